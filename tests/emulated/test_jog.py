"""Setpoints from the host: frames on the wire, and the drive disabled at every exit."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import pytest
from typer.testing import CliRunner

from benchtool.bench.session import Session
from benchtool.cli import app
from benchtool.errors import DriveFault, ValueRefused
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.modes import Mode
from benchtool.run.jog import jog

from .conftest import Wire, over_both_wires

NODE = 1
RPDO = 0x200 + NODE
SDO_REQUEST = 0x600 + NODE


def _always(value: float) -> Callable[[float], float]:
    return lambda _: value


def test_a_speed_is_held_by_setpoint_frames(wire: Wire) -> None:
    session = wire.session
    session.drive.connect()
    wire.frames()
    result = jog(
        session.drive, session.profile.motor, Mode.VELOCITY, lambda _: 15.0, duration_s=0.5, rate_Hz=200.0
    )
    assert result.omega_m_rad_s == pytest.approx(15.0, abs=0.3)
    assert (result.pacing.sent, result.pacing.late) == (100, 0)
    setpoints = [data for can_id, data in wire.frames() if can_id == RPDO]
    assert setpoints == [bytes.fromhex("00000000 00007041")] * 100
    assert session.drive.state() is State.SWITCH_ON_DISABLED
    assert int(session.drive.number("0x1400:1")) >> 31, "the frame is out of use again"


@over_both_wires
def test_setpoints_are_a_function_of_time(wire: Wire) -> None:
    session = wire.session
    session.drive.connect()
    result = jog(
        session.drive,
        session.profile.motor,
        Mode.TORQUE,
        lambda time_s: 0.0 if time_s < 0.15 else 0.4,
        duration_s=0.2,
        rate_Hz=1000.0,
    )
    assert result.torque_Nm == pytest.approx(0.4, abs=0.05)


def test_beyond_the_rating_nothing_is_sent(wire: Wire) -> None:
    session = wire.session
    session.drive.connect()
    wire.frames()
    for mode, value in ((Mode.VELOCITY, -158.0), (Mode.TORQUE, 9.6), (Mode.TORQUE, float("nan"))):
        with pytest.raises(ValueRefused, match="the profile rates the motor at"):
            jog(session.drive, session.profile.motor, mode, _always(value), duration_s=0.1)
    assert [can_id for can_id, _ in wire.frames() if can_id in (RPDO, SDO_REQUEST)] == []


@over_both_wires
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_an_interruption_leaves_the_drive_disabled(wire: Wire, error: type[BaseException]) -> None:
    session = wire.session
    session.drive.connect()

    def setpoint(time_s: float) -> float:
        if time_s > 0.05:
            raise error
        return 10.0

    with pytest.raises(error):
        jog(session.drive, session.profile.motor, Mode.VELOCITY, setpoint, duration_s=1.0)
    assert session.drive.state() is State.SWITCH_ON_DISABLED
    assert session.drive.number("omega_m_command") == 0.0
    assert int(session.drive.number("0x1400:1")) >> 31


_RPDO1 = ["0x1400:1", "0x1400:2", *(f"0x1600:{sub}" for sub in range(5))]


def _rpdo1(session: Session) -> list[int]:
    return [int(session.drive.number(label)) for label in _RPDO1]


@pytest.mark.parametrize("used", [False, True])
@pytest.mark.parametrize("end", [None, KeyboardInterrupt, DriveFault, ValueRefused])
def test_rpdo1_is_put_back_on_every_way_out(wire: Wire, used: bool, end: type[BaseException] | None) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.write("0x1400:2", 254)
    drive.write("0x1600:1", drive.dictionary["torque_command"].mapping)
    drive.write("0x1600:2", drive.dictionary["target_velocity"].mapping)
    drive.write("0x1600:0", 1)
    if used:
        drive.write("0x1400:1", 0x321)
    before = _rpdo1(wire.session)

    def setpoint(time_s: float) -> float:
        assert _rpdo1(wire.session) != before
        if time_s > 0.02 and end is not None:
            raise end
        return 10.0

    with nullcontext() if end is None else pytest.raises(end):
        jog(
            drive,
            wire.session.profile.motor,
            Mode.VELOCITY,
            lambda time_s: 10.0 if time_s == 0.0 else setpoint(time_s),
            duration_s=0.05,
        )
    assert _rpdo1(wire.session) == before
    assert drive.state() is State.SWITCH_ON_DISABLED


def _without(dictionary: Dictionary, name: str, **changes: Any) -> Dictionary:
    """The dictionary with another description of one variable, as a vendor's EDS may have it."""
    changed = replace(dictionary[name], **changes)
    return replace(dictionary, variables={**dictionary.variables, name: changed})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mappable": False}, "cannot be in an RPDO: its EDS says PDOMapping=0"),
        ({"access": "ro"}, "AccessType=ro"),
        ({"type": DataType.F64}, "12 bytes together, an RPDO has 8"),
        ({"raw_maximum": 5.0}, "its limits are"),
    ],
)
def test_setpoints_that_cannot_be_sent_are_refused_before_the_drive_is_enabled(
    wire: Wire, monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], said: str
) -> None:
    drive = wire.session.drive
    drive.connect()
    before = _rpdo1(wire.session)
    monkeypatch.setattr(drive, "dictionary", _without(drive.dictionary, "omega_m_command", **changes))
    wire.frames()
    with pytest.raises(ValueRefused, match=said):
        jog(drive, wire.session.profile.motor, Mode.VELOCITY, _always(10.0), duration_s=0.1)
    written = [data for can_id, data in wire.frames() if can_id == SDO_REQUEST and data[0] >> 5 == 1]
    assert not [data for data in written if data[1:3] in (b"\x40\x60", b"\x60\x60")], (
        "no controlword, no mode"
    )
    assert _rpdo1(wire.session) == before


def test_a_mode_that_the_drive_has_not_is_refused_before_it_is_enabled(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = wire.session.drive
    drive.connect()
    number = drive.number
    monkeypatch.setattr(drive, "number", lambda name: 0x8 if name is Role.SUPPORTED_MODES else number(name))
    with pytest.raises(ValueRefused, match=r"no velocity mode \(0x6502:0 is 0x8, torque of those"):
        jog(drive, wire.session.profile.motor, Mode.VELOCITY, _always(10.0), duration_s=0.1)
    assert drive.state() is State.SWITCH_ON_DISABLED


def test_a_setpoint_that_grows_beyond_the_rating_ends_it_unsent(wire: Wire) -> None:
    session = wire.session
    session.drive.connect()
    wire.frames()
    with pytest.raises(ValueRefused, match="the setpoint is 10 Nm"):
        jog(
            session.drive,
            session.profile.motor,
            Mode.TORQUE,
            lambda t: 0.0 if t < 0.05 else 10.0,
            duration_s=1,
        )
    assert {data for can_id, data in wire.frames() if can_id == RPDO} == {bytes(8)}
    assert session.drive.state() is State.SWITCH_ON_DISABLED


@over_both_wires
def test_a_fault_ends_it(wire: Wire) -> None:
    session = wire.session
    session.drive.connect()
    session.drive.write("i_trip", 0.5)
    with pytest.raises(DriveFault, match="0x2310"):
        jog(session.drive, session.profile.motor, Mode.TORQUE, lambda _: 2.0, duration_s=1.0)
    assert session.drive.state() is State.FAULT


def test_the_command_says_how_even_it_was() -> None:
    result = CliRunner().invoke(app, ["jog", "--torque", "0.05", "--duration", "0.1", "--json"])
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["pacing"]["sent"] == 10
    assert document["pacing"]["period_mean_s"] == pytest.approx(0.01)
    assert document["clock"] == "virtual"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--duration", "1"), "neither of --speed and --torque"),
        (("--duration", "1", "--speed", "1", "--torque", "1"), "both of --speed and --torque"),
        (("--duration", "1", "--speed", "1000"), "the profile rates the motor at 157.1 rad/s"),
        (("--duration", "1", "--speed", "1", "--rate", "2000"), "at most 1000"),
    ],
)
def test_mistakes_on_the_command_line(arguments: tuple[str, ...], complaint: str) -> None:
    result = CliRunner().invoke(app, ["jog", *arguments])
    assert result.exit_code == 2
    assert complaint in result.stderr
    assert result.stdout == ""
