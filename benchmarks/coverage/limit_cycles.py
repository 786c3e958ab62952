"""Families of a torque that a drive keeps within a band by switching, below a control of its mean.

In each row the voltage lets the torque rise or fall, by what the back-EMF leaves, and the direction changes
one row after the torque has left its band. So the ripple is bounded, its power is high up, and as an integral
holds the mean, hardly any is at zero frequency. Where the currents are converted, the torque by them stands
in heaps: the levels of two coordinates, turned with the rotor, of one converter.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import of_ripple
from benchmarks.coverage.steady_records import POLE_PAIRS, RATE_HZ, TORQUE_NM
from benchtool.analysis import ripple_numbers, track_angle
from benchtool.block import Block, Channel

Floats = NDArray[np.float64]

_NOISE = 0.1  # of the band, in what the control sees
_TORQUE_CONSTANT = 1.0  # Nm/A of the current across the rotor's flux
_FREQUENCY_HZ = 24.7
_SETTLED = 400  # rows before the record


@dataclass(frozen=True)
class _LimitCycle:
    """`periods`; half the width of the band, by how much of that the torque moves in a row, by how
    much of the error the band's middle moves in a row, and the converter's step."""

    periods: float
    band_Nm: float = 0.02
    slope: float = 0.7
    integral: float = 0.02
    step_A: float = 0.0


def _record(what: _LimitCycle, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return torque, Nm, and rotor angle, rad mechanical, shape (n,)."""
    rows_of_period = RATE_HZ / _FREQUENCY_HZ
    count = round(what.periods * rows_of_period)
    theta_e = 2.0 * np.pi * (np.arange(count + _SETTLED) / rows_of_period + random.random())
    back_emf = 0.3 * np.cos(6.0 * theta_e)
    steps = what.slope * what.band_Nm * (1.0 + 0.1 * random.standard_normal(count + _SETTLED))
    up, down = (steps * (1.0 + sign * (0.2 + back_emf)) for sign in (-1.0, 1.0))
    noise = _NOISE * what.band_Nm * random.standard_normal(count + _SETTLED)
    torque_Nm = np.empty(count + _SETTLED)
    now, middle, rises = TORQUE_NM, TORQUE_NM, True
    for row in range(count + _SETTLED):
        torque_Nm[row] = now
        now += up[row] if rises else -down[row]
        seen = torque_Nm[row] + noise[row]
        middle -= what.integral * (torque_Nm[row] - TORQUE_NM)
        if abs(seen - middle) > what.band_Nm:
            rises = seen < middle
    if what.step_A:
        current_A, turned = torque_Nm / _TORQUE_CONSTANT, np.exp(1j * theta_e)
        both = 1j * current_A * turned
        read = what.step_A * (np.round(both.real / what.step_A) + 1j * np.round(both.imag / what.step_A))
        torque_Nm = _TORQUE_CONSTANT * np.imag(read * np.conj(turned))
    return torque_Nm[_SETTLED:], theta_e[_SETTLED:] / POLE_PAIRS


def limit_cycle_trial(what: _LimitCycle, random: np.random.Generator) -> Iterator[Compared]:
    """Yield mean and ripple of one record."""
    torque_Nm, theta_m = _record(what, random)
    block = Block((Channel("torque", "Nm"),), 0, 1, 1.0 / RATE_HZ, torque_Nm[:, np.newaxis])
    track = track_angle(theta_m, POLE_PAIRS)
    # the integral holds it, and a converter moves it by its levels
    mean_Nm = OF_THE_ENSEMBLE if what.step_A else TORQUE_NM
    truths = of_ripple(mean_Nm, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE)
    yield from selected(ripple_numbers(block, "torque", "torque", track=track, pole_pairs=POLE_PAIRS), truths)


FAMILIES = families_of(
    limit_cycle_trial,
    {
        "limit_cycle_four_periods": _LimitCycle(4.05),
        "limit_cycle_seven_periods": _LimitCycle(7.3, integral=0.1),
        "limit_cycle": _LimitCycle(20.4),
        "limit_cycle_slow_control": _LimitCycle(40.0, slope=0.5, integral=0.002),
        "limit_cycle_bits_seven_periods": _LimitCycle(7.3, band_Nm=0.01, step_A=0.07),
        "limit_cycle_bits": _LimitCycle(20.4, band_Nm=0.01, step_A=0.07),
        "limit_cycle_fine_bits": _LimitCycle(20.4, step_A=0.012),
    },
)
