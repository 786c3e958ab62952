"""Analysis of variance of a gauge study: parts, operators, mountings of a part, repetitions.

The factors are random and the design is balanced: every operator mounts every part as often, and reads each
mounting as often. Parts and operators are crossed, mountings are nested in a part and operator:

    y = mu + part + operator + (part x operator) + mounting + error

Variance components come from the expected mean squares. Reference: AIAG, Measurement Systems Analysis, 4th
edition, chapter III, section B (ANOVA method), extended by the mountings; Montgomery, Design and Analysis of
Experiments, 8th edition, section 14 (nested factors).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from benchtool.errors import AnalysisError
from benchtool.gauge.inference import Draws, Inferred, expected_mean_square
from benchtool.gauge.readings import Readings

POOLED_ABOVE = 0.25
"""Probability above which an interaction of parts and operators counts as error (AIAG's rule)."""

_NDC = 1.41  # AIAG: sqrt(2) rounded, for 97 % confidence intervals that do not overlap
_OF_TOLERANCE = 6.0  # standard deviations that a tolerance is compared with
_EVEN = 1e-12  # of the readings' square: below that a sum of squares is rounding


class Source(StrEnum):
    """Where a spread of the readings comes from."""

    PART = "part"
    OPERATOR = "operator"
    INTERACTION = "part x operator"
    MOUNTING = "mounting"
    REPETITION = "repetition"


@dataclass(frozen=True)
class Component:
    """A line of the analysis of variance, and the variance component behind it.

    `F` and `p` are None where nothing is there to test against. `variance` is in the square of the readings'
    unit and 0 where its estimate is negative; None of an interaction that was pooled with the error.
    """

    source: Source
    dof: int
    sum_of_squares: float
    F: float | None
    p: float | None
    variance: float | None

    @property
    def mean_square(self) -> float:
        """Sum of squares over degrees of freedom."""
        return self.sum_of_squares / self.dof


@dataclass(frozen=True)
class GaugeStudy:
    """Result of a study, in the unit of the readings; standard deviations, not multiples of them.

    `repeatability` is the spread of repetitions, `reproducibility` that of operators and of their interaction
    with parts, `mounting` that of mounting a part again; the gauge's own is the root of the sum of squares,
    `gauge`. `part` is None where one part only was measured, `mounting` where mountings were not told apart.
    `gauge_draws` and `total_draws` are what the gauge's deviation and the total one may be.
    """

    components: tuple[Component, ...]
    repeatability: float
    reproducibility: float
    mounting: float | None
    part: float | None
    gauge: float
    tolerance: float | None
    gauge_draws: Draws = field(repr=False, compare=False)
    total_draws: Draws = field(repr=False, compare=False)

    @property
    def gauge_interval(self) -> tuple[float, float] | None:
        """Where the gauge's standard deviation lies with 95 %; None where repetitions are alike, which tells
        nothing of it."""
        return Inferred(self.gauge, self.gauge_draws).interval if self.gauge else None

    @property
    def total(self) -> float:
        """Standard deviation of a reading of any part by any operator."""
        return math.hypot(self.gauge, self.part or 0.0)

    @property
    def percent_of_total(self) -> Inferred | None:
        """%GRR: the gauge's part of the total variation; None of one part, or where repetitions are alike."""
        if self.part is None or self.gauge == 0.0:
            return None
        return Inferred(100.0 * self.gauge / self.total, 100.0 * self.gauge_draws / self.total_draws)

    @property
    def percent_of_tolerance(self) -> Inferred | None:
        """Six standard deviations of the gauge in percent of the tolerance; None without one, or where
        repetitions are alike."""
        if self.tolerance is None or self.gauge == 0.0:
            return None
        share = 100.0 * _OF_TOLERANCE / self.tolerance
        return Inferred(share * self.gauge, share * self.gauge_draws)

    @property
    def ndc(self) -> int | None:
        """Number of distinct categories that the gauge tells apart; None of one part or an exact gauge."""
        if self.part is None or self.gauge == 0.0:
            return None
        return int(_NDC * self.part / self.gauge)

    @property
    def ndc_interval(self) -> tuple[int, int] | None:
        """Where that number lies with 95 %, by the interval of %GRR; None without it."""
        share = self.percent_of_total
        if self.ndc is None or share is None:
            return None
        least, most = (math.sqrt(max(0.0, (100.0 / each) ** 2 - 1.0)) for each in reversed(share.interval))
        return int(_NDC * least), int(_NDC * most)


def study(
    readings: Readings, tolerance: float | None = None, pooled_above: float = POOLED_ABOVE
) -> GaugeStudy:
    """Analyse a balanced set of readings.

    Args:
        readings: at least two repetitions of each mounting.
        tolerance: width of the tolerance that the readings are judged by, in their unit.
        pooled_above: an interaction with a larger probability of being chance is pooled with the error;
            1 keeps it always.

    Raises:
        AnalysisError: the tolerance is not a finite number above 0.
    """
    if tolerance is not None and not (math.isfinite(tolerance) and tolerance > 0.0):
        raise AnalysisError(f"a tolerance of {tolerance:g}: its width, a number above 0, is expected")
    y = readings.values
    parts, operators, mountings, repetitions = y.shape
    sums = _sums_of_squares(y)
    dofs = {
        Source.PART: parts - 1,
        Source.OPERATOR: operators - 1,
        Source.INTERACTION: (parts - 1) * (operators - 1),
        Source.MOUNTING: parts * operators * (mountings - 1),
        Source.REPETITION: parts * operators * mountings * (repetitions - 1),
    }
    squares = {source: (sums[source], dof) for source, dof in dofs.items() if dof > 0}
    interaction = _pooled(squares, pooled_above) if Source.INTERACTION in squares else None
    axes = {source: axis for axis, source in enumerate(Source)}
    expected = {source: expected_mean_square(*found, axes[source]) for source, found in squares.items()}
    components, weights = [], dict.fromkeys(squares, 0.0)
    part_draws = np.zeros(1)
    for source, (total, dof) in squares.items():
        below = _denominator(source, squares)
        mean = total / dof
        F = p = None
        times = 1.0
        variance = mean
        if below is not None:
            times = _readings_of_each(source, y.shape)
            denominator = squares[below][0] / squares[below][1]
            F = mean / denominator if denominator > 0.0 else None
            p = None if F is None else float(fdtrc(dof, squares[below][1], F))
            variance = max(0.0, (mean - denominator) / times)
            if source is Source.PART:
                part_draws = np.maximum(0.0, (expected[source] - expected[below]) / times)
        if source is not Source.PART:
            weights[source] += 1.0 / times
            if below is not None:
                weights[below] -= 1.0 / times
        components.append(Component(source, dof, total, F, p, variance))
    variances = {each.source: each.variance or 0.0 for each in components}
    reproducibility = variances.get(Source.OPERATOR, 0.0) + variances.get(Source.INTERACTION, 0.0)
    mounting = variances.get(Source.MOUNTING)
    gauge = variances[Source.REPETITION] + reproducibility + (mounting or 0.0)
    if interaction is not None:
        components.append(interaction)
    gauge_draws = np.sum([weights[source] * draws for source, draws in expected.items()], axis=0)
    return GaugeStudy(
        tuple(sorted(components, key=lambda each: list(Source).index(each.source))),
        math.sqrt(variances[Source.REPETITION]),
        math.sqrt(reproducibility),
        None if mounting is None else math.sqrt(mounting),
        math.sqrt(variances[Source.PART]) if Source.PART in variances else None,
        math.sqrt(gauge),
        tolerance,
        np.sqrt(gauge_draws),
        np.sqrt(gauge_draws + part_draws),
    )


def _sums_of_squares(y: NDArray[np.float64]) -> dict[Source, float]:
    """Return the sum of squares of each source of readings of shape (parts, operators, mountings,
    repetitions)."""
    y = y - y.mean()
    scale = float(np.square(y).sum())
    of_mounting = y.mean(axis=3, keepdims=True)
    of_cell = of_mounting.mean(axis=2, keepdims=True)
    of_part = of_cell.mean(axis=1, keepdims=True)
    of_operator = of_cell.mean(axis=0, keepdims=True)
    deviations = {
        Source.PART: of_part,
        Source.OPERATOR: of_operator,
        Source.INTERACTION: of_cell - of_part - of_operator,
        Source.MOUNTING: of_mounting - of_cell,
        Source.REPETITION: y - of_mounting,
    }
    found = {}
    for source, deviation in deviations.items():
        each = float(np.square(deviation).sum()) * y.size / deviation.size
        found[source] = each if each > _EVEN * scale else 0.0
    return found


def _pooled(squares: dict[Source, tuple[float, int]], above: float) -> Component | None:
    """Add an interaction that may be chance to the error that it is tested against; return its line then."""
    total, dof = squares[Source.INTERACTION]
    error = Source.MOUNTING if Source.MOUNTING in squares else Source.REPETITION
    of_error, dof_of_error = squares[error]
    if of_error == 0.0:
        return None
    F = (total / dof) / (of_error / dof_of_error)
    p = float(fdtrc(dof, dof_of_error, F))
    if p <= above:
        return None
    del squares[Source.INTERACTION]
    squares[error] = (of_error + total, dof_of_error + dof)
    return Component(Source.INTERACTION, dof, total, F, p, None)


def _denominator(source: Source, squares: Mapping[Source, object]) -> Source | None:
    """Return the source whose mean square is expected to be the same but for that source's own variance."""
    order = (Source.INTERACTION, Source.MOUNTING, Source.REPETITION)
    later = order[order.index(source) + 1 :] if source in order else order
    return next((each for each in later if each in squares), None)


def _readings_of_each(source: Source, shape: tuple[int, ...]) -> float:
    """Return how many readings share one draw of that source."""
    parts, operators, mountings, repetitions = shape
    return float(
        {
            Source.PART: operators * mountings * repetitions,
            Source.OPERATOR: parts * mountings * repetitions,
            Source.INTERACTION: mountings * repetitions,
            Source.MOUNTING: repetitions,
        }[source]
    )
