"""One CANopen drive as the host sees it: SDO, NMT, heartbeat and emergencies over a python-can bus."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial

import can
import canopen
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from benchtool.clock import Clock, drained
from benchtool.errors import LinkError, NoAnswer, SdoAbort
from benchtool.link.canopen.process_data import PdoProcessData
from benchtool.link.canopen.reception import FAILING_S, receive_frames, stop_receiving
from benchtool.link.canopen.sdo_client import BlockNotOfferedError, SdoClient, SdoTimeoutError
from benchtool.link.canopen.virtual import FrameBurst
from benchtool.link.interface import CountsMalformed, Frame, FrameReceiver, LinkCounters
from benchtool.link.receiving import ReceivingLink
from benchtool.protocol.canopen import (
    Emergency,
    NmtCommand,
    NmtState,
    abort_text,
    cob_id,
    heartbeat_state,
    sdo,
)

_SECOND_ANSWER_S = 0.02
_CHECK_SENDING = "that the bus is powered and terminated and that another node acknowledges"


class CanopenLink(ReceivingLink):
    """A `FrameLink` over CANopen, with one receive thread that no frame and no driver error ends.

    Errors of the driver are counted and reception goes on; only a hundred in a row, without a frame or
    a quiet interval between them, count as a vanished adapter. Frames are handled in the receive thread,
    transfers run in the caller's, one at a time.

    Args:
        bus: open bus, owned from now on.
        node_id: the drive's, 1 to 127.
        clock: what `wait_heartbeat` goes by.
        host_node_id: whose heartbeat `send_heartbeat` is.
        sdo_timeout_s: wall time to wait for each answer.
        arrival_s: when a frame arrived, on `clock`; the moment of its handling if None.
    """

    def __init__(
        self,
        bus: can.BusABC,
        node_id: int,
        clock: Clock,
        *,
        host_node_id: int = cob_id.HOST_NODE,
        sdo_timeout_s: float = 0.5,
        arrival_s: Callable[[can.Message], float] | None = None,
    ) -> None:
        super().__init__(
            node_id, clock, thread_name="canopen-link", device="adapter", check="its cable and driver"
        )
        self._bus = bus
        self._host_node_id = host_node_id
        self._arrival_s = arrival_s or (lambda _: clock.now_s())
        self._receivers: dict[int, FrameReceiver] = {cob_id.EMCY + node_id: self._on_emergency}
        self._network = canopen.Network()
        self._network.bus = bus
        self._sdo = SdoClient(self._network, node_id, sdo_timeout_s, partial(drained, clock))
        self._sdo_response = cob_id.SDO_RESPONSE + node_id
        self._network.subscribe(cob_id.HEARTBEAT + node_id, self._on_heartbeat)
        self._transfer_lock = threading.Lock()
        self._thread.start()

    @property
    def counters(self) -> LinkCounters:
        counts = {**self._counts, **self._announced.counts, "stale_answers": self._sdo.stale}
        counts["overruns"] += self._sdo.overruns
        if isinstance(self._bus, CountsMalformed):
            counts["frames_dropped"] += self._bus.malformed
        return LinkCounters(**counts)

    def upload(self, index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        """See `Link.upload`. A server without block upload is read by segmented transfer instead."""
        with self._transfer_lock, self._translating(f"reading 0x{index:04X}:{sub}, asked twice"):
            try:
                return self._read(index, sub, block, length)
            except SdoCommunicationError:
                self._require_open()
                self._counts["retries"] += 1
                return self._read(index, sub, block, length)

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        """See `Link.download`."""
        write = self._sdo.block_download if block else self._sdo.download
        with self._transfer_lock, self._translating(f"writing 0x{index:04X}:{sub}, asked once"):
            write(index, sub, data)

    def answers(self, index: int, sub: int) -> int:
        """See `CountsAnswers.answers`; a refusal is an answer."""
        with self._transfer_lock, self._translating(f"reading 0x{index:04X}:{sub}, asked twice"):
            with suppress(SdoAbortedError):
                self._read(index, sub, False, None)
            if not self.clock.settle():
                self.clock.wait(_SECOND_ANSWER_S)
            return 1 + self._sdo.more_answers(index, sub)

    def nmt(self, command: NmtCommand) -> None:
        """See `Link.nmt`."""
        self._send(cob_id.NMT, bytes([command, self._node_id]))

    def send_heartbeat(self) -> None:
        """See `Link.send_heartbeat`; the message says operational (CiA 301, 7.2.8.3.2.2)."""
        self._send(cob_id.HEARTBEAT + self._host_node_id, bytes([NmtState.OPERATIONAL]))

    def subscribe(self, can_ids: Iterable[int], receiver: FrameReceiver) -> None:
        """See `FrameLink.subscribe`."""
        self._receivers = self._receivers | dict.fromkeys(can_ids, receiver)

    def unsubscribe(self, can_ids: Iterable[int]) -> None:
        """See `FrameLink.unsubscribe`."""
        gone = set(can_ids)
        self._receivers = {key: value for key, value in self._receivers.items() if key not in gone}

    def send_pdo(self, can_id: int, data: bytes) -> None:
        """See `FrameLink.send_pdo`."""
        self._send(can_id, data)

    @property
    def process_data(self) -> PdoProcessData:
        """See `Link.process_data`."""
        return PdoProcessData(self)

    # ---- transfers ---------------------------------------------------------------------------------------

    def _read(self, index: int, sub: int, block: bool, length: int | None) -> bytes:
        if block:
            try:
                return self._sdo.block_upload(index, sub)
            except BlockNotOfferedError:
                pass  # a read may be asked again in another way; a write never is
        return self._sdo.upload(index, sub, length)

    @contextmanager
    def _translating(self, doing: str) -> Iterator[None]:
        self._require_open()
        node = f"node {self._node_id}"
        try:
            yield
        except SdoAbortedError as aborted:
            self._counts["sdo_aborts"] += 1
            what = doing.partition(",")[0]
            raise SdoAbort(f"{node} refused {what}: {abort_text(aborted.code)}", aborted.code) from None
        except SdoTimeoutError:
            self._require_open()
            raise NoAnswer(
                f"{node} did not answer within {self._sdo.timeout_s:g} s when {doing}; "
                f"check that the drive is powered, its node id, the bit rate and the wiring"
            ) from None
        except SdoCommunicationError as reason:
            raise LinkError(
                f"{node} answered out of protocol when {doing}: {reason}; "
                f"check the wiring, and that no other SDO client talks to this node"
            ) from None
        except (can.CanError, OSError) as reason:
            raise self._send_failure(reason, FAILING_S, _CHECK_SENDING) from reason

    def _send(self, can_id: int, data: bytes) -> None:
        self._require_open()
        try:
            self._network.send_message(can_id, data)
        except (can.CanError, OSError) as reason:
            raise self._send_failure(reason, FAILING_S, _CHECK_SENDING) from reason

    def _stop_receiving(self) -> None:
        stop_receiving(self._bus, self._stopping)

    def _close_device(self) -> None:
        self._bus.shutdown()

    # ---- receive thread ------------------------------------------------------------------------------------

    def _receive(self) -> None:
        self._failure = receive_frames(
            self._bus, self._stopping, self._handle, self._count_error, self._handle_burst
        )
        self._sdo.end_waiting()

    def _count_error(self) -> None:
        self._counts["receive_errors"] += 1

    def _handle(self, frame: can.Message) -> None:
        self._counts["frames_received"] += 1
        if frame.is_error_frame or frame.is_remote_frame or frame.is_extended_id:
            self._counts["frames_dropped"] += 1
        elif frame.arbitration_id == self._sdo_response:
            self._on_sdo_response(frame)
        elif (receiver := self._receivers.get(frame.arbitration_id)) is not None:
            receiver(Frame(frame.arbitration_id, bytes(frame.data), self._arrival_s(frame)))
        else:
            self._network.notify(frame.arbitration_id, frame.data, frame.timestamp)

    def _handle_burst(self, burst: FrameBurst) -> None:
        if burst.can_id != self._sdo_response:
            for frame in burst:
                self._handle(frame)
            return
        self._counts["frames_received"] += len(burst.frames)
        whole = [data for data in burst.frames if len(data) == sdo.FRAME_SIZE]
        self._counts["frames_dropped"] += len(burst.frames) - len(whole)
        self._sdo.on_responses(whole)

    def _on_sdo_response(self, frame: can.Message) -> None:
        if len(frame.data) == sdo.FRAME_SIZE:
            self._sdo.on_response(frame.arbitration_id, frame.data, frame.timestamp)
        else:
            self._counts["frames_dropped"] += 1

    def _on_heartbeat(self, can_id: int, data: bytearray, timestamp: float) -> None:
        state = heartbeat_state(bytes(data))
        if state is None:
            self._counts["frames_dropped"] += 1
            return
        self._announced.on_heartbeat(state)

    def _on_emergency(self, frame: Frame) -> None:
        emergency = Emergency.decode(frame.data)
        if emergency is None:
            self._counts["frames_dropped"] += 1
            return
        self._announced.on_emergency(emergency, frame.arrival_s)
