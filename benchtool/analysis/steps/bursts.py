"""Where in a transient the noise is more than at rest.

Samples of a smooth answer, and of one that oscillates, follow from the two before each: what such a
prediction leaves is noise (linear prediction: Makhoul, Proc. IEEE 63 (1975) no. 4). What it would leave of
the noise at rest is known from the autocovariance of that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise

Floats = NDArray[np.float64]

_SIZE, _PARTS = 32, 100  # samples of a window, at least; windows of a record without overlap, at most
_HOPS = 4  # windows that begin within one
_LOUD = 2.5  # times the noise at rest: the prediction leaves no more of that, by chance, in 10 000 windows
_OF_MEDIAN = 1.0 / 0.6745  # standard deviation over median magnitude, of normal values
_OF_RESIDUAL, _LOUD_POWER = 40, 2.5  # samples; times the power at rest


def noise_levels(samples: Floats, noise: Noise) -> Floats:
    """Return by how much the noise of samples, shape (n,), is more than at rest, shape (n,), at least 1.

    By the median of what a prediction from two samples leaves in a window. A burst is in two windows side by
    side, an edge only in those that overlap.
    """
    count = len(samples)
    size = max(_SIZE, _HOPS * (count // (_HOPS * _PARTS)))
    levels = np.ones(count)
    covariance = np.zeros(3)
    covariance[: min(3, len(noise.autocovariance))] = noise.autocovariance[:3]
    if count <= size or not covariance[0] > 0.0:
        return levels
    begin = np.arange(0, count - size + 1, size // _HOPS)
    within = np.lib.stride_tricks.sliding_window_view(samples, size)[begin]
    columns = np.stack([within[:, 1:-1], within[:, :-2], np.ones((len(begin), size - 2))], axis=2)
    solution = np.linalg.pinv(columns) @ within[:, 2:, np.newaxis]
    left = _OF_MEDIAN * np.median(np.abs(within[:, 2:] - (columns @ solution)[..., 0]), axis=1)
    weights = np.concatenate([np.ones((len(begin), 1)), -solution[:, :2, 0]], axis=1)
    apart = np.abs(np.subtract.outer(np.arange(3), np.arange(3)))
    at_rest = np.sqrt(np.einsum("ni,ij,nj->n", weights, covariance[apart], weights))
    loud = np.where(left > _LOUD * at_rest, left / np.maximum(at_rest, np.finfo(float).tiny), 1.0)
    # an edge spoils the prediction in all windows that hold it, and in none beside them
    before, after = np.pad(loud, (_HOPS, 0))[:-_HOPS], np.pad(loud, (0, _HOPS))[_HOPS:]
    for first, level in zip(begin, np.minimum(loud, np.maximum(before, after)), strict=True):
        rows = slice(first, first + size)
        levels[rows] = np.maximum(levels[rows], level)
    return levels


def residual_levels(left: Floats, rms: float) -> Floats:
    """Return by how much the noise is more than at rest, shape (n,), at least 1, by what a smooth curve
    leaves of samples around each."""
    size = max(_OF_RESIDUAL, len(left) * 2 // _PARTS)
    if len(left) <= size:
        return np.ones(len(left))
    around = np.concatenate([[0.0], np.cumsum(np.square(left))])
    middle = np.clip(np.arange(len(left)) - size // 2, 0, len(left) - size)
    ratio = (around[middle + size] - around[middle]) / (size * rms**2)
    return np.asarray(np.where(ratio > _LOUD_POWER, np.sqrt(ratio), 1.0))
