"""A drive's end of a serial line that only streams, in real time: a process of `benchmarks.serial`.

It answers what a host asks before a stream and sends batches of made-up records when they are due, over a
pseudo-terminal whose name it prints. It never waits for the line: a batch that does not fit the backlog is
dropped and counted, as a drive would. Its own processor time is not counted.
"""

from __future__ import annotations

import os
import select
import struct
import sys
import time
import tty
from contextlib import suppress

import numpy as np

from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.serial import (
    Batch,
    FrameSplitter,
    Heartbeat,
    Identify,
    Identity,
    Message,
    Nmt,
    Read,
    ReadReply,
    Stream,
    StreamReply,
    decode_request,
    encode_frame,
    encode_message,
)
from benchtool.shipped import shipped

TICK_S = 1e-4
_BACKLOG_BYTES = 1 << 16
_WORD = 4
_POLL_S = 1e-3


class Streamer:
    """The state of the line and of the one stream on it."""

    def __init__(self, descriptor: int, max_reply: int) -> None:
        self._descriptor = descriptor
        self._max_reply = max_reply
        dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
        period = dictionary["control_period"]
        self._readable = {(period.index, period.sub): struct.pack("<f", TICK_S)}
        self._heard = FrameSplitter()
        self._backlog = bytearray()
        self._stream: Stream | None = None
        self._schema = self._sequence = self._sent = self._dropped = 0
        self._start_s = 0.0
        self._records: list[bytes] = []

    def run(self) -> None:
        """Run until the host closes its end of the terminal, or standard input ends."""
        while True:
            writable = [self._descriptor] if self._backlog else []
            ready, _, _ = select.select([self._descriptor, sys.stdin], writable, [], self._pause_s())
            if sys.stdin in ready:
                return
            if self._descriptor in ready:
                try:
                    heard = os.read(self._descriptor, 4096)
                except OSError:  # the host has closed its end; another may come
                    self._stream = None
                    time.sleep(0.01)
                    continue
                for payload in self._heard.feed(heard):
                    self._answer(decode_request(payload))
            self._send_due()
            self._flush()

    def _answer(self, request: object) -> None:
        match request:
            case Identify(tag):
                self._say(
                    Identity(
                        tag, 0, 1, 1, 5, 0, 0, 0, 0, 0, round(TICK_S * 1e9), 128, self._max_reply, "made up"
                    )
                )
            case Read(tag, index, sub):
                data = self._readable.get((index, sub), b"")
                self._say(ReadReply(tag, 0 if data else 0x06020000, index, sub, data))
            case Stream():
                self._say(StreamReply(request.tag, 0, self._schema + 1, self._sent, self._dropped))
                self._schema += 1
                self._sequence = self._sent = self._dropped = 0
                self._stream = request if request.stride else None
                self._start_s = time.monotonic()
                random = np.random.default_rng(1)
                shape = request.batch, len(request.mappings)
                self._records = [random.standard_normal(shape, dtype=np.float32).tobytes() for _ in range(50)]
            case Nmt():
                self._say(Heartbeat(5, 0))

    def _pause_s(self) -> float:
        if self._stream is None:
            return 0.1
        if self._backlog:
            return _POLL_S
        period_s = self._stream.batch * self._stream.stride * TICK_S
        return max(0.0, self._start_s + (self._sequence + 1) * period_s - time.monotonic())

    def _send_due(self) -> None:
        stream = self._stream
        if stream is None:
            return
        due = int((time.monotonic() - self._start_s) / (stream.batch * stream.stride * TICK_S))
        while self._sequence < due:
            first = self._sequence * stream.batch * stream.stride % (1 << 32)
            data = self._records[self._sequence % len(self._records)]
            batch = Batch(self._schema, self._sequence, first, stream.stride, stream.batch, data)
            self._sequence += 1
            self._sent += stream.batch
            if len(self._backlog) + len(data) > _BACKLOG_BYTES:
                self._dropped += stream.batch
            else:
                self._say(batch)

    def _say(self, message: Message) -> None:
        self._backlog += encode_frame(encode_message(message))

    def _flush(self) -> None:
        if self._backlog:
            with suppress(BlockingIOError):
                del self._backlog[: os.write(self._descriptor, self._backlog)]


def main() -> None:
    """Serve until standard input ends."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    sys.stdout.write(os.ttyname(slave) + "\n")
    sys.stdout.flush()
    try:
        Streamer(master, int(sys.argv[1])).run()
    finally:
        os.close(slave)
        os.close(master)


if __name__ == "__main__":
    main()
