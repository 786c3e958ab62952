"""Motor and sensors: currents, back-EMF, speed, and what the standard's objects tell of them."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from benchtool.acceptance import Measure
from benchtool.acceptance.suite.conditions import (
    electrical_angle,
    making_torque,
    mean_of_periods,
    number,
    phasor,
    quiet,
    rating,
    recorded,
    require_objects,
)
from benchtool.bench import Session
from benchtool.protocol import Mode

pytestmark = pytest.mark.requirement("ACC-MOTOR")

_PHASES = ("i_a", "i_b", "i_c")
_HALF_TICKS = (
    1.5  # from a row to the middle of the period that its voltage is for: one of delay, half of a period
)


def test_current_offsets(bench_session: Session, measure: Measure) -> None:
    """With the power stage off the current sensors read nothing."""
    require_objects(bench_session, *_PHASES)
    limits = rating(bench_session)
    block, _ = recorded(bench_session, 0.05, _PHASES)
    for name in _PHASES:
        offset = float(np.mean(block.column(name))) / limits.current_A
        measure(f"{name}_offset", offset, "I_N_peak", min=-0.01, max=0.01)


def test_phases_are_alike(bench_session: Session, measure: Measure) -> None:
    """The currents of the three phases add up to nothing and are alike: their sensors have one gain."""
    require_objects(bench_session, *_PHASES, "theta_m", "switching_count")
    limits = rating(bench_session)
    omega = 0.5 * limits.omega_m_rad_s
    with making_torque(bench_session, 0.9 * limits.torque_Nm, omega):
        block, _ = recorded(
            bench_session, 3.5 * limits.period_s(omega), (*_PHASES, "theta_m", "switching_count")
        )
    theta_e = electrical_angle(block, limits.pole_pairs)
    a, b, c = (phasor(block.column(name), theta_e) for name in _PHASES)
    turn = cmath.exp(2j * math.pi / 3.0)
    positive, negative, zero = (
        abs(a + b * turn + c * turn**2) / 3.0,
        abs(a + b * turn**2 + c * turn) / 3.0,
        abs(a + b + c) / 3.0,
    )
    measure("current_zero_sequence", zero / positive, "", max=0.008)
    measure("current_negative_sequence", negative / positive, "", max=0.02)
    offset = max(abs(mean_of_periods(block.column(name), theta_e)) for name in _PHASES)
    measure("current_dc_part", offset / limits.current_A, "I_N_peak", max=0.03)
    i_q = 0.9 * limits.torque_Nm / (1.5 * limits.pole_pairs * bench_session.profile.motor.psi_r_Wb)
    measure("current_for_the_torque", positive / i_q, "", min=0.5, max=1.1)
    counted = block.column("switching_count")
    measure("switchings", float(counted[-1] - counted[0]), min=3.0)


@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["forward", "backward"])
def test_back_emf(bench_session: Session, measure: Measure, direction: float) -> None:
    """Without torque the voltage is the back-EMF of the profile's flux, where the encoder says it is."""
    require_objects(bench_session, "u_alpha", "u_beta", "theta_m", "omega_m")
    limits = rating(bench_session)
    omega = direction * limits.omega_m_rad_s
    with making_torque(bench_session, 0.0, omega):
        block, _ = recorded(
            bench_session, 8.0 * limits.period_s(omega), ("u_alpha", "u_beta", "theta_m", "omega_m")
        )
    theta_e = electrical_angle(block, limits.pole_pairs)
    omega_e = limits.pole_pairs * float(np.mean(block.column("omega_m")))
    middle = theta_e + _HALF_TICKS * omega_e * limits.control_period_s
    u = np.mean((block.column("u_alpha") + 1j * block.column("u_beta")) * np.exp(-1j * middle))
    psi = complex(u) / (1j * omega_e)
    motor = bench_session.profile.motor
    measure("flux_linkage", abs(psi) / motor.psi_r_Wb, "", min=0.95, max=1.05)
    measure("encoder_offset_e", cmath.phase(psi), "rad", min=-0.05, max=0.05)


def test_speed_by_the_angle(bench_session: Session, measure: Measure) -> None:
    """Speed and angle tell the same, and the speed is that of the load machine."""
    require_objects(bench_session, "theta_m", "omega_m")
    limits = rating(bench_session)
    omega = 0.7 * limits.omega_m_rad_s
    with making_torque(bench_session, 0.0, omega):
        block, _ = recorded(bench_session, 8.0 * limits.period_s(omega), ("theta_m", "omega_m"))
        standard = number(bench_session, "velocity_actual", float("nan"))
    theta = np.unwrap(block.column("theta_m"))
    time_s = (block.ticks() - block.first_tick) * block.tick_s
    slope = float(np.polynomial.Polynomial.fit(time_s, theta, 1).convert().coef[1])
    told = float(np.mean(block.column("omega_m")))
    measure("speed_by_the_angle", slope / omega, "", min=0.995, max=1.005)
    measure("speed_by_the_observer", told / omega, "", min=0.995, max=1.005)
    if "velocity_actual" in bench_session.drive.dictionary:
        measure("velocity_actual", standard / omega, "", min=0.99, max=1.01)


@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["forward", "backward"])
def test_speed_control(bench_session: Session, measure: Measure, direction: float) -> None:
    """In velocity mode the shaft turns at the speed that was asked for."""
    require_objects(bench_session, "omega_m", "omega_m_command")
    drive = bench_session.drive
    limits = rating(bench_session)
    omega = direction * 0.5 * limits.omega_m_rad_s
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", omega)
        drive.wait(1.5)
        block, _ = recorded(bench_session, 0.1, ("omega_m",))
    speed = block.column("omega_m") / omega
    measure("speed_held", float(np.mean(speed)), "", min=0.99, max=1.01)
    measure("speed_ripple_rms", float(np.std(speed)), "", max=0.02)


def test_objects_of_the_standard(bench_session: Session, measure: Measure) -> None:
    """The objects of CiA 402 tell of torque, current and voltage what the signals do."""
    require_objects(bench_session, "torque_actual", "torque", "u_dc", "dc_link_voltage")
    drive = bench_session.drive
    limits = rating(bench_session)
    with making_torque(bench_session, 0.7 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
        quiet(bench_session, 0.01)
        told = [drive.number("torque_actual") for _ in range(5)]
        torque = [drive.number("torque") / limits.T_N_Nm for _ in range(5)]
        volts = drive.number("dc_link_voltage") / drive.number("u_dc")
        i_q = drive.number("i_q") / math.sqrt(2.0) / bench_session.profile.motor.I_N_A_rms
        current = number(bench_session, "current_actual", i_q)
    measure("torque_actual", float(np.mean(told)) - float(np.mean(torque)), "T_N", min=-0.02, max=0.02)
    measure("dc_link_voltage", volts, "", min=0.98, max=1.02)
    measure("current_actual", current - i_q, "I_N", min=-0.03, max=0.03)
