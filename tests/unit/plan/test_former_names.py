"""Names that measurements had in earlier versions, in plans to run and in recorded ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchtool.analysis.catalogue import catalogue
from benchtool.plan.former_names import present_name, upgraded
from benchtool.plan.model import recorded_plan
from benchtool.telemetry.certificate import certificate_units

from .test_validation import BASE, _refusal


@pytest.mark.parametrize(
    ("former", "present"),
    [
        ("dead_time", "step_latency"),
        ("torque_ripple_p99", "torque_ripple_percentile_range"),
        ("true_torque_mean", "transducer_torque_mean"),
        ("true_torque_ripple_p99", "transducer_torque_ripple_percentile_range"),
        ("true_torque_residual_rms", "transducer_torque_residual_rms"),
        ("current_thd", "current_thd_f"),
        ("current_thd_corrected", "current_thd_f"),
        ("current_thd_f_noise_corrected", "current_thd_f"),
        ("current_thd_n", "current_thd_f_plus_noise"),
        ("current_thdg", "current_thd_f_groups"),
        ("current_thds", "current_thd_f_subgroups"),
        ("capture_adc_saturated", "capture_adc_saturated_count"),
        ("telemetry_law_clipped", "telemetry_law_clipped_count"),
    ],
)
def test_a_former_name_has_a_present_one(former: str, present: str) -> None:
    assert present_name(former) == present
    unit = {"dead_time": "_ms"}.get(former, "_percent" if former.startswith("current") else "")
    assert present_name(former + unit) == present + unit
    assert catalogue().measuring(present) is not None or present in certificate_units(stream=True)
    assert catalogue().measuring(former) is None
    assert present_name(present) == present


def test_no_present_name_is_a_former_one() -> None:
    names = [name for each in catalogue().analyses for name in (each.name, *each.names)]
    for name in (*names, *certificate_units(stream=True)):
        assert present_name(name) == name


def test_a_recorded_plan_is_brought_up_to_date() -> None:
    document: dict[str, Any] = {
        "title": "of an earlier version",
        "profile": "zhu2011",
        "case": "tpc",
        "operating_point": {"mode": "velocity", "omega_m_rad_s": 31.42, "settle_s": 0.5},
        "record": {"duration_s": 0.2, "channels": ["torque", "theta_m", "i_a"]},
        "analyses": {"true_torque_ripple": False},
        "limits": {"torque_ripple_p99": {"max": 1.0}, "torque_order_24": {"max": 0.1}},
        "case_limits": {"tpc": {"current_thd": {"max": 5.0}}},
        "tabulate": ["current_thd", "speed_order_6"],
    }
    plan = recorded_plan(document)
    assert set(plan.limits) == {"torque_ripple_percentile_range", "torque_order_24"}
    assert set(plan.case_limits["tpc"]) == {"current_thd_f"}
    assert list(plan.tabulate) == ["current_thd_f", "speed_order_6"]
    analyses = plan.model_dump()["analyses"]
    assert analyses["transducer_torque_ripple"] is False
    assert analyses["torque_orders"] == {"orders": (24,)}
    assert analyses["speed_orders"] == {"orders": (6,)}
    again = plan.model_dump(mode="json")
    assert upgraded(again) == again


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ("[limits]\ntrue_torque_mean = { max = 1.0 }\n", "called 'transducer_torque_mean' now"),
        ("[limits]\ndead_time_s = { max = 1.0 }\n", "called 'step_latency_s' now"),
        ("[analyses]\ntrue_torque_ripple = false\n", "called 'transducer_torque_ripple' now"),
    ],
)
def test_a_plan_with_a_former_name_is_told_the_present_one(tmp_path: Path, more: str, told: str) -> None:
    assert told in _refusal(tmp_path / "mine.toml", BASE + more)
