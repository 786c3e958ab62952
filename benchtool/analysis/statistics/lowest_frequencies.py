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
from dataclasses import dataclass, replace as copied
from functools import lru_cache
from operator import mul
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.density_bands import FEWEST_BINS, SINGLE, Bands, Densities
from benchtool.analysis.statistics.falling_densities import falling_densities, noise_of_lags
from benchtool.analysis.uncertainty import COVERAGE

Floats = NDArray[np.float64]

_LOWEST = 1.0 / 24.0  # cycles in the record: noise that rises as 1/f or more does so no further below that
_EXPONENTS = np.array([0.3, 0.6, 1.0, 1.5, 2.0])  # of the density's fall with frequency
_CORNERS = _LOWEST * 2.0 ** np.arange(17)  # cycles in the record, below which the density is flat
_FLOORS = 2.0 ** np.arange(0.0, 12.0, 1.5)  # cycles in the record, above which white noise hides the fall
_FALLS = 0.2  # probability before the record is seen that the density falls towards zero
_OF_A_LAG = 0.1  # likewise that it is level below such a corner as half of those that fall have a crest
_NEAR_ZERO = 32.0  # cycles in the record, and below the first harmonic: a ripple's density rises above
_WHITE = 0.7  # probability before the record is seen of white noise, or of such from period to period
_SCALELESS = 0.5  # probability that such a density has no corner
_WHITE_HELD = 0.4  # likewise of what a control makes
_HELD_FROM = 0.08  # cycles in the record, below which that has no corner
_MOST_OF_A_BAND = 6.0  # bins that a band counts as: the models do not hold more exactly than that
_ENOUGH_PERIODS = 24
_LEAST_TOLD = 1e-6  # of a bin: none at all has no likelihood
_ABOVE_PERIODS = 1.0  # likewise, where what differs from period to period has a density of its own
_LAST_OF_FIRST, _BESIDE = 0.75, 0.75  # of the distance between harmonics; sin^2 beside them
_LOST = 4.5  # octaves by which the density rises below the lowest bin: 1/f noise does by 4.1 at most
_WEIGHTLESS = 1e-4  # of all models
_MOST_LIKELY = 600.0  # of a logarithm of odds
_ELSEWHERE = 3.0  # standard deviations of the logarithm of a size
_KEPT = 16  # places of bands for which all models are kept
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
        return (1.0 - self.falls) * self.rise > _LOST


def slow_noise(
    samples: Floats, periods: int = 0, beside: Sequence[Floats] = (), reference: Floats | None = None
) -> SlowNoise | None:
    """Return the error of the mean of samples, shape (n,), at equal times; None of too few.

    `periods` are the whole periods that the samples hold of what repeats, whose harmonics are left out. Where
    nothing repeats, samples `beside` of the same noise, be they of any level and size, tell its density too.
    So does a `reference` at the same times that the samples follow: their slow noise is its, of any size, and
    what hides it from some frequency on is another's.
    """
    bands = _of_periods(samples, periods)
    if bands is None:
        return None
    others = [_Beside.of(each, len(samples), bands.place[-1]) for each in beside]
    followed = None if reference is None else _Reference.of(reference, periods, bands.place[-1])
    told = bands if reference is None or followed is None else _apart(bands, samples - reference, periods)
    return _averaged(bands, told, periods, [each for each in others if each], followed)


def _of_periods(samples: Floats, periods: int) -> Bands | None:
    """Return the bands of samples, shape (n,), counting as the models hold of what repeats or does not."""
    bands = Bands.of(samples, periods)
    if bands is None:
        return None
    most = np.full(len(bands.place), _MOST_OF_A_BAND)
    if periods >= _ENOUGH_PERIODS:
        most[bands.place > periods // 2] = _ABOVE_PERIODS
    return bands.counting(most)


def _apart(bands: Bands, rest: Floats, periods: int) -> Bands:
    """Return the bands of a signal counting as what in them is the `rest` without its reference, of shape
    (n,): what is in both is one observation, and no two."""
    alone = _of_periods(rest, periods)
    power: Floats | float = 0.0
    if alone is not None:
        power = np.interp(bands.place, alone.place, alone.power, right=math.inf)
    return bands.counting(bands.count * np.clip(power / bands.power, _LEAST_TOLD, 1.0))


def continued_power(samples: Floats, periods: int, told_from: float, places: Floats) -> Floats | None:
    """Return the power of the noise of samples, shape (n,), in a bin at places in cycles in the record, shape
    (places,), by the densities that describe the bins from `told_from` on; None of too few.

    What repeats in `periods` whole periods is left out, as is what was fitted to the bins below.
    """
    bands = _of_periods(samples, periods)
    if bands is None:
        return None
    bands = bands.only(bands.place >= told_from)
    if np.sum(bands.count) < FEWEST_BINS:
        return None
    usable, floors = _usable(bands.place[-1])
    white = np.ones((1, len(bands.place)))
    densities = Densities(np.vstack([_shapes(_blurred(bands.place), usable, floors), white]))
    sought = np.vstack([_shapes(_density(places), usable, floors), np.ones((1, len(places)))])
    prior = _prior(int(np.count_nonzero(usable)), len(floors))[: -1 - len(floors)]
    fits = bands.fits(densities)
    weight = np.append(prior, _WHITE) * np.exp(fits - np.max(fits))
    return np.asarray((weight * bands.sizes(densities)) @ sought / np.sum(weight))


def walk_probability(pieces: Sequence[Floats]) -> float | None:
    """Return how probable it is that noise wanders as a random walk does: that its density rises more steeply
    than that of 1/f noise, and down to the lowest frequency that the longest of `pieces`, each of shape (n,)
    and of any level and size, shows; None of too few samples.

    Each piece alone shows few of the lowest frequencies; all are of one density.
    """
    pieces = sorted(pieces, key=len, reverse=True)
    longest = len(pieces[0])
    bands = [Bands.of(each) for each in pieces]
    found = [each for each in bands if each is not None]
    if not found or len(found) < len(pieces):
        return None
    usable, floors = _usable(found[0].place[-1])
    prior = _prior(int(np.count_nonzero(usable)), len(floors))[: -1 - len(floors)]
    log_weight = np.log(np.append(prior, _WHITE))
    for each, piece in zip(found, pieces, strict=True):
        place = each.place
        falling = _blurred(place) if len(piece) == longest else _density(place * longest / len(piece))
        shape = np.vstack([_shapes(falling, usable, floors), np.ones(len(place))])
        log_weight += each.counting(_MOST_OF_A_BAND).fits(Densities(shape))
    weight = np.exp(log_weight - np.max(log_weight))
    of_models = weight[:-1].reshape(len(_EXPONENTS), -1, len(floors))
    steep, low = _EXPONENTS > 1.0, _CORNERS[usable] <= 1.0
    return float(np.sum(of_models[steep][:, low]) / np.sum(weight))


@dataclass(frozen=True)
class _Beside:
    """Bands of a record that is `ratio` times as long as the one whose mean is looked for."""

    bands: Bands
    ratio: float

    @classmethod
    def of(cls, samples: Floats, length: int, known: float) -> _Beside | None:
        """Return those of samples, shape (n,), beside so many others, up to the place that these show; None
        of too few."""
        bands, ratio = Bands.of(samples), len(samples) / length
        if bands is None:
            return None
        bands = bands.only(bands.place <= known * ratio)
        if np.sum(bands.count) < FEWEST_BINS:
            return None
        return cls(bands.counting(_MOST_OF_A_BAND), ratio)

    def fits(self, usable: NDArray[np.bool_], floors: Floats, white: int) -> Floats:
        """Return the logarithms of the likelihoods of all usable models, and of so many that are white."""
        place = self.bands.place
        rising = _shapes(_blurred(place, self.ratio), usable, floors)
        return self.bands.fits(Densities(np.vstack([rising, np.ones((white, len(place)))])))


@dataclass(frozen=True)
class _Reference:
    """Bands of what a signal follows over its record, with as many `periods`; the white noise that hides its
    slow noise is not that of the signal."""

    bands: Bands
    periods: int

    @classmethod
    def of(cls, samples: Floats, periods: int, known: float) -> _Reference | None:
        """Return those of samples, shape (n,), up to the place that the signal shows; None of too few."""
        bands = _of_periods(samples, periods)
        if bands is None:
            return None
        bands = bands.only(bands.place <= known)
        return cls(bands, periods) if np.sum(bands.count) >= FEWEST_BINS else None

    def near_zero(self) -> _Reference:
        """Return it with the bands that tell whether a density falls."""
        return copied(self, bands=self.bands.only(_near_zero(self.bands.place, self.periods)))

    def fits(self, usable: NDArray[np.bool_], floors: Floats, steady: int) -> Floats:
        """Return the logarithms of the likelihoods of all usable models, each with any of the floors, and of
        so many that are steady."""
        place = self.bands.place
        shape = _shapes(_blurred(place), usable, floors)
        rising = self.bands.fits(Densities(shape)).reshape(-1, len(floors))
        white, *of_periods = self.bands.fits(Densities(_steady(place, floors, self.periods)[:, 1:]))
        either = _log_mean(np.array([white, _log_mean(np.array(of_periods))]))
        return np.concatenate([np.repeat(_log_mean(rising), len(floors)), np.full(steady, either)])

    def fits_of_falling(self) -> Floats:
        """Return those of densities that fall, each with any white noise, shape (densities,)."""
        falling, of_mean, _ = falling_densities(self.bands.place.tobytes())
        return _log_mean(self.bands.fits(falling).reshape(of_mean.shape))

    def fits_of_lags(self) -> Floats:
        """Return those of first-order lags, each with any white noise, shape (corners,)."""
        lags, levels = noise_of_lags(self.bands.place.tobytes())
        return _log_mean(self.bands.fits(lags).reshape(-1, levels))


@dataclass(frozen=True)
class _Models:
    """What densities of noise make of the lowest `SINGLE` bins, shape (exponents, corners, bins), and of the
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
    bins = np.arange(SINGLE + 1)[:, np.newaxis]
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
    bands: Bands, told: Bands, periods: int, beside: Sequence[_Beside], reference: _Reference | None
) -> SlowNoise:
    """Return the error by all models, each of any size, with the weight that the bands give it, counting as
    `told`, those of records beside it, and those of a reference."""
    place, models = bands.place, _candidates(bands.place.tobytes(), periods)
    usable, floors, steady = models.usable, models.floors, len(models.floors) + 1
    prior = models.prior if reference is None else models.prior_held
    fits = told.fits(models.densities)
    for each in beside:
        fits += each.fits(usable, floors, steady)
    if reference is not None:
        fits += reference.fits(usable, floors, steady)
    weight = prior * np.exp(fits - np.max(fits))
    weight /= np.sum(weight)
    size2 = _size2(models.densities, bands)
    if periods:  # levels of periods show below the first harmonic, as their means do
        levels = slice(-len(floors), None)
        below = place < periods
        of_levels = Densities(models.densities.shape[levels][:, below])
        size2[levels] = np.sqrt(size2[levels] * bands.only(below).sizes(of_levels))
    near = _near_zero(place, periods)
    bands, told = bands.only(near), told.only(near)
    fits = told.fits(models.near_zero)
    if reference is not None:
        reference = reference.near_zero()
        fits += reference.fits(usable, floors, steady)
    return SlowNoise(
        _half_width(weight, np.sqrt(models.of_mean * size2)) / _K,
        _DOF,
        float(np.sum(weight * models.rise)),
        *_of_falling(bands, told, float(_log_mean(fits, prior)), reference),
    )


@dataclass(frozen=True)
class _Candidates:
    """All models at the places of the bands of a record, the steady ones last: their `densities`, also at
    those `near_zero` alone; the variance of the mean `of_mean` that each makes, the octaves by which it has
    a `rise` below the record, and its `prior` probability, or `prior_held` where a control makes the noise,
    shape (models,)."""

    usable: NDArray[np.bool_]
    floors: Floats
    densities: Densities
    near_zero: Densities
    of_mean: Floats
    rise: Floats
    prior: Floats
    prior_held: Floats


@lru_cache(maxsize=_KEPT)
def _candidates(places: bytes, periods: int) -> _Candidates:
    """Return the models at places, floats, in a record of so many periods: many records have the same."""
    place = np.frombuffer(places)
    usable, floors = _usable(place[-1])
    level = _levels(usable, floors)
    of_mean = (_models().of_mean[:, usable, np.newaxis] + level).ravel()
    low, one = _density(np.array([_LOWEST])), _density(np.array([1.0]))
    rise = np.log2((low[:, usable] + level) / (one[:, usable] + level)).ravel()
    steady = _steady(place, floors, periods)
    densities = Densities(np.vstack([_shapes(_blurred(place), usable, floors), steady[:, 1:]]))
    corners = int(np.count_nonzero(usable))
    return _Candidates(
        usable,
        floors,
        densities,
        densities.only(_near_zero(place, periods)),
        np.append(of_mean, steady[:, 0]),
        np.append(rise, np.zeros(len(steady))),
        _prior(corners, len(floors)),
        _prior(corners, len(floors), held=True),
    )


def _of_falling(
    bands: Bands, told: Bands, others: float, reference: _Reference | None
) -> tuple[float, float]:
    """Return the probability that a density falls towards zero frequency, by bands counting as `told` and the
    logarithm of the likelihood of the `others`, and the standard deviation of the mean if it does.

    A crest is no sign of it: only what is below it tells that from the noise of a lag.
    """
    falling, of_mean, of_kind = falling_densities(bands.place.tobytes())
    levels = of_mean.shape[1]
    fits, prior = told.fits(falling), np.repeat(of_kind, levels) / levels
    if reference is not None:
        fits += np.repeat(reference.fits_of_falling(), levels)
    lags, of_lag = noise_of_lags(bands.place.tobytes())
    of_lags = told.fits(lags)
    if reference is not None:
        of_lags += np.repeat(reference.fits_of_lags(), of_lag)
    both = np.array([others, float(_log_mean(of_lags))])
    others = float(_log_mean(both, np.array([1.0 - _FALLS - _OF_A_LAG, _OF_A_LAG])))
    odds = _FALLS * math.exp(min(float(_log_mean(fits, prior)) - others, _MOST_LIKELY))
    weight = prior * np.exp(fits - np.max(fits))
    square = of_mean.ravel() * bands.sizes(falling)
    return odds / (1.0 + odds), math.sqrt(float(weight @ square) / float(np.sum(weight)))


def _near_zero(place: Floats, periods: int) -> NDArray[np.bool_]:
    """Return which places tell whether a density falls: a ripple's own rises above."""
    return np.asarray(place < min(_NEAR_ZERO, periods or _NEAR_ZERO))


def _log_mean(fits: Floats, weight: Floats | float = 1.0) -> Floats:
    """Return the logarithm of the mean of likelihoods over the last axis, from their logarithms, or of their
    sum with weights."""
    most = np.max(fits, axis=-1, keepdims=True)
    part = np.exp(fits - most) * weight
    mean = np.mean(part, axis=-1) if np.ndim(weight) == 0 else np.sum(part, axis=-1)
    return np.asarray(np.log(mean) + most[..., 0])


def _size2(densities: Densities, bands: Bands) -> Floats:
    """Return the mean of the posterior of the size of densities, shape (models,): of a model that fits above,
    and in the lowest bins clearly does not, the geometric mean of what all tell and what these do, of which
    neither is right."""
    by_all, low, count = bands.sizes(densities), bands.place <= SINGLE, bands.count
    if not 0 < np.count_nonzero(low) < len(low) or np.sum(count[low]) < FEWEST_BINS:
        return by_all
    by_low, by_rest = (bands.only(each).sizes(densities.only(each)) for each in (low, ~low))
    standard = math.sqrt(1.0 / float(np.sum(count[low])) + 1.0 / float(np.sum(count[~low])))
    differs = np.abs(np.log(by_low / by_rest)) > _ELSEWHERE * standard
    return np.where(differs, np.sqrt(by_low * by_all), by_all)


def _usable(known: float) -> tuple[NDArray[np.bool_], Floats]:
    """Return which corners are of use where the highest place that is `known` is so many cycles, and the
    floors, of which the first is none."""
    usable = known > _CORNERS
    usable[0] = True
    return usable, np.concatenate([[math.inf], _FLOORS[known > _FLOORS]])


def _blurred(place: Floats, ratio: float = 1.0) -> Floats:
    """Return the densities at places in a record that is `ratio` times as long as that of the models, the
    lowest of which it blurs, shape (exponents, corners, places)."""
    falling, single = _density(place / ratio), int(np.count_nonzero(place <= SINGLE))
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
    shares = weight.tolist()
    slope = 2.0 / math.sqrt(math.pi) * weight / scale
    half = _OF_COVERAGE / float(weight @ (1.0 / scale))  # not more, as erf is concave
    for _ in range(_STEPS):  # from below, as what lies within rises ever more slowly
        relative = half / scale
        within = sum(map(mul, shares, map(math.erf, relative.tolist())))
        step = (COVERAGE - within) / float(np.sum(slope * np.exp(-(relative**2))))
        half += step
        if step < _STEP * half:
            break
    return half


def _prior(corners: int, floors: int, *, held: bool = False) -> Floats:
    """Return the probabilities of all models before a record is seen, the steady ones last.

    Most of what falls more slowly than a first-order lag has no corner: 1/f noise. The noise of a signal that
    is `held` by a control has one, within its bandwidth, which a record of a steady state shows.
    """
    is_within = _CORNERS[:corners] >= _HELD_FROM if held else np.ones(corners, dtype=np.bool_)
    of_corners = np.tile(is_within / np.count_nonzero(is_within), (len(_EXPONENTS), 1))
    if corners > 1 and not held:
        of_corners[:-1] *= 1.0 - _SCALELESS
        of_corners[:-1, 0] += _SCALELESS
    each = np.repeat(of_corners.ravel() / len(_EXPONENTS), floors) / floors
    white = _WHITE_HELD if held else _WHITE
    of_periods = np.full(floors, 0.5 * white / floors)
    return np.concatenate([(1.0 - white) * each, [0.5 * white], of_periods])
