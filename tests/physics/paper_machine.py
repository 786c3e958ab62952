"""A core with the paper's machine, set up as its profile does."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.core import Core
from benchtool.emulator.machine.sensor_truth import SensorTruth
from benchtool.emulator.machine.train_truth import NOTHING, TrainTruth
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.protocol.dictionary.objects import ObjectTable, table_from_toml
from benchtool.shipped import shipped

MOTOR: dict[str, Any] = {
    "pole_pairs": 4,
    "R_s_ohm": 0.123,
    "L_d_H": 9.52e-3,
    "L_q_H": 9.52e-3,
    "psi_r_Wb": 0.1685,
    "J_kgm2": 13.1e-4,
}
PARAMETERS: dict[str, Any] = {
    "pole_pairs": 4,
    "R_s": 0.123,
    "L_d": 9.52e-3,
    "L_q": 9.52e-3,
    "psi_r": 0.1685,
    "J": 13.1e-4,
    "T_N": 9.55,
    "omega_m_N": 157.1,
    "u_s": 81.65,
    "T_k_ratio": 0.7,
    "K_p_speed": 0.04,
    "K_i_speed": 0.4,
    "torque_limit": 9.55,
    "omega_observer": 160.0,
    "omega_m_trip": 220.0,
    "u_dc_min": 50.0,
    "u_dc_max": 400.0,
}
FINE: dict[str, Any] = {"adc_bits": 24, "encoder_lines": 10_000_000}  # sensors that hide nothing


@cache
def object_table() -> ObjectTable:
    document = (shipped("firmware_protocol") / "objects.toml").read_text(encoding="utf-8")
    return table_from_toml(tomllib.loads(document))


def make_core(
    *,
    motor: dict[str, Any] | None = None,
    inverter: dict[str, Any] | None = None,
    sensors: dict[str, Any] | None = None,
    parameters: dict[str, Any] | None = None,
    train: TrainTruth = NOTHING,
    seed: int = 0,
    control_period_s: float = 1e-4,
) -> Core:
    """The paper's machine with changes."""
    core = Core(
        object_table(),
        MotorTruth(**{**MOTOR, **(motor or {})}),
        InverterTruth(**{"u_dc_V": 122.5, **(inverter or {})}),
        SensorTruth(**{"i_full_scale_A": 15.0, "u_full_scale_V": 500.0, **(sensors or {})}),
        seed,
        train=train,
        control_period_s=control_period_s,
    )
    level = {"i_trip": 0.96 * core.sensors.i_full_scale_A}
    for name, value in {**PARAMETERS, **level, **(parameters or {})}.items():
        core.memory[name] = value
    assert not core.memory["i_trip"][0] > core.sensors.i_full_scale_A, "no current could trip"
    core.memory["encoder_lines"] = core.sensors.encoder_lines
    return core


def captured(core: Core, names: list[str], rows: int) -> dict[str, NDArray[np.float64]]:
    """Float signals of the next `rows` ticks."""
    core.capture.arm(names=names, rows=rows)
    core.run(rows)
    data = core.capture.rows().view(np.float32).astype(np.float64)
    return dict(zip(names, data.T, strict=True))
