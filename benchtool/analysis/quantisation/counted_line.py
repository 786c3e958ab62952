"""Lines that whole counts allow: of an encoder at constant speed, of time stamps at an even rate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_SLOPES = 50
_HALVINGS = 30
_HARMONICS = 256
_MOST_GAINED, _SLOW = 2.6, 4.0
_PLACES = 33  # of slopes from the least to the greatest that is allowed


@dataclass(frozen=True)
class CountedLine:
    """The slope of a line, per place, and its standard uncertainty."""

    slope: float
    standard: float


@dataclass(frozen=True)
class LeastSpread:
    """The slope from which values deviate least, peak to peak, and that deviation."""

    slope: float
    spread: float


def least_spread(values: NDArray[np.float64], places: NDArray[np.float64]) -> LeastSpread:
    """Return the line from which values at rising places, both of shape (n,), deviate least, peak to peak.

    Up to one count, a line explains values in whole counts. The deviation is convex in the slope, and each
    slope's extremes give a line below it; where two such lines meet is the next slope.
    """
    lines: dict[bool, tuple[float, float]] = {}
    slope = float((values[-1] - values[0]) / (places[-1] - places[0])) if len(values) > 1 else 0.0
    least = LeastSpread(slope, math.inf)
    for _ in range(_SLOPES):
        deviation = values - slope * places
        high, low = int(np.argmax(deviation)), int(np.argmin(deviation))
        spread, reach = float(deviation[high] - deviation[low]), float(places[low] - places[high])
        if spread < least.spread:
            least = LeastSpread(slope, spread)
        lines[high > low] = (reach, spread - reach * slope)  # of a greater slope they then deviate less
        if high == low:
            break
        if len(lines) < 2:
            slope -= spread / reach
            continue
        (rise_a, at_a), (rise_b, at_b) = lines.values()
        if rise_a == rise_b or (at_b - at_a) / (rise_a - rise_b) == slope:
            break
        slope = (at_b - at_a) / (rise_a - rise_b)
    return least


def line_through_counts(
    values: NDArray[np.float64], places: NDArray[np.float64], count: float
) -> CountedLine | None:
    """Return the mean slope of all lines that values in steps of `count` allow at rising places, both of
    shape (n,); None where none does.

    A line is allowed where the values deviate from it by up to one count, peak to peak, and for a slope there
    is what is left of the count to shift it in. All allowed lines are taken for equally likely (JCGM
    100:2008, 4.3.7).
    """
    best = least_spread(values, places)
    if not best.spread <= count:
        return None
    about = values - best.slope * places
    reach = 2.0 * count / float(places[-1] - places[0])
    changes = np.linspace(
        -_allowed(-about, places, reach, count), _allowed(about, places, reach, count), _PLACES
    )
    room = np.array([max(0.0, count - float(np.ptp(about - change * places))) for change in changes])
    if not np.any(room):
        return CountedLine(best.slope, 0.0)
    mean = float(np.average(changes, weights=room))
    return CountedLine(best.slope + mean, math.sqrt(float(np.average((changes - mean) ** 2, weights=room))))


def of_slow_beats(step: float, counts_per_row: float, rows: int, left: float) -> float:
    """Return the standard uncertainty, over the record, of a line by least squares through `rows` values in
    steps of `step`, because their phase within a step hardly moves; `left` is their rms deviation from it.

    The error of rounding down has harmonics of amplitude step / (pi m), which noise of sigma steps damps by
    exp(-2 (pi m sigma)^2) (Widrow and Kollár, Quantization Noise, 2008, 5.1). Harmonic m turns once in 1 / m
    steps; from row to row that may be nearly whole turns. What then turns c times over the record adds up to
    6 / (pi c) of its amplitude to the line, and at most 2.6, near two thirds of a turn. What turns oftener
    than four times is seen in the deviation.
    """
    order = np.arange(1, _HARMONICS + 1)
    turns = order * counts_per_row
    cycles = rows * np.abs(turns - np.round(turns))
    sigma2 = max(0.0, (left / step) ** 2 - 1.0 / 12.0)
    amplitude = step / (np.pi * order) * np.exp(-2.0 * (np.pi * order) ** 2 * sigma2)
    gained = np.minimum(_MOST_GAINED, 6.0 / (np.pi * np.maximum(cycles, 1e-9))) * (cycles < _SLOW)
    return math.sqrt(0.5 * float(np.sum((amplitude * gained) ** 2)))


def _allowed(about: NDArray[np.float64], places: NDArray[np.float64], reach: float, count: float) -> float:
    """Return by how much a slope may rise, up to `reach`, until values deviate by more than one count."""
    low, high = 0.0, reach
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_allowed = float(np.ptp(about - middle * places)) <= count
        low, high = (middle, high) if is_allowed else (low, middle)
    return low
