"""Targets, halt and quick stop as CiA 402 has them, by a master that knows objects and controlwords."""

from __future__ import annotations

import pytest

from benchtool.bench.session import Session
from benchtool.drive import RemoteDrive
from benchtool.errors import SdoAbort
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.cia402 import State

from .conftest import Wire, over_both_wires

ENABLED, HALTED, QUICK_STOP = 0x0F, 0x10F, 0x02
VELOCITY, TORQUE = 3, 4
TARGET_REACHED = 0x400
TARGETS = ("target_torque", "target_velocity", "torque_command", "omega_m_command")


@pytest.fixture
def drive(wire: Wire) -> RemoteDrive:
    """A drive without supervision, as of a master that has not asked for it."""
    return wire.session.drive


def word(drive: RemoteDrive, *words: int) -> None:
    """Write controlwords."""
    for each in words:
        drive.write("controlword", each)


def up(drive: RemoteDrive, mode: int = VELOCITY, last: int = ENABLED) -> None:
    """Switch on step by step."""
    drive.write("mode_of_operation", mode)
    word(drive, 0x06, 0x07, last)


def targets(drive: RemoteDrive) -> list[float]:
    """As they read back."""
    return [drive.number(name) for name in TARGETS]


def reached(drive: RemoteDrive) -> bool:
    """Bit 10 of the statusword."""
    return bool(int(drive.number("statusword")) & TARGET_REACHED)


@over_both_wires
@pytest.mark.parametrize("name", ["target_velocity", "omega_m_command"])
def test_a_velocity_written_before_enabling_is_what_the_drive_runs_at(drive: RemoteDrive, name: str) -> None:
    drive.write("mode_of_operation", VELOCITY)
    drive.write(name, 15.0)
    assert drive.number(name) == 15.0
    up(drive)
    assert drive.number(name) == drive.number("omega_m_command") == 15.0
    drive.clock.wait(0.4)
    assert drive.number("omega_m") == pytest.approx(15.0, abs=0.5)


@over_both_wires
def test_a_torque_written_before_enabling_is_made(wire: Wire, drive: RemoteDrive) -> None:
    assert wire.session.load is not None
    wire.session.load.hold(20.0)
    drive.write("mode_of_operation", TORQUE)
    drive.write("target_torque", 0.1)
    up(drive, TORQUE)
    drive.clock.wait(0.1)
    assert drive.number("torque") == pytest.approx(drive.number("torque_command"), abs=0.1)
    assert drive.number("torque_command") == pytest.approx(0.955, abs=0.001)


@over_both_wires
@pytest.mark.parametrize("down", [[0x07], [0x06], [0x00], [QUICK_STOP]])
def test_disabling_by_controlword_keeps_the_target(drive: RemoteDrive, down: list[int]) -> None:
    up(drive)
    drive.write("target_velocity", 15.0)
    drive.clock.wait(0.2)
    word(drive, *down)
    drive.clock.wait(0.5)
    assert drive.state() is not State.OPERATION_ENABLED
    assert drive.number("target_velocity") == 15.0
    up(drive)
    drive.clock.wait(0.3)
    assert drive.number("omega_m") == pytest.approx(15.0, abs=0.5)


def fault(session: Session) -> None:
    drive = session.drive
    drive.write("u_dc_max", 100.0)
    drive.clock.wait(0.01)
    assert drive.state() is State.FAULT


def lose_link(session: Session) -> None:
    drive = session.drive
    drive.write("abort_connection_option", "disable_voltage")
    drive.write("host_heartbeat", 127 << 16 | 100)
    drive.link.send_heartbeat()
    drive.clock.wait(0.2)
    assert drive.read("link_state") == "lost"


@over_both_wires
@pytest.mark.parametrize("cause", ["fault", "link", "nmt stop", "nmt reset node", "mode"])
def test_what_calls_for_a_fresh_command_zeroes_the_targets(wire: Wire, cause: str) -> None:
    drive = wire.session.drive
    drive.write("mode_of_operation", VELOCITY)
    drive.write("target_torque", 1.0)
    drive.write("target_velocity", 15.0)
    assert 0.0 not in targets(drive)
    match cause:
        case "fault":
            fault(wire.session)
        case "link":
            lose_link(wire.session)
        case "nmt stop":
            wire.send(0x000, 2, 1)
            wire.send(0x000, 128, 1)
        case "nmt reset node":
            wire.send(0x000, 129, 1)
        case "mode":
            drive.write("mode_of_operation", VELOCITY)
            assert 0.0 not in targets(drive), "it is no change"
            drive.write("mode_of_operation", TORQUE)
    assert targets(drive) == [0.0] * 4


@over_both_wires
def test_halt_stands_still_and_goes_on(wire: Wire, drive: RemoteDrive) -> None:
    up(drive)
    drive.write("target_velocity", 40.0)
    drive.clock.wait(0.4)
    assert not reached(drive)
    word(drive, HALTED)
    assert not reached(drive)
    drive.clock.wait(0.3)
    assert drive.state() is State.OPERATION_ENABLED
    assert reached(drive)
    assert abs(drive.number("omega_m")) < 0.5
    assert drive.number("target_velocity") == 40.0
    assert wire.session.load is not None
    wire.session.load.apply(3.0)
    drive.clock.wait(0.3)
    assert abs(drive.number("omega_m")) < 0.5
    assert drive.number("torque") == pytest.approx(3.0, abs=0.3)
    wire.session.load.apply(0.0)
    drive.write("target_velocity", 20.0)
    word(drive, ENABLED)
    drive.clock.wait(0.6)
    assert drive.number("omega_m") == pytest.approx(20.0, abs=0.5)
    assert not reached(drive)


@over_both_wires
def test_a_start_with_halt_is_a_start_that_waits(drive: RemoteDrive) -> None:
    drive.write("mode_of_operation", VELOCITY)
    drive.write("target_velocity", 15.0)
    up(drive, last=HALTED)
    drive.clock.wait(0.2)
    assert drive.state() is State.OPERATION_ENABLED
    assert abs(drive.number("omega_m")) < 0.5
    word(drive, ENABLED)
    drive.clock.wait(0.3)
    assert drive.number("omega_m") == pytest.approx(15.0, abs=0.5)


@over_both_wires
def test_halt_ends_a_stimulus_and_admits_none(drive: RemoteDrive) -> None:
    up(drive)
    drive.write("stimulus_quantity", "speed")
    drive.write("stimulus_shape", "constant")
    drive.write("stimulus_amplitude", 5.0)
    drive.write("stimulus_ticks", 100_000)
    drive.write("stimulus_control", "start")
    drive.clock.wait(0.1)
    assert drive.read("stimulus_state") == "running"
    word(drive, HALTED)
    drive.clock.wait(0.01)
    assert drive.read("stimulus_state") == "idle"
    with pytest.raises(SdoAbort) as refused:
        drive.write("stimulus_control", "start")
    assert refused.value.code == Abort.DEVICE_STATE


@over_both_wires
@pytest.mark.parametrize(("option", "stays"), [(2, False), (5, True), (6, True)])
@pytest.mark.parametrize("omega_m", [40.0, -40.0])
def test_a_quick_stop_ends_as_its_option_says(
    drive: RemoteDrive, option: int, stays: bool, omega_m: float
) -> None:
    drive.write("quick_stop_option", option)
    up(drive)
    drive.write("target_velocity", omega_m)
    drive.clock.wait(0.4)
    word(drive, QUICK_STOP)
    assert drive.state() is State.QUICK_STOP_ACTIVE
    drive.clock.wait(0.5)
    assert abs(drive.number("omega_m")) < 0.5
    if stays:
        assert drive.state() is State.QUICK_STOP_ACTIVE
        assert reached(drive)
        word(drive, ENABLED)
        assert drive.state() is State.QUICK_STOP_ACTIVE, "transition 16 is not supported"
        word(drive, 0x00)
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert not reached(drive)


@over_both_wires
def test_a_hold_ends_with_the_link(drive: RemoteDrive) -> None:
    drive.write("abort_connection_option", "quick_stop")
    drive.write("quick_stop_option", 6)
    drive.write("host_heartbeat", 127 << 16 | 400)
    drive.link.send_heartbeat()
    up(drive)
    word(drive, QUICK_STOP)
    drive.clock.wait(0.3)
    assert drive.state() is State.QUICK_STOP_ACTIVE
    drive.clock.wait(0.4)
    assert drive.state() is State.SWITCH_ON_DISABLED


# ---- transfers that do not tell their length, from a master on the bus -------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "length"),
    [((0x6040, 0), 0x06, 2), ((0x6060, 0), 0x03, 1), ((0x60FF, 0), 15_000, 4), ((0x1017, 0), 250, 2)],
)
def test_an_expedited_download_without_size_is_taken(
    wire: Wire, key: tuple[int, int], value: int, length: int
) -> None:
    index, sub = key
    wire.frames()
    wire.send(0x601, 0x22, index & 0xFF, index >> 8, sub, *value.to_bytes(4, "little"))
    assert (0x581, bytes([0x60, index & 0xFF, index >> 8, sub, 0, 0, 0, 0])) in wire.frames()
    assert wire.session.drive.link.upload(index, sub) == value.to_bytes(length, "little")
