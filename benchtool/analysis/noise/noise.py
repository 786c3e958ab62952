"""Noise between the harmonics of a spectrum: its floor, and that around each harmonic."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.distributions import median_of_exponentials
from benchtool.analysis.noise.noise_by_place import repetition_of_bins
from benchtool.analysis.noise.noise_over_time import ONE_LEVEL, NoiseOverTime, noise_over_time
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS, median, medians
from benchtool.analysis.statistics.scatter import MeanError

FEWEST_BINS = 8
"""Fewest bins between harmonics that tell a noise."""

_LOCAL_BINS = 20  # at least, around each harmonic
_BAND_BINS = 16
_CLEARLY = 6.0  # a ratio of variances, of 16 degrees of freedom each: by chance once in two thousand
_STEEP = 0.25  # change of the logarithm of the density over a band, above which it is taken into account
_BANDS_AROUND = 2
_OF_LOGARITHM, _SURELY = math.pi / math.sqrt(6.0), 2.0  # deviation of that of an exponential; standard errors
_MOVED_MOST = 10  # harmonics around which a wander of the phase may be seen
_FEWEST_ALIKE = 1.5  # squares that hold the power of noise: of fewer its level is not told from below
_SURE = 1e-2  # relative uncertainty of a power, below which its root has half of it
_LINE = 10.0  # times the mean square of noise: by chance one bin in twenty thousand
_LINES_BY_CHANCE = 5e-4
_BESIDE_TAKEN = 2  # bins, in which the fit of a line takes noise for it
_LOWEST_BINS = 64  # by which the density at low frequencies is told
_NOTHING = np.empty(0)


@dataclass(frozen=True)
class NoiseFloor:
    """Noise between the harmonics of a spectrum, in the signal's unit.

    `amplitude` is the rms over `bins` bins, each `bin_Hz` wide, of their peak amplitude. The
    medians of narrow bands give it, so that lines in less than half of the bins of a band do not count, and
    noise need not be white: where the density is steep, it is the mean of the squares, without the lines that
    stand out of the slope of the bands around. What only moves the phase of harmonics is left out. A strong
    interharmonic that was not taken out leaks through the rectangular window into all bins around it, and
    with that counts as noise.
    `highest` is this rms with all that the bins have, and `least` that without what may be left of a phase
    that was followed, relative to it. Either may be right: `all_noise` is the probability of the first.
    `of_bins` is the relative standard uncertainty of the floor by the scatter of its bins, of `dof` degrees
    of freedom, and `by_time` what it has besides because its level changes, `over_time`. Lines and a dc were
    `taken` out of bins that have this share of its power, by the density of others.
    """

    highest: float
    bin_Hz: float
    bins: int
    of_bins: float
    dof: float
    least: float = 1.0
    all_noise: float = 0.5
    over_time: NoiseOverTime = ONE_LEVEL
    taken: float = 0.0

    @property
    def amplitude(self) -> float:
        """Noise floor, rms of the peak amplitudes of bins: the expectation of both."""
        return self.highest * self._expected

    @property
    def of_rest(self) -> float:
        """Relative standard uncertainty of the floor by what may be left of a phase that was followed."""
        deviation = math.sqrt(self.all_noise * (1.0 - self.all_noise))
        return (1.0 - self.least) * deviation / self._expected

    @property
    def _expected(self) -> float:
        return self.all_noise + (1.0 - self.all_noise) * self.least

    @property
    def relative_error(self) -> float:
        """Relative standard uncertainty of the floor as one of a level that does not change."""
        return math.hypot(self.of_bins, self.of_rest)

    @property
    def by_time(self) -> MeanError:
        """Relative standard uncertainty of the floor, because the level changes with time."""
        error = self.over_time.error
        return MeanError(relative_to_found(error.standard), error.dof)

    @property
    def density(self) -> float:
        """Noise per root of the bandwidth, rms, in the signal's unit per sqrt(Hz)."""
        return self.amplitude / math.sqrt(2.0 * self.bin_Hz)

    @property
    def standard(self) -> float:
        """Standard uncertainty that the noise gives the amplitude of a line well above it.

        Of the two components of the noise, each of rms `amplitude` / sqrt(2), only the one in phase with the
        line changes its length.
        """
        return self.amplitude / math.sqrt(2.0)


def noise_floor(
    spectrum: CoherentSpectrum,
    first_order: float = 0.0,
    last_order: float = math.inf,
    *,
    has_moved: bool = False,
    follows_signal: bool = False,
    taken: NDArray[np.float64] = _NOTHING,
) -> NoiseFloor | None:
    """Return noise floor from the bins between two orders that are not harmonics; None if fewer than eight.

    Where there are four periods or more, the bins next to dc and to a harmonic are left out too: a harmonic
    that is not quite steady spreads there. In bands of 16 bins or more, each a tenth wider than the one
    before, the median of the squares over that of an exponential distribution is the band's power; where the
    density is steep, the mean of those that are no line.

    Where a phase was followed or the course of an amplitude was divided out (`has_moved`), something of it
    may be left between the low harmonics, or be noise of that colour: the floor is all that is there or that
    without what the lower bands have more than the upper half of them. A phase that `follows_signal` took
    the noise in quadrature to the fundamental along. What was `taken` out, at places in bins of shape
    (lines,), took noise of the bins beside it along.

    The median of n exponentially distributed squares has the mean H_n - H_(n/2), H the harmonic numbers, and
    scatters by about 1 / sqrt(n) (Kendall and Stuart, The Advanced Theory of Statistics, vol. 1, 10.10 and
    14.6).
    """
    bins = bins_between(spectrum, first_order, last_order)
    if len(bins) < FEWEST_BINS:
        return None
    additive, leaked = _additive(spectrum, follows_signal)
    square = additive[bins]
    bands = _bands(len(bins))
    powers, variances = [], []
    for band, slope in zip(bands, _slopes(square, bins, bands), strict=True):
        part, places = square[band], bins[band]
        if abs(slope) * math.log(places[-1] / places[0]) > _STEEP:
            power, variance = _steep_power(part, (places / places[0]) ** slope)
        else:
            power = _power_without_lines(part)
            variance = (power / math.log(2.0)) ** 2 / len(part)
        powers.append(power)
        variances.append(variance)
    shares = np.array([band.stop - band.start for band in bands]) / len(bins)
    total = float(np.average(powers, weights=shares))
    bin_Hz = spectrum.fundamental_Hz / spectrum.periods
    if not total > 0.0:
        return NoiseFloor(0.0, bin_Hz, len(bins), 0.0, math.inf)
    relative2 = float(shares**2 @ np.array(variances)) / total**2
    relative2 *= repetition_of_bins(spectrum.phasor, spectrum.periods, bins)
    relative = math.sqrt(min(relative2, 1.0 / _FEWEST_ALIKE))
    # half of the relative error of a power is that of the amplitude
    of_leakage = 0.5 * leaked / (total * len(bins))
    of_bins = math.hypot(relative_to_found(relative), of_leakage)
    least = _without_low_bands(powers, shares) if has_moved else 1.0
    over_time = noise_over_time(spectrum.phasor, _quiet(spectrum, bins, bands, powers))
    amplitude, dof = math.sqrt(total), 2.0 / relative**2
    return NoiseFloor(
        amplitude,
        bin_Hz,
        len(bins),
        of_bins,
        dof,
        least,
        over_time=over_time,
        taken=_share_beside(taken, square, bins) if len(taken) else 0.0,
    )


def _share_beside(taken: NDArray[np.float64], square: NDArray[np.float64], bins: NDArray[np.int64]) -> float:
    """Return the share that bins beside what was taken out have of the power of noise, by squares in bins,
    both of shape (n,): as the density of the lowest others goes on there."""
    near = np.any(np.abs(bins[:, np.newaxis] - taken) <= _BESIDE_TAKEN, axis=1)
    kept = np.flatnonzero(~near & (bins > 0) & (square > 0.0))[:_LOWEST_BINS]
    if len(kept) < FEWEST_BINS or not np.any(near):
        return float(np.mean(near))
    slope = slope_within(square[kept], bins[kept])
    level = float(np.mean(np.log(square[kept]) - slope * np.log(bins[kept]))) + np.euler_gamma
    beside = float(np.sum(np.exp(level + slope * np.log(np.maximum(bins[near], 1)))))
    return beside / (beside + float(np.sum(square[~near])))


def _quiet(
    spectrum: CoherentSpectrum, bins: NDArray[np.int64], bands: list[slice], powers: list[float]
) -> NDArray[np.int64]:
    """Return the bins from the first to the last of `bins` that are neither harmonics nor lines.

    Those next to harmonics count where they have no more than noise: without them the rest would repeat
    itself in every period.
    """
    inside = np.arange(bins[0], bins[-1] + 1)
    centres = [float(bins[(each.start + each.stop) // 2]) for each in bands]
    square = np.square(spectrum.amplitude[inside])
    is_noise = (inside % spectrum.periods > 0) & (square <= _LINE * np.interp(inside, centres, powers))
    return np.asarray(inside[is_noise])


def _without_low_bands(powers: list[float], shares: NDArray[np.float64]) -> float:
    """Return the root of the mean of powers, of bands with these shares, without what the lower bands have
    more than the upper half, relative to that with it; 1 where they have no more."""
    upper = np.cumsum(shares) > 0.5
    level = float(np.average(np.array(powers)[upper], weights=shares[upper]))
    return min(1.0, math.sqrt(level / float(shares @ np.array(powers))))


def _steep_power(square: NDArray[np.float64], shape: NDArray[np.float64]) -> tuple[float, float]:
    """Return the mean of exponentially distributed squares, shape (n,), whose density is about in proportion
    to `shape`, and the variance of that.

    The shape only tells which of them are lines: no median knows what a few bins hold most of. How few these
    are, both the shape and the squares tell, and the mean of both is taken: a shape goes on where the density
    may be level, and of the squares the largest may be low by chance. Of n alike, n = 2 (sum of x)^2 / (sum
    of x^2) - 1 on average, as the square of each is twice that of its mean.
    """
    even = square / shape
    is_noise = even <= _LINE * _power_without_lines(even)
    noise = square[is_noise]
    of_all = float(np.sum(shape) / np.sum(shape[is_noise])) / len(square)
    power = of_all * float(np.sum(noise))
    if not power > 0.0:
        return 0.0, 0.0
    alike = 2.0 * float(np.sum(noise)) ** 2 / float(noise @ noise) - 1.0
    of_shape = float(np.sum(shape)) ** 2 / float(shape @ shape)
    inverse = 0.5 * (1.0 / max(alike, _FEWEST_ALIKE) + 1.0 / max(of_shape, _FEWEST_ALIKE))
    return power, power**2 * inverse


def relative_to_found(relative: float) -> float:
    """Return the rms of errors of a level in units of the level found, of a power whose relative standard
    uncertainty, in units of the power sought, is given.

    A level that is low by chance is stated with a small uncertainty. A mean of n exponentially distributed
    powers has a gamma distribution of shape n, whose moments of order -1/2 and -1 give it (Johnson, Kotz and
    Balakrishnan, Continuous Univariate Distributions, vol. 1, 17.3).
    """
    if relative < _SURE:
        return 0.5 * relative
    n = 1.0 / relative**2
    of_half = math.exp(0.5 * math.log(n) + math.lgamma(n - 0.5) - math.lgamma(n))
    return math.sqrt(1.0 - 2.0 * of_half + n / (n - 1.0))


def _additive(spectrum: CoherentSpectrum, follows_signal: bool) -> tuple[NDArray[np.float64], float]:
    """Return squares of the amplitudes of all bins, those around harmonics without what moves their phase.

    What is left of a phase that was followed, or does not close, spreads as sidebands in quadrature. Where
    these are clearly more than those in phase, twice the latter stand for both. Beyond, nearer to other
    harmonics, they fall off as the square of the distance: the second number is their sum there. Where a
    phase was followed by the fundamental itself, the noise in quadrature to it went along, and twice that in
    phase stands for both too.
    """
    square, bins, periods = np.square(spectrum.amplitude), spectrum.phasor, spectrum.periods
    orders = np.arange(1, len(bins) // periods)
    # what a wander of the phase leaves beside a harmonic is in proportion to order and amplitude
    moved = orders * spectrum.amplitude[periods * orders]
    leaked = 0.0
    for order in orders[np.argsort(-moved)[:_MOVED_MOST]]:
        line = int(order) * periods
        reach = min(periods if order == 1 else periods // 2, len(bins) - line) - 1
        in_phase, quadrature = sidebands(bins, line, reach)
        if follows_signal and order == 1 and (followed := followed_bins(in_phase, quadrature)):
            square[line + 1 : line + 1 + followed] = 0.5 * in_phase[:followed]
            square[line - followed : line] = 0.5 * in_phase[:followed][::-1]
        if reach < 2 or float(np.sum(quadrature)) <= _CLEARLY * float(np.sum(in_phase)):
            continue
        square[line + 1 : line + 1 + reach] = 0.5 * in_phase
        square[line - reach : line] = 0.5 * in_phase[::-1]
        excess = 0.25 * float(np.mean(quadrature[reach // 2 :]) - np.mean(in_phase[reach // 2 :]))
        # of c / d^2, whose mean from half to all of the reach is 2 c / reach^2: c / reach on one side beyond
        leaked += max(0.0, 0.5 * excess * reach) * (1 if order == 1 else 2)
    return square, leaked


def sidebands(
    bins: NDArray[np.complex128], line: int, reach: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return squares of what pairs of bins beside a line have in phase with it and in quadrature, from the
    nearest on, each of shape (reach,)."""
    towards = np.exp(-1j * np.angle(bins[line]))
    above = bins[line + 1 : line + 1 + reach] * towards
    below = np.conj(bins[line - reach : line][::-1] * towards)
    return np.abs(above + below) ** 2, np.abs(above - below) ** 2


def followed_bins(in_phase: NDArray[np.float64], quadrature: NDArray[np.float64]) -> int:
    """Return how many bins to either side of the fundamental have clearly less in quadrature than in phase:
    up to the first few of which half is there."""
    count = len(in_phase) // FEWEST_BINS
    if not count:
        return 0
    kept, whole = (
        np.sum(each[: count * FEWEST_BINS].reshape(count, -1), axis=1) for each in (quadrature, in_phase)
    )
    if _CLEARLY * kept[0] >= whole[0]:
        return 0
    recovers = np.flatnonzero(2.0 * kept >= whole)
    return FEWEST_BINS * int(recovers[0] if len(recovers) else count)


def _slopes(square: NDArray[np.float64], bins: NDArray[np.int64], bands: list[slice]) -> list[float]:
    """Return the exponent of frequency with which the density changes in each band, by the medians of those
    around, or by its own bins where there is no other."""
    if len(bands) == 1:
        return [slope_within(square, bins)]
    # where a density rises or falls all through a band, its median is that of the bin in the middle
    centre = np.log([float(bins[(each.start + each.stop) // 2]) for each in bands])
    with np.errstate(divide="ignore"):
        level = np.log([median(square[each]) for each in bands])
    found = []
    for index in range(len(bands)):
        near = slice(max(0, index - _BANDS_AROUND), index + _BANDS_AROUND + 1)
        x, y = centre[near], level[near]
        found.append(_slope(x, y) if np.all(np.isfinite(y)) else 0.0)
    return found


def _slope(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    """Return the slope of the least-squares line through points, both of shape (n,)."""
    about = x - np.mean(x)
    return float(about @ y) / float(about @ about)


def slope_within(square: NDArray[np.float64], bins: NDArray[np.int64]) -> float:
    """Return the exponent of frequency with which squares, shape (n,), in bins change; 0 where it may be
    chance."""
    seen = (square > 0.0) & (bins > 0)
    if np.count_nonzero(seen) < FEWEST_BINS:
        return 0.0
    place = np.log(bins[seen])
    slope = _slope(place, np.log(square[seen]))
    by_chance = _OF_LOGARITHM / float(np.std(place)) / math.sqrt(len(place))
    return slope if abs(slope) > _SURELY * by_chance else 0.0


def _power_without_lines(square: NDArray[np.float64]) -> float:
    """Return the mean of exponentially distributed squares, shape (n,), by the median of those that are no
    line."""
    power = median(square) / median_of_exponentials(len(square))
    lines = int(np.count_nonzero(square > _LINE * power))
    if lines <= _LINES_BY_CHANCE * len(square):
        return power
    rest = len(square) - lines
    return median(np.sort(square)[:rest]) / median_of_exponentials(rest)


def harmonic_noise(spectrum: CoherentSpectrum, orders: int) -> NDArray[np.float64]:
    """Return the standard uncertainty of amplitudes of harmonics 1 to `orders` by the floor, shape (orders,),
    or nan.

    Each from the floor around it, because the noise of a drive is not white: from as many orders to either
    side as hold twenty bins.
    """
    periods, within = spectrum.periods, _within(spectrum)
    reach = _orders_around(spectrum)
    around = np.arange(1, orders + 1)[:, np.newaxis] + np.arange(-reach, reach)
    bins = (periods * around[:, :, np.newaxis] + within).reshape(orders, -1)
    inside = (bins > 0) & (bins < len(spectrum.amplitude))
    counts, middle = np.count_nonzero(inside, axis=1), np.full(orders, np.nan)
    for count in np.unique(counts[counts >= FEWEST_BINS]):
        rows = counts == count
        amplitude = spectrum.amplitude[bins[rows][inside[rows]]].reshape(-1, count)
        middle[rows] = medians(amplitude)
    return np.asarray(middle / MEDIAN_OF_RMS / math.sqrt(2.0))


def bins_around(spectrum: CoherentSpectrum) -> int:
    """Return of how many bins `harmonic_noise` is, in the middle of the band."""
    return 2 * _orders_around(spectrum) * len(_within(spectrum))


def _orders_around(spectrum: CoherentSpectrum) -> int:
    return math.ceil(_LOCAL_BINS / (2 * max(1, len(_within(spectrum)))))


def _within(spectrum: CoherentSpectrum) -> NDArray[np.int64]:
    """Return the bins from a harmonic to those between it and the next."""
    guard = _guard(spectrum)
    return np.arange(guard, spectrum.periods - guard + 1)


def _bands(count: int) -> list[slice]:
    """Return the successive parts of `count` bins: 16 or a tenth of those before, whichever is more."""
    edges = [0]
    while edges[-1] < count:
        edges.append(edges[-1] + max(_BAND_BINS, edges[-1] // 10))
    if len(edges) > 2 and count - edges[-2] < _BAND_BINS:
        del edges[-2]
    edges[-1] = count
    return [slice(begin, end) for begin, end in itertools.pairwise(edges)]


def _guard(spectrum: CoherentSpectrum) -> int:
    """Return the bins from a harmonic to the nearest that counts as being between harmonics."""
    return 2 if spectrum.periods >= 4 else 1


def bins_between(
    spectrum: CoherentSpectrum, first_order: float = 0.0, last_order: float = math.inf
) -> NDArray[np.int64]:
    """Return the bins between two orders that are no harmonic nor next to one."""
    periods, count = spectrum.periods, len(spectrum.amplitude)
    first = max(0, math.floor(first_order))
    last = math.ceil(min(last_order, count / periods))
    bins = (periods * np.arange(first, last)[:, np.newaxis] + _within(spectrum)).ravel()
    return bins[: np.searchsorted(bins, count)]
