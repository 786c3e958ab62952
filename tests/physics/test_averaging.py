"""A PWM period by its mean and the moments of its ripple, against the period edge by edge."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.averaging import averaged, first_moment, overlap
from benchtool.emulator.machine.inverter import clarke
from benchtool.emulator.machine.plant import step
from benchtool.emulator.machine.state import State, place
from benchtool.emulator.machine.truth import MotorTruth
from tests.physics.alpha_beta import Reference, centred, gates
from tests.physics.paper_machine import make_core

ROUND = MotorTruth(pole_pairs=4, R_s_ohm=0.123, L_d_H=9.52e-3, L_q_H=9.52e-3, psi_r_Wb=0.1685, J_kgm2=13.1e-4)
SALIENT = MotorTruth(
    pole_pairs=3, R_s_ohm=0.3, L_d_H=4e-3, L_q_H=9e-3, psi_r_Wb=0.12, J_kgm2=8e-4, friction_Nms=1e-3
)
RICH = replace(SALIENT, psi_5_Wb=5e-3, psi_7_Wb=-3e-3, psi_11_Wb=1e-3, psi_13_Wb=8e-4)
U_DC, T_LOAD = 122.5, 0.4
motors = pytest.mark.parametrize("motor", [ROUND, SALIENT, RICH], ids=["round", "salient", "harmonics"])


def reference(motor: MotorTruth) -> Reference:
    return Reference(
        p=motor.pole_pairs,
        R=motor.R_s_ohm,
        L_d=motor.L_d_H,
        L_q=motor.L_q_H,
        harmonics={
            1: motor.psi_r_Wb,
            5: motor.psi_5_Wb,
            7: motor.psi_7_Wb,
            11: motor.psi_11_Wb,
            13: motor.psi_13_Wb,
        },
        J=motor.J_kgm2,
        B=motor.friction_Nms,
        T_load=T_LOAD,
        u_dc=U_DC,
    )


def between_edges(motor: MotorTruth, x: State, duties: tuple[float, float, float], T_s: float) -> Any:
    """(i_d, i_q, omega_m, theta_e) after the period, by scipy in stator coordinates, from edge to edge."""
    other = reference(motor)
    legs = [gates(centred([duty], T_s), T_s, 0.0) for duty in duties]
    edges = sorted({0.0, T_s, *(at for leg in legs for at, _ in leg if 0.0 < at < T_s)})
    y = other.state(x.i_d, x.i_q, x.omega_e / motor.pole_pairs, x.theta_e)
    for start, end in pairwise(edges):
        modes = [next(mode for at, mode in reversed(leg) if at <= start) for leg in legs]
        y = other.run(y, (start, end), modes)
    return np.array([*other.dq(y), y[2], y[3]])


def slow(motor: MotorTruth, omega_e: float) -> float:
    """A speed; a quarter of it where harmonics turn twelve times as fast."""
    return 0.25 * omega_e if motor is RICH else omega_e


def of(motor: MotorTruth, x: State) -> Any:
    return np.array([x.i_d, x.i_q, x.omega_e / motor.pole_pairs, x.theta_e])


duty = st.integers(0, 1000).map(lambda steps: steps / 1000)  # scipy fails where edges almost meet


@motors
@settings(max_examples=15)
@given(duties=st.tuples(duty, duty, duty), omega_e=st.floats(-700.0, 700.0), theta=st.floats(0.0, 6.0))
def test_a_period_ends_where_another_integration_in_other_coordinates_does(
    motor: MotorTruth, duties: tuple[float, float, float], omega_e: float, theta: float
) -> None:
    x = place(-2.0, 4.0, slow(motor, omega_e), theta)
    after, _ = averaged(x, duties, U_DC, 1e-4, motor.machine(), T_LOAD, False)
    expected = between_edges(motor, x, duties, 1e-4)
    assert of(motor, after) == pytest.approx(expected, rel=1e-8, abs=3e-7)


def finely(motor: MotorTruth, x: State, duties: tuple[float, float, float], T_s: float) -> Any:
    """The same by the machine's own step, so short that it leaves nothing."""
    machine = motor.machine()
    edges = np.unique([0.0, T_s, *(0.5 * (1.0 + side * each) * T_s for each in duties for side in (-1, 1))])
    for start, end in pairwise(edges):
        middle = 0.5 * (start + end)
        legs = [U_DC if abs(middle - 0.5 * T_s) < 0.5 * each * T_s else 0.0 for each in duties]
        for _ in range(12):
            x = step(x, *clarke(*legs), (end - start) / 12, machine, T_LOAD)
    return of(motor, x)


@motors
def test_what_is_left_out_is_of_the_fifth_order(motor: MotorTruth) -> None:
    x, duties = place(-2.0, 4.0, slow(motor, 600.0), 0.7), (0.72, 0.35, 0.18)
    errors = []
    for T_s in (8e-4, 4e-4, 2e-4, 1e-4):
        after, _ = averaged(x, duties, U_DC, T_s, motor.machine(), T_LOAD, False)
        errors.append(np.abs(of(motor, after) - finely(motor, x, duties, T_s)).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 4.5).all()


@motors
def test_the_charge_drawn_is_power_over_voltage(motor: MotorTruth) -> None:
    """What is taken from the link turns the shaft and is stored, in windings without resistance."""
    p = motor.pole_pairs
    lossless = replace(motor, R_s_ohm=0.0, friction_Nms=0.0)
    x = place(-2.0, 4.0, slow(motor, 300.0), 0.7)
    after, charge = averaged(x, (0.72, 0.35, 0.18), U_DC, 1e-4, lossless.machine(), T_LOAD, True)

    def stored(x: State) -> float:
        magnetic = 0.75 * (motor.L_d_H * x.i_d**2 + motor.L_q_H * x.i_q**2)
        return magnetic + 0.5 * motor.J_kgm2 * (x.omega_e / p) ** 2

    shaft = T_LOAD * (after.theta_e - x.theta_e) / p
    assert U_DC * charge == pytest.approx(stored(after) - stored(x) + shaft, rel=1e-4)
    assert averaged(x, (0.72, 0.35, 0.18), U_DC, 1e-4, motor.machine(), T_LOAD, False)[1] == 0.0


@settings(max_examples=30)
@given(duty_1=duty, duty_2=duty)
def test_moments_of_the_ripple_are_its_integrals(duty_1: float, duty_2: float) -> None:
    """Of polynomials between the edges, which Gauss and Legendre's three points integrate exactly."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    edges = np.unique([0.0, 0.5, 1.0, *(0.5 * (1.0 + s * d) for d in (duty_1, duty_2) for s in (-1, 1))])
    t = (0.5 * (edges[:-1] + edges[1:])[:, None] + 0.5 * np.diff(edges)[:, None] * nodes).ravel()
    weight = (0.5 * np.diff(edges)[:, None] * weights).ravel()
    w = [np.clip(t - 0.5 * (1.0 - d), 0.0, d) - d * t for d in (duty_1, duty_2)]
    assert first_moment(duty_1) == pytest.approx(float(weight @ ((t - 0.5) * w[0])), abs=1e-15)
    assert overlap(duty_1, duty_2) == pytest.approx(float(weight @ (w[0] * w[1])), abs=1e-15)


@pytest.mark.parametrize("motor", [{}, {"L_d_H": 5e-3, "coulomb_Nm": 0.3, "breakaway_Nm": 0.4}])
def test_a_loop_is_the_same_while_a_transducer_asks_for_the_edges(motor: dict[str, float]) -> None:
    """From rest, against friction that holds the shaft at first."""
    states = []
    for watched in (False, True):
        core = make_core(motor=motor)
        core.memory["torque_command"], core.command.pwm_enabled = 2.0, 1
        core.load.torque_Nm = -0.2
        if watched:
            core.transducer.start(60)
        core.run_with(run_ticks, 60)
        states.append([float(core.shaft[name]) for name in ("i_d", "i_q", "omega_m", "theta_e")])
    assert states[0][2] > 0.5
    assert states[0] == pytest.approx(states[1], rel=1e-8, abs=1e-9)
    assert states[0] != states[1]
