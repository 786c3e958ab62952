"""Discovery of all nodes on a CAN bus. Only reads are sent."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import can

from benchtool.clock import Clock
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.discovery import (
    DEVICE_NAME,
    FIRMWARE_VERSION,
    PRODUCT_CODE,
    SERIAL_NUMBER,
    VENDOR_ID,
    Found,
    read_number,
    read_text,
)
from benchtool.link.interface import Frame
from benchtool.protocol.canopen import NmtState, cob_id, heartbeat_state, sdo

_SPACING_S = 0.005  # 200 requests a second are 5 % of a bus at 500 kbit/s
_SDO_READ_SERIAL_NUMBER = sdo.INITIATE.pack(sdo.Request.UPLOAD, *SERIAL_NUMBER, 0)


def scan_bus(place: str, bus: can.BusABC, bitrate: int | None, timeout_s: float, clock: Clock) -> list[Found]:
    """Return the nodes of a CAN bus: those that answer an SDO read of their serial number, or are heard.

    Requests to all 127 node numbers leave within 0.7 s. A node serves one transfer at a time: a read would
    abort a transfer of another host.

    Args:
        place: how the bus is called, as an address has it, without options.
        bus: open, shut down in the end.
        bitrate: of its address, in bit/s.
        timeout_s: how long to listen after the last request, for answers and heartbeats.
        clock: that the bus goes by.

    Raises:
        LinkError: frames cannot be sent, as on a bus where no node acknowledges them.
    """
    try:
        heard = _Heard()
        with CanopenLink(_Lent(bus), cob_id.HOST_NODE, clock) as survey:
            survey.subscribe([cob_id.SDO_RESPONSE + node for node in cob_id.NODES], heard.answer)
            survey.subscribe([cob_id.HEARTBEAT + node for node in cob_id.NODES], heard.heartbeat)
            for node in cob_id.NODES:
                survey.send_pdo(cob_id.SDO_REQUEST + node, _SDO_READ_SERIAL_NUMBER)
                clock.wait(_SPACING_S)
            clock.wait(timeout_s)
            survey.heartbeat_state()  # raises if the adapter has gone
        return [_node(place, bus, bitrate, node, heard, clock) for node in heard.nodes()]
    finally:
        bus.shutdown()


@dataclass
class _Heard:
    """Responses of nodes, collected in the receive thread."""

    answers: Counter[int] = field(default_factory=Counter)
    states: dict[int, NmtState] = field(default_factory=dict)

    def answer(self, frame: Frame) -> None:
        # An abort is an answer, too: of a node without a serial number.
        if len(frame.data) == sdo.FRAME_SIZE and sdo.key(frame.data) == SERIAL_NUMBER:
            self.answers[frame.can_id - cob_id.SDO_RESPONSE] += 1

    def heartbeat(self, frame: Frame) -> None:
        if (state := heartbeat_state(frame.data)) is not None:
            self.states[frame.can_id - cob_id.HEARTBEAT] = state

    def nodes(self) -> list[int]:
        """Return the nodes found, in order."""
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


def _node(place: str, bus: can.BusABC, bitrate: int | None, node: int, heard: _Heard, clock: Clock) -> Found:
    options = [] if bitrate is None else [f"bitrate={bitrate}"]
    with CanopenLink(_Lent(bus), node, clock) as link:
        answers = node in heard.answers
        return Found(
            link=f"{place}?{'&'.join([*options, f'node={node}'])}",
            node_id=node,
            vendor_id=read_number(link, VENDOR_ID) if answers else None,
            product_code=read_number(link, PRODUCT_CODE) if answers else None,
            serial_number=read_number(link, SERIAL_NUMBER) if answers else None,
            device_name=read_text(link, DEVICE_NAME) if answers else None,
            firmware_version=read_text(link, FIRMWARE_VERSION) if answers else None,
            nmt_state=heard.states.get(node),
            answers=max(1, heard.answers[node]),
        )
