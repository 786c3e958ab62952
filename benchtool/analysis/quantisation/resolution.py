"""Resolution of a channel: the step between its values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_COARSE = 1e-5  # of the peak-to-peak: a smaller step is the last digit of a 32-bit number
_BY_CHANCE = 10.0  # times the mean of the least distance between as many values, exp(-10) by chance
_LOOKED_AT = 1 << 16  # samples
_SUBNORMAL = float(np.finfo(np.float64).tiny) / 1e-10  # smaller steps have no digits left
_FEWEST_VALUES, _ROUNDING = 6, 1e-10  # of the greatest value
_WHOLE, _MOST = 1e-3, 0.9  # of a step; share of the samples that are whole steps apart
_EQUAL_RAD = 1e-9  # angles in different turns, by their rounding
_FEWEST_LEVELS, _FEWEST_COUNTS = 4.0, 1.5  # in a turn; between samples


def resolution(samples: NDArray[np.float64]) -> float:
    """Return the smallest nonzero difference between distinct values of samples, shape (n,); 0 if all are the
    same.

    The step of a quantised signal; of one that was computed, only the rounding. Of a long record 65536
    samples, evenly spread, are used.
    """
    few = samples[:: max(1, len(samples) // _LOOKED_AT)]
    steps = np.diff(np.unique(few))
    return float(np.min(steps)) if len(steps) else 0.0


def counting_step(samples: NDArray[np.float64]) -> float:
    """Return resolution of samples, shape (n,), where it is that of a converter; 0 where it is no such step.

    A smaller step than a hundred-thousandth of the peak-to-peak is the last digit of a number. Of n values
    anywhere the two nearest are peak-to-peak / n^2 apart on average, which is no step either.
    """
    few = samples[:: max(1, len(samples) // _LOOKED_AT)]
    values = np.unique(few)
    if len(values) < 2:
        return 0.0
    step, span = float(np.min(np.diff(values))), float(values[-1] - values[0])
    least = max(_COARSE, _BY_CHANCE / len(few) ** 2) * span
    return step if step > max(least, _SUBNORMAL) else 0.0


def step_between(values: NDArray[np.float64], levels: float) -> float:
    """Return the greatest step that rising `values`, shape (n,), are whole numbers of apart; 0 where that is
    by chance, as of fewer than six values, or as many `levels` are not between the first and the last.

    It is the greatest common divisor, by Euclid's algorithm. Values anywhere have none above rounding.
    """
    if len(values) < _FEWEST_VALUES:
        return 0.0
    span, rounding = float(values[-1] - values[0]), _ROUNDING * float(np.max(np.abs(values)))
    least, step = max(_COARSE * span, _SUBNORMAL), 0.0
    for each in np.sort(np.diff(values)):  # of small ones a common divisor is least rounded
        rest = float(each)
        while rest > rounding:
            step, rest = rest, step % rest
            rest = 0.0 if step - rest < rounding else rest
        if step < least:
            return 0.0
    return step if step < span / levels else 0.0


def level_of(samples: NDArray[np.float64], step: float) -> float:
    """Return a value that a converter with steps of `step` gives, of its samples, shape (n,): the rest of
    their division by it; 0 where there are no steps."""
    if not step > 0.0:
        return 0.0
    turns = np.mean(np.exp(2j * np.pi * np.mod(samples / step, 1.0)))
    return float(np.angle(turns)) / (2.0 * np.pi) * step


def step_of_counts(angle_rad: NDArray[np.float64], step_rad: float) -> float:
    """Return the step in which an angle without jumps, shape (n,), counts: `step_rad`, its resolution, where
    neighbouring samples are whole steps apart, but not always the same number; else 0.

    Of a constant speed what it turns between samples is such a step too.
    """
    if not step_rad > 0.0:
        return 0.0
    steps = np.diff(angle_rad) / step_rad
    counts = np.round(steps)
    is_counted = np.mean(np.abs(steps - counts) < _WHOLE) > _MOST and np.ptp(counts) > 0.0
    return step_rad if is_counted else 0.0


def step_of_even_counts(angle_rad: NDArray[np.float64]) -> float:
    """Return the step in which an angle without jumps, shape (n,), counts where it turns the same number of
    steps, two or more, between all samples; else 0.

    The steps are those of which samples and a whole turn are multiples: of a computed angle of constant speed
    there are none, unless it is back where it was after whole turns. One step between all samples is such an
    angle, too.
    """
    few = angle_rad[:: max(1, len(angle_rad) // _LOOKED_AT)]
    within = np.sort(np.mod(few - few[0], 2 * np.pi))
    values = np.append(within[np.diff(within, prepend=-1.0) > _EQUAL_RAD], 2 * np.pi)
    between = float(np.median(np.abs(np.diff(angle_rad)))) if len(angle_rad) > 1 else 0.0
    if not between > _EQUAL_RAD or np.ptp(np.diff(angle_rad)) > _EQUAL_RAD:
        return 0.0
    step = step_between(values, _FEWEST_LEVELS)
    return step if step * _FEWEST_COUNTS < between else 0.0
