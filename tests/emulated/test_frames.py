"""What is on the wire, byte by byte, as any CAN analyser would see it."""

from __future__ import annotations

import binascii
import struct

from benchtool.drive import Capture, CaptureRequest
from benchtool.protocol.modes import Mode

from .conftest import Wire

NODE = 1
HOST = 127


def test_boot_up_then_heartbeats_every_100_ms(wire: Wire) -> None:
    assert wire.frames() == [(0x700 + NODE, b"\x00")]
    wire.session.clock.wait(0.35)
    assert wire.frames() == [(0x700 + NODE, b"\x7f")] * 3


def test_nmt_moves_the_state_that_the_heartbeat_tells(wire: Wire) -> None:
    wire.frames()
    for command, state in ((0x01, 0x05), (0x02, 0x04), (0x80, 0x7F)):
        wire.send(0x000, command, NODE)
        wire.session.clock.wait(0.1)
        assert wire.frames() == [(0x700 + NODE, bytes([state]))]
    wire.send(0x000, 0x81, 0x00)
    assert wire.frames() == [(0x700 + NODE, b"\x00")]


def test_commands_to_other_nodes_and_nonsense_are_ignored(wire: Wire) -> None:
    wire.frames()
    wire.send(0x000, 0x02, NODE + 1)
    wire.send(0x000, 0x55, NODE)
    wire.send(0x000, 0x02)
    wire.send(0x600 + NODE + 1, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0)
    wire.session.clock.wait(0.1)
    assert wire.frames() == [(0x700 + NODE, b"\x7f")]


def test_expedited_upload_of_the_device_type(wire: Wire) -> None:
    wire.frames()
    wire.send(0x600 + NODE, 0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0)
    assert wire.frames() == [(0x580 + NODE, bytes.fromhex("43001000 92010200"))]


def test_refusals_carry_abort_codes(wire: Wire) -> None:
    wire.frames()
    wire.send(0x600 + NODE, 0x40, 0x55, 0x55, 0x00, 0, 0, 0, 0)
    wire.send(0x600 + NODE, 0x2B, 0x41, 0x60, 0x00, 1, 0, 0, 0)
    assert wire.frames() == [
        (0x580 + NODE, bytes.fromhex("80555500 00000206")),
        (0x580 + NODE, bytes.fromhex("80416000 02000106")),
    ]


def test_the_host_walks_the_state_machine_over_the_wire(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    wire.frames()
    drive.enable(Mode.TORQUE)
    controlwords = [
        struct.unpack_from("<H", data, 4)[0]
        for can_id, data in wire.frames()
        if can_id == 0x600 + NODE and data[:4] == bytes.fromhex("2b406000")
    ]
    assert controlwords == [0x06, 0x07, 0x0F]


def test_a_capture_is_read_by_block_upload_with_crc(wire: Wire) -> None:
    drive = wire.session.drive
    capture = Capture(drive, CaptureRequest(("tick", "torque"), rows=50))
    capture.wait()
    wire.frames()
    block = capture.read()
    frames = [(can_id - NODE, data) for can_id, data in wire.frames() if can_id in (0x581, 0x601)]

    size = 32 + 50 * 2 * 4
    assert frames[0] == (0x600, bytes.fromhex("a4422000 7f000000")), "initiate, CRC supported, 127 segments"
    assert frames[1] == (0x580, bytes.fromhex("c6422000") + struct.pack("<I", size))
    assert frames[2] == (0x600, bytes.fromhex("a3000000 00000000")), "start"
    segments = [data for can_id, data in frames[3:] if can_id == 0x580][: -(-size // 7)]
    numbers = [data[0] & 0x7F for data in segments]
    assert numbers == list(range(1, len(segments) + 1))
    assert [bool(data[0] & 0x80) for data in segments] == [False] * (len(segments) - 1) + [True]
    content = b"".join(data[1:] for data in segments)[:size]
    acknowledge, end, confirm = frames[-3:]
    assert acknowledge == (0x600, bytes([0xA2, len(segments), 0x7F, 0, 0, 0, 0, 0]))
    unused = 7 * len(segments) - size
    crc = struct.pack("<H", binascii.crc_hqx(content, 0))
    assert end == (0x580, bytes([0xC1 | unused << 2]) + crc + bytes(5))
    assert confirm == (0x600, bytes.fromhex("a1000000 00000000"))

    assert content[:4] == b"BTC1"
    assert block.ticks().tolist() == block.column("tick").tolist()


def test_a_silent_host_is_an_emergency_on_the_wire(wire: Wire) -> None:
    wire.send(0x600 + NODE, 0x23, 0x16, 0x10, 0x01, 0xF4, 0x01, HOST, 0x00)
    wire.send(0x700 + HOST, 0x05)
    wire.session.clock.wait(0.499)
    assert 0x080 + NODE not in dict(wire.frames())
    wire.session.clock.wait(0.001)
    assert (0x080 + NODE, bytes.fromhex("30811100 00000000")) in wire.frames()
