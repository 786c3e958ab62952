"""Error of a mean by the spectrum at the lowest frequencies of a record, continued to zero frequency.

The variance of a mean over T is the density of the noise about zero frequency over T. Where the density rises
towards zero, as that of 1/f noise or of a slow drift does, the record shows only the part above 1/T: what is
below is continued by models of the density, each weighted by how well it describes what is seen (Whittle's
likelihood: Beran, Statistics for Long-Memory Processes, 1994, ch. 6; model averaging: Hoeting et al.,
Statistical Science 14 (1999) 382).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.uncertainty import COVERAGE

Floats = NDArray[np.float64]

_LOWEST = 1.0 / 24.0  # cycles in the record: noise that rises as 1/f or more does so no further below that
_EXPONENTS = np.array([0.3, 0.6, 1.0, 1.5, 2.0])  # of the density's fall with frequency
_CORNERS = _LOWEST * 2.0 ** np.arange(17)  # cycles in the record, below which the density is flat
_FLOORS = 2.0 ** np.arange(0.0, 12.0, 1.5)  # cycles in the record, above which white noise hides the fall
_FALLS = 0.1  # probability before the record is seen that the density falls towards zero
_NEAR_ZERO = 32.0  # cycles in the record, and below the first harmonic: a ripple's density rises above
_FALL_CORNERS = 2.0 ** np.arange(0.0, 12.0)  # cycles in the record, above which such a density is flat
_LEVELS = np.array([0.0, 2.0**-6, 2.0**-4, 2.0**-2])  # of the flat part, of white noise beside it
_WHITE = 0.7  # probability before the record is seen of white noise, or of such from period to period
_SCALELESS = 0.5  # probability that such a density has no corner
_SINGLE = 8  # bins that count by themselves
_BANDS_PER_OCTAVE = 3.0
_MOST_OF_A_BAND = 6.0  # bins that a band counts as: the models do not hold more exactly than that
_ENOUGH_PERIODS = 24
_ABOVE_PERIODS = 1.0  # likewise, where what differs from period to period has a density of its own
_FEWEST = 5  # bins
_RISES = 1e-6  # probability that white noise rises as much within two octaves
_LAST_OF_FIRST, _BESIDE = 0.75, 0.75  # of the distance between harmonics; sin^2 beside them
_NEAR_HARMONIC = 0.2  # of the distance between harmonics
_LOST = 4.5  # octaves by which the density rises below the lowest bin: 1/f noise does by 4.1 at most
_WEIGHTLESS = 1e-4  # of all models
_ELSEWHERE = 3.0  # standard deviations of the logarithm of a size
_STEPS = 50  # of Newton's method, of which some four are taken
_STEP = 1e-10
_OF_COVERAGE = NormalDist().inv_cdf(0.5 + 0.5 * COVERAGE) / math.sqrt(2.0)  # where erf is the coverage
_K, _DOF = 2.0, 60.0  # of Student's distribution, for 95 %


@dataclass(frozen=True)
class SlowNoise:
    """Standard deviation of a mean by the noise's spectrum, its degrees of freedom, and the octaves by which
    the density is expected to rise below the lowest frequency of the record.

    All of it is by densities that do not fall towards zero frequency. That they do, as under a control with
    an integral, which leaves a mean no noise but at the ends of the record, has the probability `falls`; the
    mean then has the standard deviation `of_falling`.
    """

    standard: float
    dof: float
    rise: float
    falls: float = 0.0
    of_falling: float = 0.0

    @property
    def is_lost(self) -> bool:
        """Whether the density rises so far beyond what the record shows that its mean is not known."""
        return self.rise > _LOST


def slow_noise(samples: Floats, periods: int = 0, beside: Sequence[Floats] = ()) -> SlowNoise | None:
    """Return the error of the mean of samples, shape (n,), at equal times; None of too few.

    `periods` are the whole periods that the samples hold of what repeats, whose harmonics are left out. Where
    nothing repeats, samples `beside` of the same noise, be they of any level and size, tell its density too.
    """
    found = _bands(samples, periods)
    if found is None:
        return None
    place, mean, width = found
    most = np.full(len(place), _MOST_OF_A_BAND)
    if periods >= _ENOUGH_PERIODS:
        most[place > periods // 2] = _ABOVE_PERIODS
    others = [_Beside.of(each, len(samples), place[-1]) for each in beside]
    return _averaged(place, mean, np.minimum(width, most), periods, [each for each in others if each])


def walk_probability(pieces: Sequence[Floats]) -> float | None:
    """Return how probable it is that noise wanders as a random walk does: that its density rises more steeply
    than that of 1/f noise, and down to the lowest frequency that the longest of `pieces`, each of shape (n,)
    and of any level and size, shows; None of too few samples.

    Each piece alone shows few of the lowest frequencies; all are of one density.
    """
    pieces = sorted(pieces, key=len, reverse=True)
    longest = len(pieces[0])
    bands = [_bands(each, 0) for each in pieces]
    found = [each for each in bands if each is not None]
    if not found or len(found) < len(pieces):
        return None
    usable, floors = _usable(found[0][0][-1])
    prior = _prior(int(np.count_nonzero(usable)), len(floors))[: -1 - len(floors)]
    log_weight = np.log(np.append(prior, _WHITE))
    for (place, mean, width), piece in zip(found, pieces, strict=True):
        falling = _blurred(place) if len(piece) == longest else _density(place * longest / len(piece))
        shape = np.vstack([_shapes(falling, usable, floors), np.ones(len(place))])
        log_weight += _fits(shape, mean, np.minimum(width, _MOST_OF_A_BAND))
    weight = np.exp(log_weight - np.max(log_weight))
    of_models = weight[:-1].reshape(len(_EXPONENTS), -1, len(floors))
    steep, low = _EXPONENTS > 1.0, _CORNERS[usable] <= 1.0
    return float(np.sum(of_models[steep][:, low]) / np.sum(weight))


def _bands(samples: Floats, periods: int) -> tuple[Floats, Floats, Floats] | None:
    """Return place, mean power and number of bins of the bands of samples, shape (n,), up to where the
    density clearly rises; None of too few."""
    count = len(samples)
    if count < 2 * _FEWEST:
        return None
    bins = fft.rfft(samples - np.mean(samples))[1 : (count - 1) // 2 + 1] / count
    number = np.arange(1, len(bins) + 1)
    power = bins.real**2 + bins.imag**2
    if periods:
        away = np.abs(number - periods * np.round(number / periods))
        kept = (away >= max(1.0, _NEAR_HARMONIC * periods)) | (number < periods)
        kept &= away > 0
        number, power = number[kept], power[kept]
    if len(number) < _FEWEST or not np.all(power > 0.0):
        return None
    place, mean, width = _banded(number.astype(np.float64), power)
    last = _before_a_rise(place, mean, width)
    if np.sum(width[:last]) < _FEWEST:
        return None
    return place[:last], mean[:last], width[:last]


def _banded(number: Floats, power: Floats) -> tuple[Floats, Floats, Floats]:
    """Return place, mean power and number of bins of bands: the lowest bins each, then parts of octaves.

    The mean is from the median of a band where that is less: single lines are no noise.
    """
    band = np.where(
        number <= _SINGLE, number, _SINGLE + 1.0 + np.floor(_BANDS_PER_OCTAVE * np.log2(number / _SINGLE))
    )
    first = np.flatnonzero(np.diff(band, prepend=0.0))
    count = np.diff(first, append=len(number)).astype(np.float64)
    place = np.exp(np.add.reduceat(np.log(number), first) / count)
    mean = np.add.reduceat(power, first) / count
    for at in np.flatnonzero(count >= _SINGLE):
        within = power[first[at] : first[at] + int(count[at])]
        mean[at] = min(mean[at], float(np.median(within)) / math.log(2.0))
    return place, mean, count


def _before_a_rise(place: Floats, mean: Floats, count: Floats) -> int:
    """Return how many bands are below the one from which on the density is clearly higher than before."""
    last = np.arange(2, len(place))
    first = np.searchsorted(place, 0.25 * place[last])
    first[first == last] = 0
    between = np.column_stack([first, last]).ravel()
    bins_below, power = (np.add.reduceat(each, between)[::2] for each in (count, mean * count))
    of_below = power / bins_below
    # no more than below is no rise, and the distribution takes time
    for at in np.flatnonzero((bins_below >= 2.0) & (mean[last] > of_below)):
        ratio = float(mean[last[at]] / of_below[at])
        if fisher_above(2.0 * float(count[last[at]]), 2.0 * float(bins_below[at]), ratio) < _RISES:
            return int(last[at])
    return len(place)


@dataclass(frozen=True)
class _Beside:
    """Bands of a record that is `ratio` times as long as the one whose mean is looked for: their places, mean
    power and number of bins, each of shape (bands,)."""

    place: Floats
    mean: Floats
    count: Floats
    ratio: float

    @classmethod
    def of(cls, samples: Floats, length: int, known: float) -> _Beside | None:
        """Return those of samples, shape (n,), beside so many others, up to the place that these show; None
        of too few."""
        bands, ratio = _bands(samples, 0), len(samples) / length
        if bands is None:
            return None
        kept = bands[0] <= known * ratio
        place, mean, width = (each[kept] for each in bands)
        if np.sum(width) < _FEWEST:
            return None
        return cls(place, mean, np.minimum(width, _MOST_OF_A_BAND), ratio)

    def fits(self, usable: NDArray[np.bool_], floors: Floats, white: int) -> Floats:
        """Return the logarithms of the likelihoods of all usable models, and of so many that are white."""
        rising = _shapes(_blurred(self.place, self.ratio), usable, floors)
        return _fits(np.vstack([rising, np.ones((white, len(self.place)))]), self.mean, self.count)


@dataclass(frozen=True)
class _Models:
    """What densities of noise make of the lowest `_SINGLE` bins, shape (exponents, corners, bins), and of the
    variance of the mean, shape (exponents, corners)."""

    in_bins: Floats
    of_mean: Floats


@lru_cache(maxsize=64)
def _models(ratio: float = 1.0) -> _Models:
    """Return the models as a record shows them that is `ratio` times as long as theirs, and blurs frequencies
    by a cycle of its own: sinc^2."""
    fine, coarse = np.arange(_LOWEST, 40.0, 0.02), np.geomspace(40.0, 4000.0, 400)
    place = np.concatenate([fine, coarse])
    density = _density(place)
    place *= ratio
    width = np.gradient(place)
    bins = np.arange(_SINGLE + 1)[:, np.newaxis]
    blurred = np.sinc(place - bins) ** 2 + np.sinc(place + bins) ** 2
    seen = density @ (blurred * width).T
    of_mean = seen[:, :, 0]
    # without a corner these have as much below any lowest frequency as a mean has of it
    finite = _EXPONENTS < 1.0
    of_mean[finite, 0] = [_of_power_law(each) for each in _EXPONENTS[finite]]
    return _Models(seen[:, :, 1:], of_mean)


def _of_power_law(exponent: float) -> float:
    """Return the variance of the mean by a density f^-a, 0 < a < 1, down to zero frequency: the integral of 2
    sinc^2(f) f^-a (Gradshteyn and Ryzhik, 3.823)."""
    falls = -math.gamma(-1.0 - exponent) * math.cos(0.5 * math.pi * (1.0 + exponent))
    return float(2.0 ** (1.0 + exponent) * math.pi ** (exponent - 1.0) * falls)


def _density(place: Floats) -> Floats:
    """Return the densities of all models, shape (exponents, corners, places)."""
    exponents, corners = _EXPONENTS[:, np.newaxis, np.newaxis], _CORNERS[:, np.newaxis]
    return np.asarray((place**2 + corners**2) ** (-0.5 * exponents))


def _averaged(
    place: Floats, mean: Floats, count: Floats, periods: int, beside: Sequence[_Beside]
) -> SlowNoise:
    """Return the error by all models, each of any size, with the weight that the bands give it, and those of
    records beside it."""
    usable, floors = _usable(place[-1])
    shape = _shapes(_blurred(place), usable, floors)
    level = _levels(usable, floors)
    of_mean = (_models().of_mean[:, usable, np.newaxis] + level).ravel()
    low, one = _density(np.array([_LOWEST])), _density(np.array([1.0]))
    rise = np.log2((low[:, usable] + level) / (one[:, usable] + level)).ravel()
    steady = _steady(place, floors, periods)
    shape = np.vstack([shape, steady[:, 1:]])
    of_mean, rise = np.append(of_mean, steady[:, 0]), np.append(rise, np.zeros(len(steady)))
    fits = _fits(shape, mean, count)
    for each in beside:
        fits += each.fits(usable, floors, len(steady))
    prior = _prior(int(np.count_nonzero(usable)), len(floors))
    weight = prior * np.exp(fits - np.max(fits))
    weight /= np.sum(weight)
    size2 = _size2(shape, mean * count, count, place <= _SINGLE)
    if periods:  # levels of periods show below the first harmonic, as their means do
        levels = slice(len(shape) - len(floors), None)
        below = place < periods
        size2[levels] = np.sqrt(size2[levels] * _posterior(shape[levels], mean * count, count, below))
    square = of_mean * size2
    falling, of_falling = _falling(place)
    near = place < min(_NEAR_ZERO, periods or _NEAR_ZERO)
    fits, own_fits = (_fits(each[:, near], mean[near], count[near]) for each in (shape, falling))
    # likelihoods of both kinds of density, each over its own models
    most = max(float(np.max(fits)), float(np.max(own_fits)))
    others, own = float(prior @ np.exp(fits - most)), np.exp(own_fits - most) / len(own_fits)
    falls = _FALLS * float(np.sum(own)) / (_FALLS * float(np.sum(own)) + (1.0 - _FALLS) * others)
    own_size2 = _posterior(falling, mean * count, count, near)
    own /= np.sum(own) if np.any(own > 0.0) else 1.0
    return SlowNoise(
        _half_width(weight, np.sqrt(square)) / _K,
        _DOF,
        float(np.sum(weight * rise)),
        falls,
        math.sqrt(float(own @ (of_falling * own_size2))),
    )


def _falling(place: Floats) -> tuple[Floats, Floats]:
    """Return the densities f^2 / (f^2 + c^2) of all corners c, each with white noise of some levels, at
    places in a record that blurs them, shape (models, places), and their variance of the mean, shape
    (models,).

    That of a first-order lag is the Fourier integral of (1 - |t|) exp(-2 pi c |t|) over the record.
    """
    at = np.append(0.0, place)
    corners = 2.0 * np.pi * _FALL_CORNERS[:, np.newaxis]
    z = corners + 2j * np.pi * at
    lag = corners * np.real(1.0 / z - (1.0 - np.exp(-corners)) / z**2)
    seen = ((1.0 - lag)[:, np.newaxis, :] + _LEVELS[:, np.newaxis]).reshape(-1, len(at))
    return seen[:, 1:], seen[:, 0]


def _size2(shape: Floats, power: Floats, count: Floats, low: NDArray[np.bool_]) -> Floats:
    """Return the mean of the posterior of the size of densities, shape (models,), of the `power` in bands of
    `count` bins, shape (bands,): of a model that fits above, and in the `low` bands clearly does not, the
    geometric mean of what all tell and what these do, of which neither is right."""
    by_all = _posterior(shape, power, count, np.ones(len(count), dtype=bool))
    if not 0 < np.count_nonzero(low) < len(low) or np.sum(count[low]) < _FEWEST:
        return by_all
    by_low, by_rest = (_posterior(shape, power, count, each) for each in (low, ~low))
    standard = math.sqrt(1.0 / float(np.sum(count[low])) + 1.0 / float(np.sum(count[~low])))
    differs = np.abs(np.log(by_low / by_rest)) > _ELSEWHERE * standard
    return np.where(differs, np.sqrt(by_low * by_all), by_all)


def _posterior(shape: Floats, power: Floats, count: Floats, taken: NDArray[np.bool_]) -> Floats:
    """Return the mean of the inverse Gamma distribution of each model's size, shape (models,), by the bands
    `taken`."""
    # einsum in place of a product of matrices, which would start threads
    scaled = np.einsum("ij,j->i", 1.0 / shape[:, taken], power[taken])
    return np.asarray(scaled / max(float(np.sum(count[taken])) - 1.0, 0.5))


def _usable(known: float) -> tuple[NDArray[np.bool_], Floats]:
    """Return which corners are of use where the highest place that is `known` is so many cycles, and the
    floors, of which the first is none."""
    usable = known > _CORNERS
    usable[0] = True
    return usable, np.concatenate([[math.inf], _FLOORS[known > _FLOORS]])


def _blurred(place: Floats, ratio: float = 1.0) -> Floats:
    """Return the densities at places in a record that is `ratio` times as long as that of the models, the
    lowest of which it blurs, shape (exponents, corners, places)."""
    falling, single = _density(place / ratio), int(np.count_nonzero(place <= _SINGLE))
    falling[:, :, :single] = _models(ratio).in_bins[:, :, np.round(place[:single]).astype(np.int64) - 1]
    return falling


def _levels(usable: NDArray[np.bool_], floors: Floats) -> Floats:
    """Return the white noise that hides densities above floors, shape (exponents, corners, floors)."""
    level = np.zeros((len(_EXPONENTS), int(np.count_nonzero(usable)), len(floors)))
    level[:, :, 1:] = _density(floors[1:])[:, usable]
    return level


def _shapes(falling: Floats, usable: NDArray[np.bool_], floors: Floats) -> Floats:
    """Return the densities of all models that are usable, each with each floor, shape (models, places)."""
    level = _levels(usable, floors)
    return (falling[:, usable, np.newaxis, :] + level[:, :, :, np.newaxis]).reshape(-1, falling.shape[-1])


def _fits(shape: Floats, mean: Floats, count: Floats) -> Floats:
    """Return the logarithms of the likelihoods of models, shape (models,), each of any size."""
    # its size is eliminated: 1 / size has a Gamma distribution
    # einsum in place of a product of matrices, which would start threads
    scaled = np.einsum("ij,j->i", 1.0 / shape, mean * count)
    fits = -np.einsum("ij,j->i", np.log(shape), count) - float(np.sum(count)) * np.log(scaled)
    return np.asarray(fits)


def _steady(place: Floats, floors: Floats, periods: int) -> Floats:
    """Return the densities that rise no further at zero frequency, then at all places: white noise, and what
    is the same within a period and another in each, with white noise above the floors; shape (1 + floors, 1 +
    places)."""
    at = np.append(0.0, place)
    of_periods = _of_steps(at / periods) if periods else np.ones(len(at))
    hidden = _of_steps(floors / max(1, periods))
    return np.vstack([np.ones(len(at)), of_periods + hidden[:, np.newaxis]])


def _of_steps(place: Floats) -> Floats:
    """Return the density of levels that differ from period to period, at places in harmonics: sinc^2, whose
    mean beside the harmonics is three quarters of that of its crests."""
    above = _BESIDE / (math.pi * np.maximum(place, _LAST_OF_FIRST)) ** 2
    return np.asarray(np.where(place < _LAST_OF_FIRST, np.sinc(np.minimum(place, 1.0)) ** 2, above))


def _half_width(weight: Floats, standard: Floats) -> float:
    """Return half of the interval that holds 95 % of a mixture of normal distributions about zero.

    Its standard deviation would be that of the steepest of the models, however little they weigh.
    """
    kept = weight > _WEIGHTLESS
    if not np.all(standard[kept] > 0.0):  # the level of all of them is that of no power
        return 0.0
    weight, scale = weight[kept] / np.sum(weight[kept]), math.sqrt(2.0) * standard[kept]
    mixture = list(zip(weight.tolist(), scale.tolist(), strict=True))
    slope = 2.0 / math.sqrt(math.pi) * weight / scale
    half = _OF_COVERAGE / float(weight @ (1.0 / scale))  # not more, as erf is concave
    for _ in range(_STEPS):  # from below, as what lies within rises ever more slowly
        within = sum(share * math.erf(half / each) for share, each in mixture)
        step = (COVERAGE - within) / float(np.sum(slope * np.exp(-((half / scale) ** 2))))
        half += step
        if step < _STEP * half:
            break
    return half


def _prior(corners: int, floors: int) -> Floats:
    """Return the probabilities of all models before a record is seen, the steady ones last.

    Most of what falls more slowly than a first-order lag has no corner: 1/f noise.
    """
    of_corners = np.full((len(_EXPONENTS), corners), 1.0 / corners)
    if corners > 1:
        of_corners[:-1] *= 1.0 - _SCALELESS
        of_corners[:-1, 0] += _SCALELESS
    each = np.repeat(of_corners.ravel() / len(_EXPONENTS), floors) / floors
    of_periods = np.full(floors, 0.5 * _WHITE / floors)
    return np.concatenate([(1.0 - _WHITE) * each, [0.5 * _WHITE], of_periods])
