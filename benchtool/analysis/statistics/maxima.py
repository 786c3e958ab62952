"""By how much the largest of maxima differs from record to record, where no tail is heavy.

The largest of many values has the generalised extreme value distribution F(x) = exp(-(1 - k x)^(1 / k)), and
the largest of N such maxima has it again, N^-k times as wide (Jenkinson, Quart. J. R. Met. Soc. 81 (1955)
158). Its shape k is 0 of an exponential tail, 0.1 to 0.3 of normal values, of which thousands come to k = 0
so slowly that no record shows it, and 2/3 to 1 of a tail that ends, as that of an arc sine or of a uniform
distribution does. The ratio of the third to the second L-moment of the maxima tells k, and not well of few:
the variance is the mean over all k, each with the weight that this ratio gives it (Hosking, J. R. Statist.
Soc. B 52 (1990) 105; Hosking, Wallis and Wood, Technometrics 27 (1985) 251).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.statistics.clicks import normal_above

Floats = NDArray[np.float64]

_SHAPES: Floats = np.linspace(0.01, 1.2, 60)
_USUAL_SHAPE = 0.25  # mean of the exponential distribution of shapes before any maximum is seen
_MOST_MAXIMA = 40  # of more, the largest of some each are closer to the distribution
_OCTAVES = 24  # of numbers of values
_BY_CHANCE, _LIGHTER = 2.0, -0.3  # standard deviations of a kurtosis; half the excess of three uniform values
_LEAST = float(np.finfo(np.float64).tiny)  # below it are no digits
_OF_HEAP, _APART = 3, 20.0  # maxima, and widths: of an exponential tail once in two thousand records
_ALONE, _BELOW = 2, 5  # maxima beyond a heap of so many
_ROUNDING = 1e-12  # of the largest
_TIMES_A_PERIOD, _MOST_SAMPLES = 3, 1 << 14  # that a value is taken; of the largest
_IN_NEXT = 1.0 - math.sqrt(0.5)
_FAR = 6.0  # times the median of the magnitudes: four standard deviations of normal values


def scatter_of_largest_maximum(maxima: Floats, least: float = 0.0) -> float:
    """Return the standard deviation of the largest of maxima, shape (n,), n > 2, over records of as many.

    The width of the distribution is that of n values, and so the standard deviation that of Student's
    distribution (JCGM 101:2008, 6.4.9.4). It is `least` at least, in the unit of the maxima.
    """
    size = max(1, round(len(maxima) / _MOST_MAXIMA))
    blocks = np.sort(np.max(maxima[: len(maxima) - len(maxima) % size].reshape(-1, size), axis=1))
    count = len(blocks)
    width, skewness = l_moments(blocks)
    if not width > 0.0:
        return least
    # of the ratio of normal values; of other shapes it is much the same
    deviation = math.sqrt(0.1866 / count + 0.8 / count**2)
    ratio, relative = _of_shapes()
    fit = -0.5 * ((skewness - ratio) / deviation) ** 2 - _SHAPES / _USUAL_SHAPE
    weight = np.exp(fit - np.max(fit))
    of_all = relative * (len(maxima) / size) ** -_SHAPES
    mean_square = float(np.sum(weight * of_all**2) / np.sum(weight))
    return max(least, students_deviation(float(count)) * width * math.sqrt(mean_square))


def scatter_of_heap(maxima: Floats, samples: Floats | None = None) -> float:
    """Return the standard deviation of the largest of maxima, shape (n,), over records of as many, where the
    largest of them are a heap, as of a signal that takes few values; 0 where they are none.

    Then it is in that heap again, or in one that is as far above it as the next is below: with the
    probability that something of which there was nothing in n is once in n (Jeffreys' prior: Beta
    distribution of 1/2 and n + 1/2), of many 1 - sqrt(1/2). One or two that are beyond a heap come again or
    not with nearly that probability. Where all of few maxima are in one heap, the `samples`, shape (m,), of
    which they are the largest, tell how far below it the next is.
    """
    ordered = np.sort(maxima)[::-1]
    _, apart = _top_heap(ordered)
    for alone in range(1, _ALONE + 1):
        heap = ordered[alone : alone + _BELOW]
        if not apart and len(heap) == _BELOW and ordered[alone - 1] - heap[0] > _APART * (heap[0] - heap[-1]):
            apart = float(ordered[0] - heap[0])
    if not apart and samples is not None:
        apart = _below_heap(samples, len(maxima))
    return math.sqrt(_IN_NEXT * (1.0 - _IN_NEXT)) * apart


def _top_heap(ordered: Floats) -> tuple[int, float]:
    """Return how many of falling values, shape (n,), are the highest heap, and how far below it the next is;
    0 where they are none."""
    gaps, widths = ordered[_OF_HEAP - 1 : -1] - ordered[_OF_HEAP:], ordered[0] - ordered[_OF_HEAP - 1 : -1]
    ends = np.flatnonzero(gaps > _APART * widths)
    if not len(ends):
        return 0, 0.0
    end = int(ends[np.argmax(gaps[ends])])  # what is alike in a heap may be alike in parts of it, too
    return end + _OF_HEAP, float(gaps[end])


def _below_heap(samples: Floats, periods: int) -> float:
    """Return how far below the highest heap of samples, shape (n,), the next is; 0 where they are in none.

    One of few values is taken many times in a period, one of a waveform that repeats once or twice, or, of
    as many crests, without any noise.
    """
    most = min(len(samples), _MOST_SAMPLES)
    ordered = np.sort(np.partition(samples, len(samples) - most)[len(samples) - most :])[::-1]
    count, apart = _top_heap(ordered)
    if not count or not ordered[0] - ordered[count - 1] > _ROUNDING * float(np.max(np.abs(ordered))):
        return 0.0
    below, _ = _top_heap(ordered[count:])
    return apart if below > _TIMES_A_PERIOD * periods else 0.0


def is_no_heavier_than_normal(deviations: Floats) -> bool:
    """Return whether the kurtosis of deviations about zero, shape (n,), is at most by chance above that of
    normal ones, 3 with a variance of 24 / n."""
    excess = _excess(deviations)
    return excess < _BY_CHANCE * math.sqrt(24.0 / max(1, len(deviations)))


def scatter_of_largest_normal(deviations: Floats, count: int) -> float:
    """Return the standard deviation of the largest of `count` independent normal values as deviations, shape
    (n,), about zero are: of Phi^N (David and Nagaraja, Order Statistics, 3rd ed. 2003, 2.1). It falls with N.

    A few that are far larger than most, as edges are among differences, are left out; it is 0 where the
    kurtosis of the others is that of a tail that ends.
    """
    size = np.abs(deviations)
    others = deviations[size <= _FAR * float(np.median(size))] if len(size) else deviations
    if not _LIGHTER < _excess(others) < math.inf:
        return 0.0
    return float(np.std(others)) * _of_phi(_half_octaves(count))[1]


def ends_before_normal(deviations: Floats) -> bool:
    """Return whether both extremes of deviations about zero, shape (n,), together are nearer to it than
    those of as many independent normal values by more than their deviation, as where a control keeps within
    bounds."""
    mean, deviation = _of_phi(_half_octaves(len(deviations)))
    nearest = 2.0 * mean - math.sqrt(2.0) * deviation
    return float(np.ptp(deviations)) < nearest * float(np.std(deviations)) if len(deviations) else False


def scatter_of_largest_of_normal(maxima: Floats, noise_rms: float) -> float:
    """Return the standard deviation of the largest of maxima, shape (n,), over records of as many, where each
    is the largest of values in normal noise, which may be correlated.

    Of how many independent values each is the largest is told by its deviation, over that of the noise.
    """
    of_one, count = float(np.std(maxima, ddof=1)), len(maxima)
    if not noise_rms > 0.0:
        return of_one
    octaves = np.arange(0.0, _OCTAVES + 0.5, 0.5)
    deviations = np.array([_of_phi(round(2.0 * each))[1] for each in octaves])
    own = float(np.interp(-min(1.0, of_one / noise_rms), -deviations, octaves))
    of_all = float(np.interp(own + math.log2(count), octaves, deviations))
    return of_one * of_all / float(np.interp(own, octaves, deviations))


def _excess(deviations: Floats) -> float:
    """Return the kurtosis less that of normal values; inf of deviations that are all zero."""
    largest = float(np.max(np.abs(deviations))) if len(deviations) else 0.0
    if not largest > _LEAST:
        return math.inf
    square = (deviations / largest) ** 2
    return float(np.mean(square**2)) / float(np.mean(square)) ** 2 - 3.0


def l_moments(ordered: Floats) -> tuple[float, float]:
    """Return the second L-moment of values in order, shape (n,), and the ratio of the third to it."""
    count, place = len(ordered), np.arange(len(ordered))
    once = place / (count - 1.0)
    mean, first, second = (
        float(np.mean(each * ordered)) for each in (1.0, once, once * (place - 1.0) / (count - 2.0))
    )
    width = 2.0 * first - mean
    return width, (6.0 * second - 6.0 * first + mean) / width if width > 0.0 else 0.0


@cache
def _of_shapes() -> tuple[Floats, Floats]:
    """Return the ratio of the third to the second L-moment, and the standard deviation over the second, of
    each of `_SHAPES`."""
    k = _SHAPES
    one, two = (np.array([math.gamma(1.0 + by * each) for each in k]) for by in (1.0, 2.0))
    ratio = 2.0 * (1.0 - 3.0**-k) / (1.0 - 2.0**-k) - 3.0
    return ratio, np.sqrt(two - one**2) / ((1.0 - 2.0**-k) * one)


@cache
def _of_phi(half_octaves: int) -> tuple[float, float]:
    """Return mean and deviation of the largest of 2^(half_octaves / 2) normal values, over the deviation of
    these."""
    value, above = normal_above()
    # above the mean by what is above, whose logarithm keeps its digits
    below = np.where(value > 0.0, np.log1p(-np.minimum(above, 0.5)), np.log(above[::-1]))
    share, middle = np.diff(np.exp(2.0 ** (0.5 * half_octaves) * below)), 0.5 * (value[1:] + value[:-1])
    mean = float(share @ middle)
    return mean, math.sqrt(float(share @ (middle - mean) ** 2))


def _half_octaves(count: int) -> int:
    return max(0, round(2.0 * math.log2(max(1, count))))
