"""Every torque law in the closed loop on the switching-level machine, and their differences."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import coherent_spectrum, largest_low_component
from benchtool.analysis.periods import track_angle
from benchtool.emulator.control.laws import Law
from benchtool.emulator.core import Core
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import FINE, captured, make_core

# What the laws need beside the machine's parameters.
TUNED: dict[str, Any] = {
    "K_p_delta": 0.03,
    "K_i_delta": 2.2,
    "torque_band": 0.1,
    "flux_band": 0.001,
    "omega_current": 2000.0,
}
REAL: dict[str, Any] = {"i_full_scale_A": 12.5, "current_noise_A_rms": 0.001}
CHANNELS = ["torque", "torque_reference", "psi_s", "psi_s_reference", "i_a", "i_d", "i_q", "theta_m"]
ROWS = 5200  # five electrical periods at 10 Hz, and what interpolation needs at both ends
FIG_6, LOADED = (15.71, 0.65), (62.84, 3.0)
ACCUMULATED, INSTANTANEOUS = 1, 0


@cache
def steady(
    law: Law, point: tuple[float, float] = FIG_6, comparator: int = ACCUMULATED
) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.float64]]:
    """Signals and true torque at a speed and a load torque, settled, with the sensors of the profile."""
    core = make_core(sensors=REAL, parameters={**TUNED, "law": int(law), "flux_comparator": comparator})
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"], core.load.torque_Nm = point
    core.run(15_000)
    core.transducer.start(ROWS)
    signals = captured(core, CHANNELS, ROWS)
    assert core.command.trip == 0
    return signals, core.transducer.block().data[:, 0]


def held(law: Law, torque: float, omega_m: float = 50.0, u_dc: float = 122.5, **parameters: Any) -> Core:
    """A core with ideal sensors that has made a torque at a held speed for 0.3 s."""
    core = make_core(
        sensors=FINE, inverter={"u_dc_V": u_dc}, parameters={**TUNED, "law": int(law), **parameters}
    )
    core.load.held, core.load.omega_m_rad_s = 1, omega_m
    core.memory["torque_command"] = torque
    core.command.pwm_enabled = 1
    core.run(3000)
    return core


@pytest.mark.parametrize("law", Law)
def test_mean_torque_is_the_load_at_the_papers_operating_point(law: Law) -> None:
    signals, true = steady(law)
    assert signals["torque"].mean() == pytest.approx(0.65, abs=0.01)
    assert true.mean() == pytest.approx(0.65, abs=0.01)
    assert (signals["psi_s"] - signals["psi_s_reference"]).mean() == pytest.approx(0.0, abs=5e-4)


@pytest.mark.parametrize("law", Law)
@pytest.mark.parametrize("torque", [-3.0, 3.0])
def test_every_law_makes_a_torque_of_either_sign(law: Law, torque: float) -> None:
    made = captured(held(law, torque), ["torque"], 2000)["torque"].mean()
    within = {
        Law.DTC: 0.3,
        Law.FCS_MPC: 0.2,
    }  # one vector per period leaves an offset of a fraction of a step
    assert made == pytest.approx(torque, abs=within.get(law, 0.02))


@pytest.mark.parametrize("law", Law)
def test_only_laws_of_one_vector_per_period_leave_the_modulator(law: Law) -> None:
    core = held(law, 1.0)
    shadow: Any = core._controls[0]
    duties = []
    for _ in range(50):
        core.run(1)
        duties.append((shadow.duty_a, shadow.duty_b, shadow.duty_c))
    assert (set(np.ravel(duties)) == {0.0, 1.0}) == (law in (Law.DTC, Law.FCS_MPC))


@pytest.mark.parametrize("law", Law)
def test_a_law_forgets_when_the_power_stage_goes_off(law: Law) -> None:
    core = held(law, 1.0)
    core.command.pwm_enabled = 0
    core.run(1)
    remembered = (
        "limited torque_state flux_state flux_error_sum delta_integral u_d_integral u_q_integral "
        "u_alpha_asked u_beta_asked"
    )
    assert not any(core._controls[0][name] for name in remembered.split())


@pytest.mark.parametrize("law", [*map(int, Law), 99])
def test_parameters_that_make_no_sense_leave_the_machine_in_finite_states(law: int) -> None:
    """Also an unknown law, which the dictionary refuses, asks for no voltage."""
    core = make_core(parameters={"law": law, "psi_r": 0.0, "u_s": 0.0, "T_N": 0.0})
    core.load.held = 1
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = 1.0
    core.run(50)
    assert math.isfinite(core.shaft.i_d)
    assert math.isfinite(core.shaft.i_q)
    core.memory["psi_r"], core.memory["u_s"], core.memory["T_N"] = 0.1685, 81.65, 9.55
    core.command.trip, core.command.pwm_enabled = 0, 1  # dtc, which sees no torque, has tripped
    if law in tuple(map(int, Law)):  # and it works again once they do
        core.run(500)
        assert captured(core, ["torque"], 500)["torque"].mean() == pytest.approx(1.0, abs=0.3)


# ---- tpc and tpc_stator -----------------------------------------------------------------------------------


def low_component(law: Law, comparator: int) -> float:
    signals, _ = steady(law, comparator=comparator)
    spectrum = coherent_spectrum(signals["i_a"], 1e4, track_angle(signals["theta_m"], 4))
    return largest_low_component(spectrum, 10).amplitude


def test_accumulated_comparator_clears_the_low_orders_of_the_current() -> None:
    """Fig. 7(b) has at most 0.007 A about the fundamental."""
    assert low_component(Law.TPC, ACCUMULATED) <= 0.007
    assert low_component(Law.TPC, INSTANTANEOUS) > 5 * low_component(Law.TPC, ACCUMULATED)
    for comparator in (ACCUMULATED, INSTANTANEOUS):
        assert np.ptp(steady(Law.TPC, comparator=comparator)[0]["torque"]) <= 0.06


def test_flux_swings_no_further_than_three_steps_of_u_s_t_k() -> None:
    assert np.ptp(steady(Law.TPC)[0]["psi_s"]) < 3 * 81.65 * 0.7e-4
    assert np.ptp(steady(Law.TPC, comparator=INSTANTANEOUS)[0]["psi_s"]) < 2.1 * 81.65 * 0.7e-4


@pytest.mark.parametrize("comparator", [ACCUMULATED, INSTANTANEOUS])
def test_orientation_on_the_stator_flux_costs_torque_ripple_that_grows_with_the_load(comparator: int) -> None:
    ratios = []
    for point in (FIG_6, LOADED):
        proposed, earlier = (
            np.ptp(steady(law, point, comparator)[0]["torque"]) for law in (Law.TPC, Law.TPC_STATOR)
        )
        ratios.append(earlier / proposed)
    assert ratios[0] > 1.4
    assert ratios[1] > 3.0


def stepped(law: Law, **given: Any) -> NDArray[np.float64]:
    """Torque from the tick of a step from -3 to 3 Nm on, at half the rated speed with 300 V."""
    core = held(law, -3.0, 78.55, 300.0, u_s=200.0, **given)
    core.memory["torque_command"] = 3.0
    return captured(core, ["torque"], 400)["torque"]


def test_torque_step_of_tpc() -> None:
    torque = stepped(Law.TPC)
    assert np.argmax(torque >= 2.94) * 0.1 <= 1.2  # ms, two periods of delay included
    assert torque.max() <= 3.1


# ---- the others -------------------------------------------------------------------------------------------


def test_deadbeat_outdoes_tpc() -> None:
    (tpc, tpc_true), (deadbeat, deadbeat_true) = steady(Law.TPC), steady(Law.DEADBEAT)
    assert np.ptp(deadbeat_true) <= 0.5 * np.ptp(tpc_true)
    assert np.ptp(deadbeat["psi_s"]) <= 0.1 * np.ptp(tpc["psi_s"])


def test_deadbeat_takes_one_period_beside_the_delay() -> None:
    core = held(Law.DEADBEAT, 1.0)
    core.memory["torque_command"] = 1.2
    signals = captured(core, ["torque", "psi_s", "psi_s_reference"], 20)
    assert signals["torque"][:2] == pytest.approx([1.0, 1.0], abs=2e-3)
    assert signals["torque"][2:] == pytest.approx(1.2, abs=2e-3)
    assert signals["psi_s"][2:] == pytest.approx(signals["psi_s_reference"][2:], abs=2e-5)


@pytest.mark.parametrize("bandwidth", [500.0, 1000.0, 2000.0])
def test_foc_answers_like_a_first_order_lag_of_its_bandwidth(bandwidth: float) -> None:
    core = held(Law.FOC, 1.0, omega_current=bandwidth)
    core.run(7000)  # what switching on left behind goes with L / R_s, 77 ms
    core.memory["torque_command"] = 1.5
    signals = captured(core, ["i_d", "i_q"], 100)
    step = 0.5 / (6 * 0.1685)
    periods = np.maximum(
        np.arange(100) - 1, 0
    )  # the first is computed in the tick of the step, and waits one
    expected = 2 * step + step * (1.0 - np.exp(-bandwidth * 1e-4 * periods))
    assert signals["i_q"] == pytest.approx(expected, abs=0.01 * step)
    assert np.abs(signals["i_d"]).max() < 0.02 * step


@pytest.mark.parametrize("law", [Law.FOC, Law.SVM_DTC])
def test_integrals_return_from_the_limit_without_the_overshoot_of_windup(law: Law) -> None:
    core = held(law, 1.0, omega_m=100.0)  # 67 V of back EMF leave little of 122.5 V
    core.memory["torque_command"] = 9.0
    limited = 0
    for _ in range(40):
        core.run(1)
        limited += int(core._controls[0].limited)
    assert limited > 10
    core.run(5000)
    core.memory["torque_command"] = 1.0
    torque = captured(core, ["torque"], 1500)["torque"]
    assert torque[200:] == pytest.approx(1.0, abs=0.05)
    assert torque.min() > 0.9
    assert core._controls[0].limited == 0


def test_integral_of_svm_dtc_removes_the_error_of_a_wrong_resistance() -> None:
    errors = []
    for K_i in (0.0, 2.2):
        core = held(Law.SVM_DTC, 3.0, R_s=1.0, K_i_delta=K_i)
        errors.append(abs(captured(core, ["torque"], 1000)["torque"].mean() - 3.0))
    assert errors[0] > 0.05
    assert errors[1] < 0.002


def test_svm_dtc_overshoots_where_its_pi_is_too_integral_and_tpc_has_none_to_tune() -> None:
    assert stepped(Law.SVM_DTC).max() < 3.2
    assert stepped(Law.SVM_DTC, K_p_delta=0.005, K_i_delta=20.0).max() > 4.0


def test_cost_weight_of_fcs_mpc_trades_torque_for_flux() -> None:
    ripple = []
    for weight in (0.1, 10.0):
        signals = captured(held(Law.FCS_MPC, 1.0, flux_weight=weight), ["torque", "psi_s"], 3000)
        ripple.append((signals["torque"].std(), signals["psi_s"].std()))
    assert ripple[0][0] < ripple[1][0]
    assert ripple[0][1] > ripple[1][1]


def test_dtc_keeps_near_its_bands_where_the_period_is_short_enough() -> None:
    """A tenth of the voltage moves torque and flux a tenth as far per period."""
    core = held(Law.DTC, 0.3, 1.0, 12.0, u_dc_min=1.0, flux_band=0.002)
    signals = captured(core, ["torque", "psi_s", "psi_s_reference"], 3000)
    assert np.abs(signals["torque"] - 0.3).max() < 0.1 + 2 * 0.1
    assert np.abs(signals["psi_s"] - signals["psi_s_reference"]).max() < 0.002 + 2 * 8e-4
