"""Resolution of a channel: the step between its values."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

_COARSE = 1e-5  # of the peak-to-peak: a smaller step is the last digit of a 32-bit number
_BY_CHANCE = 10.0  # times the mean of the least distance between as many values, exp(-10) by chance
_LOOKED_AT = 1 << 16  # samples
_KEPT = 8  # channels of a record, each of which several analyses ask for
_SUBNORMAL = float(np.finfo(np.float64).tiny) / 1e-10  # smaller steps have no digits left
_FIRST = 16  # values or steps, which mostly tell of all
_FEWEST_VALUES, _ROUNDING = 6, 1e-10  # of the greatest value
_OF_DOUBLES = 1e-13  # of the greatest value: what a few sums and products round by
_OF_SUMS, _NONE_BETWEEN = 1e-8, 1e4  # of the greatest value: what any of them do; times as much
_ROUNDING_32, _ABOVE_ROUNDING = 4e-7, 100.0  # of numbers of 32 bits; what is less than so many is rounding
_MOST_PLACES, _OF_A_DIGIT, _LEAST_OF_TEXT = 10, 1e-4, 1e-280
_NEAR, _PART_OF_STEP = 4.5, 0.1  # differences of few steps; by how much of one they are rounded
_WHOLE = 0.02  # of a step: an angle of 2^16 counts in 32 bits is rounded by half a hundredth
_MOST = 0.9  # share of the samples that are whole steps apart
_EQUAL_RAD, _EQUAL_32_RAD = 1e-9, 2e-6  # angles in different turns, and their steps, by rounding
_MOST_STEPS = float(1 << 32)  # of a converter
_OF_TURNS_RAD = 1e-11  # what whole turns add to the rounding of an angle
_FEWEST_LEVELS, _FEWEST_COUNTS = 4.0, 1.5  # in a turn; between samples
_MOST_COUNTS = 16  # between samples, that are looked for


def resolution(samples: NDArray[np.float64]) -> float:
    """Return the step that samples, shape (n,), are whole numbers of apart; 0 if all are the same.

    The step of a quantised signal; of one that was computed, 0 or its rounding. It is the least difference
    of distinct values where those that are few of it apart are whole numbers of it, or where values are too
    few to tell; else the greatest common divisor of all: rows that are at the same few places in all
    periods show few of the levels. Of a long record 65536 samples, evenly spread, are used.
    """
    return _resolution(_few(samples).tobytes())


def counting_step(samples: NDArray[np.float64]) -> float:
    """Return resolution of samples, shape (n,), where it is that of a converter; 0 where it is no such step.

    A smaller step than a hundred-thousandth of the peak-to-peak is the last digit of a number. Of n values
    anywhere the two nearest are peak-to-peak / n^2 apart on average, which is no step either. Values that
    differ by rounding alone, as an angle does from turn to turn, are one.
    """
    return _counting_step(_few(samples).tobytes())


def step_between(values: NDArray[np.float64], levels: float, rounding: float = 0.0) -> float:
    """Return the greatest step that rising `values`, shape (n,), are whole numbers of apart, but for their
    `rounding`; 0 where that is by chance, as of fewer than six values, or as many `levels` are not between
    the first and the last."""
    if len(values) < _FEWEST_VALUES:
        return 0.0
    span, rounding = float(values[-1] - values[0]), max(rounding, _ROUNDING * float(np.max(np.abs(values))))
    step = _divisor(np.diff(values), rounding, max(_COARSE * span, _SUBNORMAL))
    return step if step < span / levels else 0.0


def _few(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    return samples[:: max(1, len(samples) // _LOOKED_AT)].astype(np.float64, copy=False)


@lru_cache(maxsize=_KEPT)
def _resolution(samples: bytes) -> float:
    return _step_of(_but_for_rounding(np.unique(np.frombuffer(samples))))


@lru_cache(maxsize=_KEPT)
def _counting_step(samples: bytes) -> float:
    few = np.frombuffer(samples)
    values = _but_for_rounding(np.unique(few), _OF_DOUBLES)
    if len(values) < 2:
        return 0.0
    step, span = _step_of(values), float(values[-1] - values[0])
    least = max(_COARSE, _BY_CHANCE / len(few) ** 2) * span
    return step if step > max(least, _SUBNORMAL) else 0.0


def _but_for_rounding(values: NDArray[np.float64], of_digits: float = 0.0) -> NDArray[np.float64]:
    """Return rising values, shape (n,), of which none differs from the one before by rounding alone: by
    `of_digits` of the greatest, or by more where several do and no step is between these and the others.

    Sums and products of large numbers, such as the speed that an angle of many turns makes from row to row,
    round by more than the values' own digits.
    """
    if len(values) < 2:
        return values
    steps, largest = np.diff(values), float(np.max(np.abs(values)))
    sizes = np.sort(steps)[_FEWEST_VALUES - 1 :]
    last = np.flatnonzero((sizes[1:] > _NONE_BETWEEN * sizes[:-1]) & (sizes[:-1] < _OF_SUMS * largest))
    rounding = max(of_digits * largest, float(sizes[last[-1]]) if len(last) else 0.0)
    return np.asarray(values[np.append(True, steps > rounding)])


def _step_of(values: NDArray[np.float64]) -> float:
    """Return the step between rising values, shape (n,); 0 where they have none above rounding."""
    steps = np.diff(values)
    if not len(steps):
        return 0.0
    step, so_far = float(np.min(steps)), 0.0
    near = steps[steps < _NEAR * step] / step
    if len(values) < _FEWEST_VALUES or (
        len(near) >= _FEWEST_VALUES and float(np.max(np.abs(near - np.round(near)))) < _PART_OF_STEP
    ):
        so_far, of_all = _over_distances(values, step)
        if of_all or len(values) < _FEWEST_VALUES:
            return so_far
    if (of_decimals := _decimal_step(values)) > 0.0:
        return of_decimals
    largest = float(np.max(np.abs(values)))
    for rounding in (_ROUNDING_32, _ROUNDING):
        divisor = _divisor(steps, rounding * largest, max(_ABOVE_ROUNDING * rounding * largest, _SUBNORMAL))
        if divisor > 0.0:
            return min(divisor, step)
    if so_far > 0.0:
        return so_far
    with np.errstate(over="ignore", under="ignore"):
        is_32_bit = np.array_equal(values, values.astype(np.float32).astype(np.float64))
    return float(np.spacing(np.float32(largest))) if is_32_bit else 0.0


def _over_distances(values: NDArray[np.float64], step: float) -> tuple[float, bool]:
    """Return a step of rising values, shape (n,), as the slope of these over their number of steps: the
    longer the distance, the less their rounding matters, as that of an angle in 32 bits to its counts.

    Where values are not whole numbers of it apart farther away, it is the step so far: whether all are is
    returned with it.
    """
    spans = values - values[0]
    spans = spans[spans < _MOST_STEPS * step] / step
    slope, reach = 1.0, _NEAR
    while True:
        within = spans[: int(np.searchsorted(spans, reach, side="right"))] / slope
        number = np.round(within)
        if float(np.max(np.abs(within - number))) > _PART_OF_STEP:
            return step * slope, False
        if np.any(number):  # of few values none is so near
            slope *= float(number @ within) / float(number @ number)
        if reach >= spans[-1]:
            return step * slope, True
        reach *= _NEAR


def _decimal_step(values: NDArray[np.float64]) -> float:
    """Return the step of rising values, shape (n,), that are decimal numbers of ten places or fewer behind
    the first digit of the largest, as text has them; 0 where they are not."""
    largest = float(np.max(np.abs(values)))
    if not _LEAST_OF_TEXT < largest < 1.0 / _LEAST_OF_TEXT:
        return 0.0
    first = math.floor(math.log10(largest))
    for places in range(_MOST_PLACES + 1):
        scale = 10.0 ** (places - first)
        if not _are_whole(values[:_FIRST] * scale):  # of a computed signal none of the first is
            continue
        scaled = values * scale
        if _are_whole(scaled):
            return float(np.gcd.reduce(np.diff(np.round(scaled)).astype(np.int64))) / scale
    return 0.0


def _are_whole(values: NDArray[np.float64]) -> bool:
    """Return whether decimal numbers, shape (n,), have nothing behind the point."""
    return bool(np.max(np.abs(values - np.round(values))) < _OF_A_DIGIT)


def _divisor(steps: NDArray[np.float64], rounding: float, least: float) -> float:
    """Return the greatest common divisor of `steps`, shape (n,), by Euclid's algorithm; 0 where it is less
    than `least`. Steps of any size have none above their `rounding`."""
    divisor, together = 0.0, 0.0
    for each in _rising(steps):  # of small ones a common divisor is least rounded
        rest = each
        while rest > rounding:
            divisor, rest = rest, divisor % rest
            rest = 0.0 if divisor - rest < rounding else rest
        if divisor < least:
            return 0.0
        together += each
        divisor = together / round(together / divisor)  # which all of them round less
    return divisor


def _rising(values: NDArray[np.float64]) -> Iterator[float]:
    """Yield values, shape (n,), from the least on: where the first tell that there is no divisor, the others
    need no order."""
    if len(values) > _FIRST:
        parted = np.partition(values, _FIRST)
        yield from np.sort(parted[:_FIRST]).tolist()
        values = parted[_FIRST:]
    yield from np.sort(values).tolist()


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

    One step between all samples is a computed angle of constant speed, too.
    """
    step, between = _even_step(angle_rad)
    return step if step * _FEWEST_COUNTS < between else 0.0


def largest_even_step(angle_rad: NDArray[np.float64]) -> float:
    """Return the largest step that may be one count, or a few, of an angle without jumps, shape (n,), which
    turns as much between all samples: of it a whole turn is a multiple, and of its part the angle itself; 0
    where there is none.

    An encoder, too, that passes two counts in every row shows one step between all samples. A computed angle
    of constant speed begins at a whole part of that by chance alone.
    """
    step, _ = _even_step(angle_rad)
    if not step > 0.0:
        return 0.0
    counts = float(angle_rad[0]) / step * np.arange(1, _MOST_COUNTS + 1)
    return step if np.min(np.abs(counts - np.round(counts))) * step < _equal_rad(angle_rad) else 0.0


def _even_step(angle_rad: NDArray[np.float64]) -> tuple[float, float]:
    """Return the step of which samples and a whole turn are multiples, and what an angle turns between all
    samples; 0 where that is not the same.

    Of a computed angle of constant speed there is none, unless it is back where it was after whole turns.
    """
    few, equal_rad = _few(angle_rad), _equal_rad(angle_rad)
    within = np.sort(np.mod(few - few[0], 2 * np.pi))
    values = np.append(within[np.diff(within, prepend=-1.0) > equal_rad], 2 * np.pi)
    values = values[np.diff(values, append=np.inf) > equal_rad]  # the first may be just below a turn
    between = float(np.median(np.abs(np.diff(angle_rad)))) if len(angle_rad) > 1 else 0.0
    if not between > equal_rad or np.ptp(np.diff(angle_rad)) > equal_rad:
        return 0.0, between
    return step_between(values, _FEWEST_LEVELS, equal_rad if equal_rad > _EQUAL_RAD else 0.0), between


def _equal_rad(angle_rad: NDArray[np.float64]) -> float:
    """Return by how much equal angles, shape (n,), in different turns differ at most by their rounding: that
    of 64 bits, or of 32 where within a turn, or within half a turn to either side, they are such numbers."""
    within = np.mod(_few(angle_rad), 2.0 * np.pi)
    for each in (within, np.where(within > np.pi, within - 2.0 * np.pi, within)):
        if np.mean(np.abs(each - each.astype(np.float32)) < _OF_TURNS_RAD) > _MOST:
            return _EQUAL_32_RAD
    return _EQUAL_RAD
