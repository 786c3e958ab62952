"""Requests of a host on a serial line, and the handling of the responses."""

from __future__ import annotations

import threading
import zlib
from collections.abc import Callable, Sequence
from typing import TypeVar

from benchtool.errors import IdentityMismatch, LinkClosed, LinkError, NoAnswer, SdoAbort, ValueRefused
from benchtool.link.serial.request_response import Answer, NoResponseError, Request, RequestResponse
from benchtool.protocol.canopen import Abort, abort_text
from benchtool.protocol.serial import (
    VERSION,
    ChunkReply,
    Chunks,
    Identify,
    Identity,
    Open,
    OpenReply,
    Read,
    ReadReply,
    Reject,
    RejectReason,
    Stream,
    StreamReply,
    Write,
    WriteReply,
)

_WINDOW_BYTES = 8192  # of chunks under way at a time: a drive's buffer for answers is small
_WINDOW_CHUNKS = 64
_ROUNDS = 3
_WRITE_HEAD = 5
_BATCH_HEAD = 14
_WORD = 4
_MOST_CHANNELS = 16
_REJECTED = {int(each): each.name.lower().replace("_", " ") for each in RejectReason}

Expected = TypeVar("Expected", Identity, ReadReply, WriteReply, OpenReply, StreamReply)


class SerialRequests:
    """The requests of a `SerialLink`, one at a time; methods raise what the link's say.

    The first request, and the first after `reset`, is preceded by a request for the identity.

    Args:
        request_response: over which requests go.
        node_id: the drive's.
        require_open: raises LinkClosed if the port is closed or gone.
    """

    def __init__(
        self, request_response: RequestResponse, node_id: int, require_open: Callable[[], None]
    ) -> None:
        self.retries = 0
        self.aborts = 0
        self.odd_chunks = 0
        """Chunks that were not asked for, or of a wrong length."""
        self._request_response = request_response
        self._node_id = node_id
        self._require_open = require_open
        self._lock = threading.Lock()
        self._identity: Identity | None = None

    def identity(self) -> Identity:
        """Return the identity of the drive; request it if it is unknown."""
        if (known := self._identity) is not None:
            return known
        with self._lock:
            return self._greet()

    def reset(self) -> None:
        """Request the identity again with the next request; from any thread."""
        self._identity = None

    def upload(self, index: int, sub: int, *, in_chunks: bool) -> bytes:
        """See `SerialLink.upload`."""
        doing = f"reading 0x{index:04X}:{sub}"
        with self._lock:
            self._greet()
            if not in_chunks:
                reply = self._ask(Read(0, index, sub), ReadReply, doing, twice=True)
                if reply.status != Abort.OUT_OF_MEMORY:
                    self._require_done(reply.status, doing)
                    return reply.data
            try:
                return self._upload_chunks(index, sub, doing)
            except (NoAnswer, LinkClosed):
                raise
            except LinkError:
                self.retries += 1
                return self._upload_chunks(index, sub, f"{doing}, asked twice")

    def download(self, index: int, sub: int, data: bytes) -> None:
        """See `SerialLink.download`."""
        doing = f"writing 0x{index:04X}:{sub}"
        with self._lock:
            room = self._greet().max_request - _WRITE_HEAD
            if not 1 <= len(data) <= room:
                raise ValueRefused(
                    f"{len(data)} bytes for 0x{index:04X}:{sub}, a write over this line carries 1 to {room}: "
                    f"nothing was sent; write it over CAN"
                )
            reply = self._ask(Write(0, index, sub, data), WriteReply, doing)
            self._require_done(reply.status, doing)

    def batch_rows(self, channels: int) -> int:
        """See `BatchLink.batch_rows`."""
        if not 1 <= channels <= _MOST_CHANNELS:
            return 0
        room = self.identity().max_reply - _BATCH_HEAD
        return max(0, min(0xFF, room // (_WORD * channels)))

    def configure_stream(self, mappings: Sequence[int], stride: int, batch: int) -> StreamReply:
        """See `BatchLink.configure_stream`."""
        doing = "starting the stream" if stride else "stopping the stream"
        with self._lock:
            self._greet()
            reply = self._ask(Stream(0, stride, batch, mappings=tuple(mappings)), StreamReply, doing)
            self._require_done(reply.status, doing)
            return reply

    # ---- inside ------------------------------------------------------------------------------------------

    def _greet(self) -> Identity:
        """Return the identity of the drive; request it if it is unknown.

        Raises:
            IdentityMismatch: another node than that of the address.
            LinkError: the drive speaks another version of the protocol.
        """
        if self._identity is not None:
            return self._identity
        identity = self._ask(Identify(0), Identity, "asking who is there", twice=True)
        if identity.version != VERSION:
            older = "benchtool" if identity.version > VERSION else "the drive's firmware"
            raise LinkError(
                f"the drive speaks version {identity.version} of the serial protocol, this benchtool version "
                f"{VERSION}: update {older}"
            )
        self._require_done(identity.status, "asking who is there")
        if identity.node_id != self._node_id:
            raise IdentityMismatch(
                f"the drive on this line is node {identity.node_id}, node {self._node_id} is expected: "
                f"check which line this is, or add node={identity.node_id} to the address"
            )
        self._identity = identity
        return identity

    def _upload_chunks(self, index: int, sub: int, doing: str) -> bytes:
        opened = self._ask(Open(0, index, sub), OpenReply, doing, twice=True)
        self._require_done(opened.status, doing)
        if opened.size and not opened.chunk_size:
            raise self._out_of_protocol(doing, "chunks of no bytes were announced")
        count = -(-opened.size // opened.chunk_size) if opened.size else 0
        window = max(1, min(_WINDOW_CHUNKS, _WINDOW_BYTES // max(1, opened.chunk_size)))
        parts: dict[int, bytes] = {}
        for first in range(0, count, window):
            wanted = range(first, min(first + window, count))
            self._fetch(opened, wanted, parts, doing)
            for _ in range(_ROUNDS):
                for number in (each for each in wanted if each not in parts):
                    self.retries += 1
                    self._fetch(opened, range(number, number + 1), parts, doing)
            if missing := sum(number not in parts for number in wanted):
                raise NoAnswer(
                    f"node {self._node_id} did not send {missing} of {count} chunks when {doing}, each asked "
                    f"for {_ROUNDS + 1} times; check the wiring and the baud rate"
                )
        data = b"".join(parts[number] for number in range(count))
        if zlib.crc32(data) != opened.crc:
            raise self._out_of_protocol(doing, f"the CRC of {len(data)} bytes is wrong")
        return data

    def _fetch(self, opened: OpenReply, wanted: range, parts: dict[int, bytes], doing: str) -> None:
        """Put chunks into `parts`, until all are there or none comes any more."""
        missing = set(wanted)
        with self._request_response.request(Chunks(0, opened.upload, wanted.start, len(wanted))) as answer:
            while missing:
                try:
                    reply = self._accepted(answer(), doing)
                except NoResponseError:
                    self._require_open()
                    return
                assert isinstance(reply, ChunkReply)
                self._require_done(reply.status, doing)
                length = min(opened.chunk_size, opened.size - reply.chunk * opened.chunk_size)
                if reply.chunk in missing and len(reply.data) == length:
                    parts[reply.chunk] = reply.data
                    missing.remove(reply.chunk)
                else:
                    self.odd_chunks += 1

    def _ask(
        self, request: Request, expected: type[Expected], doing: str, *, twice: bool = False
    ) -> Expected:
        try:
            reply = self._ask_once(request, doing)
        except NoResponseError:
            self._require_open()
            if not twice:
                raise self._no_answer(doing, "once") from None
            self.retries += 1
            try:
                reply = self._ask_once(request, doing)
            except NoResponseError:
                self._require_open()
                raise self._no_answer(doing, "twice") from None
        assert isinstance(reply, expected)
        return reply

    def _ask_once(self, request: Request, doing: str) -> Answer:
        with self._request_response.request(request) as answer:
            return self._accepted(answer(), doing)

    def _accepted(self, reply: Answer, doing: str) -> Answer:
        if isinstance(reply, Reject):
            reason = _REJECTED.get(reply.reason, f"reason {reply.reason}")
            raise self._out_of_protocol(doing, f"it rejects message type 0x{reply.type:02X}, {reason}")
        return reply

    def _require_done(self, status: int, doing: str) -> None:
        if status:
            self.aborts += 1
            raise SdoAbort(f"node {self._node_id} refused {doing}: {abort_text(status)}", status)

    def _no_answer(self, doing: str, times: str) -> NoAnswer:
        return NoAnswer(
            f"node {self._node_id} did not answer within {self._request_response.timeout_s:g} s when "
            f"{doing}, asked {times}; check that the drive is powered, the baud rate and the wiring"
        )

    def _out_of_protocol(self, doing: str, reason: str) -> LinkError:
        return LinkError(
            f"node {self._node_id} answered out of protocol when {doing}: {reason}; "
            f"check the wiring, and that the drive's firmware speaks version {VERSION} of the serial protocol"
        )
