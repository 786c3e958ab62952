"""Step responses about rest: modes that last until arrival, hum before the step, tails that are slow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.step import analyze_step
from benchtool.analysis.steps.step_drift import find_drift
from benchtool.analysis.steps.step_shape import find_step
from benchtool.block import Block

RATE_HZ = 5_000.0
BEFORE = 250


def _found(way: NDArray[np.float64]) -> dict[str, Measurement]:
    reference = np.where(np.arange(len(way)) < BEFORE, 0.0, 1.0)
    block = Block.from_arrays(RATE_HZ, {"y": "A", "r": "A"}, y=way, r=reference)
    return {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}


def _lag(rows: int, decay: float) -> NDArray[np.float64]:
    after = np.arange(rows) - BEFORE
    return np.where(after < 0, 0.0, 1.0 - np.exp(-np.maximum(after, 0) / decay))


def test_a_crest_just_below_a_level_leaves_open_when_it_is_passed() -> None:
    # a crest as far below the level as its noise, then a trough, then beyond it
    row = np.arange(120.0)
    values = np.interp(row, [0, 40, 60, 80, 120], [-1.0, -0.02, -0.4, 0.4, 1.0])
    errors = 0.02 * np.random.default_rng(5).standard_normal((400, 1)) * np.ones(len(row))
    found = NoisyCurve(values, errors).first_above(0.0)
    assert found is not None
    assert found.place == pytest.approx(70.0)
    # a sixth of the draws pass it thirty rows earlier
    assert found.standard == pytest.approx(30.0 * np.sqrt(0.16), rel=0.15)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0])
def test_hum_before_a_step_is_no_drift(phase: float) -> None:
    noise = 0.003 * np.random.default_rng(8).standard_normal(1500)
    hum = 0.01 * np.cos(2.0 * np.pi * 50.0 / RATE_HZ * np.arange(1500) + phase)
    found = _found(_lag(1500, 60.0) + noise + hum)
    assert found["overshoot"].uncertainty is not None


def test_a_slow_tail_is_no_slow_noise() -> None:
    noise = 0.003 * np.random.default_rng(9).standard_normal(4000)
    found = _found(0.94 * _lag(4000, 30.0) + 0.06 * _lag(4000, 500.0) + noise)
    expected_s = 500.0 * np.log(3.0) / RATE_HZ
    uncertainty = found["settling_time"].uncertainty
    assert uncertainty is not None
    assert abs(found["settling_time"].value - expected_s) < 2.0 * uncertainty.standard
    assert uncertainty.standard < 0.05 * expected_s


def test_a_pulse_has_not_settled_before_its_fall() -> None:
    row = np.arange(1000)
    reference = np.where((row >= 100) & (row < 800), 1.0, 0.0)
    fall = 1.0 - 0.65 ** np.maximum(0, row - 800)
    answer = np.where(row < 100, 0.0, 1.0 - 0.65 ** np.maximum(0, row - 100)) - fall
    ripple = 0.017 * np.cos(0.5 * row) + 0.004 * np.random.default_rng(4).standard_normal(1000)
    block = Block.from_arrays(10_000.0, {"y": "A", "r": "A"}, y=answer + ripple, r=reference)
    found = {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}
    uncertainty = found["tracking_error_rms"].uncertainty
    assert uncertainty is not None
    assert uncertainty.standard < 0.3 * found["tracking_error_rms"].value


def test_a_slope_before_a_step_that_does_not_go_on_after_it_is_no_doubt() -> None:
    random = np.random.default_rng(21)
    row = np.arange(5000.0)
    noise = 0.01 * random.standard_normal(len(row))
    noise[:100] += 1e-4 * (row[:100] - 50.0)  # three standard uncertainties of a slope over so few
    r = np.where(row < 100.0, 0.0, 0.65)
    y = 0.65 * (1.0 - np.exp(-np.maximum(row - 105.0, 0.0) / 10.0)) + noise
    block = Block.from_arrays(10_000.0, {"y": "Nm", "r": "Nm"}, y=y, r=r)
    step = find_step(block, "y", "r")
    assert find_drift(step, step.y_clear[2500:]).doubt < 1e-6
    drifting = find_step(Block.from_arrays(10_000.0, {"y": "Nm", "r": "Nm"}, y=y + 2e-6 * row, r=r), "y", "r")
    assert find_drift(drifting, drifting.y_clear[2500:]).doubt == pytest.approx(2e-6, rel=0.2)


def test_a_pulse_that_has_fallen_is_at_rest_by_the_time_since_its_fall() -> None:
    random = np.random.default_rng(31)
    row = np.arange(1000.0) - 150
    clean = 1.0 - np.exp(-np.maximum(row, 0.0) / 2.0)
    clean[550:] -= clean[150:600]
    r = np.where((row >= 0.0) & (row < 400.0), 1.0, 0.0)
    for _ in range(3):
        y = clean + 5e-3 * random.standard_normal(len(row))
        block = Block.from_arrays(RATE_HZ, {"y": "A", "r": "A"}, y=y, r=r)
        found = {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}
        errors = [found[f"tracking_error_{name}"].uncertainty for name in ("mean", "rms", "max")]
        mean, rms, greatest = (each.standard for each in errors if each is not None)
        assert 0.5 < mean / (5e-3 / np.sqrt(440.0)) < 1.6  # 0.00024 of 440 samples, from 90 at its end 0.0005
        assert rms < 3e-4
        assert greatest < 5e-3  # no sample of the fall, which is 0.2 a row


def test_a_tail_slower_than_the_rise_is_no_noise_of_a_plateau() -> None:
    random = np.random.default_rng(32)
    since = np.maximum(np.arange(4000.0) - BEFORE, 0.0)
    way = 1.0 - 0.94 * np.exp(-since / 33.0) - 0.06 * np.exp(-since / 480.0)
    found = _found(np.where(since > 0.0, way, 0.0) + 3e-3 * random.standard_normal(len(since)))
    mean = found["plateau_mean"].uncertainty
    assert mean is not None
    assert 4e-5 < mean.standard < 1.2e-4  # white noise 5e-5


def test_a_tail_that_outlasts_the_record_is_no_noise() -> None:
    random = np.random.default_rng(33)
    since = np.maximum(np.arange(2250.0) - BEFORE, 0.0)
    way = np.where(since > 0.0, 1.0 - 0.95 * np.exp(-since / 8.0) - 0.05 * np.exp(-since / 300.0), 0.0)
    arrived = 300.0 * np.log(2.5)
    errors = []
    for _ in range(4):
        found = _found(way + 2e-3 * random.standard_normal(len(way)))
        names = "plateau_mean", "tracking_error_rms", "overshoot", "settling_time"
        known = [found[name].uncertainty for name in names]
        mean, rms, greatest, settling = (each.standard for each in known if each is not None)
        assert mean < 1.2e-4  # white noise 5e-5
        assert rms < 2e-4
        assert greatest < 5e-4
        assert settling < 0.06 * arrived / RATE_HZ
        truth = float(np.mean(way[BEFORE + int(arrived) :]))
        errors.append((found["plateau_mean"].value - truth) / mean)
    assert float(np.max(np.abs(errors))) < 3.0


def test_the_greatest_error_of_an_answer_in_hum_is_not_that_of_its_first_sample() -> None:
    way = _lag(1550, 40.0)
    rows = np.arange(len(way))
    phases = 2.0 * np.pi * np.arange(16)[:, np.newaxis] / 16
    hums = 0.006 * np.cos(2.0 * np.pi * rows / 103.0 + phases)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(way))
    for hum in hums[:8:4]:
        found = _found(way + hum + noise)
        band = float(found["settling_time"].definition.split("within ")[1].split()[0])
        settled = rows >= BEFORE - 40.0 * np.log(band)
        truth = float(np.mean(np.max(np.abs(way + hums - 1.0)[:, settled], axis=1)))
        greatest = found["tracking_error_max"]
        assert greatest.uncertainty is not None
        assert abs(greatest.value - truth) < 2.0 * greatest.uncertainty.standard


def test_rest_after_a_pulse_is_counted_from_its_fall() -> None:
    """Noise with a memory of a tenth of the samples before it, which alone might be taken for a walk."""
    row = np.arange(2250.0) - BEFORE
    course = _lag(2250, 80.0) - np.pad(_lag(1250, 80.0), (1000, 0))
    reference = np.where((row >= 0.0) & (row < 1000.0), 1.0, 0.0)
    random = np.random.default_rng(1)
    answered = 0
    for _ in range(6):
        noise = signal.lfilter([1.0], [1.0, -0.95], random.standard_normal(len(row) + 200))[200:]
        y = course + 0.02 * np.sqrt(1.0 - 0.95**2) * noise
        block = Block.from_arrays(RATE_HZ, {"y": "A", "r": "A"}, y=y, r=reference)
        assert find_step(block, "y", "r", held=True).fall == 1000
        found = {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}
        answered += found["rise_time"].uncertainty is not None
    assert answered >= 5


def test_a_walk_that_leaves_an_answer_no_rest_is_told_by_the_later_half() -> None:
    random = np.random.default_rng(55)
    noise = 2e-3 * random.standard_normal(1500) + np.cumsum(6e-4 * random.standard_normal(1500))
    found = _found(_lag(1500, 20.0) + noise)
    assert all("wanders" in each.reason for each in found.values())


def test_few_rows_in_slow_noise_have_no_numbers_and_in_white_noise_they_have() -> None:
    random, refused = np.random.default_rng(6), {"slow": 0, "white": 0}
    way = _lag(BEFORE + 90, 8.0)[BEFORE - 30 :]
    reference = np.where(np.arange(len(way)) < 30, 0.0, 1.0)
    for _ in range(8):
        white = 0.012 * random.standard_normal(len(way) + 500)
        slow = np.sqrt(1.0 - 0.98**2) * signal.lfilter([1.0], [1.0, -0.98], white)
        for name, noise in (("slow", slow), ("white", white)):
            block = Block.from_arrays(RATE_HZ, {"y": "A", "r": "A"}, y=way + noise[500:], r=reference)
            found = analyze_step(block, "y", "r", held=True).measurements
            refused[name] += any("wanders" in each.reason for each in found)
    assert refused["slow"] >= 5
    assert refused["white"] == 0


def test_samples_that_drift_too_little_to_hide_an_answer_scatter_about_a_line() -> None:
    noise = 1e-4 * np.random.default_rng(21).standard_normal(1500)
    line = 0.004 * np.linspace(-1.0, 1.0, 1500)
    found = _found(_lag(1500, 20.0) + line + noise)
    assert np.isfinite(found["settling_time"].value)
    for name in ("plateau_mean", "tracking_error_mean"):
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        # taken for slow noise, the line would leave 2e-3 of the mean uncertain
        assert uncertainty.standard < 1e-4


def test_a_level_that_wanders_by_little_of_a_step_leaves_its_numbers_with_their_uncertainty() -> None:
    """As a speed under its control does."""
    expected = {"rise_time": 40.0 * np.log(9.0) / RATE_HZ, "settling_time": 40.0 * np.log(50.0) / RATE_HZ}
    errors: dict[str, list[float]] = {name: [] for name in expected}
    for seed in range(8):
        random = np.random.default_rng(seed)
        walk = np.cumsum(5e-5 * random.standard_normal(1500)) + 2e-5 * random.standard_normal(1500)
        found = _found(_lag(1500, 40.0) + walk)
        for name, true in expected.items():
            uncertainty = found[name].uncertainty
            assert uncertainty is not None
            assert uncertainty.standard < 0.1 * true
            errors[name].append((found[name].value - true) / uncertainty.standard)
    for each in errors.values():
        assert np.max(np.abs(each)) < 3.0


def test_a_level_that_a_control_takes_a_signal_back_to_is_known() -> None:
    """As large a walk is refused where it has moved the level, and that of a control is not."""
    refused = {"walk": 0, "control": 0}
    for seed in range(1, 7):
        walk = 1.3e-4 * np.cumsum(np.random.default_rng(seed).standard_normal(3000))
        moved = np.mean(walk[BEFORE + 500 :]) - np.mean(walk[:BEFORE])
        back = np.where(np.arange(3000) < BEFORE, 0.0, moved)
        for name, noise in (("walk", walk), ("control", walk - back)):
            found = _found(_lag(3000, 20.0) + noise)["plateau_mean"]
            refused[name] += "wanders" in found.reason
    assert refused["walk"] >= 4
    assert refused["control"] <= 1  # of which a sixth of the record moves by more


def test_a_drift_at_rest_is_a_doubt_where_few_samples_before_the_step_are_calm_by_chance() -> None:
    """200 rows of slow noise, twenty times its memory, show neither its size nor a drift of theirs."""
    random, drift = np.random.default_rng(5), -3e-5
    white = random.standard_normal(2200)
    noise = 3e-3 * math.sqrt(1.0 - 0.9**2) * signal.lfilter([1.0], [1.0, -0.9], white)
    noise[:200] = 1.5e-3 * white[:200] - drift * np.arange(200)
    since = np.maximum(0.0, np.arange(2200) - 200.0)
    y = 1.0 - np.exp(-since / 20.0) + noise + drift * np.arange(2200)
    step = find_step(
        Block.from_arrays(1e4, {"y": "Nm", "r": "Nm"}, y=y, r=np.where(since > 0.0, 1.0, 0.0)), "y", "r"
    )
    assert find_drift(step, step.y_clear[1000:]).doubt == pytest.approx(-drift, rel=0.2)
