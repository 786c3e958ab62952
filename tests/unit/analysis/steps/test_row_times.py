"""Rows of a transient at other times than they should be, and samples that are held for several rows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, analyze_step
from benchtool.analysis.steps.row_times import Repeats, even_hold, scatter_of_times
from benchtool.analysis.steps.smoothing import Noise
from benchtool.block import Block

Floats = NDArray[np.float64]
Course = Callable[[Floats], Floats]

ROWS, BEFORE, TAU, DEAD = 900, 150, 15.0, 3.3
SILENT = Noise(np.zeros(1))


def _lag(row: Floats) -> Floats:
    return np.asarray(1.0 - np.exp(-np.maximum(row - DEAD, 0.0) / TAU))


def _ringing(row: Floats) -> Floats:
    late = np.maximum(row - DEAD, 0.0)
    return np.asarray(1.0 - np.exp(-late / TAU) * np.cos(late / 5.0))


def _measured(y: Floats) -> dict[str, Measurement]:
    r = (np.arange(len(y)) >= BEFORE).astype(np.float64)
    block = Block.from_arrays(1e4, {"y": "Nm", "r": "Nm"}, y=y, r=r)
    return {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}


@pytest.mark.parametrize("course", [_lag, _ringing])
def test_the_scatter_of_times_is_found_on_slopes(course: Course) -> None:
    random = np.random.default_rng(1)
    row = np.arange(float(ROWS))
    found = [
        scatter_of_times(course(row + 0.2 * random.standard_normal(ROWS)), SILENT, 0.0) for _ in range(12)
    ]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.2, rel=0.3)


@pytest.mark.parametrize("course", [_lag, _ringing])
@pytest.mark.parametrize("rms", [0.0, 0.003, 0.03])
def test_rows_in_time_have_none_whatever_their_noise(course: Course, rms: float) -> None:
    random = np.random.default_rng(2)
    noise = Noise(np.array([rms**2]))
    y = course(np.arange(float(ROWS))) + rms * random.standard_normal((12, ROWS))
    assert np.median([scatter_of_times(each, noise, 0.0) for each in y]) < 0.01


def test_corners_and_jumps_are_no_scatter() -> None:
    row = np.arange(float(ROWS))
    corner = np.minimum(row / 60.0, 1.0)
    jumps = np.select([row < 100, row < 400, row < 402], [0.0, 1.0, 1.3], 0.2)
    assert scatter_of_times(corner, SILENT, 0.0) < 1e-6
    assert scatter_of_times(jumps, SILENT, 0.0) == 0.0


def test_times_of_rows_that_scatter_are_in_every_instant() -> None:
    random = np.random.default_rng(3)
    true_s = 1e-4 * (DEAD + TAU * np.log(50.0))
    relative = []
    for _ in range(14):
        row = np.arange(ROWS) - BEFORE + random.uniform(-0.4, 0.4, ROWS)
        reach = _measured(_lag(row))["reach_time"]
        assert reach.uncertainty is not None
        relative.append((reach.value - true_s) / reach.uncertainty.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(relative))) < 1.6


def test_a_sample_of_several_rows_is_found_in_noise_and_without() -> None:
    random = np.random.default_rng(4)
    row = np.arange(float(ROWS)) - BEFORE
    for rms in (0.0, 0.01):
        fresh = _lag(row) + rms * random.standard_normal(ROWS)
        held = fresh[np.maximum(np.arange(ROWS) - 2, 0) // 5 * 5 + 2]
        assert even_hold(held) == (5, 2)
        assert even_hold(fresh) == (1, 0)
    assert even_hold(np.round(_lag(row), 2))[0] == 1


def test_numbers_of_a_held_signal_are_those_of_its_samples() -> None:
    fresh = _lag(np.arange(float(4 * ROWS)) - BEFORE)
    found = _measured(fresh[np.arange(4 * ROWS) // 4 * 4])
    for name, rows in (("rise_time", TAU * np.log(9.0)), ("reach_time", DEAD + TAU * np.log(50.0))):
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        assert abs(found[name].value - 1e-4 * rows) < 2.0 * uncertainty.standard
        assert uncertainty.standard < 1e-4
    assert "held for 4 rows" in str(found["rise_time"].basis)


def test_the_rows_in_which_a_ringing_sets_in_are_no_scatter() -> None:
    since = np.maximum(np.arange(300.0) - 1.4, 0.0)
    y = 1.0 - np.exp(-since / 4.1) * np.cos(2.0 * np.pi * since / 6.7)
    noise = Noise(np.array([1e-6]))
    found = [
        scatter_of_times(y + 1e-3 * np.random.default_rng(seed).standard_normal(300), noise, 0.0)
        for seed in range(10)
    ]
    assert np.count_nonzero(found) <= 1


@pytest.mark.parametrize("share", [0.05, 0.1])
def test_rows_that_repeat_the_one_before_are_a_row_late(share: float) -> None:
    """Each of them by one row: the mean square of the times is the share of such rows on the way."""
    random, way = np.random.default_rng(3), 1.0 - np.exp(-np.arange(2000.0) / 60.0)
    stale = np.flatnonzero(random.random(len(way)) < share)[1:]
    late = way.copy()
    late[stale] = way[stale - 1]
    assert scatter_of_times(late, SILENT, 0.0) == pytest.approx(share**0.5, rel=0.35)
    assert scatter_of_times(way, SILENT, 0.0) == pytest.approx(0.0, abs=1e-6)


def _stale(y: Floats, share: float, random: np.random.Generator) -> Floats:
    rows = np.arange(len(y))
    new = np.where(random.random(len(y)) < share, 0, rows)
    return np.asarray(y[np.maximum.accumulate(new)])


@pytest.mark.parametrize(("rms", "step"), [(0.0, 0.0), (2e-3, 0.0), (0.0, 1e-3), (1e-4, 1e-3)])
def test_rows_that_repeat_the_one_before_are_seen_in_noise_and_on_levels(rms: float, step: float) -> None:
    random, share = np.random.default_rng(5), 0.15
    y = _ringing(np.arange(0.0, 30 * TAU) / 10.0) + rms * random.standard_normal(450)
    y = np.round(y / step) * step if step else y
    noise = Noise(np.array([rms**2]))
    late_rows = share * (1.0 + share) / (1.0 - share) ** 2
    assert scatter_of_times(_stale(y, share, random), noise, step) == pytest.approx(late_rows**0.5, rel=0.4)
    assert scatter_of_times(y, noise, step) < 0.05


@pytest.mark.parametrize(("rms", "step"), [(0.0, 0.0), (1e-3, 0.0), (0.0, 1e-3)])
def test_rows_that_repeat_the_one_before_are_on_the_course_of_the_others(rms: float, step: float) -> None:
    random = np.random.default_rng(8)
    course = _ringing(np.arange(400.0) - 20.7) + rms * random.standard_normal(400)
    y = np.round(course / step) * step if step else course
    stale = _stale(y, 0.04, random)
    found = Repeats.among(stale, SILENT, step)
    is_mended = found.without != stale
    assert found.count >= max(1, int(np.count_nonzero(is_mended)))
    assert np.array_equal(found.doubt > 0.0, is_mended) or step
    apart = np.abs(found.without - y)[is_mended]
    assert np.all(apart <= 10.0 * found.doubt[is_mended] + 4.0 * rms + 1.01 * step)
    assert np.mean(apart) < 0.4 * np.mean(np.abs(stale - y)[is_mended]) + rms
    assert Repeats.among(y, SILENT, step).count == 0


def test_rows_that_often_repeat_the_one_before_stay() -> None:
    y = _stale(_ringing(np.arange(400.0) - 20.7), 0.3, np.random.default_rng(8))
    assert np.array_equal(Repeats.among(y, SILENT, 0.0).without, y)


def test_times_are_those_of_the_rows_that_are_new() -> None:
    """They are known to a thousandth of a row where none near them repeats, and to what a row bends there."""
    true_rows = DEAD + TAU * np.log(50.0)
    for seed in range(3):
        y = _stale(
            _lag(np.arange(-BEFORE, ROWS - BEFORE, dtype=np.float64)), 0.05, np.random.default_rng(seed)
        )
        reach = _measured(y)["reach_time"]
        assert reach.uncertainty is not None
        assert reach.uncertainty.standard < 2e-3 / 1e4
        assert abs(reach.value * 1e4 - true_rows) < 2e-3
        assert "that repeat the one before" in reach.definition


def test_rows_that_noise_and_the_steps_of_a_converter_make_equal_do_not_repeat() -> None:
    random, step, rms = np.random.default_rng(2), 1e-2, 2.5e-2
    y = step * np.round((_lag(np.arange(400.0) - 20.7) + rms * random.standard_normal(400)) / step)
    assert Repeats.among(y, Noise(np.array([rms**2])), step).count == 0
    assert Repeats.among(y, SILENT, step).count > 0
