"""Long objects over a serial line: the bytes as they were when the host began, in chunks that it asks for."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

from benchtool.protocol.canopen import Abort
from benchtool.protocol.serial import ChunkReply, Chunks, Open, OpenReply

CHUNK_BYTES = 1024


class Upload:
    """The upload of one serial server: there is one at a time, and the next takes its place."""

    def __init__(self) -> None:
        self._number = 0
        self._data: bytes | None = None

    def open(self, request: Open, data: bytes) -> OpenReply:
        """Keep `data` for the chunks to come."""
        self._number = (self._number + 1) & 0xFF
        self._data = data
        return OpenReply(
            *(request.tag, 0, request.index, request.sub),
            upload=self._number,
            size=len(data),
            chunk_size=CHUNK_BYTES,
            crc=zlib.crc32(data),
        )

    def reset(self) -> None:
        """Discard the data; chunks are refused until the next `open`."""
        self._data = None

    def chunks(self, request: Chunks) -> Iterator[ChunkReply]:
        """Return the answers to a request: its chunks, or one with the reason why there are none."""
        data = self._data
        if data is None or request.upload != self._number:
            return iter([_refusal(request, Abort.DEVICE_STATE)])
        if not 1 <= request.count <= -(-len(data) // CHUNK_BYTES) - request.first:
            return iter([_refusal(request, Abort.VALUE_HIGH if request.count else Abort.VALUE_LOW)])
        return (
            ChunkReply(
                request.tag, 0, request.upload, chunk, data[chunk * CHUNK_BYTES : (chunk + 1) * CHUNK_BYTES]
            )
            for chunk in range(request.first, request.first + request.count)
        )


def _refusal(request: Chunks, reason: Abort) -> ChunkReply:
    return ChunkReply(request.tag, reason, request.upload, request.first)
