"""Standard uncertainty of means, from the record itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above, students_deviation
from benchtool.analysis.fast_lengths import next_fast_length
from benchtool.analysis.statistics.lowest_frequencies import SlowNoise, slow_noise
from benchtool.analysis.statistics.neighbours import in_deviations, neighbours_alike
from benchtool.analysis.statistics.oscillations import mean_moved_by_oscillations, tapered_power
from benchtool.analysis.statistics.slow_swing import slow_swing
from benchtool.analysis.uncertainty import Contribution

_PARTS, _MOST_PARTS = 10, 64
_FEWEST_VALUES = 3
_BY_CHANCE, _CLEARLY, _WITHOUT_DOUBT = 2.5, 2.0, 2.5  # standard deviations of a correlation
_FEWEST_INDEPENDENT = 4.0  # values that a record must hold
TOO_SLOW = "it wanders more slowly than the record shows: record longer, or choose a window in steady state"
"""Why a mean has no uncertainty."""

BLOCKS = 4096
"""Parts of a record that its slow course is looked at in, usually."""

_LOWEST, _FEWEST_OF_LOWEST, _FAR_BELOW = 5, 5, 5.0
_DOF_OF_LOWEST = 2.0 * _LOWEST
_CLEARLY_LESS = 2.0  # times the power, beyond chance
_MOST_OF_NEXT = 30
_CLEARLY_MORE = 1.4  # times the error by parts: by chance both differ by less
_FEW_PARTS = 15.0  # degrees of freedom
_BEYOND_NOISE = 0.1  # by chance
_MORE, _RISES = 0.25, 0.3  # by chance; octaves, towards zero frequency
_FEW_INDEPENDENT = 8.0  # degrees of freedom, with fewer of which the correlation of a series is not known
_FEWEST_OF_A_MEMORY = 20  # values, of which fewer do not tell how long they remember
_ENOUGH_OF_A_MEMORY, _MATTERS = 31, 1e-3  # degrees of freedom; of the mean
_NOT_NOISE, _NOT_NOISE_OF_FEW, _FEW_TO_COMPARE = 1e-4, 1e-2, 10  # by chance; degrees of freedom
_MAYBE_CORRELATED, _CLEARLY_UNLIKE = 0.0, -2.0  # standard deviations of a correlation
_ROUNDS, _MOST_CORRELATED = 4, 0.4
_ROUNDING = 1e-12  # of the largest value


class Basis(StrEnum):
    """What an error of a mean, and its degrees of freedom, are by, as a budget says it."""

    SCATTER = ""
    POOLED = ", pooled with its density at the lowest frequencies"
    LOWEST = ", by its density at the lowest frequencies"
    CONTINUED = ", by its density at the lowest frequencies, continued to zero"


@dataclass(frozen=True)
class MeanError:
    """Standard uncertainty of a mean, and its degrees of freedom; `standard` is nan where there is none.

    It is the standard deviation of Student's distribution. By the scatter of few values it has their degrees
    of freedom, by the density of all samples more.
    """

    standard: float
    dof: float
    basis: Basis = Basis.SCATTER

    @classmethod
    def of_scatter(cls, experimental: float, dof: float, basis: Basis = Basis.SCATTER) -> MeanError:
        """Return the error of an experimental standard uncertainty with these degrees of freedom."""
        return cls(experimental * students_deviation(dof), dof, basis)

    @property
    def experimental(self) -> float:
        """Experimental standard uncertainty, by which errors with few degrees of freedom are compared."""
        return self.standard / students_deviation(self.dof)

    def exceeds_by_chance(self, other: MeanError) -> float:
        """Return the probability that two estimates of one error are as far above each other."""
        ratio = self.experimental / other.experimental if other.experimental > 0.0 else math.inf
        return fisher_above(self.dof, other.dof, ratio**2)

    def pooled(self, other: MeanError) -> MeanError:
        """Return the error by both, which are estimates of one variance."""
        dof = self.dof + other.dof
        square = (self.dof * self.experimental**2 + other.dof * other.experimental**2) / dof
        return MeanError.of_scatter(math.sqrt(square), dof, self.basis)

    def pooled_with_noise(self, noise: MeanError) -> MeanError:
        """Return this scatter where it is more than `noise` explains, else the variance that both are
        estimates of."""
        if self.exceeds_by_chance(noise) < _BEYOND_NOISE:
            return self
        if not math.isfinite(self.dof + noise.dof):
            return noise if math.isinf(noise.dof) else self
        return self.pooled(noise)

    def line(self, name: str, factor: float = 1.0) -> Contribution:
        """Return the line of a budget, `name`, in which the mean counts `factor` times."""
        return Contribution(f"{name}{self.basis}", "A", factor * self.standard, self.dof, of_student=True)


def error_of_series(values: NDArray[np.float64]) -> MeanError:
    """Return the error of the mean of values, shape (n,), one for each period; neighbours may be correlated.

    The variance of the mean is tau s^2 / n: tau, from the autocorrelations summed over pairs of lags as long
    as a pair is above zero (initial positive sequence: Geyer, Statistical Science 7 (1992), 3.3), is how many
    values count as one, and n / tau - 1 are the degrees of freedom. Correlation below zero counts only where
    it is more than chance. The scatter of few values is itself uncertain: the standard uncertainty is the
    standard deviation of Student's distribution, sqrt(dof / (dof - 2)) times as much (JCGM 101:2008, 6.4.9).
    """
    count = len(values)
    if count < _FEWEST_VALUES:
        return MeanError(math.nan, math.nan)
    deviation = values - np.mean(values)
    padded = next_fast_length(2 * count)
    power = np.abs(fft.rfft(deviation, padded)) ** 2
    covariance = fft.irfft(power, padded)[:count] / count
    if not covariance[0] > (_ROUNDING * float(np.max(np.abs(values)))) ** 2:
        return MeanError(float(np.std(values)), math.inf)
    neighbours = float(covariance[1] / covariance[0])
    tau = _counting_as_one(covariance)
    if neighbours > -_BY_CHANCE / math.sqrt(count):
        tau = max(tau, 1.0)
    correlated = in_deviations(neighbours, count)
    if correlated > _CLEARLY:
        tau = max(tau, _of_a_memory(neighbours, count), _without_bias(covariance, tau))
        if tau > count / _FEWEST_INDEPENDENT and correlated > _WITHOUT_DOUBT:
            return MeanError(math.nan, max(1.0, count / tau - 1.0))
    # it is itself not known better than that
    tau = min(max(tau, 2.0 / math.sqrt(count)), 0.5 * count)
    dof = max(1.0, count / max(tau, 1.0) - 1.0)
    # the deviations are from the mean of these values, and so too small by that mean's own variance
    standard = math.sqrt(covariance[0] * tau / (count - max(tau, 1.0)))
    return without_oscillations(values, MeanError.of_scatter(standard, dof))


def is_memory_untold(
    values: NDArray[np.float64], like_noise: NDArray[np.float64], fewest: int = _FEWEST_OF_A_MEMORY
) -> bool:
    """Return whether values, shape (n,), one for each of a few periods, wander for a while that these do not
    tell.

    They deviate by more than a thousandth, and more than others that noise moves as much, `like_noise`, of
    shape (n,); they are fewer than 32; and neighbours may be correlated. Those of which the correlation shows
    are not the ones that err most: a memory as long as the record is in its mean, and hardly in its scatter.
    Fewer than `fewest` do not tell it at all, unless neighbours are clearly unlike.
    """
    freedom, middle = len(values) - 1, abs(float(np.mean(values)))
    if not 2 <= freedom < _ENOUGH_OF_A_MEMORY or not float(np.std(values)) > _MATTERS * middle:
        return False
    noise = float(np.var(like_noise))
    by_chance = _NOT_NOISE if freedom >= _FEW_TO_COMPARE else _NOT_NOISE_OF_FEW
    if noise > 0.0 and fisher_above(freedom, freedom, float(np.var(values)) / noise) > by_chance:
        return False
    least = _MAYBE_CORRELATED if len(values) >= fewest else _CLEARLY_UNLIKE
    return neighbours_alike(values) > least


def _counting_as_one(covariance: NDArray[np.float64]) -> float:
    """Return how many values count as one, by the initial positive sequence."""
    count = len(covariance)
    pairs = covariance[: count - count % 2].reshape(-1, 2).sum(axis=1) / covariance[0]
    ended = np.flatnonzero(pairs <= 0.0)
    last = int(ended[0]) if len(ended) else len(pairs)
    return 2.0 * float(np.sum(np.minimum.accumulate(pairs[:last]))) - 1.0


def _of_a_memory(neighbours: float, count: int) -> float:
    """Return how many values of a Gauss-Markov sequence count as one, by the correlation r of neighbours,
    less its bias (1 + 3 r) / n (Kendall, Biometrika 41 (1954) 403)."""
    memory = min(neighbours + (1.0 + 3.0 * neighbours) / count, 1.0 - 1.0 / count)
    return (1.0 + memory) / (1.0 - memory)


def _without_bias(covariance: NDArray[np.float64], tau: float) -> float:
    """Return how many values count as one, with the covariances about the mean of all records: about that of
    the values themselves they are smaller by its variance."""
    count = len(covariance)
    share = 1.0 - np.arange(count) / count
    for _ in range(_ROUNDS):
        within = min(tau, _MOST_CORRELATED * count)
        of_mean = covariance[0] * within / (count - within)
        tau = max(tau, _counting_as_one(covariance + of_mean * share))
    return tau


def error_of_root(squares: NDArray[np.float64], root: float, of_mean: MeanError | None = None) -> MeanError:
    """Return the error of the root mean square `root` of squares, shape (n,), one for each period, whose mean
    has the error `of_mean`, by default that of a series.

    A mean square that is low by chance has squares that scatter little: the uncertainty is that of a mean
    square an experimental standard uncertainty above. There the variance of the squares is larger by their
    skewness times that uncertainty over their deviation. Gamma distributed ones, whose scatter grows as their
    mean does, have a skewness of twice their deviation over their mean, and the error over the uncertainty an
    rms of 0.8 to 1.1; where few of them hold much, as clicks in a ripple do, they show more.
    """
    error = of_mean or error_of_series(squares)
    if not root > 0.0:
        return replace(error, standard=0.0 * error.standard)
    deviation = float(np.std(squares))
    grows = 0.0
    if deviation > 0.0:
        seen = float(np.mean(((squares - np.mean(squares)) / deviation) ** 3))
        skewness = max(seen, 2.0 * deviation / root**2)
        # a mean that wanders more slowly than the record is off by more than its values differ
        grows = skewness * min(1.0, error.experimental / deviation)
    return replace(error, standard=error.standard / (2.0 * root) * (1.0 + 0.5 * grows))


def error_of_record(samples: NDArray[np.float64], beside: Sequence[NDArray[np.float64]] = ()) -> MeanError:
    """Return the error of the mean of samples, shape (n,), at equal times, by the means of up to 64 parts, or
    by the lowest frequencies where these hold much less, of which others `beside` with the same noise tell
    too.

    An oscillation of which they hold no whole cycles moves the mean by where it begins. The lowest
    frequencies show that, but as little as it does so in the mean itself. Where it is as slow as these, it is
    nearly all that the parts do, and no noise that rises towards zero frequency.
    """
    parts = means_of_parts(samples)
    by_parts = error_of_series(parts)
    if len(parts) and not math.isfinite(by_parts.standard):
        by_parts = _without_aliases(samples, parts, by_parts)
    error = at_lowest_frequencies(samples, by_parts, beside=beside)
    if error.basis is Basis.LOWEST:
        return replace(error, standard=max(error.standard, mean_moved_by_oscillations(samples, _LOWEST)))
    swing = slow_swing(parts)
    noise = MeanError(math.nan, math.nan) if swing is None else error_of_series(swing.rest)
    if swing is None or not math.isfinite(noise.standard):
        return error
    return replace(noise, standard=math.hypot(noise.standard, swing.moved))


def mean_of_periods(values: NDArray[np.float64]) -> tuple[float, MeanError]:
    """Return the mean of values, shape (n,), one for each period, and its error: of those that swing slowly
    the mean about the swing, and the error by what is left of it."""
    swing = slow_swing(values)
    if swing is None:
        return float(np.mean(values)), error_of_periods(values)
    error = error_of_periods(swing.rest)
    return swing.mean, replace(error, standard=swing.of_mean * error.standard)


def error_of_periods(values: NDArray[np.float64], least: int = _FEWEST_OF_A_MEMORY) -> MeanError:
    """Return the error of the mean of values, shape (n,), one for each period, with a memory of some.

    That of a series or, where so few of them are independent that their correlation is hardly known, that by
    their density at the lowest frequencies, continued, if it is larger. To refuse the series whose memory
    shows would leave those in which it does not, whose errors are the larger ones: it is nan only of fewer
    than `least` values.
    """
    error = error_of_series(values)
    is_known = math.isfinite(error.standard)
    if (is_known and error.dof > _FEW_INDEPENDENT) or (not is_known and len(values) < least):
        return error
    slow = slow_noise(values)
    if slow is None or (is_known and slow.standard <= error.standard):
        return error
    return MeanError(slow.standard, slow.dof, Basis.CONTINUED)


def at_lowest_frequencies(
    samples: NDArray[np.float64],
    by_parts: MeanError,
    marks: NDArray[np.float64] | None = None,
    *,
    beside: Sequence[NDArray[np.float64]] = (),
    reference: NDArray[np.float64] | None = None,
    pooled: bool = False,
    may_fall: bool = False,
) -> MeanError:
    """Return the error of the mean of samples, shape (n,), at equal times: that by parts of them, less what
    the parts cut out of oscillations, or that by noise whose density rises towards zero frequency.

    The variance of a mean of n is the density at zero frequency over n. Parts that are no whole periods of a
    ripple differ by it, and the mean of all does not: then the density at the lowest five frequencies of the
    record is far below what the parts say, by a fifth once in two hundred records by chance. Where the
    density rises below the lowest frequency of the record (`slow_noise`) and gives clearly more than the
    parts, it stands for them; where it rises more steeply than that of 1/f noise, the error is unknown (nan).

    `marks`, shape (periods + 1,), are the sample numbers between which something repeats, if it does, of
    which the last may be in the last row. The scatter of few parts is `pooled` with the density where both
    agree. Of a signal that a control may keep at its mean (`may_fall`), a density that falls towards zero
    frequency counts by its probability. A `reference` of shape (n,) tells the density too where the samples
    follow it.
    """
    if not math.isfinite(by_parts.standard):
        parts = means_of_parts(samples)
        if not len(parts):
            return by_parts
        by_parts = error_of_series(parts)
    periods = 0 if marks is None else len(marks) - 1
    values = means_of_blocks(samples, marks)
    by_parts = without_oscillations(values, by_parts)
    blocks = [means_of_blocks(each, None, max(1, len(each) * len(values) // len(samples))) for each in beside]
    followed = None if reference is None else means_of_blocks(reference, marks)
    if followed is not None and not _follows(values, followed):
        followed = None
    slow = slow_noise(values, periods, blocks, followed)
    if slow is not None and not may_fall:
        slow = replace(slow, falls=0.0)
    known = followed is not None
    error = _of_density(values, by_parts, slow, periods, pooled=pooled, known=known)
    if slow is None or not slow.falls > 0.0 or not math.isfinite(error.standard):
        return error
    falling2 = slow.of_falling**2
    if not falling2 < error.standard**2:
        return error
    standard = math.sqrt(slow.falls * falling2 + (1.0 - slow.falls) * error.standard**2)
    return replace(error, standard=standard)


def _follows(values: NDArray[np.float64], reference: NDArray[np.float64]) -> bool:
    """Return whether values have less at their lowest frequencies without a reference, both of shape (n,)."""
    lowest = slice(1, _LOWEST + 1)
    whole, rest = (fft.rfft(each - np.mean(each))[lowest] for each in (values, values - reference))
    return bool(np.sum(np.abs(rest) ** 2) < np.sum(np.abs(whole) ** 2))


def _of_density(
    values: NDArray[np.float64],
    by_parts: MeanError,
    slow: SlowNoise | None,
    periods: int,
    *,
    pooled: bool,
    known: bool,
) -> MeanError:
    """Return that of a density that does not fall towards zero frequency."""
    # the scatter of few parts is itself so uncertain that it does not speak against more
    clearly = _CLEARLY_MORE if by_parts.dof > _FEW_PARTS and not known else 1.0
    if slow is None or slow.standard < clearly * by_parts.standard:
        return _of_both(by_parts, slow) if slow is not None and pooled else by_parts
    if slow.standard < _ROUNDING * float(np.max(np.abs(values))):
        return by_parts
    if not known and (lowest := _where_none_rises(values, periods)) is not None:
        return max(by_parts, lowest, key=lambda each: each.standard)
    # what is asked of a signal does not go on to rise for ever: a control sees to it
    is_lost = slow.is_lost and not known
    return MeanError(math.nan if is_lost else slow.standard, slow.dof, Basis.CONTINUED)


def _of_both(by_parts: MeanError, slow: SlowNoise) -> MeanError:
    """Return the error by the scatter of few periods and by the density at the lowest frequencies, pooled
    where that does not rise and the scatter is not more: far more values tell the density than there are
    periods."""
    if by_parts.dof > _FEW_PARTS or slow.rise > _RISES:
        return by_parts
    own2, of_density2 = by_parts.experimental**2, slow.standard**2
    dof = _DOF_OF_LOWEST
    if not of_density2 > 0.0 or fisher_above(by_parts.dof, dof, own2 / of_density2) < _MORE:
        return by_parts
    both = by_parts.dof + dof
    pooled2 = (by_parts.dof * own2 + dof * of_density2) / both
    return MeanError.of_scatter(math.sqrt(pooled2), both, Basis.POOLED)


def _where_none_rises(values: NDArray[np.float64], periods: int) -> MeanError | None:
    """Return the error of the mean by the five lowest frequencies of values, shape (n,), where the next
    twenty-five, below the first harmonic of `periods`, have more; None where they do not.

    A density that falls towards zero frequency, as beside a ripple that scatters, is not continued upwards.
    """
    last = min(_MOST_OF_NEXT, periods - 1 if periods else _MOST_OF_NEXT)
    if last < _FEWEST_OF_LOWEST * _LOWEST or len(values) < 2 * last:
        return None
    bins = fft.rfft(values - np.mean(values))[1 : last + 1] / len(values)
    power = bins.real**2 + bins.imag**2
    if float(np.mean(power[:_LOWEST])) > float(np.mean(power[_LOWEST:])):
        return None
    return _by_lowest(float(np.mean(power[:_LOWEST])))


def _by_lowest(power: float) -> MeanError:
    """Return the error of a mean by the mean power of the lowest bins."""
    return MeanError.of_scatter(math.sqrt(power), _DOF_OF_LOWEST, Basis.LOWEST)


def means_of_blocks(
    samples: NDArray[np.float64], marks: NDArray[np.float64] | None = None, blocks: int = BLOCKS
) -> NDArray[np.float64]:
    """Return the means of up to so many blocks of samples, shape (n,): at the edges of blocks a part of a
    sample. All are equal, and all samples count, or where something repeats between `marks`, shape
    (periods + 1,), as many are equal parts of each period: what repeats is lines then, be its pace what
    it may, and its harmonics do not alias beside harmonics.
    """
    count = len(samples)
    marks = np.array([0.0, count]) if marks is None else marks
    even, periods = np.linspace(0.0, 1.0, len(marks)), len(marks) - 1
    if count <= blocks and np.allclose(marks, count * even, rtol=0.0, atol=_ROUNDING * count):
        return samples
    # over a part of a row more, harmonics leak beside themselves
    blocks = min(blocks, math.floor(marks[-1]))
    if periods <= blocks:
        blocks -= blocks % periods
    edges = np.interp(np.linspace(0.0, 1.0, blocks + 1), even, marks)
    sums = np.concatenate([[0.0], np.cumsum(samples - np.mean(samples))])
    within = np.diff(np.interp(edges, np.arange(count + 1), sums))
    return np.asarray(np.mean(samples) + within / np.diff(edges))


def without_oscillations(values: NDArray[np.float64], by_parts: MeanError) -> MeanError:
    """Return the error of the mean by the lowest frequencies of values, shape (n,), where it is clearly
    less."""
    if len(values) < _FEWEST_OF_LOWEST * _LOWEST or not by_parts.standard > 0.0:
        return by_parts
    bins = fft.rfft(values - np.mean(values))[1 : _LOWEST + 1] / len(values)
    power = float(np.mean(bins.real**2 + bins.imag**2))
    if _FAR_BELOW * power >= by_parts.experimental**2:
        return by_parts
    return _by_lowest(power)


def _without_aliases(
    samples: NDArray[np.float64], parts: NDArray[np.float64], by_parts: MeanError
) -> MeanError:
    """Return the error of the mean of samples, shape (n,), whose `parts` wander, by their lowest frequencies
    where these hold no such wander: an oscillation of nearly as many cycles as there are parts makes it."""
    power = float(np.mean(tapered_power(samples)[1 : _LOWEST + 1]))
    return by_parts if _CLEARLY_LESS * power >= float(np.var(parts)) / len(parts) else _by_lowest(power)


def means_of_parts(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the means of up to 64 equal parts of samples, shape (n,); none of fewer than 20 samples."""
    parts = min(_MOST_PARTS, len(samples) // 2)
    if parts < _PARTS:
        return np.empty(0)
    size = len(samples) // parts
    return np.asarray(np.mean(samples[: size * parts].reshape(parts, size), axis=1))
