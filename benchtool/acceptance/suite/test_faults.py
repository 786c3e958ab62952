"""Faults that every drive must name: each is provoked by its level, as nothing is broken for it."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np
import pytest

from benchtool.acceptance import Attach, Measure
from benchtool.acceptance.suite.conditions import (
    armed,
    making_torque,
    number,
    quiet,
    rating,
    recorded,
    require_objects,
    starts,
    torque_ends_s,
)
from benchtool.bench import Session
from benchtool.errors import BenchError
from benchtool.protocol import Mode
from benchtool.protocol.canopen import ErrorCode
from benchtool.protocol.dictionary import Role
from benchtool.report import draw_traces

pytestmark = pytest.mark.requirement("ACC-FAULTS")

_CHANNELS = ("torque", "omega_m", "switching_count")
_TAU_S, _BORNE = 0.2, 1.25


@dataclass(frozen=True)
class Provoked:
    """A fault and its level: where the present value is `within` it nothing happens, `beyond` it trips.

    Both are levels in parts of the present value; `of` names what that is of.
    """

    level: str
    of: str
    code: ErrorCode
    within: float
    beyond: float


FAULTS = {
    "overcurrent": Provoked("i_trip", "current", ErrorCode.OVERCURRENT, 1.25, 0.65),
    "overspeed": Provoked("omega_m_trip", "omega_m", ErrorCode.OVERSPEED, 1.25, 0.7),
    "undervoltage": Provoked("u_dc_min", "u_dc", ErrorCode.DC_LINK_UNDERVOLTAGE, 0.8, 1.3),
    "overvoltage": Provoked("u_dc_max", "u_dc", ErrorCode.DC_LINK_OVERVOLTAGE, 1.2, 0.7),
    "overtemperature": Provoked("temperature_trip", "winding_temperature", ErrorCode.TEMPERATURE, 1.25, 0.65),
}


@pytest.mark.parametrize("fault", list(FAULTS))
def test_fault(bench_session: Session, measure: Measure, attach: Attach, fault: str) -> None:
    """Beyond its level a fault switches off at once, is named once, latched, and can be reset; within it
    nothing happens."""
    provoked = FAULTS[fault]
    drive = bench_session.drive
    require_objects(bench_session, provoked.level, *_CHANNELS)
    limits = rating(bench_session)
    before = drive.number(provoked.level)
    torque_Nm, omega = 0.5 * limits.torque_Nm, 0.4 * limits.omega_m_rad_s
    with making_torque(bench_session, torque_Nm, omega):
        present = _present(bench_session, provoked)
        within = min(provoked.within * present, _highest(bench_session, provoked))
        drive.write(provoked.level, within)
        quiet(bench_session, 0.05)
        tripped_within = drive.state().value.startswith("fault")
        drive.write(provoked.level, before)  # laws keep the current below the level by their ripple
        quiet(bench_session, 0.05)
        capture = armed(bench_session, 0.1, _CHANNELS)
        quiet(bench_session, 0.02)
        told = drive.tick_now()
        drive.write(provoked.level, min(provoked.beyond * present, _highest(bench_session, provoked)))
        quiet(bench_session, 0.1)
        state = drive.state()
        emergencies = [each.code for each in drive.emergencies() if each.code]
        code = int(drive.number(Role.ERROR_CODE))
        noted = number(bench_session, "error_history_count", 0.0) and drive.number("error_1")
        block = capture.read()
        enabled = starts(bench_session)
        drive.write(provoked.level, before)
        drive.reset_fault()
        after = drive.number(Role.ERROR_CODE)
        with drive.enabled(Mode.TORQUE):
            drive.wait(0.02)
            restarted, _ = recorded(bench_session, 0.02, ("torque",))
            torque_after = float(np.mean(restarted.column("torque"))) / limits.T_N_Nm
    drive.emergencies()
    assert told is not None
    attach.picture(
        fault,
        lambda: draw_traces(
            block, (("torque",), ("omega_m",)), fault, {"level": (told - block.first_tick) * block.tick_s}
        ),
    )
    measure("tripped_within_its_level", tripped_within, max=0)
    measure("in_fault", state.value.startswith("fault"), min=1)
    measure("time_to_no_torque", torque_ends_s(block, 0.05 * limits.T_N_Nm, told), "s", min=-0.002, max=0.01)
    measure("emergencies", len(emergencies), min=1, max=1)
    measure("emergency_code", emergencies[0] if emergencies else None, min=provoked.code, max=provoked.code)
    measure("error_code", code, min=provoked.code, max=provoked.code)
    if "error_1" in drive.dictionary:
        measure("error_history", int(noted) & 0xFFFF, min=provoked.code, max=provoked.code)
    measure("enabled_without_a_reset", enabled, max=0)
    measure("error_code_after_the_reset", after, max=0)
    measure("torque_after_the_restart", torque_after, "T_N", min=-0.08, max=0.08)


def test_fault_that_stays(bench_session: Session, measure: Measure) -> None:
    """A fault whose cause stays is not reset for long: the drive cannot be enabled."""
    require_objects(bench_session, "u_dc_max", "u_dc")
    drive = bench_session.drive
    rating(bench_session)
    before = drive.number("u_dc_max")
    drive.write("u_dc_max", 0.7 * drive.number("u_dc"))
    quiet(bench_session, 0.05)
    with contextlib.suppress(BenchError):
        drive.reset_fault()
    quiet(bench_session, 0.05)
    enabled = starts(bench_session)
    drive.write("u_dc_max", before)
    quiet(bench_session, 0.02)
    drive.reset_fault()
    drive.emergencies()
    measure("enabled_with_its_cause", enabled, max=0)


@pytest.mark.requirement("ACC-I2T")
def test_overload(bench_session: Session, measure: Measure, attach: Attach) -> None:
    """A current that is borne at length heats to its square, one that is not trips after the time of the
    thermal model, is named, latched, and can be reset once the winding has cooled (I2t)."""
    require_objects(bench_session, "i2t_current", "i2t_tau", "i2t_level", *_CHANNELS)
    drive = bench_session.drive
    limits = rating(bench_session)
    before = {name: drive.number(name) for name in ("i2t_current", "i2t_tau")}
    try:
        with making_torque(bench_session, 0.5 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
            block, _ = recorded(bench_session, 0.05, ("i_d", "i_q"))
            present_A = float(np.sqrt(np.mean(block.column("i_d") ** 2 + block.column("i_q") ** 2)))
            drive.write("i2t_tau", _TAU_S)
            drive.write("i2t_current", _BORNE * present_A)
            drive.wait(6.0 * _TAU_S)
            warm = drive.number("i2t_level")
            capture = armed(bench_session, 2.0 * _TAU_S, (*_CHANNELS, "i2t_level"))
            told = drive.tick_now()
            drive.write("i2t_current", present_A / _BORNE)
            quiet(bench_session, 2.0 * _TAU_S)
            state = drive.state()
            emergencies = [each.code for each in drive.emergencies() if each.code]
            block = capture.read()
            enabled = starts(bench_session)
    finally:
        drive.write("i2t_current", max(before["i2t_current"], drive.number("i2t_current")))
        drive.write("i2t_tau", _TAU_S)
        quiet(bench_session, 8.0 * _TAU_S)
        for name, value in before.items():
            drive.write(name, value)
    with contextlib.suppress(BenchError):
        drive.reset_fault()
    drive.emergencies()
    assert told is not None
    attach.picture(
        "overload",
        lambda: draw_traces(
            block,
            (("i2t_level",), ("torque",)),
            "Overload over time",
            {"told": (told - block.first_tick) * block.tick_s},
        ),
    )
    target = _BORNE**2
    expected_s = _TAU_S * float(np.log((target - warm) / (target - 1.0)))
    off_s = torque_ends_s(block, 0.05 * limits.T_N_Nm, told)
    measure("heat_of_a_current_that_is_borne", warm * target, "", min=0.9, max=1.1)
    measure("time_to_no_torque", off_s, "s", min=0.8 * expected_s, max=1.2 * expected_s)
    measure("in_fault", state.value.startswith("fault"), min=1)
    measure("emergencies", len(emergencies), min=1, max=1)
    code = int(ErrorCode.OVERLOAD)
    measure("emergency_code", emergencies[0] if emergencies else None, min=code, max=code)
    measure("enabled_without_a_reset", enabled, max=0)
    measure("reset_when_cool", drive.state().value.startswith("fault"), max=0)


def _present(session: Session, provoked: Provoked) -> float:
    """Return the value that the level is held against, now."""
    if provoked.of == "current":
        block, _ = recorded(session, 0.02, ("i_d", "i_q"))
        return float(np.mean(np.hypot(block.column("i_d"), block.column("i_q"))))
    return abs(session.drive.number(provoked.of))


def _highest(session: Session, provoked: Provoked) -> float:
    """Return the highest level that the drive takes."""
    drive = session.drive
    highest = {"i_trip": "i_full_scale", "u_dc_max": "u_dc_full_scale", "u_dc_min": "u_dc_max"}.get(
        provoked.level
    )
    if highest is None or highest not in drive.dictionary or not (most := drive.number(highest)):
        return float("inf")
    return most
