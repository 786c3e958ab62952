"""Bands of the spectrum of a record, and how well densities of noise fit them.

By Whittle's likelihood (Beran, Statistics for Long-Memory Processes, 1994, ch. 6): the power in a bin is
distributed exponentially about the density there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.statistics.medians import median

Floats = NDArray[np.float64]

FEWEST_BINS = 5
"""Fewest bins that tell a density."""

SINGLE = 8
"""The lowest bins, each a band of its own."""

_BANDS_PER_OCTAVE = 3.0
_RISES = 1e-6  # probability that white noise rises as much within two octaves
_PERHAPS = 2.0  # deviations of the logarithm of a ratio of two means: less is by chance far more probable
_NEAR_HARMONIC = 0.2  # of the distance between harmonics
_KEPT = 64  # lengths of records whose bands are kept: many have the same


@dataclass(frozen=True, eq=False)
class Densities:
    """Densities of noise at the places of bands, `shape` (models, bands), each of any size.

    Many records have bands at the same places: what is made of densities alone is calculated once.
    """

    shape: Floats

    @cached_property
    def reciprocal(self) -> Floats:
        return np.asarray(1.0 / self.shape)

    @cached_property
    def logarithm(self) -> Floats:
        return np.asarray(np.log(self.shape))

    def only(self, kept: NDArray[np.bool_]) -> Densities:
        """Return them at the places that are `kept`, shape (bands,)."""
        return Densities(self.shape[:, kept])


@dataclass(frozen=True)
class Bands:
    """Mean `power` of bands about each `place`, in cycles in the record, and the bins that each counts as,
    all of shape (bands,)."""

    place: Floats
    power: Floats
    count: Floats

    @classmethod
    def of(cls, samples: Floats, periods: int = 0) -> Bands | None:
        """Return the bands of samples, shape (n,), up to where the density clearly rises; None of too few.

        Harmonics of what repeats `periods` times in them are left out.
        """
        count = len(samples)
        if count < 2 * FEWEST_BINS:
            return None
        bins = fft.rfft(samples - np.mean(samples))[1 : (count - 1) // 2 + 1] / count
        edges = _edges(len(bins), periods)
        power = (bins.real**2 + bins.imag**2)[edges.kept]
        if len(power) < FEWEST_BINS or not np.all(power > 0.0):
            return None
        return edges.bands_of(power)._before_a_rise()

    def only(self, kept: NDArray[np.bool_]) -> Bands:
        """Return those that are `kept`, shape (bands,)."""
        return Bands(self.place[kept], self.power[kept], self.count[kept])

    def counting(self, most: Floats | float) -> Bands:
        """Return them counting as so many bins at most, each or all."""
        return replace(self, count=np.minimum(self.count, most))

    def fits(self, densities: Densities) -> Floats:
        """Return the logarithms of the likelihoods of densities at the places, shape (models,)."""
        # its size is eliminated: 1 / size has a Gamma distribution
        # einsum in place of a product of matrices, which would start threads
        scaled = np.einsum("ij,j->i", densities.reciprocal, self.power * self.count)
        fits = -np.einsum("ij,j->i", densities.logarithm, self.count)
        return np.asarray(fits - float(np.sum(self.count)) * np.log(scaled))

    def sizes(self, densities: Densities) -> Floats:
        """Return the mean of the inverse Gamma distribution of the size of each density, shape (models,)."""
        scaled = np.einsum("ij,j->i", densities.reciprocal, self.power * self.count)
        return np.asarray(scaled / max(float(np.sum(self.count)) - 1.0, 0.5))

    def _before_a_rise(self) -> Bands | None:
        """Return the bands below the one from which on the density is clearly higher than before; None where
        these are too few."""
        place, mean, count = self.place, self.power, self.count
        last = np.arange(2, len(place))
        first = np.searchsorted(place, 0.25 * place[last])
        first[first == last] = 0
        between = np.column_stack([first, last]).ravel()
        bins_below, power = (np.add.reduceat(each, between)[::2] for each in (count, mean * count))
        of_below = power / bins_below
        below = len(place)
        # what is within a few deviations is no rise, and the distribution takes time
        least = of_below * np.exp(_PERHAPS * np.sqrt(1.0 / count[last] + 1.0 / bins_below))
        for at in np.flatnonzero((bins_below >= 2.0) & (mean[last] > least)):
            ratio = float(mean[last[at]] / of_below[at])
            if fisher_above(2.0 * float(count[last[at]]), 2.0 * float(bins_below[at]), ratio) < _RISES:
                below = int(last[at])
                break
        found = self.only(np.arange(len(place)) < below)
        return found if np.sum(found.count) >= FEWEST_BINS else None


@dataclass(frozen=True)
class _Edges:
    """Which of the bins of a spectrum are `kept`, shape (bins,), and the `first` of these in each band, whose
    `place` and `count` are as in `Bands`."""

    kept: NDArray[np.bool_] | slice
    first: NDArray[np.int64]
    place: Floats
    count: Floats

    def bands_of(self, power: Floats) -> Bands:
        """Return the bands of the power of the bins that are kept, shape (n,).

        The mean is from the median of a band where that is less: single lines are no noise.
        """
        mean = np.add.reduceat(power, self.first) / self.count
        for at in np.flatnonzero(self.count >= SINGLE):
            within = power[self.first[at] : self.first[at] + int(self.count[at])]
            mean[at] = min(mean[at], median(within) / math.log(2.0))
        return Bands(self.place, mean, self.count)


@lru_cache(maxsize=_KEPT)
def _edges(bins: int, periods: int) -> _Edges:
    """Return those of so many bins from the lowest on, without harmonics of what repeats `periods` times: the
    lowest bins each, then parts of octaves."""
    number = np.arange(1.0, bins + 1)
    kept: NDArray[np.bool_] | slice = slice(None)
    if periods:
        away = np.abs(number - periods * np.round(number / periods))
        kept = (away > 0.0) & ((away >= max(1.0, _NEAR_HARMONIC * periods)) | (number < periods))
    number = number[kept]
    band = np.where(
        number <= SINGLE, number, SINGLE + 1.0 + np.floor(_BANDS_PER_OCTAVE * np.log2(number / SINGLE))
    )
    first = np.flatnonzero(np.diff(band, prepend=0.0))
    count = np.diff(first, append=len(number)).astype(np.float64)
    place = np.exp(np.add.reduceat(np.log(number), first) / count)
    return _Edges(kept, first, place, count)
