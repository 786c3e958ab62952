"""Recording of the slow stream into a run bundle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from benchtool.telemetry.fanout import Sink
from benchtool.telemetry.stream import DEFAULT_RATE_HZ, TelemetryStream
from benchtool.telemetry.streamed_drive import StreamedDrive

if TYPE_CHECKING:
    from benchtool.recording import BundleWriter

STREAM = "telemetry"


@contextmanager
def record_stream(
    node: StreamedDrive,
    bundle: BundleWriter,
    channels: Sequence[str] = (),
    rate_Hz: float = DEFAULT_RATE_HZ,
    *,
    others: Sequence[Sink] = (),
) -> Iterator[TelemetryStream]:
    """Record for the length of a `with` block; if data are lost, `check` and the exit raise.

    Until the block ends, only this stream may use `bundle`.

    Args:
        others: further sinks, closed on the way out.

    Raises:
        BenchError: as TelemetryStream.
    """
    recorder = Sink("recorder", lambda block: bundle.append(STREAM, block), lossless=True)
    with TelemetryStream(node, [recorder, *others], channels, rate_Hz) as stream:
        yield stream
