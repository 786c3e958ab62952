"""Families of speeds that answer a step, read by how many counts of an encoder have come in each row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.answers import Answer, Mode
from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.true_step import KnownStep
from benchtool.analysis import analyze_step
from benchtool.block import Block

Floats = NDArray[np.float64]

_RATE_HZ = 1_000.0
_FINE = 50  # instants in a row at which the speed is known
_VARIED = 0.94, 1.06  # of all times, from record to record


@dataclass(frozen=True)
class EncoderSpeed:
    """A speed that an `answer` takes from so many counts in a row, `before`, by as many as it rises.

    Edges of the encoder are at other places by `edges` counts rms, and the shaft `shakes` by so many besides,
    in the rhythm of some rows.
    """

    answer: Answer
    before: float = 6.5
    rises: float = 65.2
    counts: int = 4096
    edges: float = 0.0
    shakes: float = 0.0

    @property
    def count_rad_s(self) -> float:
        """What a count in a row is worth."""
        return 2.0 * math.pi / self.counts * _RATE_HZ


@dataclass(frozen=True)
class _Shaft:
    """How far a shaft has come, in rises of the speed for a row, by an answer whose times are `slower`."""

    of: EncoderSpeed
    slower: float

    def come(self, since: Floats) -> Floats:
        """Return it at times since the step, in rows."""
        last = max(1, math.ceil(float(np.max(since, initial=1.0))))
        fine = np.arange(_FINE * last + 1) / _FINE
        speed = self.of.answer.course(fine / self.slower)
        come = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / _FINE])
        return np.asarray(np.interp(since, fine, come))

    def mean(self, since: Floats) -> Floats:
        """Return the mean of the answer over the row before these times."""
        return self.come(since) - self.come(since - 1.0)

    def read(self, random: np.random.Generator, since: Floats) -> Floats:
        """Return what an encoder counts in each row, in rises of the speed."""
        what, ends = self.of, np.concatenate([[since[0] - 1.0], since])
        place = what.before * ends + what.rises * self.come(ends) + random.uniform()
        place += what.edges * random.standard_normal(len(ends))
        shaken = np.convolve(random.standard_normal(len(ends) + 5), np.ones(6) / 6**0.5, "valid")
        place += what.shakes * shaken
        return np.asarray((np.diff(np.floor(place)) - what.before) / what.rises)


def _trial(what: EncoderSpeed, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one step, which is made at a row and answered from anywhere within one."""
    shaft = _Shaft(what, random.uniform(*_VARIED))
    before, after = what.answer.rows
    since = np.arange(-before, after, dtype=np.float64)
    base, height = (each * what.count_rad_s for each in (what.before, what.rises))
    speed = base + height * shaft.read(random, since)
    steps = np.where(since >= 0.0, 1.0, 0.0)
    units = {"omega_m": "rad/s", "demand": "rad/s"}
    block = Block.from_arrays(_RATE_HZ, units, omega_m=speed, demand=base + height * steps)
    found = analyze_step(block, "omega_m", "demand", held=True).measurements
    known = KnownStep(
        lambda time_s: shaft.mean(time_s * _RATE_HZ),
        since / _RATE_HZ,
        steps,
        lambda: shaft.read(random, since),
        height=height,
    )
    of_samples = "plateau_", "tracking_error_"
    for each, truth in selected(found, known.true_numbers(found)):
        if not each.name.startswith(of_samples):
            yield each, truth


_RINGING = Answer((Mode(1.0, 50.0, 181.0),), rows=(200, 800))
_LAG = Answer((Mode(1.0, 33.0),), rows=(200, 600))
SPEEDS: Mapping[str, EncoderSpeed] = {
    "encoder_speed": EncoderSpeed(_RINGING),
    "encoder_speed_lag": EncoderSpeed(_LAG),
    "encoder_speed_from_rest": EncoderSpeed(_RINGING, before=0.0),
    "encoder_speed_lag_from_rest": EncoderSpeed(_LAG, before=0.0, rises=71.8),
    "encoder_speed_fine": EncoderSpeed(_RINGING, before=31.3, rises=612.7, counts=40_000),
    "encoder_speed_coarse": EncoderSpeed(_RINGING, before=3.4, rises=17.3, counts=1024),
    "encoder_speed_shakes": EncoderSpeed(_RINGING, shakes=0.15),
    "encoder_speed_edges": EncoderSpeed(_RINGING, edges=0.2),
    "encoder_speed_half_way": EncoderSpeed(_RINGING, before=7.5, rises=65.5),
    "encoder_speed_whole": EncoderSpeed(_RINGING, before=7.3, rises=60.703),
    "encoder_speed_creeps": EncoderSpeed(Answer((Mode(0.93, 22.0), Mode(0.07, 240.0)), rows=(200, 1500))),
    "encoder_speed_limited": EncoderSpeed(
        Answer((Mode(1.0, 45.0),), ramp=120.0, beyond=0.12, rows=(200, 800))
    ),
    "encoder_speed_two_masses": EncoderSpeed(
        Answer((Mode(0.95, 40.0), Mode(0.05, 90.0, 31.0)), rows=(300, 900)), before=20.3
    ),
    "encoder_speed_few_rows": EncoderSpeed(Answer((Mode(1.0, 6.0, 25.0),), rows=(120, 300))),
}

FAMILIES = families_of(_trial, SPEEDS)
