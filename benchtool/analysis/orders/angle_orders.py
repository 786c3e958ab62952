"""Orders of a signal from pairs of angle and value alone, without time or even steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import TURN, AngleCoverage
from benchtool.analysis.orders.between_orders import (
    FEWEST_REVOLUTIONS as FEWEST_BETWEEN,
    fitted_share,
    noise_between_orders,
)
from benchtool.analysis.orders.order_courses import CoursesByAngle, of_levels
from benchtool.analysis.orders.slow_course import Turns, is_no_chance, slow_course
from benchtool.analysis.validity import require_signal
from benchtool.errors import AnalysisError

_SECTORS = 360
_USABLE_BAND = 0.45  # of one over the longest arc without a sample: the circle's Nyquist limit is 0.5
_STEPS_PER_PERIOD = 10  # of a coarse angle: the fit is then at most sinc(1/10) = 1.6 % low
_CELLS_PER_UNKNOWN = 2
_WORST_CONDITION = 0.2  # least eigenvalue of the normal matrix, 1 for even coverage
_FEWEST_REVOLUTIONS = 4  # for a scatter over revolutions
_FEWEST_OF_PHASE = 8  # revolutions whose phase is told to wander
_CLEARLY = 6.0  # a ratio of variances of as many revolutions: by chance once in a hundred, or much less
_SHOWS = 0.25  # scatter of an amplitude over its mean; of noise alone it is 0.52 (Rayleigh)
MOST_GROUPS = 1000  # which are held in memory, each with the sums of all orders
_PLACES = 8  # in a revolution, by which it is told to be whole
_PASSES = 3  # of a course and of orders beside it
_PIECE = 256  # samples whose powers stay in the cache


@dataclass(frozen=True)
class AngleFit:
    """Orders 1 to K: `coefficient`, complex, shape (K,), is half the peak amplitude, with the phase.

    `standard` is the standard uncertainty of the peak amplitude, shape (K,), by `uncertainty_source`; `noise`
    is the part of it that noise has, an estimate of `noise_dof` degrees of freedom, shape (K,): nan where the
    angles do not tell it. `left_rms` is what the fit does not explain. `on_a_course` is whether a course
    from revolution to revolution, of the values or of the amplitude of an order, was taken off before.
    """

    coefficient: NDArray[np.complex128]
    standard: NDArray[np.float64]
    uncertainty_source: str
    mean: float
    left_rms: float
    noise: NDArray[np.float64]
    noise_dof: NDArray[np.float64]
    on_a_course: bool = False


def fit_orders(
    coverage: AngleCoverage, values: NDArray[np.float64], highest_order: int, name: str = "values"
) -> AngleFit:
    """Return sines of orders 1 to `highest_order` and a constant, fitted on angle by weighted least squares.

    As Lomb and Scargle fit one sine to uneven samples, but with all orders at once, so that uneven coverage
    does not leak one order into another. Every degree of every revolution has the same weight, however long
    the rotor stayed there. Fewer orders are fitted where the coverage cannot separate more: below 0.45 of one
    over the longest arc (in turns) without a sample, a tenth of the steps in which the angle counts, a
    quarter of the degrees visited in all revolutions, 0.45 of the rows in a revolution where these are fewer
    than four, and as long as the least eigenvalue of the normal matrix is above 0.2. Content above the
    highest fitted order may alias into those below: it is not filtered.

    A course that the values clearly have from revolution to revolution, as a speed that is run up has, is
    taken off (`slow_course`): within each it looks like orders. So is a course of the amplitude of an order
    that a curve explains, down to its level (`CoursesByAngle`).

    The uncertainty is the scatter over revolutions (four at least), by a variance that is robust to
    correlation within a revolution (the sandwich formula, clustered by revolution); with fewer it is the
    noise between the orders (`noise_between_orders`), and of hardly more than one there is none.

    Args:
        coverage: the angle.
        values: shape (n,), taken at those angles.
        highest_order: fit no orders above it.
        name: what the values are, in messages.

    Raises:
        AnalysisError: not finite, constant, or the samples do not determine even order 1.
    """
    require_signal(values, name)
    cell = coverage.revolution * _SECTORS
    cell += np.floor(np.mod(coverage.angle_rad, TURN) * (_SECTORS / TURN)).astype(np.int64) % _SECTORS
    _, place, visits = np.unique(cell, return_inverse=True, return_counts=True)
    weights = 1.0 / visits[place]
    weights /= weights.sum()
    order = min(highest_order, len(visits) // (2 * _CELLS_PER_UNKNOWN), _resolved(coverage))
    if coverage.revolutions < _FEWEST_REVOLUTIONS:
        # with orders k and N - k of N rows a revolution a fit takes along all noise that is between them
        order = min(order, max(1, int(_USABLE_BAND * len(values) / coverage.revolutions)))
    sums, products = _sums(coverage, weights, values, max(order, 1))
    total = sums.sum(axis=0)
    while order > 0 and not _well_conditioned(_normal(total, order)):
        order = order * 4 // 5
    if order < 1:
        raise AnalysisError(
            f"the angles leave out an arc of {math.degrees(coverage.largest_arc_rad):.3g} degrees, so that "
            f"order 1 is not told from the mean: record angles all round"
        )
    from scipy.linalg import cho_factor, cho_solve
    from scipy.signal import fftconvolve  # draws in scipy.stats, which takes longer than all else here

    factor = cho_factor(_normal(total, order))
    of_weights = _both_sides(sums[:, : 2 * order + 1])
    turns, of_each = _turns(coverage, weights), np.real(sums[:, 0])
    passed = (coverage.angle_rad - coverage.angle_rad.min()) / TURN
    courses = CoursesByAngle.none_over(turns, float(np.max(np.abs(values))))
    has_course = False
    for taken_off in range(1 + _PASSES):
        # the unknowns c of exp(1j k angle), k = -order ... order
        full = _both_sides(products[:, : order + 1])
        solution = cho_solve(factor, full.sum(axis=0))
        scores = full - fftconvolve(of_weights, solution[np.newaxis], "valid", axes=1)  # add up to zero
        shift = cho_solve(factor, scores.T)[order:]
        if taken_off == _PASSES:
            break
        each = solution[order:, np.newaxis] + (shift / of_each)[:, turns.whole]
        each[1:] *= 2.0
        known, courses = courses, courses.found_in(each)
        off = courses.beside_levels(passed, coverage.angle_rad)
        off -= known.beside_levels(passed, coverage.angle_rad)
        course = None if 0 in courses.courses else slow_course(np.real(scores[:, order]), turns)
        if course is not None and (has_course or is_no_chance(course)):
            has_course = True
            along = course(passed)
            off += along - weights @ along
        if not np.any(off):
            break
        values = values - off
        products = products[:, : order + 1] - _sums(coverage, weights, off, order)[1]
    coefficient = np.asarray(solution[order + 1 :], dtype=np.complex128)
    towards = coefficient / np.maximum(np.abs(coefficient), np.finfo(float).tiny)
    revolutions = len(scores)
    power = max(0.0, float(weights @ values**2 - np.real(np.vdot(solution, full.sum(axis=0)))))
    fitted = (2 * order + 1) * float(weights @ weights)  # share of white noise that the unknowns take along
    if coverage.revolutions >= _FEWEST_REVOLUTIONS:
        # one that is not complete counts as the part that it is
        alike = 1.0 / float(np.sum(np.real(sums[:, 0]) ** 2))
        turned = np.conj(towards)[:, np.newaxis] * shift[1:]
        along2, across2 = np.sum(turned.real**2, axis=1), np.sum(turned.imag**2, axis=1)
        left = 1.0 - max(1.0 / alike, fitted)
        freedom = np.full(order, max(1.0, alike * left))
        noise = 2.0 * np.sqrt(along2 / left)
        standard = np.hypot(noise, of_levels(courses.courses, order))
        what = "revolutions" if revolutions < MOST_GROUPS else "groups of revolutions"
        source = f"scatter of the amplitude over {revolutions} {what}, as standard error of its mean"
        if revolutions >= _FEWEST_OF_PHASE:
            lost = _lost(coefficient, along2, across2, revolutions)
            lost = np.maximum(lost, _turned(coefficient, shift[1:], of_each))
            standard = np.hypot(standard, lost)
            source += ", and what a phase that wanders takes off it"
    else:
        source = "noise halfway between the orders: with fewer than 4 revolutions none from their scatter"
        noise = standard = freedom = np.full(order, math.nan)
        if coverage.revolutions >= FEWEST_BETWEEN:
            between = cho_solve(factor, _between(coverage, weights, values, solution))[order:]
            of_whole = 1.0 / coverage.revolutions  # what is at whole orders, of white noise
            beyond = (fitted - of_whole) / (1.0 - of_whole)
            share = max(beyond, fitted_share(coverage.revolutions))
            noise, freedom = noise_between_orders(coefficient, between, share)
            standard = noise
    mean = float(np.real(solution[order]))
    return AngleFit(
        coefficient,
        standard,
        source,
        mean,
        math.sqrt(power),
        noise,
        freedom,
        has_course or bool(courses.courses),
    )


def _lost(
    coefficient: NDArray[np.complex128],
    along2: NDArray[np.float64],
    across2: NDArray[np.float64],
    revolutions: int,
) -> NDArray[np.float64]:
    """Return what is lost of the amplitude of each order to a phase that differs between revolutions, as that
    of an encoder that slips: half of the phase's variance times it, 0 where noise explains it.

    `along2` and `across2` are sums over the revolutions of the squares of what each adds along a coefficient
    and across it.
    """
    size2 = np.maximum(np.abs(coefficient) ** 2, np.finfo(float).tiny)
    excess = np.where(across2 > _CLEARLY * along2, across2 - along2, 0.0)
    return np.asarray(2.0 * np.abs(coefficient) * np.minimum(1.0, 0.5 * revolutions * excess / size2))


def _turned(
    coefficient: NDArray[np.complex128], shift: NDArray[np.complex128], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what is lost of the amplitude of each order to a phase that turns far over the revolutions: by
    how much less it is than in each of them, 0 where noise hides it there.

    `shift`, shape (K, revolutions), is what each revolution adds to the coefficients, `share` how much of all
    it is. Those that are hardly begun tell nothing.
    """
    whole = share > 0.5 * np.max(share)
    each = np.abs(coefficient[:, np.newaxis] + shift[:, whole] / share[whole])
    mean, scatter = np.mean(each, axis=1), np.std(each, axis=1, ddof=1)
    # noise has added to the squares along the phase of each revolution and across it
    alone = np.sqrt(np.maximum(0.0, mean**2 - scatter**2))
    lost = np.where(scatter < _SHOWS * mean, alone - np.abs(coefficient), 0.0)
    return np.asarray(2.0 * np.maximum(0.0, lost))


def sector_means(
    coverage: AngleCoverage, values: NDArray[np.float64], sectors: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the synchronous average: mean value in equal sectors of the circle, and how many revolutions are
    in each.

    Within a sector each revolution counts the same. Sector k, of shape (sectors,), begins at k turns divided
    by `sectors`; a sector without a sample is nan.
    """
    sector = np.floor(np.mod(coverage.angle_rad, TURN) * (sectors / TURN)).astype(np.int64) % sectors
    cell = coverage.revolution * sectors + sector
    visited, place, visits = np.unique(cell, return_inverse=True, return_counts=True)
    means = np.bincount(place, weights=values) / visits
    revolutions = np.bincount(visited % sectors, minlength=sectors)
    sums = np.bincount(visited % sectors, weights=means, minlength=sectors)
    mean = np.divide(sums, revolutions, out=np.full(sectors, np.nan), where=revolutions > 0)
    return mean, revolutions


def _resolved(coverage: AngleCoverage) -> int:
    limit = _USABLE_BAND * TURN / coverage.largest_arc_rad
    if coverage.resolution_rad > 0.0:
        limit = min(limit, TURN / coverage.resolution_rad / _STEPS_PER_PERIOD)
    return math.floor(min(limit, 1e9))


def _between(
    coverage: AngleCoverage,
    weights: NDArray[np.float64],
    values: NDArray[np.float64],
    solution: NDArray[np.complex128],
) -> NDArray[np.complex128]:
    """Return sums of w (x - fit) exp(-1j (m + 1/2) angle), m = -K ... K, shape (2 K + 1,), for unknowns of
    orders -K ... K."""
    order = len(solution) // 2
    sums, products = (each.sum(axis=0) for each in _sums(coverage, weights, values, order, 0.5))
    full, of_weights = (
        np.concatenate([np.conj(each[::-1]), each]) for each in (products, sums)
    )  # from -K - 1/2 and -2 K - 1/2
    return np.asarray((full - np.convolve(of_weights, solution, "valid"))[1:])


def _turns(coverage: AngleCoverage, weights: NDArray[np.float64]) -> Turns:
    """Return where the revolutions are, or the groups of them that `_sums` has rows of."""
    group, rows = _groups(coverage)
    visits = np.bincount(group, minlength=rows)
    visited = visits > 0
    weight = np.bincount(group, weights=weights, minlength=rows)[visited]
    turns = (coverage.angle_rad - coverage.angle_rad.min()) / TURN
    middle = np.bincount(group, weights=weights * turns, minlength=rows)[visited] / weight
    first = np.unique(np.floor(turns * _PLACES), return_index=True)[1]
    places = np.bincount(group[first], minlength=rows)[visited]
    edges = np.ceil(np.arange(rows + 1) * (int(coverage.revolution.max()) + 1) / rows)
    return Turns(
        middle=middle,
        edges=np.stack([edges[:-1], edges[1:]], axis=1)[visited],
        total=coverage.revolutions,
        weight=np.asarray(weight, dtype=np.float64),
        places=places,
        rows=float(np.mean(visits[visited])),
    )


def _groups(coverage: AngleCoverage) -> tuple[NDArray[np.int64], int]:
    """Return the group of each value, a revolution or some of them where they are many, and their number."""
    last = int(coverage.revolution.max())
    rows = min(last + 1, MOST_GROUPS)
    return coverage.revolution * rows // (last + 1), rows


def _sums(
    coverage: AngleCoverage,
    weights: NDArray[np.float64],
    values: NDArray[np.float64],
    order: int,
    first: float = 0.0,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return sums of w exp(-1j m angle), m = f ... f + 2 `order`, and of w x exp(-1j m angle), m = f ... f +
    `order`, with the `first` order f.

    A row for each revolution, or for each group of them where they are many.
    """
    group, rows = _groups(coverage)
    sums = np.zeros((rows, 2 * order + 1), dtype=np.complex128)
    products = np.zeros((rows, order + 1), dtype=np.complex128)
    weighted = weights * values
    powers = np.empty((2 * order + 1, _PIECE), dtype=np.complex128)
    in_order = np.argsort(group, kind="stable")  # a rotor that turns back visits one twice
    bounds = np.concatenate(([0], np.cumsum(np.bincount(group, minlength=rows))))
    for row in range(rows):
        for begin in range(bounds[row], bounds[row + 1], _PIECE):
            piece = in_order[begin : min(begin + _PIECE, bounds[row + 1])]
            filled = powers[:, : len(piece)]
            _raise(np.exp(-1j * coverage.angle_rad[piece]), filled)
            if first:
                filled *= np.exp(-1j * first * coverage.angle_rad[piece])
            # not a matrix product, whose threads cost more than they save on pieces of this size
            sums[row] += np.vecdot(weights[piece], filled)
            products[row] += np.vecdot(weighted[piece], filled[: order + 1])
    visited = bounds[1:] > bounds[:-1]
    return sums[visited], products[visited]


def _raise(base: NDArray[np.complex128], powers: NDArray[np.complex128]) -> None:
    """Fill `powers`, shape (count, n), with powers 0 to `count` - 1, each the product of two known ones."""
    powers[0] = 1.0
    powers[1:2] = base
    known = 2
    while known < len(powers):
        more = min(known - 1, len(powers) - known)
        np.multiply(powers[known - 1], powers[1 : more + 1], out=powers[known : known + more])
        known += more


def _both_sides(sums: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the rows of sums for m = 0 ... n, shape (rows, n + 1), as rows for m = -n ... n: the signals are
    real."""
    return np.concatenate([np.conj(sums[:, :0:-1]), sums], axis=1)


def _well_conditioned(normal: NDArray[np.complex128]) -> bool:
    """Return whether no eigenvalue is below the limit: what is left of them is positive, so Cholesky
    succeeds."""
    try:
        np.linalg.cholesky(normal - _WORST_CONDITION * np.eye(len(normal)))
    except np.linalg.LinAlgError:
        return False
    return True


def _normal(sums: NDArray[np.complex128], order: int) -> NDArray[np.complex128]:
    """Return the normal matrix of unknowns -order ... order: row j, column k is the sum of w exp(1j (k - j)
    angle)."""
    from scipy.linalg import toeplitz

    return np.asarray(toeplitz(sums[: 2 * order + 1], np.conj(sums[: 2 * order + 1])))
