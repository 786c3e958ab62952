"""Gauge studies against a published one, against least squares, and by simulation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray
from scipy.special import chdtri

from benchtool.errors import AnalysisError
from benchtool.gauge import GaugeStudy, Inferred, Readings, Source, study

# AIAG, Measurement Systems Analysis, 4th edition, figure III-B 15: three trials of ten parts by A, B and C
PUBLISHED = np.array(
    [
        [
            [0.29, -0.56, 1.34, 0.47, -0.80, 0.02, 0.59, -0.31, 2.26, -1.36],
            [0.41, -0.68, 1.17, 0.50, -0.92, -0.11, 0.75, -0.20, 1.99, -1.25],
            [0.64, -0.58, 1.27, 0.64, -0.84, -0.21, 0.66, -0.17, 2.01, -1.31],
        ],
        [
            [0.08, -0.47, 1.19, 0.01, -0.56, -0.20, 0.47, -0.63, 1.80, -1.68],
            [0.25, -1.22, 0.94, 1.03, -1.20, 0.22, 0.55, 0.08, 2.12, -1.62],
            [0.07, -0.68, 1.34, 0.20, -1.28, 0.06, 0.83, -0.34, 2.19, -1.50],
        ],
        [
            [0.04, -1.38, 0.88, 0.14, -1.46, -0.29, 0.02, -0.46, 1.77, -1.49],
            [-0.11, -1.13, 1.09, 0.20, -1.07, -0.67, 0.01, -0.56, 1.45, -1.77],
            [-0.15, -0.96, 0.67, 0.11, -1.45, -0.49, 0.21, -0.49, 1.87, -2.16],
        ],
    ]
).transpose(2, 0, 1)[:, :, np.newaxis, :]


def readings(values: NDArray[np.float64]) -> Readings:
    parts, operators = (tuple(str(number) for number in range(count)) for count in values.shape[:2])
    return Readings("length", values, parts, operators)


def drawn(
    generator: np.random.Generator, shape: tuple[int, int, int, int], deviations: dict[Source, float]
) -> NDArray[np.float64]:
    """Readings of random effects with these standard deviations."""
    shapes = {
        Source.PART: (shape[0], 1, 1, 1),
        Source.OPERATOR: (1, shape[1], 1, 1),
        Source.INTERACTION: (*shape[:2], 1, 1),
        Source.MOUNTING: (*shape[:3], 1),
        Source.REPETITION: shape,
    }
    effects = (deviation * generator.standard_normal(shapes[each]) for each, deviation in deviations.items())
    return np.asarray(sum(effects, np.zeros(shape)))


def test_the_published_study() -> None:
    result = study(readings(PUBLISHED))
    assert result.repeatability == pytest.approx(0.199933, abs=1e-6)  # table III-B 9 of the source
    assert result.reproducibility == pytest.approx(0.226838, abs=1e-6)
    assert result.gauge == pytest.approx(0.302373, abs=2e-6)
    assert result.part == pytest.approx(1.042327, abs=1e-6)
    assert result.percent_of_total is not None
    assert result.percent_of_total.estimate == pytest.approx(27.86, abs=5e-3)
    assert result.percent_of_total.interval == pytest.approx((15.3, 81.3), abs=0.1)  # of three operators
    assert result.percent_of_total.probability_below(30.0) == pytest.approx(0.475, abs=5e-3)
    assert (result.ndc, result.ndc_interval) == (4, (1, 9))
    interaction = result.components[2]
    assert (interaction.source, interaction.dof, interaction.variance) == (Source.INTERACTION, 18, None)
    assert interaction.p == pytest.approx(0.974106404329045, rel=1e-9)  # statsmodels 0.14, anova_lm, type 2


def test_an_interaction_that_is_kept() -> None:
    result = study(readings(PUBLISHED), pooled_above=1.0)
    part, operator, interaction, repetition = result.components
    assert pytest.approx(0.433721030135108, rel=1e-9) == interaction.F  # statsmodels 0.14
    assert repetition.sum_of_squares == pytest.approx(2.75893333333333, rel=1e-9)
    assert interaction.variance == 0.0  # its estimate is negative
    assert pytest.approx(9.817992716 / 0.01994345679, rel=1e-9) == part.F
    assert operator.F is not None
    assert math.isclose(operator.F, 1.583631111 / 0.01994345679, rel_tol=1e-9)


def _left(y: NDArray[np.float64], columns: list[NDArray[np.float64]]) -> tuple[float, int]:
    """Return what least squares leave of the readings, and the rank of the columns."""
    matrix = np.hstack([np.ones((y.size, 1)), *columns])
    rest = y - matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0]
    return float(rest @ rest), int(np.linalg.matrix_rank(matrix))


@pytest.mark.parametrize("shape", [(4, 3, 2, 3), (5, 2, 1, 2), (1, 3, 2, 2), (3, 1, 2, 2)])
def test_sums_of_squares_are_what_least_squares_find(shape: tuple[int, int, int, int]) -> None:
    values = drawn(np.random.default_rng(5), shape, dict.fromkeys(Source, 1.0))
    y = values.ravel()
    labels = np.array(list(itertools.product(*(range(count) for count in shape))))

    def dummies(*factors: int) -> NDArray[np.float64]:
        _, codes = np.unique(labels[:, list(factors)], axis=0, return_inverse=True)
        return np.eye(codes.max() + 1)[codes.ravel()]

    models = [[], [dummies(0)], [dummies(0), dummies(1)], [dummies(0, 1)], [dummies(0, 1, 2)]]
    left = [_left(y, model) for model in models] + [(0.0, y.size)]
    expected = {
        source: (before[0] - after[0], after[1] - before[1])
        for source, before, after in zip(Source, left, left[1:], strict=False)
        if after[1] > before[1]
    }
    lines = {each.source: each for each in study(readings(values), pooled_above=1.0).components}
    assert set(lines) == set(expected)
    for source, (sum_of_squares, dof) in expected.items():
        assert lines[source].dof == dof
        assert lines[source].sum_of_squares == pytest.approx(sum_of_squares, rel=1e-9)


@pytest.mark.parametrize(
    ("shape", "deviations"),
    [
        ((10, 3, 1, 3), (1.0, 0.2, 0.1, 0.0, 0.2)),
        ((5, 3, 3, 3), (1.0, 0.1, 0.05, 0.2, 0.1)),
        ((1, 1, 8, 5), (0.0, 0.0, 0.0, 0.2, 0.1)),
    ],
)
def test_the_interval_holds_the_truth_as_often_as_it_says(
    shape: tuple[int, int, int, int], deviations: tuple[float, ...]
) -> None:
    generator = np.random.default_rng(7)
    by_source = dict(zip(Source, deviations, strict=True))
    truth = math.sqrt(sum(deviation**2 for deviation in deviations[1:]))
    of_total = 100.0 * truth / math.hypot(truth, deviations[0])
    found = [study(readings(drawn(generator, shape, by_source))) for _ in range(500)]
    gauges = [Inferred(each.gauge, each.gauge_draws) for each in found]
    low, high = gauges[0].interval
    assert [gauges[0].probability_below(each) for each in (low, high)] == pytest.approx(
        [0.025, 0.975], abs=1e-4
    )
    assert 0.92 <= np.mean([0.025 <= each.probability_below(truth) <= 0.975 for each in gauges]) <= 0.98
    shares = [each.percent_of_total for each in found if each.percent_of_total is not None]
    assert len(shares) == (0 if shape[0] == 1 else len(found))
    held = [0.025 <= each.probability_below(of_total) <= 0.975 for each in shares]
    assert not held or 0.92 <= np.mean(held) <= 0.99
    assert np.mean([each.gauge**2 for each in found]) == pytest.approx(truth**2, rel=0.1)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    scale=st.floats(1e-6, 1e6),
    offset=st.floats(-1e3, 1e3),
    sign=st.sampled_from([1, -1]),
)
def test_percentages_do_not_depend_on_the_unit(seed: int, scale: float, offset: float, sign: int) -> None:
    values = drawn(np.random.default_rng(seed), (4, 2, 2, 2), dict.fromkeys(Source, 1.0))
    as_read, converted = study(readings(values)), study(readings(scale * (sign * values + offset)))
    here, there = as_read.percent_of_total, converted.percent_of_total
    assert here is not None
    assert there is not None
    assert there.estimate == pytest.approx(here.estimate, rel=1e-6, abs=1e-6)
    assert there.interval == pytest.approx(here.interval, rel=1e-6, abs=1e-6)
    assert converted.gauge == pytest.approx(scale * as_read.gauge, rel=1e-6)


def test_one_part_has_no_variation_of_parts() -> None:
    values = drawn(np.random.default_rng(3), (1, 2, 3, 4), dict.fromkeys(Source, 1.0))
    result: GaugeStudy = study(readings(values), tolerance=12.0)
    assert result.part is None
    assert result.percent_of_total is None
    assert result.ndc is None
    assert result.percent_of_tolerance is not None
    assert result.percent_of_tolerance.estimate == pytest.approx(50.0 * result.gauge)
    assert {each.source for each in result.components} == {
        Source.OPERATOR,
        Source.MOUNTING,
        Source.REPETITION,
    }


def test_readings_that_are_all_the_same_have_no_ratio() -> None:
    result = study(readings(np.full((2, 2, 1, 2), 0.1)))
    assert result.gauge == 0.0
    assert result.percent_of_total is None
    assert result.ndc is None
    assert all(each.F is None for each in result.components)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf])
def test_a_tolerance_is_a_width(tolerance: float) -> None:
    with pytest.raises(AnalysisError, match="number above 0"):
        study(readings(PUBLISHED), tolerance)


def test_draws_have_the_quantiles_of_chi_squared() -> None:
    """Of one source that is all there is the interval is that of a variance, s sqrt(n / chi-squared)."""
    values = drawn(np.random.default_rng(3), (1, 1, 1, 12), dict.fromkeys(Source, 1.0))
    result = study(readings(values))
    edges = [result.gauge * math.sqrt(11.0 / chdtri(11, tail)) for tail in (0.025, 0.975)]
    assert result.gauge_interval == pytest.approx(edges, rel=1e-3)
