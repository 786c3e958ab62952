"""Loads by speed, angle and time, an unbalance, and a load machine that gives way: closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.bounds import machine_of_bench, require_computable
from benchtool.emulator.machine.coefficients import Machine, driven_by, holding
from benchtool.emulator.machine.drive_train import asked_torque
from benchtool.emulator.machine.state import State, place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.train_truth import LoadMachineTruth, LoadTruth, ShaftTruth, TrainTruth
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.emulator.memory import LOAD
from benchtool.errors import EmulationError, ValueRefused
from tests.physics.paper_machine import make_core

P, J = 3, 4e-4
MOTOR = MotorTruth(pole_pairs=P, R_s_ohm=0.5, L_d_H=2e-3, L_q_H=2e-3, psi_r_Wb=0.05, J_kgm2=J)
GRAVITY = 9.80665


def coasting(train: TrainTruth) -> Machine:
    return holding(machine_of_bench(MOTOR, train), False, True)


def after(x: State, machine: Machine, duration: float, T_load: float = 0.0) -> State:
    for _ in range(200):  # from rest, where nothing tells yet how fine the steps have to be
        x = advance(x, 0.0, 0.0, duration / 200, 0.01, machine, T_load)
    return x


def test_a_fan_settles_where_its_torque_is_what_drives_it() -> None:
    """J omega' = T - k omega^2 is solved by omega = sqrt(T / k) tanh(t sqrt(T k) / J)."""
    k, T = 1e-4, 0.9
    fan = coasting(TrainTruth(load=LoadTruth(quadratic_Nms2=k), shaft=ShaftTruth(J_load_kgm2=6e-4)))
    for time in (0.02, 0.1, 0.4):
        omega = after(place(0.0, 0.0, 0.0, 0.0), fan, time, -T).omega_e / P
        assert omega == pytest.approx(math.sqrt(T / k) * math.tanh(time * math.sqrt(T * k) / 1e-3), rel=1e-8)
        backwards = after(place(0.0, 0.0, 0.0, 0.0), fan, time, T).omega_e / P
        assert backwards == pytest.approx(-omega, rel=1e-12)


def test_a_generator_brakes_in_proportion_to_the_speed() -> None:
    generator = coasting(TrainTruth(load=LoadTruth(linear_Nms=8e-3)))
    omega = after(place(0.0, 0.0, P * 90.0, 0.0), generator, 0.07).omega_e / P
    assert omega == pytest.approx(90.0 * math.exp(-8e-3 / J * 0.07), rel=1e-9)


def test_an_unbalance_is_a_pendulum() -> None:
    """Let go 2 rad from where it hangs, it is at rest again there after 4 K(sin 1) / omega_0."""
    U = 3e-3
    pendulum = coasting(TrainTruth(shaft=ShaftTruth(unbalance_kgm=U)))
    period = 4.0 * ellipk(math.sin(1.0) ** 2) / math.sqrt(GRAVITY * U / J)
    x = after(place(0.0, 0.0, 0.0, 2.0 * P), pendulum, period)
    assert (x.omega_e / P, x.theta_e / P) == pytest.approx((0.0, 2.0), abs=1e-6)
    x = after(place(0.0, 0.0, 0.0, 2.0 * P), pendulum, 0.5 * period)
    assert (x.omega_e / P, x.theta_e / P) == pytest.approx((0.0, -2.0), abs=1e-6)


def test_torques_over_the_angle_do_their_work() -> None:
    """Kinetic energy falls by the integral over the angle, which numpy has of the corners."""
    torques = (0.3, -0.1, 0.5, 0.2, -0.4)
    cam = coasting(TrainTruth(load=LoadTruth(over_angle_Nm=torques)))
    start = place(0.0, 0.0, P * 120.0, P * -2.5)
    for time in (0.004, 0.031, 0.2):
        x = after(start, cam, time)
        angles = np.arange(-30, 60) * 2.0 * math.pi / 5
        corners = np.array([*np.array(torques * 18)])
        path = np.linspace(-2.5, x.theta_e / P, 400_001)
        work = float(np.trapezoid(np.interp(path, angles, corners), path))
        kinetic = 0.5 * J * ((x.omega_e / P) ** 2 - 120.0**2)
        assert kinetic == pytest.approx(-work, abs=2e-6)


def test_torques_over_time_come_again() -> None:
    torques, T_s = (0.2, 1.4, -0.6), 1e-4
    machine = machine_of_bench(MOTOR, TrainTruth(load=LoadTruth(over_time_Nm=torques, over_time_s=0.012)))
    load: Any = np.zeros(1, LOAD)[0]
    load.torque_Nm = 0.5
    seen = [asked_torque(machine.train, load, T_s) for _ in range(300)]
    middles = (np.arange(300) + 0.5) * T_s
    expected = np.interp(middles % 0.012, np.linspace(0.0, 0.012, 4), (*torques, torques[0]))
    assert seen == pytest.approx(0.5 + expected, abs=1e-9)


LIMITED = LoadMachineTruth(bandwidth_Hz=40.0, stiffness_Nms=0.15, torque_limit_Nm=1.5)


def test_a_load_machine_that_holds_gives_way_by_its_stiffness_and_bandwidth() -> None:
    """J omega' = T - T_m, T_m' = omega_c (K (omega - omega_ref) - T_m), after a step of T: the closed form,
    which oscillates, and the droop T / K it settles to."""
    T, K, omega_c, omega_ref = 0.6, 0.15, 2.0 * math.pi * 40.0, 50.0
    train = TrainTruth(load_machine=LIMITED, load=LoadTruth(over_angle_Nm=(-T,)))
    machine = driven_by(coasting(train), True, omega_ref)
    decay = 0.5 * omega_c
    ringing = math.sqrt(K * omega_c / J - decay**2)
    for time in (0.002, 0.01, 0.02, 0.3):
        x = after(place(0.0, 0.0, P * omega_ref, 0.0), machine, time)
        wave = math.cos(ringing * time) + (decay - K / J) / ringing * math.sin(ringing * time)
        droop = T / K * (1.0 - math.exp(-decay * time) * wave)
        assert x.omega_e / P - omega_ref == pytest.approx(droop, abs=1e-7)
    assert droop == pytest.approx(T / K, rel=1e-9)


def test_a_load_machine_has_a_lag_and_a_limit() -> None:
    machine = driven_by(coasting(TrainTruth(load_machine=LIMITED)), False, 0.0)
    x = after(place(0.0, 0.0, 0.0, 0.0), machine, 0.004, 1.0)
    assert x.far.torque == pytest.approx(1.0 - math.exp(-2.0 * math.pi * 40.0 * 0.004), rel=1e-8)
    x = after(place(0.0, 0.0, 0.0, 0.0), machine, 0.2, 20.0)
    assert x.far.torque == pytest.approx(1.5, rel=1e-9)


def test_what_is_held_ideally_is_the_load() -> None:
    """An elastic coupling lets the rotor swing, and the load turns at the speed that is held."""
    train = TrainTruth(shaft=ShaftTruth(J_load_kgm2=1e-3, coupling_Nm_rad=200.0, coupling_Nms=1.0))
    core = make_core(train=train)
    core.load.held, core.load.omega_m_rad_s = 1, 30.0
    core.run_with(run_ticks, 8)
    assert core.shaft.omega_load == 30.0
    assert 0.0 < core.shaft.omega_m < 30.0
    core.run_with(run_ticks, 400)
    assert core.shaft.omega_m == pytest.approx(30.0, abs=0.1)


@pytest.mark.parametrize(
    ("train", "named"),
    [
        (TrainTruth(load=LoadTruth(linear_Nms=1e3)), "load.linear_Nms"),
        (TrainTruth(load=LoadTruth(over_angle_Nm=(1e9, -1e9))), "load.over_angle_Nm"),
        (
            TrainTruth(load_machine=LoadMachineTruth(bandwidth_Hz=1e4, stiffness_Nms=1e9)),
            "load_machine.stiffness_Nms",
        ),
        (
            TrainTruth(load_machine=LoadMachineTruth(bandwidth_Hz=1e6, stiffness_Nms=1e-9)),
            "load_machine.bandwidth_Hz",
        ),
    ],
)
def test_a_load_too_fast_to_be_computed_is_refused_by_its_keys(train: TrainTruth, named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        require_computable(MOTOR, 1e-4, train)


def test_a_load_that_runs_away_ends_the_run() -> None:
    shaft = ShaftTruth(J_load_kgm2=1e-7, coupling_Nm_rad=1.0, backlash_rad=1e3)
    core = make_core(train=TrainTruth(shaft=shaft))
    core.load.torque_Nm = 1e5
    with pytest.raises(EmulationError, match="load"):
        core.run_with(run_ticks, 100)
