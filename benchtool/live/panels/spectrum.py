"""Spectra for the eye: of the latest window of a stream, and of a capture from end to end.

Figures of merit come from `benchtool.analysis` on a whole capture; these only show where to look.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import amplitude_spectrum
from benchtool.block import Block
from benchtool.errors import AnalysisError

CANDIDATES = ("i_a", "i_b", "i_c", "i_alpha", "i_beta")
"""Currents with a fundamental, in the order in which one is chosen."""

FLOOR_DB = 0.0
"""0 dB is a thousandth of the unit: 1 mA peak for a current."""

HIGHEST_ORDER = 50
_MOST_BARS = 400
_MOST_LINES = 192
_HISTORY = 150
_ROWS = 16384
_WINDOW_S = 4.0
_FEWEST = 64
_DISTINCT = 5.0  # of the median: of noise in 8192 bins the largest is about 3.6


@dataclass(frozen=True)
class Bars:
    """A spectrum as bars, shape (n,): the largest peak amplitude about each frequency.

    `amplitude_dB` is relative to a thousandth of the channel's unit, and not below 0. The fundamental is the
    largest component but dc; `harmonic_percent`, shape (orders,), has those of order 2, 3 ... relative to it,
    and is all zero where the largest component does not stand out of noise.
    """

    channel: str
    unit: str
    frequency_Hz: NDArray[np.float64]
    amplitude_dB: NDArray[np.float64]
    fundamental_Hz: float
    fundamental: float
    harmonic_percent: NDArray[np.float64]


def chosen(names: tuple[str, ...]) -> str | None:
    """Return the channel whose spectrum is shown; None if there is none."""
    return next((name for name in CANDIDATES if name in names), None)


def decibels(amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the amplitudes relative to a thousandth of their unit, in dB, and not below 0."""
    return np.asarray(20.0 * np.log10(np.maximum(amplitude, 1e-3) / 1e-3), dtype=np.float64)


def bars(samples: NDArray[np.float64], sample_rate_Hz: float, channel: str, unit: str) -> Bars | None:
    """Return the spectrum of uniform samples under a Hann window; None where they define none."""
    if len(samples) < _FEWEST:
        return None
    try:
        spectrum = amplitude_spectrum(samples - samples.mean(), sample_rate_Hz)
    except AnalysisError:
        return None
    amplitude = spectrum.amplitude
    peak = 2 + int(np.argmax(amplitude[2:]))
    fundamental = float(amplitude[peak])
    orders = np.arange(2, HIGHEST_ORDER + 1)
    places = np.rint(orders * _between(amplitude, peak)).astype(np.int64)
    inside = places + 1 < len(amplitude)
    harmonic = np.array([amplitude[k - 1 : k + 2].max() for k in places[inside]])
    if fundamental < _DISTINCT * float(np.median(amplitude)):
        harmonic = np.zeros_like(harmonic)
    frequency_Hz, largest = _fewer(spectrum.frequency_Hz[1:], amplitude[1:], _MOST_BARS)
    return Bars(
        channel,
        unit,
        frequency_Hz,
        decibels(largest),
        float(_between(amplitude, peak) * spectrum.frequency_Hz[1]),
        fundamental,
        100.0 * harmonic / fundamental,
    )


def spectrogram(samples: NDArray[np.float64], sample_rate_Hz: float) -> tuple[NDArray[np.uint8], float]:
    """Return a waterfall of uniform samples, shape (times, frequencies), in dB as `Bars`; and its seconds a
    row."""
    length = min(len(samples), max(_FEWEST, len(samples) // 4))
    step = max(1, (len(samples) - length) // (_HISTORY - 1))
    starts = range(0, len(samples) - length + 1, step)
    rows = [_line(samples[start : start + length], sample_rate_Hz) for start in starts]
    return np.array(rows, dtype=np.uint8), step / sample_rate_Hz


class RunningSpectrum:
    """The spectrum of the last seconds of one channel, and the waterfall of those before.

    Holds `_ROWS` samples and `_HISTORY` spectra at most. A gap begins a new window.
    """

    def __init__(self, channel: str, unit: str, sample_rate_Hz: float) -> None:
        self.channel = channel
        self._unit = unit
        self.sample_rate_Hz = sample_rate_Hz
        rows = max(_FEWEST, min(_ROWS, round(_WINDOW_S * sample_rate_Hz)))
        self._samples: deque[float] = deque(maxlen=rows)
        self._history: deque[NDArray[np.uint8]] = deque(maxlen=_HISTORY)

    def add(self, block: Block, *, broken: bool) -> None:
        """Take the rows of a block; `broken` if rows are missing before it."""
        begin = block.gaps[-1].row if block.gaps else 0
        if broken or block.gaps:
            self._samples.clear()
        self._samples.extend(block.column(self.channel)[begin:].tolist())

    def bars(self) -> Bars | None:
        """Return the spectrum now; None while there are too few rows."""
        samples = np.array(self._samples)
        found = bars(samples, self.sample_rate_Hz, self.channel, self._unit)
        if found is not None:
            self._history.append(_line(samples, self.sample_rate_Hz))
        return found

    def waterfall(self) -> NDArray[np.uint8]:
        """Return the spectra so far, newest last, shape (times, frequencies), in dB as `Bars`."""
        return np.array(self._history, dtype=np.uint8)


def _line(samples: NDArray[np.float64], sample_rate_Hz: float) -> NDArray[np.uint8]:
    try:
        spectrum = amplitude_spectrum(samples - samples.mean(), sample_rate_Hz)
    except AnalysisError:
        return np.zeros(_MOST_LINES, dtype=np.uint8)
    places = np.linspace(0, len(spectrum.amplitude), _MOST_LINES + 1).astype(np.int64)
    # of few bins some are shown twice, so that every row is as wide as the others
    largest = [spectrum.amplitude[a : max(b, a + 1)].max() for a, b in pairwise(places)]
    return np.clip(np.rint(decibels(np.array(largest))), 0, 255).astype(np.uint8)


def _between(amplitude: NDArray[np.float64], peak: int) -> float:
    """Return the place of a peak between bins, from its neighbours under a Hann window.

    A sinusoid d bins beyond a bin, 0 <= d <= 0.5, reads (1 + d) / (2 - d) as much in the next bin as in that
    one: the main lobe of the window is sinc(d) / (1 - d^2).
    """
    before = amplitude[peak - 1]
    after = amplitude[peak + 1] if peak + 1 < len(amplitude) else 0.0
    side, neighbour = (1.0, after) if after >= before else (-1.0, before)
    ratio = neighbour / amplitude[peak]
    return float(peak + side * np.clip((2.0 * ratio - 1.0) / (1.0 + ratio), 0.0, 0.5))


def _fewer(
    frequency_Hz: NDArray[np.float64], amplitude: NDArray[np.float64], most: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the at most so many bars, each the largest of its neighbours."""
    each = -(-len(amplitude) // most)
    if each == 1:
        return frequency_Hz, amplitude
    whole = len(amplitude) // each * each
    return frequency_Hz[:whole].reshape(-1, each).mean(axis=1), amplitude[:whole].reshape(-1, each).max(
        axis=1
    )
