"""Amplitude spectra, one-sided, in peak amplitude: windowed, or coherent over whole electrical periods."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.signal import get_window

from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.resampling import HALF_WIDTH, USABLE_BAND, interpolate
from benchtool.analysis.validity import require_signal
from benchtool.errors import AnalysisError

_FEWEST_PERIODS = 2


@dataclass(frozen=True)
class Spectrum:
    """Peak amplitude over frequency, both of shape (bins,), dc first."""

    frequency_Hz: NDArray[np.float64]
    amplitude: NDArray[np.float64]


@dataclass(frozen=True)
class CoherentSpectrum(Spectrum):
    """Spectrum over `periods` whole periods: bin `k * periods` is exactly harmonic k.

    Bins end at 0.45 of the sample rate. `samples` is how many samples the periods cover.
    """

    periods: int
    samples: float

    @property
    def fundamental_Hz(self) -> float:
        return float(self.frequency_Hz[self.periods])


@dataclass(frozen=True)
class Component:
    """One line of a spectrum."""

    frequency_Hz: float
    amplitude: float


@dataclass(frozen=True)
class Distortion:
    """THD as a ratio to the fundamental, from harmonics 2 to `highest_harmonic`."""

    ratio: float
    highest_harmonic: int


def amplitude_spectrum(
    samples: NDArray[np.float64], sample_rate_Hz: float, window: Literal["hann", "flattop"] = "hann"
) -> Spectrum:
    """One-sided amplitude spectrum of the whole record, shape (n,), under an amplitude-correct window.

    A sinusoid on a bin reads its peak amplitude; between bins a Hann window reads up to 15 % low
    (1.42 dB), a flat-top window 0.1 % (Harris, Proc. IEEE 66 (1978), no. 1).

    Raises:
        AnalysisError: too short, not finite, or constant.
    """
    require_signal(samples, "signal")
    weights = get_window(window, len(samples))
    amplitude = 2.0 * np.abs(fft.rfft(samples * weights)) / np.sum(weights)
    amplitude[0] /= 2.0
    if len(samples) % 2 == 0:
        amplitude[-1] /= 2.0
    return Spectrum(fft.rfftfreq(len(samples), 1.0 / sample_rate_Hz), amplitude)


def coherent_spectrum(
    samples: NDArray[np.float64], sample_rate_Hz: float, track: PhaseTrack, name: str = "signal"
) -> CoherentSpectrum:
    """DFT over the most whole periods of `track` that fit, at equal steps of its phase.

    `samples`, shape (n,), are interpolated band-limited at equal steps of phase, so that neither a drift of
    the speed nor a period of a fractional number of samples leaks the fundamental into other bins; the window
    is rectangular. 32 samples at either end only feed the interpolation. Frequencies are orders times the
    mean fundamental. Error of an amplitude below 0.45 of the sample rate: under 1e-4 of itself plus 1e-6 of
    the largest component.

    Raises:
        AnalysisError: too short (fewer than two periods), not finite, constant, or the fundamental is beyond
            the usable band.
    """
    require_signal(samples, name)
    first, last = HALF_WIDTH - 1, len(samples) - 1 - HALF_WIDTH
    begin = float(track.phase(first))
    periods = math.floor((float(track.phase(last)) - begin) / (2 * np.pi)) if last > first else 0
    if periods < _FEWEST_PERIODS:
        raise AnalysisError(
            f"'{name}' has {track.periods:.2f} electrical periods in {len(samples)} samples, at least "
            f"{_FEWEST_PERIODS} and {2 * HALF_WIDTH} samples are needed: record a longer window"
        )
    covered = float(track.sample_numbers(np.array([begin + 2 * np.pi * periods]))[0]) - first
    usable_order = USABLE_BAND * covered / periods
    if usable_order < 1.0:
        raise AnalysisError(
            f"the fundamental has {covered / periods:.2f} samples per period, more than "
            f"{1 / USABLE_BAND:.2f} are needed: record at a higher rate"
        )
    per_period = fft.next_fast_len(math.ceil(covered / periods), real=True)
    phase = begin + 2 * np.pi / per_period * np.arange(per_period * periods, dtype=np.float64)
    # the clip only takes up the rounding of Newton's method at the first sample
    positions = np.maximum(track.sample_numbers(phase), first)
    bins = fft.rfft(interpolate(samples, positions))[: math.floor(usable_order * periods) + 1]
    amplitude = 2.0 / len(positions) * np.abs(bins)
    amplitude[0] /= 2.0
    frequency_Hz = sample_rate_Hz / covered * np.arange(len(amplitude), dtype=np.float64)
    return CoherentSpectrum(frequency_Hz, amplitude, periods, covered)


def harmonics(spectrum: CoherentSpectrum) -> NDArray[np.float64]:
    """Peak amplitudes of harmonics 1, 2, 3 ... up to the end of the band, shape (harmonics,)."""
    return spectrum.amplitude[spectrum.periods :: spectrum.periods]


def total_harmonic_distortion(spectrum: CoherentSpectrum, highest_harmonic: int = 50) -> Distortion:
    """THD = sqrt(sum over k = 2 ... H of A_k^2) / A_1 (IEC 61000-4-7, 3.3), with interharmonics left out.

    H is `highest_harmonic` or the last one in the band; the ratio is nan if the fundamental is zero.
    """
    amplitude = harmonics(spectrum)[:highest_harmonic]
    fundamental = float(amplitude[0])
    others = float(np.linalg.norm(amplitude[1:]))
    return Distortion(others / fundamental if fundamental > 0.0 else math.nan, len(amplitude))


def largest_low_component(spectrum: CoherentSpectrum, below_order: int = 10) -> Component:
    """Largest bin below `below_order` times the fundamental, other than dc and the fundamental itself.

    Every bin counts, so sidebands and other interharmonics are caught as well; one that falls halfway between
    two bins reads 0.64 of its amplitude.
    """
    low = spectrum.amplitude[: below_order * spectrum.periods].copy()
    low[0] = low[spectrum.periods] = 0.0
    largest = int(np.argmax(low))
    return Component(float(spectrum.frequency_Hz[largest]), float(low[largest]))
