"""Components of a current that are no harmonics: sinusoids between them, and a dc that decays.

They leak into every bin of a rectangular window over whole periods, the harmonics' too. What a model of few
constants explains is taken out, and what is left beside a harmonic is noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.spectra.groups import HarmonicGroups, groups_of, ratio_of
from benchtool.analysis.spectra.line_models import as_real, dirichlet
from benchtool.analysis.spectra.spectrum import CoherentSamples, CoherentSpectrum

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_MOST = 8
_STANDS_OUT = 8.0  # times the median of the bins around, under a Hann window
_ROUNDING = 1e-7  # of the largest line
_AROUND = 12
_FITTED = 6  # bins to either side of a sinusoid
_LEFT = 0.1  # of the power there, that one sinusoid more may leave
_CLOSE = 1.5  # bins: nearer to a harmonic both are one
_REACH = 1 << 15  # bins, beyond which one leaks less than 1e-5 of itself
_STEPS, _ENOUGH = 12, 1e-7
_SMALL = 1e-4
_OF_DECAY = 12  # bins from dc on
_DRAWS, _MOST_WINDOWS = 32, 64
_CONSTANTS = np.geomspace(0.01, 2.0, 60)  # time constants over the record


@dataclass(frozen=True)
class Interharmonics:
    """Sinusoids at `places`, in bins, shape (n,), with peak `phasors`, and a dc that begins at `start` and
    decays with the time constant `constant`, relative to the record."""

    places: Floats
    phasors: Complex
    start: float = 0.0
    constant: float = 1.0

    @property
    def words(self) -> str:
        """What they are, for a definition."""
        count = len(self.places)
        parts = [f"{count} sinusoid{'s' if count > 1 else ''} between harmonics"] if count else []
        return " and ".join([*parts, "a decaying dc"] if self.start else parts)

    def of_bins(self, bins: NDArray[np.int64], count: int) -> Complex:
        """Return what they make of bins of a record of `count` samples, as peak phasors."""
        found = self.start * _decay(self.constant, bins, count)
        for place, phasor in zip(self.places, self.phasors, strict=True):
            near = np.abs(bins - place) < _REACH
            upper, lower = _sinusoid(place, bins[near], count)
            found[near] += phasor * upper + np.conj(phasor) * lower
        return found

    def at(self, numbers: Floats, count: int) -> Floats:
        """Return them at sample numbers of any kind, shape (n,), of a record of `count` samples."""
        found = self.start * np.exp(-numbers / (self.constant * count))
        for place, phasor in zip(self.places, self.phasors, strict=True):
            found += np.real(phasor * np.exp(2j * np.pi * place / count * numbers))
        return np.asarray(found)


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
    found = Interharmonics(np.zeros(0), np.zeros(0, dtype=np.complex128))
    left = steady
    for _ in range(_MOST):
        place = _largest(left, periods)
        if place is None:
            break
        other = _fitted(steady, np.append(found.places, place), periods, count)
        if other is None:
            break
        now = steady - other.of_bins(number, count)
        window = _window(len(bins), np.array([place]), periods)
        if float(np.sum(np.abs(now[window]) ** 2)) > _LEFT * float(np.sum(np.abs(left[window]) ** 2)):
            break
        found, left = other, now
    apart = np.abs(found.places - periods * np.round(found.places / periods)) > _CLOSE
    found = Interharmonics(found.places[apart], found.phasors[apart], start, constant)
    return found if len(found.places) or start else None


def without(coherent: CoherentSamples, found: Interharmonics) -> CoherentSamples:
    """Return samples without them."""
    count = len(coherent.values)
    return replace(coherent, values=coherent.values - found.at(np.arange(count, dtype=np.float64), count))


def scatter_of_phases(
    clean: CoherentSpectrum, found: Interharmonics, groups: HarmonicGroups, count: int
) -> tuple[float, float]:
    """Return the standard deviations of the distortions by groups and by subgroups over the phases of
    components between the harmonics (JCGM 101:2008), for a record of `count` samples.

    In a window the leakage of one adds to a line, or is taken off it, as their phases have it.
    """
    periods, windows = groups.periods_per_window, min(groups.windows, _MOST_WINDOWS)
    size = round(count * periods / clean.periods)
    bins = np.arange((groups.orders + 1) * periods + 1, dtype=np.int64)
    order = np.arange(1, min(groups.orders + 1, (len(clean.phasor) - 1) // clean.periods) + 1)
    lines = np.zeros(len(bins), dtype=np.complex128)
    window = np.arange(windows)[:, np.newaxis]
    upper, lower = [], []
    for place, phasor in zip(found.places * (size / count), found.phasors, strict=True):
        begin = phasor * np.exp(2j * np.pi * place * window)
        above, below = _sinusoid(float(place), bins, size)
        upper.append(begin * above)
        lower.append(np.conj(begin) * below)
    constant = found.constant * count / size
    decaying = found.start * np.exp(-window / constant) * _decay(constant, bins, size)
    random = np.random.default_rng(0)
    ratios = []
    for _ in range(_DRAWS):
        lines[periods * order] = clean.phasor[clean.periods * order] * np.exp(
            1j * order * random.uniform(0, 2 * np.pi)
        )
        total = lines + random.choice([-1.0, 1.0]) * decaying
        for above, below in zip(upper, lower, strict=True):
            turn = np.exp(1j * random.uniform(0, 2 * np.pi))
            total = total + turn * above + np.conj(turn) * below
        drawn = groups_of(0.5 * np.abs(total) ** 2, periods, groups.orders)
        ratios.append([ratio_of(drawn.group2), ratio_of(drawn.subgroup2)])
    of_groups, of_subgroups = np.std(ratios, axis=0)
    return float(of_groups), float(of_subgroups)


def _sinusoid(place: float, bins: NDArray[np.int64], count: int) -> tuple[Complex, Complex]:
    """Return what a cosine of amplitude one makes of bins, by its positive and negative frequency."""
    number = bins.astype(np.float64)
    return _response(place - number, count), _response(-place - number, count)


def _response(apart: Floats, count: int) -> Complex:
    """Return the mean of exp(2 pi j apart n / count) over n = 0 ... count - 1 (Dirichlet's kernel)."""
    return np.asarray(dirichlet(apart, count) * np.exp(1j * np.pi * apart * (count - 1.0) / count))


def _decay(constant: float, bins: NDArray[np.int64], count: int) -> Complex:
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

    def fit(constant: float) -> tuple[float, float]:
        shape = _decay(constant, number, count)
        start = float(np.real(np.vdot(shape, measured)) / np.real(np.vdot(shape, shape)))
        return float(np.sum(np.abs(measured - start * shape) ** 2)), start

    best = int(np.argmin([fit(float(each))[0] for each in _CONSTANTS]))
    low, high = (float(_CONSTANTS[min(max(best + by, 0), len(_CONSTANTS) - 1)]) for by in (-1, 1))
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(40):
        inner, outer = high - golden * (high - low), low + golden * (high - low)
        if fit(inner)[0] < fit(outer)[0]:
            high = outer
        else:
            low = inner
    constant = 0.5 * (low + high)
    left, start = fit(constant)
    return (start, constant) if left < _LEFT * float(np.sum(np.abs(measured) ** 2)) else (0.0, 1.0)


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
    first = max(1, at - _AROUND)
    around = np.concatenate([size[first : max(first, at - 3)], size[at + 4 : at + 1 + _AROUND]])
    around = around[around > 0.0]
    if not len(around) or not size[at] > _STANDS_OUT * float(np.median(around)) or at + 1 >= len(bins):
        return None
    side = 1 if size[at + 1] > size[at - 1] else -1
    ratio = size[at + side] / size[at]
    return float(at + side * max(0.0, (2.0 * ratio - 1.0) / (1.0 + ratio)))


def _window(count: int, places: Floats, periods: int) -> NDArray[np.int64]:
    """Return the bins around some places that are no harmonics."""
    near = np.round(places).astype(np.int64)[:, np.newaxis] + np.arange(-_FITTED, _FITTED + 1)
    found = np.unique(near)
    return np.asarray(found[(found > 0) & (found < count) & (found % periods != 0)])


def _fitted(bins: Complex, places: Floats, periods: int, count: int) -> Interharmonics | None:
    """Return sinusoids of these places, about, fitted to the bins around them; None if they do not
    converge."""
    window, begin = _window(len(bins), places, periods), places
    if 2 * len(window) < 4 * len(places):
        return None
    measured = as_real(bins[window])
    for _ in range(_STEPS):
        table, linear = _phasors_at(places, window, measured, count)
        phasors, slopes = linear[0::2] - 1j * linear[1::2], []
        for place, phasor in zip(places, phasors, strict=True):
            above, below = (_sinusoid(float(place) + by, window, count) for by in (_SMALL, -_SMALL))
            change = phasor * (above[0] - below[0]) + np.conj(phasor) * (above[1] - below[1])
            slopes.append(as_real(change / (2.0 * _SMALL)))
        both = np.concatenate([table, np.stack(slopes, axis=1)], axis=1)
        step = np.linalg.lstsq(both, measured - table @ linear, rcond=None)[0][len(linear) :]
        places = places + np.clip(step, -0.5, 0.5)
        if np.any(np.abs(places - begin) > 2.0) or not np.all(np.isfinite(places)):
            return None
        if np.max(np.abs(step)) < _ENOUGH:
            break
    _, linear = _phasors_at(places, window, measured, count)
    return Interharmonics(places, linear[0::2] - 1j * linear[1::2])


def _phasors_at(
    places: Floats, window: NDArray[np.int64], measured: Floats, count: int
) -> tuple[Floats, Floats]:
    """Return what sinusoids of unit phasors make of the bins, and the phasors fitted to these, as real
    numbers in turns with imaginary ones of the other sign."""
    both = [_sinusoid(float(place), window, count) for place in places]
    table = np.stack([as_real(each) for u, v in both for each in (u + v, -1j * (u - v))], axis=1)
    return table, np.asarray(np.linalg.lstsq(table, measured, rcond=None)[0], dtype=np.float64)
