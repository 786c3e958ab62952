"""Ends of a serial line for tests: a port whose other end answers as told, byte by byte if need be."""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Callable, Iterable

from benchtool.clock import VirtualClock
from benchtool.link.pipe import pipe
from benchtool.protocol import serial as wire

NODE = 5
IDENTITY = wire.Identity(
    tag=0,
    status=0,
    version=1,
    node_id=NODE,
    nmt_state=127,
    dictionary_hash=0x1234,
    tick_period_ns=100_000,
    max_request=128,
    max_reply=64,
    device_name="scripted",
)

Step = wire.Message | bytes
"""What the other end sends: a message, or bytes as they are."""


def frame(message: wire.Message) -> bytes:
    return wire.encode_frame(wire.encode_message(message))


class ScriptedPort:
    """A port in virtual time whose other end answers each request as `answer` says; it knows itself."""

    def __init__(self, clock: VirtualClock) -> None:
        self.answer: Callable[[wire.Request], Iterable[Step]] = lambda _: ()
        self.identity: wire.Identity | None = IDENTITY
        self.requests: list[wire.Request] = []
        self.closed = 0
        self.sent = b""
        self.broken: OSError | None = None
        self._near, self._far = pipe(clock)
        self._heard = wire.FrameSplitter()
        clock.register(self._near.settle)

    def read(self) -> bytes:
        return self.read_timed()[0]

    def read_timed(self) -> tuple[bytes, float]:
        return self._near.read_timed()

    def write(self, data: bytes) -> None:
        if self.broken is not None:
            raise self.broken
        self.sent += data
        for payload in self._heard.feed(data):
            request = wire.decode_request(payload)
            assert request is not None
            assert not isinstance(request, wire.Reject)
            if isinstance(request, wire.Identify) and self.identity is not None:
                self.say(dataclasses.replace(self.identity, tag=request.tag))
                continue
            self.requests.append(request)
            self.say(*self.answer(request))

    def say(self, *steps: Step) -> None:
        """Let the other end speak unasked."""
        for step in steps:
            self._far.write(step if isinstance(step, bytes) else frame(step))

    def hang_up(self) -> None:
        """Let the other end go away."""
        self._far.close()

    def close(self) -> None:
        self.closed += 1
        self._near.close()


class Objects:
    """Answers of a drive with a dictionary, whose chunks may be spoilt on their way."""

    def __init__(self, chunk_size: int = 16) -> None:
        self.values: dict[tuple[int, int], bytes] = {}
        self.chunk_size = chunk_size
        self.spoil: Callable[[wire.ChunkReply], Iterable[Step]] = lambda reply: [reply]
        self._open = b""

    def __call__(self, request: wire.Request) -> Iterable[Step]:
        match request:
            case wire.Read(tag, index, sub):
                data = self.values.get((index, sub))
                if data is None:
                    return [wire.ReadReply(tag, 0x06020000, index, sub)]
                if len(data) > IDENTITY.max_reply - 9:
                    return [wire.ReadReply(tag, 0x05040005, index, sub)]
                return [wire.ReadReply(tag, 0, index, sub, data)]
            case wire.Write(tag, index, sub, data):
                self.values[index, sub] = data
                return [wire.WriteReply(tag, 0, index, sub)]
            case wire.Open(tag, index, sub):
                self._open = self.values[index, sub]
                crc = zlib.crc32(self._open)
                return [wire.OpenReply(tag, 0, index, sub, 7, len(self._open), self.chunk_size, crc)]
            case wire.Chunks(tag, upload, first, count):
                size = self.chunk_size
                replies = (
                    wire.ChunkReply(tag, 0, upload, number, self._open[number * size : (number + 1) * size])
                    for number in range(first, first + count)
                )
                return [step for reply in replies for step in self.spoil(reply)]
            case wire.Stream(tag):
                return [wire.StreamReply(tag, 0, schema=3, sent=10, dropped=1)]
            case _:
                return []
