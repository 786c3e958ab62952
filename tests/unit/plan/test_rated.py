"""Plans in parts of rated values, and for several profiles."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from benchtool.errors import PlanError
from benchtool.plan.cases import cases
from benchtool.plan.model import Plan, profiles_of
from benchtool.plan.rated import for_motor, require_in_si
from benchtool.profile import load_profile, shipped_profiles

MOTOR = load_profile("zhu2011").motor


def plan(**changed: Any) -> Plan:
    content: dict[str, Any] = {
        "title": "t",
        "profile": "motors/*",
        "operating_point": {"omega_m_of_rated": 0.5, "load_torque_of_rated": -0.25},
        "record": {"duration_s": 0.1, "channels": ["torque"]},
    }
    return Plan.model_validate(content | changed)


def test_setpoints_are_in_si_for_a_motor() -> None:
    stated = plan()
    with pytest.raises(PlanError, match="omega_m_of_rated, load_torque_of_rated, of no motor yet"):
        require_in_si(stated)
    point = for_motor(stated, MOTOR).operating_point
    assert (point.omega_m_rad_s, point.load_torque_Nm) == (0.5 * 157.1, -0.25 * 9.55)
    require_in_si(for_motor(stated, MOTOR))


def test_what_is_swept_is_in_si_for_a_motor() -> None:
    swept = for_motor(plan(sweep={"operating_point": {"load_torque_of_rated": [0.1, 1.0]}}), MOTOR)
    require_in_si(swept)
    assert [case.operating_point.load_torque_Nm for case in cases(swept)] == pytest.approx([0.955, 9.55])
    assert {case.operating_point.load_torque_of_rated for case in cases(swept)} == {None}


def test_limits_are_in_si_for_a_motor() -> None:
    limits = {
        "torque_mean": {"min_T_N": 0.4, "max_T_N": 0.6, "margin_T_N": 0.01},
        "omega_m_reached": {"max": 1.0, "unit": "omega_m_N"},
        "current_fundamental": {"max_I_N_peak": 0.5, "margin": "U"},
        "torque_ripple_pp": {"max_Nm": 0.1},
    }
    found = for_motor(plan(limits=limits, case_limits={"c": limits}), MOTOR)
    assert found.limits == found.case_limits["c"]
    torque, speed, current, ripple = found.limits.values()
    assert (torque.min, torque.max, torque.margin) == pytest.approx((0.4 * 9.55, 0.6 * 9.55, 0.01 * 9.55))
    assert (speed.max, speed.unit, torque.unit) == (157.1, "rad/s", "Nm")
    assert current.max == pytest.approx(0.5 * math.sqrt(2.0) * 6.7)
    assert (current.margin, current.unit) == ("U", "A")
    assert (ripple.max, ripple.unit) == (0.1, "Nm")


@pytest.mark.parametrize(
    ("limit", "reason"),
    [
        ({"min": 0.06, "max_I_N_peak": 0.07}, "min without a unit beside max_I_N_peak: state min_I_N_peak"),
        ({"min_I_N_peak": 0.06, "max": 0.64}, "max without a unit beside min_I_N_peak"),
        ({"min": 0.64, "max_I_N_peak": 0.07}, "min without a unit"),
        ({"max_I_N_peak": 0.07, "margin": 0.001}, "margin without a unit beside max_I_N_peak"),
        ({"max": 0.64, "margin_I_N_peak": 0.001}, "max without a unit beside margin_I_N_peak"),
    ],
)
def test_a_number_without_a_unit_beside_parts_of_rated_values_is_refused(
    limit: dict[str, float], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        plan(limits={"current_fundamental": limit})


@pytest.mark.parametrize(
    "limit",
    [
        {"min": 0, "max_I_N_peak": 0.5, "margin": 0.0},  # zero is the same in both
        {"min_I_N_peak": 0.0, "max_I_N_peak": 0.5, "margin_I_N_peak": 0},
        {"min": 0.0, "max": 0.5, "unit": "I_N_peak"},
    ],
)
def test_all_numbers_in_parts_of_rated_values_are_in_si_for_a_motor(limit: dict[str, Any]) -> None:
    (found,) = for_motor(plan(limits={"current_fundamental": limit}), MOTOR).limits.values()
    assert (found.min, found.max, found.margin) == pytest.approx((0.0, 0.5 * math.sqrt(2.0) * 6.7, 0.0))


def test_a_plan_in_si_is_left_as_it_is() -> None:
    stated = plan(operating_point={"omega_m_rad_s": 5.0}, limits={"torque_mean": {"max_Nm": 1.0}})
    assert for_motor(stated, MOTOR) == stated
    assert for_motor(stated, MOTOR).model_fields_set == stated.model_fields_set


@pytest.mark.parametrize(
    ("point", "reason"),
    [
        ({"omega_m_of_rated": 0.5, "omega_m_rad_s": 1.0}, "state one thing"),
        ({"omega_m_of_rated": 0.5, "torque_of_rated": 1.0}, "velocity mode has no torque_of_rated"),
        ({"mode": "torque", "hold_speed_of_rated": 0.5, "load_torque_of_rated": 0.1}, "give one of the two"),
        ({}, "velocity mode needs omega_m_rad_s"),
    ],
)
def test_contradictions_are_refused(point: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        plan(operating_point=point)


def test_a_pattern_names_every_profile_that_fits(tmp_path: Path) -> None:
    found = profiles_of("motors/speed_and_load", plan())
    assert found == tuple(each for each in shipped_profiles() if each.startswith("motors/"))
    for name in ("a.toml", "b.toml"):
        (tmp_path / name).write_text("")
    place = tmp_path / "plan.toml"
    place.write_text("")
    assert profiles_of(str(place), plan(profile="?.toml")) == (
        str(tmp_path / "a.toml"),
        str(tmp_path / "b.toml"),
    )
    with pytest.raises(PlanError, match=r"no profile fits 'engines/\*'"):
        profiles_of("motors/speed_and_load", plan(profile="engines/*"))
