"""PDOs of the drive: set up by the host as CiA 301 has it, paced in drive time, setpoints in one frame."""

from __future__ import annotations

import math
import struct

import pytest

from benchtool.errors import SdoAbort, ValueRefused
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.cob_id import INVALID
from benchtool.protocol.canopen.pdo import tpdo
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.telemetry import Setpoints

from .conftest import Wire, over_both_wires

NODE = 1
TORQUE = 0x20300C20
TICK = 0x20300120


def _pdos(wire: Wire) -> list[tuple[int, bytes]]:
    return [frame for frame in wire.frames() if 0x180 < frame[0] < 0x580]


def _set_up(wire: Wire, number: int, *mappings: int, period_s: float = 0.01) -> None:
    for label, value in tpdo(NODE, mappings, number).set_up(period_s):
        wire.session.drive.write(label, value)


def test_tpdos_tell_of_one_tick_in_the_order_of_their_identifiers(wire: Wire) -> None:
    for number in (2, 5, 1):
        _set_up(wire, number, TICK, TORQUE)
    wire.session.clock.wait(0.05)
    assert _pdos(wire) == [], "not before the NMT state operational"
    wire.send(0x000, 0x01, NODE)
    wire.session.clock.wait(0.05)
    frames = _pdos(wire)
    assert [can_id for can_id, _ in frames] == [0x181, 0x1C1, 0x281] * 5
    ticks = [struct.unpack_from("<I", data)[0] for _, data in frames]
    assert ticks == [tick for tick in range(600, 1100, 100) for _ in range(3)]
    assert wire.session.drive.number("stream_sequence") == 5
    wire.send(0x000, 0x80, NODE)
    wire.session.clock.wait(0.05)
    assert _pdos(wire) == [], "nor after it"


def test_each_has_its_own_period(wire: Wire) -> None:
    _set_up(wire, 1, TICK, period_s=0.01)
    _set_up(wire, 2, TICK, period_s=0.025)
    wire.send(0x000, 0x01, NODE)
    wire.frames()
    wire.session.clock.wait(0.1)
    ids = [can_id for can_id, _ in _pdos(wire)]
    assert (ids.count(0x181), ids.count(0x281)) == (10, 4)


@pytest.mark.parametrize(
    ("label", "value", "code"),
    [
        ("0x1A00:1", 0x20000220, Abort.NOT_MAPPABLE),  # R_s, a parameter
        ("0x1A00:1", 0x20300C10, Abort.NOT_MAPPABLE),  # 16 bits of a signal of 32
        ("0x1A00:1", 0x55550120, Abort.NO_OBJECT),
        ("0x1A00:0", 5, Abort.VALUE_HIGH),
        ("0x1A00:0", 1, Abort.NO_OBJECT),  # nothing is mapped there
        ("0x1600:1", TORQUE, Abort.NOT_MAPPABLE),  # a signal cannot be received
        ("0x1800:2", 1, Abort.VALUE_LOW),  # SYNC
        ("0x1800:1", 0x20000181, Abort.VALUE),  # 29 bits
        ("0x1800:1", 0x00000080, Abort.VALUE),  # SYNC's identifier
        ("0x1800:1", 0x00000601, Abort.VALUE),  # an SDO's
    ],
)
def test_a_mapping_that_cannot_be_is_refused(wire: Wire, label: str, value: int, code: Abort) -> None:
    drive = wire.session.drive
    variable = drive.dictionary[label]
    with pytest.raises(SdoAbort) as refused:
        drive.link.download(
            variable.index, variable.sub, struct.pack(f"<{'I' if variable.type == 'u32' else 'B'}", value)
        )
    assert refused.value.code == code


def test_more_than_eight_bytes_are_refused(wire: Wire) -> None:
    drive = wire.session.drive
    for position in (1, 2, 3):
        drive.write(f"0x1A00:{position}", TORQUE)
    drive.write("0x1A00:0", 2)
    with pytest.raises(SdoAbort) as refused:
        drive.write("0x1A00:3", TICK)
    assert refused.value.code == Abort.UNSUPPORTED_ACCESS, "sub-index 0 has to be 0 first"
    with pytest.raises(SdoAbort) as refused:
        drive.write("0x1A00:0", 3)
    assert refused.value.code == Abort.MAPPING_TOO_LONG


def test_a_pdo_in_use_keeps_its_mapping_and_identifier(wire: Wire) -> None:
    drive = wire.session.drive
    _set_up(wire, 1, TICK)
    for label, value in (("0x1A00:0", 0), ("0x1A00:1", TORQUE), ("0x1800:1", 0x182)):
        with pytest.raises(SdoAbort):
            drive.write(label, value)
    drive.write("0x1800:1", INVALID | 0x182)
    drive.write("0x1800:1", 0x182)


@pytest.mark.parametrize("command", [0x81, 0x82], ids=["reset node", "reset communication"])
def test_a_reset_takes_every_pdo_out_of_use(wire: Wire, command: int) -> None:
    _set_up(wire, 1, TICK)
    wire.send(0x000, command, NODE)
    wire.send(0x000, 0x01, NODE)
    wire.session.clock.wait(0.05)
    assert _pdos(wire) == []
    assert wire.session.drive.read("tpdo1_mapping_count") == 0
    assert wire.session.drive.read("tpdo1_cob_id") == 0xC0000180 + NODE


# ---- setpoints ---------------------------------------------------------------------------------------------


def test_a_setpoint_frame_moves_the_motor(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    setpoints = Setpoints(drive)
    with drive.enabled(Mode.VELOCITY):
        setpoints.send(omega_m_rad_s=12.5)
        drive.wait(0.5)
        assert drive.number("omega_m_command") == 12.5
        assert drive.number("omega_m") == pytest.approx(12.5, abs=0.5)
    assert (0x201, struct.pack("<ff", 0.0, 12.5)) in wire.frames()


def test_setpoint_frames_feed_the_link_supervision_and_reads_do_not(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    setpoints = Setpoints(drive)
    drive.enable(Mode.TORQUE)
    drive.stop_heartbeat()
    for _ in range(10):
        wire.session.clock.wait(0.3)
        setpoints.send()
    assert drive.state() is State.OPERATION_ENABLED
    for _ in range(10):
        wire.session.clock.wait(0.1)
        drive.read("torque")
    assert drive.state() is State.FAULT
    assert drive.read("link_state") == "lost"


@pytest.mark.parametrize(
    "data",
    [
        struct.pack("<ff", 0.5, float("nan")),
        struct.pack("<ff", float("inf"), 1.0),
        struct.pack("<f", 0.5),
        b"",
    ],
    ids=["nan behind a value", "infinite", "short", "empty"],
)
def test_a_setpoint_frame_is_taken_whole_or_not_at_all_and_then_feeds_nothing(
    wire: Wire, data: bytes
) -> None:
    drive = wire.session.drive
    drive.connect()
    setpoints = Setpoints(drive)
    drive.enable(Mode.TORQUE)
    setpoints.send(torque_Nm=0.1, omega_m_rad_s=2.0)
    drive.stop_heartbeat()
    for _ in range(4):
        wire.session.clock.wait(0.1)
        wire.send(0x201, *data)
    assert drive.number("torque_command") == pytest.approx(0.1)
    assert drive.number("omega_m_command") == 2.0
    assert drive.number("rpdo_dropped") == 4
    wire.session.clock.wait(0.2)
    assert drive.read("link_state") == "lost"


def test_setpoint_frames_are_taken_in_operational_only(wire: Wire) -> None:
    drive = wire.session.drive
    setpoints = Setpoints(drive)
    wire.send(0x000, 0x80, NODE)
    setpoints.send(torque_Nm=1.0)
    assert drive.number("torque_command") == 0.0
    wire.send(0x000, 0x01, NODE)
    setpoints.send(torque_Nm=1.0)
    assert drive.number("torque_command") == 1.0
    setpoints.close()
    setpoints.send(torque_Nm=2.0)
    assert drive.number("torque_command") == 1.0


@over_both_wires
@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["torque_Nm", "omega_m_rad_s"])
def test_a_setpoint_that_is_no_number_leaves_the_one_before(wire: Wire, name: str, wrong: float) -> None:
    drive = wire.session.drive
    drive.connect()
    setpoints = Setpoints(drive)
    setpoints.send(torque_Nm=0.5, omega_m_rad_s=3.0)
    with pytest.raises(ValueRefused):
        setpoints.send(**{name: wrong})
    wire.session.clock.wait(0.01)
    assert (drive.number("torque_command"), drive.number("omega_m_command")) == (0.5, 3.0)


def test_a_setpoint_that_is_no_number_is_not_sent(wire: Wire) -> None:
    setpoints = Setpoints(wire.session.drive)
    wire.frames()
    with pytest.raises(ValueRefused, match="finite"):
        setpoints.send(torque_Nm=float("nan"))
    assert wire.frames() == []
