"""Requests and responses on a serial line: one at a time, matched by tags; late responses are dropped."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from benchtool.protocol.serial import (
    ChunkReply,
    Chunks,
    Identify,
    Identity,
    MessageType,
    Open,
    OpenReply,
    Read,
    ReadReply,
    Reject,
    Stream,
    StreamReply,
    Write,
    WriteReply,
)

Request = Identify | Read | Write | Open | Chunks | Stream
Answer = Identity | ReadReply | WriteReply | OpenReply | ChunkReply | StreamReply | Reject

_TYPES: dict[type[Request], tuple[MessageType, type[Answer]]] = {
    Identify: (MessageType.IDENTIFY, Identity),
    Read: (MessageType.READ, ReadReply),
    Write: (MessageType.WRITE, WriteReply),
    Open: (MessageType.OPEN, OpenReply),
    Chunks: (MessageType.CHUNKS, ChunkReply),
    Stream: (MessageType.STREAM, StreamReply),
}


class NoResponseError(Exception):
    """No answer came in time, or none can come any more."""


@dataclass
class _Pending:
    request: Request
    answers: queue.SimpleQueue[Answer | None] = field(default_factory=queue.SimpleQueue)


class RequestResponse:
    """Pairs requests of the caller's thread with answers of the receive thread; one request at a time.

    Args:
        send: takes a request.
        timeout_s: wall time to wait for each answer.
        drained: given a test for an answer and `timeout_s`, as `clock.drained`; an answer that is not there
            when it is true is not waited for.
    """

    def __init__(
        self,
        send: Callable[[Request], None],
        timeout_s: float,
        drained: Callable[[Callable[[], bool], float], bool],
    ) -> None:
        self.timeout_s = timeout_s
        self.stale = 0
        """Answers to no request that is open."""
        self._send = send
        self._drained = drained
        self._tag = 0
        self._pending: _Pending | None = None

    @contextmanager
    def request(self, request: Request) -> Iterator[Callable[[], Answer]]:
        """Send a request under a new tag; what is yielded returns its next answer.

        Raises:
            NoResponseError: no response came; raised by the call of the yielded function.
        """
        self._tag = self._tag + 1 & 0xFF
        pending = _Pending(replace(request, tag=self._tag))
        self._pending = pending
        try:
            self._send(pending.request)
            yield lambda: self._next(pending)
        finally:
            self._pending = None
            self.stale += pending.answers.qsize()

    def on_response(self, answer: Answer) -> None:
        """Take an answer from the receive thread."""
        pending = self._pending
        if pending is not None and _answers(pending.request, answer):
            pending.answers.put(answer)
        else:
            self.stale += 1

    def close(self) -> None:
        """End a pending wait: no answer will come any more."""
        if (pending := self._pending) is not None:
            pending.answers.put(None)

    def _next(self, pending: _Pending) -> Answer:
        timeout_s = self.timeout_s
        if pending.answers.empty() and self._drained(lambda: not pending.answers.empty(), timeout_s):
            timeout_s = 0.0  # an answer that is not there now will not come
        try:
            answer = pending.answers.get(timeout=timeout_s)
        except queue.Empty:
            answer = None
        if answer is None:
            raise NoResponseError
        return answer


def _answers(request: Request, answer: Answer) -> bool:
    kind, expected = _TYPES[type(request)]
    if answer.tag != request.tag:
        return False
    if isinstance(answer, Reject):
        return answer.type == kind
    if not isinstance(answer, expected):
        return False
    if isinstance(request, Chunks) and isinstance(answer, ChunkReply):
        return answer.upload == request.upload
    if isinstance(request, Read | Write | Open) and isinstance(answer, ReadReply | WriteReply | OpenReply):
        return (answer.index, answer.sub) == (request.index, request.sub)
    return True
