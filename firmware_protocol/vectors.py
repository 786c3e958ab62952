"""Golden vectors of the serial protocol, as flat JSON that a test in any language can read.

Expected results are stated here: stuffing, treatment of damaged lines, responses. The tests compare the code
with them. Only the bytes of whole messages come from the code; the tests build these a second time, from the
tables of `serial.md`.
"""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass, fields
from typing import Any

from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.emcy import Emergency

_RUN = bytes(range(1, 255))  # 254 bytes without a zero
_LIMIT = 128

COBS: dict[str, tuple[bytes, bytes]] = {
    "empty": (b"", b"\x01"),
    "one_zero": (b"\0", b"\x01\x01"),
    "two_zeros": (b"\0\0", b"\x01\x01\x01"),
    "zero_between": (b"\x11\x22\0\x33", b"\x03\x11\x22\x02\x33"),
    "no_zero": (b"\x11\x22\x33\x44", b"\x05\x11\x22\x33\x44"),
    "zero_last": (b"\x11\0", b"\x02\x11\x01"),
    "zeros_around": (b"\0\x11\0", b"\x01\x02\x11\x01"),
    "run_253": (_RUN[:253], b"\xfe" + _RUN[:253]),
    "run_254": (_RUN, b"\xff" + _RUN),
    "run_255": (_RUN + b"\xff", b"\xff" + _RUN + b"\x02\xff"),
    "run_254_zero": (_RUN + b"\0", b"\xff" + _RUN + b"\x01\x01"),
    "zero_run_254": (b"\0" + _RUN, b"\x01\xff" + _RUN),
    "zero_run_255": (b"\0" + _RUN + b"\xff", b"\x01\xff" + _RUN + b"\x02\xff"),
    "run_253_zero_one": (_RUN[:253] + b"\0\x05", b"\xfe" + _RUN[:253] + b"\x02\x05"),
    "two_runs_254": (_RUN + _RUN, b"\xff" + _RUN + b"\xff" + _RUN),
}

MESSAGES: dict[str, wire.Message] = {
    "identify": wire.Identify(7, wire.VERSION),
    "identity": wire.Identity(
        *(7, 0, wire.VERSION, 1, 127, 0xA928D4B2, 0xB7C, 0x2011, 0x00010000, 1, 100_000, 256, 4096, "Drive")
    ),
    "identity_refused": wire.Identity(
        *(8, 0x08000020, wire.VERSION, 1, 5, 0xA928D4B2, 0xB7C, 0x2011, 0x00010000, 1, 100_000, 256, 4096, "")
    ),
    "read": wire.Read(9, 0x6041, 0),
    "read_reply": wire.ReadReply(9, 0, 0x6041, 0, bytes.fromhex("3702")),
    "read_refused": wire.ReadReply(10, 0x06020000, 0x5FFF, 1),
    "write": wire.Write(11, 0x2020, 1, struct.pack("<f", -1.5)),
    "write_reply": wire.WriteReply(11, 0, 0x2020, 1),
    "write_refused": wire.WriteReply(12, 0x06090031, 0x2000, 2),
    "open": wire.Open(13, 0x2042, 0),
    "open_reply": wire.OpenReply(13, 0, 0x2042, 0, 3, 2500, 1024, 0xCBF43926),
    "open_refused": wire.OpenReply(14, 0x08000024, 0x2042, 0),
    "chunks": wire.Chunks(15, 3, 1, 2),
    "chunk_reply": wire.ChunkReply(15, 0, 3, 2, b"\x01\0\x02\0"),
    "chunk_refused": wire.ChunkReply(16, 0x08000022, 2, 0),
    "stream_words": wire.Stream(17, 1, 20, 0, (0x20300220, 0x20300C20)),
    "stream_scaled": wire.Stream(18, 2, 40, 1, (0x20300220, 0x20300C20), (0.0078125, 0.001953125)),
    "stream_stop": wire.Stream(19),
    "stream_reply": wire.StreamReply(18, 0, 2, 12_000, 40),
    "stream_refused": wire.StreamReply(20, 0x06040042, 2, 12_000, 40),
    "setpoint": wire.Setpoint(1, 0.625, 15.75),
    "host_heartbeat": wire.HostHeartbeat(127, 5),
    "nmt_start": wire.Nmt(1),
    "nmt_reset_node": wire.Nmt(129),
    "heartbeat_boot_up": wire.Heartbeat(0, 0),
    "heartbeat_operational": wire.Heartbeat(5, 0xFFFFFFFF),
    "batch_words": wire.Batch(1, 0, 1000, 1, 2, struct.pack("<ffff", 1.5, -0.25, 0.0, math.inf)),
    "batch_scaled": wire.Batch(
        2, 0x00010000, 0xFFFFFFFE, 2, 3, struct.pack("<6h", 1, -1, 0, 32767, -32767, -32768)
    ),
    "event": wire.Event(4, 123_456, Emergency(0x8130, 0x11, bytes(5))),
    "reject_unknown_type": wire.Reject(21, 0x07, 1),
    "reject_wrong_length": wire.Reject(22, 0x02, 2),
    "reject_busy": wire.Reject(23, 0x06, 3),
}

# Payloads of good frames that are no message of a host of this version, and the REJECT, if it is answered.
REQUESTS: dict[str, tuple[str, str]] = {
    "unknown_request": ("0715", "ff150701"),
    "unknown_request_without_tag": ("0f", "ff000f01"),
    "read_too_short": ("02164160", "ff160202"),
    "read_too_long": ("02164160" + "0000", "ff160202"),
    "read_type_alone": ("02", "ff000202"),
    "write_without_data": ("0316202001", "ff160302"),
    "chunks_too_short": ("051603010000" + "0002", "ff160502"),
    "stream_mapping_missing": ("0616010014" + "0002" + "20023020", "ff160602"),
    "stream_scale_missing": ("0616010014" + "0101" + "20023020", "ff160602"),
    "stream_unknown_format": ("0616010014" + "0200", "ff160602"),
    "type_zero": ("0001", ""),
    "setpoint_too_short": ("1001000000" + "0000203f" + "00007c", ""),
    "setpoint_too_long": ("1001000000" + "0000203f" + "00007c41" + "00", ""),
    "nmt_without_command": ("12", ""),
    "heartbeat_too_long": ("117f0500", ""),
    "unknown_unanswered": ("1300", ""),
    "message_of_a_drive": ("4105ffffffff", ""),
}

REPLIES: dict[str, str] = {  # payloads of good frames that are no message of a drive of this version
    "heartbeat_too_short": "4105ffffff",
    "identity_cut_in_its_fixed_part": "8107000000000101" + "7f00b2d428",
    "read_refused_with_data": "820a00000206ff5f01" + "00",
    "chunk_without_data": "850f000000000302000000",
    "batch_of_no_records": "420100" + "00000000" + "e8030000" + "0100" + "00" + "0000",
    "batch_of_a_record_and_a_half": "420100" + "00000000" + "e8030000" + "0100" + "02" + "000000",
    "event_too_long": "4304" + "40e20100" + "308111" + "0000000000" + "00",
    "message_of_a_host": "02094160" + "00",
    "unknown_type": "440000",
}

SETPOINTS: list[tuple[int | None, int, bool]] = [  # last one taken, sequence, whether it is taken
    (None, 0, True),
    (None, 0xFFFFFFFF, True),
    (1, 2, True),
    (1, 1, False),
    (1, 0, False),
    (1, 5, True),
    (0xFFFFFFFF, 0, True),
    (0, 0xFFFFFFFF, False),
    (0, 0x7FFFFFFF, True),
    (0, 0x80000000, False),
    (5, 0x80000005, False),
]

SCALED: list[tuple[float, float, int]] = [  # value, scale, what is sent; NaN is null
    (0.0, 0.5, 0),
    (1.2, 0.5, 2),
    (-1.3, 0.5, -3),
    (16383.5, 0.5, 32767),
    (-16383.5, 0.5, -32767),
    (16384.0, 0.5, -32768),
    (-16384.0, 0.5, -32768),
    (math.nan, 0.5, -32768),
]


def render() -> str:
    """Return the vectors as JSON; the same text every time."""
    document = {
        "version": wire.VERSION,
        "crc": [
            {"data": b"123456789".hex(), "crc": 0xCBF43926},
            {"data": "", "crc": 0},
            {"data": "00", "crc": 0xD202EF8D},
        ],
        "cobs": [
            {"name": name, "plain": plain.hex(), "stuffed": stuffed.hex()}
            for name, (plain, stuffed) in COBS.items()
        ],
        "messages": [_message(name, message) for name, message in MESSAGES.items()],
        "lines": [_line(name, line) for name, line in lines().items()],
        "requests_not_understood": [
            {"name": name, "payload": payload, "answer": answer}
            for name, (payload, answer) in REQUESTS.items()
        ],
        "replies_dropped": [{"name": name, "payload": payload} for name, payload in REPLIES.items()],
        "setpoint_sequences": [
            {"last": last, "sequence": sequence, "taken": taken} for last, sequence, taken in SETPOINTS
        ],
        "scaled": [
            {"value": None if math.isnan(value) else value, "scale": scale, "raw": raw}
            for value, scale, raw in SCALED
        ],
    }
    return json.dumps(document, indent=1) + "\n"


@dataclass(frozen=True)
class Line:
    """Bytes from a line, and the result of a receiver of payloads up to `max_payload` bytes."""

    data: bytes
    payloads: tuple[bytes, ...]
    too_long: int = 0
    bad_stuffing: int = 0
    too_short: int = 0
    bad_crc: int = 0
    max_payload: int = _LIMIT


def lines() -> dict[str, Line]:
    """Return the whole frames and damaged ones."""
    read, chunks = wire.encode_message(MESSAGES["read"]), wire.encode_message(MESSAGES["chunks"])
    good, other = wire.encode_frame(read), wire.encode_frame(chunks)
    full = bytes([0x03, 1]) + bytes(range(1, _LIMIT - 1))
    run = b"\x02" + b"\x11" * 249  # with its CRC one full run without a zero
    return {
        "one_frame": Line(good, (read,)),
        "shared_zero": Line(good + other[1:], (read, chunks)),
        "many_zeros": Line(b"\0\0" + good + b"\0\0\0" + other, (read, chunks)),
        "without_the_first_zero": Line(good[1:] + other, (read, chunks)),
        "noise_before": Line(b"\x07\x15\xa3" + good, (read,), bad_stuffing=1),
        "not_yet_ended": Line(good + b"\x07\x15\xa3", (read,)),
        "longest_payload": Line(wire.encode_frame(full), (full,)),
        "one_byte_too_long": Line(wire.encode_frame(full + b"\x01") + good, (read,), too_long=1),
        "zeros_too_long": Line(wire.encode_frame(bytes(_LIMIT + 1)) + good, (read,), too_long=1),
        "endless": Line(b"\0" + b"\x55" * 300 + good, (read,), too_long=1),
        "endless_and_not_yet_ended": Line(good + b"\x55" * 300, (read,), too_long=1),
        "no_data": Line(b"\0\x01" + good, (read,), too_short=1),
        "crc_alone": Line(b"\0\x01\x01\x01\x01\x01" + good, (read,), too_short=1),
        "code_beyond_the_end": Line(b"\0\x05\x11\x22" + good, (read,), bad_stuffing=1),
        "full_run_beyond_the_end": Line(b"\0\xff\x11\x22" + good, (read,), bad_stuffing=1),
        "crc_of_the_other_byte_order": Line(good[:-5] + good[-5:-1][::-1] + good, (read,), bad_crc=1),
        "bit_flipped": Line(good[:3] + bytes([good[3] ^ 0x10]) + good[4:] + good, (read,), bad_crc=1),
        "end_lost": Line(good[:-3] + good, (read,), bad_stuffing=1),
        "start_lost": Line(b"\0" + good[3:] + good, (read,), bad_stuffing=1),
        "zero_between_lost": Line(good[:-1] + other[1:] + good, (read,), bad_crc=1),
        "zero_within": Line(good[:4] + b"\0" + good[4:] + good, (read,), bad_stuffing=2),
        "closed_by_an_empty_run": Line(
            wire.encode_frame(run)[:-1] + b"\x01\0" + good, (run, read), max_payload=len(run)
        ),
    }


def _message(name: str, message: wire.Message) -> dict[str, Any]:
    payload = wire.encode_message(message)
    return {
        "name": name,
        "from": "host" if payload[0] < 0x41 else "drive",
        "type": payload[0],
        "fields": _fields(message),
        "payload": payload.hex(),
        "frame": wire.encode_frame(payload).hex(),
    }


def _fields(message: wire.Message) -> dict[str, Any]:
    """Return the fields as they stand on the wire."""
    found = {each.name: getattr(message, each.name) for each in fields(message)}
    match message:
        case wire.Identity():
            found["name_length"] = len(message.device_name.encode())
        case wire.Stream():
            found["n"] = len(message.mappings)
        case wire.Event():
            emergency = found.pop("emergency")
            found |= {
                "error_code": emergency.code,
                "error_register": emergency.register,
                "vendor": emergency.vendor,
            }
        case wire.Reject():
            found["request_type"] = found.pop("type")
        case _:
            pass
    return {name: value.hex() if isinstance(value, bytes) else value for name, value in found.items()}


def _line(name: str, line: Line) -> dict[str, Any]:
    return {
        "name": name,
        "max_payload": line.max_payload,
        "bytes": line.data.hex(),
        "payloads": [payload.hex() for payload in line.payloads],
        "too_long": line.too_long,
        "bad_stuffing": line.bad_stuffing,
        "too_short": line.too_short,
        "bad_crc": line.bad_crc,
    }
