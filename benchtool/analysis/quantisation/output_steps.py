"""Errors that the steps of a converter make of a response, where they are alike for all that it rests on.

An output that rests again and again at the same few values, as after the bits of a random binary sequence, is
read wrong there by the same part of a step each time. So is a sweep, where the amplitude is the same. No
residual shows it: the output that the response makes of the input is read in steps, for several outputs that
differ by part of a step, and the errors take the place of the output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import error_of_steps, noise_beside, share_left
from benchtool.analysis.quantisation.resolution import counting_step, level_of

_DRAWS, _SEED = 12, 20_261_128
_AT_REST = 0.5  # of the levels between the least and the greatest, never read
_LEAST_POWER = 1e-9  # of the greatest
_FEWEST_LEVELS = 4
_PARTS = 2  # even and odd bins: what is not alike is independent in them
_REACH = 16  # bins of a part to either side, over which an error that is alike adds up
_SMOOTHED = 9  # frequencies
_FOLLOWED = 3  # frequencies: more would not follow what rests
_ALIKE = 0.5  # of the power of one, in the mean of many
_MOST = 8  # frequencies
_ENDS = 0.05  # of the record, where the output is still that of an input before it

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


def errors_of_output_steps(
    x: Floats, y: Floats, response: Complex, at: NDArray[np.int64]
) -> tuple[Floats, Floats, float]:
    """Return the standard uncertainty of a response of `y` to `x`, both of shape (n,), relative to it, and
    over how many neighbours it is the same, both of the shape of `response`; and that of the gain of the
    steps alone, of which all frequencies have some (the best linear gain of what has no memory: Bussgang).
    Without steps these are zero, one and zero.

    `at` are the bins, dc left out, of the response.
    """
    step, none = counting_step(y), (np.zeros(len(at)), np.ones(len(at)), 0.0)
    if not step > 0.0 or np.ptp(y) < _FEWEST_LEVELS * step:
        return none
    x_bins = fft.rfft(x)[1:]
    followed, made = (_output(x_bins, each, at, len(x)) for each in (response, _smooth(response, at)))
    ends = max(1, round(_ENDS * len(y)))
    left = (y - np.mean(y) - followed)[ends:-ends]
    # what the response does not follow is no noise, and does not differ from row to row
    noise = noise_beside(min(float(np.var(left)), 0.5 * float(np.mean(np.diff(left) ** 2))), step)
    level, size = level_of(y, step) - float(np.mean(y)), 0.5 * float(np.ptp(made))
    outputs = (followed, made)  # one lies too near to the levels, the other rests less than it does
    drawn = []
    for number, part in enumerate((np.arange(_DRAWS) + 0.5) / _DRAWS - 0.5):
        made = outputs[number % len(outputs)]
        error = error_of_steps(made * (1.0 + part * step / size), step, noise, level)
        if error is None:
            return none
        drawn.append((error, made))
    return _of_errors(drawn, x_bins, _powers(x_bins), response, at)


def errors_of_equal_readings(
    x: Floats, y: Floats, variance: float, response: Complex, at: NDArray[np.int64]
) -> tuple[Floats, Floats, float]:
    """Return what `errors_of_output_steps` does, of one of several periods of `y` that the response follows
    with the errors of its steps: of rows with one reading these are the same, as likely anywhere in a step.

    So they are where the output rests at few values. An output that moves is anywhere within its levels, and
    between its least and its greatest it is read on nearly all of them: where half of them are never read it
    rests, and of fewer what is in common has as much less power. None of an input of few lines, and
    `variance` is that between periods.
    """
    step, none = counting_step(y), (np.zeros(len(at)), np.ones(len(at)), 0.0)
    if not step > 0.0 or np.ptp(y) < _FEWEST_LEVELS * step:
        return none
    levels = np.round((y - np.min(y)) / step).astype(np.int64)
    never = 1.0 - len(np.unique(levels)) / (int(np.max(levels)) + 1.0)
    left = math.sqrt(min(1.0, never / _AT_REST)) * share_left(noise_beside(variance, step), step)
    random = np.random.default_rng(_SEED)
    drawn = left * step * random.uniform(-0.5, 0.5, (_DRAWS, int(np.max(levels)) + 1))[:, levels]
    x_bins, made = fft.rfft(x)[1:], y - np.mean(y)
    power = _powers(x_bins)
    if min(float(np.min(each)) for each in power) < _LEAST_POWER * max(float(np.max(each)) for each in power):
        return none
    return _of_errors([(error, made) for error in drawn], x_bins, power, response, at)


def _powers(x_bins: Complex) -> list[Floats]:
    """Return the power of an input around each of the bins of a part, for all parts."""
    power = np.abs(x_bins) ** 2
    return [np.asarray(_around(power[part::_PARTS]), np.float64) for part in range(_PARTS)]


def _of_errors(
    drawn: Sequence[tuple[Floats, Floats]],
    x_bins: Complex,
    power: Sequence[Floats],
    response: Complex,
    at: NDArray[np.int64],
) -> tuple[Floats, Floats, float]:
    """Return what `errors_of_output_steps` does, by drawn errors of the steps, each beside the output that it
    is of, both of shape (n,)."""
    errors, gains = [], []
    for error, made in drawn:
        gains.append(float(error @ made) / float(made @ made))
        along = np.conj(x_bins) * fft.rfft(error)[1:]
        of_error = [_around(along[part::_PARTS]) / power[part] for part in range(_PARTS)]
        errors.append([each[np.minimum(at // _PARTS, len(each) - 1)] / response for each in of_error])
    return *_in_common(np.array(errors)), float(np.sqrt(np.mean(np.square(gains))))


def _output(x_bins: Complex, response: Complex, at: NDArray[np.int64], count: int) -> Floats:
    """Return the output, less its mean, that a response at some bins makes of an input."""
    bins, turn = np.arange(len(x_bins)), _turn(response, at)
    # at zero frequency, bin -1, it is real, and hardly larger than at the lowest
    known, values = np.append(-1, at), np.append(math.copysign(abs(response[0]), response[0].real), response)
    unturned = values * np.exp(-1j * turn * known)
    between = np.interp(bins, known, unturned.real) + 1j * np.interp(bins, known, unturned.imag)
    return fft.irfft(np.concatenate([[0.0], between * np.exp(1j * turn * bins) * x_bins]), count)


def _smooth(response: Complex, at: NDArray[np.int64]) -> Complex:
    """Return means over neighbours: a response that follows the readings themselves makes an output that lies
    at the levels."""
    from scipy import ndimage

    turned = np.exp(1j * _turn(response, at) * at)
    parts = (np.conj(turned) * response).view(np.float64).reshape(-1, 2)
    mean = ndimage.uniform_filter1d(parts, _FOLLOWED, axis=0, mode="nearest")
    return np.asarray((mean[:, 0] + 1j * mean[:, 1]) * turned)


def _turn(response: Complex, at: NDArray[np.int64]) -> float:
    """Return by how much a response turns from bin to bin, on average over those furthest apart."""
    apart = np.diff(at)
    furthest = int(np.max(apart, initial=1))
    pairs = (np.conj(response[:-1]) * response[1:])[apart == furthest]
    return float(np.angle(np.sum(pairs))) / furthest


def _around(values: NDArray[np.inexact]) -> NDArray[np.inexact]:
    from scipy import ndimage

    return np.asarray(ndimage.uniform_filter1d(values, 2 * _REACH + 1, mode="nearest"))


def _in_common(errors: Complex) -> tuple[Floats, Floats]:
    """Return the rms of what errors, shape (draws, 2, m), from either half of the bins have in common, along
    the response or across it, and over how many neighbours it is the same."""
    from scipy import ndimage

    def common(width: int) -> tuple[Floats, Floats]:
        """Mean product of both, of means over so many neighbours."""
        mean = ndimage.uniform_filter1d(errors, width, axis=2, mode="nearest")
        found = (np.mean(part[:, 0] * part[:, 1], axis=0) for part in (mean.real, mean.imag))
        along, across = (ndimage.uniform_filter1d(each, _SMOOTHED, mode="nearest") for each in found)
        return np.maximum(along, 0.0), np.maximum(across, 0.0)

    along, across = common(1)
    own, alike = along + across, np.ones(errors.shape[2])
    width = 2
    while width <= min(_MOST, errors.shape[2]):
        of_mean = np.minimum(np.add(*common(width)), own)
        share = np.divide(of_mean, own, out=np.zeros_like(own), where=own > 0.0)
        alike = np.where(share > _ALIKE, width * share, alike)
        width *= 2
    return np.sqrt(np.maximum(along, across)), alike
