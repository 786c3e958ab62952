"""Step responses against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise, fitted_smoothers
from benchtool.analysis.steps.step import analyze_step
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from tests.at_length import at_length

RATE_HZ = 10_000.0
CHANNELS = (Channel("torque", "Nm"), Channel("torque_reference", "Nm"))


def _block(y: NDArray[np.float64], r: NDArray[np.float64]) -> Block:
    return Block(CHANNELS, 0, 1, 1.0 / RATE_HZ, np.column_stack([y, r]))


def _measured(y: NDArray[np.float64], r: NDArray[np.float64]) -> dict[str, float]:
    response = analyze_step(_block(y, r), "torque", "torque_reference", held=True)
    return {each.name: each.value for each in response.measurements}


def _step(before: float, after: float, rows: int = 1000, at: int = 100) -> NDArray[np.float64]:
    return np.where(np.arange(rows) < at, before, after)


@given(st.floats(-5.0, 5.0), st.floats(0.5, 10.0), st.sampled_from([1.0, -1.0]))
@settings(max_examples=settings().max_examples // 2)
def test_a_first_order_lag_in_either_direction(before: float, height: float, sign: float) -> None:
    tau_s = 2e-3
    r = _step(before, before + sign * height)
    since_s = np.maximum(0.0, np.arange(1000) - 100) / RATE_HZ
    found = _measured(before + sign * height * (1.0 - np.exp(-since_s / tau_s)), r)
    assert found["rise_time"] == pytest.approx(tau_s * math.log(9.0), rel=2e-3)
    assert found["reach_time"] == pytest.approx(tau_s * math.log(50.0), rel=2e-3)
    assert found["settling_time"] == pytest.approx(tau_s * math.log(50.0), abs=1.5 / RATE_HZ)
    assert found["overshoot"] == 0.0
    assert found["undershoot"] <= 0.02 * height * (1.0 + 1e-9)


def test_overshoot_of_a_second_order_system() -> None:
    zeta, omega = 0.4, 3000.0
    since_s = np.maximum(0.0, np.arange(2000) - 100) / RATE_HZ
    omega_d = omega * math.sqrt(1.0 - zeta**2)
    decay = np.exp(-zeta * omega * since_s)
    y = 1.0 - decay * (np.cos(omega_d * since_s) + zeta * omega / omega_d * np.sin(omega_d * since_s))
    found = _measured(3.0 * y, _step(0.0, 3.0, 2000))
    peak = math.exp(-zeta * math.pi / math.sqrt(1.0 - zeta**2))
    assert found["overshoot"] == pytest.approx(3.0 * peak, rel=2e-2)
    assert found["undershoot"] == pytest.approx(3.0 * peak**2, rel=5e-2)


def test_an_edge_is_no_overshoot_between_its_samples() -> None:
    found = _measured(
        np.select([np.arange(1000) < 101, np.arange(1000) < 102], [0.0, 1.0], 0.95), _step(0.0, 1.0)
    )
    assert found["overshoot"] == 0.0


def test_a_pulse_is_judged_by_its_plateau_and_by_its_end() -> None:
    rows = np.arange(1000)
    r = np.select([rows < 100, rows < 600], [0.0, 1.0], 0.2)
    y = r.copy()
    y[300] = 1.07
    y[650] = 0.05
    found = _measured(y, r)
    assert found["overshoot"] == pytest.approx(0.07)
    assert found["undershoot"] == pytest.approx(0.15)
    # the last movement is a jump from row 650 to 651, and its instant somewhere between the two
    assert found["settling_time"] == pytest.approx(550.5 / RATE_HZ)


def test_what_is_not_reached_has_no_time_and_says_why() -> None:
    response = analyze_step(_block(0.5 * _step(0.0, 1.0), _step(0.0, 1.0)), "torque", "torque_reference")
    by_name = {each.name: each for each in response.measurements}
    for name in ("rise_time", "reach_time", "undershoot", "settling_time"):
        assert math.isnan(by_name[name].value)
        assert by_name[name].reason


def _noisy(height: float, rms: float, seed: int = 0, rows: int = 5000) -> tuple[NDArray[np.float64], ...]:
    """A lag of 1 ms after 5 rows of delay, with noise, and its reference."""
    r = _step(0.0, height, rows)
    since_s = np.maximum(0.0, np.arange(rows) - 105) / RATE_HZ
    y = height * (1.0 - np.exp(-since_s / 1e-3))
    return y + rms * np.random.default_rng(seed).standard_normal(rows), r


@given(st.integers(3, 30))
def test_step_latency_ends_between_the_samples_of_the_first_movement(rows: int) -> None:
    r = _step(0.0, 1.0)
    (found,) = (
        each
        for each in analyze_step(
            _block(_step(0.0, 1.0, at=100 + rows), r), "torque", "torque_reference"
        ).measurements
        if each.name == "step_latency"
    )
    assert found.value == pytest.approx((rows - 0.5 + 1 / 3) / RATE_HZ)
    assert found.uncertainty is not None
    # between two samples the signal moved, and between two or at its row the reference
    assert found.uncertainty.standard == pytest.approx(
        math.hypot(1.0 / math.sqrt(12.0), 1.0 / 3.0) / RATE_HZ, rel=0.05
    )


@pytest.mark.parametrize("held", [True, False])
def test_a_signal_that_moves_with_its_reference_has_hardly_a_step_latency(held: bool) -> None:
    block = _block(_step(0.0, 1.0), _step(0.0, 1.0))
    for each in analyze_step(block, "torque", "torque_reference", held=held).measurements:
        if each.name == "step_latency":
            assert each.uncertainty is not None
            assert 0.0 < each.value <= each.uncertainty.standard < 0.4 / RATE_HZ


@pytest.mark.parametrize("with_its_row", [False, *at_length(True)])
def test_the_time_of_a_step_is_as_uncertain_as_it_is_off(with_its_row: bool) -> None:
    """Be the steps made with the rows that show them or, at random, before."""
    random, tau, found = np.random.default_rng(4), 20.0, []
    for _ in range(16):
        since = np.arange(1000) - 100 + (0.0 if with_its_row else random.uniform())
        y = 1.0 - np.exp(-np.maximum(since, 0.0) / tau)
        for each in analyze_step(_block(y, _step(0.0, 1.0)), "torque", "torque_reference").measurements:
            if each.name == "reach_time":
                assert each.uncertainty is not None
                off = each.value * RATE_HZ - tau * math.log(50.0)
                found.append(off / (each.uncertainty.standard * RATE_HZ))
    assert math.sqrt(np.mean(np.square(found))) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("late", [0.0, *at_length(1.2)])
def test_a_latency_near_the_least_that_is_possible_is_as_uncertain_as_it_is_off(late: float) -> None:
    random, found = np.random.default_rng(5), []
    for _ in range(18):
        since = np.arange(700) - 100 + random.uniform() - late
        y = 1.0 - np.exp(-np.maximum(since, 0.0) / 20.0) + 0.02 * random.standard_normal(700)
        block = _block(y, _step(0.0, 1.0, rows=700))
        for each in analyze_step(block, "torque", "torque_reference").measurements:
            if each.name == "step_latency" and each.uncertainty is not None:
                truth = late - 20.0 * math.log(0.98)
                off = each.value * RATE_HZ - truth
                found.append(off / (each.uncertainty.standard * RATE_HZ))
    assert 0.6 < math.sqrt(np.mean(np.square(found))) < 1.3


@pytest.mark.slow
def test_step_latency_does_not_take_earlier_noise_for_the_answer() -> None:
    found = []
    for seed in range(20):
        response = analyze_step(_block(*_noisy(1.0, 0.03, seed)), "torque", "torque_reference")
        found += [each for each in response.measurements if each.name == "step_latency"]
    rows = RATE_HZ * np.array([each.value for each in found])
    # the lag has gone 2 % after a fifth of a row
    assert np.median(rows) == pytest.approx(5.2, abs=0.7)
    # noise that is taken for it would be anywhere in the rows before
    assert np.min(rows) > 2.0
    assert np.std(rows) < 1.2
    uncertain = [each.uncertainty for each in found if each.uncertainty is not None]
    assert len(uncertain) == 20
    errors = (rows - 5.2) / (RATE_HZ * np.array([each.standard for each in uncertain]))
    assert 0.4 < np.sqrt(np.mean(errors**2)) < 1.4


@pytest.mark.slow
def test_noise_of_the_samples_does_not_delay_settling() -> None:
    found = [_measured(*_noisy(0.65, 0.01, seed))["settling_time"] for seed in range(20)]
    expected_s = 5 / RATE_HZ + 1e-3 * math.log(50.0)
    assert np.median(found) == pytest.approx(expected_s, rel=0.1)
    assert np.count_nonzero(np.array(found) > 6e-3) <= 1


def test_noise_beyond_two_percent_widens_the_settling_band() -> None:
    y, r = _noisy(0.65, 0.1)
    response = analyze_step(_block(y, r), "torque", "torque_reference")
    (settling,) = (each for each in response.measurements if each.name == "settling_time")
    assert "x its uncertainty, as 2% of the step is less" in settling.definition
    (clean,) = (
        each
        for each in analyze_step(_block(*_noisy(0.65, 1e-4)), "torque", "torque_reference").measurements
        if each.name == "settling_time"
    )
    assert (
        "within 0.013 Nm of the final reference, the mean of its last tenth: 2% of the step"
        in clean.definition
    )


@pytest.mark.parametrize(("before", "after"), [(0.05, 1e-4), (1e-4, 0.05)])
def test_noise_before_a_step_is_not_in_numbers_of_the_samples_after_it(before: float, after: float) -> None:
    r = _step(0.0, 1.0)
    noise = np.random.default_rng(3).normal(0.0, 1.0, len(r)) * np.where(
        np.arange(len(r)) < 100, before, after
    )
    response = analyze_step(_block(r + noise, r), "torque", "torque_reference")
    measured = {each.name: each for each in response.measurements}
    overshoot, greatest = measured["overshoot"].uncertainty, measured["tracking_error_max"].uncertainty
    for each in (overshoot, greatest):
        assert each is not None
        assert 0.1 * after < each.standard < after


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_tracking_error_is_signal_minus_reference_in_its_own_sign(sign: float) -> None:
    y, r = _noisy(sign * 2.0, 0.005)
    found = _measured(y + 0.01, r)
    assert found["tracking_error_mean"] == pytest.approx(0.01, abs=5e-4)
    assert found["tracking_error_rms"] == pytest.approx(math.hypot(0.01, 0.005), rel=0.1)
    assert found["tracking_error_max"] < 0.05


def test_overshoot_in_percent_and_its_time() -> None:
    r = _step(0.0, 4.0)
    y = r.copy()
    y[117] = 4.4
    found = _measured(y, r)
    assert found["overshoot"] == pytest.approx(0.4)
    assert found["overshoot_percent"] == pytest.approx(10.0)
    assert found["peak_time"] == pytest.approx(17 / RATE_HZ)
    lag = 4.0 * (1.0 - np.exp(-np.maximum(0.0, np.arange(1000) - 100) / 30.0))
    assert math.isnan(_measured(lag, r)["peak_time"])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_plateau_is_where_the_reference_holds_and_the_signal_has_arrived(sign: float) -> None:
    rows = np.arange(1000)
    r = np.select([rows < 100, rows < 600], [0.0, 1.0], 0.2)
    y = np.select([rows < 105, rows < 602], [0.0, 1.0], 0.2)
    y[110], y[400], y[700] = 1.03, 0.93, 3.0
    y[300] = 1.06
    y[700] = 0.5
    found = _measured(sign * y, sign * r)
    assert found["plateau_mean"] == pytest.approx(sign * (495 + 0.03 - 0.07 + 0.06) / 495)
    extremes = sorted(sign * value for value in (0.93, 1.06))
    assert [found["plateau_min"], found["plateau_max"]] == pytest.approx(extremes)


def test_a_reference_that_does_not_wait_has_no_plateau() -> None:
    rows = np.arange(1000)
    r = np.select([rows < 100, rows < 110], [0.0, 1.0], 0.2)
    y = np.select([rows < 105, rows < 112], [0.0, 0.5], 0.2) + 1e-3 * np.sin(rows)
    assert math.isnan(_measured(y, r)["plateau_max"])


def test_every_number_says_what_it_rests_on() -> None:
    response = analyze_step(_block(*_noisy(1.0, 0.01)), "torque", "torque_reference")
    document = response.to_json()
    assert {name: each["value"] for name, each in document.items()} == {
        each.name: each.value for each in response.measurements if not math.isnan(each.value)
    } | {each.name: None for each in response.measurements if math.isnan(each.value)}
    for each in response.measurements:
        assert each.basis.samples == 4900
        assert "torque against torque_reference, which goes from 0 to 1 Nm in row 100" in each.basis.reference
        assert math.isnan(each.value) == (each.uncertainty is None)
    by_name = {each.name: each for each in response.measurements}
    reach, overshoot = by_name["reach_time"].uncertainty, by_name["overshoot"].uncertainty
    assert reach is not None
    assert 1e-4 / math.sqrt(12.0) < reach.standard < 1e-3
    assert overshoot is not None
    assert 1e-4 < overshoot.standard < 5e-3  # of the smoothed signal, whose samples have 0.01


def test_without_a_step_there_is_no_response() -> None:
    noise = np.sin(np.arange(100.0))
    with pytest.raises(AnalysisError, match="'torque_reference' holds 1 over 100 samples, a step is needed"):
        analyze_step(_block(noise, np.ones(100)), "torque", "torque_reference")


def test_a_signal_in_another_unit_than_its_reference_is_refused() -> None:
    channels = (Channel("omega_m", "rad/s"), Channel("speed_reference", "rpm"))
    block = Block(channels, 0, 1, 1.0 / RATE_HZ, np.column_stack([_step(0.0, 10.0), _step(0.0, 95.5)]))
    with pytest.raises(AnalysisError, match="'omega_m' is in rad/s and 'speed_reference' in rpm"):
        analyze_step(block, "omega_m", "speed_reference")


@pytest.mark.parametrize(
    ("levels", "what"),
    [
        ([0.0, 1.0, 2.0, 3.0], "rests near -?1 Nm on its way to -?3 Nm"),
        ([0.0, 2.0, 3.0], "rests near -?2 Nm"),
        ([0.0, 10.0, 10.8], "rests near -?10 Nm"),
        ([0.0, 0.4, 10.4], "rests near -?0.4 Nm"),
        ([0.0, 1.0, 0.0, 1.0], "rises 2 times"),
        ([0.0, 1.0, -1.0], "the other"),
    ],
    ids=["staircase", "two steps", "a small one after", "a small one before", "square wave", "doublet"],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_more_than_one_step_is_refused(levels: list[float], what: str, sign: float) -> None:
    r = sign * np.repeat(levels, 200)
    with pytest.raises(AnalysisError, match=what) as refused:
        analyze_step(_block(r + 1e-3 * np.sin(np.arange(len(r))), r), "torque", "torque_reference")
    assert ("near -" in str(refused.value)) == (sign < 0.0 and "near" in what)


@pytest.mark.parametrize("rows", [2, 3, 7, 30, 199, 400])
def test_a_ramp_and_a_lag_of_the_reference_are_one_step(rows: int) -> None:
    ramp = np.clip((np.arange(1000) - 100) / rows, 0.0, 1.0)
    lag = 1.0 - np.exp(-np.maximum(0.0, np.arange(1000.0) - 100.0) / rows)
    for r in (ramp, lag):
        found = analyze_step(_block(np.roll(r, 3) * (np.arange(1000) >= 3), r), "torque", "torque_reference")
        assert found.step_row >= 100


def test_a_signal_along_a_slow_ramp_rises_with_it_and_has_no_step_latency() -> None:
    ramp = np.clip((np.arange(1000) - 100) / 200, 0.0, 1.0)
    y = np.roll(ramp, 3) * (np.arange(1000) >= 3) + 0.5  # an offset is no movement
    by_name = {
        each.name: each for each in analyze_step(_block(y, ramp), "torque", "torque_reference").measurements
    }
    assert math.isnan(by_name["step_latency"].value)
    assert by_name["step_latency"].reason == "it moves before the reference has come half the way"
    found = _measured(y - 0.5, ramp)
    assert found["rise_time"] == pytest.approx(160 / RATE_HZ)
    assert found["reach_time"] == pytest.approx((0.98 * 200 + 3 - 100) / RATE_HZ)


@pytest.mark.parametrize("rows", [4.0, 7.3, 51.9])
def test_a_ramp_counts_from_the_instant_of_half_its_way(rows: float) -> None:
    since = np.arange(1000) - 100.0
    ramp = np.clip(since / rows, 0.0, 1.0)
    tau = 20.0

    up, down = np.maximum(since, 0.0), np.maximum(since - rows, 0.0)
    y = (up - down + tau * (np.exp(-up / tau) - np.exp(-down / tau))) / rows
    found = _measured(y, ramp)["reach_time"] * RATE_HZ
    truth = tau * math.log(50.0 * tau / rows * (math.exp(rows / tau) - 1.0)) - 0.5 * rows
    assert found == pytest.approx(truth, abs=0.05)


def test_no_window_is_over_the_end_of_a_pulse_and_those_away_from_it_are_long() -> None:
    rows = np.arange(1800.0)
    y = np.where(rows < 800, 1.0 - np.exp(-rows / 20.0), np.exp(-(rows - 800.0) / 20.0))
    noise = 3e-3 * np.random.default_rng(5).standard_normal(2000)
    half = fitted_smoothers(y + noise[:1800], Noise.of(noise[1800:]))[0].half
    assert np.max(half[795:806]) <= 8
    assert np.all(half[600:800] <= 8 + (800 - rows[600:800]))
    assert half[400] >= 20


def test_a_late_mode_as_small_as_the_noise_is_not_smoothed_away() -> None:
    """No row shows it beyond six standard deviations, and the flat rows after it outweigh it."""
    random = np.random.default_rng(8)
    row = np.arange(1300.0)
    mode = 0.08 * np.exp(-row / 150.0) * np.cos(2.0 * math.pi * row / 43.0)
    y = 1.0 - 0.92 * np.exp(-row / 70.0) - mode
    noise = 0.004 * random.standard_normal((2, len(row)))
    _, best = fitted_smoothers(y + noise[0], Noise.of(noise[1]))
    assert np.all(best.half[100:340] <= 19)  # half a period has 21
    assert best.half[1000] > 60


def test_slow_noise_is_not_taken_away_with_the_line() -> None:
    """The variance of a sum over many samples, which a line fitted to as many would leave none of."""
    noise, count = np.random.default_rng(1).standard_normal((400, 200)), 200
    found = [Noise.of(each).autocovariance for each in noise]
    sums = np.mean([each[0] + 2.0 * np.sum(each[1:]) for each in found])
    assert sums == pytest.approx(1.0, abs=0.1)
    assert np.mean([each[0] for each in found]) == pytest.approx(1.0, abs=0.03)
    assert all(len(each) <= count // 2 for each in found)


def test_slow_noise_at_rest_is_no_certain_overshoot() -> None:
    """A slow lag that has none, under a random walk that white noise hides at first."""
    relative = []
    for seed in (0, 17, 19, 35, 37, 39):
        random = np.random.default_rng([3, seed])
        time_s = np.arange(-200, 2000) * 1e-4
        walk = np.cumsum(random.standard_normal(len(time_s))) / math.sqrt(len(time_s))
        noise = 9e-3 * (walk - 0.5 * walk[-1] + random.standard_normal(len(time_s)))
        lag = 1.0 - np.exp(-np.maximum(time_s, 0.0) * 2.0 * math.pi * 15.0)
        rows = np.stack([lag + noise, np.where(time_s >= 0.0, 1.0, 0.0)], axis=1)
        block = Block((Channel("y", "Nm"), Channel("r", "Nm")), 0, 1, 1e-4, rows)
        found = {each.name: each for each in analyze_step(block, "y", "r").measurements}["overshoot"]
        assert found.uncertainty is not None
        relative.append(found.value / found.uncertainty.standard)
    assert max(relative) < 2.5


@pytest.mark.slow
@pytest.mark.parametrize("zeta", [0.4, 1.0])
def test_uncertainties_cover_the_error(zeta: float) -> None:
    """The response of a second-order system in 0.3 % and in 1 % of noise, against the noise-free one."""
    omega, rows, at = 2000.0, 800, 150
    since_s = np.maximum(0.0, np.arange(rows) - at) / RATE_HZ
    root = np.sqrt(complex(zeta**2 - 1.0 + 1e-12))
    fast, slow = -omega * (zeta + root), -omega * (zeta - root)
    y = np.real(1.0 + (slow * np.exp(fast * since_s) - fast * np.exp(slow * since_s)) / (fast - slow))
    r = _step(0.0, 1.0, rows, at)
    truth = _measured(y, r)
    random = np.random.default_rng(7)
    errors: dict[str, list[float]] = {}
    for rms in (0.003, 0.01):
        for _ in range(12):
            noisy = _block(y + rms * random.standard_normal(rows), r)
            for each in analyze_step(noisy, "torque", "torque_reference").measurements:
                if each.name in ("rise_time", "reach_time", "overshoot", "peak_time", "settling_time"):
                    assert each.uncertainty is not None or zeta == 1.0
                    if each.uncertainty is not None and not math.isnan(truth[each.name]):
                        error = (each.value - truth[each.name]) / each.uncertainty.standard
                        errors.setdefault(each.name, []).append(error)
    for name, found in errors.items():
        assert np.mean(np.abs(found) <= 2.0) >= 0.75, name
        assert np.sqrt(np.mean(np.square(found))) <= 1.8, name


@pytest.mark.parametrize(("drift", "told"), [(0.2, True), (-0.2, True), (0.01, False), (0.0, False)])
def test_a_drift_before_the_step_is_not_taken_for_the_answer(drift: float, told: bool) -> None:
    after = np.maximum(0, np.arange(3000) - 1000)
    noise = 2e-3 * np.random.default_rng(5).standard_normal(len(after))
    y = 1.0 - np.exp(-0.05 * after) + noise + drift * np.linspace(0.0, 1.0, len(after))
    response = analyze_step(_block(y, np.where(after > 0, 1.0, 0.0)), "torque", "torque_reference")
    found = {each.name: each for each in response.measurements}
    assert ("drifts by" in found["settling_time"].reason) is told
    assert ("drifts by" in found["overshoot"].reason) is told
    assert "drifts by" not in found["plateau_mean"].reason


def test_what_is_above_a_level_in_the_first_row_passed_it_since_the_row_before() -> None:
    since = np.maximum(0.0, np.arange(1000) - 99.4)  # samples; the reference is seen to step in row 100
    y = 1.0 - np.exp(-since / 1.5)
    response = analyze_step(_block(y, _step(0.0, 1.0)), "torque", "torque_reference")
    rise = next(each for each in response.measurements if each.name == "rise_time")
    assert rise.uncertainty is not None
    samples, standard = rise.value * RATE_HZ, rise.uncertainty.standard * RATE_HZ
    assert standard > 0.1
    assert abs(samples - 1.5 * math.log(9.0)) < 2.0 * standard


def test_a_drift_that_noise_hides_before_a_step_is_in_what_is_late() -> None:
    since_s = np.maximum(0.0, np.arange(1000) - 100) / RATE_HZ
    clean = 1.0 - np.exp(-since_s / 2e-3) + 3e-3 * np.random.default_rng(5).standard_normal(1000)
    drifting = clean + 0.3 * (np.arange(1000) - 100) / RATE_HZ
    plain, doubtful = (
        next(
            each
            for each in analyze_step(_block(y, _step(0.0, 1.0)), "torque", "torque_reference").measurements
            if each.name == "overshoot"
        )
        for y in (clean, drifting)
    )
    assert plain.uncertainty is not None
    assert doubtful.uncertainty is not None
    assert plain.uncertainty.standard < 2e-3
    assert doubtful.value < 2.0 * doubtful.uncertainty.standard


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("before", "is_known"), [(0.45, True), (-0.45, True), (0.55, False), (2.0, False)])
def test_a_signal_far_from_its_reference_before_the_step_follows_another(
    before: float, is_known: bool, sign: float
) -> None:
    """A speed that steps from 100 to 150 rad/s beside what is added to its setpoint, 0 to 50: it had risen
    before the step, in no time, with an overshoot of 224 %."""
    r = _step(0.0, 1.0)
    since_s = np.maximum(0.0, np.arange(1000) - 100) / RATE_HZ
    y = sign * (before + 1.0 - np.exp(-since_s / 2e-3))
    response = analyze_step(_block(y, sign * r), "torque", "torque_reference", held=True)
    found = {each.name: each for each in response.measurements}
    assert math.isfinite(found["overshoot"].value) == is_known
    if not is_known:
        assert all(math.isnan(each.value) for each in found.values())
        assert f"signal is at {sign * before:.4g} Nm" in found["rise_time"].reason
        assert "name the reference that the signal follows" in found["rise_time"].reason
