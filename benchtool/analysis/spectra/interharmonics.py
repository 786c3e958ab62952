"""Components of a current that are no harmonics: sinusoids between them, and a dc that decays.

They leak into every bin of a rectangular window over whole periods, the harmonics' too. What a model of few
constants explains is taken out, and what is left beside a harmonic is noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum, spectrum_of
from benchtool.analysis.lines.line_models import as_real
from benchtool.analysis.spectra.groups import HarmonicGroups, groups_of, ratio_of
from benchtool.analysis.spectra.moving_tones import Course, MovingTone, moving_tones

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_MOST = 8
_STANDS_OUT = 8.0  # times the noise by the bins around, under a Hann window
_ROUNDING = 1e-7  # of the largest line
_AROUND, _OF_LINE = 12, 3
_FITTED = 6  # bins to either side of a sinusoid
_LEFT = 0.1  # of the power there, that one sinusoid more may leave
_NEARLY = 2.0  # times that: a step of constants turns what is fitted by far less than 0.13 rad
_CLOSE = 0.4  # bins: nearer to a harmonic, or another, the fit adds over three times the noise: both are one
_BESIDE, _OF_DISTANCE = 1.5, 0.125  # bins that `close_lines` looks at; of the distance of harmonics
_AROUND_CLOSE = 3.0  # bins from a harmonic
_ALIKE, _ALIKE_BINS = 0.2, 0.3  # of an amplitude; bins
_REACH = 1 << 15  # bins, beyond which one leaks less than 1e-5 of itself
_STEPS, _ENOUGH = 12, 1e-7
_SMALL = 1e-4
_THERE = 1e-9  # bins, and times pi
_OF_DECAY = 12  # bins from dc on
_DRAWS, _MOST_WINDOWS = 64, 64
_PRIMES = (2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0)
_CONSTANTS = np.geomspace(0.01, 2.0, 60)  # time constants over the record


@dataclass(frozen=True)
class Interharmonics:
    """Sinusoids at `places`, in bins, shape (n,), with peak `phasors`, and a dc that begins at `start` and
    decays with the time constant `constant`, relative to the record; and tones that are `moving`."""

    places: Floats = field(default_factory=lambda: np.zeros(0))
    phasors: Complex = field(default_factory=lambda: np.zeros(0, dtype=np.complex128))
    start: float = 0.0
    constant: float = 1.0
    moving: tuple[MovingTone, ...] = ()

    @property
    def words(self) -> str:
        """What they are, for a definition."""
        count = len(self.places) + len(self.moving)
        parts = [f"{count} sinusoid{'s' if count > 1 else ''} between harmonics"] if count else []
        return " and ".join([*parts, "a decaying dc"] if self.start else parts)

    def of_bins(self, bins: NDArray[np.int64], count: int) -> Complex:
        """Return what they make of bins of a record of `count` samples, as peak phasors."""
        found = self.start * _decay(self.constant, bins, count)
        for place, phasor in zip(self.places, self.phasors, strict=True):
            near = np.abs(bins - place) < _REACH
            upper, lower = sinusoid(place, bins[near], count)
            found[near] += phasor * upper + np.conj(phasor) * lower
        return found

    def at(self, course: Course) -> Floats:
        """Return them at places of the record, shape (n,)."""
        found = self.decay(course)
        for component in self.components(course):
            found += np.real(component)
        return np.asarray(found)

    def decay(self, course: Course) -> Floats:
        """Return the dc that decays at places of the record, shape (n,)."""
        return np.asarray(self.start * np.exp(-course.turned / self.constant))

    def components(self, course: Course) -> Iterator[Complex]:
        """Yield each sinusoid and each tone as an analytic signal at places of the record, shape (n,)."""
        for place, phasor in zip(self.places, self.phasors, strict=True):
            yield np.asarray(phasor * np.exp(2j * np.pi * place * course.turned))
        yield from (tone.at(course) for tone in self.moving)


def between_harmonics(
    coherent: CoherentSamples, spectrum: CoherentSpectrum, course: Course
) -> Interharmonics | None:
    """Return what stands out between the harmonics of samples at `course`: what is steady and what moves,
    with the sidebands of what swings; None if nothing does.

    A tone that hardly moves is a few steady ones as well, and two close ones are one that moves: what leaves
    the least between the harmonics counts.
    """
    steady = interharmonics(spectrum, len(coherent.values))
    rest = coherent if steady is None else without(coherent, steady, course)
    found = _with_moving(steady, _apart_from_harmonics(rest, course))
    moving = _apart_from_harmonics(coherent, course) if steady is not None else ()
    if found is None:
        return None
    if not moving:
        return found
    rest = without(coherent, Interharmonics(moving=moving), course)
    other = _with_moving(interharmonics(spectrum_of(rest), len(coherent.values)), moving)

    def left(each: Interharmonics) -> float:
        return left_between(spectrum_of(without(coherent, each, course)))

    return found if other is None else min(found, other, key=left)


def left_between(spectrum: CoherentSpectrum) -> float:
    """Return the sum of squares of the bins between the harmonics: noise, and what is not explained."""
    square = np.square(spectrum.amplitude)
    return float(np.sum(square) - np.sum(square[:: spectrum.periods]))


def _apart_from_harmonics(coherent: CoherentSamples, course: Course) -> tuple[MovingTone, ...]:
    """Return the tones that move, without those of constant frequency which are beside a harmonic on average:
    it is told by its phase what they make of it, as it is of steady ones."""
    periods = coherent.periods
    close = _close_to_harmonics(periods)
    return tuple(
        each
        for each in moving_tones(coherent, course)
        if abs(each.by_turns - periods * round(each.by_turns / periods)) > close
        or not each.is_steady_in_time(course)
    )


def _close_to_harmonics(periods: int) -> float:
    """Return within how many bins of a harmonic sinusoids are told by its phase: of few periods each is near
    a harmonic."""
    return max(_CLOSE, min(_BESIDE, _OF_DISTANCE * periods))


def without_modulation(found: Interharmonics, spectrum: CoherentSpectrum) -> Interharmonics | None:
    """Return it without the pairs of tones to both sides of a harmonic that are an amplitude or a phase which
    swings."""
    places = np.array([*found.places, *(each.by_turns for each in found.moving)])
    phasors = np.array([*found.phasors, *(each.phasor for each in found.moving)])
    line = spectrum.periods * np.clip(np.round(places / spectrum.periods), 1, None).astype(np.int64)
    apart = places - line
    # along the phase of its harmonic the lower one is the conjugate of the upper one
    turned = phasors * np.exp(-1j * np.angle(spectrum.phasor[np.minimum(line, len(spectrum.phasor) - 1)]))
    turned = np.where(apart < 0.0, np.conj(turned), turned)
    # where they move the phase, as of a speed that swings, its opposite
    unlike = np.minimum(np.abs(turned - turned[:, np.newaxis]), np.abs(turned + turned[:, np.newaxis]))
    swings = (
        (line == line[:, np.newaxis])
        & (np.abs(apart + apart[:, np.newaxis]) < _ALIKE_BINS)
        & (unlike < _ALIKE * np.abs(turned))
    )
    kept = ~np.any(swings | swings.T, axis=0)
    steady, moving = kept[: len(found.places)], kept[len(found.places) :]
    left = replace(
        found,
        places=found.places[steady],
        phasors=found.phasors[steady],
        moving=tuple(each for each, stays in zip(found.moving, moving, strict=True) if stays),
    )
    return left if len(left.places) or left.moving or left.start else None


def _with_moving(steady: Interharmonics | None, moving: tuple[MovingTone, ...]) -> Interharmonics | None:
    return replace(steady or Interharmonics(), moving=moving) if moving else steady


def together(one: Interharmonics | None, other: Interharmonics | None) -> Interharmonics | None:
    """Return both; of the other all but a decay."""
    if one is None or other is None:
        return one or other
    places, phasors = ((getattr(one, key), getattr(other, key)) for key in ("places", "phasors"))
    return replace(
        one,
        places=np.concatenate(places),
        phasors=np.concatenate(phasors),
        moving=one.moving + other.moving,
    )


def interharmonics(spectrum: CoherentSpectrum, count: int) -> Interharmonics | None:
    """Return what stands out between the harmonics and is as steady as a sinusoid, or a dc that decays
    exponentially; None if nothing does.

    Up to eight sinusoids, the strongest first, each kept if it explains nine tenths of the power around it;
    all are fitted together to the bins around them that are no harmonics (least squares). The spectrum is of
    `count` samples.
    """
    bins, periods = spectrum.phasor, spectrum.periods
    start, constant = _fitted_decay(bins, periods, count)
    number = np.arange(len(bins), dtype=np.int64)
    steady = bins - start * _decay(constant, number, count) if start else bins
    found = Interharmonics()
    left = steady
    while len(found.places) < _MOST:
        place = _largest(left, periods)
        if place is None:
            break
        window = _window(len(bins), np.array([place]), periods)
        enough = _LEFT * float(np.sum(np.abs(left[window]) ** 2))
        places, now, other, first = found.places, left, None, place // periods
        for _ in range(2):  # two may be so near that neither explains what is around it
            place = _largest(now, periods)
            if place is None or place // periods != first:  # to both sides of a harmonic, they modulate it
                break
            places = np.append(places, place)
            other = _fitted(steady, places, periods, count)
            if other is None:
                break
            now, places = steady - other.of_bins(number, count), other.places
            if float(np.sum(np.abs(now[window]) ** 2)) < enough:
                break
        if other is None or not float(np.sum(np.abs(now[window]) ** 2)) < enough:
            break
        found, left = other, now
    if len(found.places):  # which leak to the bins beside dc as a decay does
        start, constant = _fitted_decay(bins - found.of_bins(number, count), periods, count)
        steady = bins - start * _decay(constant, number, count)
        found = _fitted(steady, found.places, periods, count) or found
    apart = _is_apart(found, periods)
    found = Interharmonics(found.places[apart], found.phasors[apart], start, constant)
    return found if len(found.places) or start else None


def _is_apart(found: Interharmonics, periods: int) -> NDArray[np.bool_]:
    """Return which sinusoids are not beside a harmonic, where its phase tells them, nor near it and far less
    than one that is near it: these are what a phase that wanders, too, leaves of the fit of that."""
    harmonic, size = np.round(found.places / periods), np.abs(found.phasors)
    beside = np.abs(found.places - periods * harmonic)
    near = (beside < _AROUND_CLOSE) & (beside[:, np.newaxis] < _AROUND_CLOSE)
    is_left = near & (harmonic == harmonic[:, np.newaxis]) & (_LEFT * size > size[:, np.newaxis])
    return np.asarray((beside > _close_to_harmonics(periods)) & ~np.any(is_left, axis=1))


def without(coherent: CoherentSamples, found: Interharmonics, course: Course) -> CoherentSamples:
    """Return samples, which are at `course`, without them."""
    return replace(coherent, values=coherent.values - found.at(course))


def noise_of_fit(found: Interharmonics, spectrum: CoherentSpectrum, orders: int, count: int) -> Floats:
    """Return what the fit of the sinusoids adds to the noise of harmonics, relative to that of a bin, shape
    (orders,): much where one is near (JCGM 100:2008, 5.1.2). The record has `count` samples."""
    if not len(found.places):
        return np.zeros(orders)
    lines = spectrum.periods * np.arange(1, orders + 1, dtype=np.int64)
    window = _window(len(spectrum.phasor), found.places, spectrum.periods)
    fitted, there = (
        np.concatenate(
            [_units(found.places, each, count), _slopes(found.places, found.phasors, each, count)], axis=1
        )
        for each in (window, lines)
    )
    # of unknowns whose covariance is (A^T A)^-1 the lines B x have that of the rows of B A^+
    square = np.sum((there @ np.linalg.pinv(fitted)) ** 2, axis=1)
    return np.asarray(np.sqrt(0.5 * np.sum(square.reshape(2, -1), axis=0)))


def scatter_of_phases(
    clean: CoherentSpectrum, found: Interharmonics, groups: HarmonicGroups, course: Course
) -> tuple[float, float]:
    """Return the standard deviations of the distortions by groups and by subgroups over the phases of
    components between the harmonics (JCGM 101:2008), for a record whose samples are at `course`.

    In a window the leakage of one adds to a line, or is taken off it, as their phases have it.
    """
    periods, windows = groups.periods_per_window, min(groups.windows, _MOST_WINDOWS)
    count = len(course.turned)
    size = round(count * periods / clean.periods)
    bins = np.arange((groups.orders + 1) * periods + 1, dtype=np.int64)
    order = np.arange(1, min(groups.orders + 1, (len(clean.phasor) - 1) // clean.periods) + 1)
    lines = np.zeros(len(bins), dtype=np.complex128)
    window = np.arange(windows)[:, np.newaxis]
    upper, lower = [], []
    for place, phasor in zip(found.places * (size / count), found.phasors, strict=True):
        begin = phasor * np.exp(2j * np.pi * place * window)
        above, below = sinusoid(float(place), bins, size)
        upper.append(begin * above)
        lower.append(np.conj(begin) * below)
    for tone in found.moving:
        table = tone.at(course)[: windows * size].reshape(windows, size)
        transformed = fft.fft(table, axis=1) / size
        upper.append(transformed[:, bins])
        lower.append(np.conj(transformed[:, -bins]))
    constant = found.constant * count / size
    decaying = found.start * np.exp(-window / constant) * _decay(constant, bins, size)
    ratios = []
    for number in range(_DRAWS):
        turns = np.exp(2j * np.pi * (number * np.sqrt(_PRIMES[: len(upper) + 1])))
        lines[periods * order] = clean.phasor[clean.periods * order] * turns[-1] ** order
        total = lines + (-1.0) ** number * decaying
        for above, below, turn in zip(upper, lower, turns, strict=False):
            total = total + turn * above + np.conj(turn) * below
        drawn = groups_of(0.5 * np.abs(total) ** 2, periods, groups.orders)
        ratios.append([ratio_of(drawn.group2), ratio_of(drawn.subgroup2)])
    of_groups, of_subgroups = np.std(ratios, axis=0)
    return float(of_groups), float(of_subgroups)


def sinusoid(places: Floats | float, bins: NDArray[np.int64] | Floats, count: int) -> tuple[Complex, Complex]:
    """Return what cosines of amplitude one make of bins, by their positive and negative frequency, in the
    shape of places against bins."""
    return dirichlet_kernel(places, bins, count), dirichlet_kernel(-places, bins, count)


def dirichlet_kernel(places: Floats | float, bins: NDArray[np.int64] | Floats, count: int) -> Complex:
    """Return the mean of exp(2 pi j (place - bin) n / count) over n = 0 ... count - 1, in the shape of places
    against bins: Dirichlet's kernel, a geometric series whose numerator is the same for all whole bins."""
    apart = places - np.round(places)
    numerator = np.sin(np.pi * apart) * np.exp(1j * np.pi * apart) / count
    tangent = np.tan((np.pi / count) * (places - bins))
    there = np.abs(tangent) < _THERE / count
    return np.where(there, 1.0, numerator * (1.0 / np.where(there, 1.0, tangent) - 1j))


def _decay(constant: Floats | float, bins: NDArray[np.int64], count: int) -> Complex:
    """Return what exp(-n / (constant count)) makes of bins, as peak phasors."""
    exponent = -1.0 / (constant * count) - 2j * np.pi * bins / count
    found = 2.0 / count * np.expm1(-1.0 / constant) / np.expm1(exponent)
    return np.asarray(np.where(bins == 0, 0.5, 1.0) * found)


def _fitted_decay(bins: Complex, periods: int, count: int) -> tuple[float, float]:
    """Return beginning and time constant of a decaying dc; 0 where none explains the bins beside dc."""
    number = np.arange(1, min(_OF_DECAY, len(bins) - 1) + 1, dtype=np.int64)
    number = number[number % periods != 0]
    if len(number) < 4:
        return 0.0, 1.0
    measured = bins[number]

    def fit(constant: Floats) -> tuple[Floats, Floats]:
        shape = _decay(constant[:, np.newaxis], number, count)
        start = np.real(np.conj(shape) @ measured) / np.sum(np.abs(shape) ** 2, axis=1)
        return np.sum(np.abs(measured - start[:, np.newaxis] * shape) ** 2, axis=1), start

    left, enough = fit(_CONSTANTS)[0], _LEFT * float(np.sum(np.abs(measured) ** 2))
    best = int(np.argmin(left))
    if not left[best] < _NEARLY * enough:
        return 0.0, 1.0
    low, high = (float(_CONSTANTS[min(max(best + by, 0), len(_CONSTANTS) - 1)]) for by in (-1, 1))
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(40):
        inner, outer = high - golden * (high - low), low + golden * (high - low)
        of_inner, of_outer = fit(np.array([inner, outer]))[0]
        if of_inner < of_outer:
            high = outer
        else:
            low = inner
    constant = 0.5 * (low + high)
    (least,), (start,) = fit(np.array([constant]))
    return (float(start), constant) if least < enough else (0.0, 1.0)


def _largest(bins: Complex, periods: int) -> float | None:
    """Return about where the largest sinusoid between harmonics is, in bins; None if none stands out."""
    others = bins.copy()
    others[::periods] = 0.0
    size = np.zeros(len(bins))
    size[1:-1] = np.abs(others[1:-1] - 0.5 * (others[2:] + others[:-2]))
    size[::periods] = 0.0
    at = int(np.argmax(size))
    if not size[at] > _ROUNDING * float(np.max(np.abs(bins[1:]))):
        return None
    around = np.arange(max(1, at - _AROUND), min(len(size), at + 1 + _AROUND))
    around = around[(np.abs(around - at) > _OF_LINE) & (size[around] > 0.0)]
    if not len(around) or at + 1 >= len(bins):
        return None
    if not size[at] > _STANDS_OUT * _level(around, size[around], at):
        return None
    side = 1 if size[at + 1] > size[at - 1] else -1
    ratio = size[at + side] / size[at]
    return float(at + side * max(0.0, (2.0 * ratio - 1.0) / (1.0 + ratio)))


def _level(bins: NDArray[np.int64], size: Floats, at: int) -> float:
    """Return the size that noise may have in a bin, by that in bins around it, both of shape (n,): where all
    of them are above, it may rise towards dc as that of a random walk."""
    above = float(np.median(bins)) / at if at < np.min(bins) else 1.0
    return above * float(np.median(size))


def _window(count: int, places: Floats, periods: int) -> NDArray[np.int64]:
    """Return the bins around some places that are no harmonics."""
    near = np.round(places).astype(np.int64)[:, np.newaxis] + np.arange(-_FITTED, _FITTED + 1)
    found = np.unique(near)
    return np.asarray(found[(found > 0) & (found < count) & (found % periods != 0)])


def _fitted(bins: Complex, places: Floats, periods: int, count: int) -> Interharmonics | None:
    """Return sinusoids of these places, about, fitted to the bins around them; None if they do not
    converge, or two of them do to one place."""
    window, begin = _window(len(bins), places, periods), places
    if 2 * len(window) < 4 * len(places):
        return None
    measured = as_real(bins[window])
    for _ in range(_STEPS):
        table, linear = _phasors_at(places, window, measured, count)
        slopes = _slopes(places, linear[0::2] - 1j * linear[1::2], window, count)
        both = np.concatenate([table, slopes], axis=1)
        step = np.linalg.lstsq(both, measured - table @ linear, rcond=None)[0][len(linear) :]
        places = places + np.clip(step, -0.5, 0.5)
        if np.any(np.abs(places - begin) > 2.0) or not np.all(np.isfinite(places)):
            return None
        if np.max(np.abs(step)) < _ENOUGH:
            break
    if np.any(np.diff(np.sort(places)) < _CLOSE):
        return None
    _, linear = _phasors_at(places, window, measured, count)
    return Interharmonics(places, linear[0::2] - 1j * linear[1::2])


def _phasors_at(
    places: Floats, window: NDArray[np.int64], measured: Floats, count: int
) -> tuple[Floats, Floats]:
    """Return what sinusoids of unit phasors make of the bins, and the phasors fitted to these, as real
    numbers in turns with imaginary ones of the other sign."""
    table = _units(places, window, count)
    return table, np.asarray(np.linalg.lstsq(table, measured, rcond=None)[0], dtype=np.float64)


def _units(places: Floats, bins: NDArray[np.int64], count: int) -> Floats:
    above, below = sinusoid(places, bins[:, np.newaxis], count)
    units = np.stack([above + below, -1j * (above - below)], axis=2)
    return as_real(units.reshape(len(bins), -1))


def _slopes(places: Floats, phasors: Complex, bins: NDArray[np.int64], count: int) -> Floats:
    """Return what a change of each place makes of the bins."""
    (above, below), (above_less, below_less) = (
        sinusoid(places + by, bins[:, np.newaxis], count) for by in (_SMALL, -_SMALL)
    )
    change = phasors * (above - above_less) + np.conj(phasors) * (below - below_less)
    return as_real(change / (2.0 * _SMALL))
