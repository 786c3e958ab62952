"""Computed captures that every analysis can answer, which the catalogue is held against."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.profile import Motor

EXAMPLE_MOTOR: Final = Motor(
    pole_pairs=4,
    R_s_ohm=0.1,
    L_d_H=1e-2,
    L_q_H=1e-2,
    psi_r_Wb=0.1,
    J_kgm2=1e-3,
    T_N_Nm=2.0,
    omega_m_N_rad_s=200.0,
    I_N_A_rms=5.0,
)

_RATE_HZ: Final = 1e4
_UNITS: Final = {
    **dict.fromkeys(("i_a", "i_b", "i_c"), "A"),
    **dict.fromkeys(("psi_s", "psi_alpha", "psi_beta"), "Wb"),
    **dict.fromkeys(("u_alpha", "u_beta", "u_dc"), "V"),
    "torque": "Nm",
    "theta_m": "rad",
    "omega_m": "rad/s",
}


def steady_capture() -> tuple[Block, Block]:
    """A steady state with every channel that an analysis needs, and the capture of a torque transducer.

    0.3 s of a machine with four pole pairs at 12.5 revolutions a second, 15 electrical periods, with noise.
    """
    rows = 3000
    theta_e = 2.0 * np.pi * 50.0 * np.arange(rows) / _RATE_HZ
    noise = np.random.default_rng(0).standard_normal((16, rows))
    third = 2.0 * np.pi / 3.0
    torque = 1.0 + 0.1 * np.cos(6.0 * theta_e)
    block = Block.from_arrays(
        _RATE_HZ,
        _UNITS,
        i_a=np.cos(theta_e) + 0.01 * np.cos(5.0 * theta_e) + 1e-3 * noise[0],
        i_b=np.cos(theta_e - third) + 1e-3 * noise[1],
        i_c=np.cos(theta_e + third) + 1e-3 * noise[2],
        torque=torque + 1e-3 * noise[3],
        psi_s=0.1 + 1e-4 * noise[4],
        psi_alpha=0.1 * np.cos(theta_e) + 1e-4 * noise[5],
        psi_beta=0.1 * np.sin(theta_e) + 1e-4 * noise[6],
        theta_m=np.mod(theta_e / EXAMPLE_MOTOR.pole_pairs, 2.0 * np.pi),
        omega_m=2.0 * np.pi * 12.5 + 1e-3 * noise[7],
        u_alpha=40.0 * np.cos(theta_e) + 0.1 * noise[8],
        u_beta=40.0 * np.sin(theta_e) + 0.1 * noise[9],
        u_dc=100.0 + 0.1 * noise[10],
        switching_count=3.0 * np.arange(rows),
    )
    shaft: NDArray[np.float64] = np.repeat(torque, 2) + 1e-3 * noise[11:13].reshape(-1)
    return block, Block.from_arrays(2.0 * _RATE_HZ, {"torque_transducer": "Nm"}, torque_transducer=shaft)


def step_capture() -> Block:
    """`torque` follows a step of `torque_reference` with a lag."""
    after = np.maximum(0, np.arange(400) - 100)
    noise = np.random.default_rng(0).standard_normal(len(after))
    signal = 1.0 - np.exp(-0.05 * after) + 1e-3 * noise
    units = {"torque": "Nm", "torque_reference": "Nm"}
    reference = np.where(after > 0, 1.0, 0.0)
    return Block.from_arrays(_RATE_HZ, units, torque=signal, torque_reference=reference)


def response_capture() -> Block:
    """`torque` follows the random signs of `torque_reference` with a lag."""
    demand = np.sign(np.random.default_rng(0).standard_normal(8192))
    answer = np.convolve(demand, 0.3 * 0.7 ** np.arange(40))[: len(demand)]
    units = {"torque": "Nm", "torque_reference": "Nm"}
    return Block.from_arrays(_RATE_HZ, units, torque_reference=demand, torque=answer)
