"""Discovery over any wire: results and common requests. Only reads are sent."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from benchtool.errors import LinkError, SdoAbort
from benchtool.link.interface import Link
from benchtool.protocol.canopen import NmtState

DEVICE_NAME, FIRMWARE_VERSION = (0x1008, 0), (0x100A, 0)
VENDOR_ID, PRODUCT_CODE, SERIAL_NUMBER = (0x1018, 1), (0x1018, 2), (0x1018, 4)


@dataclass(frozen=True)
class Found:
    """A drive that answered, and its address as `--link` takes it; None for what it does not provide.

    `answers` is how often it answered one request on CAN: more than once if two nodes have the same number.
    """

    link: str
    node_id: int
    vendor_id: int | None
    product_code: int | None
    serial_number: int | None
    device_name: str | None
    firmware_version: str | None
    nmt_state: NmtState | None
    answers: int = 1


def duplicates(found: Sequence[Found]) -> list[str]:
    """Return duplicates of node ids and serial numbers, one line each. A serial number of 0 is ignored."""
    lines = [
        f"node {each.node_id} answered {each.answers} times ({each.link}): "
        f"give each node of the bus a number of its own"
        for each in found
        if each.answers > 1
    ]
    same = Counter((each.vendor_id, each.product_code, each.serial_number) for each in found)
    for (vendor_id, product_code, serial_number), count in same.items():
        if count > 1 and serial_number:
            links = " and ".join(
                each.link
                for each in found
                if (each.vendor_id, each.product_code, each.serial_number)
                == (vendor_id, product_code, serial_number)
            )
            lines.append(f"serial number {serial_number} at {links}: one drive on several links, or a copy")
    return lines


def read_number(link: Link, key: tuple[int, int]) -> int | None:
    """Return an unsigned number of the drive; None if it does not provide it."""
    data = _read(link, key)
    return int.from_bytes(data, "little") if data else None


def read_text(link: Link, key: tuple[int, int]) -> str | None:
    """Return a text of the drive; None if it does not provide it."""
    data = _read(link, key)
    return data.decode(errors="replace").rstrip("\0") if data else None


def _read(link: Link, key: tuple[int, int]) -> bytes:
    with suppress(SdoAbort, LinkError):
        return link.upload(*key)
    return b""
