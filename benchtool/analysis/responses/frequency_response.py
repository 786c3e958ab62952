"""Frequency response of one channel to another, with coherence and uncertainty at each frequency.

Of an input that repeats itself the ratio of the means over its periods (`periodic_response`); of noise, a
sweep or a single event, which has power at every frequency, a fit over neighbouring frequencies; otherwise
the H1 estimate S_xy / S_xx, which noise in the output does not bias.

Within a loop the input holds the noise of the output, that the controller feeds back, and those estimates
tend to -1 over the controller. With the stimulus r of the loop, which holds no noise, the response is the
ratio S_ry / S_rx of the responses of output and input to it (joint input-output, or instrumental variable:
Pintelon and Schoukens, System Identification, 2nd ed., 2.6; Söderström and Stoica, chapters 8 and 10).

Random error of the gain, relative, and of the phase, in rad: sqrt((1 - c) / (2 n c)) with the coherence c and
n averages (Bendat and Piersol, Random Data, chapters 6 and 9), the noise, that of output less response times
input, taken from neighbouring frequencies and n - 1 in place of n.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.output_steps import errors_of_equal_readings, errors_of_output_steps
from benchtool.analysis.quantisation.swept_steps import error_of_input_steps, errors_of_steps
from benchtool.analysis.responses.drift_between_rests import drift_between_rests
from benchtool.analysis.responses.estimated_response import (
    EXCITED,
    NO_NOISE,
    WELL_EXCITED,
    FrequencyResponse,
    coherence_of,
    noise_power,
)
from benchtool.analysis.responses.local_polynomial import (
    REACH,
    LocalFit,
    degrees_of_freedom,
    indirect_fit,
    local_fit,
    telling,
)
from benchtool.analysis.responses.periodic_response import (
    ENOUGH_PERIODS,
    FEWEST_PERIODS,
    period_of,
    periodic_response,
    periods_setting_in,
)
from benchtool.analysis.responses.swept_input import InputNoise, input_noise
from benchtool.analysis.validity import require_signal
from benchtool.block import as_samples, require_rate
from benchtool.errors import AnalysisError

_ENOUGH_TRUSTED = 0.25  # of fewer periods: least share of the frequencies that are used
_FEWEST_SEGMENTS, _SHORTEST_SEGMENT = 4, 4  # below, no frequency is left beside dc and its neighbour
_SEGMENTS = 16  # of the record, half overlapping, unless the caller says otherwise
_NEAR, _STEP_NEAR = 16, 2  # so many reaches from zero frequency a fit stands at every second bin
_DENSE = 5.0  # bins of 17: a sweep uses most, noise half, an input that repeats itself four times a quarter
_REST_SHARE = 0.01  # of the record, at either end
_AT_REST = 1e-3  # rms deviation there over that of all
_ALIKE = 8.0  # frequencies of the lowest over which what is left of a drift is the same
_NOTHING = 1e-30  # of the noise: a response below it is not detected
_OF_CORRECTION = 0.25  # of what noise of a sweeping input biases: its standard uncertainty
_OVERLAP_LOSS = 2.0 / 36.0  # twice the squared correlation of half-overlapping Hann windows, (1/6)^2


def frequency_response(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    *,
    stimulus: NDArray[np.float64] | None = None,
    period: int | None = None,
    segment: int | None = None,
    names: tuple[str, str, str] = ("input", "output", "stimulus"),
) -> FrequencyResponse:
    """Return the response of output `y` to input `x`, both of shape (n,), sampled together.

    An input that repeats itself is transformed over its whole `period` of samples, without a window and so
    without leakage, if the record holds four periods or more, or two that tell enough of the response; a
    period that is not stated but shows in the input counts from four on, and periods in which the answer
    sets in are left out (`periods_setting_in`). One
    with power at every frequency, as noise or a sweep has, is transformed over the whole record at once:
    `local_response`. Otherwise Welch's half-overlapping segments under a Hann window are averaged: `segment`
    samples each, by default so many that the record holds 16; a response that lasts longer than a segment, or
    a delay of much of one, is biased low.

    With the samples of a `stimulus`, what excites a loop that holds the input, all this is said of it in
    place of the input, and noise that goes around the loop is no part of the response.

    Raises:
        AnalysisError: a signal is dead, too short, or of another length than the other, the rate is not
            positive, or what excites does not repeat itself after `period`.
    """
    require_rate(sample_rate_Hz)
    x, y = as_samples(x, names[0]), as_samples(y, names[1])
    r = x if stimulus is None else as_samples(stimulus, names[2])
    for samples, name in zip((x, y, r), names, strict=True):
        require_signal(samples, name)
        if len(x) != len(samples):
            raise AnalysisError(
                f"'{names[0]}' has {len(x)} samples and '{name}' {len(samples)}, as many of each are needed: "
                f"take both from one capture"
            )
    if period is not None and len(x) >= FEWEST_PERIODS * period:
        found = _over_periods(x, y, sample_rate_Hz, period, stimulus)
        used, excited = np.count_nonzero(found.trusted), np.count_nonzero(found.well_excited)
        if len(x) >= ENOUGH_PERIODS * period or used >= _ENOUGH_TRUSTED * excited:
            return found
    if period is None and segment is None:
        if is_dense(r):
            return local_response(x, y, sample_rate_Hz, stimulus)
        if (own := period_of(r)) is not None:
            return _over_periods(x, y, sample_rate_Hz, own, stimulus)
    return averaged_response(x, y, sample_rate_Hz, segment, stimulus)


def _over_periods(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    period: int,
    stimulus: NDArray[np.float64] | None,
) -> FrequencyResponse:
    """Return a response over the periods of an input in which the answer has set in."""
    first = periods_setting_in(x, y, period, stimulus)
    rows = slice(first * period, None)
    x, y, r = x[rows], y[rows], None if stimulus is None else stimulus[rows]
    found = _with_output_steps(periodic_response(x, y, sample_rate_Hz, period, r), x, y, period)
    text = f", after {first} in which the answer sets in"
    return replace(found, method=found.method + text) if first else found


def _with_output_steps(
    found: FrequencyResponse, x: NDArray[np.float64], y: NDArray[np.float64], period: int
) -> FrequencyResponse:
    """Return a response over periods with what the steps of a converter do alike at its frequencies: an
    output that rests at few values, as after the bits of a sequence, is read there by the same error each
    time."""
    at = np.flatnonzero(found.excited & (found.gain > 0.0))
    if len(at) < 2 * REACH:
        return found
    periods = y[: len(y) // period * period].reshape(-1, period)
    variance = float(np.mean(np.var(periods, axis=0, ddof=1)))
    of_steps, alike, in_common = errors_of_equal_readings(
        x[:period], periods[0], variance, found.response[at], at
    )
    if not in_common > 0.0:
        return found
    error, shared = found.error.copy(), found.shared.copy()
    error[at], shared[at] = _together(error[at], shared[at], of_steps, alike)
    coherence = coherence_of(error, found.averages)
    return replace(found, error=error, shared=shared, coherence=coherence, at_rest=in_common)


def averaged_response(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    segment: int | None = None,
    stimulus: NDArray[np.float64] | None = None,
) -> FrequencyResponse:
    """Return response by Welch's method, with half-overlapping Hann windows, each segment's mean taken out.

    Without a stimulus the input is its own.

    Overlapping segments are not independent: `averages` is less than their number by Welch's variance
    (IEEE Trans. Audio Electroacoust. 15 (1967) no. 2).

    Raises:
        AnalysisError: fewer than four segments, or segments of fewer than four samples.
    """
    size = segment or max(_SHORTEST_SEGMENT, 2 * len(x) // (_SEGMENTS + 1))
    segments = 2 * len(x) // max(1, size) - 1
    if segments < _FEWEST_SEGMENTS or size < _SHORTEST_SEGMENT:
        raise AnalysisError(
            f"{len(x)} samples hold {max(0, segments)} half-overlapping segments of {size}, at least "
            f"{_FEWEST_SEGMENTS} of {_SHORTEST_SEGMENT} or more are needed: record longer or choose other "
            f"segments"
        )

    from scipy import signal  # draws in scipy.stats, which takes longer than all else here

    def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.complex128]:
        spectrum = signal.csd(a, b, sample_rate_Hz, window="hann", nperseg=size, noverlap=size // 2)[1]
        return np.asarray(spectrum, dtype=np.complex128)

    r = x if stimulus is None else stimulus
    averages = segments / (1.0 + _OVERLAP_LOSS * (segments - 1) / segments)
    kept = slice(2, None)  # dc and its neighbour, into which the window spreads what is left of the mean
    frequency_Hz = sample_rate_Hz / size * np.arange(size // 2 + 1, dtype=np.float64)[kept]
    s_rx, s_ry, s_yx = (cross(a, b)[kept] for a, b in ((r, x), (r, y), (y, x)))
    s_rr, s_xx, s_yy = (cross(each, each).real[kept] for each in (r, x, y))
    tiny = np.finfo(np.float64).tiny
    driven = np.abs(s_rx) ** 2 / np.maximum(s_rr, tiny)  # power of the input that the stimulus makes
    response = np.conj(s_rx) * s_ry / np.maximum(np.abs(s_rx) ** 2, tiny)
    size_2 = np.abs(response) ** 2
    left = np.maximum(s_yy - 2.0 * np.real(response * s_yx) + size_2 * s_xx, 0.0)
    shows = driven > NO_NOISE * np.maximum(s_xx - driven, 0.0) / (averages - 1.0)
    excited, well_excited = (shows & (s_rr > share * np.max(s_rr)) for share in (EXCITED, WELL_EXCITED))
    noise = noise_power(left / (averages - 1.0))
    by = "" if stimulus is None else ", by the stimulus"
    return FrequencyResponse(
        frequency_Hz=frequency_Hz,
        response=response,
        coherence=size_2 * driven / np.maximum(size_2 * driven + left, tiny),
        error=np.sqrt(noise / np.maximum(2.0 * size_2 * driven, _NOTHING * noise + tiny)),
        shared=np.ones(len(frequency_Hz)),
        excited=excited,
        well_excited=well_excited,
        averages=averages,
        samples=len(x) // size * size,
        method=f"Welch's average of {segments} segments of {size} samples, half overlapping, Hann window{by}",
    )


def is_dense(x: NDArray[np.float64]) -> bool:
    """Return whether an input, shape (n,), has power at most bins of its DFT, as noise or a sweep has, and an
    input that repeats itself has not."""
    power = np.abs(fft.rfft(x)[1:]) ** 2
    width = 2 * REACH + 1
    if len(power) < width:
        return False
    near = np.lib.stride_tricks.sliding_window_view(power, width)[::width]
    excited = near[np.mean(near, axis=1) > WELL_EXCITED * np.max(power)]
    if len(excited) == 0:
        return False
    # share of the bins that would hold equal power if the others had none
    used = np.sum(excited, axis=1) ** 2 / np.sum(excited**2, axis=1)
    return bool(np.median(used) >= _DENSE)


def _together(
    error: NDArray[np.float64],
    shared: NDArray[np.float64],
    added: NDArray[np.float64],
    alike: NDArray[np.float64] | float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return errors together with others, and how many frequencies tell as much as one: so many `shared` by
    the first and, by those that are added, as many as are `alike` where that is more."""
    both = np.hypot(error, added)
    own = np.divide(error, both, out=np.ones(len(both)), where=both > 0.0) ** 2
    return both, own * shared + (1.0 - own) * np.maximum(shared, alike)


def local_response(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    sample_rate_Hz: float,
    stimulus: NDArray[np.float64] | None = None,
) -> FrequencyResponse:
    """Return the response to noise, a sweep or a single event, by one DFT of the whole record, rectangular
    window.

    Around each eighth bin, of the lowest 128 around each second, the response and what the ends of the record
    leave in are fitted to 17 bins (`local_polynomial`); where the input is constant over the first and the
    last hundredth of the record, nothing is left in but a drift of the output between them, which is taken
    out, with what it may be in the errors. `coherence` is what the error of the fit amounts to.

    Raises:
        AnalysisError: too short for one fit.
    """
    r = x if stimulus is None else stimulus
    at_rest = _begins_and_ends_at_rest(r)
    drifts: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    if at_rest:
        of_y = drift_between_rests(r, y)
        y = y - of_y.course
        drifts.append((y, of_y.doubts))
        if stimulus is not None:
            of_x = drift_between_rests(r, x)
            x = x - of_x.course
            drifts.append((x, of_x.doubts))
    x_bins, y_bins = fft.rfft(x)[1:], fft.rfft(y)[1:]
    last = len(x_bins) - REACH
    near = min(_NEAR * REACH, last)
    at = np.concatenate([np.arange(REACH, near, _STEP_NEAR), np.arange(near, last, REACH)])
    if len(at) == 0:
        raise AnalysisError(
            f"{len(x)} samples are too few for a response, at least {4 * (REACH + 1)} are needed: record "
            f"longer"
        )
    noise = input_noise(r, y, (at + 1.0) / len(x))
    if stimulus is None:
        found = local_fit(x_bins, y_bins, at, at_rest=at_rest)
        if noise is not None and not at_rest:
            noise = replace(noise, share=noise.share / telling(x_bins, at))
        found, shows = _without_input_noise(found, noise)
    else:
        found = indirect = indirect_fit(fft.rfft(stimulus)[1:], x_bins, y_bins, at, at_rest=at_rest)
        shows = NO_NOISE * indirect.noise < 1.0
    freedom = degrees_of_freedom(at_rest=at_rest)
    greatest = float(np.max(found.power))
    frequency_Hz = sample_rate_Hz / len(x) * (at + np.ones(len(at)))
    shared = np.where(at < near, REACH / _STEP_NEAR, 1.0)
    of_r = found if stimulus is None else local_fit(fft.rfft(r)[1:], y_bins, at, at_rest=at_rest)
    in_common = 0.0
    if noise is not None:  # it sweeps
        of_steps, alike = errors_of_steps(r, y, np.abs(of_r.response))
        in_common = error_of_input_steps(x) if stimulus is None else 0.0
    else:
        of_steps, alike, in_common = errors_of_output_steps(r, y, of_r.response, at)
    error, shared = _together(found.error, shared, of_steps, alike)
    for samples, doubts in drifts:
        error, shared = _together(error, shared, _of_doubts(r, samples, doubts, at), _ALIKE)
    ends = "at rest at both ends" if at_rest else "with a line for what its ends leave in"
    by = "" if stimulus is None else ", by the stimulus"
    return FrequencyResponse(
        frequency_Hz=frequency_Hz,
        response=found.response,
        coherence=coherence_of(error, freedom + 1.0),
        error=error,
        shared=shared,
        excited=shows & (found.power > EXCITED * greatest),
        well_excited=shows & (found.power > WELL_EXCITED * greatest),
        averages=freedom + 1.0,
        samples=len(x),
        method=f"DFT of all {len(x)} samples, rectangular window; a parabola over {2 * REACH + 1} bins, "
        f"{ends}{by}",
        at_rest=in_common,
    )


def _of_doubts(
    r: NDArray[np.float64], y: NDArray[np.float64], doubts: NDArray[np.float64], at: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return what errors of an output `y`, shape (k, n), make of its response to `r`, relative to that, shape
    (m,)."""
    error = np.zeros(len(at))
    if len(doubts):
        r_bins = fft.rfft(r)[1:]
        size = np.abs(local_fit(r_bins, fft.rfft(y)[1:], at, at_rest=True).response)
        for doubt in doubts:
            made = np.abs(local_fit(r_bins, fft.rfft(doubt)[1:], at, at_rest=True).response)
            error = np.hypot(error, made / np.maximum(size, np.finfo(np.float64).tiny))
    return error


def _without_input_noise(found: LocalFit, noise: InputNoise | None) -> tuple[LocalFit, NDArray[np.bool_]]:
    """Return a response, shape (m,), without the bias by noise of an input that sweeps, and where there is
    little enough of that."""
    if noise is None:
        return found, np.ones(len(found.response), dtype=np.bool_)
    if noise.excites(found.response):
        return found, np.ones(len(found.response), dtype=np.bool_)
    response = noise.corrected(found.response)
    size = np.maximum(np.abs(response), np.finfo(np.float64).tiny)
    changed = np.abs(response - found.response)
    spread = np.hypot(found.error * np.abs(found.response), _OF_CORRECTION * changed)
    return replace(found, response=response, error=spread / size), noise.is_little


def _begins_and_ends_at_rest(x: NDArray[np.float64]) -> bool:
    rows = max(2, math.ceil(_REST_SHARE * len(x)))
    largest = _AT_REST * float(np.std(x))
    # at the same value: a step between the ends would be a transient of the periodic continuation
    ends = np.concatenate([x[:rows], x[-rows:]])
    return bool(np.max(np.abs(ends - x[0])) <= largest)
