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
    bins = np.abs(fft.rfft(y)[round(_HIGHEST * 0.5 * len(y)) :]) ** 2
    noise = math.sqrt(float(np.median(bins)) / math.log(2.0) / len(y))
    left = share_left(noise_beside(noise**2, step), step)
    # a step of the amplitude further the error is the same again, half a step further the opposite
    apart = np.abs(np.gradient(amplitude)) if len(amplitude) > 1 else np.ones(1)
    alike = np.clip(0.5 / np.maximum(apart, np.finfo(np.float64).tiny), 1.0, _MOST)
    return left * relative_error(amplitude), alike
