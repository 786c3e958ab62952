"""Who is there: on a serial line, or among all nodes of a CAN bus. Nothing but reads is sent."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import can

from benchtool.clock import Clock
from benchtool.errors import LinkClosed, LinkError, NoAnswer, SdoAbort
from benchtool.link import Frame, Link
from benchtool.link.address import DEFAULT_BAUDRATE, Address
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.port import Port
from benchtool.link.serial.link import SerialLink
from benchtool.protocol.canopen.nmt import NmtState, heartbeat_state
from benchtool.protocol.serial import (
    VERSION,
    FrameSplitter,
    Identify,
    Identity,
    decode_reply,
    encode_frame,
    encode_message,
)

_NODES = range(1, 128)
_HOST = 127
_SDO_RESPONSE = 0x580
_SDO_REQUEST = 0x600
_HEARTBEAT = 0x700
_SPACING_S = 0.005  # 200 requests a second are 5 % of a bus at 500 kbit/s
_SDO_READ_SERIAL_NUMBER = bytes([0x40, 0x18, 0x10, 0x04, 0, 0, 0, 0])
_DEVICE_NAME, _FIRMWARE_VERSION = (0x1008, 0), (0x100A, 0)
_VENDOR_ID, _PRODUCT_CODE, _SERIAL_NUMBER = (0x1018, 1), (0x1018, 2), (0x1018, 4)
_TAG = 1


@dataclass(frozen=True)
class Found:
    """A drive that answered, and its address as `--link` takes it; None for what it does not tell.

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


def ask_port(place: str, port: Port, baudrate: int, timeout_s: float, clock: Clock) -> Found:
    """Who is at the other end of a serial line.

    Args:
        place: how the port is called, as an address has it.
        port: open at `baudrate`, closed in the end.
        timeout_s: wall time to wait for an answer, in which it is asked for twice.
        clock: that the line goes by.

    Raises:
        NoAnswer: nobody, or nobody who speaks this protocol.
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
        firmware_version = _text(link, _FIRMWARE_VERSION) if spoken else None
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


def ask_bus(address: Address, bus: can.BusABC, timeout_s: float, clock: Clock) -> list[Found]:
    """The nodes of a CAN bus: those that answer an SDO read of their serial number, or are heard.

    Requests to all 127 node numbers leave within 0.7 s. A node serves one transfer at a time: a read would
    break off what another host is just transferring.

    Args:
        address: of the bus.
        bus: open, shut down in the end.
        timeout_s: how long to listen after the last request, for answers and heartbeats.
        clock: that the bus goes by.

    Raises:
        LinkError: frames cannot be sent, as on a bus where nobody acknowledges them.
    """
    try:
        heard = _Heard()
        with CanopenLink(_Lent(bus), _HOST, clock) as survey:
            survey.subscribe([_SDO_RESPONSE + node for node in _NODES], heard.answer)
            survey.subscribe([_HEARTBEAT + node for node in _NODES], heard.heartbeat)
            for node in _NODES:
                survey.send_pdo(_SDO_REQUEST + node, _SDO_READ_SERIAL_NUMBER)
                clock.wait(_SPACING_S)
            clock.wait(timeout_s)
            survey.heartbeat_state()  # raises if the adapter has gone
        return [_node(address, bus, node, heard, clock) for node in heard.nodes()]
    finally:
        bus.shutdown()


def duplicates(found: Sequence[Found]) -> list[str]:
    """What should be there once and is there twice, a line each. A serial number of 0 is none."""
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


# ---- a serial line ---------------------------------------------------------------------------------------


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


# ---- a CAN bus -------------------------------------------------------------------------------------------


@dataclass
class _Heard:
    """What nodes have sent, taken in the receive thread."""

    answers: Counter[int] = field(default_factory=Counter)
    states: dict[int, NmtState] = field(default_factory=dict)

    def answer(self, frame: Frame) -> None:
        # An abort is an answer, too: of a node without a serial number.
        if len(frame.data) == 8 and frame.data[1:4] == _SDO_READ_SERIAL_NUMBER[1:4]:
            self.answers[frame.can_id - _SDO_RESPONSE] += 1

    def heartbeat(self, frame: Frame) -> None:
        if (state := heartbeat_state(frame.data)) is not None:
            self.states[frame.can_id - _HEARTBEAT] = state

    def nodes(self) -> list[int]:
        """In order."""
        return sorted({*self.answers, *self.states})


class _Lent(can.BusABC):
    """A bus that outlives the link which closes it."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus
        self.channel_info = bus.channel_info
        super().__init__(bus.channel_info)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        return self._bus.recv(timeout)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        self._bus.send(msg, timeout)


def _node(address: Address, bus: can.BusABC, node: int, heard: _Heard, clock: Clock) -> Found:
    options = [] if address.bitrate is None else [f"bitrate={address.bitrate}"]
    place = f"can:{address.interface}:{address.channel}"
    with CanopenLink(_Lent(bus), node, clock) as link:
        answers = node in heard.answers
        return Found(
            link=f"{place}?{'&'.join([*options, f'node={node}'])}",
            node_id=node,
            vendor_id=_number(link, _VENDOR_ID) if answers else None,
            product_code=_number(link, _PRODUCT_CODE) if answers else None,
            serial_number=_number(link, _SERIAL_NUMBER) if answers else None,
            device_name=_text(link, _DEVICE_NAME) if answers else None,
            firmware_version=_text(link, _FIRMWARE_VERSION) if answers else None,
            nmt_state=heard.states.get(node),
            answers=max(1, heard.answers[node]),
        )


def _number(link: Link, key: tuple[int, int]) -> int | None:
    data = _read(link, key)
    return int.from_bytes(data, "little") if data else None


def _text(link: Link, key: tuple[int, int]) -> str | None:
    data = _read(link, key)
    return data.decode(errors="replace").rstrip("\0") if data else None


def _read(link: Link, key: tuple[int, int]) -> bytes:
    with suppress(SdoAbort, LinkError):
        return link.upload(*key)
    return b""
