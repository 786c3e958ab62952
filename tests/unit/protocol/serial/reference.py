"""A second, plain implementation of the protocol, as a reference."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any

import firmware_protocol

FOLDER = Path(firmware_protocol.__file__).parent
VECTORS: dict[str, Any] = json.loads((FOLDER / "serial_vectors.json").read_text(encoding="utf-8"))
PAGE = (FOLDER / "serial.md").read_text(encoding="utf-8")

_ROW = re.compile(r"^\| ([\d n+]+) \| (\w+)(?:\[(\w+)\])? \| (\w+) \| (.*) \|$", re.MULTILINE)
_CODES = {"u8": "<B", "u16": "<H", "u32": "<I", "f32": "<f"}


def crc32(data: bytes) -> int:
    """CRC-32 of IEEE 802.3, bit by bit."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def stuff(data: bytes) -> bytes:
    """COBS as `serial.md` tells it."""
    stuffed = b""
    rest = data + b"\0"
    while rest:
        piece = rest[: rest.index(0)][:254]
        stuffed += bytes([len(piece) + 1]) + piece
        rest = rest[len(piece) + (len(piece) < 254) :]
        if len(piece) == 254 and rest == b"\0":
            break
    return stuffed


def frame(payload: bytes) -> bytes:
    """A frame with its zeros."""
    return b"\0" + stuff(payload + struct.pack("<I", crc32(payload))) + b"\0"


def sections() -> dict[int, list[tuple[str, ...]]]:
    """Tables of the page by type: offset, kind, count, field and meaning of each row."""
    parts = re.split(r"^### 0x([0-9A-F]{2}) \w+$", PAGE, flags=re.MULTILINE)
    return {
        int(kind, 16): [
            row.groups("") for row in _ROW.finditer(re.split(r"^##", text, flags=re.MULTILINE)[0])
        ]
        for kind, text in zip(parts[1::2], parts[2::2], strict=True)
    }


def payload(kind: int, values: dict[str, Any]) -> bytes:
    """Payload of a message, built from the page's table; every fixed offset there must be right."""
    data = b""
    for offset, code, count, field, meaning in sections()[kind]:
        if offset.strip().isdigit():
            assert int(offset) == len(data), f"0x{kind:02X} {field}: at {len(data)}, not {offset}"
        if field in ("type", "reserved"):
            value: Any = int(meaning.split(";")[0], 0)
        else:
            value = values[field]
        if code == "utf8":
            data += value.encode()
            assert values[count] == len(value.encode())
        elif code == "bytes":
            data += bytes.fromhex(value)
            assert not count or len(value) == 2 * int(count)
        elif count:
            assert field == "scales" or values[count] == len(value)
            data += b"".join(struct.pack(_CODES[code], each) for each in value)
        else:
            data += struct.pack(_CODES[code], value)
    return data
