"""Torque a period ahead, on a machine integrated finely and sampled as a drive does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.torque.residual import NEEDED, torque_residual
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.profile import Motor

T_S = 1e-4
STEPS = 50
MOTOR = Motor(
    pole_pairs=3,
    R_s_ohm=0.5,
    L_d_H=4e-3,
    L_q_H=7e-3,
    psi_r_Wb=0.12,
    J_kgm2=1e-3,
    T_N_Nm=5.0,
    omega_m_N_rad_s=200.0,
    I_N_A_rms=5.0,
)
UNITS = {"i_a": "A", "i_b": "A", "i_c": "A", "u_alpha": "V", "u_beta": "V", "torque": "Nm"}


def _record(rows: int = 400, omega_m: float = 60.0) -> tuple[Block, Block]:
    """A salient machine at constant speed, fed with the voltage asked one period before, as a drive does."""
    rng = np.random.default_rng(3)
    omega_e, h = MOTOR.pole_pairs * omega_m, T_S / STEPS
    i_d, i_q, theta_m = -1.0, 6.0, 0.4
    table: list[list[float]] = []
    fine: list[float] = []
    applied = asked = 0j
    for _ in range(rows):
        theta_e = MOTOR.pole_pairs * theta_m
        applied = asked
        steady = MOTOR.R_s_ohm * (-1.0 + 6.0j) + 1j * omega_e * (MOTOR.psi_r_Wb - 4e-3 + 7e-3 * 6.0j)
        ahead = np.exp(1j * (theta_e + 1.5 * omega_e * T_S))
        asked = (steady + 8.0 * complex(*rng.standard_normal(2))) * ahead
        i_s = (i_d + 1j * i_q) * np.exp(1j * theta_e)
        phases = [float((i_s * np.exp(-2j * np.pi / 3 * k)).real) for k in range(3)]
        row = [*phases, np.mod(theta_m, 2 * np.pi), omega_m, asked.real, asked.imag, _torque(i_d, i_q)]
        table.append([float(value) for value in row])
        for _ in range(STEPS):
            fine.append(_torque(i_d, i_q))
            # midpoint rule
            half_d, half_q = (
                x + 0.5 * h * slope
                for x, slope in zip((i_d, i_q), _slopes(i_d, i_q, applied, theta_m, omega_e), strict=True)
            )
            theta_m += 0.5 * h * omega_m
            slopes = _slopes(half_d, half_q, applied, theta_m, omega_e)
            theta_m += 0.5 * h * omega_m
            i_d, i_q = i_d + h * slopes[0], i_q + h * slopes[1]
    channels = tuple(Channel(name, UNITS.get(name, "")) for name in NEEDED)
    transducer = Block(
        (Channel("torque_transducer", "Nm"),), 0, 1, T_S / STEPS, np.array(fine)[:, np.newaxis]
    )
    return Block(channels, 0, 1, T_S, np.array(table)), transducer


def _torque(i_d: float, i_q: float) -> float:
    psi_d, psi_q = MOTOR.L_d_H * i_d + MOTOR.psi_r_Wb, MOTOR.L_q_H * i_q
    return 1.5 * MOTOR.pole_pairs * (psi_d * i_q - psi_q * i_d)


def _slopes(i_d: float, i_q: float, u_s: complex, theta_m: float, omega_e: float) -> tuple[float, float]:
    u = u_s * np.exp(-1j * MOTOR.pole_pairs * theta_m)
    psi_d, psi_q = MOTOR.L_d_H * i_d + MOTOR.psi_r_Wb, MOTOR.L_q_H * i_q
    return (
        float(u.real - MOTOR.R_s_ohm * i_d + omega_e * psi_q) / MOTOR.L_d_H,
        float(u.imag - MOTOR.R_s_ohm * i_q - omega_e * psi_d) / MOTOR.L_q_H,
    )


def _values(block: Block, motor: Motor, transducer: Block | None = None) -> dict[str, float]:
    return {each.name: each.value for each in torque_residual(block, motor, transducer)}


@pytest.fixture(scope="module")
def record() -> tuple[Block, Block]:
    return _record()


def test_the_right_parameters_leave_almost_nothing(record: tuple[Block, Block]) -> None:
    block, transducer = record
    ripple_Nm = float(np.std(block.column("torque")))
    found = _values(block, MOTOR, transducer)
    assert ripple_Nm > 0.2
    assert found["torque_residual_max"] < 2e-3 * ripple_Nm
    assert found["torque_residual_percent_of_ripple"] < 0.1
    # a period's torque is bent, its ends know of the chord: small, but more than the prediction's error
    assert found["transducer_torque_residual_rms"] < 2e-2 * ripple_Nm
    assert abs(found["transducer_torque_residual_mean"]) < 5e-3 * ripple_Nm


@pytest.mark.parametrize("key", ["R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb"])
@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_wrong_parameter_shows(record: tuple[Block, Block], key: str, factor: float) -> None:
    block, _ = record
    wrong = MOTOR.model_copy(update={key: factor * getattr(MOTOR, key)})
    right, found = _values(block, MOTOR), _values(block, wrong)
    assert found["torque_residual_rms"] > 5.0 * right["torque_residual_rms"]


def test_a_voltage_taken_a_period_too_early_shows(record: tuple[Block, Block]) -> None:
    block, _ = record
    data = block.data.copy()
    for name in ("u_alpha", "u_beta"):
        column = NEEDED.index(name)
        data[:-1, column] = data[1:, column]
    early = Block(block.channels, 0, 1, T_S, data)
    assert _values(early, MOTOR)["torque_residual_rms"] > 100 * _values(block, MOTOR)["torque_residual_rms"]


def test_the_mean_shows_the_flux_linkage_with_its_sign(record: tuple[Block, Block]) -> None:
    block, _ = record

    def mean(psi_r_Wb: float) -> float:
        return _values(block, MOTOR.model_copy(update={"psi_r_Wb": psi_r_Wb}))["torque_residual_mean"]

    means: NDArray[np.float64] = np.array([mean(psi) for psi in (0.10, 0.12, 0.14)])
    assert means[0] < -0.01
    assert abs(means[1]) < 1e-4
    assert means[2] > 0.01


def test_it_takes_every_tick_and_enough_of_them(record: tuple[Block, Block]) -> None:
    block, _ = record
    sparse = Block(block.channels, 0, 2, T_S, block.data[::2])
    with pytest.raises(AnalysisError, match="holds one tick in 2"):
        torque_residual(sparse, MOTOR)
    with pytest.raises(AnalysisError, match="5 rows to predict"):
        torque_residual(Block(block.channels, 0, 1, T_S, block.data[:5]), MOTOR)


def test_what_has_no_uncertainty_says_why() -> None:
    block, shaft = _record()
    bare = [each for each in torque_residual(block, MOTOR, shaft) if each.uncertainty is None]
    assert bare
    assert all(each.uncertainty_reason or each.reason for each in bare)
