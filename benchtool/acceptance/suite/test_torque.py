"""Torque: its accuracy and ripple over the torque-speed map, its step, its limit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.acceptance import Attach, Measure
from benchtool.acceptance.suite.conditions import (
    SETTLE_S,
    load_machine,
    making_torque,
    number,
    rating,
    recorded,
    require_objects,
)
from benchtool.bench import Session
from benchtool.drive import Stimulus
from benchtool.plan import Record
from benchtool.protocol import Mode
from benchtool.report import draw_map, draw_traces
from benchtool.run import capture_stimulus

_TORQUES, _SPEEDS = (0.3, 0.9), (0.25, 0.9)
_CHANNELS = ("torque", "torque_reference", "omega_m")
_QUADRANTS = {
    "drives_forward": (1, 1),
    "brakes_forward": (-1, 1),
    "drives_backward": (-1, -1),
    "brakes_backward": (1, -1),
}


@pytest.mark.requirement("ACC-TORQUE", "ACC-RIPPLE")
@pytest.mark.parametrize("quadrant", list(_QUADRANTS))
def test_map(bench_session: Session, measure: Measure, attach: Attach, quadrant: str) -> None:
    """Over a quadrant of the map the torque is the one that was asked for, by the drive's estimate and on the
    shaft, and its ripple is within its limit."""
    require_objects(bench_session, *_CHANNELS)
    load_machine(bench_session)
    limits = rating(bench_session)
    signs = _QUADRANTS[quadrant]
    errors = []
    for part in _TORQUES:
        for of_speed in _SPEEDS:
            torque_Nm = signs[0] * part * limits.torque_Nm
            omega = signs[1] * of_speed * limits.omega_m_rad_s
            with making_torque(bench_session, torque_Nm, omega):
                duration_s = min(
                    0.4, max(0.02, math.ceil(0.02 / limits.period_s(omega)) * limits.period_s(omega))
                )
                block, shaft = recorded(bench_session, duration_s, _CHANNELS)
            place = f"[{part * signs[0]:+g} T, {of_speed * signs[1]:+g} n]"
            T_N = limits.T_N_Nm
            held = float(np.mean(block.column("omega_m"))) / omega
            estimate = block.column("torque")
            measure(f"speed_reached{place}", held, "", min=0.98, max=1.02)
            error = (float(np.mean(estimate)) - torque_Nm) / T_N
            measure(f"torque_error{place}", error, "T_N", min=-0.01, max=0.01)
            measure(f"torque_ripple_rms{place}", float(np.std(estimate)) / T_N, "T_N", max=0.03)
            if shaft is not None:
                true = shaft.column("torque_transducer")
                error = (float(np.mean(true)) - torque_Nm) / T_N
                measure(f"shaft_torque_error{place}", error, "T_N", min=-0.02, max=0.02)
                measure(f"shaft_ripple_rms{place}", float(np.std(true)) / T_N, "T_N", max=0.06)
            errors.append((omega, torque_Nm, error))
    attach.picture(
        "torque_error",
        lambda: draw_map(
            errors, "Error of the torque in parts of T_N", 0.02, "omega_m (rad/s)", "torque (Nm)"
        ),
    )


@pytest.mark.requirement("ACC-STEP")
@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["up", "down"])
def test_step(bench_session: Session, measure: Measure, attach: Attach, direction: float) -> None:
    """The torque follows a step fast, without much overshoot, and stays there."""
    require_objects(bench_session, "stimulus_control", *_CHANNELS)
    limits = rating(bench_session)
    T_s = limits.control_period_s
    amplitude_Nm = direction * 0.6 * limits.torque_Nm
    stimulus = Stimulus(
        quantity="torque", shape="constant", amplitude_Nm=amplitude_Nm, duration_s=400.0 * T_s
    )
    record = Record.model_construct(
        duration_s=450.0 * T_s, channels=_CHANNELS, stride=1, pretrigger_s=50.0 * T_s
    )
    with making_torque(bench_session, 0.0, 0.3 * limits.omega_m_rad_s):
        block, _ = capture_stimulus(bench_session, record, stimulus)
    torque = block.column("torque") / amplitude_Nm
    after = torque[50:450]
    reached = np.flatnonzero(after >= 0.9)
    law = bench_session.drive.read("law") if "law" in bench_session.drive.dictionary else ""
    lag_s = 3.0 / number(bench_session, "omega_current", 1e9) if law == "foc" else 0.0
    attach.picture(
        "step",
        lambda: draw_traces(block, (("torque", "torque_reference"),), "Torque step", {"step": 50.0 * T_s}),
    )
    reach_s = float(reached[0]) * T_s if len(reached) else None
    measure("time_to_90_percent", reach_s, "s", max=30.0 * T_s + 3.0 * lag_s)
    measure("overshoot", float(after.max()) - 1.0, "", max=0.3)
    measure("torque_after_the_step", float(np.mean(after[-150:])), "", min=0.95, max=1.05)
    measure("torque_before_the_step", float(np.mean(torque[:45])), "", min=-0.1, max=0.1)


@pytest.mark.requirement("ACC-LIMITS")
@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["positive", "negative"])
def test_torque_limit(bench_session: Session, measure: Measure, direction: float) -> None:
    """The torque stays within its limit, and the drive says that it limits."""
    require_objects(bench_session, "torque_limit", "torque_command", "statusword", *_CHANNELS)
    drive = bench_session.drive
    limits = rating(bench_session)
    before = drive.number("torque_limit")
    lower_Nm = 0.3 * limits.torque_Nm
    drive.write("torque_limit", lower_Nm)
    try:
        with making_torque(bench_session, direction * 0.6 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
            block, _ = recorded(bench_session, 0.1, _CHANNELS)
            word = int(drive.number("statusword"))
    finally:
        drive.write("torque_limit", before)
    found = direction * float(np.mean(block.column("torque"))) / lower_Nm
    measure("torque_over_its_limit", found, "", min=0.95, max=1.05)
    measure("says_that_it_limits", word >> 11 & 1, min=1)


@pytest.mark.requirement("ACC-TORQUE")
def test_enabling_makes_no_torque(bench_session: Session, measure: Measure) -> None:
    """A drive that is enabled without a command makes no torque."""
    require_objects(bench_session, *_CHANNELS)
    limits = rating(bench_session)
    with bench_session.drive.enabled(Mode.TORQUE):
        block, _ = recorded(bench_session, SETTLE_S, _CHANNELS)
    measure(
        "torque_without_command",
        float(np.mean(block.column("torque"))) / limits.T_N_Nm,
        "T_N",
        min=-0.02,
        max=0.02,
    )
