"""The stream of a drive, gathered in memory."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from benchtool.api.connection import Connection, Use
from benchtool.api.recorded import RecordedBlock, with_certificate
from benchtool.block import Block
from benchtool.errors import AnalysisError, UsageError
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.telemetry import ClockFit, TelemetryStream


class Stream:
    """What a drive streams within a `with` block, while `bench.wait` waits; whatever the drive is doing.

        with drive.stream(["torque", "i_q"], rate_Hz=250) as stream:
            bench.wait(2.0)
            print(stream.latest["torque"])
        stream.block.plot()

    Raises:
        ValueRefused: in the `with` statement: the drive cannot stream this.
        LinkError, StateError: while it waits, or at its end: the stream has stopped.
    """

    def __init__(
        self, connection: Connection, channels: tuple[str, ...], rate_Hz: float, live: str | Path = ""
    ) -> None:
        self._connection = connection
        self._channels = channels
        self._rate_Hz = rate_Hz
        self._live = live
        self._blocks: list[Block] = []
        self._stream: TelemetryStream | None = None

    def __enter__(self) -> Self:
        from benchtool.drive import Capability
        from benchtool.telemetry import Sink, TelemetryStream, keep_journal

        if self._stream is not None:
            raise UsageError("this stream has run: call drive.stream(...) again")
        with self._connection.use() as session, ExitStack() as stack:
            if self._connection.stream is not None:
                raise UsageError("the drive streams already: leave that `with` block first")
            session.drive.capabilities.require(Capability.STREAM, purpose="a stream")
            takers = {"memory": self._blocks.append}
            if self._live:
                from benchtool.api.live import stream_view

                view = stack.enter_context(stream_view(session, self._live))
                stack.enter_context(keep_journal(session.drive, [view.event]))
                takers["live"] = view.add_block
            sinks = [Sink(name, take, lossless=name == "memory") for name, take in takers.items()]
            self._stream = TelemetryStream(session.drive, sinks, self._channels, self._rate_Hz)
            stack.enter_context(self._stream)
            stack.enter_context(session.drive.watched(self._stream.check))
            self._connection.hold(Use.STREAM, stack.pop_all())
            self._connection.stream = self
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._connection.stream is not self:
            return  # the bench was closed, which has ended it
        with self._connection.use():
            self._connection.stream = None
            self._connection.give_up(Use.STREAM).__exit__(kind, error, trace)

    @property
    def clock(self) -> ClockFit | None:
        """The drive's time on the host's clock; None until some records have come."""
        return None if self._stream is None else self._stream.report().clock

    @property
    def block(self) -> RecordedBlock:
        """All that has come so far, a fifth of a second late, with its certificate.

        Raises:
            AnalysisError: nothing has.
        """
        from benchtool.telemetry import StreamFacts, certify

        with self._connection.use() as session:
            if self._stream is None or not self._blocks:
                raise AnalysisError(
                    "the stream has brought no record so far: wait with bench.wait(...) while it runs"
                )
            block = Block.joined(self._blocks)
            report = self._stream.report()
            certificate = certify(
                {"telemetry": StreamFacts.of_report(report)}, session.drive.link.counters, report
            )
            return with_certificate(block, certificate)

    @property
    def latest(self) -> dict[str, float]:
        """The newest row, by channel; empty until one has come."""
        if not self._blocks:
            return {}
        block = self._blocks[-1]
        return dict(zip(block.names, block.data[-1].tolist(), strict=True))

    def _repr_html_(self) -> str:
        units = {each.name: each.unit for block in self._blocks[:1] for each in block.channels}
        rows = [(name, f"{value:.6g}", units[name]) for name, value in self.latest.items()]
        return table_html(("stream", ">latest", "unit"), rows)
