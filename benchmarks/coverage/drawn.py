"""Families drawn at random: chance decides what meets in them, how much of it, and in how long a record.

Truths are as in the families that are written down. So nothing is drawn that has none, or whose truth a
record cannot tell: swings of an amplitude of which a record shows less than four, lines nearer to a harmonic
than the record resolves, spikes, or steps of an input of two levels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchmarks.coverage.dynamic import Excited, Lag, Stepped, excited_trial, stepped_trial
from benchmarks.coverage.families import Family, families_of
from benchmarks.coverage.noise import UNCORRELATED, Kind
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

Random = np.random.Generator
Draw = Callable[[Random, Disturbance], Disturbance]

_MOST_S = 5.0  # of a record
_KINDS: Final[tuple[Kind, ...]] = (
    "pink", "heavy", "bursts", "resonant", "popcorn", "bounded", "pink_and_white", "skewed", "mixed_tails",
    "two_levels",
)  # fmt: skip
_OTHER_THAN_WHITE, _COLOURED, _WITH_ANGLE = 0.3, 0.25, 0.65
_MOST_TOGETHER, _HELD, _FIRST_ORDER = 3, 0.4, 0.4
_EXCITATIONS: Final = ("chirp", "prbs", "multisine", "noise")
_COUNTS = (64, 256, 720, 1000, 1024, 2048, 2500, 4096, 8192, 16384)


def _between(random: Random, low: float, high: float) -> float:
    """Return a number whose logarithm is as likely anywhere between two."""
    return float(np.exp(random.uniform(math.log(low), math.log(high))))


def _signed(random: Random, low: float, high: float) -> float:
    return float(random.choice([-1.0, 1.0])) * _between(random, low, high)


def _shown_Hz(random: Random, what: Disturbance) -> float:
    """Return a frequency of which the record shows four cycles, and a period two."""
    return _between(random, 4.0 * what.frequency_Hz / what.periods, 0.5 * what.frequency_Hz)


def _lines(random: Random, what: Disturbance) -> Disturbance:
    apart = min(0.5, 1.5 / what.periods)
    orders = random.choice(12, size=random.integers(1, 3), replace=False)
    places = orders + random.uniform(apart, 1.0 - apart, len(orders))
    return replace(what, lines=tuple((float(each), _between(random, 1e-3, 0.03)) for each in places))


def _harmonics(random: Random, what: Disturbance) -> Disturbance:
    orders = random.choice([2, 3, 4, 5, 7, 9], size=random.integers(1, 4), replace=False)
    return replace(what, harmonics={int(each): _between(random, 5e-4, 0.1) for each in orders})


def _swing(random: Random, what: Disturbance) -> Disturbance:
    lowest_Hz = 1.5 * what.frequency_Hz / what.periods
    return replace(
        what, swing=(_between(random, 5e-4, 0.02), _between(random, lowest_Hz, 0.5 * what.frequency_Hz))
    )


def _amplitude_swing(random: Random, what: Disturbance) -> Disturbance:
    if what.periods < 12.0:
        return what
    return replace(what, amplitude_swing=(_between(random, 1e-3, 0.05), _shown_Hz(random, what)))


_ANY: Final[Mapping[str, Draw]] = {
    "plain": lambda random, what: what,
    "drift": lambda random, what: replace(what, drift=_signed(random, 1e-3, 0.1)),
    "swing": _swing,
    "settling": lambda random, what: replace(
        what, settling=(_signed(random, 2e-3, 0.05), _between(random, 0.1, 0.8))
    ),
    "speed_walk": lambda random, what: replace(what, speed_walk=_between(random, 5e-4, 0.02)),
    "reversal": lambda random, what: replace(what, reverses=True, periods=max(12.0, what.periods)),
    "standstill": lambda random, what: replace(
        what, stands_still=random.uniform(0.02, 0.3), periods=max(12.0, what.periods)
    ),
    "lines": _lines,
    "harmonics": _harmonics,
    "offset": lambda random, what: replace(what, offset=_between(random, 0.01, 0.4)),
    "decay": lambda random, what: replace(
        what, decay=(_between(random, 0.05, 1.0), _between(random, 0.03, 0.7))
    ),
    "amplitude_swing": _amplitude_swing,
    "amplitude_ramp": lambda random, what: replace(what, amplitude_ramp=_signed(random, 2e-3, 0.08)),
    "amplitude_noise": lambda random, what: replace(
        what, amplitude_noise=(_between(random, 1e-3, 0.03), float(random.choice([0.0, 0.3, 0.6, 0.9])))
    ),
    "ripple_noise": lambda random, what: replace(
        what, ripple_noise=(_between(random, 0.03, 0.4), float(random.choice([0.0, 0.4, 0.8])))
    ),
    "two_regimes": lambda random, what: replace(
        what, second_regime=math.exp(_signed(random, math.log(1.05), math.log(2.5)))
    ),
    "clipping": lambda random, what: replace(what, clip=random.uniform(0.7, 0.995)),
    "jitter": lambda random, what: replace(what, time_jitter=_between(random, 0.01, 0.2)),
    "bits": lambda random, what: replace(what, bits=int(random.integers(6, 17))),
    "once_per_turn": lambda random, what: replace(
        what, turns_Nm=(_between(random, 0.01, 0.15), _between(random, 0.01, 0.1))
    ),
}
_OF_ANGLE: Final[Mapping[str, Draw]] = {
    "counts": lambda random, what: replace(what, counts=int(random.choice(_COUNTS))),
    "wobble": lambda random, what: replace(
        what, wobble_rad=(_between(random, 5e-4, 1e-2), int(random.integers(1, 4)))
    ),
    "slip": lambda random, what: replace(what, slip=_signed(random, 1e-4, 4e-3)),
    "angle_noise": lambda random, what: replace(what, angle_noise_rad=_between(random, 3e-4, 5e-3)),
}


def drawn_steady(random: Random) -> Disturbance:
    """Return a steady record with one to three disturbances, and noise."""
    frequency_Hz = _between(random, 8.0, 200.0)
    periods = max(3.1, min(_between(random, 3.2, 120.0), frequency_Hz * _MOST_S))
    noise = _noise(random, 1e-4, 0.02)
    what = Disturbance(
        periods=periods,
        frequency_Hz=frequency_Hz,
        angle=bool(random.random() < _WITH_ANGLE),
        noise=noise.rms,
        kind=noise.kind,
        colour=noise.colour,
    )
    draws = {**_ANY, **_OF_ANGLE} if what.angle else _ANY
    for name in random.choice(list(draws), size=random.integers(1, _MOST_TOGETHER + 1), replace=False):
        what = draws[str(name)](random, what)
    return what


def drawn_step(random: Random) -> Stepped:
    """Return a step response with noise, on a lag of the first or second order."""
    lag = _lag(random, 15.0, 800.0)
    duration_s = float(np.clip(_between(random, 12.0 / lag.corner_Hz, 60.0 / lag.corner_Hz), 0.05, 1.0))
    noise, is_held = _noise(random, 1e-4, 0.02), bool(random.random() < _HELD)
    what = Stepped(lag, noise.rms, noise.colour, kind=noise.kind, duration_s=duration_s, held=is_held)
    match random.choice(["plain", "rise", "pulse", "delay", "drift", "ripple", "bits", "height"]):
        case "rise":
            return replace(what, rise_s=_between(random, 0.2, 5.0) / lag.corner_Hz)
        case "pulse":
            return replace(what, pulse_s=duration_s * random.uniform(0.5, 0.8))
        case "delay":
            return replace(what, delay_s=_between(random, 2e-4, 5e-3))
        case "drift":
            return replace(what, drift=_signed(random, 0.01, 0.3))
        case "ripple":
            return replace(what, ripple=(_between(random, 1e-3, 0.02), _between(random, 50.0, 1500.0)))
        case "bits":
            return replace(what, bits=int(random.integers(7, 14)))
        case "height":
            return replace(what, height=_signed(random, 0.1, 200.0))
        case _:
            return what


def drawn_response(random: Random) -> Excited:
    """Return a frequency response with white or coloured noise, on a lag of the first or second order."""
    noise, excitation = _noise(random, 1e-4, 0.05, is_white=True), random.choice(_EXCITATIONS)
    duration_s = _between(random, 0.6, 4.0)
    what = Excited(_lag(random, 20.0, 600.0), excitation, noise.rms, noise.colour, duration_s=duration_s)
    match random.choice(["plain", "delay", "drift", "bits", "input_bits"]):
        case "delay":
            return replace(what, delay_s=_between(random, 2e-4, 4e-3))
        case "drift":
            return replace(what, drift=_between(random, 0.01, 0.5))
        case "bits":
            return replace(what, bits=int(random.integers(8, 14)))
        case "input_bits" if excitation != "prbs":
            return replace(what, input_bits=int(random.integers(8, 14)))
        case _:
            return what


def _lag(random: Random, low_Hz: float, high_Hz: float) -> Lag:
    corner_Hz = _between(random, low_Hz, high_Hz)
    return Lag(corner_Hz) if random.random() < _FIRST_ORDER else Lag(corner_Hz, random.uniform(0.15, 0.9))


@dataclass(frozen=True)
class _Noise:
    rms: float
    kind: Kind
    colour: float


def _noise(random: Random, low: float, high: float, *, is_white: bool = False) -> _Noise:
    """Return a noise: correlated kinds are not coloured besides, whose rms that would change."""
    kind: Kind = "white"
    if not is_white and random.random() < _OTHER_THAN_WHITE:
        kind = _KINDS[int(random.integers(len(_KINDS)))]
    is_coloured = kind in UNCORRELATED and random.random() < _COLOURED
    colour = 1.0 - _between(random, 0.005, 0.5) if is_coloured else 0.0
    return _Noise(_between(random, low, high), kind, colour)


def drawn_family(number: int, seed: int) -> Family:
    """Return the family of a number: of six, three are steady records, two steps and one a response."""
    name, random = f"drawn_{number}", np.random.default_rng([seed, number])
    match number % 6:
        case 0 | 2 | 4:
            (family,) = families_of(trial, {name: drawn_steady(random)})
        case 1 | 3:
            (family,) = families_of(stepped_trial, {name: drawn_step(random)})
        case _:
            (family,) = families_of(excited_trial, {name: drawn_response(random)})
    return family
