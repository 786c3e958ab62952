"""Parameters of a drive's control that fit a motor: each by a rule that is stated with its source.

A starting point for commissioning, as an engineer would calculate it by hand: `docs/decisions/0085` has the
rules with their reasons and what they give for some motors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from benchtool.profile.drive import CONTROL_PERIOD_S
from benchtool.profile.motor import Motor

LAWS: Final = ("tpc", "tpc_stator", "svm_dtc", "dtc", "fcs_mpc", "foc", "deadbeat")
"""Control laws of the reference drive."""

_T_K_RATIO = 0.7  # "a tested value" of Zhu, Xiao and Li, II-C
_OF_SAMPLING = 0.05  # of 2 pi / T_s: bandwidth of the current loop
_CASCADE = 10.0  # a loop is that much slower than the one within it
_OBSERVER = 5.0  # poles of the speed observer over the bandwidth of the speed loop
_TORQUE_OF_A_COUNT = 0.002  # of T_N: what a step of the encoder may make of the torque
_OF_DEADBEAT = 0.5  # gain of svm_dtc's torque PI
_INTEGRAL_PERIODS = 100.0  # in which its integral part makes up what the proportional one leaves
_BAND = 0.1  # of what one vector changes in a period
_LARGEST_STEP = 0.25  # of I_N: up to here TPC's fixed voltage is of use
_OVERCURRENT, _OVERSPEED = 1.25, 1.4
_BORNE, _TAU_S = 1.1, 30.0
_USABLE = 0.95  # of the trip level, by the drive's laws
_STEPS: Final = {"tpc": 1.5 * _T_K_RATIO, "tpc_stator": 1.5 * _T_K_RATIO, "dtc": 2.5, "fcs_mpc": 1.5}
"""Steps of u_s T_s that these laws keep their current below the trip level."""

_UNDERVOLTAGE, _OVERVOLTAGE = 0.5, 1.5


@dataclass(frozen=True)
class Derived:
    """A parameter by its TOML key, and the rule that gave it."""

    key: str
    value: float | str
    rule: str


@dataclass(frozen=True)
class Given:
    """What the rules rest on besides the motor.

    Args:
        u_dc_V: nominal voltage of the dc link.
        encoder_lines: of the quadrature encoder; four counts each.
        control_period_s: T_s.
        dead_time_s: of the inverter, which the drive compensates.
        double_update: control runs at both ends of a PWM period, which is 2 T_s then.
    """

    u_dc_V: float
    encoder_lines: int
    control_period_s: float = CONTROL_PERIOD_S
    dead_time_s: float = 0.0
    double_update: bool = False


def derived_parameters(motor: Motor, given: Given, law: str = "") -> tuple[Derived, ...]:
    """Return every parameter of control and protection that depends on the motor.

    Args:
        motor: as control believes it.
        given: what it runs on.
        law: the law it runs with; without one `tpc`, or `foc` where a fixed voltage is too coarse.
    """
    T_s = given.control_period_s
    I_N = math.sqrt(2.0) * motor.I_N_A_rms
    u_s = 2.0 / 3.0 * given.u_dc_V
    per_ampere = 1.5 * motor.pole_pairs
    least_L = min(motor.L_d_H, motor.L_q_H)
    vector_A = u_s * T_s / least_L
    step_A = _T_K_RATIO * vector_A
    chosen = law or ("tpc" if step_A <= _LARGEST_STEP * I_N else "foc")
    ripple_A = _STEPS.get(chosen, 0.0) * vector_A
    omega_current = _OF_SAMPLING * 2.0 * math.pi / T_s
    count_rad = 2.0 * math.pi / (4.0 * given.encoder_lines)
    omega_speed = min(
        omega_current / _CASCADE,
        math.sqrt(_TORQUE_OF_A_COUNT * motor.T_N_Nm / (_OBSERVER * motor.J_kgm2 * count_rad)),
    )
    K_p_delta = _OF_DEADBEAT * motor.L_q_H / (per_ampere * motor.psi_r_Wb**2)
    return (
        Derived("law", chosen, _law_rule(law, chosen, step_A / I_N)),
        Derived("u_s_V", u_s, "2/3 u_dc, the length of a basic vector (Zhu, Xiao, Li 2011, II-C)"),
        Derived("T_k_ratio", _T_K_RATIO, "T_k / T_s, tested by Zhu, Xiao, Li 2011, II-C"),
        Derived("dead_time_compensation_s", given.dead_time_s, "the dead time of the inverter"),
        Derived("encoder_lines", given.encoder_lines, "of the encoder; four counts each"),
        Derived(
            "omega_current_rad_s",
            omega_current,
            f"foc: {_OF_SAMPLING:g} of 2 pi / T_s, internal-model control (Harnefors, Nee 1998)",
        ),
        Derived(
            "K_p_speed_Nms_rad",
            motor.J_kgm2 * omega_speed,
            f"J omega_s, omega_s = {omega_speed:.4g} rad/s: 1/{_CASCADE:g} of the current loop, or where an "
            f"encoder count makes {_TORQUE_OF_A_COUNT:.1%} of T_N",
        ),
        Derived(
            "K_i_speed_Nm_rad",
            motor.J_kgm2 * omega_speed**2 / 4.0,
            "J omega_s^2 / 4: both poles at omega_s / 2, critically damped",
        ),
        Derived("torque_limit_Nm", motor.T_N_Nm, "T_N"),
        Derived(
            "omega_observer_rad_s", _within(_OBSERVER * omega_speed, 1.0, 5000.0), f"{_OBSERVER:g} omega_s"
        ),
        Derived(
            "i_trip_A",
            min(max(_OVERCURRENT * I_N, 1.05 * (I_N + ripple_A) / _USABLE), 10_000.0),
            f"{_OVERCURRENT:g} I_N peak, or I_N and the ripple of the law's voltage",
        ),
        Derived("i2t_current_A", _BORNE * I_N, f"{_BORNE:g} I_N peak, borne at length"),
        Derived("i2t_tau_s", _TAU_S, "thermal time constant of a small winding; of a large one longer"),
        Derived("omega_m_trip_rad_s", _OVERSPEED * motor.omega_m_N_rad_s, f"{_OVERSPEED:g} omega_m_N"),
        Derived("u_dc_min_V", _UNDERVOLTAGE * given.u_dc_V, f"{_UNDERVOLTAGE:g} u_dc"),
        Derived("u_dc_max_V", _OVERVOLTAGE * given.u_dc_V, f"{_OVERVOLTAGE:g} u_dc"),
        Derived(
            "K_p_delta_rad_Nm",
            K_p_delta,
            f"svm_dtc: {_OF_DEADBEAT:g} of the deadbeat gain L_q / (3/2 p psi_r^2), the inverse of "
            f"dT / d delta at delta = 0",
        ),
        Derived(
            "K_i_delta_rad_Nms",
            K_p_delta / (_INTEGRAL_PERIODS * T_s),
            f"svm_dtc: K_p_delta / ({_INTEGRAL_PERIODS:g} T_s)",
        ),
        Derived(
            "torque_band_Nm",
            _BAND * per_ampere * motor.psi_r_Wb / motor.L_q_H * u_s * T_s,
            f"dtc: {_BAND:g} of what a basic vector changes in T_s, (12) of Zhu, Xiao, Li 2011",
        ),
        Derived("flux_band_Wb", _BAND * u_s * T_s, f"dtc: {_BAND:g} of u_s T_s, (11) likewise"),
        Derived(
            "flux_weight",
            (motor.psi_r_Wb / (motor.L_q_H * I_N)) ** 2,
            "fcs_mpc: (psi_r / (L_q I_N))^2, which weighs i_d and i_q alike",
        ),
    )


def _law_rule(asked: str, chosen: str, step: float) -> str:
    if asked:
        return "as asked for"
    moves = f"one period of u_s moves the current by {step:.2g} of I_N"
    return f"{moves}, {'at most' if chosen == 'tpc' else 'more than'} {_LARGEST_STEP:g}"


def _within(value: float, least: float, greatest: float) -> float:
    return min(max(value, least), greatest)
