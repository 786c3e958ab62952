"""A transducer at the flange reads what the rotor passes on to the load, with its bandwidth and errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.flange import lagged
from benchtool.emulator.machine.train_truth import (
    FlangeTruth,
    LoadMachineTruth,
    LoadTruth,
    ShaftTruth,
    TrainTruth,
)
from benchtool.protocol import Mode
from tests.physics.paper_machine import make_core

COGGING: dict[str, Any] = {
    "cogging_Nm": (0.2, 0.05),
    "cogging_order": (24, 48),
    "cogging_phase_rad": (0.0, 0.7),
}
RUBBING: dict[str, Any] = {"coulomb_Nm": 0.1, "friction_Nms": 2e-3}
J, J_LOAD = 13.1e-4, 4e-3
QUICK = FlangeTruth(bandwidth_Hz=1e12)
STIFF_LINK: dict[str, Any] = {"dc_link_R_ohm": 0.01, "dc_link_C_F": 0.1}


def bench(flange: FlangeTruth = QUICK, load: LoadTruth | None = None, **motor: Any) -> Core:
    """The paper's machine with an inertia on its flange. All benches here have the same parts, those of
    `test_dc_link` too: one kernel."""
    train = TrainTruth(
        shaft=ShaftTruth(J_load_kgm2=J_LOAD),
        load=load or LoadTruth(linear_Nms=1e-12),
        flange=flange,
    )
    return make_core(motor={**COGGING, **RUBBING, **motor}, inverter=STIFF_LINK, train=train)


def recorded(core: Core, ticks: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Readings and true air-gap torque of the next ticks."""
    core.transducer.start(ticks)
    core.run(ticks)
    block = core.transducer.block()
    assert block.names == ("torque_transducer", "torque_airgap")
    return block.column("torque_transducer"), block.column("torque_airgap")


def drive(core: Core, omega_m: float, load_Nm: float, ticks: int) -> None:
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"], core.load.torque_Nm = omega_m, load_Nm
    core.run(ticks)


def order(samples: NDArray[np.float64], rate_Hz: float, frequency_Hz: float) -> float:
    """Amplitude of a sine of whole periods."""
    turns = 2j * math.pi * frequency_Hz / rate_Hz * np.arange(len(samples))
    return float(2.0 * abs(np.mean(samples * np.exp(-turns))))


def test_in_steady_state_the_flange_passes_on_the_load() -> None:
    """And the air gap that of the friction beside it; the fan takes what it takes at this speed."""
    core = bench(load=LoadTruth(linear_Nms=1e-12, quadratic_Nms2=1e-3))
    drive(core, 50.0, 2.0, 30_000)
    flange, airgap = recorded(core, 4000)
    omega_m = float(core.shaft.omega_m)
    assert omega_m == pytest.approx(50.0, rel=5e-3)
    assert flange.mean() == pytest.approx(2.0 + 1e-3 * omega_m**2, rel=5e-3)
    assert airgap.mean() - flange.mean() == pytest.approx(0.1 + 2e-3 * omega_m, rel=1e-2)


def test_under_acceleration_the_flange_accelerates_the_load() -> None:
    """At every sample it is J_load alpha + load, alpha being that of the whole shaft by Newton's law."""
    core = bench()
    drive(core, 60.0, 0.5, 600)
    flange, airgap = recorded(core, 1)
    before = float(core.shaft.omega_m)
    x, theta_m = core.shaft, float(core.shaft.theta_e) / 4
    flange, airgap = recorded(core, 40)
    assert core.shaft.omega_m > before + 1.0
    cogging = 0.2 * math.sin(24 * theta_m) + 0.05 * math.sin(48 * theta_m + 0.7)
    torque = airgap[0] - cogging - 0.1 - 2e-3 * before
    alpha = (torque - 0.5) / (J + J_LOAD)
    assert flange[0] == pytest.approx(0.5 + J_LOAD * alpha, rel=1e-9)
    gained = (float(x.omega_m) - before) / (40 * 1e-4)
    assert flange.mean() == pytest.approx(0.5 + J_LOAD * gained, rel=2e-3)


def test_at_a_held_speed_the_flange_feels_cogging_and_friction() -> None:
    """Without current: every order with its amplitude, less what the bandwidth takes of it."""
    for cut_off_Hz in (1e6, 60.0):
        core = bench(FlangeTruth(bandwidth_Hz=cut_off_Hz))
        core.load.held, core.load.omega_m_rad_s = 1, 4.0 * math.pi  # two revolutions a second
        core.run(1000)
        flange, airgap = recorded(core, 10_000)
        assert not airgap.any()
        assert flange.mean() == pytest.approx(-0.1 - 2e-3 * 4.0 * math.pi, rel=1e-3)
        for number, amplitude in ((24, 0.2), (48, 0.05)):
            kept = 1.0 / math.hypot(1.0, 2.0 * number / cut_off_Hz)
            assert order(flange, 200e3, 2.0 * number) == pytest.approx(amplitude * kept, rel=2e-4)


def test_gain_offset_and_noise_of_the_transducer() -> None:
    """Noise is that of the sample, however recordings divide the time."""
    noisy = FlangeTruth(bandwidth_Hz=1e6, gain=1.01, offset_Nm=0.3, noise_Nm_rms=0.05)
    cores = [bench(noisy), bench(noisy), bench()]
    for core in cores:
        core.load.torque_Nm = 0.05  # the shaft sticks
    whole, _ = recorded(cores[0], 600)
    parts = np.concatenate([recorded(cores[1], ticks)[0] for ticks in (7, 1, 592)])
    clean, _ = recorded(cores[2], 600)
    assert np.array_equal(whole, parts)
    assert clean == pytest.approx(0.05, abs=1e-12)
    noise = whole - (1.01 * clean + 0.3)
    assert noise.std() == pytest.approx(0.05, rel=0.03)
    assert abs(noise.mean()) < 5.0 * 0.05 / math.sqrt(len(noise))
    assert np.mean(np.abs(noise) < 0.05) == pytest.approx(math.erf(math.sqrt(0.5)), abs=0.02)


def test_the_transducer_follows_between_recordings() -> None:
    """One that lags by a second has not forgotten what it read before the recording began."""
    core = bench(FlangeTruth(bandwidth_Hz=1.0 / (2.0 * math.pi)))
    core.load.torque_Nm = 0.05
    core.run(100)
    core.load.torque_Nm = -0.05
    core.run(5000)
    flange, _ = recorded(core, 10)
    assert flange[0] == pytest.approx(-0.05 + 0.1 * math.exp(-0.5), abs=2e-5)
    core.run(5000)
    assert recorded(core, 10)[0][0] == pytest.approx(-0.05 + 0.1 * math.exp(-1.001), abs=4e-5)


def test_the_lag_is_exact_for_a_line() -> None:
    """y' = omega_c (u - y) with u = 2 + 3 t has the solution 2 + 3 (t - T) + c exp(-t / T)."""
    T, h, y = 0.02, 0.007, 5.0
    for _ in range(3):
        y, u0 = lagged(y, 2.0, 2.0 + 3.0 * h, h / T), y
        assert y == pytest.approx(2.0 + 3.0 * (h - T) + (u0 - 2.0 + 3.0 * T) * math.exp(-h / T), rel=1e-12)


def test_an_elastic_coupling_is_the_flange() -> None:
    """Its torque is what the transducer reads, at steady state that of the load, behind a load machine with
    a lag too."""
    train = TrainTruth(
        shaft=ShaftTruth(J_load_kgm2=J_LOAD, coupling_Nm_rad=300.0, coupling_Nms=2.0),
        load_machine=LoadMachineTruth(bandwidth_Hz=200.0, stiffness_Nms=5.0),
        flange=QUICK,
    )
    core = make_core(motor={"coulomb_Nm": 1.0}, train=train)
    core.load.torque_Nm = 0.7
    core.transducer.start(400)
    core.run_with(run_ticks, 400)
    flange = core.transducer.block().column("torque_transducer")
    assert flange[-1] == pytest.approx(300.0 * core.shaft.twist, rel=1e-3)
    assert flange[-200:].mean() == pytest.approx(0.7, rel=1e-2)  # the rotor sticks, and takes it
