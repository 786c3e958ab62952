"""A machine that is excited for parameters to be found, integrated in its own currents and not in its flux.

    L_d d i_d/dt = u_d - R_s i_d + omega_e L_q i_q
    L_q d i_q/dt = u_q - R_s i_q - omega_e (L_d i_d + psi_r)
    J d omega_m/dt = 3/2 p (psi_r + (L_d - L_q) i_d) i_q - B omega_m - T_c sign(omega_m) - T_n sin(n theta_m)

by Heun's method, four steps a tick. The voltage is the mean one, less what dead time takes from each phase.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from benchtool.block import Block
from benchtool.profile import Motor
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR

T_S: Final = 1e-4
U_DC: Final = 100.0
_STEPS: Final = 4
_DIRECTIONS: Final = np.exp(2j * math.pi / 3.0 * np.arange(3))
_UNITS: Final = {
    **dict.fromkeys(("i_a", "i_b", "i_c"), "A"),
    **dict.fromkeys(("u_alpha", "u_beta", "u_dc"), "V"),
    "theta_m": "rad",
    "omega_m": "rad/s",
}


@dataclass(frozen=True)
class Truth:
    """The machine, its inverter and its sensors as they are."""

    motor: Motor = EXAMPLE_MOTOR
    friction_Nms: float = 0.0
    coulomb_Nm: float = 0.0
    cogging_Nm: float = 0.0
    cogging_order: int = 0
    dead_time_V: float = 0.0
    encoder_offset_rad: float = 0.0
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)
    step_A: float = 0.01
    noise_A: float = 0.005
    counts: int = 10_000


@dataclass(frozen=True)
class Excitation:
    """Currents that are asked for: i_q swings, i_d is switched between two values at random."""

    i_q_A: float = 2.0
    i_q_Hz: float = 6.0
    i_d_A: float = 1.0
    speed_rad_s: float | None = None
    """Speed at which the shaft is held; None of a shaft that turns freely."""
    swing_rad_s: float = 0.0
    """By what the machine that holds the shaft swings its speed, at `swing_Hz`."""
    swing_Hz: float = 9.0


def capture(truth: Truth, excitation: Excitation, rows: int, seed: int = 0) -> Block:
    """Return what a drive with a proportional current controller captures of it."""
    rng = np.random.default_rng(seed)
    m, held = truth.motor, excitation.speed_rad_s is not None
    i_dq, omega_m, theta_m = 0j, excitation.speed_rad_s or 0.0, 0.3
    switched = np.repeat(rng.choice((-1.0, 1.0), rows // 20 + 1), 20)
    u_next = 0j
    found = {name: np.empty(rows) for name in _UNITS}
    for k in range(rows):
        rotor = np.exp(1j * m.pole_pairs * theta_m)
        i_abc = np.real(i_dq * rotor * np.conj(_DIRECTIONS))
        read = i_abc * np.array(truth.gains) + truth.noise_A * rng.standard_normal(3)
        read = np.round(read / truth.step_A) * truth.step_A
        angle = theta_m - truth.encoder_offset_rad / m.pole_pairs
        angle = (math.floor(angle / (2.0 * math.pi) * truth.counts) + 0.5) * 2.0 * math.pi / truth.counts
        u_now = u_next
        seen = np.exp(1j * m.pole_pairs * angle)
        i_seen = 2.0 / 3.0 * np.sum(read * _DIRECTIONS) * np.conj(seen)
        wanted = complex(
            excitation.i_d_A * switched[k],
            excitation.i_q_A * math.cos(2.0 * math.pi * excitation.i_q_Hz * k * T_S),
        )
        u_next = (20.0 * (wanted - i_seen) + 1j * m.pole_pairs * omega_m * m.psi_r_Wb) * seen
        u_next *= min(1.0, U_DC / math.sqrt(3.0) / max(abs(u_next), 1e-9))
        values = (*read, u_next.real, u_next.imag, U_DC, math.fmod(angle, 2.0 * math.pi), omega_m)
        for name, value in zip(_UNITS, values, strict=True):
            found[name][k] = value
        for _ in range(_STEPS):
            i_dq, omega_m, theta_m = _heun(truth, i_dq, omega_m, theta_m, u_now, T_S / _STEPS, held)
        if excitation.speed_rad_s is not None:
            swung = math.sin(2.0 * math.pi * excitation.swing_Hz * (k + 1) * T_S)
            omega_m = excitation.speed_rad_s + excitation.swing_rad_s * swung
    return Block.from_arrays(1.0 / T_S, _UNITS, **found)


def _heun(
    truth: Truth, i_dq: complex, omega_m: float, theta_m: float, u_s: complex, h: float, held: bool
) -> tuple[complex, float, float]:
    first = _rates(truth, i_dq, omega_m, theta_m, u_s, held)
    i_then, omega_then, theta_then = i_dq + h * first[0], omega_m + h * first[1], theta_m + h * omega_m
    second = _rates(truth, i_then, omega_then, theta_then, u_s, held)
    return (
        i_dq + 0.5 * h * (first[0] + second[0]),
        omega_m + 0.5 * h * (first[1] + second[1]),
        theta_m + 0.5 * h * (omega_m + omega_then),
    )


def _rates(
    truth: Truth, i_dq: complex, omega_m: float, theta_m: float, u_s: complex, held: bool
) -> tuple[complex, float]:
    m, omega_e = truth.motor, truth.motor.pole_pairs * omega_m
    angle = m.pole_pairs * theta_m
    cos, sin = math.cos(angle), math.sin(angle)
    if truth.dead_time_V:
        i_alpha, i_beta = i_dq.real * cos - i_dq.imag * sin, i_dq.real * sin + i_dq.imag * cos
        across = 0.5 * math.sqrt(3.0) * i_beta
        a, b, c = (
            math.copysign(truth.dead_time_V, i)
            for i in (i_alpha, across - 0.5 * i_alpha, -across - 0.5 * i_alpha)
        )
        u_s -= complex((2.0 * a - b - c) / 3.0, (b - c) / math.sqrt(3.0))
    u_d, u_q = u_s.real * cos + u_s.imag * sin, u_s.imag * cos - u_s.real * sin
    di_d = (u_d - m.R_s_ohm * i_dq.real + omega_e * m.L_q_H * i_dq.imag) / m.L_d_H
    di_q = (u_q - m.R_s_ohm * i_dq.imag - omega_e * (m.L_d_H * i_dq.real + m.psi_r_Wb)) / m.L_q_H
    torque = 1.5 * m.pole_pairs * (m.psi_r_Wb + (m.L_d_H - m.L_q_H) * i_dq.real) * i_dq.imag
    rubbing = truth.friction_Nms * omega_m + (math.copysign(truth.coulomb_Nm, omega_m) if omega_m else 0.0)
    torque -= truth.cogging_Nm * math.sin(truth.cogging_order * theta_m)
    return complex(di_d, di_q), 0.0 if held else (torque - rubbing) / m.J_kgm2


@cache
def excited_capture() -> Block:
    """A machine as it is believed, without flaws of its sensors but their steps, 0.3 s."""
    return capture(Truth(), Excitation(i_q_Hz=5.0), 3000)


def motor_with(**changes: float) -> Motor:
    """Return the motor of the examples with changed parameters."""
    return Motor.model_validate(EXAMPLE_MOTOR.model_dump() | changes)
