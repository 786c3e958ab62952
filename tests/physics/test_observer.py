"""The speed observer: poles, no lag, a wrong inertia, held shafts, standstill, noise of the encoder."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.emulator.control.laws import Law
from benchtool.emulator.control.observer import SETTLED, track
from benchtool.emulator.core import Core, Trip
from benchtool.emulator.machine.sensor_truth import CurrentTruth
from benchtool.emulator.memory import CONTROL
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import captured, make_core

T_S = 1e-4
STEP = 2.0 * math.pi / 10_000  # of the encoder of 2500 lines
J = 13.1e-4


def observed(theta_m: NDArray[Any], torque: float = 0.0, **parameters: Any) -> NDArray[np.float64]:
    """Speed at every sample of an angle, from the second on with `torque` fed forward."""
    memory = make_core(parameters=parameters).memory[0]
    control = np.zeros(1, CONTROL)[0]
    return np.array([track(math.remainder(theta, 2 * math.pi), torque, memory, control) for theta in theta_m])


def of_second_order(theta_m: NDArray[np.float64], omega_0: float = 300.0) -> NDArray[np.float64]:
    """The former observer, with two poles at -omega_0: speed from the angle alone."""
    angle, speed, speeds = theta_m[0], 0.0, []
    for theta in theta_m:
        error = theta - (angle + T_S * speed)
        angle += T_S * speed + 2.0 * omega_0 * T_S * error
        speed += T_S * omega_0 * omega_0 * error
        speeds.append(speed)
    return np.array(speeds)


@pytest.mark.parametrize("omega_0", [1.0, 160.0, 5000.0])
def test_all_three_poles_are_where_they_were_placed(omega_0: float) -> None:
    """One tick is linear in (theta, omega, acceleration): its matrix, column by column."""
    memory = make_core(parameters={"omega_observer": omega_0, "J": 0.0}).memory[0]
    columns = []
    for state in (1e-6, 0.0, 0.0), (0.0, 1e-6, 0.0), (0.0, 0.0, 1e-6):
        control = np.zeros(1, CONTROL)[0]
        control.angles = SETTLED
        control.theta_m, control.omega_m, control.acceleration = state
        track(0.0, 0.0, memory, control)
        columns.append([control.theta_m, control.omega_m, control.acceleration])
    z = math.exp(-omega_0 * T_S)
    assert np.poly(np.array(columns).T / 1e-6) == pytest.approx([1.0, -3 * z, 3 * z**2, -(z**3)], abs=1e-6)


@pytest.mark.parametrize("omega_m", [-70.0, 0.3, 157.0])
def test_a_constant_speed_is_followed_without_lag(omega_m: float) -> None:
    assert observed(omega_m * T_S * np.arange(2000))[-1] == pytest.approx(omega_m, rel=1e-6)


@pytest.mark.parametrize("omega_m", [-150.0, 20.0, 150.0])
def test_a_shaft_that_turns_at_the_first_call_is_caught_without_overshoot(omega_m: float) -> None:
    """The settled gains overshoot by a quarter of the speed, which tripped at 0.8 of the trip level."""
    ratio = observed(omega_m * T_S * np.arange(1000)) / omega_m
    assert ratio.max() < 1.015
    assert (ratio[60:] > 0.95).all()


@pytest.mark.parametrize("lines", [100, 2500])
def test_the_first_steps_of_an_encoder_are_not_taken_for_a_speed(lines: int) -> None:
    """A count within a control period would be 157 and 6 rad/s."""
    step = 2.0 * math.pi / (4 * lines)
    for tick in (1, 2, 4, 8, 16, 32):
        speed = observed(np.where(np.arange(100) < tick, 0.0, step))
        assert np.abs(speed).max() < 0.14 * step / T_S


@pytest.mark.parametrize("inertia", [0.0, J / 2, J, 2 * J])
@pytest.mark.parametrize("acceleration", [-763.0, 763.0])
def test_a_constant_acceleration_is_followed_without_lag_whatever_inertia_is_believed(
    inertia: float, acceleration: float
) -> None:
    """At rest first, then through zero speed the other way; the observer of second order lagged 5 rad/s."""
    t = T_S * np.arange(1500)
    omega_m = observed(-20.0 * t + 0.5 * acceleration * t**2, J * acceleration, J=inertia)
    assert omega_m[-1] == pytest.approx(-20.0 + acceleration * t[-1], abs=1e-3)


def test_the_machines_own_torque_leaves_no_error_from_the_first_tick_on() -> None:
    t = T_S * np.arange(500)
    errors = observed(0.5 * 763.0 * t**2, J * 763.0, J=J) - 763.0 * t
    assert np.abs(errors[1:]).max() < 1e-6
    begun = np.concatenate((np.zeros(500), t))
    unaware = observed(0.5 * 763.0 * begun**2, J * 763.0, J=0.0) - 763.0 * begun
    assert np.abs(unaware).max() == pytest.approx(
        0.84 * 763.0 / 160.0, rel=0.02
    )  # 4.236 exp(-1.618) / omega_0


@settings(max_examples=20)
@given(st.floats(1.0, 5000.0), st.floats(0.0, 100.0), st.floats(-100.0, 100.0))
def test_any_parameters_keep_it_finite(omega_0: float, inertia: float, torque: float) -> None:
    theta = np.random.default_rng(0).uniform(-3.0, 3.0, 200)
    assert np.isfinite(observed(theta, torque, omega_observer=omega_0, J=inertia)).all()


def test_the_encoders_steps_reach_the_speed_no_more_than_before() -> None:
    """White noise comes through as 1.75 omega_0^3 with three poles and 0.25 omega_0^3 with two, 6 % more at
    160 than at 300 rad/s. Steps that beat slowly with the control period are no white noise."""
    ratios = []
    for omega_m in np.random.default_rng(1).uniform(0.5, 160.0, 8):
        counted = (np.floor(omega_m * T_S * np.arange(3000) / STEP) + 0.5) * STEP
        before, now = of_second_order(counted)[1000:].std(), observed(counted, J=0.0)[1000:].std()
        ratios.append(now / before)
    assert np.median(ratios) < 1.0
    assert max(ratios) < 1.3


# ---- in the loop -------------------------------------------------------------------------------------------


def turning(omega_m: float, law: Law = Law.TPC, **parameters: Any) -> Core:
    """A free shaft at a speed, with room in the dc link."""
    tuned = {"u_s": 207.3, "torque_limit": 1.0, "K_p_speed": 0.1, "omega_current": 2000.0, "law": int(law)}
    core = make_core(
        inverter={"u_dc_V": 311.0},
        sensors={"current_noise_A_rms": 0.001},
        parameters={**tuned, **parameters},
    )
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = omega_m
    core.run(5000)
    return core


def plateau(core: Core, omega_m: float) -> NDArray[np.float64]:
    """Torque over the sign of its limit, from 2 ms after a step of the speed until the limit is left."""
    core.memory["omega_m_command"] = omega_m
    signals = captured(core, ["torque", "torque_reference"], 1500)
    limited = np.abs(signals["torque_reference"]) > 0.999
    assert limited.sum() > 500
    assert core.command.trip == 0
    return (signals["torque"] / signals["torque_reference"])[limited][20:]


@pytest.mark.parametrize("law", [Law.TPC, Law.FOC, Law.DEADBEAT])
@pytest.mark.parametrize(("start", "end"), [(15.71, 94.26), (60.0, -60.0)], ids=["Fig. 8", "reversal"])
def test_torque_stays_at_its_limit_while_the_machine_accelerates(law: Law, start: float, end: float) -> None:
    """0.935 with tpc and 0.876 with foc before, when the observer lagged."""
    torque = plateau(turning(start, law), end)
    assert torque.mean() == pytest.approx(1.0, abs=0.01)
    assert torque.min() > 0.95
    assert torque.max() < 1.05


@pytest.mark.parametrize("inertia", [0.0, J / 2, 2 * J])
def test_a_wrong_inertia_costs_two_percent_of_it_and_no_stability(inertia: float) -> None:
    core = turning(15.71, J=inertia)
    assert plateau(core, 94.26).mean() == pytest.approx(1.0, abs=0.02)
    core.run(4000)
    settled = captured(core, ["torque", "omega_m"], 1000)
    assert settled["omega_m"] == pytest.approx(94.26, abs=0.3)
    assert np.ptp(settled["torque"]) < 0.08


def test_a_held_shaft_is_not_taken_for_an_accelerating_one() -> None:
    core = make_core(inverter={"u_dc_V": 311.0}, parameters={"u_s": 207.3})
    core.load.held, core.load.omega_m_rad_s = 1, 78.55
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = -3.0
    core.run(3000)
    core.memory["torque_command"] = 3.0
    signals = captured(core, ["omega_m", "torque"], 500)
    assert signals["omega_m"] == pytest.approx(78.55, abs=0.1)
    assert signals["torque"][20:] == pytest.approx(3.0, abs=0.05)


def test_an_unknown_load_is_found() -> None:
    core = turning(30.0, torque_limit=9.55)
    core.load.torque_Nm = 2.0
    core.run(3000)
    assert float(core.memory["omega_m"][0]) == pytest.approx(float(core.shaft.omega_m), abs=0.1)
    assert float(core._controls[0].acceleration) == pytest.approx(-2.0 / J, rel=0.05)


def test_a_standing_shaft_reads_standstill_whatever_the_current_sensors_add() -> None:
    core = make_core(
        sensors={
            "i_a": CurrentTruth(offset_A=0.3),
            "i_b": CurrentTruth(offset_A=-0.3),
            "current_noise_A_rms": 0.05,
        }
    )
    assert not captured(core, ["omega_m"], 1000)["omega_m"].any()


def test_switching_on_over_an_offset_of_the_current_sensors_starts_cleanly() -> None:
    """The offset is a torque that the shaft does not get, and the rest of it turns the shaft."""
    core = make_core(
        sensors={
            "i_a": CurrentTruth(offset_A=0.3),
            "i_b": CurrentTruth(offset_A=-0.3),
            "current_noise_A_rms": 0.05,
        }
    )
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    errors = []
    for _ in range(300):
        core.run(10)
        errors.append(abs(float(core.memory["omega_m"][0]) - float(core.shaft.omega_m)))
    assert max(errors) < 2.5
    assert errors[-1] < 0.3


def test_switching_off_while_accelerating_leaves_a_speed_that_stands() -> None:
    core = turning(0.0)
    core.memory["omega_m_command"] = 100.0
    core.run(800)
    core.command.pwm_enabled = 0
    core.run(1)
    true = float(core.shaft.omega_m)
    omega_m = captured(core, ["omega_m"], 2000)["omega_m"]
    assert omega_m == pytest.approx(true, abs=0.6)
    assert omega_m[-1] == pytest.approx(true, abs=0.05)


@pytest.mark.parametrize("omega_m", [-100.0, 157.1])
@pytest.mark.parametrize("law", Law)
def test_switching_on_in_the_first_tick_over_a_turning_shaft(law: Law, omega_m: float) -> None:
    """The observer begins at standstill; up to 100 rad/s no law trips, beyond none of free voltage.

    Both TPCs have 57 V against a back-EMF of 106 V there, and the few milliseconds in which the observer
    finds the speed end in a trip.
    """
    core = make_core(parameters={"law": int(law), "i_trip": 12.0, "omega_current": 2000.0, "K_p_delta": 0.03})
    core.shaft.omega_m = omega_m
    core.load.held, core.load.omega_m_rad_s = 1, omega_m
    core.command.mode, core.command.pwm_enabled = int(Mode.TORQUE), 1
    core.memory["torque_command"] = 0.65
    core.run(1000)
    core.run(1000)  # a trip ends a run
    fixed = law in (Law.TPC, Law.TPC_STATOR) and omega_m == 157.1
    assert Trip(int(core.command.trip)) == (Trip.OVERCURRENT if fixed else Trip(0))
    assert core.command.pwm_enabled == int(not fixed)
    assert float(core.memory["omega_m"][0]) == pytest.approx(omega_m, abs=0.5)
