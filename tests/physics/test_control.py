"""Control alone and in the loop: TPC's property, flux, speed PI, modulator, trips, quick stop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control import tpc
from benchtool.emulator.control.estimation import StateEstimate, predict, state_estimate
from benchtool.emulator.control.flux import flux_reference
from benchtool.emulator.control.observer import rotor_angle
from benchtool.emulator.control.speed import speed_pi
from benchtool.emulator.control.svpwm import compensated, modulate
from benchtool.emulator.core import Trip
from benchtool.emulator.machine.coefficients import holding
from benchtool.emulator.machine.inverter import clarke
from benchtool.emulator.machine.plant import airgap_torque
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.emulator.memory import CONTROL, Record
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import FINE, MOTOR, captured, make_core

THETA = 0.7


def drive(**parameters: Any) -> Any:
    return make_core(parameters=parameters).memory[0]


def at(i_d: float, i_q: float, omega_e: float, memory: Any) -> StateEstimate:
    return state_estimate(i_d, i_q, omega_e, math.cos(THETA), math.sin(THETA), memory)


def torque_after_a_cycle(T_s: float, omega_e: float, raise_flux: bool) -> tuple[float, float]:
    """Torque error and change of flux after one cycle of TPC's mean voltage on the exact machine."""
    memory = drive(control_period=T_s)
    machine = holding(MotorTruth(**MOTOR).machine(), True, False)
    start = at(0.1, 2.0, omega_e, memory)
    before = math.hypot(start.psi_d, start.psi_q)
    wanted = start.torque + 300.0 * T_s  # within the reach of any cycle
    u_alpha, u_beta, _, clipped = tpc.voltage(start, wanted, 1.0 if raise_flux else 0.0, memory)
    assert not clipped
    x = advance(place(0.1, 2.0, omega_e, THETA), u_alpha, u_beta, T_s, 0.001, machine, 0.0)
    after = math.hypot(9.52e-3 * x.i_d + 0.1685, 9.52e-3 * x.i_q)
    return airgap_torque(x.i_d, x.i_q, x.theta_e, machine) - wanted, after - before


@pytest.mark.parametrize("raise_flux", [True, False], ids=["lambda", "pi - lambda"])
def test_torque_error_after_a_cycle_is_of_second_order(raise_flux: bool) -> None:
    """(13) is the first-order expansion of the torque; what is left shrinks with the square of the cycle."""
    errors = [abs(torque_after_a_cycle(T_s, 63.0, raise_flux)[0]) for T_s in (2e-4, 1e-4, 5e-5)]
    assert errors[1] < 0.01
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 1.7).all()


def test_both_angles_make_the_same_torque_and_move_the_flux_oppositely() -> None:
    up, down = torque_after_a_cycle(1e-4, 63.0, True), torque_after_a_cycle(1e-4, 63.0, False)
    assert up[0] == pytest.approx(down[0], abs=0.005)
    assert up[1] > 1e-3
    assert down[1] < -1e-3


def test_angle_of_equation_14() -> None:
    memory = drive()
    now = at(0.5, 1.0, 63.0, memory)
    *_, angle, clipped = tpc.voltage(now, now.torque + 0.1, 1.0, memory)
    psi_s, psi_r = complex(now.psi_d, now.psi_q), complex(0.1685, 0.0)
    gain = 1.5 * 4 / 9.52e-3
    emf = gain * (psi_s.conjugate() * (1j * 63.0 * psi_r)).imag
    argument = (0.1 + (0.123 / 9.52e-3 * now.torque + emf) * 1e-4) / (gain * 0.1685 * 0.7e-4 * 81.65)
    assert angle == pytest.approx(math.asin(argument), rel=1e-6)
    assert not clipped
    *_, opposite, _ = tpc.voltage(now, now.torque + 0.1, 0.0, memory)
    assert opposite == pytest.approx(math.pi - angle)


def test_argument_of_14_is_clipped_and_says_so() -> None:
    memory = drive()
    for sign in (1.0, -1.0):
        u_alpha, u_beta, angle, clipped = tpc.voltage(at(0.0, 0.0, 0.0, memory), sign * 50.0, 1.0, memory)
        assert clipped
        sine = 50.0 * 9.52e-3 / (6 * 0.1685)  # of the flux vector of 1 Wb that makes it
        assert angle == pytest.approx(sign * math.atan2(sine, math.sqrt(1.0 - sine * sine) - 0.1685))
        assert math.hypot(u_alpha, u_beta) == pytest.approx(0.7 * 81.65, rel=1e-6)


def test_prediction_is_the_machine_to_second_order() -> None:
    errors = []
    for T_s in (2e-4, 1e-4):
        memory = drive(control_period=T_s)
        now = at(-1.0, 3.0, 200.0, memory)
        machine = holding(MotorTruth(**MOTOR).machine(), True, False)
        exact = advance(place(-1.0, 3.0, 200.0, THETA), 20.0, 30.0, T_s, 0.001, machine, 0.0)
        then = predict(now, 20.0, 30.0, memory)
        assert (then.cos_theta, then.sin_theta) == pytest.approx((exact.cos_theta, exact.sin_theta), abs=1e-6)
        errors.append(math.hypot(then.i_d - exact.i_d, then.i_q - exact.i_q))
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_least_current_flux() -> None:
    assert flux_reference(2.0, drive(psi_s_command=0.3)) == pytest.approx(0.3, rel=1e-6)
    i_q = 2.0 / (1.5 * 4 * 0.1685)
    assert flux_reference(2.0, drive()) == pytest.approx(math.hypot(0.1685, 9.52e-3 * i_q), rel=1e-6)


@pytest.mark.parametrize(("L_d", "L_q"), [(4e-3, 9e-3), (9e-3, 4e-3)])
def test_least_current_flux_of_a_salient_machine(L_d: float, L_q: float) -> None:
    """Against the least |i| found by search along the curve of constant torque."""
    i_d = np.linspace(-8.0, 8.0, 160_001)
    i_q = 6.0 / (1.5 * 4 * (0.1685 + (L_d - L_q) * i_d))
    best = np.argmin(np.hypot(i_d, i_q))
    expected = math.hypot(0.1685 + L_d * i_d[best], L_q * i_q[best])
    assert flux_reference(6.0, drive(L_d=L_d, L_q=L_q)) == pytest.approx(expected, rel=1e-4)


def test_speed_pi_does_not_wind_up() -> None:
    memory, control = drive(torque_limit=1.0), np.zeros(1, CONTROL)[0]
    for _ in range(20_000):  # two seconds against the limit
        assert speed_pi(50.0, memory, control) == 1.0
    assert abs(control.speed_integral) <= 1.0
    assert speed_pi(-30.0, memory, control) < 0.0  # the first tick beyond the setpoint brakes


def test_speed_step_ends_without_the_overshoot_of_windup() -> None:
    core = make_core(parameters={"torque_limit": 1.0})
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 60.0
    core.run(300)
    signals = captured(core, ["omega_m", "torque_reference"], 9000)
    assert signals["torque_reference"].max() == pytest.approx(1.0)
    assert signals["omega_m"].max() < 60.0 * 1.2
    assert signals["omega_m"][-1] == pytest.approx(60.0, abs=1.0)


def test_rotor_angle_undoes_the_encoder_offset() -> None:
    memory = drive(encoder_offset=0.5, encoder_lines=2500)
    count = math.floor((1.2 + 0.5) * 10_000 / (2 * math.pi))
    assert rotor_angle(count, memory) == pytest.approx(1.2, abs=math.pi / 10_000)


@pytest.mark.parametrize("angle", np.linspace(0.0, 6.0, 13))
def test_modulator_makes_the_mean_voltage(angle: float) -> None:
    made = modulate(60.0 * math.cos(angle), 60.0 * math.sin(angle), 122.5)
    duties = (made.duty_a, made.duty_b, made.duty_c)
    u_alpha, u_beta = clarke(*(122.5 * duty for duty in duties))
    assert (u_alpha, u_beta) == pytest.approx((60.0 * math.cos(angle), 60.0 * math.sin(angle)))
    assert max(duties) + min(duties) == pytest.approx(1.0)  # both zero vectors equally long
    assert not made.limited


@pytest.mark.parametrize("angle", np.linspace(0.0, 6.0, 13))
def test_modulator_stays_in_the_hexagon(angle: float) -> None:
    made = modulate(200.0 * math.cos(angle), 200.0 * math.sin(angle), 122.5)
    duties = (made.duty_a, made.duty_b, made.duty_c)
    assert made.limited
    assert (min(duties), max(duties)) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert math.atan2(made.u_beta, made.u_alpha) == pytest.approx(math.remainder(angle, 2 * math.pi))


def test_dead_time_compensation_is_limited_to_the_period() -> None:
    assert compensated(0.5, 1.0, 0.03) == pytest.approx(0.53)
    assert compensated(0.5, -1.0, 0.03) == pytest.approx(0.47)
    assert compensated(0.99, 1.0, 0.03) == 1.0
    assert compensated(0.5, 0.0, 0.03) == 0.5


def running(**given: Any) -> Any:
    core = make_core(**given)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 30.0
    core.run(3000)
    assert core.command.trip == 0
    return core


@pytest.mark.parametrize(
    ("name", "value", "trip"),
    [
        ("i_trip", 1e-3, Trip.OVERCURRENT),
        ("omega_m_trip", 1.0, Trip.OVERSPEED),
        ("u_dc_min", 200.0, Trip.UNDERVOLTAGE),
        ("u_dc_max", 100.0, Trip.OVERVOLTAGE),
    ],
)
def test_trip_ends_the_run_in_its_tick_with_the_power_stage_off(name: str, value: float, trip: Trip) -> None:
    core = running()
    core.memory[name] = value
    assert core.run(500) == 1
    assert Trip(int(core.command.trip)) == trip
    assert core.command.pwm_enabled == 0
    assert core.run(500) == 500  # latched: not new any more
    assert (core.shaft.i_d, core.shaft.i_q) == (0.0, 0.0)
    core.command.pwm_enabled = 1
    core.run(1)
    assert core.command.pwm_enabled == 0


@pytest.mark.parametrize("speed", [-50.0, 50.0])
def test_overspeed_trips_in_either_direction(speed: float) -> None:
    core = make_core(parameters={"omega_m_trip": 60.0})
    core.load.held, core.load.omega_m_rad_s = 1, speed
    assert core.run(1000) == 1000
    assert core.command.trip == 0
    core.load.omega_m_rad_s = 1.4 * speed
    core.run(1000)
    assert Trip(int(core.command.trip)) == Trip.OVERSPEED


@pytest.mark.parametrize("phase", range(3))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_overcurrent_trips_on_any_phase_of_either_sign(phase: int, sign: float) -> None:
    """Half of the current flows in each of the other two, so that one phase alone is beyond the limit."""
    core = make_core(sensors=FINE, parameters={"i_trip": 8.0})
    for peak, trip in ((7.0, 0), (9.0, Trip.OVERCURRENT)):
        core.turn_rotor(phase * 2.0 * math.pi / 3.0)
        core.shaft.i_d = sign * peak
        core.load.held = 1
        core._controls["gated"] = core.command.pwm_enabled = 1  # a zero vector: the current flows on
        core._controls["duty_a"] = core._controls["duty_b"] = core._controls["duty_c"] = 0.0
        core.run(1)
        assert int(core.command.trip) == trip


def test_the_speed_loop_starts_from_nothing_after_a_stand_by() -> None:
    core = make_core()
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 30.0
    core.load.torque_Nm = 2.0
    core.run(10_000)
    assert float(core.memory["torque_reference"][0]) > 1.5  # the integral carries the load
    core.load.held, core.load.omega_m_rad_s = 1, 30.0
    core.command.pwm_enabled = 0
    core.run(500)
    core.command.pwm_enabled = 1
    core.run(1)
    error = 30.0 - float(core.memory["omega_m"][0])
    assert abs(error) < 1.0
    assert float(core.memory["torque_reference"][0]) == pytest.approx(0.04 * error, abs=0.01)


def test_quick_stop_reaches_standstill_in_either_mode() -> None:
    core = running()
    core.command.mode = int(Mode.TORQUE)
    core.command.quick_stop = 1
    core.run(1)
    assert core.command.standstill == 0
    core.run(4000)
    assert core.command.standstill == 1
    assert abs(float(core.memory["omega_m"][0])) < 1.6


@pytest.mark.parametrize("torque", [-3.0, 3.0])
def test_torque_follows_its_setpoint_on_a_held_shaft(torque: float) -> None:
    core = make_core(sensors=FINE)
    core.load.held, core.load.omega_m_rad_s = 1, 50.0
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = torque
    core.run(1000)
    signals = captured(core, ["torque", "psi_s", "psi_s_reference", "i_d"], 2000)
    assert signals["torque"] == pytest.approx(torque, abs=0.05)
    # The flux swings about its reference by less than one cycle's u_s T_k.
    assert np.abs(signals["psi_s"] - signals["psi_s_reference"]).max() < 81.65 * 0.7e-4 * 1.2


def test_delay_compensation_pays() -> None:
    ripple = {}
    for compensation in (0, 1):
        core = make_core(sensors=FINE, parameters={"delay_compensation": compensation})
        core.load.held, core.load.omega_m_rad_s = 1, 15.71
        core.memory["torque_command"] = 0.65
        core.command.pwm_enabled = 1
        core.run(500)
        ripple[compensation] = np.ptp(captured(core, ["torque"], 2000)["torque"])
    assert ripple[1] < 0.2 * ripple[0]


def shadow(core: Any) -> Record:
    record: Record = core._controls
    return record


def test_duties_take_effect_one_cycle_after_they_are_computed() -> None:
    core = make_core()
    core.load.held = 1
    core.memory["torque_command"] = 2.0
    core.command.pwm_enabled = 1
    core.run(1)  # samples and computes; the power stage has nothing to apply yet
    assert core.shaft.i_q == 0.0
    core.run(1)  # the period in which the result waits in the shadow register
    assert core.shaft.i_q == 0.0
    core.run(1)
    assert core.shaft.i_q != 0.0
    assert shadow(core)["gated"][0] == 1
