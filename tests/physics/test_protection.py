"""Trips: nan, readings at the end of a range, and levels that the machine reaches."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control.laws import Law
from benchtool.emulator.control.protection import Trip, overload, trips
from benchtool.emulator.memory import CONTROL, MEASUREMENT
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


@pytest.mark.parametrize("times", [1.05, 1.5, 3.0])
def test_an_overload_trips_after_the_time_of_the_first_order_lag(times: float) -> None:
    memory = make_core(parameters={"i2t_current": 5.0, "i2t_tau": 0.2}).memory[0]
    measurement: Any = np.zeros(1, MEASUREMENT)[0]
    control: Any = np.zeros(1, CONTROL)[0]
    ticks = 0
    while overload(memory, control, measurement) == 0:
        angle = 0.03 * ticks  # the length of the vector counts, wherever it points
        for phase, behind in (("i_a", 0.0), ("i_b", 1.0), ("i_c", 2.0)):
            measurement[phase] = times * 5.0 * math.cos(angle - behind * 2.0 * math.pi / 3.0)
        ticks += 1
    assert ticks * 1e-4 == pytest.approx(0.2 * math.log(times**2 / (times**2 - 1.0)), abs=3e-4)
    measurement["i_a"] = measurement["i_b"] = measurement["i_c"] = 0.0
    for _ in range(2000):
        overload(memory, control, measurement)
    assert memory["i2t_level"] == pytest.approx(math.exp(-1.0), rel=2e-3), "it cools as slowly"


@pytest.mark.parametrize(("borne", "current"), [(5.0, math.nan), (5.0, math.inf), (0.0, 0.0), (5.0, 1e30)])
def test_a_heat_that_cannot_be_told_trips(borne: float, current: float) -> None:
    memory = make_core(parameters={"i2t_current": borne, "i2t_tau": 0.1}).memory[0]
    measurement: Any = np.zeros(1, MEASUREMENT)[0]
    control: Any = np.zeros(1, CONTROL)[0]
    measurement["i_b"] = current
    assert Trip(overload(memory, control, measurement)) is Trip.OVERLOAD
    assert math.isfinite(memory["i2t_level"])


@pytest.mark.parametrize("times", [0.5, 1.0])
def test_what_is_borne_does_not_trip(times: float) -> None:
    memory = make_core(parameters={"i2t_current": 5.0, "i2t_tau": 0.1}).memory[0]
    measurement: Any = np.zeros(1, MEASUREMENT)[0]
    control: Any = np.zeros(1, CONTROL)[0]
    measurement["i_a"], measurement["i_b"] = times * 5.0, -0.5 * times * 5.0
    measurement["i_c"] = measurement["i_b"]
    for _ in range(10_000):
        assert overload(memory, control, measurement) == 0
    assert memory["i2t_level"] == pytest.approx(times**2, rel=1e-3)


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
