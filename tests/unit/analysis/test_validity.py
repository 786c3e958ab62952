"""What makes a record no record of its signal: values that stand still, and steps of an angle."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.resolution import (
    largest_even_step,
    resolution,
    step_of_counts,
    step_of_even_counts,
)
from benchtool.analysis.validity import clipping, require_signal, standing
from benchtool.errors import AnalysisError

SINE = np.cos(2.0 * np.pi * np.arange(20_000) / 500)


def held(samples: np.ndarray, rows: int) -> np.ndarray:
    """Return the samples with so many that repeat the one in row 7100, where the sine falls."""
    repeated = samples.copy()
    repeated[7100 : 7100 + rows] = repeated[7100]
    return repeated


@pytest.mark.parametrize("step", [0.0, 1e-3])
def test_values_that_stand_still_while_the_signal_goes_on_are_told(step: float) -> None:
    samples = np.round(SINE / step) * step if step else SINE
    assert standing(samples) == ""
    assert standing(held(samples, 60)).startswith("60 samples in a row from row 7100")


@pytest.mark.parametrize("step", [0.008, 0.03, 0.2])
def test_the_crest_of_a_wave_in_steps_does_not_stand_still(step: float) -> None:
    assert standing(np.round(SINE / step) * step) == ""


def test_a_signal_of_levels_does_not_stand_still() -> None:
    """Values that stay, as those of a slow sensor or of a logic level, are no fault of one place."""
    levels = np.repeat(np.random.default_rng(0).standard_normal(200), 100)
    assert standing(levels) == ""
    assert standing(np.ones(100)) == ""


def test_a_constant_that_a_computation_has_rounded_is_one() -> None:
    rounded = np.where(np.arange(1000) % 2, 0.1 + 0.2, 0.3)
    assert np.ptp(rounded) > 0.0
    with pytest.raises(AnalysisError, match=r"constant at 0.3 Nm"):
        require_signal(rounded, "torque", "Nm")
    require_signal(0.3 + 1e-12 * np.arange(1000.0), "torque", "Nm")


def test_an_angle_at_constant_speed_counts_in_no_steps() -> None:
    even = 0.01 * np.arange(5000.0)
    assert step_of_counts(even, resolution(even)) == 0.0
    counted = np.floor(even / 0.007) * 0.007
    assert step_of_counts(counted, resolution(counted)) == pytest.approx(0.007)


@pytest.mark.parametrize(("counts", "a_row"), [(4096, 14), (1000, 7), (2500, 3)])
def test_an_angle_that_turns_whole_counts_between_rows_counts_in_steps(counts: int, a_row: int) -> None:
    """The rest of its counts shows where a turn is no multiple of what it turns between rows."""
    step = 2 * np.pi / counts
    angle = 0.3 + a_row * step * np.arange(500.0)
    shared = np.gcd(counts, a_row)
    found = step_of_even_counts(angle)
    assert found == pytest.approx(shared * step if a_row > shared else 0.0)


def test_a_computed_angle_counts_in_no_steps() -> None:
    assert step_of_even_counts(0.3 + 0.0123456 * np.arange(5000.0)) == 0.0
    assert step_of_even_counts(2 * np.pi / 200 * np.arange(5000.0)) == 0.0  # back after 200 rows
    assert step_of_even_counts(np.cumsum(0.01 + 1e-6 * np.arange(500.0))) == 0.0


def test_what_an_angle_turns_between_all_samples_may_be_a_count_where_a_turn_is_a_multiple_of_it() -> None:
    assert largest_even_step(2 * np.pi / 360 * np.arange(430.0)) == pytest.approx(2 * np.pi / 360)
    assert largest_even_step(2 * np.pi / 4096 * 14 * np.arange(500.0)) == pytest.approx(2 * np.pi / 2048)
    assert largest_even_step(2 * np.pi / 360 * (7.0 + np.arange(430.0))) == pytest.approx(2 * np.pi / 360)
    assert largest_even_step(2 * np.pi / 360 * (7.5 + np.arange(430.0))) == pytest.approx(2 * np.pi / 360)
    assert largest_even_step(2 * np.pi / 360 * (7.31 + np.arange(430.0))) == 0.0
    assert largest_even_step(0.3 + 0.0123456 * np.arange(5000.0)) == 0.0
    assert largest_even_step(np.cumsum(0.01 + 1e-6 * np.arange(500.0))) == 0.0


@pytest.mark.parametrize("step", [0.0, 0.01])
@pytest.mark.parametrize("rows", [6.31234, 10.98765, 21.74321, 300.1])
def test_a_clipped_wave_is_told_with_few_rows_in_a_period_too(rows: float, step: float) -> None:
    """Of few rows in a period no three in a row are at the limit."""
    sine = np.cos(2.0 * np.pi * np.arange(1500) / rows)
    read = np.round(sine / step) * step if step else sine
    assert clipping(read) == ""
    assert "clipped" in clipping(np.minimum(read, 0.95))


@pytest.mark.parametrize("rows", [5, 8, 12, 20, 40])
@pytest.mark.parametrize("step", [0.0, 0.003, 0.02, 0.1])
def test_a_crest_that_all_periods_repeat_is_not_clipped(rows: int, step: float) -> None:
    """Rows at the same places of all periods have the same values, but for rounding."""
    at = 2.0 * np.pi * np.arange(60 * rows) / rows
    for begin in np.linspace(0.0, 0.5, 6):
        wave = np.cos(at + begin) + 0.07 * np.cos(5.0 * at) + 0.04 * np.cos(7.0 * at + 1.0)
        assert clipping(np.round(wave / step) * step if step else wave) == ""


def test_crests_in_steps_are_not_clipped() -> None:
    rng = np.random.default_rng(3)
    for _ in range(400):
        wave = np.cos(2.0 * np.pi * np.arange(1000) / rng.uniform(5.0, 200.0))
        wave += rng.choice([0.0, 1e-3, 1e-2]) * rng.standard_normal(1000)
        step = rng.uniform(0.005, 0.1)
        assert clipping(np.round(wave / step) * step) == ""


@pytest.mark.parametrize("speed", [0.0, 80.12])
@pytest.mark.parametrize("turned", [slice(None), slice(None, None, -1)])
def test_a_signal_that_rests_at_a_count_before_or_after_it_moves_is_not_clipped(
    speed: float, turned: slice
) -> None:
    """A speed by counts goes back and forth between two of them, or is zero; it reaches a limit later."""
    answer = 100.0 * (1.0 - np.exp(-np.maximum(np.arange(6_000) - 1_200.0, 0.0) / 300.0))
    answer += 5.0 * np.sin(0.02 * np.arange(6_000)) * (answer > 60.0)
    counts = np.diff(np.floor(np.cumsum(speed + answer)))[turned]
    assert np.mean(counts == np.min(counts)) > 0.1
    assert clipping(counts) == clipping(-counts) == ""
    assert "at the greatest value" in clipping(np.minimum(counts, np.floor(speed) + 101.0))


@pytest.mark.parametrize("digits", [3, 5, 15])
@pytest.mark.parametrize(
    ("first", "last"), [(0, 400), (1500, 1560), (1000, 2000), (1000, 1001 + 1500), (4000, 5000)]
)
def test_a_sensor_that_stops_is_told_however_long_and_wherever_it_goes_on(
    digits: int, first: int, last: int
) -> None:
    turned = np.arange(5000) / 199.7
    torque = (
        1.0 + 0.2 * np.cos(2 * np.pi * 6 * turned) + 1e-3 * np.random.default_rng(1).standard_normal(5000)
    )
    torque = np.round(torque, digits)
    assert not standing(torque)
    torque[first:last] = torque[first]
    assert f"{last - first} samples in a row from row {first} (from 0)" in standing(torque, "Nm")


@pytest.mark.parametrize("rest", [slice(0, 2000), slice(3800, 5000)])
def test_a_sensor_that_stops_is_told_beside_a_rest_at_zero(rest: slice) -> None:
    """The rest is longer, and hid that the sensor had stopped."""
    random = np.random.default_rng(1)
    torque = 1.0 + 0.2 * np.cos(np.arange(5000) / 5.3) + 1e-3 * random.standard_normal(5000)
    torque[rest] = 0.0
    assert standing(torque) == ""
    torque[2500:2800] = torque[2500]
    assert "300 samples in a row from row 2500 (from 0)" in standing(torque)


@pytest.mark.parametrize("seed", range(4))
def test_a_current_that_a_converter_leaves_alone_again_and_again_does_not_stand_still(seed: int) -> None:
    """Of 14 samples at rest, as ten other rests before a jump were, a sensor was said to stand still."""
    random = np.random.default_rng(seed)
    steps: list[int] = []
    for rest in random.geometric(0.2, 300):
        steps += [*random.choice((-1, 1), 20), *([0] * int(rest)), int(random.choice((-9, 9)))]
    current = 0.0244 * (np.cumsum(steps) + 100.3)
    assert standing(current) == ""
    current[3000:3200] = current[3000]
    current[3200:] += current[3000] + 1.0 - current[3200]
    assert int(standing(current).partition(" samples in a row ")[0]) >= 200
