"""Which parameter is named as wrong."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.balances.deviations import contradictions, deviations, shared_cause, undefined
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR

BELIEVED = {"R_s": 0.1, "L_d": 1e-2, "L_q": 1e-2, "psi_r": 0.1, "J": 1e-3}


def measured(name: str, value: float, standard: float = 0.0) -> Measurement:
    prefix = "motion_balance" if name in ("J", "friction", "coulomb") else "flux_balance"
    return Measurement(f"{prefix}_{name}", value, "", "", uncertainty=Uncertainty(standard, "scatter"))


def named(*estimates: Measurement) -> list[str]:
    found = deviations(estimates, BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    return [each.name for each in contradictions(found)]


def test_what_differs_beyond_three_uncertainties_and_the_tolerance_is_named_the_plainest_first() -> None:
    assert named(measured("R_s", 0.12, 0.002), measured("L_d", 1.2e-2, 1e-5), measured("psi_r", 0.1005)) == [
        "L_d",
        "R_s",
    ]


@pytest.mark.parametrize(
    ("name", "value", "standard"),
    [
        ("R_s", 0.12, 0.007),
        ("R_s", 0.104, 0.0001),
        ("psi_r", 0.1009, 1e-6),
        ("encoder_offset", math.radians(0.9), 1e-6),
        ("dead_time_voltage", 0.19, 1e-6),
        ("friction", 4e-5, 1e-9),
        ("coulomb", 9e-3, 1e-9),
        ("current_gain_b", 4e-3, 1e-9),
        ("J", math.nan, 0.0),
    ],
)
def test_what_is_uncertain_or_small_or_untold_is_not_named(name: str, value: float, standard: float) -> None:
    assert named(measured(name, value, standard)) == []


def test_one_factor_in_all_impedances_points_at_a_sensor() -> None:
    off = [measured(name, 1.04 * value, 1e-3 * value) for name, value in BELIEVED.items() if name != "J"]
    currents = deviations(
        [*off[:3], measured("psi_r", 0.1)], {**BELIEVED, "R_s": 0.08}, EXAMPLE_MOTOR, u_dc_V=100.0
    )
    assert shared_cause(contradictions(currents)) == ""
    off[0] = measured("R_s", 1.06 * 0.1, 1e-2 * 0.1)
    found = deviations(off, BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    assert "dc link" in shared_cause(contradictions(found))
    found = deviations([*off[:3], measured("psi_r", 0.1)], BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    assert "current sensors" in shared_cause(contradictions(found))


def test_what_is_not_told_keeps_its_reason() -> None:
    lost = Measurement.undefined("flux_balance_L_q", "H", "", "capture a second torque")
    found = deviations([lost], BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    assert list(undefined(found)) == [("L_q", "capture a second torque")]
    assert str(deviations([measured("R_s", 0.12)], BELIEVED, EXAMPLE_MOTOR, 100.0)[0]).endswith("+20 %")


@pytest.mark.parametrize(("dof", "is_named"), [(1.0, False), (3.0, False), (30.0, True), (math.inf, True)])
def test_few_degrees_of_freedom_ask_for_a_larger_difference(dof: float, is_named: bool) -> None:
    """0.35 is six standard uncertainties of 0.06: within U of one degree of freedom, and little beyond three
    standard uncertainties of the many."""
    uncertain = Uncertainty(0.06, "scatter", dof)
    estimate = Measurement("flux_balance_R_s", 0.45, "ohm", "", uncertainty=uncertain)
    (found,) = deviations([estimate], BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    assert found.contradicts == is_named
    assert found.threshold > uncertain.expanded


def test_three_standard_uncertainties_of_many_degrees_of_freedom_are_the_threshold() -> None:
    (found,) = deviations([measured("R_s", 0.12, 0.007)], BELIEVED, EXAMPLE_MOTOR, u_dc_V=100.0)
    assert found.threshold == pytest.approx(3.0 * 0.007)
