"""Discovery of a drive on a serial line. Only reads are sent."""

from __future__ import annotations

import time

from benchtool.clock import Clock
from benchtool.errors import LinkClosed, NoAnswer
from benchtool.link.discovery import FIRMWARE_VERSION, Found, read_text
from benchtool.link.port import DEFAULT_BAUDRATE, Port
from benchtool.link.serial.link import SerialLink
from benchtool.protocol.canopen import heartbeat_state
from benchtool.protocol.serial import (
    VERSION,
    FrameSplitter,
    Identify,
    Identity,
    decode_reply,
    encode_frame,
    encode_message,
)

_TAG = 1


def scan_port(place: str, port: Port, baudrate: int, timeout_s: float, clock: Clock) -> Found:
    """Return the drive at the other end of a serial line.

    Args:
        place: how the port is called, as an address has it.
        port: open at `baudrate`, closed in the end.
        timeout_s: wall time to wait for an answer, in which it is asked for twice.
        clock: that the line goes by.

    Raises:
        NoAnswer: no drive that speaks this protocol.
        LinkClosed: the port is gone.
    """
    try:
        identity = _identity(place, port, timeout_s)
    except OSError as reason:
        port.close()
        raise LinkClosed(f"{place} stopped working: {reason}; check who else has it open") from None
    except BaseException:
        port.close()
        raise
    speed = "" if baudrate == DEFAULT_BAUDRATE else f"baudrate={baudrate}&"
    spoken = identity.version == VERSION
    with SerialLink(port, identity.node_id, clock, timeout_s=timeout_s) as link:
        firmware_version = read_text(link, FIRMWARE_VERSION) if spoken else None
    return Found(
        link=f"serial:{place}?{speed}node={identity.node_id}",
        node_id=identity.node_id,
        vendor_id=identity.vendor_id if spoken else None,
        product_code=identity.product_code if spoken else None,
        serial_number=identity.serial_number if spoken else None,
        device_name=identity.device_name if spoken else f"speaks version {identity.version} of the protocol",
        firmware_version=firmware_version,
        nmt_state=heartbeat_state(bytes([identity.nmt_state])),
    )


def _identity(place: str, port: Port, timeout_s: float) -> Identity:
    splitter = FrameSplitter()
    question = encode_frame(encode_message(Identify(_TAG)))
    heard = 0
    for _ in range(2):
        port.write(question)
        deadline_s = time.monotonic() + 0.5 * timeout_s
        while time.monotonic() < deadline_s:
            data = port.read()
            heard += len(data)
            for payload in splitter.feed(data):
                reply = decode_reply(payload)
                if isinstance(reply, Identity) and reply.tag == _TAG:
                    return reply
    what = f"{heard} bytes, but no answer came" if heard else "no answer"
    raise NoAnswer(
        f"{what} from {place} within {timeout_s:g} s; check that the drive is powered, the baud rate and "
        f"the wiring"
    )
