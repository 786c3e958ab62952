"""What SDO transfers on a recorded wire have read and written (CiA 301, 7.2.4.3)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum

_ABORTED = 0x80
_LAST_SEGMENT = 0x80


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
    """Every transfer between one client and one server that came to an end.

    Expedited and segmented transfers both ways, and block uploads; of a block download nothing is told.

    Args:
        frames: number, whether it is of the server, and data of each SDO frame, in order.
    """
    conversation = _Conversation()
    for position, of_server, data in frames:
        if len(data) == 8:
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
        command = data[0] >> 5
        if command in (1, 2) or (command == 5 and not data[0] & 0x03):
            self._key, self._content, self._in_blocks = _key(data), b"", False
            self._writing, self.sized = command == 1, not _is_unsized(data)
            if command == 1 and data[0] & 0x02:
                self._content = _expedited(data)
        elif command == 0 and self._writing:
            self._content += data[1 : 8 - (data[0] >> 1 & 0x07)]
            self._last = bool(data[0] & 0x01)
        elif command == 5 and data[0] & 0x03 == 2:
            self._segment = 0
        elif data[0] == _ABORTED:
            self._in_blocks = False
        return None

    def answer(self, data: bytes) -> _Ended | None:
        """Take a frame of the server."""
        if self._in_blocks and self._block(data):
            return None
        command = data[0] >> 5
        if data[0] == _ABORTED:
            self._in_blocks = False
            return Kind.ABORTED, self._key, data[4:8]
        if command == 2 and _key(data) == self._key:
            self._content, self.sized = b"", not _is_unsized(data)
            return (Kind.READ, self._key, _expedited(data)) if data[0] & 0x02 else None
        if command == 0:
            self._content += data[1 : 8 - (data[0] >> 1 & 0x07)]
            return (Kind.READ, self._key, self._content) if data[0] & 0x01 else None
        if command == 3 and _key(data) == self._key:
            # Segments follow if the request had no data of its own.
            return (Kind.WRITTEN, self._key, self._content) if self._content else None
        if command == 1 and self._writing and self._last:
            return Kind.WRITTEN, self._key, self._content
        if command == 6:
            return self._block_command(data)
        return None

    def _block_command(self, data: bytes) -> _Ended | None:
        if not data[0] & 0x01:
            self._in_blocks, self._segment, self._content = True, 0, b""
            return None
        unused = data[0] >> 2 & 0x07
        return Kind.READ, self._key, self._content[: len(self._content) - unused]

    def _block(self, data: bytes) -> bool:
        """Take a segment; one that is repeated after a loss counts once."""
        number = data[0] & 0x7F
        if number == self._segment + 1:
            self._segment = number
            self._content += data[1:]
            self._in_blocks = not data[0] & _LAST_SEGMENT
            return True
        return data[0] != _ABORTED


def _key(data: bytes) -> tuple[int, int]:
    return int.from_bytes(data[1:3], "little"), data[3]


def _is_unsized(data: bytes) -> bool:
    """Of an initiate of a download, or the answer to one of an upload: expedited, without size indication."""
    return data[0] >> 5 in (1, 2) and data[0] & 0x03 == 0x02


def _expedited(data: bytes) -> bytes:
    unused = data[0] >> 2 & 0x03 if data[0] & 0x01 else 0
    return data[4 : 8 - unused]
