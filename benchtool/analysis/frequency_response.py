"""Frequency response of one channel to another, with its coherence and what it is worth at each frequency.

The H1 estimate S_xy / S_xx, which noise in the output does not bias. Random error of gain, relative, and of
phase, in rad: sqrt((1 - c) / (2 n c)) with the coherence c and n averages (Bendat and Piersol, Random Data,
chapters 6 and 9).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, signal

from benchtool.analysis.validity import require_signal
from benchtool.errors import AnalysisError

COHERENT = 0.8
"""Least coherence of a frequency that is used; more where few averages leave more to chance."""

EXCITED = 1e-5
"""Least input power of a frequency that is used, of the greatest there is: 50 dB below it."""

FEWEST_PERIODS = 4
_FEWEST_SEGMENTS = 4
_BY_CHANCE = 0.05  # probability that noise alone passes for coherent at one of all frequencies
_SEGMENTS = 16  # of the record, half overlapping, unless the caller says otherwise
_OVERLAP_LOSS = 2.0 / 36.0  # twice the squared correlation of half-overlapping Hann windows, (1/6)^2


@dataclass(frozen=True)
class FrequencyResponse:
    """Response at `frequency_Hz`, dc left out; every array has shape (bins,).

    `response` is output over input, complex; `error` the standard uncertainty of its gain relative to the
    gain, and of its phase in rad; `trusted` where the input has power and the coherence is high enough.
    `averages` is the number of independent spectra, `samples` how many samples they cover, and `method` says
    in words how they were made.
    """

    frequency_Hz: NDArray[np.float64]
    response: NDArray[np.complex128]
    coherence: NDArray[np.float64]
    error: NDArray[np.float64]
    excited: NDArray[np.bool_]
    averages: float
    samples: int
    method: str

    @property
    def least_coherence(self) -> float:
        """What is asked of a frequency: 0.8, or what noise reaches at one of them in a response of twenty.

        Of n averages, independent signals exceed a coherence c with probability (1 - c)^(n - 1) (Carter,
        Proc. IEEE 75 (1987) no. 2).
        """
        share = _BY_CHANCE / len(self.coherence)
        return max(COHERENT, 1.0 - math.pow(share, 1.0 / (self.averages - 1.0)))

    @property
    def trusted(self) -> NDArray[np.bool_]:
        return self.excited & (self.coherence >= self.least_coherence)

    @property
    def gain(self) -> NDArray[np.float64]:
        return np.abs(self.response)

    @property
    def gain_dB(self) -> NDArray[np.float64]:
        return 20.0 * np.log10(np.maximum(self.gain, np.finfo(np.float64).tiny))

    @property
    def phase_rad(self) -> NDArray[np.float64]:
        """Phase without jumps between trusted frequencies, the first within +-pi; nan at the others."""
        phase = np.full(len(self.response), math.nan)
        phase[self.trusted] = np.unwrap(np.angle(self.response[self.trusted]))
        return phase


def frequency_response(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    *,
    period: int | None = None,
    segment: int | None = None,
    names: tuple[str, str] = ("input", "output"),
) -> FrequencyResponse:
    """Response of output `y` to input `x`, both of shape (n,), sampled together.

    An input that repeats itself is transformed over its whole `period` of samples, without a window and so
    without leakage, if the record holds four periods or more. Otherwise Welch's half-overlapping segments
    under a Hann window are averaged: `segment` samples each, by default so many that the record holds 16; a
    response that lasts longer than a segment, or a delay of much of one, is biased low.

    Raises:
        AnalysisError: a signal is dead, too short, or of another length than the other.
    """
    for samples, name in ((x, names[0]), (y, names[1])):
        require_signal(samples, name)
    if len(x) != len(y):
        raise AnalysisError(
            f"'{names[0]}' has {len(x)} samples and '{names[1]}' {len(y)}, as many of each are needed: "
            f"take both from one capture"
        )
    if period is not None and len(x) >= FEWEST_PERIODS * period:
        return periodic_response(x, y, sample_rate_Hz, period)
    return averaged_response(x, y, sample_rate_Hz, segment)


def periodic_response(
    x: NDArray[np.float64], y: NDArray[np.float64], sample_rate_Hz: float, period: int
) -> FrequencyResponse:
    """Response to an input that repeats itself every `period` samples, over the most whole periods.

    Rectangular window of one period; S_xy and S_xx are sums over the periods, so that the coherence and the
    error are those of what differs from period to period. What repeats with the input, as harmonics made by
    the system do, looks like its response.

    Raises:
        AnalysisError: fewer than four periods.
    """
    periods = len(x) // period
    if periods < FEWEST_PERIODS:
        raise AnalysisError(
            f"{len(x)} samples hold {periods} whole periods of {period}, at least {FEWEST_PERIODS} are "
            f"needed: repeat the stimulus more often and record it"
        )
    x_bins, y_bins = (
        fft.rfft(samples[: periods * period].reshape(periods, period), axis=1)[:, 1:] for samples in (x, y)
    )
    s_xx, s_yy = (np.sum(np.abs(bins) ** 2, axis=0) for bins in (x_bins, y_bins))
    s_xy = np.sum(np.conj(x_bins) * y_bins, axis=0)
    frequency_Hz = sample_rate_Hz / period * np.arange(1.0, len(s_xx) + 1.0)
    method = f"DFT over {periods} periods of {period} samples, rectangular window"
    return _estimate(frequency_Hz, s_xx, s_yy, s_xy, float(periods), periods * period, method)


def averaged_response(
    x: NDArray[np.float64], y: NDArray[np.float64], sample_rate_Hz: float, segment: int | None = None
) -> FrequencyResponse:
    """Response by Welch's method, with half-overlapping Hann windows, each segment's mean taken out.

    Overlapping segments are not independent: `averages` is less than their number by Welch's variance
    (IEEE Trans. Audio Electroacoust. 15 (1967) no. 2).

    Raises:
        AnalysisError: fewer than four segments.
    """
    size = segment or max(2, 2 * len(x) // (_SEGMENTS + 1))
    segments = 2 * len(x) // size - 1
    if segments < _FEWEST_SEGMENTS or size < 2:
        raise AnalysisError(
            f"{len(x)} samples hold {max(0, segments)} half-overlapping segments of {size}, at least "
            f"{_FEWEST_SEGMENTS} are needed: record longer or choose shorter segments"
        )

    def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.complex128]:
        spectrum = signal.csd(a, b, sample_rate_Hz, window="hann", nperseg=size, noverlap=size // 2)[1]
        return np.asarray(spectrum, dtype=np.complex128)

    frequency_Hz = sample_rate_Hz / size * np.arange(size // 2 + 1, dtype=np.float64)
    s_xx, s_yy, s_xy = cross(x, x).real, cross(y, y).real, cross(x, y)
    averages = segments / (1.0 + _OVERLAP_LOSS * (segments - 1) / segments)
    method = f"Welch's average of {segments} segments of {size} samples, half overlapping, Hann window"
    kept = slice(2, None)  # dc and its neighbour, into which the window spreads what is left of the mean
    return _estimate(
        frequency_Hz[kept], s_xx[kept], s_yy[kept], s_xy[kept], averages, len(x) // size * size, method
    )


def _estimate(
    frequency_Hz: NDArray[np.float64],
    s_xx: NDArray[np.float64],
    s_yy: NDArray[np.float64],
    s_xy: NDArray[np.complex128],
    averages: float,
    samples: int,
    method: str,
) -> FrequencyResponse:
    tiny = np.finfo(np.float64).tiny
    excited = s_xx > EXCITED * np.max(s_xx)
    coherence = np.minimum(1.0, np.abs(s_xy) ** 2 / np.maximum(s_xx * s_yy, tiny))
    error = np.sqrt((1.0 - coherence) / (2.0 * averages * np.maximum(coherence, tiny)))
    response = s_xy / np.maximum(s_xx, tiny)
    return FrequencyResponse(frequency_Hz, response, coherence, error, excited, averages, samples, method)
