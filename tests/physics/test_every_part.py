"""What a machine can have beyond the ideal one, compiled together: as the plain functions do."""

from __future__ import annotations

from typing import Any

import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.core.kernels import kernel_of
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.sensor_truth import CurrentTruth, EncoderTruth, VoltageTruth
from benchtool.emulator.machine.train_truth import (
    FlangeTruth,
    LoadMachineTruth,
    LoadTruth,
    ShaftTruth,
    TrainTruth,
)
from tests.physics.paper_machine import make_core
from tests.physics.test_accounts import INVERTER, MECHANICS, imbalance
from tests.physics.test_asymmetry import MOTOR, NO_TRIP, WIDE
from tests.physics.test_saturation import MADE

HEAT = HeatTruth(C_winding_J_K=2e-3, C_body_J_K=5e-3, R_winding_body_K_W=0.8, R_body_ambient_K_W=2.0)
EVERYTHING: dict[str, Any] = {
    **MOTOR,
    **MECHANICS,
    "R_fe_ohm": 80.0,
    "heat": HEAT,
    "saturation": SaturationTruth(**MADE),
}
TRAIN = TrainTruth(
    shaft=ShaftTruth(
        J_load_kgm2=1e-3,
        coupling_Nm_rad=100.0,
        coupling_Nms=0.01,
        backlash_rad=1e-3,
        unbalance_kgm=0.01,
    ),
    load=LoadTruth(
        linear_Nms=1e-3,
        quadratic_Nms2=1e-5,
        over_angle_Nm=(0.1, 0.2),
        over_time_Nm=(0.1, 0.2),
        over_time_s=1.0,
    ),
    load_machine=LoadMachineTruth(bandwidth_Hz=100.0, stiffness_Nms=1.0),
    flange=FlangeTruth(bandwidth_Hz=100.0),
)
SENSORS: dict[str, Any] = {
    **WIDE,
    "sampling_point": 0.7,
    "warm_up_K": 20.0,
    "i_a": CurrentTruth(offset_drift_A_K=0.01, bandwidth_Hz=5e3),
    "i_b": CurrentTruth(delay_s=9e-5),
    "u_dc": VoltageTruth(bandwidth_Hz=1e3, noise_V_rms=0.1),
    "encoder": EncoderTruth(relative=True, index=True, lost_every=10, eccentricity_1_rad=0.01),
}
LINK: dict[str, Any] = {
    "dc_link_R_ohm": 0.4,
    "dc_link_C_F": 1e-4,
    "supply_ripple_V": 2.0,
    "supply_ripple_Hz": 300.0,
    "chopper_R_ohm": 10.0,
    "chopper_on_V": 70.0,
    "chopper_off_V": 62.0,
}
STEP_A = 2000.0 / 2**24
FIELDS = (
    "i_d",
    "i_q",
    "psi_d",
    "psi_q",
    "omega_m",
    "theta_e",
    "u_dc",
    "T_winding",
    "T_magnet",
    "omega_load",
    "twist",
    "load_torque",
)


def started() -> Core:
    core = make_core(
        motor=EVERYTHING,
        inverter={**INVERTER, **LINK, "timer_Hz": 1e8},
        sensors=SENSORS,
        parameters=NO_TRIP,
        train=TRAIN,
    )
    core.shaft.omega_m, core.shaft.omega_load = 60.0, 58.0
    core.shaft.twist = 4e-4  # faces of the coupling meet soon
    core.shaft.u_dc = 80.0  # above what switches the chopper on
    core.load.torque_Nm = 0.5
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


@pytest.mark.slow  # of the largest kernel, which takes a quarter of a minute to compile
def test_compiled_and_plain_functions_agree() -> None:
    compiled, plain = started(), started()
    modulated(compiled, kernel_of(compiled._truth))
    modulated(plain, run_ticks)
    for field in FIELDS:
        assert float(compiled.shaft[field]) == pytest.approx(float(plain.shaft[field]), rel=1e-10, abs=1e-10)
    for name, energy in plain.energies.now_J().items():
        assert compiled.energies.now_J()[name] == pytest.approx(energy, rel=1e-9, abs=1e-12)
    assert compiled.shaft["T_winding"] > 25.0
    assert imbalance(compiled) < 1e-9
    assert min(map(abs, compiled.energies.now_J().values())) > 0.0
    read, expected = compiled._measurements[0], plain._measurements[0]
    for name in ("i_a", "i_b", "i_c", "u_dc"):
        assert getattr(read, name) == pytest.approx(getattr(expected, name), abs=2 * STEP_A)
    assert read.count == expected.count != 0
    for name in ("warm_K", "u_dc", "edge", "error", "travelled"):
        assert getattr(compiled._sensors[0], name) == pytest.approx(getattr(plain._sensors[0], name))
