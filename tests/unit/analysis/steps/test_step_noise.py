"""Step responses whose noise is unknown, heavy, or the reference's, and peaks that are alike or weak."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import special

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.departure import departure
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step import analyze_step
from benchtool.analysis.steps.step_shape import find_step
from benchtool.block import Block
from tests.at_length import at_length

RATE_HZ = 10_000.0


def _block(y: NDArray[np.float64], r: NDArray[np.float64]) -> Block:
    return Block.from_arrays(
        RATE_HZ, {"torque": "Nm", "torque_reference": "Nm"}, torque=y, torque_reference=r
    )


def _step(before: float, after: float, rows: int = 1000, at: int = 100) -> NDArray[np.float64]:
    return np.where(np.arange(rows) < at, before, after)


def _noisy(height: float, rms: float, seed: int = 0, rows: int = 5000) -> tuple[NDArray[np.float64], ...]:
    """A lag of 1 ms after 5 rows of delay, with noise, and its reference."""
    since_s = np.maximum(0.0, np.arange(rows) - 105) / RATE_HZ
    y = height * (1.0 - np.exp(-since_s / 1e-3))
    return y + rms * np.random.default_rng(seed).standard_normal(rows), _step(0.0, height, rows)


def _one(y: NDArray[np.float64], r: NDArray[np.float64], name: str) -> Measurement:
    response = analyze_step(_block(y, r), "torque", "torque_reference")
    (found,) = (each for each in response.measurements if each.name == name)
    return found


def _errors(y: NDArray[np.float64], r: NDArray[np.float64], name: str, truth: float) -> tuple[float, float]:
    found = _one(y, r, name)
    assert found.uncertainty is not None
    return found.value - truth, found.uncertainty.standard


def test_every_uncertainty_is_the_root_sum_square_of_a_budget_of_both_types() -> None:
    y, r = _noisy(1.0, 0.01, rows=1500)
    response = analyze_step(_block(y, r), "torque", "torque_reference")
    types = {}
    for name, entry in response.to_json().items():
        uncertainty = entry.get("uncertainty")
        if uncertainty is None:
            continue
        lines = uncertainty["budget"]
        assert math.hypot(*(line["standard"] for line in lines)) == pytest.approx(uncertainty["standard"])
        types[name] = {line["evaluation"] for line in lines}
    for name in ("step_latency", "reach_time", "settling_time"):
        assert types[name] == {"A", "B"}, name  # noise, and where between two rows step and passage are
    assert len(types) >= 10


def test_too_few_samples_at_rest_show_no_noise_and_give_no_numbers() -> None:
    y, r = _noisy(1.0, 0.01, rows=200)
    for name in ("settling_time", "undershoot", "plateau_mean"):
        found = _one(y[94:160], r[94:160], name)
        assert math.isnan(found.value)
        assert "its noise is not known from 6 rows before the step and the last 7 after it" in found.reason
    assert not math.isnan(_one(y[90:160], r[90:160], "undershoot").value)


def test_interference_in_many_samples_gives_no_numbers() -> None:
    y, r = _noisy(1.0, 0.005, rows=2000)
    hit = np.random.default_rng(2).random(len(y)) < 0.05
    found = _one(y + 0.3 * hit, r, "settling_time")
    assert math.isnan(found.value)
    assert "far from their neighbours, too many to be left out" in found.reason


def test_a_noisy_reference_has_the_levels_that_its_noise_is_about() -> None:
    y, r = _noisy(1.0, 0.005, rows=1500)
    errors = []
    for seed in range(8):
        noise = 0.01 * np.random.default_rng(seed).standard_normal(len(r))
        step = find_step(_block(y, r + noise), "torque", "torque_reference")
        errors.append((step.greatest - 1.0) / step.greatest_error)
        assert abs(step.before) < 0.004
    # the greatest of the samples would be 0.03 too large
    assert np.sqrt(np.mean(np.square(errors))) < 2.0


def test_undershoot_is_after_the_one_or_the_other_of_two_peaks_alike() -> None:
    rows = np.arange(1500)
    peaks = 0.3 * np.exp(-(((rows - 200) / 12.0) ** 2)) + 0.305 * np.exp(-(((rows - 400) / 12.0) ** 2))
    dip = 0.2 * np.exp(-(((rows - 300) / 12.0) ** 2))
    r = _step(0.0, 1.0, len(rows))
    y = r + peaks - dip + 0.02 * np.random.default_rng(1).standard_normal(len(rows))
    error, standard = _errors(y, r, "undershoot", 0.2)
    assert abs(error) < 3.0 * standard
    assert standard > 0.05


@pytest.mark.slow
def test_a_weak_undershoot_is_not_taken_for_noise_of_a_plateau() -> None:
    rows, damping, omega = 1500, 0.5, 0.1
    since = np.maximum(0.0, np.arange(rows) - 200.0)
    damped = omega * math.sqrt(1.0 - damping**2)
    slope = damping * omega / damped
    decay = np.exp(-damping * omega * since)
    course = 1.0 - decay * (np.cos(damped * since) + slope * np.sin(damped * since))
    truth = math.exp(-2.0 * math.pi * slope)
    r = _step(0.0, 1.0, rows)
    found = []
    for seed in range(12):
        noise = 0.02 * np.random.default_rng(seed).standard_normal(rows)
        found.append(_errors(course + noise, r, "undershoot", truth))
    error, standard = np.array(found).T
    assert np.mean(error) > -0.35 * truth
    assert np.sqrt(np.mean((error / standard) ** 2)) < 1.4


def test_an_overshoot_that_is_not_there_is_the_less_uncertain_the_further_the_signal_is_below() -> None:
    standard = []
    for final in (1.0, 0.98):
        y, r = _noisy(1.0, 0.01)
        error, of_none = _errors(final * y, r, "overshoot", 0.0)
        assert error >= 0.0
        standard.append(of_none)
    assert standard[1] < 0.7 * standard[0]


def test_rounding_beyond_the_reference_has_no_peak_time() -> None:
    y, r = np.minimum(1.0, 0.01 * np.maximum(0.0, np.arange(1000) - 100.0)), _step(0.0, 1.0)
    y[500] = 1.0 + 4e-16
    assert math.isnan(_one(y, r, "peak_time").value)


def test_settling_of_a_pulse_says_that_its_fall_is_in_it() -> None:
    rows = np.arange(1000)
    r = np.select([rows < 100, rows < 600], [0.0, 1.0], 0.2)
    found = _one(r + 1e-3 * np.sin(rows), r, "settling_time")
    assert (
        "the reference leaves its greatest value 0.05 s after the step, which this includes"
        in found.definition
    )


def test_rare_spikes_are_in_the_noise_that_is_drawn() -> None:
    random = np.random.default_rng(3)
    spiked = random.standard_normal(1000) + 8.0 * (random.random(1000) < 0.01)
    drawn = Noise.of(spiked).draw(random, (50, 1000))
    assert np.mean((drawn / np.std(drawn)) ** 4) > 5.0
    normal = Noise.of(random.standard_normal(1000)).draw(random, (50, 1000))
    assert np.mean((normal / np.std(normal)) ** 4) == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize("pair", [(0.06, -0.06), *at_length(((-0.05, -0.03),), ((0.06, 0.0),))])
def test_outliers_long_after_the_answer_do_not_delay_settling(pair: tuple[float, float]) -> None:
    y, r = _noisy(1.0, 0.008, rows=2000)
    truth_s = 5.0 / RATE_HZ + 1e-3 * math.log(50.0)
    for row in (700, 1300):
        y[row : row + 2] += pair
        error, standard = _errors(y, r, "settling_time", truth_s)
        assert abs(error) < 3.0 * standard < 1e-3


@pytest.mark.slow
def test_extremes_and_the_rms_of_heavy_noise_are_as_uncertain_as_they_scatter() -> None:
    y, r = _noisy(1.0, 0.0, rows=1500)
    names = "plateau_max", "plateau_min", "tracking_error_max", "tracking_error_rms"
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    for seed in range(24):
        noise = 0.005 * np.random.default_rng(seed).standard_t(3, len(y))
        for each in analyze_step(_block(y + noise, r), "torque", "torque_reference").measurements:
            if each.name in found and each.uncertainty is not None:
                found[each.name].append((each.value, each.uncertainty.standard))
    for name, pairs in found.items():
        value, standard = np.array(pairs).T
        relative = (value - np.mean(value)) / standard
        assert 0.4 < float(np.sqrt(np.mean(relative**2))) < 1.8, name


def test_the_rms_of_a_tracking_error_is_without_the_noise_of_its_reference() -> None:
    y, r = _noisy(1.0, 0.005, rows=1500)
    errors = []
    for seed in range(8):
        noise = 0.015 * np.random.default_rng(seed).standard_normal(len(r))
        found = _one(y, r + noise, "tracking_error_rms")
        assert "of noise left in the reference" in found.definition
        assert found.uncertainty is not None
        errors.append((found.value - 0.005, found.uncertainty.standard))
    error, standard = np.array(errors).T
    assert abs(float(np.mean(error))) < 3e-4
    assert float(np.sqrt(np.mean((error / standard) ** 2))) < 1.5


def test_an_error_that_the_noise_of_a_reference_hides_has_no_rms() -> None:
    y, r = _noisy(1.0, 1e-4, rows=1500)
    noise = 0.03 * np.random.default_rng(3).standard_normal(len(r))
    found = _one(y, r + noise, "tracking_error_rms")
    assert math.isnan(found.value)
    assert "not told from the noise of the reference" in found.reason


def test_a_latency_is_none_before_its_step_and_less_uncertain_the_later_that_must_have_been() -> None:
    """The answer is ahead of the row of the step, by most of the row in which that may have been."""
    rows = np.arange(1000)
    found = []
    for ahead in (0.1, 0.9):
        y = 1.0 - np.exp(-np.maximum(rows - 100 + ahead, 0.0) / 10.0)
        found.append(_one(y, _step(0.0, 1.0), "step_latency"))
    late, early = (each.uncertainty for each in found)
    assert late is not None
    assert early is not None
    assert early.standard < 0.95 * late.standard
    assert 0.0 < found[1].value < found[0].value


def test_a_signal_that_stays_and_jumps_has_no_interference() -> None:
    """Torque that is computed of converted currents: levels of irregular height, each for some rows."""
    random = np.random.default_rng(6)
    y, r = _noisy(1.0, 0.0, rows=3000)
    levels = np.repeat(0.01 * random.standard_normal(3000), random.integers(1, 14, 3000))[:3000]
    found = _one(y + levels, r, "reach_time")
    assert not found.reason
    assert found.value == pytest.approx(5e-4 + 1e-3 * math.log(50.0), rel=0.3)


def test_a_signal_that_follows_a_reference_that_wanders_does_not() -> None:
    """The reference of an inner loop walks as the outer loop does; the signal follows within a row."""
    random = np.random.default_rng(7)
    walk = np.cumsum(4e-4 * random.standard_normal(2400))
    r = _step(0.0, 1.0, rows=2400, at=500) + walk
    y = np.append(r[:1], r[:-1])
    followed = _one(y + 1e-3 * random.standard_normal(2400), r, "plateau_mean")
    assert not followed.reason
    alone = _one(y + 1e-3 * random.standard_normal(2400), r - walk, "plateau_mean")
    assert "wanders" in alone.reason


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_start_that_noise_hides_is_that_of_a_lag_of_the_order_that_the_rest_shows(order: int) -> None:
    rows, tau, dead = np.arange(600.0), 24.0 / order, 7.0
    y = special.gammainc(order, np.maximum(rows - 100.0 - dead, 0.0) / tau)
    step = find_step(_block(y, _step(0.0, 1.0, len(rows))), "torque", "torque_reference", held=True)
    draws = 0.03 * np.random.default_rng(1).standard_normal((40, 1))
    found = departure(step, NoisyCurve(step.y, draws * np.ones(len(step.y))))
    assert found is not None
    assert found.place == pytest.approx(dead + tau * special.gammaincinv(order, 0.02), abs=0.3)
    assert 0.3 < found.standard < 4.0


def test_rows_that_repeat_the_one_before_move_what_is_of_the_samples() -> None:
    """Without noise they are left out of the curve like clicks, and not out of the samples."""
    tau, stale, rows = 19.0, 0.05, 1400
    lag = 1.0 - np.exp(-np.maximum(0.0, np.arange(rows) - 203.0) / tau)
    for seed in range(4):
        is_new = np.random.default_rng(seed).random(rows) > stale
        y = lag[np.maximum.accumulate(np.where(is_new, np.arange(rows), 0))]
        _, standard = _errors(y, _step(0.0, 1.0, rows, 200), "tracking_error_max", 0.0)
        assert standard > 0.5 * math.sqrt(stale) * 0.02 / tau


def test_a_click_elsewhere_in_the_record_may_be_among_the_samples() -> None:
    y, r = _noisy(1.0, 3e-3, rows=2000)
    without = _one(y, r, "tracking_error_max")
    y[40] += 0.1
    found = _one(y, r, "tracking_error_max")
    assert without.uncertainty is not None
    assert found.uncertainty is not None
    assert found.value == without.value
    assert found.uncertainty.standard > 0.02 > 5.0 * without.uncertainty.standard
    assert found.definition.endswith("the record has 1 sample that is far from the neighbours")
    powers = [_one(each, r, "tracking_error_rms") for each in (y, np.where(np.arange(2000) == 40, 0.0, y))]
    of_click, of_none = (each.uncertainty.standard for each in powers if each.uncertainty is not None)
    assert of_click > 3.0 * of_none
