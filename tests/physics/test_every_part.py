"""What a machine can have beyond the ideal one, compiled together: as the plain functions do."""

from __future__ import annotations

from typing import Any

import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import kernel_of, run_ticks
from benchtool.emulator.machine.heat import HeatTruth
from tests.physics.paper_machine import make_core
from tests.physics.test_accounts import INVERTER, MECHANICS, imbalance
from tests.physics.test_asymmetry import MOTOR, NO_TRIP, WIDE

HEAT = HeatTruth(C_winding_J_K=2e-3, C_body_J_K=5e-3, R_winding_body_K_W=0.8, R_body_ambient_K_W=2.0)
EVERYTHING: dict[str, Any] = {**MOTOR, **MECHANICS, "R_fe_ohm": 80.0, "heat": HEAT}
FIELDS = ("i_d", "i_q", "omega_m", "theta_e", "u_dc", "T_winding", "T_magnet")


def started() -> Core:
    core = make_core(motor=EVERYTHING, inverter=INVERTER, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.omega_m, core.load.torque_Nm = 60.0, 0.5
    return core


def modulated(core: Core, kernel: Any) -> None:
    """Two periods of these duties, then the stage is switched off under current."""
    core.command.pwm_enabled = 1
    for _ in range(2):
        core._controls["duty_a"], core._controls["duty_b"], core._controls["duty_c"] = 0.7, 0.3, 0.5
        core._controls["gated"] = 1
        core.run_with(kernel, 1)
    core.command.pwm_enabled = 0
    core.run_with(kernel, 2)


def test_compiled_and_plain_functions_agree() -> None:
    compiled, plain = started(), started()
    modulated(compiled, kernel_of(compiled._truth))
    modulated(plain, run_ticks)
    for field in FIELDS:
        assert float(compiled.shaft[field]) == pytest.approx(float(plain.shaft[field]), rel=1e-10, abs=1e-10)
    for name, energy in plain.energies_J().items():
        assert compiled.energies_J()[name] == pytest.approx(energy, rel=1e-9, abs=1e-12)
    assert compiled.shaft["T_winding"] > 25.0
    assert imbalance(compiled) < 1e-9
