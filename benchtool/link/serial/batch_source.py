"""The stream over a serial line: batches of records, up to one record every tick of the control."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from benchtool.errors import ValueRefused
from benchtool.link.interface import BatchLink
from benchtool.link.process_data import DriveAccess, Sent, control_period_s
from benchtool.protocol import stream_channel
from benchtool.protocol.canopen import NmtCommand
from benchtool.protocol.serial import Batch, BatchDecoder, StreamFormat

MOST_CHANNELS = 16
_LATENCY_S = 0.02  # how long the first record of a batch may wait for the last
_LONGEST_STRIDE = 0xFFFF
_ROUNDING = 1e-3  # of a rate, up to which the nearest one does: 100 Hz of a drive of 33 us

TimedBatch = tuple[Batch, float]


class BatchSource:
    """A `Source` of batches.

    Args:
        drive: connected.
        link: its link.
        channels: signals of four bytes, 16 at most.
        rate_Hz: records per second; a whole number of the drive's ticks apart, to a thousandth.

    Raises:
        ValueRefused: the drive cannot stream this.
    """

    def __init__(self, drive: DriveAccess, link: BatchLink, channels: Sequence[str], rate_Hz: float) -> None:
        self._drive = drive
        self._link = link
        self._channels = tuple(stream_channel(drive.dictionary, name) for name in channels)
        if not 1 <= len(channels) <= MOST_CHANNELS or len(set(channels)) != len(channels):
            raise ValueRefused(
                f"channels are '{','.join(channels)}', 1 to {MOST_CHANNELS} different signals are expected: "
                f"name each once, and fewer"
            )
        self.tick_s = control_period_s(drive)
        self.stride = _stride(rate_Hz, self.tick_s)
        self._lock = threading.Lock()
        self._receive: Callable[[TimedBatch], None] | None = None
        self._early: list[TimedBatch] = []
        self._schema: int | None = None
        self.decoder = self._decoder_of(0)

    def start(self, receive: Callable[[TimedBatch], None]) -> None:
        """See `Source.start`."""
        room = self._link.batch_rows(len(self._channels))
        if not room:
            raise ValueRefused(
                f"a record of {len(self._channels)} channels is too long for this drive's messages: "
                f"choose fewer"
            )
        batch = max(1, min(room, round(_LATENCY_S / (self.stride * self.tick_s))))
        self._receive = receive
        self._link.on_batch(self._on_batch)
        mappings = [channel.mapping for channel in self._channels]
        schema = self._link.configure_stream(mappings, self.stride, batch).schema
        with self._lock:
            self.decoder, self._schema = self._decoder_of(schema), schema
            early, self._early = self._early, []
            for each in early:
                self._pass_on(each)
        self._link.nmt(NmtCommand.START)

    def stop(self) -> Sent:
        """See `Source.stop`."""
        reply = self._link.configure_stream()
        return Sent(reply.sent, reply.dropped)

    def detach(self) -> None:
        """See `Source.detach`."""
        self._link.on_batch(None)

    def feed(self, item: TimedBatch) -> bool:
        """See `Source.feed`."""
        return self.decoder.feed(*item) > 0

    def _on_batch(self, batch: Batch, arrival_s: float) -> None:
        # An operational drive streams at once: batches may be here before the number of their schema is.
        with self._lock:
            if self._schema is None:
                self._early.append((batch, arrival_s))
            else:
                self._pass_on((batch, arrival_s))

    def _pass_on(self, item: TimedBatch) -> None:
        # Those of another schema are what an earlier host asked for.
        if self._receive is not None and item[0].schema == self._schema:
            self._receive(item)

    def _decoder_of(self, schema: int) -> BatchDecoder:
        near = self._drive.tick_now()
        return BatchDecoder(self._channels, self.stride, self.tick_s, StreamFormat.WORDS, (), schema, near)


def _stride(rate_Hz: float, tick_s: float) -> int:
    """Return the ticks between two records.

    Raises:
        ValueRefused: the rate is not one of the drive's.
    """
    if not 0.0 < rate_Hz < 1e9:
        raise ValueRefused(f"a rate of {rate_Hz:g} Hz is not possible: choose one up to {1.0 / tick_s:g} Hz")
    ticks = 1.0 / (rate_Hz * tick_s)
    whole = max(1, min(_LONGEST_STRIDE, round(ticks)))
    if abs(ticks - whole) > _ROUNDING * ticks:
        raise ValueRefused(
            f"a rate of {rate_Hz:g} Hz is a record every {ticks:g} ticks, the drive counts whole ticks, 1 to "
            f"{_LONGEST_STRIDE}: choose {1.0 / (whole * tick_s):.6g} Hz"
        )
    return whole
