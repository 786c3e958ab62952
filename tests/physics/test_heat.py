"""Temperatures of two masses and iron loss, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.coefficients import holding, warmed
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.plant import advance
from benchtool.emulator.machine.saturation import SaturationTruth, flux_at
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.truth import MotorTruth
from tests.physics.paper_machine import make_core
from tests.physics.test_asymmetry import MOTOR, NO_TRIP, WIDE
from tests.physics.test_saturation import MADE, SYMMETRIC

T_S = 1e-4
# Masses of millijoules, so that some ticks make some kelvin.
SMALL = HeatTruth(
    C_winding_J_K=2e-3,
    C_body_J_K=5e-3,
    R_winding_body_K_W=0.8,
    R_body_ambient_K_W=2.0,
    ambient_degC=30.0,
    alpha_R_1_K=0.0,
    alpha_psi_1_K=0.0,
)


def closed_form(truth: HeatTruth, copper_W: float, iron_W: float, time_s: float) -> Any:
    G, G_a = 1.0 / truth.R_winding_body_K_W, 1.0 / truth.R_body_ambient_K_W
    per_C = np.diag([1.0 / truth.C_winding_J_K, 1.0 / truth.C_body_J_K])
    A, b = per_C @ np.array([[-G, G], [G, -G - G_a]]), per_C @ np.array([copper_W, iron_W])
    system = np.zeros((3, 3))
    system[:2, :2], system[:2, 2] = A, b
    return truth.ambient_degC + expm(system * time_s)[:2, 2]


def test_two_masses_warm_as_their_closed_form() -> None:
    """Direct current at standstill: 1.5 R i^2 in the winding, nothing in the iron."""
    motor = {"L_d_H": 1e-3, "L_q_H": 1e-3, "R_s_ohm": 0.4, "psi_r_Wb": 0.0, "heat": SMALL}
    core = make_core(motor=motor, inverter={"u_dc_V": 60.0}, sensors=WIDE, parameters=NO_TRIP)
    core.load.held, core.command.pwm_enabled = 1, 1
    u = 0.4 * 9.0  # of the a axis, that holds 9 A
    core.shaft.i_d = 9.0
    for _ in range(100):
        core._controls["gated"] = 1
        core._controls["duty_a"] = 1.5 * u / 60.0
        core._controls["duty_b"] = core._controls["duty_c"] = 0.0
        core.run_with(run_ticks, 1)
    copper_W = core.energies.now_J()["copper"] / (100 * T_S)
    assert copper_W == pytest.approx(1.5 * 0.4 * 81.0, rel=1e-2)
    expected = closed_form(SMALL, copper_W, 0.0, 100 * T_S)
    assert (core.shaft.T_winding, core.shaft.T_magnet) == pytest.approx(tuple(expected), abs=0.05)
    assert core.shaft.T_winding > 90.0


def test_a_tick_is_the_closed_form_of_a_tick() -> None:
    """Masses of a real motor, whose temperatures change by a millionth in a tick."""
    truth = HeatTruth(C_winding_J_K=400.0, C_body_J_K=3000.0, R_winding_body_K_W=0.3, R_body_ambient_K_W=0.9)
    heat = truth.heat(T_S, 0.0)
    by_loss = np.array([[heat.w_copper, heat.w_iron], [heat.m_copper, heat.m_iron]])
    for column, losses in enumerate(((1.0, 0.0), (0.0, 1.0))):
        expected = closed_form(truth, *losses, T_S) - truth.ambient_degC
        assert by_loss[:, column] == pytest.approx(expected, rel=1e-6, abs=1e-14)
    x = np.array([80.0, 35.0])
    for _ in range(3):
        x = x + np.array([[heat.ww, heat.wm], [heat.mw, heat.mm]]) @ x
    A = np.array([[-1 / 0.3, 1 / 0.3], [1 / 0.3, -1 / 0.3 - 1 / 0.9]]) / np.array([[400.0], [3000.0]])
    assert x == pytest.approx(expm(A * 3 * T_S) @ np.array([80.0, 35.0]), rel=1e-13)


def test_resistance_and_rotor_flux_follow_their_temperatures() -> None:
    heat = HeatTruth(
        C_winding_J_K=1.0,
        C_body_J_K=1.0,
        R_winding_body_K_W=1.0,
        R_body_ambient_K_W=1.0,
        reference_degC=20.0,
    ).heat(T_S, 0.05)
    cold = MotorTruth(**MOTOR).machine(devices_ohm=0.05)
    hot = warmed(heat, holding(cold, True, False), 120.0, 70.0)
    assert hot.R_s == pytest.approx(0.05 + 0.3 * 1.393)
    assert hot.psi_r == pytest.approx(cold.psi_r * (1.0 - 0.055))
    assert hot.harmonics is not None
    assert hot.harmonics.psi_5 == pytest.approx(0.006 * 0.945)
    assert hot.gamma == 0.0
    saturated = MotorTruth(**SYMMETRIC, saturation=SaturationTruth(**MADE)).machine()
    weak = warmed(heat, saturated, 20.0, 70.0).saturation
    assert weak is not None
    assert flux_at(weak, 0.0, 0.0, None) == pytest.approx((0.12 * 0.945, 0.0), abs=1e-12)


def test_iron_loss_brakes_a_coasting_machine() -> None:
    """With open terminals J d omega/dt = -3/2 p^2 psi_r^2 / R_fe omega."""
    motor = MotorTruth(**SYMMETRIC, R_fe_ohm=50.0)
    x = advance(place(0.0, 0.0, 900.0, 0.0), 0.0, 0.0, 0.02, 0.05, holding(motor.machine(), False, True), 0.0)
    rate = 1.5 * 3**2 * 0.12**2 / 50.0 / 8e-4
    assert x.omega_e == pytest.approx(900.0 * math.exp(-rate * 0.02), rel=1e-9)


def test_iron_loss_is_that_of_a_resistance_across_the_emf() -> None:
    """At steady speed the braking power is 3/2 |omega_e psi_s|^2 / R_fe, whatever the currents."""
    core = make_core(
        motor={**SYMMETRIC, "R_fe_ohm": 50.0},
        inverter={"u_dc_V": 300.0, "energy_accounts": True},
        sensors=WIDE,
        parameters=NO_TRIP,
    )
    core.load.held, core.load.omega_m_rad_s = 1, 200.0
    core.run_with(run_ticks, 5)
    assert core.energies.now_J()["iron"] == pytest.approx(
        5 * T_S * 1.5 * (600.0 * 0.12) ** 2 / 50.0, rel=1e-9
    )
    assert core.energies.now_J()["shaft"] == pytest.approx(-core.energies.now_J()["iron"], rel=1e-12)
