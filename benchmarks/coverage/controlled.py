"""Families of closed loops whose gain rises just above rest, of outputs that drift on a bent course under a
sweep between two rests, and of delays over all frequencies alike."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.true_response import sampled, true_numbers_of_response
from benchtool.analysis import analyze_response
from benchtool.block import Block

Floats = NDArray[np.float64]
Excitation = Literal["noise", "bits", "lines", "sweep"]
Course = Literal["none", "parabola", "decay", "walk"]

_RATE_HZ = 4_000.0
_COUNT = 24_000
_REST = 0.06  # of the record, before and after a sweep
_PERIOD = 3_000
_LINES = 36


@dataclass(frozen=True)
class Controlled:
    """A loop of a proportional and integral controller about an integrator behind a lag, or with a `damping`
    a resonance of two poles; `noise` and `drift` of the output are relative to its rms."""

    excitation: Excitation = "noise"
    noise: float = 0.15
    drift: float = 0.0
    course: Course = "none"
    damping: float | None = None


def controlled_trial(what: Controlled, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one record."""
    numerator, denominator = _loop(random) if what.damping is None else _resonance(what.damping, random)
    x = _excited(what.excitation, random)
    y = np.asarray(signal.lfilter(numerator, denominator, x))
    rms = float(np.std(y))
    y += rms * (what.noise * random.standard_normal(len(y)) + what.drift * _course(what.course, random))
    block = Block.from_arrays(_RATE_HZ, {"x": "A", "y": "A"}, x=x, y=y)
    period = _PERIOD if what.excitation == "lines" else None
    found = analyze_response(block, "x", "y", begin_row=period or 0, period_rows=period).measurements
    response = sampled(numerator, denominator, _RATE_HZ)
    yield from selected(found, true_numbers_of_response(response, 0.5 * _RATE_HZ, found))


def _loop(random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return the closed loop: the zero of its controller is a tenth to a third of its crossover."""
    crossover = 2.0 * math.pi * random.uniform(40.0, 90.0) / _RATE_HZ
    pole, zero = (
        math.exp(-random.uniform(3.0, 8.0) * crossover),
        math.exp(-random.uniform(0.1, 0.3) * crossover),
    )
    late = int(random.integers(1, 4))
    below = np.convolve([1.0, -2.0, 1.0], [1.0, -pole])
    above = np.concatenate([np.zeros(late), crossover * (1.0 - pole) * np.array([1.0, -zero])])
    size = max(len(above), len(below))
    above, below = (np.pad(each, (0, size - len(each))) for each in (above, below))
    return above, above + below


def _resonance(damping: float, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return two poles, of unit gain at rest."""
    omega = 2.0 * math.pi * random.uniform(100.0, 260.0) / _RATE_HZ
    size = math.exp(-damping * omega)
    turn = omega * math.sqrt(1.0 - damping**2)
    below = np.array([1.0, -2.0 * size * math.cos(turn), size**2])
    return np.array([0.0, float(np.sum(below))]), below


def _excited(excitation: Excitation, random: np.random.Generator) -> Floats:
    """Return samples of the excitation."""
    if excitation == "noise":
        return random.standard_normal(_COUNT)
    if excitation == "bits":
        return np.repeat(random.choice([-1.0, 1.0], _COUNT // 6), 6)
    if excitation == "lines":
        lines = np.unique(np.geomspace(1.0, 0.35 * _PERIOD, _LINES).round().astype(int))
        bins = np.zeros(_PERIOD // 2 + 1, dtype=np.complex128)
        bins[lines] = np.exp(2j * np.pi * random.random(len(lines)))
        return np.asarray(np.tile(np.fft.irfft(bins) * _PERIOD / len(lines), _COUNT // _PERIOD))
    rest = round(_REST * _COUNT)
    time_s = np.arange(_COUNT - 2 * rest) / _RATE_HZ
    return np.pad(signal.chirp(time_s, 0.3, float(time_s[-1]), 1_500.0, phi=-90.0), rest)


def _course(course: Course, random: np.random.Generator) -> Floats:
    """Return a drift that goes by about one over the record."""
    time = np.linspace(0.0, 1.0, _COUNT)
    if course == "parabola":
        return np.asarray(random.choice([-1.0, 1.0]) * time**2)
    if course == "decay":
        return np.asarray(random.choice([-1.0, 1.0]) * np.exp(-time / random.uniform(0.25, 0.6)))
    if course == "walk":
        return np.asarray(np.cumsum(random.standard_normal(_COUNT)) / math.sqrt(_COUNT))
    return np.zeros(_COUNT)


FAMILIES = families_of(
    controlled_trial,
    {
        "integral_loop_noise": Controlled(),
        "integral_loop_bits": Controlled("bits"),
        "integral_loop_lines": Controlled("lines", 0.1),
        "integral_loop_sweep": Controlled("sweep"),
        "integral_loop_quiet": Controlled("bits", 0.01),
        "sweep_rest_parabola": Controlled("sweep", 0.01, 0.4, "parabola", 0.5),
        "sweep_rest_decay": Controlled("sweep", 0.01, 0.4, "decay", 0.4),
        "sweep_rest_walk": Controlled("sweep", 0.01, 0.2, "walk", 0.6),
        "sharp_between_lines": Controlled("lines", 0.02, damping=0.05),
    },
)
