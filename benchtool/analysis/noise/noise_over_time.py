"""Noise between harmonics over time: how far its level in one record is from that of others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.fast_lengths import next_fast_length
from benchtool.analysis.statistics.scatter import MeanError, error_of_series

_PARTS, _FEWEST_PARTS = 64, 16
_MOST = 0.7  # of a power: with more, so few changes of the level do not tell it
_BINS_OF_A_PART = 4  # at least: with fewer the power of successive parts is that of the same waves


@dataclass(frozen=True)
class NoiseOverTime:
    """How the level of noise changes with time.

    `error` is how far its mean power in this record is from that of all time because of that, relative; its
    standard uncertainty is nan where the level wanders more slowly than the record shows. `evenness` is the
    square of the mean of the powers of parts over the mean of their squares, without what the scatter of
    noise of one level adds to these: of so much of the record noise of one level would scatter as much.
    """

    error: MeanError
    evenness: float


ONE_LEVEL = NoiseOverTime(MeanError(0.0, math.inf), 1.0)
"""Of noise whose level is the same at all times, as far as is known."""


def noise_over_time(phasor: NDArray[np.complex128], bins: NDArray[np.int64]) -> NoiseOverTime:
    """Return how the level of noise changes: what a spectrum, `phasor`, shape (n,), has in these `bins`,
    in ascending order.

    The scatter of the bins tells the error of the power of noise of one level: its variance is half the sum
    of their powers' squares over the square of their sum. Of noise in bursts, or of a drive that goes from
    one limit cycle to another, the mean of the powers of up to 64 parts of the record, with their
    correlation, scatters by more: that beyond the first is the error. Bins too few to have a course are of
    one level.
    """
    parts = min(_PARTS, len(bins) // _BINS_OF_A_PART)
    if parts < _FEWEST_PARTS:
        return ONE_LEVEL
    alone = np.zeros(int(bins[-1]) + 1, dtype=np.complex128)
    alone[bins] = phasor[bins]
    wave = fft.irfft(alone, next_fast_length(2 * len(alone)))
    size = len(wave) // parts
    power = np.mean(np.square(wave[: size * parts]).reshape(parts, size), axis=1)
    mean = float(np.mean(power))
    if not mean > 0.0:
        return ONE_LEVEL
    of_parts = error_of_series(power)
    square = np.square(np.abs(phasor[bins]))
    of_one_level = 0.5 * float(square @ square) / float(np.sum(square)) ** 2
    uneven = max(0.0, float(np.var(power)) / mean**2 - parts * of_one_level)
    excess = (of_parts.standard / mean) ** 2 - of_one_level
    standard = math.sqrt(max(0.0, excess)) if excess < _MOST**2 else math.nan
    return NoiseOverTime(MeanError(standard, of_parts.dof), 1.0 / (1.0 + uneven))
