"""Families of step responses that are scored by every number: of the curve, and of the samples themselves.

An answer is a sum of decaying modes, or one that is limited in its rate and runs beyond its reference, and
its rows are few or many, coarse, spiked, or at other times than they should be.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import converted
from benchtool.analysis import Measurement, analyze_step
from benchtool.block import Block

Floats = NDArray[np.float64]

_RATE_HZ = 10_000.0
_FINE = 50  # instants per row at which the truth is looked for
_RECORDS = 100  # over which an extreme is averaged
_ARRIVED, _LOW, _HIGH = 0.02, 0.1, 0.9
_ROUNDING = 1e-7  # of the step
_VARIED = 0.94, 1.06  # of all times, from record to record


@dataclass(frozen=True)
class Mode:
    """exp(-t / `decay`) cos(2 pi t / `period`), its part of the way `share`; times in rows."""

    share: float
    decay: float
    period: float = math.inf


@dataclass(frozen=True)
class Answer:
    """What answers a step of 1: 1 - the sum of `modes`, after `delay` rows, or, where it is limited to
    1 / `ramp` a row, a line up to 1 + `beyond` that decays by the first of them.

    `noise` and the amplitude of a `ripple`, with its period in rows, are relative to the step; `spikes` are a
    share of the rows and their height. Rows are late or early by up to `jitter`, each sample is held for
    `held` of them, `held_since` rows before the first, and a `walk` is added, each of whose steps has that
    standard deviation. Of the rows a share is `stale`, and repeats the one before.
    """

    modes: tuple[Mode, ...]
    delay: float = 3.3
    ramp: float = 0.0
    beyond: float = 0.0
    rows: tuple[int, int] = (200, 1200)  # before the step, and from it on
    noise: float = 0.0
    heavy: bool = False
    of_reference: float = 0.0
    bits: int = 0
    spikes: tuple[float, float] = (0.0, 0.0)
    ripple: tuple[float, float] = (0.0, 1.0)
    jitter: float = 0.0
    held: int = 1
    held_since: int = 0
    walk: float = 0.0
    stale: float = 0.0

    def anywhere(self, random: np.random.Generator) -> Answer:
        """Return one whose dead time ends anywhere within a row, and whose holds begin in any row: neither is
        that of the recorder, and within these no record tells it."""
        return replace(
            self,
            delay=self.delay + random.uniform(-0.5, 0.5),
            held_since=int(random.integers(self.held)),
        )

    def course(self, since: Floats) -> Floats:
        """Return the answer without noise at times since the step, in rows."""
        late = np.maximum(since - self.delay, 0.0)
        if self.ramp:
            top = self.ramp * (1.0 + self.beyond)
            falls = 1.0 + self.beyond * np.exp(-np.maximum(late - top, 0.0) / self.modes[0].decay)
            return np.asarray(np.where(late < top, late / self.ramp, falls))
        parts = (
            each.share * np.exp(-late / each.decay) * np.cos(2.0 * math.pi * late / each.period)
            for each in self.modes
        )
        return np.asarray(1.0 - sum(parts))

    def disturbed(self, random: np.random.Generator, since: Floats) -> Floats:
        """Return the answer as it is measured, but for the steps of a converter."""
        count = len(since)
        noise = random.standard_t(3, count) / math.sqrt(3.0) if self.heavy else random.standard_normal(count)
        y = self.course(since + random.uniform(-self.jitter, self.jitter, count)) + self.noise * noise
        size, period = self.ripple
        y += size * np.cos(2.0 * math.pi * since / period + random.uniform(0.0, 2.0 * math.pi))
        share, height = self.spikes
        hit = random.random(count) < share
        y[hit] += height * random.choice([-1.0, 1.0], int(np.sum(hit)))
        y += np.cumsum(self.walk * random.standard_normal(count))
        held = (np.arange(count) + self.held_since) // self.held * self.held - self.held_since
        new = np.where(random.random(count) < self.stale, 0, held) if self.stale else held
        return np.asarray(y[np.maximum.accumulate(np.maximum(new, 0))])


def _trial(what: Answer, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one step response, with the row of the step known."""
    what = what.anywhere(random)
    before, after = what.rows
    slower = random.uniform(*_VARIED)
    row = np.arange(-before, after, dtype=np.float64)
    since = row / slower
    y = what.disturbed(random, since)
    if what.bits:
        y = converted(y, 2.0 / 2**what.bits, random)
    reference = np.where(row >= 0.0, 1.0, 0.0) + what.of_reference * random.standard_normal(len(row))
    block = Block.from_arrays(_RATE_HZ, {"y": "Nm", "r": "Nm"}, y=y, r=reference)
    found = analyze_step(block, "y", "r", held=True).measurements
    yield from selected(found, _truths(what, random, since, slower, _band(found)))


def _band(found: tuple[Measurement, ...]) -> float:
    (text,) = (each.definition for each in found if each.name == "settling_time")
    within = re.search(r"within ([-+.\de]+) ", text)
    assert within is not None
    stated = float(within[1])
    return _ARRIVED if math.isclose(stated, _ARRIVED, rel_tol=1e-2) else stated


def _truths(
    what: Answer, random: np.random.Generator, since: Floats, slower: float, band: float
) -> Mapping[str, float]:
    after = int(np.count_nonzero(since >= 0.0))
    fine = np.arange(0.0, after - 1, 1.0 / _FINE) / slower
    kinks = np.array([0.0, what.ramp * (1.0 + what.beyond)]) + what.delay
    fine = np.unique(np.concatenate([fine, kinks]))
    y, row_s = what.course(fine), slower / _RATE_HZ
    outside = np.flatnonzero(np.abs(y - 1.0) > band)
    top = int(np.argmax(y))
    peak, over = _peak(what, fine[max(0, top - 1) : top + 2], fine[top])
    times = {
        "step_latency": _passed(fine, y, _ARRIVED),
        "rise_time": _passed(fine, y, _HIGH) - _passed(fine, y, _LOW),
        "reach_time": _passed(fine, y, 1.0 - _ARRIVED),
        "settling_time": math.nan,
    }
    if (last := int(outside[-1])) < len(fine) - 1:
        pair = slice(last, last + 2)
        times["settling_time"] = float(np.interp(-band, -np.abs(y[pair] - 1.0), fine[pair]))
    if over > _ROUNDING:
        times["peak_time"] = peak
    truths = {name: row_s * time for name, time in times.items()}
    truths["overshoot"] = max(0.0, over)
    truths["undershoot"] = max(0.0, 1.0 - float(np.min(y[top:])))
    held, settled = (since >= times[name] for name in ("reach_time", "settling_time"))
    smooth = what.course(since)
    truths["plateau_mean"] = float(np.mean(smooth[held]))
    truths["tracking_error_mean"] = float(np.mean(smooth[settled])) - 1.0
    records = [what.disturbed(random, since) for _ in range(_RECORDS)]
    for name, of in _OF_SAMPLES.items():
        rows = held if name.startswith("plateau") else settled
        truths[name] = float(np.mean([of(each[rows]) for each in records]))
    return {name: truth for name, truth in truths.items() if not math.isnan(truth)}


def _peak(what: Answer, near: Floats, top: float) -> tuple[float, float]:
    """Return when the answer is the greatest, near these instants, and how far beyond 1 it is then."""

    def beyond(at: float) -> float:
        return float(what.course(np.array([at]))[0]) - 1.0

    found = optimize.minimize_scalar(
        lambda at: -beyond(at), bounds=(near[0], near[-1]), method="bounded", options={"xatol": 1e-7}
    )
    place = float(max((top, float(found.x)), key=beyond))
    return place, beyond(place)


_OF_SAMPLES: Mapping[str, Callable[[Floats], float]] = {
    "plateau_min": lambda y: float(np.min(y)),
    "plateau_max": lambda y: float(np.max(y)),
    "tracking_error_rms": lambda y: math.sqrt(float(np.mean((y - 1.0) ** 2))),
    "tracking_error_max": lambda y: float(np.max(np.abs(y - 1.0))),
}


def _passed(time: Floats, y: Floats, level: float) -> float:
    above = np.flatnonzero(y >= level)
    if not len(above):
        return math.nan
    pair = slice(above[0] - 1, above[0] + 1)
    return float(np.interp(level, y[pair], time[pair]))


_LAG, _RINGING = (Mode(1.0, 19.0),), (Mode(1.0, 38.0, 77.0),)
ANSWERS: Mapping[str, Answer] = {
    "answer_bits_7": Answer(_RINGING, bits=7),
    "answer_fast_bits_6": Answer((Mode(1.0, 2.6, 11.0),), bits=6, rows=(150, 150)),
    "answer_fast_bits_7_noise": Answer((Mode(1.0, 2.4),), bits=7, noise=1e-3, rows=(60, 120)),
    "answer_fast_bits_12": Answer((Mode(1.0, 2.1),), bits=12, rows=(300, 95)),
    "answer_lag_bits_8_noise": Answer(_LAG, bits=8, noise=2e-3),
    "answer_bits_7_flicker": Answer(_RINGING, bits=7, noise=2.5e-3),
    "answer_lag_bits_6_flicker": Answer(_LAG, bits=6, noise=3e-3),
    "answer_lag_noise": Answer(_LAG, noise=1e-2),
    "answer_few_rows": Answer((Mode(1.0, 4.1, 6.7),), rows=(40, 300), noise=1e-3, delay=1.4),
    "answer_limited": Answer((Mode(1.0, 45.0),), ramp=70.0, beyond=0.15),
    "answer_limited_noise": Answer((Mode(1.0, 45.0),), ramp=70.0, beyond=0.15, noise=8e-3),
    "answer_two_modes": Answer((Mode(0.8, 28.0), Mode(0.2, 120.0, 37.0)), noise=1e-2, rows=(200, 2000)),
    "answer_reference_noise": Answer(_LAG, noise=5e-3, of_reference=1e-2),
    "answer_short": Answer((Mode(1.0, 5.0, 11.0),), rows=(6, 40), noise=5e-3),
    "answer_spikes_often": Answer(_RINGING, noise=4e-3, spikes=(0.05, 0.25)),
    "answer_spikes_small": Answer(_LAG, noise=8e-3, spikes=(0.01, 0.05)),
    "answer_heavy": Answer(_LAG, noise=8e-3, heavy=True, rows=(200, 2000)),
    "answer_dip": Answer((Mode(1.0, 17.0, 62.0),), delay=70.0, noise=2e-2),
    "answer_ripple": Answer(_LAG, noise=1e-3, ripple=(0.012, 73.3)),
    "answer_jitter": Answer(_RINGING, jitter=0.35),
    "answer_jitter_noise": Answer((Mode(1.0, 9.0),), jitter=0.45, noise=1e-3),
    "answer_held": Answer(_RINGING, held=3),
    "answer_held_noise": Answer((Mode(1.0, 26.0),), held=5, noise=6e-3, rows=(250, 1500)),
    "answer_walk": Answer(_LAG, noise=2e-3, walk=4e-4, rows=(400, 1800)),
    "answer_late_mode": Answer((Mode(0.92, 70.0), Mode(0.08, 150.0, 43.0)), noise=4e-3, rows=(250, 1300)),
    "answer_hum": Answer((Mode(1.0, 31.0, 190.0),), noise=3e-3, ripple=(0.01, 103.0), rows=(250, 1300)),
    "answer_slow_tail": Answer((Mode(0.94, 33.0), Mode(0.06, 480.0)), noise=3e-3, rows=(250, 3800)),
    "answer_heavy_ringing": Answer(_RINGING, noise=6e-3, heavy=True, rows=(300, 1500)),
    "answer_spikes_rare": Answer((Mode(1.0, 11.0),), noise=5e-3, spikes=(0.006, 0.04), rows=(300, 1800)),
    "answer_ringing_reference_noise": Answer(_RINGING, noise=4e-3, of_reference=8e-3, rows=(150, 1000)),
    "answer_jitter_lag": Answer((Mode(1.0, 31.0),), jitter=0.3),
    "answer_held_late": Answer((Mode(1.0, 24.0, 90.0),), held=4, delay=5.1),
    "answer_stale": Answer(_RINGING, stale=0.03),
    "answer_stale_noise": Answer(_RINGING, stale=0.05, noise=2e-3),
    "answer_stale_lag": Answer(_LAG, stale=0.05),
    "answer_stale_bits_10": Answer(_RINGING, stale=0.04, bits=10),
    "answer_limited_few_rows": Answer((Mode(1.0, 13.0),), ramp=11.0, beyond=0.3, rows=(60, 400)),
    "answer_hum_few_rows": Answer(
        (Mode(1.0, 15.0, 42.0),), noise=1e-3, ripple=(0.017, 45.3), rows=(25, 128), delay=1.4
    ),
    "answer_low_crest": Answer((Mode(1.0, 8.0, 62.0),), noise=2e-2, rows=(250, 1600)),
}


FAMILIES = families_of(_trial, ANSWERS)
