"""Band-limited interpolation: values of a sampled signal between its samples."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

HALF_WIDTH = 32
"""Samples that interpolation needs on either side of a position."""

USABLE_BAND = 0.45
"""Share of the sample rate below which a component keeps its amplitude within 1e-4."""

_KAISER_BETA = 9.0  # 90 dB; with 64 taps the transition begins at 0.45 of the sample rate
_FRACTIONS = 1024
_CHUNK = 512  # positions at a time: the gathered taps and weights, 0.25 MB each, stay in the cache


def interpolate(samples: NDArray[np.float64], positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values of uniformly sampled `samples`, shape (n,), at fractional sample numbers, shape (m,).

    As `interpolate_all` of that signal alone.
    """
    return np.asarray(interpolate_all((samples,), positions)[0])


def interpolate_all(
    signals: Sequence[NDArray[np.float64]], positions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the values of signals that were sampled together, each of shape (n,), as shape (signals, m).

    Sinc interpolation under a Kaiser window (Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed.,
    7.5.3) of 64 taps; kernel values are interpolated linearly between 1024 fractions of a sample. `positions`
    lie within [HALF_WIDTH - 1, n - HALF_WIDTH).

    Raises:
        ValueError: a position has not HALF_WIDTH samples on either side.
    """
    count = len(signals[0])
    inside = (positions >= HALF_WIDTH - 1) & (positions < count - HALF_WIDTH)
    if not np.all(inside):
        raise ValueError(f"positions need {HALF_WIDTH} samples on either side, there are {count} in all")
    kernel, steps = _kernel()
    windows = [sliding_window_view(each, 2 * HALF_WIDTH) for each in signals]
    values = np.empty((len(signals), len(positions)))
    for start in range(0, len(positions), _CHUNK):
        position = positions[start : start + _CHUNK]
        sample = position.astype(np.int64)  # towards zero, and positions are positive
        blend = (position - sample) * _FRACTIONS
        row = blend.astype(np.int64)
        blend -= row
        weights = kernel[row]
        weights += blend[:, np.newaxis] * steps[row]
        first = sample - (HALF_WIDTH - 1)
        for value, window in zip(values, windows, strict=True):
            value[start : start + _CHUNK] = np.vecdot(weights, window[first])
    return values


@cache
def _kernel() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tap weights, and what they change to those of the next row, both of shape (fractions, taps).

    Row r is for a position r / fractions of a sample past tap HALF_WIDTH - 1.
    """
    fraction = np.arange(_FRACTIONS + 1) / _FRACTIONS
    distance = np.arange(1 - HALF_WIDTH, HALF_WIDTH + 1) - fraction[:, np.newaxis]
    inside = np.maximum(0.0, 1.0 - (distance / HALF_WIDTH) ** 2)
    weights = np.sinc(distance) * np.i0(_KAISER_BETA * np.sqrt(inside))
    weights /= np.sum(weights, axis=1, keepdims=True)
    return weights[:-1], np.diff(weights, axis=0)
