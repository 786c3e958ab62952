"""Errors of a converter's steps in a signal that goes on through them without repeating itself in periods.

Slow lines, a drift, or a ripple in step with nothing carry a waveform over the steps, and errors average
out; not all of them, as a sinusoid of A dwells at its ends: of sin(2 pi k x / q) it leaves J_0(2 pi k A / q)
(Widrow and Kollár, Quantization Noise, 2008, of sinusoids). No scatter shows what is left. It is looked up
along the record, in all that stands out of its spectrum.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, error_of_steps, noise_beside

_DRAWS = 32  # of where the levels lie, and of the size of the signal
_APART = 0.1  # of a step: by how much signals of two draws differ, rms, and which lines are left out
_STANDS_OUT = 4.0  # of the amplitude of noise of a step
_MOST_ROWS = 1 << 15

Floats = NDArray[np.float64]


class StepsAlong(RepeatedSteps):
    """As of one period that is the whole record, of any levels."""

    @property
    def of_rms(self) -> float:
        """As of `RepeatedSteps`; the power that steps add is not that of all signals either."""
        deviation = self.waveform - np.mean(self.waveform)
        added = np.mean(self.errors**2, axis=1)
        moved = 2.0 * np.mean(self.errors * deviation, axis=1) + added - np.mean(added)
        return math.sqrt(float(np.mean(moved**2))) / (2.0 * float(np.std(self.waveform)))


def steps_along(samples: Floats, step: float) -> StepsAlong | None:
    """Return the errors of steps along samples, shape (n,), over levels in all places; None where noise hides
    them, or where nothing stands out of it."""
    mean = float(np.mean(samples))
    signal = _standing_out(samples, step)
    size = float(np.std(signal))
    if not size > 0.0:
        return None
    # at the ends the spectrum leaves out more
    left = np.average((samples - mean - signal) ** 2, weights=np.hanning(len(samples)))
    noise = noise_beside(float(left), step)
    signal = signal[:: -(-len(samples) // _MOST_ROWS)]
    larger = 1.0 + _APART * step / size * np.random.default_rng(0).standard_normal(_DRAWS)
    found = [
        error_of_steps(mean + each * signal, step, noise, level)
        for each, level in zip(larger, step * np.arange(_DRAWS) / _DRAWS, strict=True)
    ]
    errors = [each for each in found if each is not None]
    return StepsAlong(mean + signal, np.array(errors), 1) if errors else None


def are_alike(left: Floats, step: float) -> bool:
    """Return whether periods are read in the same parts of the steps, by what their mean has `left` of
    samples, shape (n,)."""
    return float(np.std(_standing_out(left, step))) < _APART * step


def _standing_out(samples: Floats, step: float) -> Floats:
    """Return the lines of samples about their mean, shape (n,), that stand out of noise of a step."""
    count = len(samples)
    bins = fft.rfft(samples - np.mean(samples))
    bins[np.abs(bins) < 0.5 * count * step * max(_APART, _STANDS_OUT * 2.0 / math.sqrt(count))] = 0.0
    return np.asarray(fft.irfft(bins, count))
