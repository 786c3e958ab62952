"""Places at which a curve passes a level: between samples, before the first, and for the last time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.steps.passages import (
    Crossing,
    Instant,
    first_passage,
    first_passages,
    last_passage,
    last_passages,
    places_of,
)


def passed(above: list[float]) -> Crossing:
    found = first_passage(np.array(above), np.zeros(len(above)))
    assert found is not None
    return found


@pytest.mark.parametrize("ahead", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("factor", [0.3, 0.9, 1.0, 1.2])
def test_a_level_that_the_first_sample_is_beyond_was_passed_where_an_exponential_leads(
    ahead: float, factor: float
) -> None:
    rows = ahead + np.arange(3.0)
    above = rows if factor == 1.0 else (factor**rows - 1.0) / (factor - 1.0)
    found = passed(above.tolist())
    assert abs(found.place + ahead) <= found.reach + 1e-12
    assert found.reach == pytest.approx(min(abs(above[0] / (above[1] - above[0]) - ahead), 0.5), abs=0.2)


@pytest.mark.parametrize("ahead", [0.1, 0.5, 0.9])
def test_before_a_change_that_nothing_follows_it_was_passed_since_the_line_through_it(ahead: float) -> None:
    found = passed([ahead, ahead + 1.0, ahead + 1.0])
    assert found.place - found.reach == pytest.approx(-ahead)
    assert found.place + found.reach == pytest.approx(0.0)


@pytest.mark.parametrize("above", [[0.5], [0.5, 0.4, 0.3], [3.0, 4.0, 5.0]])
def test_without_a_slope_that_leads_there_it_was_anywhere_since_the_one_before(above: list[float]) -> None:
    assert passed(above) == Crossing(-0.5, 0.5)


def test_a_curve_that_stays_below_passes_nothing() -> None:
    assert first_passage(np.array([-2.0, -1.0, -0.5]), np.zeros(3)) is None


def test_samples_below_a_level_put_it_off_until_the_curve_is_surely_beyond() -> None:
    above = np.array([-2.0, -1.0, 0.1, -0.1, 0.1, 2.0, 3.0])
    assert 1.0 < passed(above.tolist()).place < 2.0
    late = first_passage(above, np.full(7, 0.5))
    assert late is not None
    assert late.place == pytest.approx(passed(above.tolist()).place + 1.0)


def test_samples_below_a_level_put_it_off_until_the_curve_stays_though_nothing_is_surely_beyond() -> None:
    flickers, sure = [0.9, -1.1, -1.1, 0.9, -1.1, 0.9, 0.9], np.full(20, 1.2)
    late = first_passage(np.array([-1.1] * 3 + flickers + [0.9] * 10), sure)
    assert late is not None
    assert late.place == pytest.approx(passed([-1.1] * 3 + [0.9] * 17).place + 3.0)
    too_short = first_passage(np.array([-1.1] * 3 + flickers), sure[:10])
    assert too_short is not None
    assert too_short.place < 3.0


@pytest.mark.parametrize("begin", [0.0, 0.25, 0.5, 0.75])
def test_a_smooth_curve_passes_within_the_reach(begin: float) -> None:
    place = 5.0 + begin
    found = passed(np.sin(0.2 * (np.arange(12) - place)).tolist())
    assert abs(found.place - place) <= found.reach
    assert found.reach < 1e-3


def test_a_jump_is_anywhere_between_its_two_samples() -> None:
    assert passed([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]) == Crossing(2.5, 0.5)


def test_the_last_passage_is_where_a_lobe_between_samples_ends() -> None:
    """A crest between two samples that are both inside leaves the band by itself."""
    values = 1.02 - 0.05 * (np.arange(12.0) - 6.5) ** 2
    values[:5] = 3.0
    found = last_passage(values, 0.5, 0.51)
    assert found is not None
    assert found.place == pytest.approx(6.5 + np.sqrt(0.01 / 0.05))


def test_values_that_are_never_outside_are_inside_from_the_first_on_and_others_never() -> None:
    assert last_passage(np.ones(8), 1.0, 0.1) == Crossing(0.0, 0.0)
    assert last_passage(np.arange(8.0), 1.0, 0.1) is None


@pytest.mark.parametrize("rows", [3, 5, 60, 40_000])
def test_each_of_many_curves_passes_where_it_does_alone(rows: int) -> None:
    """Also of those that are never there, or from the first row on, and more than are looked at at once."""
    random = np.random.default_rng(8)
    scale = random.choice([0.3, 1.0, 3.0], (7, 1))
    row = np.arange(float(rows))
    values = scale * np.exp(-3.0 * row / rows) * np.cos(20.0 * row / rows) + random.normal(0, 0.02, (7, rows))
    sure = np.full(rows, 0.05)
    first, last = first_passages(0.5 - values, sure), last_passages(values, 0.0, 0.2)
    assert first == [first_passage(0.5 - each, sure) for each in values]
    assert last == [last_passage(each, 0.0, 0.2) for each in values]
    expected = [math.nan if each is None else each.place for each in last]
    np.testing.assert_array_equal(places_of(last), expected)
    assert first_passages(values[:0], sure) == []
    assert last_passages(values[:0], 0.0, 0.2) == []


@pytest.mark.parametrize("period", [16.0, 26.0])
def test_a_passage_of_a_mode_is_as_uncertain_as_the_cubic_is_off(period: float) -> None:
    missed = []
    for phase in np.linspace(0.02, 0.98, 33):
        since = np.arange(2.0 * period) + phase
        values = 1.0 - np.exp(-since / (0.5 * period)) * np.cos(2.0 * np.pi * since / period)
        fine = np.linspace(0.1 * period, 0.3 * period, 200_001)
        way = 1.0 - np.exp(-fine / (0.5 * period)) * np.cos(2.0 * np.pi * fine / period)
        found = first_passage(values - 0.98, np.zeros(len(values)))
        assert found is not None
        truth = float(np.interp(0.98, way, fine)) - phase
        missed.append((found.place - truth) / found.reach * np.sqrt(3.0))
    assert 0.65 < np.sqrt(np.mean(np.square(missed))) < 1.4


def test_draws_far_apart_are_about_a_place_by_those_that_are_near_it() -> None:
    """A lobe that may leave the band once more: the place is before it in a third of the draws."""
    before, after = np.linspace(226.0, 229.0, 27), np.linspace(268.0, 285.0, 53)
    drawn = (*after.tolist(), math.nan, *before.tolist())

    assert Instant(227.0, 1.0, drawn).of_drawn == pytest.approx(227.5)
    assert Instant(275.0, 1.0, drawn).of_drawn == pytest.approx(276.5)
    alone = tuple(np.random.default_rng(1).normal(100.0, 3.0, 80).tolist())
    assert Instant(95.0, 1.0, alone).of_drawn == pytest.approx(np.median(alone))
    assert math.isnan(Instant(5.0, 1.0).of_drawn)
