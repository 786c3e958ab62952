"""Requests and answers on a serial line: one at a time, told apart by tags, late ones passed over."""

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

Question = Identify | Read | Write | Open | Chunks | Stream
Answer = Identity | ReadReply | WriteReply | OpenReply | ChunkReply | StreamReply | Reject

_TYPES: dict[type[Question], tuple[MessageType, type[Answer]]] = {
    Identify: (MessageType.IDENTIFY, Identity),
    Read: (MessageType.READ, ReadReply),
    Write: (MessageType.WRITE, WriteReply),
    Open: (MessageType.OPEN, OpenReply),
    Chunks: (MessageType.CHUNKS, ChunkReply),
    Stream: (MessageType.STREAM, StreamReply),
}


class UnansweredError(Exception):
    """No answer came in time, or none can come any more."""


@dataclass
class _Pending:
    question: Question
    answers: queue.SimpleQueue[Answer | None] = field(default_factory=queue.SimpleQueue)


class Exchange:
    """Pairs questions of the caller's thread with answers of the receive thread; one question at a time.

    Args:
        send: takes a question.
        timeout_s: wall time to wait for each answer.
        settle: `Clock.settle`; an answer that is not there when it is true is not waited for.
    """

    def __init__(
        self, send: Callable[[Question], None], timeout_s: float, settle: Callable[[], bool]
    ) -> None:
        self.timeout_s = timeout_s
        self.stale = 0
        """Answers to no question that is open."""
        self._send = send
        self._settle = settle
        self._tag = 0
        self._pending: _Pending | None = None

    @contextmanager
    def asking(self, question: Question) -> Iterator[Callable[[], Answer]]:
        """Send a question under a new tag; what is yielded returns its next answer.

        Raises:
            UnansweredError: by the call of what is yielded.
        """
        self._tag = self._tag + 1 & 0xFF
        pending = _Pending(replace(question, tag=self._tag))
        self._pending = pending
        try:
            self._send(pending.question)
            yield lambda: self._next(pending)
        finally:
            self._pending = None
            self.stale += pending.answers.qsize()

    def take(self, answer: Answer) -> None:
        """Take an answer from the receive thread."""
        pending = self._pending
        if pending is not None and _answers(pending.question, answer):
            pending.answers.put(answer)
        else:
            self.stale += 1

    def end(self) -> None:
        """No answer will come any more: nobody waits on."""
        if (pending := self._pending) is not None:
            pending.answers.put(None)

    def _next(self, pending: _Pending) -> Answer:
        timeout_s = self.timeout_s
        if pending.answers.empty() and self._settle():
            timeout_s = 0.0  # what has not come by now never will
        try:
            answer = pending.answers.get(timeout=timeout_s)
        except queue.Empty:
            answer = None
        if answer is None:
            raise UnansweredError
        return answer


def _answers(question: Question, answer: Answer) -> bool:
    kind, expected = _TYPES[type(question)]
    if answer.tag != question.tag:
        return False
    if isinstance(answer, Reject):
        return answer.type == kind
    if not isinstance(answer, expected):
        return False
    if isinstance(question, Chunks) and isinstance(answer, ChunkReply):
        return answer.upload == question.upload
    if isinstance(question, Read | Write | Open) and isinstance(answer, ReadReply | WriteReply | OpenReply):
        return (answer.index, answer.sub) == (question.index, question.sub)
    return True
