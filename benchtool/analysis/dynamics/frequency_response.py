"""Frequency response of one channel to another, with coherence and uncertainty at each frequency.

The H1 estimate S_xy / S_xx, which noise in the output does not bias; of noise, a sweep or a single event,
which has power at every frequency, a fit over neighbouring frequencies. Random error of gain, relative, and
of phase, in rad: sqrt((1 - c) / (2 n c)) with the coherence c and n averages (Bendat and Piersol, Random
Data, chapters 6 and 9), the noise (1 - c) S_yy taken from neighbouring frequencies and n - 1 in place of n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.dynamics.local_polynomial import REACH, degrees_of_freedom, local_fit
from benchtool.analysis.quantisation import counting_step
from benchtool.analysis.repeated_steps import noise_beside, repeated_steps
from benchtool.analysis.validity import require_signal
from benchtool.block import as_samples, read_only, require_rate
from benchtool.errors import AnalysisError

COHERENT = 0.8
"""Least coherence of a frequency that is used; higher where averages are few."""

EXCITED = 1e-5
"""Least input power of a frequency that is used, of the greatest there is: 50 dB below it."""

WELL_EXCITED = 1e-2
"""Least input power, of the greatest, of the frequency that gives the reference gain."""

REPEATED = 0.8
"""Least share of the input's power that is the same in every period."""

NEPER_DB = 20.0 / math.log(10.0)
"""dB of a small relative change of a gain, over that change."""

FEWEST_PERIODS = 2
_ENOUGH_PERIODS, _ENOUGH_TRUSTED = 4, 0.25  # of fewer periods: least share of the frequencies that are used
_FEWEST_SEGMENTS = 4
_BY_CHANCE = 0.05  # probability that noise alone passes for coherent at one of all frequencies
_SEGMENTS = 16  # of the record, half overlapping, unless the caller says otherwise
_NEAR, _STEP_NEAR = 16, 2  # so many reaches from zero frequency a fit stands at every second bin
_DENSE = 5.0  # bins of 17: a sweep uses most, noise half, an input that repeats itself four times a quarter
_REST_SHARE = 0.01  # of the record, at either end
_AT_REST = 1e-3  # rms deviation there over that of all
_NOTHING = 1e-30  # of the noise: a response below it is not detected
_LINE = 3.0  # times the noise of its neighbours: a disturbance at one frequency
_FEWEST_LEVELS = 16  # of a converter; fewer are those of a stimulus
_OVERLAP_LOSS = 2.0 / 36.0  # twice the squared correlation of half-overlapping Hann windows, (1/6)^2


@dataclass(frozen=True)
class FrequencyResponse:
    """Response at `frequency_Hz`, dc left out; every array has shape (bins,) and is read-only.

    `response` is output over input, complex; `error` the standard uncertainty of its gain relative to the
    gain, and of its phase in rad; `shared` is how many of these frequencies rest on the same bins and tell as
    much as one; `trusted` where the input has power and the coherence is high enough.
    `averages` is the number of independent spectra (of a fit, its degrees of freedom), `samples` how many
    samples they cover, and `method` says in words how they were made. `well_excited` are those with more than
    a hundredth of the input's greatest power.
    """

    frequency_Hz: NDArray[np.float64]
    response: NDArray[np.complex128]
    coherence: NDArray[np.float64]
    error: NDArray[np.float64]
    shared: NDArray[np.float64]
    excited: NDArray[np.bool_]
    well_excited: NDArray[np.bool_]
    averages: float
    samples: int
    method: str

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value))

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
    def reference(self) -> int:
        """Index of the frequency whose gain the others are compared with.

        The lowest that is trusted and well excited, with an error of at most 1 % or three times the median of
        the trusted; the lowest trusted if there is none such.
        """
        trusted = self.trusted
        largest = max(0.01, 3.0 * float(np.median(self.error[trusted]))) if np.any(trusted) else 0.0
        known = trusted & self.well_excited & (self.error <= largest)
        return int(np.argmax(known if np.any(known) else trusted))

    @property
    def error_of_many(self) -> NDArray[np.float64]:
        """Errors to use where the frequencies are combined as if their errors were uncorrelated."""
        return np.asarray(self.error * np.sqrt(self.shared))

    @property
    def gain(self) -> NDArray[np.float64]:
        return np.abs(self.response)

    @property
    def gain_dB(self) -> NDArray[np.float64]:
        return decibels(self.response)

    @property
    def phase_rad(self) -> NDArray[np.float64]:
        """Phase without jumps between trusted frequencies, the first within +-pi; nan at the others."""
        phase = np.full(len(self.response), math.nan)
        phase[self.trusted] = np.unwrap(np.angle(self.response[self.trusted]))
        return phase


def decibels(ratio: NDArray[np.complex128] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the magnitude of ratios in dB; zero counts as the smallest positive number."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(ratio), np.finfo(np.float64).tiny)))


def frequency_response(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    *,
    period: int | None = None,
    segment: int | None = None,
    names: tuple[str, str] = ("input", "output"),
) -> FrequencyResponse:
    """Return the response of output `y` to input `x`, both of shape (n,), sampled together.

    An input that repeats itself is transformed over its whole `period` of samples, without a window and so
    without leakage, if the record holds four periods or more, or two that tell enough of the response. One
    with power at every frequency, as noise or a sweep has, is transformed over the whole record at once:
    `local_response`. Otherwise Welch's half-overlapping segments under a Hann window are averaged: `segment`
    samples each, by default so many that the record holds 16; a response that lasts longer than a segment, or
    a delay of much of one, is biased low.

    Raises:
        AnalysisError: a signal is dead, too short, or of another length than the other, the rate is not
            positive, or the input does not repeat itself after `period`.
    """
    require_rate(sample_rate_Hz)
    x, y = as_samples(x, names[0]), as_samples(y, names[1])
    for samples, name in ((x, names[0]), (y, names[1])):
        require_signal(samples, name)
    if len(x) != len(y):
        raise AnalysisError(
            f"'{names[0]}' has {len(x)} samples and '{names[1]}' {len(y)}, as many of each are needed: "
            f"take both from one capture"
        )
    if period is not None and len(x) >= FEWEST_PERIODS * period:
        found = periodic_response(x, y, sample_rate_Hz, period)
        used, excited = np.count_nonzero(found.trusted), np.count_nonzero(found.well_excited)
        if len(x) >= _ENOUGH_PERIODS * period or used >= _ENOUGH_TRUSTED * excited:
            return found
    if period is None and segment is None and is_dense(x):
        return local_response(x, y, sample_rate_Hz)
    return averaged_response(x, y, sample_rate_Hz, segment)


def periodic_response(
    x: NDArray[np.float64], y: NDArray[np.float64], sample_rate_Hz: float, period: int
) -> FrequencyResponse:
    """Return response to an input that repeats itself every `period` samples, over the most whole periods.

    Rectangular window of one period, less the line that the means of the periods drift along, which would be
    the same in all. S_xy and S_xx are sums over the periods, so that the coherence and the error are those of
    what differs from period to period, and of the steps of a converter, which are the same in all. Components
    that repeat with the input, such as harmonics generated by the system, appear as response.

    Raises:
        AnalysisError: fewer than two periods, or less than 0.8 of the input's power is the same in all.
    """
    periods = len(x) // period
    if periods < FEWEST_PERIODS:
        raise AnalysisError(
            f"{len(x)} samples hold {periods} whole periods of {period}, at least {FEWEST_PERIODS} are "
            f"needed: repeat the stimulus more often and record it"
        )
    of_x, of_y = (_without_drift(each[: periods * period].reshape(periods, period)) for each in (x, y))
    x_bins, y_bins = (fft.rfft(each, axis=1)[:, 1:] for each in (of_x, of_y))
    s_xx, s_yy = (np.sum(np.abs(bins) ** 2, axis=0) for bins in (x_bins, y_bins))
    same = float(np.sum(np.abs(np.sum(x_bins, axis=0)) ** 2) / (periods * np.sum(s_xx)))
    if same < REPEATED:
        raise AnalysisError(
            f"{100 * same:.0f} % of the input's power repeats itself every {period} samples, at least "
            f"{100 * REPEATED:.0f} % is needed: state the period of the stimulus, or none"
        )
    s_xy = np.sum(np.conj(x_bins) * y_bins, axis=0)
    frequency_Hz = sample_rate_Hz / period * np.arange(1.0, len(s_xx) + 1.0)
    method = f"DFT over {periods} periods of {period} samples, rectangular window"
    found = _estimate(frequency_Hz, s_xx, s_yy, s_xy, float(periods), periods * period, method)
    steps = np.zeros(len(s_xx))
    for samples, power, table in ((x, s_xx, of_x), (y, s_yy, of_y)):
        steps += _of_steps(samples[: periods * period], table) / np.maximum(power, np.finfo(np.float64).tiny)
    if not np.any(steps):
        return found
    error = np.sqrt(found.error**2 + 0.5 * steps)
    coherence = np.minimum(found.coherence, 1.0 / (1.0 + 2.0 * periods * error**2))
    return replace(found, error=error, coherence=coherence)


def _of_steps(samples: NDArray[np.float64], table: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power in each bin, summed over the periods, of the errors of a converter's steps that are
    the same in each; `table` are the samples in shape (periods, period)."""
    periods, period = table.shape
    bins, step = period // 2, counting_step(samples)
    if not step > 0.0 or len(np.unique(samples)) < _FEWEST_LEVELS:
        return np.zeros(bins)
    phasors = fft.rfft(np.mean(table, axis=0))[1:] * (2.0 / period)
    noise = noise_beside(float(np.mean(np.var(table, axis=0, ddof=1))), step)
    found = repeated_steps(float(np.mean(samples)), phasors, step, noise, float(len(samples)), periods)
    if found is None:
        return np.zeros(bins)
    return np.asarray(periods * (0.5 * period) ** 2 * found.power_at(np.arange(1, bins + 1)))


def _without_drift(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return samples of shape (periods, period) less the least-squares line through their periods' means."""
    periods, period = samples.shape
    number = np.arange(periods) - 0.5 * (periods - 1.0)
    drift = float(number @ np.mean(samples, axis=1)) / float(number @ number)
    time = np.arange(samples.size).reshape(samples.shape) / period
    return np.asarray(samples - drift * (time - np.mean(time)))


def averaged_response(
    x: NDArray[np.float64], y: NDArray[np.float64], sample_rate_Hz: float, segment: int | None = None
) -> FrequencyResponse:
    """Return response by Welch's method, with half-overlapping Hann windows, each segment's mean taken out.

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

    from scipy import signal  # draws in scipy.stats, which takes longer than all else here

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


def is_dense(x: NDArray[np.float64]) -> bool:
    """Return whether an input, shape (n,), has power at most bins of its DFT, as noise or a sweep has, and an
    input that repeats itself has not."""
    power = np.abs(fft.rfft(x)[1:]) ** 2
    width = 2 * REACH + 1
    near = (
        np.lib.stride_tricks.sliding_window_view(power, width)[::width] if len(power) >= width else power[:0]
    )
    excited = near[np.mean(near, axis=-1) > WELL_EXCITED * np.max(power, initial=0.0)]
    if len(excited) == 0:
        return False
    # share of the bins that would hold equal power if the others had none
    used = np.sum(excited, axis=1) ** 2 / np.sum(excited**2, axis=1)
    return bool(np.median(used) >= _DENSE)


def local_response(
    x: NDArray[np.float64], y: NDArray[np.float64], sample_rate_Hz: float
) -> FrequencyResponse:
    """Return the response to noise, a sweep or a single event, by one DFT of the whole record, rectangular
    window.

    Around each eighth bin, of the lowest 128 around each second, the response and what the ends of the record
    leave in are fitted to 17 bins (`local_polynomial`); where the input is constant over the first and the
    last hundredth of the record, nothing is left in. `coherence` is what the error of the fit amounts to, c
    of sqrt((1 - c) / (2 n c)).

    Raises:
        AnalysisError: too short for one fit.
    """
    x_bins, y_bins = fft.rfft(x)[1:], fft.rfft(y)[1:]
    last = len(x_bins) - REACH
    near = min(_NEAR * REACH, last)
    at = np.concatenate([np.arange(REACH, near, _STEP_NEAR), np.arange(near, last, REACH)])
    if len(at) == 0:
        raise AnalysisError(
            f"{len(x)} samples are too few for a response, at least {4 * (REACH + 1)} are needed: record "
            f"longer"
        )
    at_rest = _begins_and_ends_at_rest(x)
    found = local_fit(x_bins, y_bins, at, at_rest=at_rest)
    freedom = degrees_of_freedom(at_rest=at_rest)
    greatest = float(np.max(found.power))
    frequency_Hz = sample_rate_Hz / len(x) * (at + np.ones(len(at)))
    shared = np.where(at < near, REACH / _STEP_NEAR, 1.0)
    ends = "at rest at both ends" if at_rest else "with a line for what its ends leave in"
    return FrequencyResponse(
        frequency_Hz=frequency_Hz,
        response=found.response,
        coherence=1.0 / (1.0 + 2.0 * freedom * found.error**2),
        error=found.error,
        shared=shared,
        excited=found.power > EXCITED * greatest,
        well_excited=found.power > WELL_EXCITED * greatest,
        averages=float(freedom),
        samples=len(x),
        method=f"DFT of all {len(x)} samples, rectangular window; a parabola over {2 * REACH + 1} bins, "
        f"{ends}",
    )


def _begins_and_ends_at_rest(x: NDArray[np.float64]) -> bool:
    rows = max(2, math.ceil(_REST_SHARE * len(x)))
    largest = _AT_REST * float(np.std(x))
    # at the same value: a step between the ends would be a transient of the periodic continuation
    ends = np.concatenate([x[:rows], x[-rows:]])
    return bool(np.max(np.abs(ends - x[0])) <= largest)


def _noise_power(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power of the noise at every frequency, shape (bins,), estimated from few averages.

    At one frequency it scatters, and a fit that weights by it would follow where it is small by chance: the
    mean of a frequency and its neighbours, or its own where that stands out as a line does.
    """
    from scipy import ndimage

    mean = ndimage.uniform_filter1d(found, min(2 * REACH + 1, len(found)), mode="nearest")
    return np.asarray(np.where(found > _LINE * mean, found, mean))


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
    excited, well_excited = (s_xx > share * np.max(s_xx) for share in (EXCITED, WELL_EXCITED))
    coherence = np.minimum(1.0, np.abs(s_xy) ** 2 / np.maximum(s_xx * s_yy, tiny))
    noise = _noise_power(s_yy * (1.0 - coherence) / (averages - 1.0))
    error = np.sqrt(noise / np.maximum(2.0 * coherence * s_yy, _NOTHING * noise + tiny))
    response = s_xy / np.maximum(s_xx, tiny)
    return FrequencyResponse(
        frequency_Hz,
        response,
        coherence,
        error,
        np.ones(len(error)),
        excited,
        well_excited,
        averages,
        samples,
        method,
    )
