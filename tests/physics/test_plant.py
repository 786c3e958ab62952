"""The machine's step: order, energy, harmonics, friction, and the hold of speed and currents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.emulator.machine.coefficients import Machine, holding
from benchtool.emulator.machine.inverter import clarke
from benchtool.emulator.machine.plant import added, airgap_torque, derivative, step
from benchtool.emulator.machine.state import State, place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.emulator.rotate import rotate

SALIENT = MotorTruth(
    pole_pairs=3,
    R_s_ohm=0.3,
    L_d_H=4e-3,
    L_q_H=9e-3,
    psi_r_Wb=0.12,
    J_kgm2=8e-4,
    friction_Nms=1e-3,
    coulomb_Nm=0.05,
    cogging_Nm=(0.08, 0.03),
    cogging_order=(18, 36),
    cogging_phase_rad=(0.0, 0.4),
    psi_5_Wb=0.004,
    psi_7_Wb=-0.002,
)


def run(x: State, machine: Machine, duration: float, steps: int) -> State:
    for _ in range(steps):
        x = step(x, 40.0, 25.0, duration / steps, machine, 0.4)
    return x


@pytest.mark.parametrize(
    "motor",
    [
        SALIENT,
        MotorTruth(
            pole_pairs=4, R_s_ohm=0.123, L_d_H=9.52e-3, L_q_H=9.52e-3, psi_r_Wb=0.1685, J_kgm2=13.1e-4
        ),
    ],
    ids=["salient, imperfect", "paper"],
)
def test_error_falls_with_the_fourth_power_of_the_step(motor: MotorTruth) -> None:
    start, machine = place(3.0, -2.0, 900.0, 0.4), motor.machine()
    exact = run(start, machine, 2e-3, 2048)
    runs = [run(start, machine, 2e-3, steps) for steps in (16, 32, 64)]
    errors = [np.abs(np.subtract(x[:-2], exact[:-2])).max() for x in runs]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx([4.0, 4.0], abs=0.35)


def test_energy_is_conserved_with_every_imperfection() -> None:
    """Electrical input = copper loss + stored energy + mechanical work, cogging and friction within."""
    motor, machine = SALIENT, SALIENT.machine()
    x = place(2.0, 5.0, 60.0, 0.1)
    u_alpha, u_beta, T_load, h = 40.0, 25.0, 0.4, 1e-6
    electrical = copper = shaft = friction = cogging = 0.0
    stored = [_stored(x, motor)]
    for _ in range(4000):
        middle = step(x, u_alpha, u_beta, 0.5 * h, machine, T_load)
        after = step(middle, u_alpha, u_beta, 0.5 * h, machine, T_load)
        for weight, y in ((1 / 6, x), (4 / 6, middle), (1 / 6, after)):  # Simpson
            i_alpha = y.i_d * y.cos_theta - y.i_q * y.sin_theta
            i_beta = y.i_d * y.sin_theta + y.i_q * y.cos_theta
            omega_m = y.omega_e / 3
            electrical += weight * h * 1.5 * (u_alpha * i_alpha + u_beta * i_beta)
            copper += weight * h * 1.5 * 0.3 * (y.i_d**2 + y.i_q**2)
            shaft += weight * h * T_load * omega_m
            coulomb = math.copysign(0.05, y.omega_e)
            friction += weight * h * omega_m * (1e-3 * omega_m + coulomb)
            theta_m = y.theta_e / 3
            detent = 0.08 * math.sin(18 * theta_m) + 0.03 * math.sin(36 * theta_m + 0.4)
            cogging += weight * h * omega_m * detent
        x = after
    stored.append(_stored(x, motor))
    assert electrical > 0.5
    balance = electrical - copper - shaft - friction - cogging - (stored[1] - stored[0])
    assert abs(balance) < 1e-9


def _stored(x: State, motor: MotorTruth) -> float:
    magnetic = 0.75 * (motor.L_d_H * x.i_d**2 + motor.L_q_H * x.i_q**2)
    return magnetic + 0.5 * motor.J_kgm2 * (x.omega_e / motor.pole_pairs) ** 2


def test_torque_is_flux_cross_current() -> None:
    motor = MotorTruth(pole_pairs=4, R_s_ohm=0.1, L_d_H=3e-3, L_q_H=7e-3, psi_r_Wb=0.2, J_kgm2=1e-3)
    i_d, i_q = -4.0, 9.0
    psi_s, i_s = complex(3e-3 * i_d + 0.2, 7e-3 * i_q), complex(i_d, i_q)
    expected = 1.5 * 4 * (psi_s.conjugate() * i_s).imag
    assert airgap_torque(i_d, i_q, 0.3, motor.machine()) == pytest.approx(expected, rel=1e-12)


def test_back_emf_has_the_stated_harmonics() -> None:
    """With open terminals the EMF of phase a is the derivative of psi_r cos + psi_5 cos 5 + psi_7 cos 7."""
    machine, omega_e = SALIENT.machine(), 500.0
    for theta in np.linspace(0.0, 6.0, 13):
        # The voltage at which no current changes is the EMF; v = u / L is what the rates are made of.
        di_d, di_q, *_ = derivative(0.0, 0.0, omega_e, theta, 0.0, 0.0, machine, 0.0)
        e_d, e_q = -di_d * SALIENT.L_d_H, -di_q * SALIENT.L_q_H
        e_a = e_d * math.cos(theta) - e_q * math.sin(theta)
        harmonics = 0.12 * math.sin(theta) + 5 * 0.004 * math.sin(5 * theta) - 7 * 0.002 * math.sin(7 * theta)
        assert e_a == pytest.approx(-omega_e * harmonics, abs=1e-9)


def test_held_speed_and_open_terminals_hold() -> None:
    machine = SALIENT.machine()
    x = advance(place(0.0, 0.0, 300.0, 0.0), 40.0, 0.0, 1e-3, 0.05, holding(machine, True, False), 5.0)
    assert x.omega_e == 300.0
    assert abs(x.i_d) > 1.0
    x = advance(place(0.0, 0.0, 300.0, 0.0), 0.0, 0.0, 1e-3, 0.05, holding(machine, False, True), 0.0)
    assert x.i_d == 0.0
    assert x.i_q == 0.0
    assert x.omega_e < 300.0


def test_coulomb_friction_stops_the_shaft_and_holds_it() -> None:
    motor = MotorTruth(
        pole_pairs=2, R_s_ohm=1.0, L_d_H=1e-3, L_q_H=1e-3, psi_r_Wb=0.1, J_kgm2=1e-3, coulomb_Nm=0.1
    )
    free = holding(motor.machine(), False, True)
    x = advance(place(0.0, 0.0, 20.0, 0.0), 0.0, 0.0, 0.09, 0.05, free, 0.0)
    assert x.omega_e / 2 == pytest.approx(10.0 - 0.1 / 1e-3 * 0.09, rel=1e-9)
    x = advance(x, 0.0, 0.0, 0.1, 0.05, free, 0.0)
    assert x.omega_e == 0.0
    assert x.theta_e / 2 == pytest.approx(10.0**2 / 2 / (0.1 / 1e-3), rel=1e-9)


def test_turning_is_exact_to_rounding() -> None:
    for angle in (0.0, 1e-9, -0.013, 0.05, -0.0500001, 2.0):
        cosine, sine = rotate(math.cos(0.7), math.sin(0.7), angle)
        assert cosine == pytest.approx(math.cos(0.7 + angle), abs=3e-16)
        assert sine == pytest.approx(math.sin(0.7 + angle), abs=3e-16)


def test_compensated_sum_keeps_what_rounding_would_lose() -> None:
    total, rest, plain = 1000.0, 0.0, 1000.0
    for _ in range(10_000):
        total, rest = added(total, rest, 1e-13)
        plain += 1e-13
    assert total == pytest.approx(1000.0 + 1e-9, abs=2e-13)
    assert plain != total


def test_clarke_is_amplitude_invariant() -> None:
    phases = [5.0 * math.cos(1.1 - 2 * math.pi * k / 3) for k in range(3)]
    assert clarke(*phases) == pytest.approx((5.0 * math.cos(1.1), 5.0 * math.sin(1.1)))
