"""SDO transfers in a recorded trace: what was read and written (CiA 301, 7.2.4.3)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum

from benchtool.protocol.canopen import EXPEDITED, SIZE_INDICATED, SPECIFIER, Block, Request, Response, sdo


class Kind(Enum):
    """How a transfer ended."""

    READ = "read"
    WRITTEN = "written"
    ABORTED = "aborted"


@dataclass(frozen=True)
class Transfer:
    """One transfer, ended by frame number `position`; `data` of an abort are the four bytes of its code.

    Not `sized` is one that brought four bytes and does not say how many of them count.
    """

    position: int
    kind: Kind
    key: tuple[int, int]
    data: bytes
    sized: bool = True


def transfers(frames: Iterable[tuple[int, bool, bytes]]) -> Iterator[Transfer]:
    """Yield every transfer between one client and one server that came to an end.

    Expedited and segmented transfers both ways, and block uploads; block downloads are ignored.

    Args:
        frames: number, whether it is of the server, and data of each SDO frame, in order.
    """
    conversation = _Conversation()
    for position, of_server, data in frames:
        if len(data) == sdo.FRAME_SIZE:
            ended = conversation.answer(data) if of_server else conversation.request(data)
            if ended is not None:
                yield Transfer(position, *ended, sized=conversation.sized)


_Ended = tuple[Kind, tuple[int, int], bytes]


class _Conversation:
    def __init__(self) -> None:
        self._key = (0, 0)
        self._content = b""
        self._in_blocks = False
        self._segment = 0
        self._writing = False
        self.sized = True
        """Whether the transfer said how many bytes it has."""

    def request(self, data: bytes) -> _Ended | None:
        """Take a frame of the client."""
        command = data[0] & SPECIFIER
        if sdo.initiates(data[0]) and command != Request.BLOCK_DOWNLOAD:
            self._key, self._content, self._in_blocks = sdo.key(data), b"", False
            self._writing, self.sized = command == Request.DOWNLOAD, not _is_unsized(data)
            if command == Request.DOWNLOAD and data[0] & EXPEDITED:
                self._content = sdo.expedited_data(data)
        elif command == Request.DOWNLOAD_SEGMENT and self._writing:
            self._content += sdo.segment_data(data)
            self._last = bool(data[0] & sdo.NO_MORE_SEGMENTS)
        elif command == Request.BLOCK_UPLOAD and data[0] & sdo.BLOCK_SUBCOMMAND == Block.ACKNOWLEDGE:
            self._segment = 0
        elif data[0] == sdo.ABORT:
            self._in_blocks = False
        return None

    def answer(self, data: bytes) -> _Ended | None:
        """Take a frame of the server."""
        if self._in_blocks and self._block(data):
            return None
        command = data[0] & SPECIFIER
        if data[0] == sdo.ABORT:
            self._in_blocks = False
            return Kind.ABORTED, self._key, data[4:8]
        if command == Response.UPLOAD and sdo.key(data) == self._key:
            self._content, self.sized = b"", not _is_unsized(data)
            return (Kind.READ, self._key, sdo.expedited_data(data)) if data[0] & EXPEDITED else None
        if command == Response.UPLOAD_SEGMENT:
            self._content += sdo.segment_data(data)
            return (Kind.READ, self._key, self._content) if data[0] & sdo.NO_MORE_SEGMENTS else None
        if command == Response.DOWNLOAD and sdo.key(data) == self._key:
            # Segments follow if the request had no data of its own.
            return (Kind.WRITTEN, self._key, self._content) if self._content else None
        if command == Response.DOWNLOAD_SEGMENT and self._writing and self._last:
            return Kind.WRITTEN, self._key, self._content
        if command == Response.BLOCK_UPLOAD:
            return self._block_command(data)
        return None

    def _block_command(self, data: bytes) -> _Ended | None:
        if not data[0] & Block.END:
            self._in_blocks, self._segment, self._content = True, 0, b""
            return None
        end = len(self._content) - sdo.block_unused(data[0])
        return Kind.READ, self._key, self._content[:end]

    def _block(self, data: bytes) -> bool:
        """Take a segment; one that is repeated after a loss counts once."""
        number = data[0] & ~sdo.LAST_SEGMENT
        if number == self._segment + 1:
            self._segment = number
            self._content += data[1:]
            self._in_blocks = not data[0] & sdo.LAST_SEGMENT
            return True
        return data[0] != sdo.ABORT


def _is_unsized(data: bytes) -> bool:
    """Of an initiate of a download, or the answer to one of an upload: expedited, without size indication."""
    initiates = data[0] & SPECIFIER in (Request.DOWNLOAD, Request.UPLOAD)
    return initiates and data[0] & (EXPEDITED | SIZE_INDICATED) == EXPEDITED
