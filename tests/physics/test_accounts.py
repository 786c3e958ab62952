"""Energy accounts balance, over everything that a bench can have at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.energies import NAMES
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


BALANCES = {
    "supply": ("link_resistance", "chopper", "capacitor", "dc"),
    "dc": ("copper", "iron", "inverter", "friction", "shaft", "magnetic", "kinetic"),
    "shaft": ("coupling", "twist", "load_kinetic", "load"),
}


def imbalance(core: Core) -> float:
    """What the worst of the balances leaves of the energy drawn, over all that was moved."""
    energy = core.energies.now_J()
    moved = sum(abs(value) for value in energy.values())
    return max(
        abs(energy[drawn] - sum(energy[part] for part in parts)) / moved for drawn, parts in BALANCES.items()
    )


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
    assert core.energies.now_J()["dc"] != 0.0
    assert imbalance(core) < 1e-9


SHAFTS: dict[str, dict[str, float]] = {
    "rigid": {},
    "elastic": {"coupling_Nm_rad": 50.0, "coupling_Nms": 0.02},
    "with play": {"coupling_Nm_rad": 50.0, "coupling_Nms": 0.02, "backlash_rad": 2e-4},
}


@pytest.mark.parametrize("name", SHAFTS)
def test_the_shaft_takes_what_the_drive_train_does(name: str) -> None:
    """What is rigid on the rotor is in its kinetic energy, a load behind a coupling in the shaft's; faces of
    a coupling meet and part."""
    shaft = ShaftTruth(J_load_kgm2=2e-3, **SHAFTS[name])
    core = core_with(MOTORS["phases differ"], TrainTruth(shaft=shaft, load=LoadTruth(quadratic_Nms2=1e-4)))
    core.shaft.omega_load = 62.0 if name == "with play" else 60.0
    run_duties(core, np.random.default_rng(2).choice([0.0, 1.0, 0.5, 0.7, 0.3], (4, 3)))
    energy = core.energies.now_J()
    assert energy["shaft"] != 0.0
    assert imbalance(core) < 1e-9
    # By the state at the end: 0.5 J omega^2 of the load.
    J_load = 2e-3 if name != "rigid" else 0.0
    began = 62.0 if name == "with play" else 60.0
    stored = 0.5 * J_load * (float(core.shaft.omega_load) ** 2 - began**2)
    assert energy["load_kinetic"] == pytest.approx(stored, rel=1e-9)


def test_a_row_of_energies_for_every_tick() -> None:
    """The rows hold the accounts as they are at each tick, from the tick on at which recording starts."""
    core = core_with(MOTORS["saturates"])
    core.run_with(run_ticks, 1)
    core.energies.start(3)
    at_ticks = [core.energies.now_J()]
    for _ in range(5):
        core.run_with(run_ticks, 1)
        at_ticks.append(core.energies.now_J())
    block = core.energies.block()
    assert (block.first_tick, block.stride, block.tick_s) == (1, 1, 1e-4)
    assert [dict(zip(NAMES, row, strict=True)) for row in block.data.tolist()] == at_ticks[:4]
    assert block.names == tuple(f"energy_{name}" for name in NAMES)
    assert np.ptp(block.column("energy_kinetic")) > 0.0
