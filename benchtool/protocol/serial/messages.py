"""Messages of the serial line, version 1; `firmware_protocol/serial.md` is their normative text."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from benchtool.protocol.canopen.emcy import Emergency

VERSION = 1
"""Version of the protocol that this package speaks."""


class MessageType(IntEnum):
    """First byte of a payload."""

    IDENTIFY = 0x01
    READ = 0x02
    WRITE = 0x03
    OPEN = 0x04
    CHUNKS = 0x05
    STREAM = 0x06
    SETPOINT = 0x10
    HOST_HEARTBEAT = 0x11
    NMT = 0x12
    HEARTBEAT = 0x41
    BATCH = 0x42
    EVENT = 0x43
    IDENTITY = 0x81
    READ_REPLY = 0x82
    WRITE_REPLY = 0x83
    OPEN_REPLY = 0x84
    CHUNK_REPLY = 0x85
    STREAM_REPLY = 0x86
    REJECT = 0xFF


class StreamFormat(IntEnum):
    """How a record holds its values."""

    WORDS = 0  # the object's four bytes
    INT16 = 1  # its value in steps of the channel's scale


class RejectReason(IntEnum):
    """Reason of a drive to reject a valid request."""

    UNKNOWN_TYPE = 1
    WRONG_LENGTH = 2
    BUSY = 3


@dataclass(frozen=True)
class Identify:
    """Request for the identity; `version` is that of the host."""

    tag: int
    version: int = VERSION


@dataclass(frozen=True)
class Identity:
    """Identity of the drive. For a drive of another version, the fields after `dictionary_hash` are zero."""

    tag: int
    status: int
    version: int
    node_id: int
    nmt_state: int
    dictionary_hash: int
    vendor_id: int = 0
    product_code: int = 0
    revision_number: int = 0
    serial_number: int = 0
    tick_period_ns: int = 0
    max_request: int = 0
    max_reply: int = 0
    device_name: str = ""


@dataclass(frozen=True)
class Read:
    """Read an object."""

    tag: int
    index: int
    sub: int


@dataclass(frozen=True)
class ReadReply:
    """`status` is 0 or an SDO abort code (CiA 301, table 22), with which there are no data."""

    tag: int
    status: int
    index: int
    sub: int
    data: bytes = b""


@dataclass(frozen=True)
class Write:
    """Write an object."""

    tag: int
    index: int
    sub: int
    data: bytes


@dataclass(frozen=True)
class WriteReply:
    """Result of a write; `status` as in `ReadReply`."""

    tag: int
    status: int
    index: int
    sub: int


@dataclass(frozen=True)
class Open:
    """Begin the upload of an object of any length."""

    tag: int
    index: int
    sub: int


@dataclass(frozen=True)
class OpenReply:
    """Number of the upload, bytes of the object, bytes of each chunk but the last, CRC-32 of the object."""

    tag: int
    status: int
    index: int
    sub: int
    upload: int = 0
    size: int = 0
    chunk_size: int = 0
    crc: int = 0


@dataclass(frozen=True)
class Chunks:
    """Send `count` chunks of an upload from chunk `first` on."""

    tag: int
    upload: int
    first: int
    count: int


@dataclass(frozen=True)
class ChunkReply:
    """One chunk, counted from 0."""

    tag: int
    status: int
    upload: int
    chunk: int
    data: bytes = b""


@dataclass(frozen=True)
class Stream:
    """Stream a record of these objects every `stride` ticks, `batch` records at a time; stride 0 stops.

    `mappings` are index << 16 | sub << 8 | bits, `scales` of format INT16 the object's unit per bit.
    """

    tag: int
    stride: int = 0
    batch: int = 1
    format: int = StreamFormat.WORDS
    mappings: tuple[int, ...] = ()
    scales: tuple[float, ...] = ()


@dataclass(frozen=True)
class StreamReply:
    """Number of the schema in force, and the records sent and dropped under the one that ends here."""

    tag: int
    status: int
    schema: int = 0
    sent: int = 0
    dropped: int = 0


@dataclass(frozen=True)
class Setpoint:
    """Commands to the drive."""

    sequence: int
    torque_command_Nm: float
    omega_m_command_rad_s: float


@dataclass(frozen=True)
class HostHeartbeat:
    """Heartbeat of the host."""

    node: int
    nmt_state: int


@dataclass(frozen=True)
class Nmt:
    """A command of network management (CiA 301, 7.2.8.2.1)."""

    command: int


@dataclass(frozen=True)
class Heartbeat:
    """Heartbeat of the drive."""

    nmt_state: int
    tick: int


@dataclass(frozen=True)
class Batch:
    """`n` records, row by row, of ticks first_tick + k * stride modulo 2**32."""

    schema: int
    sequence: int
    first_tick: int
    stride: int
    n: int
    data: bytes


@dataclass(frozen=True)
class Event:
    """An emergency message (CiA 301, 7.2.7) with its number and the tick it arose."""

    sequence: int
    tick: int
    emergency: Emergency


@dataclass(frozen=True)
class Reject:
    """The drive cannot take the request of this type and tag."""

    tag: int
    type: int
    reason: int


Request = Identify | Read | Write | Open | Chunks | Stream | Setpoint | HostHeartbeat | Nmt
Answer = Identity | ReadReply | WriteReply | OpenReply | ChunkReply | StreamReply | Reject
Reply = Answer | Heartbeat | Batch | Event
Message = Request | Reply
