"""Regimes of a record: stretches of it at levels of their own, which one number would average."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_PARTS, _FINE_PARTS = 64, 256
_FEWEST_PER_PART = 8
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
    for measured, of in ((np.mean, "average"), (np.std, "have an rms deviation of")):
        values, fine = (_of_parts(measured, samples, most) for most in (_PARTS, _FINE_PARTS))
        for each in (values, fine):
            if len(each) and (found := _stretches(each, greatest, unit, of)):
                return found
        if text := _two_levels(values, greatest, unit, of):
            return Regimes(2, text)
    return None


def _of_parts(
    measured: Callable[..., NDArray[np.float64]], samples: NDArray[np.float64], most: int
) -> NDArray[np.float64]:
    """Return what is measured of each of up to so many parts of samples, shape (n,); of too few none."""
    count = min(most, len(samples) // _FEWEST_PER_PART)
    if count < _FEWEST_PER_PART:
        return np.empty(0)
    rows, longer = divmod(len(samples), count)  # the first parts have a row more
    split = longer * (rows + 1)
    both = samples[:split].reshape(longer, rows + 1), samples[split:].reshape(-1, rows)
    return np.concatenate([measured(each, axis=1) for each in both])


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
