"""Times of rows that are not what they should be: rows that scatter about them, or hold an older sample.

On its way a signal changes with time, and an error of the time is one of the value, in proportion to the
slope. At rest nothing shows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise

Floats = NDArray[np.float64]

_ORDERS = 2, 4  # of the prediction: one mode that decays or oscillates, and two
_STEEP = 0.03  # of the steepest slope
_CLEAR = 3.0  # times the noise: what a steep slope changes in one row
_FEWEST = 5  # rows on a steep slope, beyond the numbers that are fitted
_ROUGH = 2.0  # times the noise
_OF_MEDIAN = 1.0 / 0.4549  # mean square over median square, of normal values
_OF_SQUARE = 1.9  # relative standard deviation of that of one row
_FAR_FROM_STEP = 2.0  # steps of a converter: neighbours so far apart are not equal by it
_ROUNDING = 1e-6  # of the greatest change from row to row
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_ROUNDS = 10
_FEWEST_CHANGES = 10
_LONGEST, _OFTEN = 3, 0.1  # rows that repeat one; of those on the way, of which more are no rare lapse
_BESIDE = 3  # rows to either side, the polynomial through which is what a course does between


def scatter_of_times(samples: Floats, noise: Noise, step: float) -> float:
    """Return the standard deviation of the times of the rows of a transient, shape (n,), in rows; 0 where
    they show none.

    Exponentials and oscillations follow from a few samples before, and a slow course has no fourth
    difference. The least that these leave on steep slopes, relative to them, is that of the times, where it
    is more than `noise` and the `step` of a converter, with its own standard deviation added: too little
    would be far too certain. It is by the median: corners are few. Rows that repeat the one before, each of
    which is a row late, are counted.
    """
    repeated = _of_repeated(samples, _far(noise, step))
    least = math.inf
    for residual, weights, fitted in _residuals(samples):
        of_noise = math.hypot(noise.of_sum(weights), step * math.sqrt(float(weights @ weights) / 12.0))
        of_row = _changed_in_a_row(samples, weights)
        steep = _on_slope(samples, len(weights)) & (of_row > _CLEAR * of_noise)
        rows = int(np.count_nonzero(steep))
        if rows < fitted + _FEWEST:
            break
        if math.sqrt(_OF_MEDIAN * float(np.median(residual[steep] ** 2))) <= _ROUGH * of_noise:
            least = 0.0
            break
        left = _OF_MEDIAN * float(np.median((residual[steep] / of_row[steep]) ** 2))
        left *= rows / (rows - fitted)
        least = min(least, left * (1.0 + _OF_SQUARE / math.sqrt(rows)))
    return math.sqrt((least if math.isfinite(least) else 0.0) + repeated)


def _far(noise: Noise, step: float) -> float:
    """Return by how much neighbours differ that a converter does not make equal."""
    return _FAR_FROM_STEP * step + (_CLEAR * noise.rms if step else 0.0)


def _on_slope(samples: Floats, size: int) -> NDArray[np.bool_]:
    """Return where all of so many samples are on a steep slope: no jump between rows at rest."""
    change = np.abs(np.diff(samples))
    steep = change > _STEEP * float(np.max(change))
    return np.asarray(np.all(np.lib.stride_tricks.sliding_window_view(steep, size - 1), axis=1))


def _changed_in_a_row(samples: Floats, weights: Floats) -> Floats:
    """Return what sums of samples with these weights, latest first, change by if each is a row away, in any
    direction: of sums up to each row, beginning with the first whole one."""
    slope = np.abs(np.gradient(samples))
    slope[1:-1] = np.maximum(slope[1:-1], np.maximum(slope[:-2], slope[2:]))
    return np.asarray(np.sqrt(np.maximum(np.convolve(slope**2, weights**2, mode="valid"), 0.0)))


def _residuals(samples: Floats) -> Iterator[tuple[Floats, Floats, int]]:
    """Yield what sums of neighbours leave of samples, shape (n,), their weights, latest first, and how many
    numbers were fitted."""
    for order in _ORDERS:
        rows = len(samples) - order
        if rows > order + _FEWEST:
            known = np.stack([samples[lag : lag + rows] for lag in range(order)] + [np.ones(rows)], axis=1)
            solution = _least_deviations(known, samples[order:])
            weights = np.concatenate([[1.0], -solution[order - 1 :: -1]])
            yield samples[order:] - known @ solution, weights, order + 1
            if order == _ORDERS[0]:
                yield np.convolve(samples, _FOURTH_DIFFERENCE, mode="valid"), _FOURTH_DIFFERENCE, 0


def _least_deviations(known: Floats, wanted: Floats) -> Floats:
    """Return the factors, shape (k,), of the columns of `known`, shape (n, k), that leave about the least sum
    of magnitudes of `wanted`, shape (n,): the few rows in which a transient sets in follow from none before
    them (iteratively reweighted least squares: Schlossmacher, J. Am. Stat. Assoc. 68 (1973) 857)."""
    weights = np.ones(len(wanted))
    for _ in range(_ROUNDS):
        solution, *_ = np.linalg.lstsq(known * weights[:, np.newaxis], wanted * weights, rcond=None)
        left = np.abs(wanted - known @ solution)
        weights = 1.0 / np.sqrt(np.maximum(left, float(np.median(left)) + np.finfo(float).tiny))
    return np.asarray(solution)


@dataclass(frozen=True)
class Repeats:
    """Samples, shape (n,), `without` the rows that repeat the one before, of which there are `count`, and the
    standard uncertainty of these, `doubt`, shape (n,), 0 of all others."""

    without: Floats
    doubt: Floats
    count: int = 0

    @classmethod
    def among(cls, samples: Floats, noise: Noise, step: float) -> Repeats:
        """Find the rows of samples, shape (n,), that repeat the one before on the way, up to three of them,
        and put them on the polynomial through three rows to either side; where they are often there are none.

        They tell nothing: noise alone makes no two rows equal, and the `step` of a converter, on whose levels
        they are put, none among changes of more than both. How far they are from the cubic through two rows
        to either side is how little they are known.
        """
        lapses = _lapses(samples, _far(noise, step))
        if not lapses:
            return cls(samples, np.zeros(len(samples)))
        is_new = np.ones(len(samples), dtype=np.bool_)
        for begin, end in lapses:
            is_new[begin + 1 : end + 1] = False
        new = np.flatnonzero(is_new)
        without, doubt = samples.copy(), np.zeros(len(samples))
        for begin, end in lapses:
            at = int(np.searchsorted(new, begin)) + 1
            rows, near = np.arange(begin + 1, end + 1), new[max(0, at - _BESIDE) : at + _BESIDE]
            values = _through(near, samples[near], rows)
            doubt[rows] = np.abs(values - _through(near[1:-1], samples[near[1:-1]], rows))
            if step:
                values = samples[begin] + step * np.round((values - samples[begin]) / step)
            without[rows] = values
        return cls(without, doubt, len(samples) - len(new))


def _lapses(samples: Floats, far: float) -> list[tuple[int, int]]:
    """Return rows that are repeated, between changes of more than `far`, and the last that repeat each; none
    where that is often."""
    changes = np.abs(np.diff(samples))
    moves = changes > max(far, _ROUNDING * float(np.max(changes, initial=0.0)))
    edges = np.flatnonzero(np.diff(changes == 0.0, prepend=False, append=False)).reshape(-1, 2)
    short = edges[(edges[:, 1] - edges[:, 0] <= _LONGEST) & (edges[:, 0] > 0) & (edges[:, 1] < len(changes))]
    found = short[moves[short[:, 0] - 1] & moves[short[:, 1]]]
    rare = np.sum(found[:, 1] - found[:, 0]) <= _OFTEN * np.count_nonzero(moves)
    return [(begin, end) for begin, end in found.tolist()] if rare else []


def _through(known: NDArray[np.int64], values: Floats, rows: NDArray[np.int64]) -> Floats:
    """Return the polynomial through values in known rows, in others, shape (n,)."""
    from scipy.interpolate import barycentric_interpolate

    return np.asarray(barycentric_interpolate(known, values, rows))


def _of_repeated(samples: Floats, far: float) -> float:
    """Return the mean square of how late samples, shape (n,), are because some rows repeat the one before.

    Equal to it, between two that change by more than `far`, which a converter makes equal too, are those
    alone: of a share q of repeated rows q (1 - q) of those that change. The rows late are geometrically
    distributed then.
    """
    changes = np.abs(np.diff(samples))
    moves = changes > max(far, _ROUNDING * float(np.max(changes, initial=0.0)))
    alone = (changes[1:-1] == 0.0) & moves[:-2] & moves[2:]
    if (moved := int(np.count_nonzero(moves))) < _FEWEST_CHANGES:
        return 0.0
    share = 0.5 - math.sqrt(max(0.0, 0.25 - float(np.count_nonzero(alone)) / moved))
    return share * (1.0 + share) / (1.0 - share) ** 2


def even_hold(samples: Floats) -> tuple[int, int]:
    """Return for how many rows each sample of a record, shape (n,), is held, and the first row with a new
    one; 1 and 0 where each row is a sample of its own.

    All changes are then a multiple of it apart, and most of them just that; `held_rows` is of holds that are
    not all equal.
    """
    changes = np.flatnonzero(np.diff(samples)) + 1
    apart = np.diff(changes)
    if len(apart) < _FEWEST_CHANGES:
        return 1, 0
    rows = int(np.gcd.reduce(apart))
    if rows < 2 or np.median(apart) != rows:
        return 1, 0
    return rows, int(changes[0]) % rows
