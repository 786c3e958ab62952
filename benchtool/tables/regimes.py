"""Regimes of a record: stretches of it at levels of their own, which one number would average."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_PARTS, _FINE_PARTS = 64, 256
_FEWEST_PER_PART, _FEWEST_PARTS = 8, 8
_FEWEST_PERIODS = 16  # of fewer parts a decay has two levels
_OF_A_REPETITION = 0.1  # of the variance in a line: harmonics of a few steps have less
_AROUND, _OF_A_LINE = 8, 100.0  # bins; times their power: steps, pulses and noise have no lines
_MOST_LOOKED_AT = 1 << 14  # means of rows, for the period
_EXPLAINED = 0.88  # of the variance over parts by two levels: a line has 0.75, a sine 0.81, noise 0.64
_LARGEST_CHANGE = 0.1  # of the greatest value
_MOST_STRETCHES, _LEAST_SHARE = 6, 0.015
_OF_NEIGHBOURS = 0.954  # median of the difference of two normal values, over their standard deviation
_STEADY = 1.5  # times the noise: stretches of a drift scatter more
_STEP = 6.0  # times the noise
_ALIKE = 0.1  # of the largest step: levels that count as one
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Regimes:
    """How many levels a record has, and what to say of them."""

    levels: int
    text: str


def regimes(samples: NDArray[np.float64], unit: str) -> Regimes | None:
    """Return the levels, of the mean or else of the rms deviation, that parts of a record, shape (n,), have;
    None where it has one, drifts or swings."""
    greatest = float(np.max(np.abs(samples)))
    if not greatest > 0.0:
        return None
    scaled = samples / greatest
    middle = float(np.mean(scaled))
    scaled -= middle
    sums = _sums(scaled), _sums(scaled**2)
    period = _period(scaled)
    parts = [_of_parts(*sums, _width(len(samples), most, period)) for most in (_PARTS, _FINE_PARTS)]
    averages = [greatest * (middle + average) for average, _ in parts]
    deviations = [greatest * deviation for _, deviation in parts]
    for (values, fine), of in ((averages, "average"), (deviations, "have an rms deviation of")):
        for each in (values, fine):
            if len(each) and (found := _stretches(each, greatest, unit, of)):
                return found
        if text := _two_levels(values, greatest, unit, of):
            return Regimes(2, text)
    return None


def _sums(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sum of the values before each, and of all."""
    return np.concatenate([[0.0], np.cumsum(values)])


def _period(samples: NDArray[np.float64]) -> float | None:
    """Return the rows of a period of the largest sinusoid of a record without its mean; None of one that does
    not repeat, or has too few periods."""
    rows = len(samples) // _MOST_LOOKED_AT + 1  # periods that are much shorter than a part do not beat
    means = samples[: len(samples) // rows * rows].reshape(-1, rows).mean(axis=1)
    power = np.abs(np.fft.rfft(np.hanning(len(means)) * means)) ** 2
    if len(power) < 2 * _FEWEST_PERIODS:
        return None
    line = _FEWEST_PERIODS + int(np.argmax(power[_FEWEST_PERIODS:-3]))
    of_line = float(np.sum(power[line - 2 : line + 3]))
    around = float(np.median([*power[line - _AROUND : line - 2], *power[line + 3 : line + _AROUND + 1]]))
    if not of_line > max(_OF_A_REPETITION * float(np.sum(power)), _OF_A_LINE * around):
        return None
    before, at, after = np.sqrt(power[line - 1 : line + 2])
    # of a Hann window the greater neighbour tells how far beside the bin the line is
    beside = (2.0 * after - at) / (at + after) if after > before else (at - 2.0 * before) / (at + before)
    return float(rows * len(means) / (line + beside))


def _width(rows: int, most: int, period: float | None) -> float:
    """Return the rows of each of up to so many parts; in whole periods, as others would beat with them."""
    least = rows / max(min(most, rows // _FEWEST_PER_PART), 1)
    return least if period is None else math.ceil(least / period) * period


def _of_parts(
    sums: NDArray[np.float64], of_squares: NDArray[np.float64], width: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return average and rms deviation of each part of so many rows; of too few parts none. A row that an
    edge divides counts on either side by its share."""
    rows = len(sums) - 1
    count = int(rows / width + _ROUNDING)
    if count < _FEWEST_PARTS:
        return np.empty(0), np.empty(0)
    edges = np.minimum(width * np.arange(count + 1), rows)
    row = np.minimum(edges.astype(np.int64), rows - 1)

    def averages(of: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.diff(of[row] + (edges - row) * (of[row + 1] - of[row])) / width)

    average = averages(sums)
    return average, np.sqrt(np.maximum(averages(of_squares) - average**2, 0.0))


def _stretches(values: NDArray[np.float64], greatest: float, unit: str, of: str) -> Regimes | None:
    """Return a few stretches of parts at levels of their own, with steps between them.

    The noise is that of neighbouring parts. Within stretches, but for the parts at either end of them, values
    scatter hardly more; between them they step by many times of it, within a part.
    """
    noise = float(np.median(np.abs(np.diff(values)))) / _OF_NEIGHBOURS + _ROUNDING * greatest
    least = max(_STEP * noise, _LARGEST_CHANGE * greatest)
    is_step = np.zeros(len(values), dtype=bool)
    is_step[1:-1] = np.abs(values[2:] - values[:-2]) >= least  # one within a part shows over two
    begins = np.flatnonzero(np.diff(~is_step, prepend=False) & ~is_step)
    ends = np.flatnonzero(np.diff(~is_step, append=False) & ~is_step) + 1
    if not least > 0.0 or not 2 <= len(begins) <= _MOST_STRETCHES:
        return None
    stretches = [values[begin:end] for begin, end in zip(begins, ends, strict=True)]
    levels = np.array([float(np.median(each)) for each in stretches])
    scatter = np.sqrt(
        np.mean(np.concatenate([(x - level) ** 2 for x, level in zip(stretches, levels, strict=True)]))
    )
    if np.any(np.abs(np.diff(levels)) < least) or scatter > _STEADY * noise:
        return None
    kept: list[float] = []
    for level in sorted(levels):
        if not kept or level - kept[-1] > _ALIKE * np.ptp(levels):
            kept.append(float(level))
    count = sum(map(len, stretches))
    shares = [
        sum(len(each) for each, level in zip(stretches, levels, strict=True) if _nearest(kept, level) == n)
        for n in range(len(kept))
    ]
    if min(shares) < _LEAST_SHARE * len(values):
        return None
    listed = ", ".join(
        f"{100 * share / count:.0f} % {of if n == 0 else 'at'} {level:.3g} {unit}"
        for n, (share, level) in enumerate(zip(shares, kept, strict=True))
    )
    word = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}[len(kept)]
    return Regimes(
        len(kept),
        f"{word} regimes: of the record about {listed}; the numbers are of all together: choose one "
        f"with --from and --to",
    )


def _nearest(levels: list[float], level: float) -> int:
    return int(np.argmin([abs(each - level) for each in levels]))


def _two_levels(values: NDArray[np.float64], greatest: float, unit: str, of: str) -> str:
    """Return what to say if parts of the record have either of two levels, with hardly any between.

    It is by the best split in two of the sorted values, by the share of their variance that the two means
    explain (Otsu, IEEE Trans. Syst. Man Cybern. 9 (1979) 62).
    """
    count = len(values)
    if not count or not float(np.var(values)) > 0.0:
        return ""
    ordered = np.sort(values)
    below = np.arange(1, count)
    lower = np.cumsum(ordered)[:-1] / below
    upper = (np.sum(ordered) - np.cumsum(ordered)[:-1]) / (count - below)
    share = below / count
    explained = share * (1.0 - share) * (upper - lower) ** 2 / float(np.var(values))
    best = int(np.argmax(explained))
    fewest = min(below[best], count - below[best])
    change = float(upper[best] - lower[best])
    if explained[best] < _EXPLAINED or fewest < 0.05 * count or change < _LARGEST_CHANGE * greatest:
        return ""
    is_low = values <= ordered[best]
    if np.count_nonzero(np.diff(is_low)) > count // 4:  # it oscillates, and has no regimes
        return ""
    return (
        f"two regimes: {100 * share[best]:.0f} % of the record {of} {lower[best]:.3g} {unit}, the rest "
        f"{upper[best]:.3g} {unit}; the numbers are of both together: choose one with --from and --to"
    )
