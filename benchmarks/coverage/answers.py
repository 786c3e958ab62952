"""Families of step responses that are scored by every number: of the curve, and of the samples themselves.

An answer is a sum of decaying modes, or one that is limited in its rate and runs beyond its reference, and
its rows are few or many, coarse, spiked, or at other times than they should be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import converted
from benchmarks.coverage.true_step import KnownStep
from benchtool.analysis import analyze_step
from benchtool.block import Block

Floats = NDArray[np.float64]

_RATE_HZ = 10_000.0
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

    @property
    def kinks(self) -> tuple[float, float]:
        """Times, in rows, at which the answer is not smooth."""
        return self.delay, self.delay + self.ramp * (1.0 + self.beyond)

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
    known = KnownStep(
        lambda time_s: what.course(time_s * _RATE_HZ / slower),
        row / _RATE_HZ,
        np.where(row >= 0.0, 1.0, 0.0),
        partial(what.disturbed, random, since),
        kinks_s=tuple(slower / _RATE_HZ * each for each in what.kinks),
    )
    yield from selected(found, known.true_numbers(found))


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
