"""Harmonics of the rotor flux and phases that differ, against phase variables: see `alpha_beta`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.plant import airgap_torque, derivative
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.truth import MotorTruth
from tests.physics.alpha_beta import OFF, PHASES, Reference, centred, gates
from tests.physics.paper_machine import FINE, make_core

T_S = 1e-4
HARMONICS = {5: 0.006, 7: -0.004, 11: 0.002, 13: 0.0015}
PHASE: dict[str, Any] = {
    "psi_of_phase": (1.02, 0.95, 1.0),
    "series_R": (0.0, 0.15, 0.05),
    "series_L": (8e-4, 0.0, 3e-4),
}
MOTOR: dict[str, Any] = {
    "pole_pairs": 3,
    "R_s_ohm": 0.3,
    "L_d_H": 4e-3,
    "L_q_H": 9e-3,
    "psi_r_Wb": 0.12,
    "J_kgm2": 8e-4,
    **{f"psi_{order}_Wb": psi for order, psi in HARMONICS.items()},
    "psi_of_phase": PHASE["psi_of_phase"],
    "series_R_ohm": PHASE["series_R"],
    "series_L_H": PHASE["series_L"],
}
WIDE: dict[str, Any] = {**FINE, "i_full_scale_A": 1000.0, "u_full_scale_V": 2000.0}
NO_TRIP: dict[str, Any] = {"i_trip": 900.0, "omega_m_trip": 1e5, "u_dc_min": 0.0, "u_dc_max": 2000.0}


def reference(**given: Any) -> Reference:
    return Reference(
        p=3, R=0.3, L_d=4e-3, L_q=9e-3, harmonics={1: 0.12, **HARMONICS}, J=8e-4, **PHASE, **given
    )


def core_with(inverter: dict[str, Any], i_d: float, i_q: float, omega_m: float) -> Core:
    core = make_core(motor=MOTOR, inverter=inverter, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = i_d, i_q, omega_m
    return core


def state_of(core: Core) -> tuple[float, float, float, float]:
    return core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m, core.shaft.theta_e


def over_duties(reference: Reference, y: Any, duties: Any, dead_time: float) -> Any:
    """The reference's state after these PWM periods."""
    end = len(duties) * T_S
    legs = [gates(centred(list(duties[:, k]), T_S), end, dead_time) for k in range(3)]
    return reference.follow(y, legs, end)


def run_duties(core: Core, duties: NDArray[np.float64]) -> None:
    core.command.pwm_enabled = 1
    for row in duties:
        core._controls["gated"] = 1
        for name, duty in zip(("duty_a", "duty_b", "duty_c"), row, strict=True):
            core._controls[name] = duty
        assert core.run_with(run_ticks, 1) == 1


@pytest.mark.parametrize("imperfect", [False, True], ids=["ideal inverter", "dead time and drops"])
def test_agrees_with_phase_variables(imperfect: bool) -> None:
    rng = np.random.default_rng(5)
    duties = rng.choice([0.0, 1.0, 0.004, 0.5, 0.7, 0.3], (8, 3))
    dead_time, drop = (2e-6, 1.2) if imperfect else (0.0, 0.0)
    core = core_with({"u_dc_V": 60.0, "dead_time_s": dead_time, "device_drop_V": drop}, 2.0, -3.0, 60.0)
    run_duties(core, duties)
    other = reference(u_dc=60.0, drop=drop)
    y = over_duties(other, other.state(2.0, -3.0, 60.0, 0.0), duties, dead_time)
    within = 1e-5 if imperfect else 2e-8
    assert state_of(core) == pytest.approx((*other.dq(y), y[2], y[3]), abs=within, rel=within)


def test_rectifies_as_phase_variables_do() -> None:
    core = core_with({"u_dc_V": 60.0, "device_drop_V": 0.8}, 0.0, 0.0, 300.0)
    core.load.held, core.load.omega_m_rad_s = 1, 300.0
    other = reference(u_dc=60.0, drop=0.8, held=True)
    y = other.state(0.0, 0.0, 300.0, 0.0)
    core.run_with(run_ticks, 12)
    for k in range(12):
        y = other.run(y, (k * T_S, (k + 1) * T_S), (OFF, OFF, OFF))
    assert state_of(core)[:2] == pytest.approx(other.dq(y), abs=5e-3)
    assert abs(core.shaft.i_d) > 2.0


def test_emf_of_each_phase_is_the_slope_of_its_flux() -> None:
    machine, omega_e = MotorTruth(**MOTOR).machine(), 500.0
    for theta in np.linspace(0.0, 6.0, 13):
        di_d, di_q, *_ = derivative(0.0, 0.0, omega_e, theta, 0.0, 0.0, machine, 0.0)
        L = reference().inductance(theta)
        c, s = math.cos(theta), math.sin(theta)
        e = -L @ np.array([di_d * c - di_q * s, di_d * s + di_q * c])
        h = 1e-5
        slope = (reference().rotor_flux(theta + h) - reference().rotor_flux(theta - h)) / (2 * h)
        assert PHASES @ e == pytest.approx(PHASES @ slope * omega_e, abs=1e-6)


def test_torque_is_the_slope_of_the_coenergy() -> None:
    machine = MotorTruth(**MOTOR).machine()
    for theta in np.linspace(0.0, 6.0, 13):
        x = place(-4.0, 9.0, 0.0, theta)
        i = np.array([-4.0 * x.cos_theta - 9.0 * x.sin_theta, -4.0 * x.sin_theta + 9.0 * x.cos_theta])
        assert airgap_torque(-4.0, 9.0, theta, machine) == pytest.approx(
            reference().torque(i, theta), abs=1e-8
        )
