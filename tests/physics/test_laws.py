"""Every torque law alone: one decision, compared with the exact machine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control import deadbeat, dtc, fcs_mpc, foc, svm_dtc, tpc, tpc_stator
from benchtool.emulator.control.estimation import StateEstimate, state_estimate
from benchtool.emulator.control.flux import operating_point
from benchtool.emulator.control.flux_comparator import threshold
from benchtool.emulator.control.laws import Law, demand
from benchtool.emulator.control.svpwm import modulate
from benchtool.emulator.control.vectors import MODULATED, held, nearest_zero
from benchtool.emulator.machine.coefficients import holding
from benchtool.emulator.machine.plant import airgap_torque
from benchtool.emulator.machine.state import State, place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.emulator.memory import CONTROL
from tests.physics.paper_machine import MOTOR, make_core

THETA = 0.7
OMEGA = 63.0
L, PSI_R, PER_AMPERE = 9.52e-3, 0.1685, 1.5 * 4


def drive(**parameters: Any) -> Any:
    return make_core(parameters={"u_dc": 122.5, **parameters}).memory[0]


def remembered() -> Any:
    """State of the control when the power stage is switched on."""
    return np.zeros(1, CONTROL)[0]


def at(i_d: float, i_q: float, omega_e: float, memory: Any, theta: float = THETA) -> StateEstimate:
    return state_estimate(i_d, i_q, omega_e, math.cos(theta), math.sin(theta), memory)


def after_a_cycle(
    i_d: float, i_q: float, u: tuple[float, float], *, T_s: float = 1e-4, omega_e: float = OMEGA, **motor: Any
) -> tuple[float, float, float]:
    """Torque, length of the stator flux and its angle against the rotor flux on the exact machine."""
    truth = {**MOTOR, **motor}
    machine = holding(MotorTruth(**truth).machine(), True, False)
    x: State = advance(place(i_d, i_q, omega_e, THETA), *u, T_s, 0.001, machine, 0.0)
    psi_s = complex(truth["L_d_H"] * x.i_d + PSI_R, truth["L_q_H"] * x.i_q)
    return airgap_torque(x.i_d, x.i_q, x.theta_e, machine), abs(psi_s), math.atan2(psi_s.imag, psi_s.real)


# ---- tpc_stator ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("raise_below", [0.0, 1.0], ids=["lower", "raise"])
@pytest.mark.parametrize("torque", [-0.4, 0.0, 0.5])
def test_without_load_both_tpc_are_the_same(torque: float, raise_below: float) -> None:
    """No current: psi_s lies on psi_r, and there is no u_s x i_s to approximate."""
    memory = drive()
    now = at(0.0, 0.0, OMEGA, memory)
    assert tpc_stator.voltage(now, torque, 0.18, raise_below, memory) == pytest.approx(
        tpc.voltage(now, torque, raise_below, memory)
    )


@pytest.mark.parametrize("torque", [2.6, 3.0, 3.3])
def test_both_tpc_are_the_same_where_the_flux_error_is_what_the_voltage_does(torque: float) -> None:
    """With i_s across psi_s only the voltage along psi_s enters u_s x i_s; (11) then holds exactly."""
    memory = drive()
    i_q = 3.0
    i_d = (-PSI_R + math.sqrt(PSI_R**2 - 4 * (L * i_q) ** 2)) / (2 * L)
    now = at(i_d, i_q, OMEGA, memory)
    wanted = tpc.voltage(now, torque, 1.0, memory)
    assert not wanted[3]
    psi_s = complex(now.psi_d, now.psi_q)
    at_the_end = psi_s * np.exp(1j * (THETA + OMEGA * 1e-4))
    growth = (complex(*wanted[:2]) * np.conj(at_the_end)).real / abs(psi_s) * 1e-4
    exact = tpc_stator.voltage(now, torque, abs(psi_s) + growth, 1.0, memory)
    assert exact[:2] == pytest.approx(wanted[:2], rel=1e-6)
    approximate = tpc_stator.voltage(now, torque, abs(psi_s), 1.0, memory)
    assert math.dist(approximate[:2], wanted[:2]) > 5.0


def test_the_angle_of_tpc_stator_is_laid_against_the_stator_flux() -> None:
    memory = drive()
    now = at(0.5, 3.0, OMEGA, memory)
    u_alpha, u_beta, angle, _ = tpc_stator.voltage(now, 3.0, 0.17, 1.0, memory)
    direction = math.atan2(now.psi_q, now.psi_d) + THETA + OMEGA * 1e-4
    assert math.remainder(math.atan2(u_beta, u_alpha) - direction - angle, 2 * math.pi) == pytest.approx(
        0.0, abs=1e-6
    )


@pytest.mark.parametrize(("reference", "periods"), [(0, 0), (1, 1)], ids=["start", "end"])
@pytest.mark.parametrize("law", [Law.TPC, Law.TPC_STATOR])
def test_lambda_is_laid_against_the_flux_at_the_chosen_end_of_the_period(
    law: Law, reference: int, periods: int
) -> None:
    memory = drive(law=int(law), lambda_reference=reference, flux_comparator=0)
    now = at(0.5, 3.0, 300.0, memory)
    asked = demand(now, now.torque, math.hypot(now.psi_d, now.psi_q), memory, remembered())
    of_flux = math.atan2(now.psi_q, now.psi_d) if law is Law.TPC_STATOR else 0.0
    direction = math.atan2(asked.u_beta, asked.u_alpha) - asked.angle
    expected = THETA + of_flux + periods * 300.0 * 1e-4
    assert math.remainder(direction - expected, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    assert not asked.clipped


# ---- the flux comparator of both -------------------------------------------------------------------------


def test_instantaneous_comparator_is_the_reference() -> None:
    memory, control = drive(flux_comparator=0), remembered()
    assert threshold(0.17, at(0.0, 1.0, 0.0, memory), memory, control) == 0.17


def test_accumulated_comparator_leans_against_a_lasting_error_and_no_further_than_a_step() -> None:
    memory, control = drive(flux_comparator=1), remembered()
    now = at(0.0, 0.0, 0.0, memory)
    shifts = [threshold(PSI_R + 0.001, now, memory, control) - PSI_R - 0.001 for _ in range(40)]
    assert shifts[:3] == pytest.approx([0.0005, 0.001, 0.0015], abs=1e-8)
    assert shifts[-1] == pytest.approx(81.65 * 0.7e-4, rel=1e-6)


# ---- svm_dtc ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("error", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("omega_e", [-150.0, 0.0, 150.0])
def test_svm_dtc_turns_the_flux_by_the_output_of_its_pi_and_holds_its_length(
    error: float, omega_e: float
) -> None:
    memory, control = drive(K_p_delta=0.03, K_i_delta=0.0), remembered()
    now = at(0.0, 1.0, omega_e, memory)
    u = svm_dtc.voltage(now, now.torque + error, 0.17, memory, control)
    _, length, angle = after_a_cycle(0.0, 1.0, u, omega_e=omega_e)
    assert angle - math.atan2(now.psi_q, now.psi_d) == pytest.approx(0.03 * error, abs=1e-5)
    assert length == pytest.approx(0.17, abs=1e-6)


def test_svm_dtc_integrates_only_while_the_voltage_suffices() -> None:
    memory, control = drive(K_i_delta=10.0), remembered()
    now = at(0.0, 1.0, 0.0, memory)
    memory.torque = now.torque
    svm_dtc.voltage(now, now.torque + 0.5, 0.17, memory, control)
    assert control.delta_integral == pytest.approx(10.0 * 1e-4 * 0.5)
    control.limited = 1
    svm_dtc.voltage(now, now.torque + 0.5, 0.17, memory, control)
    assert control.delta_integral == pytest.approx(10.0 * 1e-4 * 0.5)


# ---- dtc -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("flux", [1, -1])
@pytest.mark.parametrize("torque", [1, -1])
@pytest.mark.parametrize("sector", range(-3, 4))
def test_switching_table_moves_torque_and_flux_as_asked(sector: int, torque: int, flux: int) -> None:
    for within in np.linspace(-25.0, 25.0, 11):
        direction = math.radians(60 * sector + within)
        if abs(direction) > math.pi:
            continue
        switched = held(dtc.table(direction, torque, flux), 122.5)
        u = complex(switched.u_alpha, switched.u_beta)
        # Turned so that the flux, here that of the magnets alone, lies where the machine's test has it.
        u *= np.exp(1j * (THETA - direction))
        made, length, _ = after_a_cycle(0.0, 0.0, (u.real, u.imag), omega_e=0.0)
        assert made * torque > 0.1
        assert (length - PSI_R) * flux > 1e-4


def test_three_levels_of_torque() -> None:
    states = [0]
    for error in (0.05, 0.15, 0.05, 0.01, -0.01, -0.05, -0.15, -0.05, 0.01, 0.05):
        states.append(dtc.torque_state(error, 0.1, states[-1]))
    assert states == [0, 0, 1, 1, 1, 0, 0, -1, -1, 0, 0]


def test_two_levels_of_flux() -> None:
    states = [0]
    for error in (-0.5, 0.5, 1.5, 0.5, -0.5, -1.5, -0.5, 0.5, 1.5):
        states.append(dtc.flux_state(error, 1.0, states[-1]))
    assert states == [0, -1, -1, 1, 1, 1, -1, -1, -1, 1]
    assert dtc.flux_state(0.5, 1.0, 0) == 1


@pytest.mark.parametrize(("duties", "zero"), [((1, 1, 0), 7), ((1, 0, 0), 0), ((0, 0, 0), 0), ((1, 1, 1), 7)])
def test_zero_vector_of_fewer_switchings(duties: tuple[int, int, int], zero: int) -> None:
    memory, control = drive(torque_band=0.1), remembered()
    control.duty_a, control.duty_b, control.duty_c = duties
    now = at(0.0, 1.0, 0.0, memory)
    assert nearest_zero(control) == zero
    assert dtc.vector(now, now.torque, 0.17, memory, control) == zero


# ---- fcs_mpc ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_no_vector_costs_less_than_the_chosen_one(seed: int) -> None:
    random = np.random.default_rng(seed)
    memory, control = drive(flux_weight=float(random.uniform(0.2, 5.0))), remembered()
    theta, omega_e = random.uniform(0.0, 6.28), random.uniform(-300.0, 300.0)
    i_d, i_q = random.uniform(-3.0, 3.0, 2)
    now = at(i_d, i_q, omega_e, memory, theta)
    torque, psi_s = now.torque + random.uniform(-1.0, 1.0), random.uniform(0.16, 0.18)

    frame, turn = np.exp(1j * theta), np.exp(1j * omega_e * 1e-4)
    costs = []
    for k in range(7):
        u = 2 / 3 * 122.5 * np.exp(1j * (k - 1) * math.pi / 3) if k else 0.0
        psi = frame * complex(now.psi_d, now.psi_q) + 1e-4 * (u - 0.123 * frame * complex(now.i_d, now.i_q))
        i_s = (psi - PSI_R * frame * turn) / L
        made = PER_AMPERE * (psi.conjugate() * i_s).imag
        costs.append(
            ((made - torque) / 9.55) ** 2 + float(memory.flux_weight) * ((abs(psi) - psi_s) / PSI_R) ** 2
        )
    assert fcs_mpc.vector(now, torque, psi_s, memory, control) == int(np.argmin(costs))


@pytest.mark.parametrize(("duties", "zero"), [((0, 1, 1), 7), ((0, 1, 0), 0)])
def test_fcs_mpc_takes_the_zero_vector_of_fewer_switchings(duties: tuple[int, int, int], zero: int) -> None:
    memory, control = drive(), remembered()
    control.duty_a, control.duty_b, control.duty_c = duties
    now = at(0.0, 1.0, 0.0, memory)
    assert fcs_mpc.vector(now, now.torque, math.hypot(PSI_R, L), memory, control) == zero


# ---- foc -------------------------------------------------------------------------------------------------


def test_foc_moves_the_currents_by_the_share_of_its_bandwidth() -> None:
    memory, control = drive(omega_current=2000.0, R_s=0.0), remembered()
    now = at(0.0, 1.0, 0.0, memory)
    u_alpha, u_beta, clipped = foc.voltage(
        now, PER_AMPERE * PSI_R * 2.0, math.hypot(PSI_R, 2 * L), memory, control
    )
    u = complex(u_alpha, u_beta) * np.exp(-1j * THETA)
    assert u.imag == pytest.approx((1.0 - math.exp(-0.2)) * L / 1e-4, rel=1e-6)
    assert u.real == pytest.approx(0.0, abs=1e-3)
    assert not clipped


def test_foc_counts_what_the_inverter_fell_short_of() -> None:
    """A voltage that was cut leaves the integral where a reachable reference would have."""
    memory = drive(omega_current=2000.0)
    now = at(0.0, 1.0, 0.0, memory)
    integrals = []  # of d and q, without and with the shortage
    for made in (1.0, 0.5):
        control = remembered()
        foc.voltage(now, 4.0, 0.1735, memory, control)
        control.u_alpha, control.u_beta = made * control.u_alpha_asked, made * control.u_beta_asked
        foc.voltage(now, 4.0, 0.1735, memory, control)
        integrals.append((float(control.u_d_integral), float(control.u_q_integral)))
    assert integrals[0][0] != 0.0
    # Half the voltage is half the way: of two steps' integral, a quarter of it stands for each half step.
    assert integrals[1] == pytest.approx(0.75 * np.array(integrals[0]), rel=0.01)


# ---- deadbeat --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("motor", [{}, {"L_d_H": 6e-3}], ids=["surface", "salient"])
def test_what_deadbeat_leaves_after_a_cycle_is_of_third_order(motor: dict[str, float]) -> None:
    """Long periods and a high resistance, to stand clear of the rounding of float32 parameters."""
    errors = []
    for T_s in (3.2e-3, 1.6e-3, 8e-4):
        memory = drive(control_period=T_s, L_d=motor.get("L_d_H", L), R_s=2.0)
        now = at(-0.2, 2.0, OMEGA, memory)
        torque, psi_s = now.torque + 300.0 * T_s, math.hypot(now.psi_d, now.psi_q) + 2.0 * T_s
        u_alpha, u_beta, clipped = deadbeat.voltage(now, torque, psi_s, memory)
        assert not clipped
        made, length, _ = after_a_cycle(-0.2, 2.0, (u_alpha, u_beta), T_s=T_s, R_s_ohm=2.0, **motor)
        errors.append((abs(made - torque), abs(length - psi_s)))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 2.5).all()


@pytest.mark.parametrize("motor", [{}, {"L_d_H": 6e-3}], ids=["surface", "salient"])
def test_deadbeat_meets_torque_and_flux_after_a_cycle(motor: dict[str, float]) -> None:
    memory = drive(L_d=motor.get("L_d_H", L))
    now = at(-0.2, 2.0, OMEGA, memory)
    u_alpha, u_beta, _ = deadbeat.voltage(now, now.torque + 0.3, 0.170, memory)
    made, length, _ = after_a_cycle(-0.2, 2.0, (u_alpha, u_beta), **motor)
    assert made == pytest.approx(now.torque + 0.3, abs=1e-5)
    assert length == pytest.approx(0.170, abs=1e-7)


@pytest.mark.parametrize(("L_d", "L_q"), [(L, L), (4e-3, 9e-3), (9e-3, 4e-3)])
@pytest.mark.parametrize("torque", [-6.0, 0.0, 0.65, 6.0])
def test_operating_point_makes_the_torque_with_the_flux(torque: float, L_d: float, L_q: float) -> None:
    psi_d, psi_q, clipped = operating_point(torque, 0.18, drive(L_d=L_d, L_q=L_q))
    assert math.hypot(psi_d, psi_q) == pytest.approx(0.18, rel=1e-9)
    assert PER_AMPERE * (psi_d * psi_q / L_q - psi_q * (psi_d - PSI_R) / L_d) == pytest.approx(
        torque, abs=1e-3
    )
    assert not clipped


def test_operating_point_beyond_the_pull_out_torque_stays_there() -> None:
    pull_out = PER_AMPERE * 0.18 * PSI_R / L
    psi_d, psi_q, clipped = operating_point(-1.5 * pull_out, 0.18, drive())
    assert (psi_d, psi_q) == pytest.approx((0.0, -0.18))
    assert clipped


# ---- all of them -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", range(1, 7))
def test_vector_held_is_the_corner_of_the_hexagon(k: int) -> None:
    switched = held(k, 122.5)
    corner = 2 / 3 * 122.5 * np.exp(1j * (k - 1) * math.pi / 3)
    assert complex(switched.u_alpha, switched.u_beta) == pytest.approx(corner)
    modulated = modulate(corner.real, corner.imag, 122.5)
    assert switched[:3] == pytest.approx(modulated[:3], abs=1e-12)
    assert set(switched[:3]) == {0.0, 1.0}


@pytest.mark.parametrize("zero", [0, 7])
def test_zero_vectors_make_no_voltage(zero: int) -> None:
    assert held(zero, 122.5)[:5] == pytest.approx((zero // 7,) * 3 + (0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("law", [Law.FOC, Law.DEADBEAT])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_torque_that_no_flux_of_that_length_makes_is_told(law: Law, sign: float) -> None:
    memory = drive(law=int(law))
    pull_out = PER_AMPERE * 0.18 * PSI_R / L
    for share, clipped in ((0.9, False), (1.1, True)):
        asked = demand(at(0.2, 1.0, OMEGA, memory), sign * share * pull_out, 0.18, memory, remembered())
        assert bool(asked.clipped) is clipped


@pytest.mark.parametrize("law", [Law.FOC, Law.DEADBEAT])
def test_every_tick_in_which_a_law_is_out_of_reach_is_counted(law: Law) -> None:
    """A voltage to spare, so that it is the law that clips and not the modulator."""
    limits = {"i_trip": 55.0, "u_dc_max": 900.0, "torque_limit": 40.0}
    core = make_core(
        inverter={"u_dc_V": 800.0},
        sensors={"i_full_scale_A": 60.0, "u_full_scale_V": 1000.0, "adc_bits": 16},
        parameters={"law": int(law), "psi_s_command": 0.18, **limits},
    )
    core.load.held, core.load.omega_m_rad_s = 1, 15.0
    core.command.pwm_enabled = 1
    pull_out = PER_AMPERE * 0.18 * PSI_R / L
    counted = []
    for share in (0.5, 1.2):
        core.memory["torque_command"] = share * pull_out
        core.run(1000)
        before = int(core.memory["law_clipped"][0])
        core.run(400)
        counted.append(int(core.memory["law_clipped"][0]) - before)
    assert core.command.trip == 0
    assert counted == [0, 400]


@pytest.mark.parametrize("law", [law for law in Law if law is not Law.TPC_STATOR])
def test_law_angle_is_that_of_the_voltage_against_the_rotor_flux(law: Law) -> None:
    memory = drive(law=int(law))
    asked = demand(at(0.2, 1.0, OMEGA, memory), 1.6, 0.172, memory, remembered())
    direction = math.atan2(asked.u_beta, asked.u_alpha) - THETA - OMEGA * 1e-4
    assert math.remainder(direction - asked.angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    assert (asked.vector != MODULATED) == (law in (Law.DTC, Law.FCS_MPC))
