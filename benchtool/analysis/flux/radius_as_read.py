"""How much larger the extremes of a radius are read than they are, in the steps of both axes' converters.

The greatest of readings of one axis is the reading of its greatest value: as often too large as too small. A
radius has the errors of both axes, which change from sample to sample as it turns: the greatest of it is
where they make it so, as if it had noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_DRAWS, _SEED = 24, 20_261_130
_HIGHEST = 24  # order of a coordinate that is looked for
_PER_ORDER = 4  # samples in a revolution
_STANDS_OUT = 0.25  # of a step: lines of the path that are more are no errors of the steps
_MOST_ROWS = 1 << 14

Complex = NDArray[np.complex128]


class ReadLarger(NamedTuple):
    """By how much a peak-to-peak radius is read too large, and the standard deviation of that."""

    mean: float = 0.0
    standard: float = 0.0


def radius_as_read(
    path: Complex, rest: Complex, circle: Complex, revolutions: int, step: float
) -> ReadLarger:
    """Return that of a path that is read in steps, shape (n,), all over whole revolutions of a circle of
    radius 1, shape (n,); `rest` is the path without order 1, shape (n,).

    What the other orders are that stand out of the steps, and what noise is left, is read again with the
    levels anywhere.
    """
    if not step > 0.0:
        return ReadLarger()
    every = slice(None, None, -(-len(path) // _MOST_ROWS))
    first, rest, circle = (path - rest)[every], rest[every], circle[every]
    highest = min(_HIGHEST, len(path) // revolutions // _PER_ORDER)
    orders = circle[:, np.newaxis] ** np.array([k for k in range(-highest, highest + 1) if k != 1])
    lines = np.linalg.solve(np.conj(orders.T) @ orders, np.conj(orders.T) @ rest)
    signal = first + orders @ np.where(np.abs(lines) > _STANDS_OUT * step, lines, 0.0)
    noise = np.sqrt(max(0.0, 0.5 * float(np.mean(np.abs(first + rest - signal) ** 2)) - step**2 / 12.0))
    random = np.random.default_rng(_SEED)
    larger = []
    for _ in range(_DRAWS):
        parts = noise * random.standard_normal((2, len(signal)))
        before = signal + parts[0] + 1j * parts[1]
        level = complex(*random.uniform(0.0, step, 2))
        read = step * (np.round((before - level).real / step) + 1j * np.round((before - level).imag / step))
        larger.append(float(np.ptp(np.abs(read + level)) - np.ptp(np.abs(before))))
    return ReadLarger(float(np.mean(larger)), float(np.std(larger)))
