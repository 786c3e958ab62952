"""Tail of a distribution: its index, and how the largest of many values in it scatters."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import log_beta

GUMBEL = math.pi / math.sqrt(6.0)
"""Standard deviation of the largest of exponential excesses, over their mean."""

_EXPONENTIAL, _HEAVIEST = 0.02, 0.4  # index of a tail: below it is none, above it has no variance to speak of
_OF_TAIL, _FEWEST_OF_TAIL, _MOST_OF_TAIL = 100, 20, 2000  # one value in so many is of the tail
_INDICES = 16  # of a tail, each as likely
_DIFFERS = 3.0  # standard deviations of an index
_FEWEST_OVER_TAIL = 4  # times the tail: fewer values are hardly beyond the middle of their distribution


def extreme_over_excess(tail: float, beyond: int) -> float:
    """Return the standard deviation of the largest of `beyond` excesses on average, over their mean.

    Of generalised Pareto excesses of scale s and index x the mean is s / (1 - x), the largest of n behaves as
    s ((n / e)^x - 1) / x with e exponential. Of an index below zero, of which that has no bound, e / n is the
    least of n uniform values, and the mean of its k-th power is n B(n, 1 + k).
    """
    tail = min(tail, _HEAVIEST)
    if abs(tail) <= _EXPONENTIAL:
        return GUMBEL
    if tail < 0.0:
        mean, square = (beyond * math.exp(log_beta(beyond, 1.0 - power * tail)) for power in (1, 2))
        return (1.0 - tail) * math.sqrt(max(0.0, square - mean**2)) / -tail
    spread = math.sqrt(math.gamma(1.0 - 2.0 * tail) - math.gamma(1.0 - tail) ** 2) / tail
    return (1.0 - tail) * math.exp(tail * math.log(beyond)) * spread


def tail_index(deviations: NDArray[np.float64], of_tail: int = _OF_TAIL) -> float:
    """Return the index of the tails of deviations about zero, shape (n,): above 0 for power laws, 0 for
    exponential tails and for lighter ones, and where the values are too few to tell.

    The moment estimator over the largest of the magnitudes, one in `of_tail` (Dekkers, Einmahl and de Haan,
    Ann. Statist. 17 (1989) 1833), which of normal values is below zero; where it is above by its own standard
    deviation, with that added: a tail that is found too light gives an extreme that is far too certain. A few
    that are far larger than all others are a tail of their own: where an octave of the largest or more has
    clearly less, half as many are taken, and so on (Drees and Kaufmann, Stoch. Process. Appl. 75 (1998) 149).
    """
    top = min(len(deviations) // of_tail, _MOST_OF_TAIL)
    if top < _FEWEST_OF_TAIL:
        return 0.0
    size = np.abs(deviations)
    tops = [top >> octave for octave in range(int(math.log2(top / _FEWEST_OF_TAIL)) + 1)]
    largest = np.partition(size, len(size) - top - 1)[len(size) - top - 1 :]
    found = [moment_estimate(largest, each) for each in tops]
    index, standard = next(each for number, each in enumerate(found) if _is_of_all(each, found[number + 1 :]))
    return index + standard if index > standard else 0.0


def _is_of_all(found: tuple[float, float], further: list[tuple[float, float]]) -> bool:
    """Return whether an index and its standard deviation are not clearly above those further out."""
    index, standard = found
    # of nested samples, the variance of a difference is the difference of variances
    return all(index - of <= _DIFFERS * math.sqrt(max(0.0, u**2 - standard**2)) for of, u in further)


def tail_indices_of_heavy(deviations: NDArray[np.float64], of_tail: int) -> tuple[float, ...]:
    """Return indices, each as likely, of the tails of deviations about zero, shape (n,), that are known to be
    heavier than normal ones, by their kurtosis say; none where the values are too few to tell.

    That of exponential tails is then as little known as that of a power law: the moment estimator over the
    largest twenty at least has a normal error, and the index is none below 0. Far more than in proportion to
    the index does the largest value scatter: one in the middle of these gives too little.
    """
    top = min(max(len(deviations) // of_tail, _FEWEST_OF_TAIL), _MOST_OF_TAIL)
    if len(deviations) <= _FEWEST_OVER_TAIL * top:
        return ()
    index, standard = moment_estimate(np.abs(deviations), top)
    if not standard > 0.0:
        return ()
    found = NormalDist(index, standard)
    below = found.cdf(0.0)
    shares = below + (1.0 - below) * (np.arange(_INDICES) + 0.5) / _INDICES
    return tuple(found.inv_cdf(each) for each in shares.tolist() if each < 1.0)


def moment_estimate(size: NDArray[np.float64], top: int) -> tuple[float, float]:
    """Return the index of the tail of magnitudes, shape (n,), over so many of the largest, and its standard
    deviation; 0 and 0 where these show none."""
    largest = np.partition(size, len(size) - top - 1)[len(size) - top - 1 :]
    least = float(np.min(largest))
    if not least > 0.0:
        return 0.0, 0.0
    logs = np.log(largest / least)
    first, second = float(np.sum(logs)) / top, float(np.sum(logs**2)) / top
    if not second > 0.0 or first**2 >= second:
        return 0.0, 0.0
    index = first + 1.0 - 0.5 / (1.0 - first**2 / second)
    return index, math.sqrt((1.0 + index**2) / top)
