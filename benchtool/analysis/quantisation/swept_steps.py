"""Errors that the steps of a converter make of the response to a sweep.

Rounding to steps q turns a sinusoid of amplitude A into one of A + 2 q / pi times the sum over n of
+-J_1(2 pi n A / q) / n (Widrow and Kollár, Quantization Noise, 2008, of sinusoids); J_1(z)^2 is 1 / (pi z) on
average. Unlike the rest of the rounding it is alike at neighbouring frequencies of a sweep, as the amplitude
hardly differs there, and no residual shows it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import noise_beside, share_left
from benchtool.analysis.quantisation.resolution import counting_step

_OF_LEVELS = math.sqrt(1.2) * math.sqrt(2.0) / math.pi**2  # rms over q (q / A)^(1/2); 1.2: sum of 1 / n^3
_FEWEST_LEVELS = 16
_LEAST_AMPLITUDE = 0.5  # steps: below it nothing is rounded up
_HIGHEST = 0.8  # of the frequencies: a sweep does not come so far, and noise that is white does
_MOST = 64.0  # frequencies

Floats = NDArray[np.float64]


def relative_error(levels: Floats | float) -> Floats:
    """Return the rms error that steps make of a sinusoid of an amplitude of so many, relative to it."""
    return np.asarray(_OF_LEVELS * np.power(levels, -1.5))


def errors_of_steps(r: Floats, y: Floats, gain: Floats) -> tuple[Floats, Floats]:
    """Return the standard uncertainty of the gain of an output to what sweeps, relative to it, and over how
    many neighbours it is the same, both of the shape of `gain`; zero and one of an output without steps."""
    step = counting_step(y)
    if not step > 0.0 or np.ptp(y) < _FEWEST_LEVELS * step:
        return np.zeros(len(gain)), np.ones(len(gain))
    amplitude = np.maximum(0.5 * float(np.ptp(r)) * gain / step, _LEAST_AMPLITUDE)
    # a step of the amplitude further the error is the same again, half a step further the opposite
    apart = np.abs(np.gradient(amplitude)) if len(amplitude) > 1 else np.ones(1)
    alike = np.clip(0.5 / np.maximum(apart, np.finfo(np.float64).tiny), 1.0, _MOST)
    return _left(y, step) * relative_error(amplitude), alike


def error_of_input_steps(x: Floats) -> float:
    """Return the standard uncertainty of the gain to an input that sweeps, relative to it: of an amplitude
    that is the same at all frequencies the error is, too. Zero of an input without steps."""
    step = counting_step(x)
    if not step > 0.0 or np.ptp(x) < _FEWEST_LEVELS * step:
        return 0.0
    return _left(x, step) * float(relative_error(0.5 * float(np.ptp(x)) / step))


def _left(samples: Floats, step: float) -> float:
    """Return how much of the errors of steps is left in noise of the density above the frequencies of a
    sweep."""
    bins = np.abs(fft.rfft(samples)[round(_HIGHEST * 0.5 * len(samples)) :]) ** 2
    noise = math.sqrt(float(np.median(bins)) / math.log(2.0) / len(samples))
    return share_left(noise_beside(noise**2, step), step)
