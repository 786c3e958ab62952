"""The motion of a shaft behind the counts of its encoder, to a few thousandths of a count.

A motion that is smooth in time and repeats some orders in every revolution is in the count of every row where
it is right. Where it is off by a small part d of a count, a share d of the rows is in the next one: so by how
many counts rows differ is on average the motion's own error, without the rounding of the counts, which a fit
to these would take for a motion where it moves slowly. Newton's method with the normal equations of a fit
brings that to nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_MOST_ROWS = 1 << 14  # that tell the motion
_HIGHEST_ORDER, _MOST_ORDERS = 200, 40
_PIECES = 1, 4, 16, 64, 256  # of a spline over the time
_DEGREE = 3
_FEWEST_PER_PIECE = 8  # rows
_FOLLOWED = 2e-3  # share of the rows that are in another count
_NEARLY_FOLLOWED = 0.3  # likewise, where what is left is no course that more pieces follow
_CLEARLY_LESS = 0.9  # times as many: of a shaft that shakes, more pieces follow some of that
_STANDS_OUT = 3.0  # times the rms of noise: by chance one of 200 orders in 40 records
_NEAR_LARGEST = 0.3  # of the largest: less may be made by its lack
_ROUNDS = 40
_FEWEST_EDGES, _MOST_EDGES = 16, 1 << 22
_RIDGE = 1e-9  # relative: splines of many pieces follow low orders, too
_VARIES = 0.01  # of the speed, rms
_NEARLY_STANDS = 0.2  # of the mean speed
_ROUNDING = 1.0 / math.sqrt(12.0)  # of a count: the deviation of what lies anywhere in it
_OF_MEAN_SIZE = math.sqrt(0.5 * math.pi)  # rms of a normal distribution over the mean of its size
_SHAKES = 0.1  # share of rows in another count up to which that is the mean size of the rest, in counts


@dataclass(frozen=True)
class CountedMotion:
    """A motion in counts: a spline over time, with its `knots` and `slow` coefficients, and `waves` of
    `orders` of the angle, a row each, as of `_columns`.

    `elsewhere` is the share of the rows that it has in another count than was read, `shakes` the rms, in
    counts, of what it does not follow from row to row, and `edges` the part of it that is the same whenever
    a count comes round: those of the encoder are as far off even places.
    """

    knots: Floats
    slow: Floats
    orders: tuple[int, ...]
    waves: Floats
    varies: bool
    elsewhere: float
    shakes: float
    edges: float

    def at(self, times: Floats, angle_rad: Floats) -> Floats:
        """Return its places at times and angles, shape (n,), in counts."""
        from scipy.interpolate import BSpline

        spline = BSpline(self.knots, self.slow, _DEGREE)
        places = np.asarray(spline(times), dtype=np.float64)
        slowness = _slowness(spline.derivative()(times)) if self.varies else None
        for order, wave in zip(self.orders, self.waves, strict=True):
            places += _columns(np.exp(1j * order * angle_rad), slowness) @ wave
        return places


def motion_behind(counts: Floats, times: Floats, count_rad: float) -> CountedMotion:
    """Return the motion behind whole counts of `count_rad`, shape (n,), read at rising `times`: of the
    smoothest slow course that follows them, or else as well as any."""
    few = np.arange(len(counts))
    if len(few) > _MOST_ROWS:  # not evenly, where rounding is in other lines than that of all rows
        few = np.sort(np.random.default_rng(0).choice(few, _MOST_ROWS, replace=False))
    counts, times = counts[few], times[few]
    carriers = np.exp(1j * np.outer(count_rad * counts, np.arange(1, _HIGHEST_ORDER + 1)))
    rungs = [each for each in _PIECES if each == 1 or each * _FEWEST_PER_PIECE <= len(times)]
    per_turn = round(2.0 * math.pi / count_rad)
    best = _followed(counts, times, carriers, rungs[0], per_turn)
    for pieces in rungs[1:]:
        if best.elsewhere < _FOLLOWED:
            break
        found = _followed(counts, times, carriers, pieces, per_turn)
        is_better = found.elsewhere < _CLEARLY_LESS * best.elsewhere
        if not is_better and best.elsewhere < _NEARLY_FOLLOWED:
            break
        best = found if is_better else best
    return best


def _followed(counts: Floats, times: Floats, carriers: Complex, pieces: int, per_turn: int) -> CountedMotion:
    """Return the motion with a spline of so many pieces, and of orders as long as some stand out of what
    counts it is off by."""
    from scipy.interpolate import BSpline

    inner = np.quantile(times, np.linspace(0.0, 1.0, pieces + 1))
    knots = np.concatenate([[inner[0]] * _DEGREE, inner, [inner[-1]] * _DEGREE])
    table = BSpline.design_matrix(times, knots, _DEGREE).toarray()
    splines = table.shape[1]
    found = _fit_of(table)(counts + 0.5)
    of_speed = _slowness(BSpline(knots, found, _DEGREE).derivative()(times))
    slowness = of_speed if float(np.std(of_speed)) > _VARIES else None
    orders: list[int] = []
    while True:
        found, elsewhere = _into_counts(counts, table, found)
        off = counts - np.floor(table @ found)
        more = _standing_out(off, carriers, orders) if elsewhere > _FOLLOWED else []
        if not more or len(orders) + len(more) > _MOST_ORDERS:
            break
        orders += more
        waves = [_columns(carriers[:, each - 1], slowness) for each in more]
        table = np.concatenate([table, *waves], axis=1)
        found = np.concatenate([found, np.zeros(table.shape[1] - len(found))])
    shakes = _OF_MEAN_SIZE * elsewhere
    if elsewhere > _SHAKES:
        shakes = math.sqrt(max(0.0, float(np.mean((counts + 0.5 - table @ found) ** 2)) - _ROUNDING**2))
    return CountedMotion(
        knots,
        found[:splines],
        tuple(orders),
        found[splines:].reshape(len(orders), 2 if slowness is None else 4),
        slowness is not None,
        elsewhere,
        shakes,
        _of_edges(counts, np.floor(table @ found), per_turn),
    )


def _into_counts(counts: Floats, table: Floats, found: Floats) -> tuple[Floats, float]:
    """Return the coefficients, shape (columns,), with which fewest rows are in another count than was read,
    and their share, from those `found` so far on."""
    fit, least, kept = _fit_of(table), math.inf, found
    for _ in range(_ROUNDS):
        off = counts - np.floor(table @ found)
        elsewhere = float(np.mean(off != 0.0))
        if elsewhere < least:
            least, kept = elsewhere, found
        if not elsewhere > 0.0:
            break
        found = found + fit(off)
    return kept, least


def _of_edges(counts: Floats, expected: Floats, per_turn: int) -> float:
    """Return the rms, in counts, by which edges are off even places: whole counts, shape (n,), differ from
    those `expected` in a share of the rows that is an edge's own, alike in both halves of a record."""
    if per_turn > _MOST_EDGES:
        return 0.0
    edge = np.mod(np.maximum(counts, expected), per_turn).astype(np.int64)
    half = len(counts) // 2
    rows = np.stack([np.bincount(each, minlength=per_turn) for each in (edge[:half], edge[half:])])
    off = [
        np.bincount(edge[part], (counts - expected)[part], per_turn)
        for part in (slice(0, half), slice(half, None))
    ]
    are_twice = np.min(rows, axis=0) > 0
    if np.count_nonzero(are_twice) < _FEWEST_EDGES:
        return 0.0
    product = np.prod(np.stack(off)[:, are_twice] / rows[:, are_twice], axis=0)
    square = float(np.mean(product))
    by_chance = float(np.std(product)) / math.sqrt(len(product))
    return math.sqrt(square) if square > _STANDS_OUT * by_chance else 0.0


def _fit_of(table: Floats) -> Callable[[Floats], Floats]:
    """Return the function that fits the columns of a table, shape (n, columns), to values, shape (n,)."""
    from scipy.linalg import cho_factor, cho_solve

    normal = table.T @ table
    normal[np.diag_indices(len(normal))] *= 1.0 + _RIDGE
    factor = cho_factor(normal)
    return lambda values: np.asarray(cho_solve(factor, table.T @ values))


def _standing_out(off: Floats, carriers: Complex, known: list[int]) -> list[int]:
    """Return the orders besides those known that stand out of what a motion is off by, shape (n,)."""
    size = 2.0 * np.abs(off @ carriers) / len(off)
    noise = 2.0 * math.sqrt(float(np.mean(off**2)) / len(off))
    least = max(_STANDS_OUT * noise, _NEAR_LARGEST * float(np.max(size)))
    return [each for each in (np.flatnonzero(size > least) + 1).tolist() if each not in known]


def _columns(carrier: Complex, slowness: Floats | None) -> Floats:
    """Return the columns of a table for an order, shape (n, 2), or (n, 4) of a speed that varies: an error of
    the encoder is the same at each, and a ripple of the speed turns the shaft further the slower it is."""
    waves = np.stack([carrier.real, carrier.imag], axis=1)
    return waves if slowness is None else np.concatenate([waves, waves * slowness[:, np.newaxis]], axis=1)


def _slowness(speed: Floats) -> Floats:
    """Return by how much the inverse of a speed, shape (n,), exceeds that of its mean, relative to it."""
    mean = float(np.mean(speed))
    relative = speed / mean if mean else np.ones(len(speed))
    return np.asarray(1.0 / np.maximum(relative, _NEARLY_STANDS) - 1.0)
