"""One drive at the other end of a serial line, as `firmware_protocol/serial.md` describes it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial

from benchtool.clock import Clock, drained
from benchtool.link.interface import BatchReceiver, LinkCounters
from benchtool.link.pipe import PipePort
from benchtool.link.port import Port
from benchtool.link.receiving import ReceivingLink
from benchtool.link.serial.process_data import BatchProcessData
from benchtool.link.serial.request_response import RequestResponse
from benchtool.link.serial.requests import SerialRequests
from benchtool.protocol.canopen import HOST_NODE, NmtCommand, NmtState
from benchtool.protocol.serial import (
    VERSION,
    Batch,
    Event,
    FrameSplitter,
    Heartbeat,
    HostHeartbeat,
    Identity,
    Nmt,
    Request,
    Setpoint,
    StreamReply,
    decode_reply,
    encode_frame,
    encode_message,
)
from benchtool.ticks import wrap_tick

_FAILING_S = 0.2
_CHECK_SENDING = "that the other end of the line reads, and that there is no flow control"


class SerialLink(ReceivingLink):
    """A `BatchLink` over a byte port, with one receive thread that only the end of the port ends.

    Messages are handled in the receive thread, requests run in the caller's, one at a time. The first
    request, and the first after a reset of the drive, is preceded by a request for the identity.

    Args:
        port: open port, owned from now on.
        node_id: the drive's, 1 to 126.
        clock: what `wait_heartbeat` goes by.
        host_node_id: whose heartbeat `send_heartbeat` is.
        timeout_s: wall time to wait for each answer.
    """

    def __init__(
        self, port: Port, node_id: int, clock: Clock, *, host_node_id: int = HOST_NODE, timeout_s: float = 0.5
    ) -> None:
        super().__init__(
            node_id, clock, thread_name="serial-link", device="serial port", check="its cable and adapter"
        )
        self._port = port
        self._host_node_id = host_node_id
        self._splitter = FrameSplitter()
        self._request_response = RequestResponse(self._send, timeout_s, partial(drained, clock))
        self._requests = SerialRequests(self._request_response, node_id, self._require_open)
        self._batch_receiver: BatchReceiver | None = None
        self._setpoint_sequence = 0
        self._send_lock = threading.Lock()
        self._event_sequence: int | None = None
        self._thread.start()

    @property
    def counters(self) -> LinkCounters:
        """See `Link.counters`; frames dropped are those of any defect, frames received those without."""
        splitter = self._splitter
        received = {
            "frames_received": splitter.frames,
            "frames_dropped": self._counts["frames_dropped"] + splitter.dropped + self._requests.odd_chunks,
            "stale_answers": self._request_response.stale,
            "retries": self._requests.retries,
            "sdo_aborts": self._requests.aborts,
        }
        return LinkCounters(**{**self._counts, **self._announced.counts, **received})

    # ---- objects -----------------------------------------------------------------------------------------

    def upload(self, index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        """See `Link.upload`; every answer contains its length.

        An object too long for one answer is read in chunks in any case.
        """
        return self._requests.upload(index, sub, in_chunks=block)

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        """See `Link.download`; there is one transfer for every length.

        Raises:
            ValueRefused: more or fewer bytes than a write can carry; nothing was sent.
        """
        self._requests.download(index, sub, data)

    # ---- network management ------------------------------------------------------------------------------

    def nmt(self, command: NmtCommand) -> None:
        """See `Link.nmt`."""
        self._send(Nmt(command))

    def send_heartbeat(self) -> None:
        """See `Link.send_heartbeat`."""
        self._send(HostHeartbeat(self._host_node_id, NmtState.OPERATIONAL))

    # ---- process data ------------------------------------------------------------------------------------

    def batch_rows(self, channels: int) -> int:
        """See `BatchLink.batch_rows`."""
        return self._requests.batch_rows(channels)

    def configure_stream(self, mappings: Sequence[int] = (), stride: int = 0, batch: int = 1) -> StreamReply:
        """See `BatchLink.configure_stream`."""
        return self._requests.configure_stream(mappings, stride, batch)

    def on_batch(self, receiver: BatchReceiver | None) -> None:
        """See `BatchLink.on_batch`."""
        self._batch_receiver = receiver

    def send_setpoint(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        """See `BatchLink.send_setpoint`."""
        self._requests.identity()
        self._setpoint_sequence = wrap_tick(self._setpoint_sequence + 1)
        self._send(Setpoint(self._setpoint_sequence, torque_Nm, omega_m_rad_s))

    @property
    def process_data(self) -> BatchProcessData:
        """See `Link.process_data`."""
        return BatchProcessData(self)

    # ---- inside ------------------------------------------------------------------------------------------

    def _send(self, message: Request) -> None:
        frame = encode_frame(encode_message(message))
        self._require_open()
        try:
            with self._send_lock:
                self._port.write(frame)
        except OSError as reason:
            raise self._send_failure(reason, _FAILING_S, _CHECK_SENDING) from reason

    def _stop_receiving(self) -> None:
        super()._stop_receiving()
        if isinstance(self._port, PipePort):
            self._port.wake()

    def _close_device(self) -> None:
        self._port.close()

    # ---- receive thread ----------------------------------------------------------------------------------

    def _receive(self) -> None:
        read = getattr(self._port, "read_timed", None) or self._read
        try:
            while not self._stopping.is_set():
                data, arrival_s = read()
                for payload in self._splitter.feed(data):
                    try:
                        self._handle(payload, arrival_s)
                    except Exception:  # noqa: BLE001  a receiver of batches must not end the reception
                        self._counts["receive_errors"] += 1
        except Exception as failure:  # noqa: BLE001  drivers raise anything when their adapter goes
            self._failure = failure
        finally:
            self._request_response.close()

    def _read(self) -> tuple[bytes, float]:
        data = self._port.read()
        return data, self.clock.now_s()

    def _handle(self, payload: bytes, arrival_s: float) -> None:
        message = decode_reply(payload)
        match message:
            case None:
                self._counts["frames_dropped"] += 1
            case Batch():
                if (receiver := self._batch_receiver) is not None:
                    receiver(message, arrival_s)
            case Heartbeat():
                self._on_heartbeat(message)
            case Event():
                self._on_event(message, arrival_s)
            case _:
                if isinstance(message, Identity):
                    self._on_identity(message)
                self._request_response.on_response(message)

    def _on_identity(self, identity: Identity) -> None:
        # Heartbeats before it may have waited in a buffer for longer than this host is there.
        if identity.version == VERSION and identity.nmt_state in set(NmtState):
            self._announced.on_state_read(NmtState(identity.nmt_state))

    def _on_heartbeat(self, heartbeat: Heartbeat) -> None:
        if heartbeat.nmt_state not in set(NmtState):
            self._counts["frames_dropped"] += 1
            return
        state = NmtState(heartbeat.nmt_state)
        self._announced.on_heartbeat(state)
        if state is NmtState.BOOT_UP:
            # Another firmware may have started: ask for the identity again; its events count from 0.
            self._requests.reset()
            self._event_sequence = None

    def _on_event(self, event: Event, arrival_s: float) -> None:
        if self._event_sequence is not None:
            self._counts["emcy_lost"] += (event.sequence - self._event_sequence - 1) % 256
        self._event_sequence = event.sequence
        self._announced.on_emergency(event.emergency, arrival_s)
