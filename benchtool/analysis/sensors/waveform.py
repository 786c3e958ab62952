"""What the bandwidth and the resolution of a sensor do to a waveform that was read with it.

Effects are relative changes of a feature of the recorded samples: of the mean, of one line, of the harmonics,
of the rms or of the extremes about the mean. They say what a stated error may have done to a measurement of
that kind, without the analysis that made it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import cached_property
from typing import Final

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.sensors.lag import Response
from benchtool.analysis.spectral_window import hann_response, interpolated

Floats = NDArray[np.float64]
Feature = Callable[["Waveform"], complex]

_LOOKED_AT = 1 << 16  # samples
_MAIN_LOBE = 3.0  # bins of a line under a Hann window
_DRAWS = 24  # of waveforms alike
_LOBES = 4  # bins to either side, beyond which a line under a Hann window has a millionth of its power
_APART = 0.1  # of a step, rms: how much their lines differ
_MOST_LINES = 64
_OF_A_STEP = 0.25  # lines below may be the steps' own
_OF_A_LINE = 1.5  # power of three bins over that of the largest, of a line under a Hann window
_BINS = 65  # whose mean tells signal from noise
_LOWER = 0.75  # times the frequencies up to which signal is taken back
_CLEARLY = 6.0  # over the root of their number: by how much noise hardly exceeds its lower quartile
_STANDS_OUT = 12.0  # of the mean power of noise, which one bin of 160000 exceeds


class Waveform:
    """Uniform samples, shape (n,), in the unit of their channel; of a long record the first 65536."""

    def __init__(self, samples: Floats, rate_Hz: float) -> None:
        self.samples: Final = samples[:_LOOKED_AT]
        self.rate_Hz: Final = rate_Hz
        self._in_steps: dict[float, tuple[tuple[Waveform, Waveform], ...]] = {}

    @cached_property
    def mean(self) -> float:
        return float(np.mean(self.samples))

    @cached_property
    def rms(self) -> float:
        """About the mean."""
        return float(np.std(self.samples))

    @cached_property
    def peak_to_peak(self) -> float:
        return float(np.ptp(self.samples))

    def range_within(self, beyond_percent: float) -> float:
        """Return the distance of the percentiles that so many of the samples are beyond, at either end."""
        low, high = np.percentile(self.samples, (beyond_percent, 100.0 - beyond_percent))
        return float(high - low)

    @cached_property
    def bins(self) -> NDArray[np.complex128]:
        """DFT of the whole under a Hann window, without the mean."""
        return np.asarray(fft.rfft((self.samples - self.mean) * np.hanning(len(self.samples))))

    def line(self, frequency_Hz: float) -> complex:
        """Return the bin nearest to a frequency; 0 beyond half the rate, or where it is not known."""
        if not math.isfinite(frequency_Hz):
            return 0.0
        place = round(abs(frequency_Hz) * len(self.samples) / self.rate_Hz)
        return complex(self.bins[place]) if place < len(self.bins) else 0.0

    @cached_property
    def sizes(self) -> Floats:
        """Magnitudes of its bins."""
        return np.asarray(np.abs(self.bins))

    @cached_property
    def amplitudes(self) -> Floats:
        """Peak amplitude of a line at each bin, by the power in it and its neighbours, which is within 1 % of
        that of a line between two bins."""
        return self._amplitude(np.convolve(self.sizes**2, np.ones(3), mode="same"))

    @cached_property
    def least_amplitude(self) -> float:
        """Peak amplitude above which a line stands out of the noise."""
        return float(self._amplitude(_OF_A_LINE * _least_of_lines(self.sizes**2)))

    def _amplitude(self, power: Floats | float) -> Floats:
        """Return the peak amplitude of lines of which three bins hold so much power."""
        weights = np.hanning(len(self.samples))
        return np.asarray(2.0 * np.sqrt(power / (np.sum(weights**2) * len(weights))))

    def amplitude(self, frequency_Hz: float) -> float:
        """Return the peak amplitude of the line at a frequency; 0 beyond half the rate, or where it is not
        known."""
        if not math.isfinite(frequency_Hz):
            return 0.0
        place = round(frequency_Hz * len(self.samples) / self.rate_Hz)
        return float(self.amplitudes[place]) if place < len(self.amplitudes) else 0.0

    def harmonics(self, fundamental_Hz: float, top_Hz: float) -> Iterator[tuple[float, float]]:
        """Yield frequency and peak amplitude of orders 2, 3 ... up to a frequency."""
        if fundamental_Hz > 0.0:
            for order in range(2, math.floor(min(top_Hz, 0.5 * self.rate_Hz) / fundamental_Hz + 1e-9) + 1):
                yield order * fundamental_Hz, self.amplitude(order * fundamental_Hz)

    def lines(self) -> tuple[NDArray[np.int64], Floats]:
        """Return bins and peak amplitudes of the lines that stand out of the noise, at most 64."""
        size = self.sizes
        inner = np.arange(1, len(size) - 1)
        stands_out = self.amplitudes[inner] > self.least_amplitude
        peaks = inner[stands_out & (size[inner] > size[inner - 1]) & (size[inner] >= size[inner + 1])]
        peaks = peaks[np.argsort(-size[peaks])][:_MOST_LINES]
        return peaks, self.amplitudes[peaks]

    def before(self, response: Response) -> tuple[Waveform, Waveform]:
        """Return its inner half, and the same as it was before a sensor of that response.

        Bins that do not stand out of the noise stay as they are: noise of the converter was not lost. Both
        outer quarters are weighted by half of a Hann window, and the inner half is as it is.
        """
        count = len(self.samples)
        quarter = count // 4
        inner = slice(quarter, count - quarter)
        weights = np.ones(count)
        weights[:quarter] = np.sin(0.5 * np.pi * (np.arange(quarter) + 0.5) / quarter) ** 2
        weights[count - quarter :] = weights[:quarter][::-1]
        bins = np.asarray(fft.rfft((self.samples - self.mean) * weights))
        power = np.abs(bins) ** 2
        inverse = response.inverse(np.asarray(fft.rfftfreq(count, 1.0 / self.rate_Hz), dtype=np.float64))
        lost = np.where(power > _least_of_lines(power), bins * (inverse - 1.0), 0.0)
        read = self.samples[inner]
        whole = read + fft.irfft(lost, count)[inner]
        return Waveform(read, self.rate_Hz), Waveform(whole, self.rate_Hz)

    def between(self, fundamental_Hz: float) -> float:
        """Return the rms of the bins between the harmonics, in the unit of `line`."""
        order = np.arange(len(self.bins)) * (self.rate_Hz / (len(self.samples) * fundamental_Hz))
        apart = np.abs(order - np.round(order)) * len(self.samples) * fundamental_Hz / self.rate_Hz
        left = np.abs(self.bins[(apart > _MAIN_LOBE) & (order > 0.0)])
        return float(np.sqrt(np.mean(left**2))) if len(left) else 0.0

    def in_steps(self, step: float) -> tuple[tuple[Waveform, Waveform], ...]:
        """Return waveforms alike, each before and after it was read in steps whose grid begins anywhere.

        They have the mean, lines and noise of this one. This one itself may have been read in the steps
        already, which once more would not move.
        """
        if step not in self._in_steps:
            self._in_steps[step] = tuple(self._alike(step))
        return self._in_steps[step]

    def _alike(self, step: float) -> Iterator[tuple[Waveform, Waveform]]:
        random, count = np.random.default_rng(0), len(self.samples)
        places, amplitudes = self.lines()
        places = places[amplitudes > _OF_A_STEP * step]
        values = np.full((_DRAWS, count), self.mean)
        least2, most2 = self._noise_before(step, max(0.0, self._power_beside(places) - step**2 / 12.0))
        # a waveform that repeats has its errors at the same places: its lines keep their ratios
        for bin_of_line, phasor in map(self._exactly, places):
            apart = random.standard_normal(_DRAWS) + 1j * random.standard_normal(_DRAWS)
            drawn = phasor + _APART * step * apart
            turn = np.exp(2j * np.pi * bin_of_line * np.arange(count) / count)
            values += np.outer(drawn.real, turn.real) - np.outer(drawn.imag, turn.imag)
        for k, waveform in enumerate(values):
            before = waveform + math.sqrt(random.uniform(least2, most2)) * random.standard_normal(count)
            read = in_steps(before, step, (k + 0.5) / _DRAWS)
            yield Waveform(before, self.rate_Hz), Waveform(read, self.rate_Hz)

    def _exactly(self, place: int) -> tuple[float, complex]:
        """Return the bin, not a whole one, and the peak phasor of the line nearest to one.

        By the ratio of its two largest bins under a Hann window (Rife and Vincent, Bell Syst. Tech. J. 49
        (1970) 197).
        """
        off, ratio = interpolated(self.sizes, place)
        off = off if ratio > 0.5 else 0.0  # less is noise's
        of_window = 0.25 * (len(self.samples) - 1) * float(hann_response(off))
        # the window's middle is half a record from its beginning
        return place + off, complex(self.bins[place]) / of_window * np.exp(-1j * np.pi * off)

    def _power_beside(self, places: NDArray[np.int64]) -> float:
        """Return the mean square that is left without the lines at these bins, shape (n,)."""
        left = np.ones(len(self.bins), dtype=bool)
        left[0] = False
        for near in range(-_LOBES, _LOBES + 1):
            left[np.clip(places + near, 0, len(left) - 1)] = False
        of_bins = np.sum(np.hanning(len(self.samples)) ** 2) * len(self.samples) / 2.0
        power = float(np.sum(self.sizes[left] ** 2)) / of_bins
        return power * len(left) / max(1, int(np.count_nonzero(left)))

    def _noise_before(self, step: float, noise2: float) -> tuple[float, float]:
        """Return between which squares noise was before the steps, of the square of all that there is.

        What came later blurs the readings about their grid, to a mean vector of exp(-2 pi^2 s^2) for s steps
        of it, which is known to two standard deviations of one of as many samples anywhere.
        """
        vector, chance = (
            abs(np.mean(np.exp(2j * np.pi * self.samples / step))),
            2.0 / math.sqrt(len(self.samples)),
        )
        least, most = (
            -math.log(min(each, 1.0)) / (2.0 * math.pi**2) if each > 0.0 else math.inf
            for each in (vector + chance, vector - chance)
        )
        return max(0.0, noise2 - most * step**2), max(0.0, noise2 - least * step**2)


def moved_small_line(waveform: Waveform, step: float, amplitude: float) -> float:
    """Return the standard uncertainty of a line, of an amplitude of a part of a step, by what the steps do to
    all that is as small: as much as moves the samples of a waveform alike to another level."""
    if not 0.0 < amplitude < _OF_A_STEP * step:
        return 0.0
    changes = []
    for k, (before, _) in enumerate(waveform.in_steps(step)):
        up, down = (
            in_steps(before.samples + moved, step, (k + 0.5) / _DRAWS) for moved in (amplitude, -amplitude)
        )
        changes.append(float(np.mean(up - down)) / 2.0 - amplitude)
    return math.sqrt(sum(change**2 for change in changes) / len(changes))


class Undone(Enum):
    """What of a spectrum is taken back before a sensor: `ALL`, as ratios of spectra need it, each frequency
    by itself; the `SIGNAL` that stands out of the noise; or what would if all frequencies were `LOWER` by a
    quarter, which shows what is lost with the highest."""

    ALL = auto()
    SIGNAL = auto()
    LOWER = auto()


def before_sensor(samples: Floats, rate_Hz: float, by: Response, undone: Undone) -> Floats:
    """Return what samples, shape (n,), were before a sensor of that response.

    By its frequency response. Before the first and past the last the samples go on as in a mirror, which
    keeps their mean. What does not stand out of the noise stays as it is: it is noise of the reading, which
    the sensor has not attenuated.
    """
    mirrored = np.concatenate([samples, samples[::-1]])
    bins = np.asarray(fft.rfft(mirrored))
    inverse = by.inverse(np.asarray(fft.rfftfreq(len(mirrored), 1.0 / rate_Hz), dtype=np.float64))
    added = fft.irfft(_share(bins, undone) * bins * (inverse - 1.0), len(mirrored))[: len(samples)]
    return np.asarray(samples + added)


def _share(bins: NDArray[np.complex128], undone: Undone) -> Floats:
    """Return how much of each bin, shape (n,), is taken back."""
    if undone is Undone.ALL:
        return np.ones(len(bins))
    share, places = _share_of_signal(np.abs(bins) ** 2), np.arange(len(bins))
    return share if undone is Undone.SIGNAL else np.interp(places / _LOWER, places, share, right=0.0)


def _least_of_lines(power: Floats) -> float:
    """Return the power above which a bin holds more than noise, whose mean is taken from the least quarter of
    all bins."""
    return _STANDS_OUT * float(np.quantile(power, 0.25)) / math.log(4.0 / 3.0)


def _share_of_signal(power: Floats) -> Floats:
    """Return how much of each bin, shape (n,), is signal and not noise, as by Wiener's filter: by the mean
    power of its neighbours, so that a transient has a smooth share along its spectrum."""
    near = np.convolve(power, np.full(_BINS, 1.0 / _BINS), mode="same")
    floor = (1.0 + _CLEARLY / math.sqrt(_BINS)) * float(np.quantile(near, 0.25))
    return np.asarray(1.0 - floor / np.maximum(near, floor + np.finfo(float).tiny))


def in_steps(samples: Floats, step: float, phase: float) -> Floats:
    """Return samples as read in steps, `phase` of a step being where the grid begins."""
    return np.asarray((np.round(samples / step - phase) + phase) * step)


def enlarged_largest(
    waveform: Waveform, fundamental_Hz: float, at_Hz: float, top_Hz: float, response: Response
) -> float:
    """Return by which factor the largest line was larger before a sensor: the one that was read at `at_Hz`,
    or a harmonic that has lost more of itself."""
    own = waveform.amplitude(at_Hz) or math.inf
    others = (
        response.enlarges(each_Hz) * size / own
        for each_Hz, size in waveform.harmonics(fundamental_Hz, top_Hz)
        if waveform.least_amplitude < size <= own
    )
    return max(response.enlarges(at_Hz), *others, 1.0)


def enlarged_harmonics(
    waveform: Waveform, fundamental_Hz: float, top_Hz: float, response: Response, *, as_ratio: bool
) -> float:
    """Return by which factor the root of the sum of squares of the harmonics was larger before a sensor; of
    their ratio to the fundamental if `as_ratio`. Harmonics that do not stand out count as they were read."""
    lines = np.array(list(waveform.harmonics(fundamental_Hz, top_Hz))).reshape(-1, 2).T
    squares = lines[1] ** 2
    factors = np.where(lines[1] > waveform.least_amplitude, np.abs(response.inverse(lines[0])) ** 2, 1.0)
    read, whole = float(np.sum(squares)), float(np.sum(factors * squares))
    own = response.enlarges(fundamental_Hz) if as_ratio else 1.0
    return math.sqrt(whole / read) / own if read > 0.0 else 1.0


def by_steps(waveform: Waveform, step: float, feature: Feature) -> float:
    """Return the standard uncertainty of a feature by steps whose grid may begin anywhere, in its unit.

    The rms change of waveforms alike: step / sqrt(12) of a mean that nothing moves, and little where
    the signal spans many steps, whose errors average out then.
    """
    changes = [abs(feature(read) - feature(before)) for before, read in waveform.in_steps(step)]
    return math.sqrt(sum(change**2 for change in changes) / len(changes))
