"""Families of loads that swing within few electrical periods: those of a compressor, once in a revolution,
and of cogging, several times in each period, with the speed, the torque and the current that go with them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchtool.analysis import current_spectrum, ripple_numbers, track_angle
from benchtool.analysis.periods import track_tone
from benchtool.block import Block

Floats = NDArray[np.float64]

_RATE_HZ, _COUNT = 10_000.0, 20_000
_A, _NM = 5.0, 2.0
_HARMONICS = {5: 0.04, 7: 0.02}  # of the fundamental
_FAST, _HIGHEST = 0.5, 50  # cycles in a period; harmonics
_PLACES = 20_000  # in a revolution, at which its mean over time is summed up


@dataclass(frozen=True)
class _Swinging:
    """By how much speed, amplitude and torque swing `times` in a revolution, relative to their means, and by
    how much the angle between rotor and current does, rad electrical; `counts` of the encoder in a
    revolution, or no angle."""

    speed: float = 0.05
    amplitude: float = 0.3
    torque: float = 0.4
    load_angle_rad: float = 0.08
    times: int = 1
    pole_pairs: int = 3
    speed_rad_s: tuple[float, float] = (95.0, 190.0)
    counts: int | None = 4096


def _trial(what: _Swinging, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one record."""
    time_s, times = np.arange(_COUNT) / _RATE_HZ, what.times
    steady = random.uniform(*what.speed_rad_s) * time_s + random.uniform(0.0, 2.0 * np.pi)
    late = random.uniform(0.0, 2.0 * np.pi, 6)
    theta = _turned(what, steady, late)
    theta_e, current = _current(what, theta, late)
    i_a = _A * current + 0.01 * random.standard_normal(_COUNT)
    torque = _NM * (1.0 + what.torque * np.cos(times * theta + late[5]))
    torque += 0.01 * random.standard_normal(_COUNT)
    block = Block.from_arrays(_RATE_HZ, {"i_a": "A", "torque": "Nm"}, i_a=i_a, torque=torque)
    if what.counts is None:
        track = track_tone(i_a)
    else:
        step_rad = 2.0 * np.pi / what.counts
        track = track_angle(np.mod(np.floor(theta / step_rad) * step_rad, 2.0 * np.pi), what.pole_pairs)
    turned_rad = float(theta_e[-1] - theta_e[0])
    truths = {
        "fundamental_frequency": turned_rad / (2.0 * math.pi * float(time_s[-1])),
        "current_thd_f": _distortion(what, late),
        "torque_mean": _over_time(what, late),
    }
    if what.counts is None:  # whose revolutions nothing tells
        del truths["torque_mean"]
    found = current_spectrum(block, "i_a", track).measurements
    yield from selected(found, truths)
    yield from selected(
        ripple_numbers(block, "torque", "torque", track=track, pole_pairs=what.pole_pairs), truths
    )


def _turned(what: _Swinging, steady: Floats, late: Floats) -> Floats:
    """Return the rotor's angle at even times, at which an even one would be `steady`, shape (n,).

    It is at theta + s / m sin(m theta + a) then: its speed is in proportion to 1 / (1 + s cos(m theta + a)).
    """
    theta = steady.copy()
    for _ in range(60):
        theta = steady - what.speed / what.times * np.sin(what.times * theta + late[0])
    return theta


def _current(what: _Swinging, theta: Floats, late: Floats) -> tuple[Floats, Floats]:
    """Return the current's phase, and the current relative to its mean amplitude, at angles of the rotor, all
    of shape (n,)."""
    size = 1.0 + what.amplitude * np.cos(what.times * theta + late[1])
    theta_e = what.pole_pairs * theta + what.load_angle_rad * np.cos(what.times * theta + late[2])
    current = np.cos(theta_e)
    for (order, share), phase in zip(_HARMONICS.items(), late[3:], strict=False):
        current += share * np.cos(order * theta_e + phase)
    return theta_e, np.asarray(size * current)


def _distortion(what: _Swinging, late: Floats) -> float:
    """Return THD, %: of harmonics of the current's own phase, or along the rotor's angle, in time without
    one, where that swings by half a cycle in a period or more."""
    if what.times < _FAST * what.pole_pairs:
        return 100.0 * math.hypot(*_HARMONICS.values())
    place = np.linspace(0.0, 2.0 * np.pi, _PLACES, endpoint=False)
    theta = place if what.counts is not None else _turned(what, place, late)
    lines = np.abs(np.fft.rfft(_current(what, theta, late)[1]))[:: what.pole_pairs][1 : _HIGHEST + 1]
    return 100.0 * float(np.linalg.norm(lines[1:]) / lines[0])


def _over_time(what: _Swinging, late: Floats) -> float:
    """Return the mean torque over the time of a revolution."""
    place = what.times * np.linspace(0.0, 2.0 * np.pi, _PLACES, endpoint=False)
    weights = 1.0 + what.speed * np.cos(place + late[0])
    return float(np.average(_NM * (1.0 + what.torque * np.cos(place + late[5])), weights=weights))


_COMPRESSOR = _Swinging()
_COGGING = _Swinging(0.04, 0.0, 0.0, 0.0, times=24, pole_pairs=4, speed_rad_s=(5.0, 7.5), counts=16_384)
FAMILIES = families_of(
    _trial,
    {
        "compressor": _COMPRESSOR,
        "compressor_steadier_speed": replace(_COMPRESSOR, speed=0.01),
        "compressor_no_angle": replace(_COMPRESSOR, speed=0.02, load_angle_rad=0.04, counts=None),
        "compressor_two_pole_pairs": replace(_COMPRESSOR, pole_pairs=2),
        "compressor_two_pole_pairs_no_angle": replace(
            _COMPRESSOR, pole_pairs=2, speed=0.02, load_angle_rad=0.04, counts=None
        ),
        "compressor_few_revolutions_no_angle": replace(
            _COMPRESSOR, pole_pairs=2, speed=0.02, load_angle_rad=0.04, counts=None, speed_rad_s=(22.0, 32.0)
        ),
        "twice_in_three_pole_pairs_no_angle": replace(
            _COMPRESSOR, speed=0.02, load_angle_rad=0.04, counts=None, times=2
        ),
        "cogging_at_low_speed": _COGGING,
        "cogging_little_at_low_speed": replace(_COGGING, speed=0.005),
    },
)
