"""One slow stream: set up on the drive, received, decoded in a thread of its own, handed to sinks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from benchtool.block import Gap
from benchtool.clock import VirtualClock
from benchtool.errors import BenchError, NoAnswer, StateError
from benchtool.link import Frame
from benchtool.protocol.nmt import NmtCommand, NmtState
from benchtool.protocol.pdo import INVALID, TPDO_COB_IDS
from benchtool.protocol.telemetry import RecordDecoder, StreamCounters, stream_layout
from benchtool.telemetry.clock_fit import ArrivalStatistics, ClockFit
from benchtool.telemetry.fanout import FanOut, Sink
from benchtool.telemetry.node import Node
from benchtool.telemetry.worker import Worker

DEFAULT_RATE_HZ = 100.0
DEFAULT_CHANNELS = (
    *("i_d", "i_q", "torque", "torque_reference", "psi_s"),
    *("omega_m", "u_dc", "law_clipped", "adc_saturated"),
)
_BATCH_S = 0.2
_FRAMES = 4096
_ROOM_S = 5.0
_SILENCE_S = 1.0
_SILENT_PERIODS = 5


@dataclass(frozen=True)
class StreamReport:
    """What came of a stream.

    `expected` is how many records the drive says it sent; None if it could not be asked. `first` and `last`
    are the values of the first and the last row, by channel.
    """

    expected: int | None
    counters: StreamCounters
    gaps: tuple[Gap, ...]
    first: Mapping[str, float]
    last: Mapping[str, float]
    frames_dropped: int
    rows_dropped: int
    jitter_rms_s: float
    jitter_max_s: float
    clock: ClockFit | None


class TelemetryStream:
    """Streams within a `with` block.

    The link's receive thread puts frames into a bounded queue, the stream's thread makes Blocks of a fifth
    of a second of them, and each sink has a thread. In virtual time all of them are part of what the
    clock waits for. Failures of these threads are raised by `check`, which the caller calls while it waits,
    and on the way out.

    Args:
        node: connected drive.
        sinks: what the blocks go to; theirs from now on is this stream's to close.
        channels: signals of four bytes, 13 at most.
        rate_Hz: records per second; a whole number of milliseconds apart.

    Raises:
        ValueRefused: the drive cannot stream this.
        SdoAbort, NoAnswer, WriteNotVerified: it does not let itself be set up.
    """

    def __init__(
        self,
        node: Node,
        sinks: Sequence[Sink],
        channels: Sequence[str] = DEFAULT_CHANNELS,
        rate_Hz: float = DEFAULT_RATE_HZ,
    ) -> None:
        self._node = node
        self._fan_out = FanOut(sinks)
        with ExitStack() as stack:
            stack.callback(self._fan_out.close)
            tick_s = round(node.number("control_period") * 1e9) * 1e-9
            self.layout = stream_layout(node.dictionary, node.link.node_id, channels, rate_Hz, tick_s)
            stack.pop_all()
        self._decoder = RecordDecoder(self.layout)
        self._rows = max(1, round(_BATCH_S * rate_Hz))
        self._arrivals = ArrivalStatistics(tick_s)
        self._gaps: list[Gap] = []
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._taken = 0
        self._next_tick = 0
        self._frames_dropped = 0
        self._sequence_before: int | None = None
        self._sent: int | None = None
        self._started_s = 0.0
        self._worker = Worker("benchtool-telemetry", self._take_frame, _FRAMES)
        self._running = False

    # ---- life ------------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        clock = self._node.clock
        if isinstance(clock, VirtualClock):
            clock.settle_with(self._worker.settle)
            for sink in self._fan_out.sinks:
                clock.settle_with(sink.worker.settle)
        try:
            self._start()
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            try:
                self._stop()
            finally:
                self._close()
            self._check_threads()
        except BenchError:
            if error is None:  # else the first failure is the one to report
                raise

    def check(self) -> None:
        """Raise what has gone wrong behind the caller's back.

        Raises:
            RecordingError: a lossless sink failed, or does not keep up.
            NoAnswer: no record has come for a second, nor a heartbeat that would say why.
            StateError: none has come because the drive has left the NMT state operational.
        """
        self._check_threads()
        silent_s = self._node.clock.now_s() - max(self._started_s, self._decoder.arrival_s)
        if not self._running or silent_s <= max(_SILENCE_S, _SILENT_PERIODS * self.layout.period_s):
            return
        state = self._node.link.heartbeat_state()
        received = self._decoder.counters.received
        node = self._node.link.node_id
        seen = f"the stream of node {node} stopped {silent_s:.1f} s ago, after {received} records"
        if state is None or state is NmtState.OPERATIONAL:
            raise NoAnswer(f"{seen}: check that the drive is powered, the wiring and the load of the bus")
        raise StateError(
            f"{seen}: its heartbeat says {state.name.lower().replace('_', '-')}, operational is expected; "
            f"it was reset or another master commands it: find out which, then record again"
        )

    def report(self) -> StreamReport:
        """What has come so far; complete after the `with` block."""
        counters = self._decoder.counters
        # A drive that restarted has counted from zero again.
        trusted = self._sent is not None and self._sent >= counters.received
        return StreamReport(
            expected=self._sent if trusted else None,
            counters=counters,
            gaps=tuple(self._gaps),
            first=self._first,
            last=self._last,
            frames_dropped=self._frames_dropped,
            rows_dropped=sum(sink.rows_dropped for sink in self._fan_out.sinks),
            jitter_rms_s=self._arrivals.jitter_rms_s,
            jitter_max_s=self._arrivals.jitter_max_s,
            clock=self._arrivals.fit(),
        )

    # ---- the drive -------------------------------------------------------------------------------------

    def _start(self) -> None:
        node = self._node
        for number in range(1, len(TPDO_COB_IDS) + 1):
            self._switch_off(number)
        self._sequence_before = int(node.number("stream_sequence"))
        node.link.subscribe((pdo.can_id for pdo in self.layout.pdos), self._receive)
        # The first PDO last: a record begins with it, so that none begins before all are in use.
        for pdo in reversed(self.layout.pdos):
            for label, value in pdo.set_up(self.layout.period_s):
                node.write(label, value)
        self._started_s = node.clock.now_s()
        self._running = True
        node.link.nmt(NmtCommand.START)

    def _stop(self) -> None:
        if self._running:
            self._running = False
            for pdo in self.layout.pdos:
                self._node.write(*pdo.switch_off)
            assert self._sequence_before is not None
            self._sent = int(self._node.number("stream_sequence")) - self._sequence_before

    def _switch_off(self, number: int) -> None:
        label = f"0x{0x1800 + number - 1:04X}:1"
        if label in self._node.dictionary:
            cob_id = int(self._node.number(label))
            if not cob_id & INVALID:
                self._node.write(label, cob_id | INVALID)

    # ---- threads ---------------------------------------------------------------------------------------

    def _receive(self, frame: Frame) -> None:
        if not self._worker.put(frame, _ROOM_S):
            self._frames_dropped += 1

    def _take_frame(self, frame: Frame) -> None:
        if self._decoder.feed(*frame):
            self._arrivals.add(self._decoder.tick, self._decoder.arrival_s)
            if self._decoder.rows >= self._rows:
                self._hand_on()

    def _hand_on(self) -> None:
        block = self._decoder.take()
        if block is None:
            return
        missing = (block.first_tick - self._next_tick) // block.stride if self._taken else 0
        self._gaps += [Gap(self._taken, missing)] if missing else []
        self._gaps += [Gap(self._taken + gap.row, gap.missing_rows) for gap in block.gaps]
        self._last = dict(zip(block.names, block.data[-1].tolist(), strict=True))
        self._first = self._first or dict(zip(block.names, block.data[0].tolist(), strict=True))
        self._taken += len(block.data)
        self._next_tick = int(block.ticks()[-1]) + block.stride
        self._fan_out.put(block)

    def _check_threads(self) -> None:
        self._worker.check()
        self._fan_out.check()

    def _close(self) -> None:
        clock = self._node.clock
        self._node.link.unsubscribe(pdo.can_id for pdo in self.layout.pdos)
        with ExitStack() as stack:
            stack.callback(self._fan_out.close)
            self._worker.close()
            if not self._worker.failed:
                self._hand_on()
        if isinstance(clock, VirtualClock):
            clock.forget(self._worker.settle)
            for sink in self._fan_out.sinks:
                clock.forget(sink.worker.settle)
