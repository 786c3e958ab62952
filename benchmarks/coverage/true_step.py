"""True numbers of a step response that is known, by their definitions.

Times and excursions are those of the answer without noise. Numbers of the samples after it has arrived are
those of records like this one: extremes and the rms on average over many, in which noise is drawn again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from benchmarks.coverage.families import NEVER
from benchtool.analysis import Measurement

Floats = NDArray[np.float64]

_FINE = 50  # instants per row at which the truth is looked for
_RECORDS = 100  # over which an extreme is averaged
_OF_SAMPLES = (
    "plateau_mean", "plateau_min", "plateau_max",
    "tracking_error_mean", "tracking_error_rms", "tracking_error_max",
)  # fmt: skip
_ARRIVED, _LOW, _HIGH = 0.02, 0.1, 0.9
_ROUNDING = 1e-7  # of the step
_NEARLY = 1e-2  # how far the band is off that share of a step whose height is not known exactly


@dataclass(frozen=True)
class KnownStep:
    """A step of `height`, at time zero or, of a ramp, about `zero_s`, and what answers it.

    `answer` is that to a step of 1 at times in s, with `kinks_s` where it is not smooth. The rows are at
    `time_s`, shape (n,), where the `reference` is known and `disturbed` returns an answer as another record
    would hold it, both relative to the height; `drift` is what it drifts by in a second.
    """

    answer: Callable[[Floats], Floats]
    time_s: Floats
    reference: Floats
    disturbed: Callable[[], Floats]
    height: float = 1.0
    zero_s: float = 0.0
    kinks_s: tuple[float, ...] = ()
    drift: float = 0.0

    @property
    def _after(self) -> Floats:
        """Times from the step on, at which its truth is looked for."""
        rows = int(np.count_nonzero(self.time_s >= 0.0)) - 1
        last_s = float(self.time_s[-1])
        fine_s = np.linspace(0.0, last_s, _FINE * rows + 1)
        return np.unique(np.concatenate([fine_s, [each for each in self.kinks_s if 0.0 < each < last_s]]))

    def true_numbers(self, found: Iterable[Measurement]) -> Mapping[str, float]:
        """Return the truths of the numbers that were `found`, which state the band of settling."""
        band = self._band(found)
        after_s = self._after
        y = np.asarray(self.answer(after_s))
        final = float(self.reference[-1])
        times = {
            "peak_time": NEVER,
            "step_latency": _passed(after_s, self.answer, _ARRIVED),
            "reach_time": _passed(after_s, self.answer, 1.0 - _ARRIVED),
            "settling_time": _settled(after_s, lambda at_s: self.answer(at_s) - final, band),
        }
        top = int(np.argmax(y))
        peak_s, greatest = self._greatest(after_s, top)
        over = greatest - 1.0
        if over > _ROUNDING:
            times["peak_time"] = peak_s
        truths = {name: time_s - self.zero_s for name, time_s in times.items()}
        low_s, high_s = (_passed(after_s, self.answer, each) for each in (_LOW, _HIGH))
        truths["rise_time"] = high_s - low_s
        truths["overshoot"] = abs(self.height) * max(0.0, over)
        truths["overshoot_percent"] = 100.0 * max(0.0, over)
        lowest = top + int(np.argmin(y[top:]))
        least = float(y[lowest])
        if final - least > _ROUNDING:
            _, least = self._greatest(after_s, lowest, sign=-1.0)
        truths["undershoot"] = abs(self.height) * max(0.0, final - least)
        return {**truths, **self._of_samples(after_s, band)}

    def _of_samples(self, after_s: Floats, band: float) -> Mapping[str, float]:
        """Return the truths of the samples once the answer, with what it drifts by, has arrived."""
        final, greatest = float(self.reference[-1]), 1.0 - _ARRIVED

        def moved(at_s: Floats) -> Floats:
            return np.asarray(self.answer(at_s)) + self.drift * at_s

        reached_s = _passed(after_s, moved, greatest)
        settled_s = _settled(after_s, lambda at_s: moved(at_s) - final, band)
        held = np.maximum.accumulate(self.reference) >= greatest
        falls = held & (self.reference < greatest)
        end = int(np.argmax(falls)) if np.any(falls) else len(falls)
        held &= (self.time_s >= reached_s) & (np.arange(len(falls)) < end)
        settled = self.time_s >= settled_s
        smooth = np.asarray(self.answer(self.time_s)) + self.drift * self.time_s
        truths = dict.fromkeys(_OF_SAMPLES, NEVER)
        if np.any(held):
            truths["plateau_mean"] = self.height * float(np.mean(smooth[held]))
        if np.any(settled):
            error = smooth[settled] - self.reference[settled]
            truths["tracking_error_mean"] = self.height * float(np.mean(error))
        records = [self.height * self.disturbed() for _ in range(_RECORDS)]
        for name, rows, level, of in (
            ("plateau_min", held, 0.0, np.min),
            ("plateau_max", held, 0.0, np.max),
            ("tracking_error_rms", settled, self.height * self.reference, _rms),
            ("tracking_error_max", settled, self.height * self.reference, _greatest_magnitude),
        ):
            if np.any(rows):
                truths[name] = float(np.mean([of((each - level)[rows]) for each in records]))
        return truths

    def _band(self, found: Iterable[Measurement]) -> float:
        """Return half the width of the band that is stated, relative to the step."""
        stated = next(each.basis.band for each in found if each.name == "settling_time")
        assert stated is not None
        band = stated / abs(self.height)
        return _ARRIVED if math.isclose(band, _ARRIVED, rel_tol=_NEARLY) else band

    def _greatest(self, after_s: Floats, top: int, sign: float = 1.0) -> tuple[float, float]:
        """Return when the answer is the greatest, or the least with a `sign` of -1, near that of these
        instants, and what it is then."""

        def below(at_s: float) -> float:
            return -sign * float(self.answer(np.array([at_s]))[0])

        near_s = after_s[max(0, top - 1) : top + 2]
        found = optimize.minimize_scalar(
            below,
            bounds=(near_s[0], near_s[-1]),
            method="bounded",
            options={"xatol": 1e-6 * (near_s[-1] - near_s[0])},
        )
        place_s = min(float(after_s[top]), float(found.x), key=below)
        return place_s, -sign * below(place_s)


def _passed(time_s: Floats, of: Callable[[Floats], Floats], level: float) -> float:
    """Return when what is a function of these times first reaches a level."""
    above = np.flatnonzero(np.asarray(of(time_s)) >= level)
    return NEVER if not len(above) else _root(time_s, int(above[0]), lambda at_s: of(at_s) - level)


def _settled(time_s: Floats, away: Callable[[Floats], Floats], band: float) -> float:
    """Return when what is `away` from its last level, by times, stays within a band."""
    outside = np.flatnonzero(np.abs(away(time_s)) > band)
    if not len(outside) or outside[-1] == len(time_s) - 1:
        return NEVER
    return _root(time_s, int(outside[-1]) + 1, lambda at_s: band - np.abs(away(at_s)))


def _root(time_s: Floats, at: int, above: Callable[[Floats], Floats]) -> float:
    """Return when what is a function of time rises to zero, as it has at one of these times and had not at
    that before."""
    if not at:
        return float(time_s[0])
    before_s, after_s = (float(each) for each in time_s[at - 1 : at + 1])
    of = partial(_at, above)
    if of(before_s) >= 0.0:  # by rounding
        return before_s
    tolerance = 1e-6 * (after_s - before_s)
    return float(optimize.brentq(of, before_s, after_s, xtol=tolerance)) if of(after_s) >= 0.0 else after_s


def _at(of: Callable[[Floats], Floats], time_s: float) -> float:
    return float(np.asarray(of(np.array([time_s])))[0])


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))


def _greatest_magnitude(values: Floats) -> float:
    return float(np.max(np.abs(values)))
