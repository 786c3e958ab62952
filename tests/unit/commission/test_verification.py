"""What the balance of the verification run contradicts."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.known import Known
from benchtool.commission.steps.verification import Verification, sound_balance
from benchtool.errors import AnalysisError
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import Value
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.excited_machine import U_DC, excited_capture

KNOWN = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
R_S = KNOWN.identified.R_s_ohm
SWING = Verification().plan(KNOWN)[0]
SWING_A = math.sqrt(SWING.squares_A2s / (SWING.request.rows * KNOWN.control_period_s))


def told(R_s_ohm: float) -> dict[str, Measurement]:
    certain = Uncertainty(0.001 * R_S, "scatter", 10.0)
    assert SWING.stimulus is not None
    return {
        "flux_balance_R_s": Measurement("flux_balance_R_s", R_s_ohm, "ohm", "", uncertainty=certain),
        "speed_reached": Measurement("speed_reached", SWING.stimulus.amplitude, "rad/s", ""),
    }


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_resistance_is_contradicted_beyond_what_dead_time_makes_at_the_current_of_the_swing(
    sign: float,
) -> None:
    known = KNOWN.with_drop(0.4 * R_S * SWING_A)
    lost_ohm = 0.5 * abs(known.drop_fundamental_V) / SWING_A
    assert not Verification().findings(told(R_S + sign * 0.9 * lost_ohm), known)
    (finding,) = Verification().findings(told(R_S + sign * 1.1 * lost_ohm), known)
    assert "R_s" in finding.what


def test_without_dead_time_a_resistance_that_is_a_fifth_off_is_contradicted() -> None:
    assert Verification().findings(told(1.2 * R_S), KNOWN)


@pytest.mark.parametrize("J_is_told", [False, True])
def test_an_inertia_is_compared_with_one_that_a_step_told_and_not_with_the_nameplates(
    J_is_told: bool,
) -> None:
    J, certain = KNOWN.motor.J_kgm2, Uncertainty(1e-8, "scatter", 10.0)
    own = Measurement("J", J, "kgm2", "", uncertainty=certain)
    other = Measurement("motion_balance_J", 0.8 * J, "kgm2", "", uncertainty=certain)
    known = KNOWN.with_estimates({"J": own}) if J_is_told else KNOWN
    findings = Verification().findings(told(R_S) | {other.name: other}, known)
    assert [each.what.split("run, ")[1][:4] for each in findings] == (["J is"] if J_is_told else [])


@pytest.mark.parametrize("off", [-0.08, 0.08])
def test_an_inertia_is_compared_with_what_dead_time_does_between_samples(off: float) -> None:
    """A small servo with 1 V of dead time came out 8 % off: it moves the mean current within a period."""
    J, certain = KNOWN.motor.J_kgm2, Uncertainty(1e-8, "scatter", 10.0)
    own = Measurement("J", J, "kgm2", "", uncertainty=certain)
    other = Measurement("motion_balance_J", (1.0 + off) * J, "kgm2", "", uncertainty=certain)
    known = KNOWN.with_estimates({"J": own})
    motor = KNOWN.identified
    swing_V = (
        0.5 * (motor.L_d_H + motor.L_q_H) / KNOWN.control_period_s * SWING_A
    )  # makes its current in a period
    for share, contradicts in ((0.1, True), (0.5, False)):
        findings = Verification().findings(told(R_S) | {other.name: other}, known.with_drop(share * swing_V))
        assert bool(findings) is contradicts


def test_a_balance_that_takes_the_resistance_for_dead_time_tells_nothing() -> None:
    """A hub motor of 0.24 ohm with 1.4 V of dead time was balanced by -0.15 ohm and 2.2 V."""
    known = KNOWN.with_drop(1.4)

    def balance(dead_time_V: float, standard_V: float) -> list[Measurement]:
        certain = Uncertainty(standard_V, "scatter", 10.0)
        name = "flux_balance_dead_time_voltage"
        return [*told(R_S).values(), Measurement(name, dead_time_V, "V", "", uncertainty=certain)]

    for dead_time_V, standard_V in ((1.3, 0.01), (0.8, 0.01), (2.2, 0.3)):
        assert len(sound_balance(balance(dead_time_V, standard_V), known)) == 3
    for dead_time_V in (2.2, 0.6, 0.0):
        with pytest.raises(AnalysisError, match=r"for dead time, several levels of current have told 1\.4 V"):
            sound_balance(balance(dead_time_V, 0.04), known)
    assert sound_balance([], known) == []


def test_the_balances_know_the_step_that_a_commissioning_assumes_of_the_dc_link() -> None:
    """A link at rest reads the same in every sample, and shows none."""
    known = replace(KNOWN, motor=EXAMPLE_MOTOR, u_dc_V=U_DC, u_dc_full_scale_V=1024.0)
    assert known.link_step_V == 1.0
    found = Verification().estimate([excited_capture()], known)["flux_balance_psi_r"]
    assert found.uncertainty is not None
    by_step = 1.0 / math.sqrt(12.0) / U_DC * found.value
    (line,) = (each for each in found.uncertainty.budget if "u_dc" in each.name)
    assert line.standard == pytest.approx(by_step, rel=0.01)


def test_what_the_balance_leaves_unexplained_is_in_its_estimates() -> None:
    held: dict[str, Value] = {"law": "tpc", "u_s": 80.0, "T_k_ratio": 0.7}
    known = replace(KNOWN, motor=EXAMPLE_MOTOR, u_dc_V=U_DC, u_dc_full_scale_V=1024.0, held=held)
    found = Verification().estimate([excited_capture()], known)
    lines = {
        name: [line.standard for line in each.uncertainty.budget if line.name == "voltage left unexplained"]
        for name, each in found.items()
        if each.uncertainty is not None
    }
    by_name = {name: each[0] for name, each in lines.items() if each}
    assert {name.removeprefix("flux_balance_") for name in by_name} >= {"R_s", "L_d", "L_q", "psi_r"}
    assert by_name["flux_balance_encoder_offset"] == pytest.approx(
        by_name["flux_balance_psi_r"] / EXAMPLE_MOTOR.psi_r_Wb
    )


def test_a_law_that_modulates_has_no_ripple_that_tells_inductances() -> None:
    """Of a motor of 31 uH they were 14 % off, with a stated uncertainty of 6 %."""
    known = replace(KNOWN, motor=EXAMPLE_MOTOR, u_dc_V=U_DC, u_dc_full_scale_V=1024.0, held={"law": "foc"})
    found = Verification().estimate([excited_capture()], known)
    assert math.isfinite(found["flux_balance_R_s"].value)
    for name in ("flux_balance_L_d", "flux_balance_L_q"):
        assert math.isnan(found[name].value)
        assert "law foc" in found[name].reason


@pytest.mark.parametrize(("psi_5_Wb", "told"), [(0.0, True), (5e-4, False)])
def test_a_friction_beside_harmonics_that_brake_is_none(psi_5_Wb: float, told: bool) -> None:
    certain = Uncertainty(1e-4, "scatter", 10.0)
    harmonics = Measurement("psi_5_cos", psi_5_Wb, "Wb", "", uncertainty=certain)
    known = replace(KNOWN, motor=EXAMPLE_MOTOR, u_dc_V=U_DC, u_dc_full_scale_V=1024.0).with_estimates(
        {"psi_5_cos": harmonics}
    )
    found = Verification().estimate([excited_capture()], known)["motion_balance_friction"]
    assert math.isfinite(found.value) is told or "brake the shaft" not in found.reason
    assert ("brake the shaft" in found.reason) is not told


def test_an_inertia_is_as_uncertain_as_the_rotor_flux_that_makes_the_torque() -> None:
    psi_Wb = EXAMPLE_MOTOR.psi_r_Wb
    psi_r = Measurement("psi_r", psi_Wb, "Wb", "", uncertainty=Uncertainty(0.003 * psi_Wb, "fit"))
    known = replace(KNOWN, motor=EXAMPLE_MOTOR, u_dc_V=U_DC, u_dc_full_scale_V=1024.0)
    found = Verification().estimate([excited_capture()], known.with_estimates({"psi_r": psi_r}))
    J = found["motion_balance_J"]
    assert J.uncertainty is not None
    (line,) = (each for each in J.uncertainty.budget if each.name == "rotor flux of its own step")
    assert line.standard == pytest.approx(0.003 * J.value)
