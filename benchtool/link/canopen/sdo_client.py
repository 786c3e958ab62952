"""The SDO client of the canopen package, made safe for writes and fast for long reads (CiA 301, 7.2.4.3).

From the package come requests, answers, aborts and the expedited and segmented upload. Its streams for the
other transfers are not used: they send again, when closed or collected, after a failure, which can complete
a write that was given up. Here a transfer is one call that has ended, on both sides, when it returns.
"""

# The base class has no annotations.
# mypy: disallow-untyped-calls=False

from __future__ import annotations

import binascii
import queue
import time
from collections.abc import Callable, Sequence

import canopen
from canopen.sdo import client
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from benchtool.protocol.canopen import (
    MAX_BLOCK_SIZE,
    SEGMENT_SIZE,
    Abort,
    Block,
    Request,
    Response,
    cob_id,
    sdo,
)

_QUEUE_SIZE = 1024
_FRUITLESS_SUB_BLOCKS = 3
_UNANSWERED = b""  # among the responses, where none will come
_HEADERS = [bytes([value]) for value in range(256)]


class SdoTimeoutError(SdoCommunicationError):
    """The server did not answer in time."""


class BlockNotOfferedError(SdoCommunicationError):
    """The server has no block upload, or prefers another protocol."""


class SdoClient(client.SdoClient):
    """Client of one server; not thread-safe.

    Every transfer raises SdoTimeoutError, canopen.SdoAbortedError if the server aborts, or
    canopen.SdoCommunicationError if it answers out of protocol or with a wrong CRC; python-can's errors
    pass through. Nothing is repeated but lost segments within a block transfer.

    Args:
        network: to send on; its owner has `on_response` called for every frame of the server.
        node_id: the server's.
        timeout_s: wall time to wait for each answer.
        drained: given a test for an answer and `timeout_s`, as `clock.drained`; an answer that is not there
            when it is true is not waited for.
    """

    def __init__(
        self,
        network: canopen.Network,
        node_id: int,
        timeout_s: float,
        drained: Callable[[Callable[[], bool], float], bool] = lambda *_: False,
    ) -> None:
        super().__init__(
            cob_id.SDO_REQUEST + node_id, cob_id.SDO_RESPONSE + node_id, canopen.ObjectDictionary()
        )
        self.network = network
        self.timeout_s = timeout_s
        self._drained = drained
        self.overruns = 0
        self.stale = 0
        """Late answers to earlier requests."""
        # Four times as fast as the package's queue, whose other methods are not called.
        self.responses: queue.SimpleQueue[bytes] = queue.SimpleQueue()  # type: ignore[assignment]  # see above
        self._object = bytes(3)

    # ---- frames ------------------------------------------------------------------------------------------

    def on_response(self, can_id: int, data: bytes | bytearray, timestamp: float) -> None:
        """Take a frame from the receive thread."""
        if self.responses.qsize() < _QUEUE_SIZE:
            self.responses.put(bytes(data))
        else:
            self.overruns += 1

    def on_responses(self, frames: Sequence[bytes]) -> None:
        """Take frames that came at once from the receive thread."""
        room = max(0, _QUEUE_SIZE - self.responses.qsize())
        self.overruns += max(0, len(frames) - room)
        put = self.responses.put
        for data in frames[:room]:
            put(data)

    def end_waiting(self) -> None:
        """Have a transfer that waits for an answer time out now: reception has ended."""
        self.responses.put(_UNANSWERED)

    def read_response(self) -> bytes:
        """Return the next frame of the server."""
        return self._raise_abort(self._next_frame(self.timeout_s))

    def request_response(self, request: bytes) -> bytes:
        """Send a request and return its answer; late answers to earlier requests are dropped."""
        while not self.responses.empty():
            self.responses.get_nowait()
            self.stale += 1
        initiates = sdo.initiates(request[0])
        if initiates:
            self._object = bytes(request[1:4])
        self.send_request(request)
        deadline_s = time.monotonic() + self.timeout_s
        try:
            while True:
                response = self._next_frame(max(0.0, deadline_s - time.monotonic()))
                if not initiates or response[1:4] == self._object or _aborts_anything(response):
                    return self._raise_abort(response)
                self.stale += 1
        except SdoTimeoutError:
            self.abort(Abort.TIMED_OUT)
            raise

    def abort(self, abort_code: int = Abort.GENERAL) -> None:
        """Tell the server that the transfer is over."""
        self.send_request(bytes([sdo.ABORT]) + self._object + sdo.ABORT_CODE.pack(abort_code))

    def _next_frame(self, timeout_s: float) -> bytes:
        try:  # `suppress` would cost as much as all else here
            frame = self.responses.get_nowait()
        except queue.Empty:
            if self.responses.empty() and self._drained(self._has_response, self.timeout_s):
                timeout_s = 0.0  # an answer that is not there now will not come
            try:
                frame = self.responses.get(timeout=timeout_s)
            except queue.Empty:
                frame = _UNANSWERED
        if frame == _UNANSWERED:
            raise SdoTimeoutError("no answer")
        return frame

    def more_answers(self, index: int, sub: int) -> int:
        """Return how many answers to the last request are left, which are dropped: of other nodes."""
        more = 0
        while not self.responses.empty():
            if (frame := self.responses.get_nowait()) != _UNANSWERED:
                more += sdo.key(frame) == (index, sub)
                self.stale += 1
        return more

    def _has_response(self) -> bool:
        return not self.responses.empty()

    def _raise_abort(self, response: bytes) -> bytes:
        if response[0] == sdo.ABORT:
            raise SdoAbortedError(int.from_bytes(response[4:8], "little"))
        return response

    def _refuse(self, response: bytes, code: Abort, reason: str) -> SdoCommunicationError:
        self.abort(code)
        return SdoCommunicationError(f"{reason} (frame {response.hex(' ')})")

    # ---- download ----------------------------------------------------------------------------------------

    def download(self, index: int, subindex: int, data: bytes, force_segment: bool = False) -> None:
        """Write by expedited (1 to 4 bytes) or segmented transfer."""
        size = len(data)
        if 1 <= size <= 4 and not force_segment:
            command, value = sdo.expedited(Request.DOWNLOAD, size), int.from_bytes(data, "little")
            self._confirm(sdo.INITIATE.pack(command, index, subindex, value), Response.DOWNLOAD)
            return
        command = Request.DOWNLOAD | sdo.SIZE_INDICATED
        self._confirm(sdo.INITIATE.pack(command, index, subindex, size), Response.DOWNLOAD)
        toggle = 0
        for start in range(0, max(1, size), SEGMENT_SIZE):
            chunk, last = data[start : start + SEGMENT_SIZE], start + SEGMENT_SIZE >= size
            request = sdo.segment(Request.DOWNLOAD_SEGMENT, toggle, chunk, last=last)
            self._confirm(request, Response.DOWNLOAD_SEGMENT | toggle)
            toggle ^= sdo.TOGGLE

    def block_download(self, index: int, subindex: int, data: bytes) -> None:
        """Write by block transfer with CRC."""
        command = Request.BLOCK_DOWNLOAD | sdo.BLOCK_CRC | sdo.BLOCK_SIZE_INDICATED
        response = self.request_response(sdo.INITIATE.pack(command, index, subindex, len(data)))
        if not _is_block(response, Response.BLOCK_DOWNLOAD, Block.INITIATE):
            raise self._refuse(response, Abort.COMMAND_SPECIFIER, "no answer to a block download")
        segments = _segments(data)
        position, size, fruitless = 0, self._block_size(response, response[4]), 0
        while position < len(segments):
            acknowledgement = self._send_sub_block(segments, position, size)
            acknowledged = acknowledgement[1]
            fruitless = 0 if acknowledged else fruitless + 1
            if acknowledged > len(segments[position : position + size]) or fruitless == _FRUITLESS_SUB_BLOCKS:
                raise self._refuse(acknowledgement, Abort.SEQUENCE_NUMBER, "the segments do not get through")
            position += acknowledged
            size = self._block_size(acknowledgement, acknowledgement[2])
        unused = SEGMENT_SIZE * len(segments) - len(data)
        crc = binascii.crc_hqx(data, 0) if response[0] & sdo.BLOCK_CRC else 0
        self._confirm(sdo.block_end(Request.BLOCK_DOWNLOAD, unused, crc), Response.BLOCK_DOWNLOAD | Block.END)

    def _send_sub_block(self, segments: list[bytes], position: int, size: int) -> bytes:
        sub_block = segments[position : position + size]
        for number, segment in enumerate(sub_block, start=1):
            last = position + number == len(segments)
            self.send_request(_HEADERS[sdo.LAST_SEGMENT | number if last else number] + segment)
        try:
            response = self.read_response()
        except SdoTimeoutError:
            self.abort(Abort.TIMED_OUT)
            raise
        if response[0] != Response.BLOCK_DOWNLOAD | Block.ACKNOWLEDGE:
            raise self._refuse(response, Abort.COMMAND_SPECIFIER, "no acknowledgement of a sub-block")
        return response

    def _block_size(self, response: bytes, size: int) -> int:
        if not 1 <= size <= MAX_BLOCK_SIZE:
            raise self._refuse(response, Abort.BLOCK_SIZE, f"a block size of {size}")
        return size

    def _confirm(self, request: bytes, expected: int) -> None:
        response = self.request_response(request)
        if response[0] != expected:
            raise self._refuse(response, Abort.COMMAND_SPECIFIER, f"0x{expected:02X} expected")

    # ---- upload ------------------------------------------------------------------------------------

    def upload(self, index: int, subindex: int, length: int | None = None) -> bytes:
        """Read by expedited or segmented transfer, as the server chooses.

        Of an expedited answer without size indication (7.2.4.3.6, s = 0) the first `length` bytes are taken,
        all four if it is None.
        """
        with self.open(index, subindex, buffering=0) as stream:
            data, announced, expedited = bytes(stream.read()), stream.size, stream.exp_data is not None
        if expedited and announced is None:
            return data[:length]
        if announced is not None and announced != len(data):
            raise SdoCommunicationError(f"{len(data)} bytes came, {announced} were announced")
        return data

    def block_upload(self, index: int, subindex: int) -> bytes:
        """Read by block transfer and check the CRC.

        Raises:
            BlockNotOfferedError: read it by `upload`.
        """
        try:
            return self._block_upload(index, subindex)
        except SdoTimeoutError:
            self.abort(Abort.TIMED_OUT)
            raise

    def _block_upload(self, index: int, subindex: int) -> bytes:
        command = Request.BLOCK_UPLOAD | sdo.BLOCK_CRC
        request = sdo.INITIATE.pack(command, index, subindex, MAX_BLOCK_SIZE)
        try:
            start = self.request_response(request)
        except SdoAbortedError as aborted:
            if aborted.code == Abort.COMMAND_SPECIFIER:
                raise BlockNotOfferedError("block upload refused") from None
            raise
        if start[0] & (sdo.SPECIFIER | Block.END) != Response.BLOCK_UPLOAD | Block.INITIATE:
            self.abort(Abort.COMMAND_SPECIFIER)
            raise BlockNotOfferedError("block upload answered by another protocol")
        self.send_request(_block_request(Block.START_UPLOAD))
        segments = self._receive_segments()
        end = self.read_response()
        if not _is_block(end, Response.BLOCK_UPLOAD, Block.END):
            raise self._refuse(end, Abort.COMMAND_SPECIFIER, "no end of the block upload")
        joined = b"".join(segments)
        data = joined[: len(joined) - sdo.block_unused(end[0])]
        if start[0] & sdo.BLOCK_CRC and int.from_bytes(end[1:3], "little") != binascii.crc_hqx(data, 0):
            raise self._refuse(end, Abort.CRC, f"the CRC of {len(data)} bytes is wrong")
        if start[0] & sdo.BLOCK_SIZE_INDICATED and int.from_bytes(start[4:8], "little") != len(data):
            raise self._refuse(start, Abort.LENGTH, f"{len(data)} bytes came, others were announced")
        self.send_request(_block_request(Block.END))
        return data

    def _receive_segments(self) -> list[bytes]:
        segments: list[bytes] = []
        in_order = fruitless = 0
        take = self.responses.get_nowait
        while True:
            ended = complete = False
            try:
                frame = self._next_frame(self.timeout_s)
                while frame[0] == in_order + 1 < MAX_BLOCK_SIZE:  # most of a block
                    in_order += 1
                    segments.append(frame[1:])
                    frame = take()
                self._raise_abort(frame)
            except queue.Empty:
                continue
            except SdoTimeoutError:
                # With none in order nothing may be acknowledged: a lost acknowledgement would count twice.
                if not in_order:
                    raise
                ended = True
            else:
                last, number = bool(frame[0] & sdo.LAST_SEGMENT), frame[0] & ~sdo.LAST_SEGMENT
                ended = last or number == MAX_BLOCK_SIZE
                if number == in_order + 1:
                    in_order = number
                    segments.append(frame[1:])
                    complete = last
            if ended:
                fruitless = 0 if in_order else fruitless + 1
                if fruitless == _FRUITLESS_SUB_BLOCKS:
                    raise self._refuse(frame, Abort.SEQUENCE_NUMBER, "the segments do not get through")
                self.send_request(_block_request(Block.ACKNOWLEDGE, in_order, MAX_BLOCK_SIZE))
                in_order = 0
                if complete:
                    return segments


def _segments(data: bytes) -> list[bytes]:
    starts = range(0, max(1, len(data)), SEGMENT_SIZE)
    return [data[start : start + SEGMENT_SIZE].ljust(SEGMENT_SIZE, b"\x00") for start in starts]


def _block_request(subcommand: Block, *content: int) -> bytes:
    """Return a request of a block upload that is under way."""
    return bytes([Request.BLOCK_UPLOAD | subcommand, *content]).ljust(sdo.FRAME_SIZE, b"\x00")


def _is_block(response: bytes, specifier: Response, subcommand: Block) -> bool:
    return response[0] & (sdo.SPECIFIER | sdo.BLOCK_SUBCOMMAND) == specifier | subcommand


def _aborts_anything(response: bytes) -> bool:
    """Return whether it is an abort that names no object: some servers leave that out."""
    return response[0] == sdo.ABORT and not any(response[1:4])
