"""Orders of a signal from pairs of angle and value alone, without time or even steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import TURN, AngleCoverage
from benchtool.analysis.orders.angle_equations import (
    MOST_GROUPS,
    Equations,
    coefficients_of_all,
    groups_of,
    is_well_conditioned,
    sums_of,
)
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
_FEWEST_REVOLUTIONS = 4  # for a scatter over revolutions
_FEWEST_OF_PHASE = 8  # revolutions whose phase is told to wander
_CLEARLY = 6.0  # a ratio of variances of as many revolutions: by chance once in a hundred, or much less
_SHOWS = 0.25  # scatter of an amplitude over its mean; of noise alone it is 0.52 (Rayleigh)
_PLACES = 8  # in a revolution, by which it is told to be whole
_PASSES = 3  # of a course and of orders beside it


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
    weights, cells = _weights(coverage)
    order = min(highest_order, cells // (2 * _CELLS_PER_UNKNOWN), _resolved(coverage))
    if coverage.revolutions < _FEWEST_REVOLUTIONS:
        # with orders k and N - k of N rows a revolution a fit takes along all noise that is between them
        order = min(order, max(1, int(_USABLE_BAND * len(values) / coverage.revolutions)))
    sums, products = sums_of(coverage, weights, values, max(order, 1))
    total = sums.sum(axis=0)
    while order > 0 and not is_well_conditioned(total, order):
        order = order * 4 // 5
    if order < 1:
        raise AnalysisError(
            f"the angles leave out an arc of {math.degrees(coverage.largest_arc_rad):.3g} degrees, so that "
            f"order 1 is not told from the mean: record angles all round"
        )
    solved = _without_courses(Equations.of(sums, products, order), coverage, weights, values)
    coefficient = np.asarray(solved.unknowns[order + 1 :], dtype=np.complex128)
    spread = _spread(solved, coefficient, coverage, weights)
    return AngleFit(
        coefficient,
        spread.standard,
        spread.source,
        float(np.real(solved.unknowns[order])),
        solved.left_rms,
        spread.noise,
        spread.dof,
        solved.on_a_course,
    )


def amplitudes_of_all(
    coverage: AngleCoverage, values: NDArray[np.float64], orders: int
) -> NDArray[np.float64]:
    """Return the peak amplitudes of orders 1 to `orders`, as many as are fitted, of many signals at these
    angles, shape (signals, n), that have no courses: shape (signals, orders)."""
    weights, _ = _weights(coverage)
    return 2.0 * np.abs(coefficients_of_all(coverage, weights, values, orders))


def _weights(coverage: AngleCoverage) -> tuple[NDArray[np.float64], int]:
    """Return weights of samples, shape (n,), the same in sum for every degree of every revolution, and how
    many of these are visited."""
    cell = coverage.revolution * _SECTORS
    cell += np.floor(np.mod(coverage.angle_rad, TURN) * (_SECTORS / TURN)).astype(np.int64) % _SECTORS
    _, place, visits = np.unique(cell, return_inverse=True, return_counts=True)
    weights = 1.0 / visits[place]
    return weights / weights.sum(), len(visits)


@dataclass(frozen=True)
class _Solved:
    """The `unknowns` of equations, and by how much each group of revolutions moves the mean and orders 1 to
    K, `shift`, shape (1 + K, groups), of the `values` without their `courses`; `left_rms` is what is left,
    and `on_a_course` whether one was taken off."""

    equations: Equations
    values: NDArray[np.float64]
    unknowns: NDArray[np.complex128]
    shift: NDArray[np.complex128]
    courses: CoursesByAngle
    left_rms: float
    on_a_course: bool


def _without_courses(
    equations: Equations, coverage: AngleCoverage, weights: NDArray[np.float64], values: NDArray[np.float64]
) -> _Solved:
    """Return the solution for values without what they do from revolution to revolution."""
    order, turns = equations.order, _turns(coverage, weights)
    passed = (coverage.angle_rad - coverage.angle_rad.min()) / TURN
    courses = CoursesByAngle.none_over(turns, float(np.max(np.abs(values))))
    has_course = False
    for taken_off in range(1 + _PASSES):
        unknowns, scores = equations.solved()
        shift = equations.moved_by(scores.T)[order:]
        if taken_off == _PASSES:
            break
        each = unknowns[order:, np.newaxis] + (shift / equations.share)[:, turns.whole]
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
        equations = equations.less(sums_of(coverage, weights, off, order)[1])
    explained = float(np.real(np.vdot(unknowns, equations.right.sum(axis=0))))
    left_rms = math.sqrt(max(0.0, float(weights @ values**2) - explained))
    return _Solved(equations, values, unknowns, shift, courses, left_rms, has_course or bool(courses.courses))


@dataclass(frozen=True)
class _Spread:
    """Standard uncertainties of amplitudes, and the part that noise has, of so many degrees of freedom, all
    of shape (K,), and where they are from."""

    standard: NDArray[np.float64]
    noise: NDArray[np.float64]
    dof: NDArray[np.float64]
    source: str


def _spread(
    solved: _Solved,
    coefficient: NDArray[np.complex128],
    coverage: AngleCoverage,
    weights: NDArray[np.float64],
) -> _Spread:
    """Return how uncertain amplitudes are: by their scatter over revolutions or, of few, by the noise between
    the orders."""
    order, shift = len(coefficient), solved.shift[1:]
    fitted = (2 * order + 1) * float(weights @ weights)  # share of white noise that the unknowns take along
    if coverage.revolutions < _FEWEST_REVOLUTIONS:
        source = "noise halfway between the orders: with fewer than 4 revolutions none from their scatter"
        unknown = np.full(order, math.nan)
        if coverage.revolutions < FEWEST_BETWEEN:
            return _Spread(unknown, unknown, unknown, source)
        between = solved.equations.moved_by(_between(coverage, weights, solved.values, solved.unknowns))
        of_whole = 1.0 / coverage.revolutions  # what is at whole orders, of white noise
        beyond = (fitted - of_whole) / (1.0 - of_whole)
        share = max(beyond, fitted_share(coverage.revolutions))
        noise, freedom = noise_between_orders(coefficient, between[order:], share)
        return _Spread(noise, noise, freedom, source)
    # one that is not complete counts as the part that it is
    alike, revolutions = 1.0 / float(np.sum(solved.equations.share**2)), shift.shape[1]
    towards = coefficient / np.maximum(np.abs(coefficient), np.finfo(float).tiny)
    turned = np.conj(towards)[:, np.newaxis] * shift
    along2, across2 = np.sum(turned.real**2, axis=1), np.sum(turned.imag**2, axis=1)
    left = 1.0 - max(1.0 / alike, fitted)
    freedom = np.full(order, max(1.0, alike * left))
    noise = 2.0 * np.sqrt(along2 / left)
    standard = np.hypot(noise, of_levels(solved.courses.courses, order))
    what = "revolutions" if revolutions < MOST_GROUPS else "groups of revolutions"
    source = f"scatter of the amplitude over {revolutions} {what}, as standard error of its mean"
    if revolutions >= _FEWEST_OF_PHASE:
        lost = _lost(coefficient, along2, across2, revolutions)
        lost = np.maximum(lost, _turned(coefficient, shift, solved.equations.share))
        standard = np.hypot(standard, lost)
        source += ", and what a phase that wanders takes off it"
    return _Spread(standard, noise, freedom, source)


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
    it is. Those that are hardly begun tell nothing, and neither does a single one.
    """
    whole = share > 0.5 * np.max(share)
    if np.count_nonzero(whole) < 2:
        return np.zeros(len(coefficient))
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
    sums, products = (each.sum(axis=0) for each in sums_of(coverage, weights, values, order, 0.5))
    full, of_weights = (
        np.concatenate([np.conj(each[::-1]), each]) for each in (products, sums)
    )  # from -K - 1/2 and -2 K - 1/2
    return np.asarray((full - np.convolve(of_weights, solution, "valid"))[1:])


def _turns(coverage: AngleCoverage, weights: NDArray[np.float64]) -> Turns:
    """Return where the revolutions are, or the groups of them that `sums_of` has rows of."""
    group, rows = groups_of(coverage)
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
