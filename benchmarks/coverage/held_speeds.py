"""Families of a torque by which a speed is held: its reference follows a reading of the speed that is noisy,
or in counts, and the torque follows the reference beneath a ripple and noise of its own.

A controller with an integral, both poles at half of the crossover, leaves the mean no noise over a long time.
A record holds few cycles of that crossover, or less than one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import of_ripple
from benchmarks.coverage.noise import pink
from benchmarks.coverage.steady_records import POLE_PAIRS, RATE_HZ, TORQUE_NM
from benchtool.analysis import torque_ripple, track_angle
from benchtool.block import Block

Floats = NDArray[np.float64]

_ROWS_OF_PERIOD = 37.4
_RIPPLE = 0.01  # of the torque
_SETTLED = 6.0  # cycles of the crossover, before the record
_LATE_ROWS = 3
_INNER = 100.0  # rad in the record, above which the control of the torque leaves it noise


@dataclass(frozen=True)
class _HeldSpeed:
    """`periods`; cycles of the crossover in the record; noise of the torque by the speed's, relative to the
    torque, or by how much of it a count of the speed moves it; and the torque's own noise, relative to it."""

    periods: float
    cycles: float
    by_speed: float = 1e-3
    by_count: float = 0.0
    own: float = 1e-3


def _record(what: _HeldSpeed, random: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Return torque and its reference, Nm, and rotor angle, rad mechanical, shape (n,)."""
    count = round(what.periods * _ROWS_OF_PERIOD)
    before = round(_SETTLED * count / what.cycles)
    crossover = 2.0 * np.pi * what.cycles / count  # rad a row
    # the speed as the torque that its proportional part asks for
    read_noise = what.by_speed * TORQUE_NM * pink(random, before + count)
    step = what.by_count * TORQUE_NM
    reference_Nm = np.zeros(before + count)
    speed = integral = 0.0
    for row in range(before + count):
        torque_Nm = reference_Nm[row - _LATE_ROWS] if row >= _LATE_ROWS else 0.0
        speed += crossover * torque_Nm
        error = -speed - read_noise[row]
        if step:
            error = step * (np.floor(error / step) + 0.5)
        integral += 0.25 * crossover * error
        reference_Nm[row] = error + integral
    late = np.roll(reference_Nm, _LATE_ROWS)[before:]
    theta_e = 2.0 * np.pi * (np.arange(count) / _ROWS_OF_PERIOD + random.random())
    inner = np.exp(-_INNER / count)
    own = lfilter([1.0, -1.0], [1.0, -inner], random.standard_normal(before + count))[before:]
    ripple = _RIPPLE * np.cos(6.0 * theta_e) + what.own * own
    return TORQUE_NM * (1.0 + ripple) + late, TORQUE_NM + reference_Nm[before:], theta_e / POLE_PAIRS


def held_speed_trial(what: _HeldSpeed, random: np.random.Generator) -> Iterator[Compared]:
    """Yield mean and ripple of one record."""
    torque_Nm, reference_Nm, theta_m = _record(what, random)
    units = {"torque": "Nm", "torque_reference": "Nm"}
    block = Block.from_arrays(RATE_HZ, units, torque=torque_Nm, torque_reference=reference_Nm)
    track = track_angle(theta_m, POLE_PAIRS)
    # where the speed stands between two counts, the mean does not
    mean_Nm = OF_THE_ENSEMBLE if what.by_count else TORQUE_NM
    truths = of_ripple(mean_Nm, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE)
    yield from selected(torque_ripple(block, track=track, pole_pairs=POLE_PAIRS), truths)


FAMILIES = families_of(
    held_speed_trial,
    {
        "held_speed": _HeldSpeed(33.4, 3.0),
        "held_speed_slow": _HeldSpeed(29.3, 0.8),
        "held_speed_fast": _HeldSpeed(36.6, 12.0),
        "held_speed_hidden": _HeldSpeed(33.4, 2.0, own=3e-3),
        "held_speed_hidden_slow": _HeldSpeed(35.7, 0.8, own=3e-3),
        "held_speed_counts": _HeldSpeed(36.4, 6.0, by_speed=1e-5, by_count=5e-3),
        "held_speed_eight_periods": _HeldSpeed(8.4, 2.0),
    },
)
