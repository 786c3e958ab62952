"""Families of lines in steps of a converter about as coarse as they are, with noise that hides the steps or
not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import coloured, converted
from benchtool.analysis import Measurement, Uncertainty, spectral_lines
from benchtool.block import Block

MEAN_NM, RATE_HZ = 2.0, 2_000.0


@dataclass(frozen=True)
class CoarseLines:
    """A torque of 2 Nm in steps of `step` of it, and lines (cycles per revolution, steps), from the first
    to the second number; noise of so many steps, behind a low-pass with this `pole`. A ripple has `orders`
    (order, steps) of a revolution."""

    lines: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = (((0.3, 5.0), (3.0, 6.0)),)
    noise: tuple[float, float] = (0.0, 0.0)
    pole: float = 0.0
    orders: tuple[tuple[int, float], ...] = ()
    step: tuple[float, float] = (0.01, 0.3)
    revolutions: tuple[float, float] = (10.0, 60.0)
    speed_Hz: tuple[float, float] = (3.0, 15.0)


@dataclass(frozen=True)
class CoarseCurrent:
    """A current of 3 to 5 A in a range of 11 A of so many bits, from the first to the second number, and a
    sinusoid between its harmonics of a `share` of it; noise of so many steps."""

    bits: tuple[int, int] = (8, 12)
    share: tuple[float, float] = (0.02, 0.3)
    noise: tuple[float, float] = (0.0, 0.0)
    harmonics: tuple[int, ...] = ()


def _lines(what: CoarseLines, random: np.random.Generator) -> Iterator[Compared]:
    step = MEAN_NM * _log_uniform(random, what.step)
    speed_Hz = random.uniform(*what.speed_Hz)
    count = round(random.uniform(*what.revolutions) / speed_Hz * RATE_HZ)
    turns = speed_Hz / RATE_HZ * np.arange(count)
    made, torque = [], np.full(count, MEAN_NM)
    for cycles, steps in what.lines:
        made.append((speed_Hz * _log_uniform(random, cycles), step * random.uniform(*steps)))
    made += [(order * speed_Hz, step * steps * random.uniform(0.7, 1.3)) for order, steps in what.orders]
    for frequency_Hz, amplitude in made:
        turned = frequency_Hz / speed_Hz * turns + random.uniform()
        torque += amplitude * np.cos(2 * np.pi * turned)
    noise = step * random.uniform(*what.noise)
    torque += noise * coloured(random.standard_normal(count), what.pole)
    yield from _measured(converted(torque, step, random), RATE_HZ, made)


def _current(what: CoarseCurrent, random: np.random.Generator) -> Iterator[Compared]:
    rate_Hz, step = 10_000.0, 11.0 / 2.0 ** random.integers(what.bits[0], what.bits[1] + 1)
    f_Hz, size = random.uniform(17.0, 60.0), random.uniform(3.0, 5.0)
    time = np.arange(round(random.uniform(20.3, 80.0) / f_Hz * rate_Hz)) / rate_Hz
    between = random.integers(0, 8) + random.uniform(0.2, 0.8)
    made = [(f_Hz, size), (between * f_Hz, size * _log_uniform(random, what.share))]
    made += [(order * f_Hz, size * 0.03 * random.uniform(0.5, 1.5)) for order in what.harmonics]
    current = step * random.uniform(*what.noise) * random.standard_normal(len(time))
    for frequency_Hz, amplitude in made:
        current += amplitude * np.cos(2 * np.pi * (frequency_Hz * time + random.uniform()))
    yield from _measured(converted(current, step, random), rate_Hz, made)


def _measured(
    samples: NDArray[np.float64], rate_Hz: float, made: Sequence[tuple[float, float]]
) -> Iterator[Compared]:
    """Return the largest line, and that of each row of the table which is one that was made."""
    found = spectral_lines(Block.from_arrays(rate_Hz, {"torque": "Nm"}, torque=samples), "torque")
    largest = max(made, key=lambda each: each[1])
    truths = dict(zip(("torque_line_frequency", "torque_line_amplitude"), largest, strict=True))
    yield from selected(found.measurements, truths)
    for frequency_Hz, amplitude in made:
        name = "largest" if amplitude == largest[1] else "other"
        near = [row for row in found.tables[0].rows if abs(row[0] - frequency_Hz) < rate_Hz / len(samples)]
        for row in near[:1]:
            yield _of_row(f"{name}_frequency", row[0], row[2]), frequency_Hz
            yield _of_row(f"{name}_amplitude", row[1], row[3]), amplitude


def _of_row(name: str, value: float, standard: float) -> Measurement:
    uncertainty = Uncertainty(standard, "") if math.isfinite(standard) else None
    return Measurement(name, value, "", "", uncertainty=uncertainty)


def _log_uniform(random: np.random.Generator, between: tuple[float, float]) -> float:
    return math.exp(random.uniform(*np.log(between)))


_SILENT, _CURRENT = CoarseLines(), CoarseCurrent()
_SLOW = (0.3, 5.0)
TORQUES: Mapping[str, CoarseLines] = {
    "coarse_lines_silent": _SILENT,
    "coarse_lines_noise_of_0.05": replace(_SILENT, noise=(0.05, 0.05)),
    "coarse_lines_noise_of_0.1": replace(_SILENT, noise=(0.1, 0.1)),
    "coarse_lines_noise_of_0.3": replace(_SILENT, noise=(0.3, 0.3)),
    "coarse_lines_noise_of_1": replace(_SILENT, noise=(1.0, 1.0)),
    "coarse_lines_coloured": replace(_SILENT, noise=(0.1, 0.3), pole=0.95),
    "coarse_lines_large": replace(_SILENT, lines=((_SLOW, (10.0, 40.0)),)),
    "coarse_lines_small": replace(_SILENT, lines=((_SLOW, (0.8, 3.0)),)),
    "coarse_lines_small_noisy": replace(_SILENT, lines=((_SLOW, (0.8, 3.0)),), noise=(0.05, 0.3)),
    "coarse_lines_long": replace(_SILENT, revolutions=(100.0, 300.0)),
    "coarse_lines_few_periods": replace(_SILENT, lines=(((0.4, 1.0), (3.0, 6.0)),), revolutions=(10.0, 15.0)),
    "coarse_lines_fast": replace(_SILENT, lines=(((5.0, 60.0), (3.0, 6.0)),)),
    "coarse_lines_two": replace(_SILENT, lines=((_SLOW, (3.0, 6.0)), (_SLOW, (0.5, 2.5)))),
    "coarse_lines_two_noisy": replace(
        _SILENT, lines=((_SLOW, (3.0, 6.0)), (_SLOW, (0.5, 2.5))), noise=(0.05, 0.3)
    ),
    "coarse_lines_on_a_drift": replace(_SILENT, lines=((_SLOW, (3.0, 6.0)), ((0.003, 0.01), (1.0, 2.0)))),
    "coarse_lines_ripple": replace(_SILENT, orders=((6, 0.6),)),
    "coarse_lines_ripple_larger": replace(_SILENT, orders=((6, 1.2), (12, 0.6))),
    "coarse_lines_ripple_noisy": replace(_SILENT, orders=((6, 0.6),), noise=(0.05, 0.3)),
}
CURRENTS: Mapping[str, CoarseCurrent] = {
    "coarse_current": _CURRENT,
    "coarse_current_noisy": replace(_CURRENT, noise=(0.05, 0.3)),
    "coarse_current_weak": replace(_CURRENT, share=(0.003, 0.02)),
    "coarse_current_harmonics": replace(_CURRENT, harmonics=(5, 7)),
}

FAMILIES = (*families_of(_lines, TORQUES), *families_of(_current, CURRENTS))
