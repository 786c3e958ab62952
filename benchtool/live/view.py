"""The live view of one recording: blocks, events and results in, batches to every destination out."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from types import TracebackType
from typing import Self

import rerun as rr

from benchtool.block import Block
from benchtool.errors import EnvironmentFailure
from benchtool.link import ClockAnchor
from benchtool.live import names
from benchtool.live.blueprint import Layout, blueprint
from benchtool.live.messages import (
    LayoutMessage,
    Message,
    StaticContent,
    TimeAxis,
    block_columns,
    parts,
    series,
)
from benchtool.live.panels import locus
from benchtool.live.panels.band import Limits, TorqueBand
from benchtool.live.panels.documents import parameters_document, results_document
from benchtool.live.panels.events import EventLog, markers
from benchtool.live.panels.key import key_document
from benchtool.live.panels.quality import Counters, Quality
from benchtool.live.panels.spectra import capture_spectra, running_spectra
from benchtool.live.panels.spectrum import RunningSpectrum, chosen
from benchtool.live.sinks.sink import PATIENCE_S, Destination, RecordingSink
from benchtool.recording import Event, Level

_WATERFALL_S = 1.0  # between two pictures, each of which is kept in the recording
_SAME = 0.05
_ROWS = 20_000  # in a batch, so that a long record needs no more memory than itself


@dataclass(frozen=True)
class Setup:
    """Setup of a view before the first block.

    `psi_Wb` is the flux of the motor's magnets, and the radius of the flux plane's circle where the drive
    tells no reference; its hexagon is that of `u_dc`.
    `limits` are (min, max) by measurement, `torque_ripple_pp` among them; `parameters` go into a document.
    `mark` tells wall time; without it the first row has that of its arrival. `followed` shows the last
    seconds, else everything is shown.
    """

    title: str
    psi_Wb: float
    limits: Limits = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=dict)
    mark: ClockAnchor | None = None
    followed: bool = True


class LiveView:
    """A live recording; none of its failures disturbs the drive.

    `add_block` is called in a thread of its own with a bounded queue (`telemetry.Sink`, lossless False);
    `event` may be called from any thread and only leaves a note; the other methods are for when nothing is
    measured.

    Args:
        setup: see `Setup`.
        destinations: where to; each has a recording of its own.
        note: takes a line if a destination cannot be opened, is stuck, gone or back.
    """

    def __init__(
        self,
        setup: Setup,
        destinations: Sequence[Destination],
        note: Callable[[str], None] = lambda _: None,
        *,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._setup = setup
        self._note = note
        self._layout = Layout(psi_Wb=setup.psi_Wb, followed=setup.followed)
        mark = setup.mark
        self._axis = None if mark is None else TimeAxis(mark.tick_s, mark.tick, mark.wall_s)
        self._events = EventLog()
        self._band = TorqueBand(setup.limits)
        self._circle = locus.ReferenceCircle(setup.psi_Wb)
        self._quality = Quality(self._not_shown)
        self._lock = threading.Lock()
        self._failed = False
        self._u_dc_V = 0.0  # that the hexagon is drawn for
        self._spectrum: RunningSpectrum | None = None
        self._next_tick: int | None = None
        self._last_tick = 0 if mark is None else mark.tick
        self._waterfall_tick = 0
        self._queue_dropped: Callable[[], int] = lambda: 0
        recording, title = str(uuid.uuid4()), setup.title
        self.sinks: list[RecordingSink] = []
        for destination in destinations:
            try:
                self.sinks.append(RecordingSink(destination, recording, title, note, patience_s=patience_s))
            except EnvironmentFailure as failure:
                note(f"not shown by {destination.name}: {failure}")
        still: list[Message] = [
            locus.axes(setup.psi_Wb),
            StaticContent(
                names.RESULTS, results_document(setup.title, (), remarks=["nothing is measured yet"])
            ),
            StaticContent(names.PARAMETERS, parameters_document(setup.title, setup.parameters)),
            *markers(),
        ]
        self._send(still)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def title(self) -> str:
        """Of the recording."""
        return self._setup.title

    @property
    def rows_dropped(self) -> dict[str, int]:
        """Rows that a destination did not take, by its name."""
        return {sink.name: sink.rows_dropped for sink in self.sinks}

    def count_drops(self, dropped: Callable[[], int]) -> None:
        """Have the rows that were dropped on the way here shown as well."""
        self._queue_dropped = dropped

    def count(self, counters: Counters) -> None:
        """Have further counters shown, such as those of the link."""
        self._quality.count(counters)

    # ---- while it is measured ---------------------------------------------------------------------------

    def add_block(self, block: Block) -> None:
        """Show the next rows of the slow stream."""
        if len(block.data):
            self._without_raising(partial(self._take, block), len(block.data))

    def event(self, event: Event) -> None:
        """Leave a line for the log, at its tick or at that of the last row."""
        self._events.add(event)

    # ---- when it was measured ---------------------------------------------------------------------------

    def captured(self, block: Block, source: str = names.CAPTURE, trigger_row: int | None = None) -> None:
        """Show a record of the control rate, or of a transducer, at its place in drive time.

        `trigger_row` is where in it the drive was triggered.
        """
        if len(block.data):
            self._without_raising(partial(self._captured, block, source, trigger_row), len(block.data))

    def results(self, document: rr.TextDocument) -> None:
        """Show what was measured."""
        self._without_raising(lambda: self._send([StaticContent(names.RESULTS, document)]))

    def quality(self, document: rr.TextDocument) -> None:
        """Show how good the data are, in place of the counters."""
        self._without_raising(lambda: self._send([StaticContent(names.COUNTERS, document)]))

    def close(self) -> None:
        """Send what waits and end the recording."""
        self._without_raising(self._tell)
        with ExitStack() as stack:  # each is closed, even if another one raises
            for sink in self.sinks:
                stack.callback(sink.close)

    # ---- inside -----------------------------------------------------------------------------------------

    def _without_raising(self, show: Callable[[], None], rows: int = 0) -> None:
        """Send messages of so many rows; report a failure of the view once, and never raise it."""
        if not self._failed:
            try:
                with self._lock:
                    show()
                return
            except Exception as failure:  # noqa: BLE001  no failure of the view may end a measurement
                self._failed = True
                self._note(
                    f"the live view has failed and stopped ({type(failure).__name__}: {failure}): "
                    f"the measurement goes on without it"
                )
        for sink in self.sinks:
            sink.discard(rows)

    def _take(self, block: Block) -> None:
        axis = self._axis_of(block)
        self._show(names.STREAM, block)
        broken = self._next_tick is not None and block.first_tick > self._next_tick
        messages: list[Message] = [*block_columns(block, axis, names.STREAM, self._next_tick)]
        missing = sum(gap.missing_rows for gap in block.gaps)
        if broken and self._next_tick is not None:
            missing += (block.first_tick - self._next_tick) // block.stride
        if missing:
            last_before = self._last_tick if broken else int(block.ticks()[block.gaps[0].row - 1])
            text = f"{missing} rows of the stream are missing"
            self._events.add(Event(text=text, level=Level.WARN, tick=last_before + block.stride))
        self._last_tick = int(block.ticks()[-1])
        self._next_tick = self._last_tick + block.stride
        self._quality.add(len(block.data), missing)
        self._events.notice(block)
        messages += self._circle.messages(block, axis)
        messages += locus.trace(block, axis, names.STREAM)
        messages += self._band.running(block, axis, broken=broken)
        if self._spectrum is not None:
            self._spectrum.add(block, broken=broken)
            due = self._last_tick >= self._waterfall_tick
            if due:
                self._waterfall_tick = self._last_tick + round(_WATERFALL_S / axis.tick_s)
            messages += running_spectra(self._spectrum, axis, self._last_tick, waterfall=due)
        messages += self._quality.messages(axis, self._last_tick)
        self._send(messages, len(block.data))
        self._send(self._events.messages(axis, self._last_tick, self._band.mean_Nm))

    def _captured(self, block: Block, source: str, trigger_row: int | None) -> None:
        axis, next_tick = self._axis_of(block), None
        self._last_tick = max(self._last_tick, axis.tick(block, -1))
        self._show(source, block)
        for part in parts(block, _ROWS):
            self._send(block_columns(part, axis, source, next_tick), len(part.data))
            next_tick = int(part.ticks()[-1]) + part.stride
        messages: list[Message] = [*self._circle.messages(block, axis), *locus.trace(block, axis, source)]
        if source == names.CAPTURE:
            messages += self._band.whole(block, axis) + capture_spectra(block, axis, self._last_tick)
        self._send(messages)
        rows, seconds = len(block.data), block.time_s()[-1]
        text = f"{source.strip('/')}: {rows} rows over {seconds:.3g} s"
        self._events.add(Event(text=text, tick=axis.tick(block, 0)))
        if trigger_row is not None:
            self._events.trigger(axis.tick(block, trigger_row))
        self._tell()

    def _tell(self) -> None:
        """Send the events that wait, if there is a time axis to put them on."""
        if self._axis is None and self._events.waiting:
            self._axis = TimeAxis(1e-4, 0, time.time())
        if self._axis is not None:
            self._send(
                [
                    *self._events.messages(self._axis, self._last_tick, self._band.mean_Nm),
                    *self._quality.messages(self._axis, self._last_tick, last=True),
                ]
            )

    def _axis_of(self, block: Block) -> TimeAxis:
        if self._axis is None:
            took_s = (block.ticks()[-1] - block.first_tick) * block.tick_s
            self._axis = TimeAxis(block.tick_s, block.first_tick, time.time() - took_s)
        return self._axis

    def _show(self, source: str, block: Block) -> None:
        """Name the series of a source, and lay the view out, when it appears."""
        self._draw_hexagon(block)
        layout = replace(self._layout.with_source(source, block.channels), states=self._events.stateful)
        if layout == self._layout:
            return
        self._layout = layout
        self._send(series(block.channels, source))
        name = chosen(block.names)
        if source == names.STREAM and name is not None and self._spectrum is None:
            self._spectrum = RunningSpectrum(name, block.unit(name), block.sample_rate_Hz)
        self._send(
            [
                StaticContent(names.KEY, key_document(self._layout.sources())),
                LayoutMessage(blueprint(self._layout)),
            ]
        )

    def _draw_hexagon(self, block: Block) -> None:
        """The hexagon of the dc link, where that is another than before."""
        if "u_dc" in block.names:
            u_dc_V = float(block.column("u_dc").mean())
            if u_dc_V > 0.0 and abs(u_dc_V - self._u_dc_V) > _SAME * u_dc_V:
                self._u_dc_V = u_dc_V
                self._send(locus.voltages(self._setup.psi_Wb, u_dc_V))

    def _not_shown(self) -> dict[str, int]:
        return {"queue": self._queue_dropped(), **self.rows_dropped}

    def _send(self, messages: Iterable[Message], rows: int = 0) -> None:
        batch = tuple(messages)
        for sink in self.sinks:
            sink.send(batch, rows)
