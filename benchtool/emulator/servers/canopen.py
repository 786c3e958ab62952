"""The emulated drive on a CAN bus (CiA 301): NMT, heartbeat, EMCY, SDO and PDO over python-can."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import can
from canopen import SdoAbortedError

from benchtool.emulator.firmware.objects import Refused
from benchtool.emulator.servers.disturbance import NEVER_S, Stage, Way
from benchtool.emulator.servers.drive_node import DriveNode
from benchtool.emulator.servers.parties import CanFrame
from benchtool.emulator.servers.receiver import Receiver
from benchtool.emulator.servers.sdo_server import SdoServer
from benchtool.link.canopen import FrameBurst, Received, VirtualTimeBus
from benchtool.protocol.canopen import Emergency, NmtState, cob_id

_POLL_S = 0.2
_ERRORS_IN_A_ROW = 10
_ERROR_PAUSE_S = 0.02


class BusFailedError(Exception):
    """A bus could not be received from, for the reason that is its cause."""


class CanopenServer:
    """A drive's end of one bus.

    What an adapter cannot send is lost, as on a bus without a listener; an adapter whose reception fails ten
    times in a row is gone.

    Args:
        bus: open bus, owned from now on.
        node: the drive.
    """

    is_can = True

    def __init__(self, bus: can.BusABC, node: DriveNode) -> None:
        self.receiver = Receiver("emulated-drive", self._receive, self._close, self._wake)
        self._bus = bus
        self._node = node
        self._errors = 0
        self._is_handled = isinstance(bus, VirtualTimeBus) and bus.handle_with(self._take)
        # A controller drops a frame whose check sum is wrong.
        self._inbound: Stage[CanFrame] = Stage(Way.TO_DRIVE, node.disturbances, lambda *_: None)
        self._outbound: Stage[CanFrame] = Stage(Way.TO_HOST, node.disturbances, lambda *_: None)
        self._sdo = SdoServer(
            self._read,
            self._write,
            lambda data: self._send(cob_id.SDO_RESPONSE + node.node_id, data),
            node.firmware.objects.length,
            lambda frames: self._send_all(cob_id.SDO_RESPONSE + node.node_id, frames),
        )

    def boot(self) -> None:
        """See `Server.boot`; a transfer that was under way has ended."""
        self._sdo.reset()
        self.heartbeat(NmtState.BOOT_UP)

    def confirm(self, state: NmtState) -> None:
        """See `Server.confirm`; on CAN it has time until the next heartbeat."""

    def heartbeat(self, state: NmtState) -> None:
        """See `Server.heartbeat`."""
        self._send(cob_id.HEARTBEAT + self._node.node_id, bytes([state]))

    def emergency(self, emergency: Emergency) -> None:
        """See `Server.emergency`."""
        self._send(cob_id.EMCY + self._node.node_id, emergency.encode())

    def process_data(self, can_id: int, data: bytes) -> None:
        """See `Server.process_data`."""
        self._send(can_id, data)

    def next_tick(self, tick: int) -> int:
        """See `Server.next_tick`: of frames that are late, and of other nodes on the bus."""
        node = self._node
        late = node.tick_at(min(self._inbound.next_s(), self._outbound.next_s()))
        return min([late, *(party.next_tick(tick) for party in node.parties)])

    def transmit(self, tick: int) -> None:
        """See `Server.transmit`."""
        now_s = self._node.now_s
        for frame in self._outbound.due(now_s):
            self._put(*frame)
        for can_id, data in self._inbound.due(now_s):
            self._handle(can_id, data)
        for party in self._node.parties:
            for frame in party.sends(tick):
                self._put(*frame)

    def is_under_way(self) -> bool:
        """Return whether frames are late, but for those that wait without end."""
        return min(self._inbound.next_s(), self._outbound.next_s()) < NEVER_S

    def release(self) -> None:
        """See `Server.release`."""

    # ---- receive thread ------------------------------------------------------------------------------------

    def _receive(self) -> None:
        try:
            frame = self._next_frame()
        except BusFailedError as failed:
            self._errors += 1
            if self._errors == _ERRORS_IN_A_ROW:
                raise OSError(f"the adapter stopped working: {failed.__cause__}") from failed.__cause__
            self.receiver.pause(_ERROR_PAUSE_S)
            return
        self._errors = 0
        if frame is not None:
            self._take(frame)

    def _next_frame(self) -> can.Message | None:
        bus = self._bus
        if self._is_handled and isinstance(bus, VirtualTimeBus):
            try:
                bus.serve(_POLL_S)  # what has come is handled there
            except can.CanError as error:
                raise BusFailedError from error
            return None
        try:
            return bus.recv(_POLL_S)
        except Exception as error:  # drivers raise anything at a line that is disturbed
            raise BusFailedError from error

    def _take(self, received: Received) -> None:
        for frame in received if isinstance(received, FrameBurst) else (received,):
            if not _is_data(frame):
                continue
            sent = frame.arbitration_id, bytes(frame.data)
            with self._node.lock:
                for can_id, data in self._inbound.passed(sent, self._node.now_s):
                    self._handle(can_id, data)
                for party in self._node.parties:
                    for answer in party.hear(*sent):
                        self._put(*answer)

    def _wake(self) -> None:
        if isinstance(self._bus, VirtualTimeBus):
            self._bus.wake()

    def _close(self) -> None:
        if isinstance(self._bus, VirtualTimeBus):
            self._bus.leave()
        with suppress(can.CanError, OSError):
            self._bus.shutdown()

    def _handle(self, can_id: int, data: bytes) -> None:
        node = self._node
        if node.firmware.hung:
            return
        if can_id == cob_id.NMT:
            if len(data) == 2 and data[1] in (0, node.node_id):
                node.command(data[0])
        elif can_id == cob_id.SDO_REQUEST + node.node_id:
            if node.nmt_state is not NmtState.STOPPED:
                self._sdo.on_request(data)
        elif can_id - cob_id.HEARTBEAT in cob_id.NODES:
            if len(data) == 1:
                node.on_host_heartbeat(can_id - cob_id.HEARTBEAT)
        else:
            node.on_process_data(can_id, data)

    def _read(self, index: int, sub: int) -> bytes:
        try:
            return self._node.firmware.objects.read(index, sub)
        except Refused as refused:
            raise SdoAbortedError(refused.code) from None

    def _write(self, index: int, sub: int, data: bytes) -> None:
        try:
            self._node.firmware.objects.write(index, sub, data)
        except Refused as refused:
            raise SdoAbortedError(refused.code) from None

    def _send(self, can_id: int, data: bytes) -> None:
        for frame in self._outbound.passed((can_id, data), self._node.now_s):
            self._put(*frame)

    def _send_all(self, can_id: int, frames: Sequence[bytes]) -> None:
        if self._outbound.is_undisturbed:
            self._put(can_id, *frames)
            return
        for data in frames:
            self._send(can_id, data)

    def _put(self, can_id: int, *frames: bytes) -> None:
        bus, now_s = self._bus, self._node.firmware.now_s
        with suppress(can.CanError, OSError):
            if isinstance(bus, VirtualTimeBus) and bus.is_unbounded:
                bus.send_data(can_id, frames, now_s)
                return
            for data in frames:
                bus.send(can.Message(timestamp=now_s, arbitration_id=can_id, data=data, is_extended_id=False))


def _is_data(frame: can.Message) -> bool:
    return not (frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame)
