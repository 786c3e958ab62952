"""The emulated drive as a CANopen node (CiA 301): NMT, heartbeat, EMCY, SDO and PDO over a python-can bus."""

from __future__ import annotations

import threading
from collections.abc import Callable

import can
from canopen import SdoAbortedError

from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.objects import Refused
from benchtool.emulator.sdo_server import SdoServer
from benchtool.emulator.servers.pdo import ProcessData
from benchtool.errors import LinkClosed
from benchtool.protocol.emcy import Emergency
from benchtool.protocol.nmt import NmtCommand, NmtState

_NMT = 0x000
_EMCY = 0x080
_SDO_RESPONSE = 0x580
_SDO_REQUEST = 0x600
_HEARTBEAT = 0x700
_POLL_S = 0.2


class CanopenNode:
    """One drive on one bus: a receive thread for frames, `advance_to` for time.

    Args:
        bus: open bus, owned from now on.
        node_id: 1 to 127.
        firmware: makes the firmware, given where its emergencies go.
    """

    def __init__(
        self, bus: can.BusABC, node_id: int, firmware: Callable[[Callable[[Emergency], None]], Firmware]
    ) -> None:
        self.node_id = node_id
        self._bus = bus
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._failure: BaseException | None = None
        self._nmt_state = NmtState.BOOT_UP
        self.firmware = firmware(self._send_emergency)
        self._sdo = SdoServer(self._read, self._write, lambda data: self._send(_SDO_RESPONSE + node_id, data))
        self._pdos = ProcessData(
            self.firmware.objects, node_id, self.firmware.period_s, self._send, self.firmware.feed_link
        )
        self._boot()
        self._thread = threading.Thread(target=self._receive, name="emulated-drive", daemon=True)
        self._thread.start()

    def advance_to(self, now_s: float) -> None:
        """Run the drive up to `now_s` of the clock it follows, sending heartbeat and PDOs on the way.

        Raises:
            LinkClosed: the receive thread has failed.
        """
        self._raise_failure()
        with self._lock:
            end = int(now_s / self.firmware.period_s + 1e-6)
            while (tick := int(self.firmware.objects["tick"])) < end:
                every = self._heartbeat_ticks()
                beat = (tick // every + 1) * every if every else end
                operational = self._nmt_state is NmtState.OPERATIONAL
                stop = min(end, beat, self._pdos.next_tick(tick) if operational else end)
                self.firmware.advance_to(stop)
                if operational:
                    self._pdos.transmit(stop)
                if every and beat == stop:
                    self._send(_HEARTBEAT + self.node_id, bytes([self._nmt_state]))

    def close(self) -> None:
        """Power off: the thread ends, the bus is closed.

        Raises:
            LinkClosed: the receive thread had failed.
        """
        self._stopping.set()
        self._thread.join()
        self._bus.shutdown()
        self._raise_failure()

    # ---- frames in ---------------------------------------------------------------------------------------

    def _receive(self) -> None:
        try:
            while not self._stopping.is_set():
                frame = self._bus.recv(_POLL_S)
                if frame is not None and _is_data(frame):
                    with self._lock:
                        self._handle(frame.arbitration_id, bytes(frame.data))
        except BaseException as failure:  # noqa: BLE001 # re-raised at the caller of advance_to and close
            self._failure = failure

    def _handle(self, can_id: int, data: bytes) -> None:
        host = self.firmware.supervision.host_node_id
        if can_id == _NMT:
            self._command(data)
        elif can_id == _SDO_REQUEST + self.node_id and self._nmt_state is not NmtState.STOPPED:
            self._sdo.on_request(data)
        elif host and can_id == _HEARTBEAT + host and len(data) == 1:
            self.firmware.feed_link()
        elif self._nmt_state is NmtState.OPERATIONAL:
            self._pdos.receive(can_id, data)

    def _command(self, data: bytes) -> None:
        if len(data) != 2 or data[1] not in (0, self.node_id) or data[0] not in set(NmtCommand):
            return
        match NmtCommand(data[0]):
            case NmtCommand.START:
                self._nmt_state = NmtState.OPERATIONAL
            case NmtCommand.STOP:
                self._nmt_state = NmtState.STOPPED
                self.firmware.stop()
            case NmtCommand.ENTER_PRE_OPERATIONAL:
                self._nmt_state = NmtState.PRE_OPERATIONAL
            case NmtCommand.RESET_NODE:
                self.firmware.reset()
                self._boot()
            case NmtCommand.RESET_COMMUNICATION:
                self._boot()

    def _read(self, index: int, sub: int) -> bytes:
        try:
            return self.firmware.objects.read(index, sub)
        except Refused as refused:
            raise SdoAbortedError(refused.code) from None

    def _write(self, index: int, sub: int, data: bytes) -> None:
        try:
            self.firmware.objects.write(index, sub, data)
        except Refused as refused:
            raise SdoAbortedError(refused.code) from None

    # ---- frames out --------------------------------------------------------------------------------------

    def _boot(self) -> None:
        self._pdos.reset()
        self._send(_HEARTBEAT + self.node_id, bytes([NmtState.BOOT_UP]))
        self._nmt_state = NmtState.PRE_OPERATIONAL

    def _heartbeat_ticks(self) -> int:
        return round(float(self.firmware.objects["producer_heartbeat"]) * 1e-3 / self.firmware.period_s)

    def _send_emergency(self, emergency: Emergency) -> None:
        if self._nmt_state is not NmtState.STOPPED:
            self._send(_EMCY + self.node_id, emergency.encode())

    def _send(self, can_id: int, data: bytes) -> None:
        self._bus.send(
            can.Message(timestamp=self.firmware.now_s, arbitration_id=can_id, data=data, is_extended_id=False)
        )

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise LinkClosed(
                f"the emulated drive stopped receiving: {self._failure!r}; this is a defect of benchtool"
            ) from self._failure


def _is_data(frame: can.Message) -> bool:
    return not (frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame)
