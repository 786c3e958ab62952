"""What the bandwidth and the resolution of a sensor do to a waveform that was read with it.

Effects are relative changes of a feature of the recorded samples: of the mean, of one line, of the harmonics,
of the rms or of the extremes about the mean. They say what a stated error may have done to a measurement of
that kind, without the analysis that made it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Final

import numpy as np
from numpy import fft
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Feature = Callable[["Waveform"], complex]

_LOOKED_AT = 1 << 16  # samples
_SETTLED = 10.0  # time constants, after which what was before the record is forgotten
_MAIN_LOBE = 3.0  # bins of a line under a Hann window
_PHASES = 8  # of the grid of a resolution, whose place is not known


class Waveform:
    """Uniform samples, shape (n,), in the unit of their channel; of a long record the first 65536."""

    def __init__(self, samples: Floats, rate_Hz: float) -> None:
        self.samples: Final = samples[:_LOOKED_AT]
        self.rate_Hz: Final = rate_Hz
        self._in_steps: dict[float, tuple[Waveform, ...]] = {}

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

    def harmonics(self, fundamental_Hz: float, top_Hz: float) -> Iterator[tuple[float, float]]:
        """Yield frequency and amplitude of orders 2, 3 ... up to a frequency, in the unit of `line`."""
        if fundamental_Hz > 0.0:
            for order in range(2, math.floor(min(top_Hz, 0.5 * self.rate_Hz) / fundamental_Hz + 1e-9) + 1):
                yield order * fundamental_Hz, abs(self.line(order * fundamental_Hz))

    def between(self, fundamental_Hz: float) -> float:
        """Return the rms of the bins between the harmonics, in the unit of `line`."""
        order = np.arange(len(self.bins)) * (self.rate_Hz / (len(self.samples) * fundamental_Hz))
        apart = np.abs(order - np.round(order)) * len(self.samples) * fundamental_Hz / self.rate_Hz
        left = np.abs(self.bins[(apart > _MAIN_LOBE) & (order > 0.0)])
        return float(np.sqrt(np.mean(left**2))) if len(left) else 0.0

    def in_steps(self, step: float) -> tuple[Waveform, ...]:
        """Return it as read in steps, for eight places of their grid."""
        if step not in self._in_steps:
            self._in_steps[step] = tuple(
                Waveform(in_steps(self.samples, step, (k + 0.5) / _PHASES), self.rate_Hz)
                for k in range(_PHASES)
            )
        return self._in_steps[step]


def lagged(samples: Floats, rate_Hz: float, bandwidth_Hz: float) -> Floats:
    """Return what a first-order lag that has lost 3 dB at `bandwidth_Hz` makes of samples, shape (n,).

    By its frequency response. Before the first and past the last the samples go on as in a mirror, which
    keeps their mean, until the lag has forgotten.
    """
    count = len(samples)
    reach = min(count - 1, math.ceil(_SETTLED * rate_Hz / (2.0 * math.pi * bandwidth_Hz)))
    extended = np.pad(samples, reach, mode="reflect")
    response = 1.0 / (1.0 + 1j * fft.rfftfreq(len(extended), 1.0 / rate_Hz) / bandwidth_Hz)
    filtered = fft.irfft(fft.rfft(extended) * response, len(extended))
    return np.asarray(filtered[reach : reach + count])


def in_steps(samples: Floats, step: float, phase: float) -> Floats:
    """Return samples as read in steps, `phase` of a step being where the grid begins."""
    return np.asarray((np.round(samples / step - phase) + phase) * step)


def without_lag(read: float, once: float, twice: float) -> float:
    """Return what a feature would be without a lag, of what it is with it, with one more and with two more.

    The parabola through the three: of a line at f it is within 0.2 % at half the bandwidth and 2.5 % low at
    the bandwidth. The line through the first two where the third is nan.
    """
    return 3.0 * read - 3.0 * once + twice if math.isfinite(twice) else 2.0 * read - once


def lost_of_feature(waveform: Waveform, bandwidth_Hz: float, feature: Callable[[Waveform], float]) -> float:
    """Return what a sensor's lag has taken off a feature, relative to what was read; 0 if that is nothing."""
    rate_Hz, whole = waveform.rate_Hz, waveform.samples
    once = lagged(whole, rate_Hz, bandwidth_Hz)
    twice = lagged(once, rate_Hz, bandwidth_Hz)
    settling = math.ceil(2.0 * _SETTLED * rate_Hz / (2.0 * math.pi * bandwidth_Hz))
    begin = min(settling, len(whole) // 2)
    read, later, last = (feature(Waveform(each[begin:], rate_Hz)) for each in (whole, once, twice))
    return without_lag(read, later, last) / read - 1.0 if read else 0.0


def lost_of_line(frequency_Hz: float, bandwidth_Hz: float) -> float:
    """Return what a lag has taken off the amplitude of a line, relative to what was read."""
    return math.hypot(1.0, frequency_Hz / bandwidth_Hz) - 1.0


def lost_of_harmonics(
    waveform: Waveform, fundamental_Hz: float, top_Hz: float, bandwidth_Hz: float, *, as_ratio: bool
) -> float:
    """Return what a lag has taken off the root of the sum of squares of the harmonics, relative to what was
    read; of their ratio to the fundamental if `as_ratio`. nan if there is no harmonic."""
    squares = [(f, a * a) for f, a in waveform.harmonics(fundamental_Hz, top_Hz)]
    read = sum(square for _, square in squares)
    if not read > 0.0:
        return math.nan
    whole = sum(square * (1.0 + (f / bandwidth_Hz) ** 2) for f, square in squares)
    own = lost_of_line(fundamental_Hz, bandwidth_Hz) if as_ratio else 0.0
    return math.sqrt(whole / read) / (1.0 + own) - 1.0


def by_steps(waveform: Waveform, step: float, feature: Feature) -> float:
    """Return the standard uncertainty of a feature by steps whose grid may begin anywhere, in its unit.

    The rms change over eight places of the grid: step / sqrt(12) of a mean that nothing moves, and little
    where the signal spans many steps, whose errors average out then.
    """
    read = feature(waveform)
    changes = [abs(feature(each) - read) for each in waveform.in_steps(step)]
    return math.sqrt(sum(change**2 for change in changes) / len(changes))
