"""Amplitude spectra, one-sided, in peak amplitude: windowed, or coherent over whole electrical periods."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.resampling import (
    HALF_WIDTH,
    USABLE_BAND,
    gain_error,
    interpolate_all,
)
from benchtool.analysis.fast_lengths import next_fast_length, previous_fast_length
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.spectral_window import WindowName, spectral_window
from benchtool.analysis.validity import require_signal
from benchtool.block import as_samples, read_only, require_rate
from benchtool.errors import AnalysisError

FIRST_ROW = HALF_WIDTH - 1
"""Row at which the periods of a spectrum begin; those before, and the last 32, feed the interpolation."""

_FEWEST_PERIODS = 2
_PLACES, _GOES_BACK_RAD = 65, math.pi  # of a record, between which a phase does not go back by as much
_CHUNK = 1 << 14  # of values at a time, so that intermediate arrays stay in the cache
_ANY_PERIODS = 100  # up to here every number of periods is transformed fast enough


@dataclass(frozen=True)
class Spectrum:
    """Peak amplitude over frequency, both of shape (bins,), dc first; read-only."""

    frequency_Hz: NDArray[np.float64]
    amplitude: NDArray[np.float64]

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value))


@dataclass(frozen=True)
class CoherentSamples:
    """A signal at equal steps of phase over whole periods.

    `values`, read-only, has shape (periods * per_period,); `samples` is how many of the recorded samples,
    taken at `sample_rate_Hz`, the periods cover.
    """

    values: NDArray[np.float64]
    periods: int
    samples: float
    sample_rate_Hz: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", read_only(self.values))

    @property
    def per_period(self) -> int:
        return len(self.values) // self.periods

    @property
    def fundamental_Hz(self) -> float:
        return self.sample_rate_Hz * self.periods / self.samples

    @property
    def usable_order(self) -> float:
        """Order at 0.45 of the sample rate, up to which amplitudes are right."""
        return USABLE_BAND * self.samples / self.periods


@dataclass(frozen=True)
class CoherentSpectrum(Spectrum):
    """Spectrum over `periods` whole periods: bin `k * periods` is exactly harmonic k.

    Bins end at 0.45 of the sample rate. `samples` is how many samples the periods cover. `phasor`, shape
    (bins,), are the bins as peak amplitudes of cosines, with their phase at the first sample of the periods.
    """

    periods: int
    samples: float
    phasor: NDArray[np.complex128]

    @property
    def fundamental_Hz(self) -> float:
        return float(self.frequency_Hz[self.periods])

    @property
    def duration_s(self) -> float:
        return self.periods / self.fundamental_Hz

    @property
    def fundamental(self) -> float:
        """Peak amplitude of the fundamental."""
        return float(self.amplitude[self.periods])

    @property
    def harmonic_phase_rad(self) -> NDArray[np.float64]:
        """Phase of harmonics 1, 2, 3 ... as cosines at the first sample of the periods."""
        return np.angle(self.phasor[self.periods :: self.periods])

    def resampling_error(
        self, amplitude: float, order: float, largest: tuple[float, float] | None = None
    ) -> float:
        """Return the standard uncertainty that the resampling leaves in an amplitude of that order.

        Its bound of `gain_error` of the amplitude and a third of that of the `largest` line, an order and its
        amplitude, by default the fundamental, evenly distributed (JCGM 100:2008, 4.3.7).
        """
        largest_order, largest_amplitude = largest or (1.0, self.fundamental)
        cycles = self.periods / self.samples  # of the fundamental, a sample
        own, other = (gain_error(each * cycles) for each in (order, largest_order))
        return (own * amplitude + other / 3.0 * largest_amplitude) / math.sqrt(3.0)


@dataclass(frozen=True)
class Component:
    """One line of a spectrum."""

    frequency_Hz: float
    amplitude: float


def amplitude_spectrum(
    samples: NDArray[np.float64], sample_rate_Hz: float, window: WindowName = "hann"
) -> Spectrum:
    """Return one-sided amplitude spectrum of the whole record, shape (n,), under an amplitude-correct window.

    A sinusoid on a bin reads its peak amplitude; between bins a Hann window reads up to 15 % low
    (1.42 dB), a flat-top window 0.1 % (0.01 dB); side lobes of the Hann window begin at -31.5 dB (Harris,
    Proc. IEEE 66 (1978), no. 1).

    Raises:
        AnalysisError: too short, not finite, constant, not of shape (n,), or a rate that is not positive.
    """
    require_rate(sample_rate_Hz)
    samples = as_samples(samples)
    require_signal(samples, "signal")
    weights = spectral_window(window, len(samples))
    amplitude = 2.0 * np.abs(fft.rfft(samples * weights)) / np.sum(weights)
    amplitude[0] /= 2.0
    if len(samples) % 2 == 0:
        amplitude[-1] /= 2.0
    frequency_Hz = np.asarray(fft.rfftfreq(len(samples), 1.0 / sample_rate_Hz), dtype=np.float64)
    return Spectrum(frequency_Hz, amplitude)


def coherent_samples(
    samples: NDArray[np.float64],
    sample_rate_Hz: float,
    track: PhaseTrack,
    name: str = "signal",
    *,
    every: bool = False,
) -> CoherentSamples:
    """Return the signal at equal steps of the phase of `track`, over the most whole periods that fit.

    `samples`, shape (n,), are interpolated band-limited; 32 at either end only feed the interpolation.
    Beyond 100 periods their number is the next lower one without prime factors above 11, at most 5 % less,
    because a long transform of a large prime takes twenty times as long; `every` period is for what is not
    transformed.

    Raises: as `coherent_samples_of_all`.
    """
    return coherent_samples_of_all({name: samples}, sample_rate_Hz, track, every=every)[0]


def coherent_samples_of_all(
    signals: Mapping[str, NDArray[np.float64]],
    sample_rate_Hz: float,
    track: PhaseTrack,
    *,
    every: bool = False,
) -> tuple[CoherentSamples, ...]:
    """`coherent_samples` of signals that were sampled together, by name, for little more than one takes.

    Raises:
        AnalysisError: too short (fewer than two periods), not finite, constant, not of shape (n,), a rate
            that is not positive, or the fundamental is beyond the usable band or not above zero all along.
    """
    require_rate(sample_rate_Hz)
    columns = [as_samples(samples, name) for name, samples in signals.items()]
    for name, samples in zip(signals, columns, strict=True):
        require_signal(samples, name)
    name, count = ", ".join(signals), len(columns[0])
    passed = track.at(np.linspace(0.0, count - 1.0, _PLACES))
    if float(np.max(np.maximum.accumulate(passed) - passed)) > _GOES_BACK_RAD:
        raise AnalysisError(
            f"the frequency that was found for '{name}' goes through zero within {count} samples: choose a "
            f"window in which the machine turns one way"
        )
    first, last = FIRST_ROW, count - 1 - HALF_WIDTH
    begin, end = (float(each) for each in track.at(np.array([first, last], dtype=np.float64)))
    periods = math.floor((end - begin) / (2 * np.pi)) if last > first else 0
    if periods < _FEWEST_PERIODS:
        raise AnalysisError(
            f"'{name}' has {track.periods:.2f} electrical periods in {count} samples, at least "
            f"{_FEWEST_PERIODS} and {2 * HALF_WIDTH} samples are needed: record a longer window"
        )
    if not every:
        periods = transformable_periods(periods)
    covered = rows_of(track, periods)
    if USABLE_BAND * covered < periods:
        raise AnalysisError(
            f"the fundamental has {covered / periods:.2f} samples per period, more than "
            f"{1 / USABLE_BAND:.2f} are needed: record at a higher rate"
        )
    per_period = next_fast_length(math.ceil(covered / periods))
    values = np.empty((len(columns), per_period * periods))
    for start in range(0, values.shape[1], _CHUNK):
        part = values[:, start : start + _CHUNK]
        phase = begin + 2 * np.pi / per_period * np.arange(start, start + part.shape[1], dtype=np.float64)
        # the clip only takes up the rounding of Newton's method at the first sample
        part[:] = interpolate_all(columns, np.maximum(track.sample_numbers(phase), first))
    return tuple(CoherentSamples(each, periods, covered, sample_rate_Hz) for each in values)


def rows_of(track: PhaseTrack, periods: int) -> float:
    """Return how many rows the first so many periods of a spectrum cover."""
    end = track.at(np.array([float(FIRST_ROW)])) + 2 * np.pi * periods
    return float(track.sample_numbers(end)[0]) - FIRST_ROW


def transformable_periods(periods: int) -> int:
    """Return the most of so many periods whose transform is quick."""
    return previous_fast_length(periods) if periods > _ANY_PERIODS else periods


def coherent_spectrum(
    samples: NDArray[np.float64], sample_rate_Hz: float, track: PhaseTrack, name: str = "signal"
) -> CoherentSpectrum:
    """Return the DFT over whole periods of `track`, at equal steps of its phase: `spectrum_of`
    `coherent_samples`.

    Neither a drift of the speed nor a period of a fractional number of samples leaks the fundamental into
    other bins; the window is rectangular. Frequencies are orders times the mean fundamental. Error of an
    amplitude below 0.45 of the sample rate: under 1e-4 of itself plus 3e-5 of the largest component, and far
    less at low frequencies (`resampling.gain_error`).

    Raises:
        AnalysisError: too short (fewer than two periods), not finite, constant, not of shape (n,), a rate
            that is not positive, or the fundamental is beyond the usable band or not above zero all along.
    """
    return spectrum_of(coherent_samples(samples, sample_rate_Hz, track, name))


def spectrum_of(coherent: CoherentSamples) -> CoherentSpectrum:
    """Return the DFT of samples over whole periods."""
    periods, last = coherent.periods, math.floor(coherent.usable_order * coherent.periods)
    if last > periods and last % periods == 0:
        last -= 1  # of a harmonic with nothing above it the noise would not be known
    bins = fft.rfft(coherent.values)[: last + 1]
    bins *= 2.0 / len(coherent.values)
    bins[0] /= 2.0
    amplitude = np.abs(bins)
    frequency_Hz = np.arange(len(amplitude), dtype=np.float64)
    frequency_Hz *= coherent.sample_rate_Hz / coherent.samples
    return CoherentSpectrum(frequency_Hz, amplitude, periods, coherent.samples, bins)


def samples_of(spectrum: CoherentSpectrum, count: int) -> NDArray[np.float64]:
    """Return what a spectrum has at `count` equal steps over its periods, shape (count,), without the mean.

    Samples that were resampled have something beyond the band, too: what the interpolation folds there beats
    against the rows.
    """
    bins = spectrum.phasor * (0.5 * count)
    bins[0] = 0.0
    return np.asarray(fft.irfft(bins, count))


def harmonics(spectrum: CoherentSpectrum) -> NDArray[np.float64]:
    """Return the peak amplitudes of harmonics 1, 2, 3 ... up to the end of the band, shape (harmonics,)."""
    return spectrum.amplitude[spectrum.periods :: spectrum.periods]


def largest_low_component(spectrum: CoherentSpectrum, below_order: int = 10) -> Component:
    """Return largest bin below `below_order` times the fundamental, other than dc and the fundamental itself.

    Every bin counts, so sidebands and other interharmonics are caught as well; one that falls halfway between
    two bins reads 0.64 of its amplitude.
    """
    low = spectrum.amplitude[: below_order * spectrum.periods].copy()
    low[0] = low[spectrum.periods] = 0.0
    largest = int(np.argmax(low))
    return Component(float(spectrum.frequency_Hz[largest]), float(low[largest]))
