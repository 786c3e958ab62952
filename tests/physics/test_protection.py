"""Trips: nan, readings at the end of a range, and levels that the machine reaches."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control.laws import Law
from benchtool.emulator.control.protection import Trip, trips
from benchtool.emulator.memory import MEASUREMENT
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import make_core

LEVELS = {"i_trip": 12.0, "omega_m_trip": 220.0, "u_dc_min": 50.0, "u_dc_max": 400.0}
OF_LEVEL = {
    "i_trip": Trip.OVERCURRENT,
    "omega_m_trip": Trip.OVERSPEED,
    "u_dc_min": Trip.UNDERVOLTAGE,
    "u_dc_max": Trip.OVERVOLTAGE,
}


def tripped(
    *, levels: dict[str, float] | None = None, omega_m: float = 10.0, on: bool = True, **measured: float
) -> Trip:
    memory = make_core(parameters={**LEVELS, **(levels or {})}).memory[0]
    measurement: Any = np.zeros(1, MEASUREMENT)[0]
    for name, value in {"u_dc": 122.5, **measured}.items():
        measurement[name] = value
    return Trip(trips(memory, measurement, omega_m, on))


@pytest.mark.parametrize(
    ("given", "trip"),
    [
        ({}, Trip(0)),
        ({"i_a": 12.0, "i_b": -12.0}, Trip(0)),
        ({"i_a": 12.01}, Trip.OVERCURRENT),
        ({"i_b": -12.01}, Trip.OVERCURRENT),
        ({"i_c": -12.01, "on": False}, Trip.OVERCURRENT),
        ({"omega_m": -220.1, "on": False}, Trip.OVERSPEED),
        ({"omega_m": 220.0}, Trip(0)),
        ({"u_dc": 50.0}, Trip(0)),
        ({"u_dc": 49.9}, Trip.UNDERVOLTAGE),
        ({"u_dc": 49.9, "on": False}, Trip(0)),
        ({"u_dc": 400.0}, Trip(0)),
        ({"u_dc": 400.1, "on": False}, Trip.OVERVOLTAGE),
        ({"saturated": 1}, Trip.OVERCURRENT),
        ({"saturated": 1, "on": False}, Trip(0)),
        ({"u_dc_saturated": 1, "on": False}, Trip.OVERVOLTAGE),
        ({"i_a": math.nan}, Trip.OVERCURRENT),
        ({"i_c": math.nan}, Trip.OVERCURRENT),
        ({"omega_m": math.nan}, Trip.OVERSPEED),
        ({"u_dc": math.nan}, Trip.UNDERVOLTAGE | Trip.OVERVOLTAGE),
    ],
)
def test_what_trips(given: dict[str, Any], trip: Trip) -> None:
    assert tripped(**given) == trip


@pytest.mark.parametrize("name", LEVELS)
def test_a_level_that_is_no_number_trips(name: str) -> None:
    assert tripped(levels={name: math.nan}) == OF_LEVEL[name]


def test_a_current_beyond_the_converters_range_trips_whatever_the_level() -> None:
    """A flux of 35 A is asked for. What is measured stays at 12.5 A, so that the flux is raised for ever."""
    core = make_core(sensors={"i_full_scale_A": 12.5}, parameters={"psi_s_command": 0.5})
    core.memory["i_trip"] = 300.0  # as no write could
    core.load.held = 1
    core.command.pwm_enabled = 1
    assert core.run(5000) < 5000
    assert Trip(int(core.command.trip)) == Trip.OVERCURRENT
    assert math.hypot(core.shaft.i_d, core.shaft.i_q) < 30.0


def test_a_dc_link_beyond_the_converters_range_trips_at_its_end() -> None:
    core = make_core(inverter={"u_dc_V": 600.0})
    core.memory["u_dc_max"] = 1000.0
    core.run(1)
    assert Trip(int(core.command.trip)) == Trip.OVERVOLTAGE


@pytest.mark.parametrize("law", Law)
def test_normal_running_at_rated_torque_is_no_overcurrent_with_half_again_its_current(law: Law) -> None:
    core = make_core(
        sensors={"i_full_scale_A": 15.0},
        parameters={"law": int(law), "torque_band": 0.1, "K_p_delta": 0.03, "omega_current": 2000.0},
    )
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 15.71
    core.load.torque_Nm = 5.0
    assert core.run(5000) == 5000
    assert core.command.trip == 0
