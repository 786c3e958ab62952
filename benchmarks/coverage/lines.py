"""Families of lines, without an angle, that are not steady: they decay, drift, swing, wander, beat, begin."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import Kind, noise_of
from benchtool.analysis import spectral_lines
from benchtool.block import Block

RATE_HZ, LINE_NM = 2_000.0, 0.1


@dataclass(frozen=True)
class Changing:
    """A line of a torque whose amplitude or phase has a course over the record, or another one beside it.

    Times and rates are of the record: it decays with the constant `decay`, its frequency drifts by
    `drift_bins` from begin to end, its phase swings by (rad, cycles) and wanders by `walk_rad` until the end,
    and its amplitude swings by (share, cycles), steps by a share midway, and is nothing before `begins`.
    Another line, `beside`, is (bins, share) away, and a `slow` one has (share, cycles).
    """

    decay: float = math.inf
    drift_bins: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    walk_rad: float = 0.0
    breath: tuple[float, float] = (0.0, 1.0)
    step: float = 0.0
    begins: float = 0.0
    beside: tuple[float, float] = (0.0, 0.0)
    slow: tuple[float, float] = (0.0, 1.0)
    noise: float = 5e-3
    kind: Kind = "white"
    duration_s: float = 4.0


def _trial(what: Changing, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.duration_s * RATE_HZ)
    at, per_bin_Hz = np.arange(count) / count, 1.0 / what.duration_s
    middle_Hz = random.uniform(60.0, 300.0)
    begin = 2 * np.pi * random.random(4)
    phase = 2 * np.pi * (middle_Hz / per_bin_Hz * at + 0.5 * what.drift_bins * (at**2 - at)) + begin[0]
    turned = what.swing[0] * np.sin(2 * np.pi * what.swing[1] * at + begin[1])
    turned += what.walk_rad * np.cumsum(random.standard_normal(count)) / math.sqrt(count)
    size = LINE_NM * np.exp(-at / what.decay) * (1.0 + what.step * (at > 0.5)) * (at >= what.begins)
    size *= 1.0 + what.breath[0] * np.cos(2 * np.pi * what.breath[1] * at + begin[2])
    torque = 1.8 + size * np.cos(phase + turned) + what.noise * noise_of(what.kind, random, count)
    bins, share = what.beside
    torque += share * LINE_NM * np.cos(phase + 2 * np.pi * bins * at + begin[3])
    share, cycles = what.slow
    torque += share * LINE_NM * np.cos(2 * np.pi * cycles * at + begin[3])
    # a swing of few cycles turns it on or back from begin to end
    whole = phase + turned if what.swing[1] < _FEW_CYCLES else phase
    mean_Hz = float(whole[-1] - whole[0]) / (2 * np.pi) * RATE_HZ / (count - 1)
    truths = {"torque_line_frequency": mean_Hz}
    if what.walk_rad:
        truths = {"torque_line_amplitude": LINE_NM}
    elif not (what.decay < math.inf or what.begins or what.step):
        truths["torque_line_amplitude"] = LINE_NM
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    yield from selected(spectral_lines(block, "torque").measurements, truths)


_FEW_CYCLES = 2.0
_STEADY = Changing()
LINES: Mapping[str, Changing] = {
    "line_in_pink": replace(_STEADY, kind="pink", noise=0.03),
    "line_rings_down": replace(_STEADY, decay=0.12),
    "line_decays_slowly": replace(_STEADY, decay=1.4, noise=2e-3),
    "line_drifts": replace(_STEADY, drift_bins=6.3),
    "line_drifts_little": replace(_STEADY, drift_bins=0.7, noise=2e-3),
    "line_swings_slowly": replace(_STEADY, swing=(0.5, 1.3)),
    "line_swings_hidden": replace(_STEADY, swing=(0.3, 0.8), noise=0.05),
    "line_swings_once": replace(_STEADY, swing=(0.3, 1.3), noise=0.05),
    "line_swings_fast": replace(_STEADY, swing=(0.3, 17.4), noise=2e-3),
    "line_wanders": replace(_STEADY, walk_rad=3.0),
    "line_breathes_once": replace(_STEADY, breath=(0.3, 1.0)),
    "line_steps": replace(_STEADY, step=0.5),
    "line_begins_late": replace(_STEADY, begins=0.45),
    "line_beats_two_bins": replace(_STEADY, beside=(2.1, 0.6)),
    "line_above_a_slow_one": replace(_STEADY, slow=(0.6, 2.3), noise=1e-3, duration_s=0.6),
    "line_above_a_slower_one": replace(_STEADY, slow=(0.7, 1.3), duration_s=0.4),
    "line_beats_at_once": replace(_STEADY, beside=(1.1, 0.5)),
}

FAMILIES = families_of(_trial, LINES)
