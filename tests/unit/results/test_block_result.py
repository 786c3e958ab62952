"""Measuring a block, whatever it comes from: every number has a value or a reason."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.profile import Bench, Sensor
from benchtool.results.block_result import analyze
from tests.unit.analysis.example_capture import steady_capture
from tests.unit.results.recorded_specimen import PROFILE, stream, with_gaps

ALL = ("torque", "omega_m", "i_a", "theta_m", "u_dc")


def _every_number_has_a_value_or_a_reason(block: Block) -> None:
    for each in analyze(block, PROFILE):
        assert math.isfinite(each.value) != bool(each.reason), each.name
        assert "`" not in each.definition


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    channels=st.sets(st.sampled_from(ALL), min_size=1),
    rate_Hz=st.sampled_from([20.0, 250.0, 1000.0]),
    seconds=st.sampled_from([0.2, 3.0]),
    speed=st.sampled_from([0.0, 5.0, 150.0]),
)
def test_whatever_was_recorded_every_number_has_a_value_or_a_reason(
    channels: set[str], rate_Hz: float, seconds: float, speed: float
) -> None:
    _every_number_has_a_value_or_a_reason(
        stream([(seconds, speed, 0.65)], rate_Hz, channels=sorted(channels))
    )


def test_a_capture_gives_what_its_analyses_give() -> None:
    block, transducer = steady_capture()
    result = analyze(block, PROFILE, transducer=transducer)
    assert result["torque_ripple_pp"].value == pytest.approx(float(np.ptp(block.column("torque"))))
    assert result["torque_ripple_pp"].uncertainty is not None
    assert "transducer_torque_mean" in result
    assert result.tables
    assert result.steady["torque_mean"].value == result["torque_mean"].value
    assert result.to_json()["measurements"]["torque_mean"]["unit"] == "Nm"


def test_torque_alone_gives_mean_and_rms_and_says_its_band() -> None:
    block = stream([(10.0, 15.7, 0.65)], channels=("torque",))
    result = analyze(block, PROFILE)
    assert result["torque_mean"].value == pytest.approx(0.65, abs=0.003)
    assert result["torque_ripple_rms"].value == pytest.approx(0.02, rel=0.1)
    for name in ("torque_mean", "torque_ripple_rms"):
        assert result[name].basis.bandwidth_Hz == 125.0
        assert "what lies above 125 Hz folds into it" in result[name].definition
    for name in ("torque_ripple_pp", "torque_ripple_percent_of_mean"):
        assert math.isnan(result[name].value)
        assert "extremes between them are not seen" in result[name].reason
    with pytest.raises(AnalysisError, match="'current_thd_f' needs i_a, not recorded here"):
        result["current_thd_f"]
    with pytest.raises(AnalysisError, match="no measurement 'ripple' of this block"):
        result["ripple"]


def test_distortion_is_not_claimed_of_rows_that_are_far_apart() -> None:
    result = analyze(stream([(5.0, 15.7, 0.65)], channels=ALL), PROFILE)
    assert result["fundamental_frequency"].value == pytest.approx(4.0 * 15.7 / (2.0 * math.pi), rel=1e-3)
    assert result["current_fundamental"].value == pytest.approx(1.0, rel=0.01)
    assert "fold onto those below" in result["current_thd_f"].reason
    assert "fold onto those below" in result["current_noise_floor"].reason


@pytest.mark.parametrize("channels", [ALL, ("torque", "i_a", "omega_m"), ("torque", "i_a")])
def test_a_current_that_the_rows_cannot_follow_has_no_frequency(channels: tuple[str, ...]) -> None:
    # 100 Hz of current in rows at 150 Hz look like 50 Hz
    result = analyze(stream([(10.0, 157.1, 0.65)], 150.0, channels=channels), PROFILE)
    assert math.isnan(result["fundamental_frequency"].value)
    assert math.isnan(result["current_fundamental"].value)
    assert "150" in result["fundamental_frequency"].reason.replace("149.254", "150")
    assert result["torque_mean"].value == pytest.approx(0.65, abs=0.01), "the mean torque needs no rotation"


@pytest.mark.parametrize("speed", [0.0, 0.3])
def test_a_shaft_that_hardly_turns_has_a_mean_torque(speed: float) -> None:
    result = analyze(stream([(3.0, speed, 0.65)], channels=ALL), PROFILE)
    assert result["torque_mean"].value == pytest.approx(0.65, abs=0.01)
    assert math.isnan(result["fundamental_frequency"].value)


def test_a_gap_is_the_reason_and_nothing_is_interpolated() -> None:
    result = analyze(with_gaps(stream([(5.0, 15.7, 0.65)]), (100, 7)), PROFILE)
    assert "7 rows are missing in 1 gap" in result["torque_mean"].reason
    assert all(math.isnan(each.value) for each in result)
    window = analyze(with_gaps(stream([(5.0, 15.7, 0.65)]), (100, 7)), PROFILE, from_s=0.5)
    assert window["torque_mean"].value == pytest.approx(0.65, abs=0.01)


def test_what_is_asked_for_is_made_and_what_is_left_out_is_not() -> None:
    block, _ = steady_capture()
    table = {"torque_orders": False, "step": {"signal": "torque", "reference": "torque"}}
    result = analyze(block, PROFILE, analyses=table)
    assert "torque_orders" not in result.findings
    assert "step" in result.findings
    with pytest.raises(AnalysisError, match=r"\[analyses\] key 'stepp'"):
        analyze(block, PROFILE, analyses={"stepp": True})


def test_a_block_without_rows_is_refused() -> None:
    block = stream([(1.0, 0.0, 0.0)])
    with pytest.raises(AnalysisError, match="without rows: nothing was recorded"):
        analyze(replace(block, data=block.data[:0]), PROFILE)
    with pytest.raises(AnalysisError, match="no row lies from 5 s on"):
        analyze(block, PROFILE, from_s=5.0)


def test_the_sensors_of_the_profile_are_in_the_uncertainty() -> None:
    block, _ = steady_capture()
    sensor = Sensor(sensor="estimate", gain_U_percent=1.0, due=date(2026, 1, 1))
    profile = PROFILE.model_copy(update={"bench": Bench(channels={"torque": sensor})})
    plain, sensed = (analyze(block, each, on=date(2026, 2, 1)) for each in (PROFILE, profile))
    before, after = plain["torque_mean"].uncertainty, sensed["torque_mean"].uncertainty
    assert before is not None
    assert after is not None
    assert after.standard == pytest.approx(
        math.hypot(before.standard, 0.005 * plain["torque_mean"].value), rel=1e-3
    )
    assert [each.channel for each in sensed.overdue] == ["torque"]


@pytest.mark.parametrize("slip", [0.0, 0.01])
def test_an_encoder_that_slips_is_a_remark(slip: float) -> None:
    """The rotor turns by 8 revolutions, in 32 periods of the current; the encoder counts 1 % less."""
    theta_m = 2.0 * np.pi * 4.0 * np.arange(20_000) / 1e4
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(theta_m))
    angle = np.mod((1.0 - slip) * theta_m, 2.0 * np.pi)
    units = {"i_a": "A", "theta_m": "rad"}
    block = Block.from_arrays(1e4, units, i_a=np.cos(4.0 * theta_m) + noise, theta_m=angle)
    result = analyze(block, PROFILE)
    told = [text for text in result.remarks if "by angle and pole pairs at 15.84 Hz, 115° electrical" in text]
    assert len(told) == len(result.remarks) == (1 if slip else 0)
    assert result.to_json().get("remarks", []) == told


def test_the_angle_alone_tells_at_which_frequency_an_order_was_read() -> None:
    """Order 12 at 25 revolutions per second is at 300 Hz."""
    theta_m = 2.0 * math.pi * 25.0 * np.arange(8_000) / 10e3
    torque = 1.0 + 0.1 * np.cos(12.0 * theta_m) + 1e-4 * np.random.default_rng(1).standard_normal(8_000)
    block = Block.from_arrays(10e3, {"torque": "Nm"}, torque=torque, theta_m=np.mod(theta_m, 2.0 * math.pi))
    bench = Bench(channels={"torque": Sensor(bandwidth_Hz=300.0, bandwidth_tolerance_percent=1.0)})
    found = analyze(block, PROFILE.model_copy(update={"bench": bench}))["torque_order_largest_amplitude"]
    assert found.basis.frequency_Hz == pytest.approx(300.0, rel=1e-3)
    assert found.value == pytest.approx(0.1 * math.sqrt(2.0), rel=1e-3)
