"""Errors of a converter's steps in a signal that repeats in no period.

Slow lines, a drift, or a ripple in step with nothing carry a waveform over the steps, and errors average
out; not all of them, as a sinusoid of A dwells at its ends: of sin(2 pi k x / q) it leaves J_0(2 pi k A / q)
(Widrow and Kollár, Quantization Noise, 2008, of sinusoids). No scatter shows what is left. It is looked up
along the record, in all that stands out of its spectrum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import (
    RepeatedSteps,
    error_of_steps,
    most_of_steps,
    noise_beside,
)

_DRAWS = 32  # of where the levels lie, and of the size of the signal
_APART = 0.1  # of a step: by how much signals of two draws differ, rms
_LEAST_LINE = 0.25  # of a step: smaller ones may be made by steps, and count as noise
_STANDS_OUT = 4.0  # of the amplitude of noise of a step
_NEIGHBOURS, _FEW = 4, 32.0  # on either side; steps, from least to greatest
_ONE_PLACE = 1e-15  # square of a distance that is rounding
_LEAST_LEAK = 0.02  # of a step
_MOST_ROWS = 1 << 15

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class StepsAlong(RepeatedSteps):
    """As of one period that is the whole record, of so many `periods`, and of any levels."""

    periods: int = 1

    @property
    def of_rms(self) -> float:
        """As of `RepeatedSteps`; the power that steps add is not that of all signals either."""
        deviation = self.waveform - np.mean(self.waveform)
        added = np.mean(self.errors**2, axis=1)
        moved = 2.0 * np.mean(self.errors * deviation, axis=1) + added - np.mean(added)
        return math.sqrt(float(np.mean(moved**2))) / (2.0 * float(np.std(self.waveform)))

    @property
    def highest_order(self) -> int:
        return super().highest_order // self.periods

    def _lines(self, orders: NDArray[np.int64]) -> Complex:
        return super()._lines(orders * self.periods)


def steps_along(samples: Floats, step: float) -> StepsAlong | None:
    """Return the errors of steps along samples, shape (n,), over levels in all places; None where noise hides
    them, or where nothing stands out of it."""
    return steps_of_lines(lines_of(samples), step)


def steps_of_lines(lines: Complex, step: float, periods: int = 1, in_band: float = 1.0) -> StepsAlong | None:
    """Return the errors of steps along a record of so many periods, as `steps_along`, by all `lines` of it,
    shape (n,): peak amplitudes of cosines, the first its mean, up to a share of half of the rate."""
    mean, count = float(lines[0].real), 2 * len(lines) - 1
    signal, noise = apart_from_noise(lines, step, count, in_band)
    size = float(np.std(signal))
    if not size > 0.0:
        return None
    signal = signal[:: -(-len(signal) // _MOST_ROWS)]
    larger = 1.0 + _APART * step / size * np.random.default_rng(0).standard_normal(_DRAWS)
    levels = step * np.arange(_DRAWS) / _DRAWS
    errors = error_of_steps(mean + np.outer(larger, signal), step, noise, levels[:, np.newaxis])
    return None if errors is None else StepsAlong(mean + signal, errors, 1, periods)


def apart_from_noise(lines: Complex, step: float, count: int, in_band: float = 1.0) -> tuple[Floats, float]:
    """Return what stands out of lines, shape (n,), as of `steps_of_lines`, about its mean along a record of
    shape (count,), and the rms of the noise in all else, without what steps make of that."""
    stand_out = _with_leaks(_stand_out(lines, step), lines, step)
    about = np.append(0.0, lines[1:])
    signal, rest = (_along(np.where(each, about, 0.0), count) for each in (stand_out, ~stand_out))
    # at the ends the spectrum leaves out more
    left = float(np.average(rest**2, weights=np.hanning(len(rest)))) / in_band
    return signal, noise_beside(left, step)


def are_alike(lines: Complex, step: float, periods: int = 1) -> bool:
    """Return whether periods are read in the same parts of the steps: whether the lines that are none of
    their harmonics, of all `lines` as of `steps_of_lines`, are no more than steps themselves may make of
    them."""
    others = _stand_out(lines, step)
    if periods > 1:
        others[::periods] = False
    return 0.5 * float(np.sum(np.abs(lines[others]) ** 2)) < most_of_steps(step)


def are_read_alike(samples: Floats, turns: Floats, step: float) -> bool:
    """Return whether periods in samples, shape (n,), are read in the same parts of the steps: whether
    neighbours in the order of their places, which are of other periods, differ by no lines. `turns`, shape
    (n,), is where samples are, in periods.

    Places that lie evenly may have neighbours from every other period alone, and more of them tell where a
    waveform of few steps bends by less than one between them.
    """
    place = np.mod(turns, 1.0)
    order = np.argsort(place, kind="stable")
    around = _NEIGHBOURS if float(np.ptp(samples)) < _FEW * step else 1
    off = np.empty(len(samples))
    off[order] = _off_neighbours(samples[order], place[order], around)
    return are_alike(lines_of(off), step)


def _off_neighbours(values: Floats, place: Floats, around: int) -> Floats:
    """Return how far values, shape (n,), are off a straight line through them and so many neighbours on
    either side, in the order of their places, from 0 to 1."""
    x, y = (np.pad(each, around, mode="wrap") for each in (place, values))
    x[:around] -= 1.0
    x[-around:] += 1.0
    xs, ys = (sliding_window_view(each, 2 * around + 1) for each in (x, y))
    middle, mean = np.mean(xs, axis=1), np.mean(ys, axis=1)
    aside = xs - middle[:, np.newaxis]
    square = np.sum(aside**2, axis=1)
    slope = np.divide(np.sum(aside * ys, axis=1), square, out=np.zeros(len(place)), where=square > _ONE_PLACE)
    return np.asarray(values - mean - slope * (place - middle))


def lines_of(samples: Floats) -> Complex:
    """Return the lines of samples, shape (n,), as of `steps_of_lines`."""
    lines = fft.rfft(samples) * (2.0 / len(samples))
    lines[0] *= 0.5
    return np.asarray(lines)


def _stand_out(lines: Complex, step: float) -> NDArray[np.bool_]:
    """Return which lines but the mean stand out of noise of a step, and are not small against it."""
    found = np.abs(lines) > step * max(_LEAST_LINE, _STANDS_OUT * 2.0 / math.sqrt(2 * len(lines)))
    found[0] = False
    return np.asarray(found)


def _with_leaks(stand_out: NDArray[np.bool_], lines: Complex, step: float) -> NDArray[np.bool_]:
    """Return lines that stand out, and those beside them as far as they leak, by 1 / (pi bins)."""
    found, size = stand_out.copy(), np.where(stand_out, np.abs(lines) / step, 0.0)
    is_peak = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])
    for peak in np.flatnonzero(is_peak) + 1:
        leaks = math.ceil(min(size[peak] / (math.pi * _LEAST_LEAK), len(found)))
        found[max(1, peak - leaks) : peak + leaks + 1] = True
    return found


def _along(lines: Complex, count: int) -> Floats:
    """Return what lines of no mean are along a record, shape (count,)."""
    return np.asarray(fft.irfft(lines * (0.5 * count), count))
