"""What a ripple does between its samples, where they fall at the same places of all periods."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import periods_to_same_places

Floats = NDArray[np.float64]

BETWEEN = "curve between samples at the same places of all periods"
"""Name of the line of a budget."""

_FINER = 16  # places between two of the samples
_SAME = 0.5  # of a row: places that move by no more over the record are the same
_MOST_PLACES = 4096  # of more the curve between two is a millionth of the ripple of a sixth harmonic
_OF_HANN = 1.5  # mean square of a Hann window over the square of its mean
_STANDS_OUT = -math.log(1e-4)  # of the mean power of noise in a harmonic: once in ten thousand by chance


@dataclass(frozen=True)
class Between:
    """A curve of a period at `_FINER` points from one place of samples to the next, shape (m,), and which of
    its points are `sampled`, shape (n,), each as often. What differs from it from period to period is
    `noise`, rms."""

    curve: Floats
    sampled: NDArray[np.int64]
    noise: float

    def error_of(self, number: Callable[[Floats], float]) -> float:
        """Return the root mean square by which a number of samples misses that of the curve, over all phases
        of the samples within the distance of their places; 0 where noise is more, which carries some of the
        samples over what is between them."""
        whole = number(self.curve)
        missed = [number(self.curve[self.sampled - each]) - whole for each in range(_FINER)]
        error = float(np.sqrt(np.mean(np.square(missed))))
        return error if error > self.noise else 0.0


def between_samples(samples: Floats, turns: Floats) -> Between | None:
    """Return the curve of samples, shape (n,), at places in the periods that they repeat with, `turns`, shape
    (n,): that of the harmonics that stand out of what differs from period to period. None where it is
    constant or the places are many.

    Of a whole number of samples in each period, or in each few of them, the extremes are missed by as much in
    all periods, by up to k d^2 / 8 for a curvature k and a distance d. The curve is taken to hold nothing
    above half the rate at which its places follow each other (sampling theorem).
    """
    whole = float(turns[-1] - turns[0])
    rows, periods = (len(turns) - 1.0) / whole, max(1, round(whole))
    together = periods_to_same_places(rows, periods, _SAME) or periods
    places = round(together * rows)
    if places > _MOST_PLACES or places < 3 or 2 * together > periods:
        return None
    some = turns[:: max(1, len(turns) // _MOST_PLACES)]
    phase = turns - float(np.angle(np.sum(np.exp(2j * np.pi * places * some)))) / (2.0 * np.pi * places)
    # as seen from one period, the places of so many of them are shuffled
    at = np.round(phase * places).astype(np.int64) % places
    # under it lines in step with nothing and a drift are no curve of a period, as their mean would be
    weight = np.sin(np.pi * (np.arange(len(samples)) + 0.5) / len(samples)) ** 2
    count = np.bincount(at, weight, places)
    if not np.all(count):
        return None
    means = np.bincount(at, weight * samples, places) / count
    noise2 = _variance(samples - means[at], turns, places) * _OF_HANN / len(samples)
    bins = fft.rfft(means) / places
    bins[np.abs(bins) ** 2 <= _STANDS_OUT * noise2] = 0.0
    if not np.any(bins[1:]):
        return None
    curve = fft.irfft(bins, _FINER * places) * (_FINER * places)
    fine = np.arange(len(curve)) / len(curve)
    sampled = np.unique(np.round(phase * len(curve)).astype(np.int64) % len(curve))
    # as often as in the samples: of few values percentiles would be between two of them
    return Between(
        curve,
        np.repeat(sampled, math.ceil(min(len(samples), _MOST_PLACES) / len(sampled))),
        # where samples move about their places, they do so on the curve
        math.sqrt(_variance(samples - np.interp(phase, fine, curve, period=1.0), turns, places)),
    )


def _variance(rest: Floats, turns: Floats, places: int) -> float:
    """Return the variance of what samples, shape (n,), leave of so many values, but for what moves whole
    periods, which is no noise."""
    period = np.maximum(turns, 0.0).astype(np.int64)
    of_periods = np.bincount(period, rest) / np.maximum(1, np.bincount(period))
    own = rest - np.interp(turns, np.arange(len(of_periods)) + 0.5, of_periods)
    return float(own @ own) / max(1, len(rest) - places)
