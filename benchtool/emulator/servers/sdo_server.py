"""The SDO server of the emulated drive: expedited, segmented and block transfer (CiA 301, 7.2.4.3).

Expedited and segmented transfer are those of the canopen package. Its server refuses block download and
answers block upload with a segmented one, so that block transfer is added here; and it trusts every client
to keep to the protocol, so that here each request is first checked against the stage of the transfer.
"""

# The base class has no annotations.
# mypy: disallow-untyped-calls=False

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum, auto

import canopen
from canopen.sdo import server
from canopen.sdo.exceptions import SdoAbortedError

from benchtool.emulator.servers.sdo_block import BlockDownload, BlockUpload
from benchtool.protocol.canopen import (
    EXPEDITED,
    MAX_BLOCK_SIZE,
    SIZE_INDICATED,
    Abort,
    Block,
    Request,
    Response,
    sdo,
)


class _Stage(Enum):
    """What the server waits for."""

    IDLE = auto()
    SEGMENT_UPLOAD = auto()
    SEGMENT_DOWNLOAD = auto()
    BLOCK_UPLOAD_START = auto()
    BLOCK_UPLOAD_ACKNOWLEDGE = auto()
    BLOCK_UPLOAD_END = auto()
    BLOCK_DOWNLOAD_SEGMENT = auto()
    BLOCK_DOWNLOAD_END = auto()


class _Objects:
    """The dictionary as the package's server wants it: the pair of callables behind a node's methods."""

    def __init__(self, read: Callable[[int, int], bytes], write: Callable[[int, int, bytes], None]) -> None:
        self.object_dictionary = canopen.ObjectDictionary()
        self.read = read
        self.write = write
        self.announced: int | None = None

    def get_data(self, index: int, sub: int, check_readable: bool = False) -> bytes:
        return self.read(index, sub)

    def set_data(self, index: int, sub: int, data: bytes, check_writable: bool = False) -> None:
        announced, self.announced = self.announced, None
        if announced is not None and announced != len(data):
            raise SdoAbortedError(Abort.LENGTH)
        self.write(index, sub, bytes(data))


class SdoServer(server.SdoServer):
    """One SDO channel; a new request ends a transfer that was under way.

    Args:
        read: bytes of (index, sub); may raise canopen.SdoAbortedError.
        write: takes (index, sub, data), all of a transfer at once; may raise canopen.SdoAbortedError.
        send: takes the eight bytes of every answer.
        length: bytes of (index, sub), None if it has no length of its own: how many of the four bytes of an
            expedited download without size indication count.
        send_all: takes the frames of a sub-block of an upload; each goes to `send` by default.
    """

    _index: int
    _subindex: int

    def __init__(
        self,
        read: Callable[[int, int], bytes],
        write: Callable[[int, int, bytes], None],
        send: Callable[[bytes], None],
        length: Callable[[int, int], int | None] = lambda index, sub: None,
        send_all: Callable[[Sequence[bytes]], None] | None = None,
    ) -> None:
        self._length = length
        self._objects = _Objects(read, write)
        super().__init__(0, 0, self._objects)
        self._send = send
        self._send_all = send_all or self._send_each
        self._stage = _Stage.IDLE
        self._index = self._subindex = 0
        self._upload = BlockUpload(b"", MAX_BLOCK_SIZE, crc=False)
        self._download = BlockDownload(None, crc=False)
        self.malformed = 0

    def reset(self) -> None:
        """Discard a transfer that is under way, as after a reset of the drive, without an abort to the
        client."""
        self._stage = _Stage.IDLE

    def on_request(self, data: bytes) -> None:  # type: ignore[override]  # the caller has sorted out CAN ids
        """Take one frame from the client.

        A frame that is not eight bytes long is no SDO and is only counted in `malformed`; one that does not
        fit the stage of the transfer is counted and answered with abort 0x05040001.
        """
        if len(data) != sdo.FRAME_SIZE:
            self.malformed += 1
            return
        try:
            if data[0] == sdo.ABORT:
                self._stage = _Stage.IDLE
            elif self._stage is _Stage.BLOCK_DOWNLOAD_SEGMENT:
                self._take_segment(data)
            else:
                self._dispatch(data)
        except SdoAbortedError as aborted:
            self._stage = _Stage.IDLE
            self.abort(aborted.code)

    def send_response(self, response: bytes) -> None:
        """Send one frame, as the package's part of the server asks for."""
        self._send(bytes(response))

    def _dispatch(self, data: bytes) -> None:
        command = data[0]
        match command & sdo.SPECIFIER:
            case Request.DOWNLOAD_SEGMENT if self._stage is _Stage.SEGMENT_DOWNLOAD:
                self.segmented_download(command, data)
                if command & sdo.NO_MORE_SEGMENTS:
                    self._stage = _Stage.IDLE
            case Request.DOWNLOAD:
                self._begin_download(data)
            case Request.UPLOAD:
                self._begin_upload(data, self._read(data))
            case Request.UPLOAD_SEGMENT if self._stage is _Stage.SEGMENT_UPLOAD:
                self.segmented_upload(command)
                if not self._buffer:
                    self._stage = _Stage.IDLE
            case Request.BLOCK_UPLOAD:
                self._continue_block_upload(data)
            case Request.BLOCK_DOWNLOAD if not command & Block.END:
                self._begin_block_download(data)
            case Request.BLOCK_DOWNLOAD if self._stage is _Stage.BLOCK_DOWNLOAD_END:
                self._end_block_download(data)
            case _:
                self._refuse()

    def _refuse(self) -> None:
        self.malformed += 1
        raise SdoAbortedError(Abort.COMMAND_SPECIFIER)

    def _read(self, data: bytes) -> bytes:
        self._stage = _Stage.IDLE
        self._index, self._subindex = sdo.key(data)
        return self._objects.read(self._index, self._subindex)

    # ---- expedited and segmented -------------------------------------------------------------------------

    def _begin_upload(self, request: bytes, value: bytes) -> None:
        size = len(value)
        if 1 <= size <= 4:
            command = sdo.expedited(Response.UPLOAD, size)
            self._send(bytes([command]) + request[1:4] + value.ljust(4, b"\x00"))
            return
        self._buffer, self._toggle = bytearray(value), 0
        self._stage = _Stage.SEGMENT_UPLOAD
        self._send(sdo.INITIATE.pack(Response.UPLOAD | SIZE_INDICATED, self._index, self._subindex, size))

    def _begin_download(self, request: bytes) -> None:
        segmented = not request[0] & EXPEDITED
        announces = segmented and request[0] & SIZE_INDICATED
        self._objects.announced = int.from_bytes(request[4:], "little") if announces else None
        self._stage = _Stage.SEGMENT_DOWNLOAD if segmented else _Stage.IDLE
        if not segmented and not request[0] & SIZE_INDICATED:
            request = self._with_size(request)
        self.init_download(request)

    def _with_size(self, request: bytes) -> bytes:
        """Return an expedited download as it would be with the size of its object indicated (7.2.4.3.3,
        s)."""
        size = min(self._length(*sdo.key(request)) or 4, 4)
        return bytes([sdo.expedited(Request.DOWNLOAD, size)]) + request[1:]

    # ---- block upload ------------------------------------------------------------------------------------

    def _continue_block_upload(self, data: bytes) -> None:
        match data[0] & sdo.BLOCK_SUBCOMMAND, self._stage:
            case Block.INITIATE, _:
                self._begin_block_upload(data)
            case Block.START_UPLOAD, _Stage.BLOCK_UPLOAD_START:
                self._send_sub_block()
            case Block.ACKNOWLEDGE, _Stage.BLOCK_UPLOAD_ACKNOWLEDGE:
                end = self._upload.acknowledge(data[1], data[2])
                if end is None:
                    self._send_sub_block()
                else:
                    self._stage = _Stage.BLOCK_UPLOAD_END
                    self._send(end)
            case Block.END, _Stage.BLOCK_UPLOAD_END:
                self._stage = _Stage.IDLE
            case _:
                self._refuse()

    def _begin_block_upload(self, request: bytes) -> None:
        value, threshold = self._read(request), request[5]
        if threshold and len(value) <= threshold:
            # The client allows the change of protocol for so few bytes (7.2.4.3.13, pst).
            self._begin_upload(request, value)
            return
        self._upload = BlockUpload(value, request[4], bool(request[0] & sdo.BLOCK_CRC))
        self._stage = _Stage.BLOCK_UPLOAD_START
        command = Response.BLOCK_UPLOAD | sdo.BLOCK_CRC | sdo.BLOCK_SIZE_INDICATED
        self._send(sdo.INITIATE.pack(command, self._index, self._subindex, len(value)))

    def _send_sub_block(self) -> None:
        self._stage = _Stage.BLOCK_UPLOAD_ACKNOWLEDGE
        self._send_all(self._upload.sub_block())

    def _send_each(self, frames: Sequence[bytes]) -> None:
        for frame in frames:
            self._send(frame)

    # ---- block download ----------------------------------------------------------------------------------

    def _begin_block_download(self, request: bytes) -> None:
        command, self._index, self._subindex, size = sdo.INITIATE.unpack(request)
        announced = size if command & sdo.BLOCK_SIZE_INDICATED else None
        self._download = BlockDownload(announced, bool(command & sdo.BLOCK_CRC))
        self._stage = _Stage.BLOCK_DOWNLOAD_SEGMENT
        response = Response.BLOCK_DOWNLOAD | sdo.BLOCK_CRC
        self._send(sdo.INITIATE.pack(response, self._index, self._subindex, MAX_BLOCK_SIZE))

    def _take_segment(self, frame: bytes) -> None:
        acknowledgement = self._download.segment(frame)
        if self._download.complete:
            self._stage = _Stage.BLOCK_DOWNLOAD_END
        if acknowledgement is not None:
            self._send(acknowledgement)

    def _end_block_download(self, frame: bytes) -> None:
        self._stage = _Stage.IDLE
        self._objects.write(self._index, self._subindex, self._download.finish(frame))
        self._send(bytes([Response.BLOCK_DOWNLOAD | Block.END]).ljust(sdo.FRAME_SIZE, b"\x00"))
