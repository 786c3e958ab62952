"""The emulated drive on a serial line: requests, setpoints, heartbeat, events and the stream."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Callable, Sequence
from contextlib import suppress

from benchtool.emulator.firmware.objects import Refused
from benchtool.emulator.ports.client import HungUp, Traffic
from benchtool.emulator.servers.disturbance import NEVER_S, Stage, Way
from benchtool.emulator.servers.drive_node import DriveNode
from benchtool.emulator.servers.receiver import Receiver
from benchtool.emulator.servers.serial_stream import ControlRateStream
from benchtool.emulator.servers.transmitter import DirectTransmitter, QueuedTransmitter
from benchtool.emulator.servers.upload import Upload
from benchtool.link import PipePort, Port
from benchtool.protocol.canopen import Abort, Emergency, NmtState
from benchtool.protocol.serial import (
    MAX_PAYLOAD,
    VERSION,
    Batch,
    Chunks,
    Event,
    FrameSplitter,
    Heartbeat,
    HostHeartbeat,
    Identify,
    Identity,
    MessageType,
    Nmt,
    Open,
    OpenReply,
    Read,
    ReadReply,
    Reject,
    RejectReason,
    Reply,
    Setpoint,
    Stream,
    StreamReply,
    Write,
    WriteReply,
    decode_request,
    encode_frame,
    encode_message,
)
from benchtool.ticks import is_newer, wrap_tick

MAX_REQUEST = 256
"""Longest request that this drive takes, bytes; a stream of 16 scaled signals has 135."""

MAX_REPLY = MAX_PAYLOAD
_READ_REPLY_HEAD = 9
_F32 = struct.Struct("<f")


class SerialServer:
    """A drive's end of one serial line.

    While the drive is stopped, requests that touch the dictionary are answered with 0x08000022, where CAN has
    no answer at all.

    A client that hangs up (`HungUp` from the port) loses its settings: the stream ends, and the next client
    starts afresh. Link supervision decides whether the motor stops.

    Args:
        port: open port, owned from now on.
        node: the drive.
        buffered: send from a thread, so that a port that blocks does not delay the drive; what it does not
            take in time is lost, telemetry first. Without it, the thread that advances time writes to the
            port.
    """

    def __init__(self, port: Port, node: DriveNode, *, buffered: bool = True) -> None:
        self.receiver = Receiver("emulated-drive-serial", self._receive, self._close, self._wake)
        self._port = port
        self._node = node
        self._splitter = FrameSplitter(MAX_REQUEST)
        self._inbound: Stage[bytes] = Stage(Way.TO_DRIVE, node.disturbances, _flipped)
        self._outbound: Stage[bytes] = Stage(Way.TO_HOST, node.disturbances, _flipped)
        write = port.write if buffered else _stamped(port, node)
        transmitter = QueuedTransmitter if buffered else DirectTransmitter
        self._line = transmitter(write, self.receiver.lose)
        self._upload = Upload()
        self._stream = ControlRateStream(
            node.firmware.objects, node.firmware.core.stream, self._send_batch, MAX_REPLY
        )
        self._last_sequence: int | None = None
        self._events = 0

    @property
    def traffic(self) -> Traffic:
        """Frames to and from the host."""
        splitter, line = self._splitter, self._line
        return Traffic(splitter.frames, line.sent, splitter.dropped + line.dropped)

    def boot(self) -> None:
        """See `Server.boot`."""
        self._reset_host()
        self.heartbeat(NmtState.BOOT_UP)

    def confirm(self, state: NmtState) -> None:
        """See `Server.confirm`; at once."""
        self._run_stream()
        self.heartbeat(state)

    def heartbeat(self, state: NmtState) -> None:
        """See `Server.heartbeat`."""
        self._send(Heartbeat(state, self._tick()))

    def emergency(self, emergency: Emergency) -> None:
        """See `Server.emergency`."""
        self._send(Event(self._events, self._tick(), emergency))
        self._events = (self._events + 1) & 0xFF

    def process_data(self, can_id: int, data: bytes) -> None:
        """See `Server.process_data`; a serial line has none."""

    def next_tick(self, tick: int) -> int:
        """See `Server.next_tick`."""
        late = self._node.tick_at(min(self._inbound.next_s(), self._outbound.next_s()))
        return min(late, self._stream.next_tick(tick))

    def transmit(self, tick: int) -> None:
        """See `Server.transmit`."""
        self._stream.transmit()
        now_s = self._node.now_s
        for frame in self._outbound.due(now_s):
            self._line.send(frame)
        for piece in self._inbound.due(now_s):
            self._take(piece)

    def is_under_way(self) -> bool:
        """Return whether frames are late, but for those that wait without end."""
        return min(self._inbound.next_s(), self._outbound.next_s()) < NEVER_S

    def release(self) -> None:
        """See `Server.release`."""
        if self._stream.configured:
            self._stream.end()
            self._node.stream_taken = False

    # ---- receive thread ------------------------------------------------------------------------------------

    def _receive(self) -> None:
        try:
            data = self._port.read()
        except HungUp:
            with self._node.lock:
                self._reset_host()
            self._line.clear()
            return
        if not data:
            return
        if self._node.disturbances.active:
            with self._node.lock:
                for frame in _frames(data):
                    for piece in self._inbound.passed(frame, self._node.now_s):
                        self._take(piece)
            return
        dropped = self._splitter.dropped
        payloads = self._splitter.feed(data)  # without the drive's lock: garbage delays no other server
        with self._node.lock:
            self._node.count("serial_dropped", self._splitter.dropped - dropped)
            for payload in payloads:
                self._handle(payload)

    def _take(self, data: bytes) -> None:
        """Handle bytes with the node's lock held."""
        dropped = self._splitter.dropped
        payloads = self._splitter.feed(data)
        self._node.count("serial_dropped", self._splitter.dropped - dropped)
        for payload in payloads:
            self._handle(payload)

    def _reset_host(self) -> None:
        self._inbound.clear()
        self._outbound.clear()
        self.release()
        self._last_sequence = None
        self._upload.reset()

    def _wake(self) -> None:
        if isinstance(self._port, PipePort):
            self._port.wake()

    def _close(self) -> None:
        with suppress(OSError):
            self._port.close()
        self._line.close()

    def _handle(self, payload: bytes) -> None:
        if self._node.firmware.hung:
            return
        message = decode_request(payload)
        match message:
            case Setpoint():
                self._on_setpoint(message)
            case HostHeartbeat():
                self._node.on_host_heartbeat(message.node)
            case Nmt():
                self._node.command(message.command)
            case Read():
                status, data = self._read(message.index, message.sub)
                if len(data) > MAX_REPLY - _READ_REPLY_HEAD:
                    status, data = Abort.OUT_OF_MEMORY, b""
                self._send(ReadReply(message.tag, status, message.index, message.sub, data))
            case Write():
                self._send(WriteReply(message.tag, self._write(message), message.index, message.sub))
            case Open():
                status, data = self._read(message.index, message.sub)
                refused = OpenReply(message.tag, status, message.index, message.sub)
                self._send(refused if status else self._upload.open(message, data))
            case Chunks():
                self._line.send_each(
                    frame for each in self._upload.chunks(message) for frame in self._passed(_frame(each))
                )
            case Stream():
                self._send(self._configure(message))
            case Identify():
                self._send(self._identify(message))
            case Reject():
                self._node.count("serial_dropped")
                self._send(message)
            case None:
                self._node.count("serial_dropped")

    def _identify(self, request: Identify) -> Identity:
        objects = self._node.firmware.objects
        spoken = request.version == VERSION
        if spoken:
            self._last_sequence = None
        return Identity(
            tag=request.tag,
            status=0 if spoken else Abort.NOT_STORED,
            version=VERSION,
            node_id=self._node.node_id,
            nmt_state=self._node.nmt_state,
            dictionary_hash=int(objects["dictionary_hash"]),
            vendor_id=int(objects["vendor_id"]),
            product_code=int(objects["product_code"]),
            revision_number=int(objects["revision_number"]),
            serial_number=int(objects["serial_number"]),
            tick_period_ns=round(self._node.firmware.period_s * 1e9),
            max_request=MAX_REQUEST,
            max_reply=MAX_REPLY,
            device_name=str(objects.table.by_name["device_name"].default),
        )

    def _read(self, index: int, sub: int) -> tuple[int, bytes]:
        if self._node.nmt_state is NmtState.STOPPED:
            return Abort.DEVICE_STATE, b""
        try:
            return 0, self._node.firmware.objects.read(index, sub)
        except Refused as refused:
            return refused.code, b""

    def _write(self, request: Write) -> int:
        if self._node.nmt_state is NmtState.STOPPED:
            return Abort.DEVICE_STATE
        try:
            self._node.firmware.objects.write(request.index, request.sub, request.data)
        except Refused as refused:
            return refused.code
        return 0

    def _on_setpoint(self, message: Setpoint) -> None:
        """Take it if it is newer than the last one taken, and both of its values can be."""
        node = self._node
        if node.nmt_state is not NmtState.OPERATIONAL:
            return
        newer = self._last_sequence is None or is_newer(message.sequence, self._last_sequence)
        torque_command = _F32.pack(message.torque_command_Nm)
        omega_m_command = _F32.pack(message.omega_m_command_rad_s)
        if newer and node.on_setpoint(torque_command, omega_m_command):
            self._last_sequence = message.sequence
        else:
            node.count("rpdo_dropped")

    def _configure(self, message: Stream) -> StreamReply | Reject:
        stream = self._stream
        status, layout = 0, None
        if self._node.nmt_state is NmtState.STOPPED:
            status = Abort.DEVICE_STATE
        else:
            try:
                layout = stream.layout(message)
            except Refused as refused:
                status = refused.code
        if status:
            return StreamReply(message.tag, status, stream.schema, stream.sent, stream.dropped)
        if layout is not None and self._node.stream_taken and not stream.configured:
            return Reject(message.tag, MessageType.STREAM, RejectReason.BUSY)
        self.release()
        sent, dropped = stream.sent, stream.dropped
        if layout is not None:
            self._node.stream_taken = True
            stream.begin(layout)
            self._run_stream()
        return StreamReply(message.tag, 0, stream.schema, sent, dropped)

    # ---- out -----------------------------------------------------------------------------------------------

    def _run_stream(self) -> None:
        if self._node.nmt_state is NmtState.OPERATIONAL:
            self._stream.resume()
        else:
            self._stream.pause()

    def _tick(self) -> int:
        return wrap_tick(self._node.tick)

    def _send(self, message: Reply) -> None:
        for frame in self._passed(_frame(message)):
            self._line.send(frame)

    def _send_batch(self, batch: Batch) -> bool:
        sent = True  # also of a batch that is lost on the wire
        for frame in self._passed(_frame(batch)):
            sent = self._line.send(frame, telemetry=True) and sent
        return sent

    def _passed(self, frame: bytes) -> Sequence[bytes]:
        """Return what goes out now, of a frame of the drive's."""
        return self._outbound.passed(frame, self._node.now_s)


def _frames(data: bytes) -> list[bytes]:
    """Return what was read, frame by frame."""
    return [each for each in re.split(rb"(?<=\x00)", data) if each]


def _flipped(frame: bytes, draw: random.Random) -> bytes:
    """Return a frame with one bit flipped."""
    place, bit = draw.randrange(len(frame)), draw.randrange(8)
    return frame[:place] + bytes([frame[place] ^ 1 << bit]) + frame[place + 1 :]


def _frame(message: Reply) -> bytes:
    return encode_frame(encode_message(message))


def _stamped(port: Port, node: DriveNode) -> Callable[[bytes], None]:
    """Writing with the drive's time, where the port takes it: the clock stands still while the drive runs."""
    write_at: Callable[[bytes, float], None] | None = getattr(port, "write_at", None)
    if write_at is None:
        return port.write
    return lambda data: write_at(data, node.firmware.now_s)
