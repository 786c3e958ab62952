"""Where in a transient the noise is more than at rest.

Samples of a smooth answer, and of one that oscillates, follow from the two before each: what such a
prediction leaves is noise (linear prediction: Makhoul, Proc. IEEE 63 (1975) no. 4). What it would leave of
the noise at rest is known from the autocovariance of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise, without_a_line

Floats = NDArray[np.float64]

_SIZE, _PARTS = 16, 100  # samples of a window, at least; windows of a record without overlap, at most
_HOPS = 4  # windows that begin within one
LOUD = 2.5
"""Times the noise at rest: the prediction leaves no more of that, by chance, in 10 000 windows."""

_CALM = 0.7  # of the noise at rest: no less of that is between bursts, by chance
_LEAST = 1e-3  # of the noise: less is none
_LATE = 5  # the last of so many parts of a record, whose noise is that at rest
_OF_MEDIAN = 1.0 / 0.6745  # standard deviation over median magnitude, of normal values
_OF_RESIDUAL, _LOUD_POWER = 40, 2.5  # samples; times the power at rest


def noise_and_levels(samples: Floats, noise: Noise, of_plateau: Noise | None = None) -> tuple[Noise, Floats]:
    """Return noise and by how much that of samples, shape (n,), is more, shape (n,), at least 1: the noise
    that is known at rest or, where that has bursts itself, what is between them.

    Where another noise is known of a plateau it is that, and the levels may be less than 1.

    By what a prediction from two samples leaves in a window, where its median is large. A burst is in two
    windows side by side, an edge only in those that overlap.
    """
    count = len(samples)
    if of_plateau is not None and of_plateau.rms > 0.0:
        noise = of_plateau
    if count <= _size(count) or not noise.rms > 0.0:
        return noise, np.ones(count)
    predicted = _Predicted.of(samples, noise)
    if of_plateau is not None:
        loud = predicted.levels(predicted.left > LOUD * predicted.of_noise, 1.0)
        return noise, loud * predicted.calm_levels()
    usual = float(np.median(predicted.share))
    levels = predicted.levels(predicted.is_loud, usual) if usual > 0.0 else np.ones(count)
    if np.any(levels[count // 2 :] > 1.0):  # at rest too, and not before these samples alone
        late = slice(-(count // _LATE), None)
        calm = Noise.of(without_a_line(samples[late]) / levels[late])
        if 0.0 < calm.rms < _CALM * noise.rms:
            predicted = _Predicted.of(samples, calm)
            return calm, predicted.levels(predicted.is_loud, 1.0)
    return noise, predicted.levels(predicted.left > LOUD * predicted.of_noise, 1.0)


def _size(count: int) -> int:
    """Return the samples of a window, of so many."""
    return max(_SIZE, _HOPS * (count // (_HOPS * _PARTS)))


@dataclass(frozen=True)
class _Predicted:
    """What predictions leave in windows of `size` samples, which `begin` in some rows of `count`: `left`, by
    its median, and its `rms`, and what they would leave `of_noise` that is known, all of shape
    (windows,)."""

    count: int
    size: int
    begin: NDArray[np.int64]
    left: Floats
    rms: Floats
    of_noise: Floats

    @classmethod
    def of(cls, samples: Floats, noise: Noise) -> _Predicted:
        count, size = len(samples), _size(len(samples))
        begin = np.arange(0, count - size + 1, size // _HOPS)
        errors, weights = unpredicted(samples, begin, size)
        known = np.zeros(3)
        known[: min(3, len(noise.autocovariance))] = noise.autocovariance[:3]
        apart = np.abs(np.subtract.outer(np.arange(3), np.arange(3)))
        # as many samples as a prediction has coefficients are no errors
        square = (size - 5) / (size - 2) * np.einsum("ni,ij,nj->n", weights, known[apart], weights)
        of_noise = np.sqrt(np.maximum(square, np.finfo(float).tiny))
        rms = np.sqrt(np.mean(errors**2, axis=1))
        return cls(count, size, begin, _OF_MEDIAN * np.median(np.abs(errors), axis=1), rms, of_noise)

    @property
    def share(self) -> Floats:
        """What is left relative to what would be of the noise, shape (windows,)."""
        return self.rms / self.of_noise

    @property
    def is_loud(self) -> NDArray[np.bool_]:
        """Whether more is left than mostly is, and than mostly is relative to the noise, shape (windows,)."""
        relative = self.left / self.of_noise
        return (self.left > LOUD * np.median(self.left)) & (relative > LOUD * np.median(relative))

    def levels(self, loud: NDArray[np.bool_], usual: float) -> Floats:
        """Return by how much what is left is more than usual at every sample, shape (n,), at least 1, in
        windows that are `loud`, shape (windows,), and have one of these beside them, or end the record."""
        levels = np.ones(self.count)
        # an edge spoils the prediction in all windows that hold it, and in none beside them
        before, after = np.pad(loud, (_HOPS, 0))[:-_HOPS], np.pad(loud, (0, _HOPS), mode="edge")[_HOPS:]
        for at in np.flatnonzero(loud & (before | after)):
            rows = slice(self.begin[at], self.begin[at] + self.size)
            levels[rows] = np.maximum(levels[rows], self.share[at] / usual)
        return levels

    def calm_levels(self) -> Floats:
        """Return by how much less than the noise is left at every sample, shape (n,), at most 1: where it is
        clearly less in all windows that hold the sample."""
        share = np.where(LOUD * self.share < 1.0, np.maximum(self.share, _LEAST), 1.0)
        levels = np.zeros(self.count)
        for begin, level in zip(self.begin, share, strict=True):
            rows = slice(begin, begin + self.size)
            levels[rows] = np.maximum(levels[rows], level)
        return np.where(levels > 0.0, levels, share[-1])


def unpredicted(samples: Floats, begin: NDArray[np.int64], size: int) -> tuple[Floats, Floats]:
    """Return what linear predictions from the two samples before leave in windows of samples that begin in
    some rows, shape (windows, size - 2), and the weights of a sample and of the two before it in that, shape
    (windows, 3)."""
    within = np.lib.stride_tricks.sliding_window_view(samples, size)[begin]
    columns = np.stack([within[:, 1:-1], within[:, :-2], np.ones((len(begin), size - 2))], axis=2)
    solution = np.linalg.pinv(columns) @ within[:, 2:, np.newaxis]
    errors = within[:, 2:] - (columns @ solution)[..., 0]
    return errors, np.concatenate([np.ones((len(begin), 1)), -solution[:, :2, 0]], axis=1)


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
