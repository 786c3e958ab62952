"""Families of closed loops whose controller has an integral part: a zero and a pole far below the bandwidth.

A speed loop about an inertia and the lag of its torque. Its gain is 1 at rest and a few percent more above
the zero, which may be below the lowest frequency that is played.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.true_response import sampled, true_numbers_of_response
from benchtool.analysis import analyze_response
from benchtool.block import Block

Floats = NDArray[np.float64]

_CROSSOVER_HZ = 8.0, 40.0
_ZERO, _LAG = (0.04, 0.2), (2.0, 5.0)  # of the crossover
_ROWS_PER_CYCLE = 30.0, 120.0  # of the crossover
_REST = 16  # of the record, at either end of a sweep
_SETTLED = 1e-2  # of its ringing, after as long: a loop that rings on is at the limit of stability


@dataclass(frozen=True)
class SpeedLoop:
    """`excitation` is a sweep, noise, or periods of a binary sequence or of lines; `noise` is that of the
    output relative to its own rms."""

    excitation: str
    noise: float = 0.01
    rows: int = 16_000
    delay_rows: int = 1


def _trial(what: SpeedLoop, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of a stable loop whose crossover, zero, lag and sample rate are drawn."""
    crossover_Hz, rate_Hz, above, closed_below = _drawn(what, random)
    while float(np.max(np.abs(np.roots(closed_below)))) ** (what.rows / _REST) > _SETTLED:
        crossover_Hz, rate_Hz, above, closed_below = _drawn(what, random)
    x, period = _played(what, crossover_Hz / rate_Hz, random)
    y = np.asarray(signal.lfilter(above, closed_below, x))
    y += what.noise * float(np.std(y)) * random.standard_normal(len(y))
    block = Block.from_arrays(rate_Hz, {"x": "rad/s", "y": "rad/s"}, x=x, y=y)
    found = analyze_response(block, "x", "y", begin_row=period or 0, period_rows=period).measurements
    closed = sampled(above, closed_below, rate_Hz)
    yield from selected(found, true_numbers_of_response(closed, 0.5 * rate_Hz, found))


def _drawn(what: SpeedLoop, random: np.random.Generator) -> tuple[float, float, Floats, Floats]:
    """Return crossover and sample rate, Hz, numerator and denominator of a closed loop, stable or not."""
    crossover_Hz = random.uniform(*_CROSSOVER_HZ)
    rate_Hz = crossover_Hz * math.exp(random.uniform(*np.log(_ROWS_PER_CYCLE)))
    omega = 2.0 * math.pi * crossover_Hz
    zero, lag = omega * random.uniform(*_ZERO), omega * random.uniform(*_LAG)
    opened = omega * lag * np.array([1.0, zero]), np.array([1.0, lag, 0.0, 0.0])
    held, below, _ = signal.cont2discrete(opened, 1.0 / rate_Hz, "zoh")
    above = np.concatenate([np.zeros(what.delay_rows), np.ravel(held)])
    below = np.concatenate([below, np.zeros(what.delay_rows)])
    return crossover_Hz, rate_Hz, above, below + above


def _played(what: SpeedLoop, crossover: float, random: np.random.Generator) -> tuple[Floats, int | None]:
    """Return the input and its period in rows; `crossover` is in cycles per row."""
    if what.excitation == "noise":
        return random.standard_normal(what.rows), None
    if what.excitation == "sweep":
        x, rest = np.zeros(what.rows), what.rows // _REST
        row = np.arange(what.rows - 2 * rest, dtype=np.float64)
        x[rest:-rest] = signal.chirp(row, 0.01 * crossover, row[-1], min(0.45, 6.0 * crossover), phi=-90.0)
        return x, None
    if what.excitation == "binary":
        one = 2.0 * signal.max_len_seq(10, state=np.ones(10, dtype=np.int8))[0] - 1.0
        one = np.roll(np.repeat(one, 2), int(random.integers(2046)))
    else:
        turn = 2.0 * math.pi * np.arange(2000) / 2000
        lines = np.unique(np.geomspace(1.0, min(0.45, 5.0 * crossover) * len(turn), 60).astype(np.int64))
        phase = random.uniform(0.0, 2.0 * math.pi, len(lines))
        one = np.sum(np.cos(np.outer(lines, turn) + phase[:, np.newaxis]), axis=0)
    return np.tile(one, round(what.rows / len(one))), len(one)


SPEED_LOOPS: Mapping[str, SpeedLoop] = {
    "speed_loop_sweep": SpeedLoop("sweep"),
    "speed_loop_noise": SpeedLoop("noise"),
    "speed_loop_binary": SpeedLoop("binary"),
    "speed_loop_lines": SpeedLoop("lines"),
    "speed_loop_noise_short": SpeedLoop("noise", noise=2.5e-3, rows=4_000, delay_rows=3),
    "speed_loop_lines_late": SpeedLoop("lines", noise=0.02, delay_rows=6),
    "speed_loop_sweep_noisy": SpeedLoop("sweep", noise=0.1, delay_rows=2),
}

FAMILIES = families_of(_trial, SPEED_LOOPS)
