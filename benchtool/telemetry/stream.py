"""One stream: set up on the drive, received, decoded in its own thread, passed to sinks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from types import TracebackType
from typing import Any, Self

from benchtool.block import Block, Gap
from benchtool.errors import BenchError, NoAnswer, StateError
from benchtool.link import Sent, TickAnchor
from benchtool.protocol import StreamCounters
from benchtool.protocol.canopen import NmtState
from benchtool.telemetry.clock_fit import ArrivalStatistics, ClockFit
from benchtool.telemetry.fanout import FanOut, Sink
from benchtool.telemetry.streamed_drive import StreamedDrive
from benchtool.telemetry.worker import Worker
from benchtool.ticks import ticks_since

DEFAULT_RATE_HZ = 100.0
DEFAULT_CHANNELS = (
    *("torque", "torque_reference", "omega_m", "i_q", "i_d"),  # those of a record of five
    *("i_a", "i_b", "psi_s", "psi_alpha", "psi_beta", "u_dc", "law_clipped", "adc_saturated"),
)
_BATCH_S = 0.2
_ITEMS = 4096
_ROOM_S = 5.0
_SILENCE_S = 1.0
_SILENT_PERIODS = 5


@dataclass(frozen=True)
class StreamReport:
    """Report on a stream.

    `expected` is the number of records due by the drive's count, `drive_dropped` how many of them it dropped,
    as its line was full; None if it could not be asked. `first` and `last` are the values of the first and
    the last row, by channel. Jitter and clock are of the time since the last resumption.
    """

    expected: int | None
    drive_dropped: int | None
    counters: StreamCounters
    gaps: tuple[Gap, ...]
    first: Mapping[str, float]
    last: Mapping[str, float]
    frames_dropped: int
    rows_dropped: int
    resumptions: int
    jitter_rms_s: float
    jitter_max_s: float
    clock: ClockFit | None


class TelemetryStream:
    """Streams within a `with` block.

    The link's receive thread puts what it got into a bounded queue, the stream's thread makes Blocks of a
    fifth of a second of it, and each sink has a thread. In virtual time all of them are part of what the
    clock waits for. Failures of these threads are raised by `check`, which the caller calls while it waits,
    and on the way out.

    Args:
        node: connected drive.
        sinks: destinations of the blocks; closed by this stream.
        channels: signals of four bytes: 13 at most over CAN, 16 over a serial line; without any, those of
            `DEFAULT_CHANNELS` that fit. What the drive's supervisor needs is streamed beside them, where it
            fits, and is not for the sinks.
        rate_Hz: records per second: over CAN a whole number of milliseconds apart, over a serial line of the
            drive's ticks.

    Raises:
        ValueRefused: the drive cannot stream this.
        SdoAbort, NoAnswer, WriteNotVerified: it cannot be set up.
    """

    def __init__(
        self,
        node: StreamedDrive,
        sinks: Sequence[Sink],
        channels: Sequence[str] = (),
        rate_Hz: float = DEFAULT_RATE_HZ,
    ) -> None:
        self._node = node
        supervisor = node.supervisor
        self._supervisor = supervisor if supervisor is not None and supervisor.channels else None
        needed = () if self._supervisor is None else self._supervisor.channels
        self._asked, self._channels = _chosen(node, tuple(channels), needed)
        self._rate_Hz = rate_Hz
        self._fan_out = FanOut(sinks)
        self._supervising = FanOut(
            () if self._supervisor is None else (Sink("limits", self._supervisor.take, lossless=True),)
        )
        with ExitStack() as stack:
            stack.callback(self._fan_out.close)
            stack.callback(self._supervising.close)
            self._source = node.link.process_data.source(node, self._channels, rate_Hz)
            stack.pop_all()
        self._rows = max(1, round(_BATCH_S * rate_Hz))
        self._arrivals = ArrivalStatistics(self._source.tick_s)
        self._gaps: list[Gap] = []
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._taken = 0
        self._next_tick = 0
        self._frames_dropped = 0
        self._resumptions = 0
        self._earlier = StreamCounters()
        self._before: TickAnchor | None = None
        self._sent: Sent | None = None
        self._started_s = 0.0
        self._worker = Worker("benchtool-telemetry", self._take_item, _ITEMS)
        self._running = False

    @property
    def period_s(self) -> float:
        """Drive time between two records."""
        return self._source.stride * self._source.tick_s

    # ---- life ------------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        for worker in self._workers():
            self._node.clock.register(worker.settle)
        try:
            if self._supervisor is not None:
                self._supervisor.stream_opens(self._channels)
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
            if self._supervisor is not None:
                self._supervisor.stream_closed()
            self._check_threads()
        except BenchError:
            if error is None:  # otherwise the first failure is reported
                raise

    def resume(self) -> None:
        """Resume after the node's link was lost and opened again; missed rows are a gap by their ticks.

        Raises:
            SdoAbort, NoAnswer, WriteNotVerified: the drive cannot be set up again.
        """
        self._running = False
        self._source.detach()
        self._worker.settle()
        self._hand_on()
        self._earlier = self._counters()
        if self._taken:
            self._before = self._mark()
        self._resumptions += 1
        self._arrivals = ArrivalStatistics(self._source.tick_s)
        process_data = self._node.link.process_data
        self._source = process_data.source(self._node, self._channels, self._rate_Hz, self._source)
        self._start()

    def check(self) -> None:
        """Raise an error of the background threads.

        Raises:
            RecordingError: a lossless sink failed, or does not keep up.
            NoAnswer: no record and no heartbeat has come for a second.
            StateError: no record has come because the drive has left the NMT state operational, or it
                restarted while its link was lost.
        """
        self._check_threads()
        silent_s = self._node.clock.now_s() - max(self._started_s, self._source.decoder.arrival_s)
        if not self._running or silent_s <= max(_SILENCE_S, _SILENT_PERIODS * self.period_s):
            return
        state = self._node.link.heartbeat_state()
        received = self._counters().received
        node = self._node.link.node_id
        seen = f"the stream of node {node} stopped {silent_s:.1f} s ago, after {received} records"
        if state is None or state is NmtState.OPERATIONAL:
            raise NoAnswer(f"{seen}: check that the drive is powered, the wiring and the load of the bus")
        raise StateError(
            f"{seen}: its heartbeat says {state.name.lower().replace('_', '-')}, operational is expected; "
            f"it was reset or another master commands it: find out which, then record again"
        )

    def report(self) -> StreamReport:
        """Return the report so far; complete after the `with` block."""
        counters = self._counters()
        # A drive that restarted has counted from zero again.
        sent = None if self._sent is None or self._sent.records < counters.received else self._sent
        if self._resumptions:
            sent = None  # earlier records are unknown
        return StreamReport(
            expected=None if sent is None else sent.records,
            drive_dropped=None if sent is None else sent.dropped,
            counters=counters,
            gaps=tuple(self._gaps),
            first=self._first,
            last=self._last,
            frames_dropped=self._frames_dropped,
            rows_dropped=sum(sink.rows_dropped for sink in self._fan_out.sinks),
            resumptions=self._resumptions,
            jitter_rms_s=self._arrivals.jitter_rms_s,
            jitter_max_s=self._arrivals.jitter_max_s,
            clock=self._arrivals.fit(),
        )

    # ---- the drive -------------------------------------------------------------------------------------

    def _start(self) -> None:
        self._source.start(self._receive)
        self._started_s = self._node.clock.now_s()
        self._running = True

    def _stop(self) -> None:
        if self._running:
            self._running = False
            self._sent = self._source.stop()

    # ---- threads ---------------------------------------------------------------------------------------

    def _receive(self, item: Any) -> None:
        if not self._worker.put(item, _ROOM_S):
            self._frames_dropped += 1

    def _take_item(self, item: Any) -> None:
        if self._source.feed(item):
            if self._before is not None:
                self._require_same_run(self._before)
                self._before = None
            decoder = self._source.decoder
            self._arrivals.add(decoder.tick, decoder.arrival_s)
            if decoder.rows >= self._rows:
                self._hand_on()

    def _hand_on(self) -> None:
        block = self._source.decoder.pop_block()
        if block is None:
            return
        if self._taken:
            # A new source does not know how often the drive's counter has wrapped.
            first_tick = self._next_tick + ticks_since(block.first_tick, self._next_tick)
            block = replace(block, first_tick=first_tick)
        missing = (block.first_tick - self._next_tick) // block.stride if self._taken else 0
        self._gaps += [Gap(self._taken, missing)] if missing else []
        self._gaps += [Gap(self._taken + gap.row, gap.missing_rows) for gap in block.gaps]
        self._taken += len(block.data)
        self._next_tick = int(block.ticks()[-1]) + block.stride
        self._supervising.put(block)
        block = _of_channels(block, self._asked)
        self._last = dict(zip(block.names, block.data[-1].tolist(), strict=True))
        self._first = self._first or dict(zip(block.names, block.data[0].tolist(), strict=True))
        self._fan_out.put(block)

    def _require_same_run(self, before: TickAnchor) -> None:
        later = self._mark()
        if before.restarted_since(later):
            raise StateError(
                f"node {self._node.link.node_id} restarted while its link was lost: tick {before.tick} was "
                f"followed by {later.tick}; its rows cannot stand in one stream, record again"
            )

    def _mark(self) -> TickAnchor:
        """Return the tick of the last record received."""
        decoder = self._source.decoder
        return TickAnchor(decoder.tick, decoder.arrival_s, self._source.tick_s)

    def _counters(self) -> StreamCounters:
        """Return the counters of all sources so far."""
        parts = (asdict(self._earlier), asdict(self._source.decoder.counters))
        return StreamCounters(**{name: sum(part[name] for part in parts) for name in parts[0]})

    def _check_threads(self) -> None:
        self._worker.check()
        self._fan_out.check()
        self._supervising.check()

    def _close(self) -> None:
        self._source.detach()
        with ExitStack() as stack:
            stack.callback(self._fan_out.close)
            stack.callback(self._supervising.close)
            self._worker.close()
            if not self._worker.failed:
                self._hand_on()
        for worker in self._workers():
            self._node.clock.unregister(worker.settle)

    def _workers(self) -> tuple[Worker[Any], ...]:
        sinks = (*self._supervising.sinks, *self._fan_out.sinks)
        return self._worker, *(sink.worker for sink in sinks)


def _chosen(
    node: StreamedDrive, asked: tuple[str, ...], needed: tuple[str, ...]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the signals for the sinks, and those of the stream: with `needed` ones, if they fit."""
    fitting = node.link.process_data.fitting
    if not asked:
        usual = (*needed, *(name for name in DEFAULT_CHANNELS if name not in needed))
        asked = fitting(node.dictionary, usual)
        return asked, asked
    missing = tuple(name for name in needed if name not in asked)
    both = (*asked, *missing)
    return asked, both if set(missing) <= set(fitting(node.dictionary, both)) else asked


def _of_channels(block: Block, names: tuple[str, ...]) -> Block:
    if block.names == names:
        return block
    places = [block.names.index(name) for name in names]
    channels = tuple(block.channels[place] for place in places)
    return replace(block, channels=channels, data=block.data[:, places])
