"""Energy accounts balance, over everything that a bench can have at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.train_truth import NOTHING, LoadTruth, ShaftTruth, TrainTruth
from tests.physics.paper_machine import make_core
from tests.physics.test_asymmetry import MOTOR, NO_TRIP, WIDE, run_duties
from tests.physics.test_saturation import MADE, SYMMETRIC

MECHANICS: dict[str, Any] = {
    "friction_Nms": 1e-3,
    "coulomb_Nm": 0.02,
    "cogging_Nm": 0.03,
    "cogging_order": 18,
}
INVERTER: dict[str, Any] = {
    "u_dc_V": 60.0,
    "dead_time_s": 2e-6,
    "device_drop_V": 1.1,
    "on_resistance_ohm": 0.02,
    "energy_accounts": True,
}
MOTORS: dict[str, dict[str, Any]] = {
    "phases differ": {**MOTOR, **MECHANICS, "R_fe_ohm": 80.0},
    "saturates": {**SYMMETRIC, **MECHANICS, "saturation": SaturationTruth(**MADE)},
}


def core_with(motor: dict[str, Any], train: TrainTruth = NOTHING) -> Core:
    core = make_core(motor=motor, inverter=INVERTER, sensors=WIDE, parameters=NO_TRIP, train=train)
    core.shaft.omega_m = 60.0
    return core


def imbalance(core: Core) -> float:
    """What the accounts leave of the energy drawn, over all that was moved."""
    energy = core.energies_J()
    rest = energy["dc"] - sum(value for name, value in energy.items() if name != "dc")
    return abs(rest) / sum(abs(value) for value in energy.values())


@pytest.mark.parametrize("name", MOTORS)
def test_accounts_balance_over_a_transient(name: str) -> None:
    """Dead time, currents through zero, a stage that is switched off under current, and rectification."""
    core = core_with(MOTORS[name])
    core.load.torque_Nm = 0.5
    run_duties(core, np.random.default_rng(2).choice([0.0, 1.0, 0.5, 0.7, 0.3], (6, 3)))
    core.command.pwm_enabled = 0
    core.run_with(run_ticks, 3)
    core.load.held, core.load.omega_m_rad_s = 1, 500.0
    core.run_with(run_ticks, 6)
    assert core.energies_J()["dc"] != 0.0
    assert imbalance(core) < 1e-9


@pytest.mark.parametrize("stiffness_Nm_rad", [0.0, 50.0], ids=["rigid", "elastic"])
def test_the_shaft_takes_what_the_drive_train_does(stiffness_Nm_rad: float) -> None:
    """What is rigid on the rotor is in its kinetic energy, a load behind a coupling in the shaft's."""
    shaft = ShaftTruth(J_load_kgm2=2e-3, coupling_Nm_rad=stiffness_Nm_rad)
    core = core_with(MOTORS["phases differ"], TrainTruth(shaft=shaft, load=LoadTruth(quadratic_Nms2=1e-4)))
    core.shaft.omega_load = 60.0
    run_duties(core, np.random.default_rng(2).choice([0.0, 1.0, 0.5, 0.7, 0.3], (4, 3)))
    assert core.energies_J()["shaft"] != 0.0
    assert imbalance(core) < 1e-9
