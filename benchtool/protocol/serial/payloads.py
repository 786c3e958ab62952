"""Encoding and decoding of messages of the serial line as payloads.

Everything is little-endian. Decoding never raises: invalid bytes give None, or for a request the `Reject`
that answers it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from benchtool.errors import ValueRefused
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.serial.messages import (
    VERSION,
    Batch,
    ChunkReply,
    Chunks,
    Event,
    Heartbeat,
    HostHeartbeat,
    Identify,
    Identity,
    Message,
    MessageType,
    Nmt,
    Open,
    OpenReply,
    Read,
    ReadReply,
    Reject,
    RejectReason,
    Reply,
    Request,
    Setpoint,
    Stream,
    StreamFormat,
    StreamReply,
    Write,
    WriteReply,
)


@dataclass(frozen=True)
class _Layout:
    """Fields of fixed size behind the type, as `struct` names them, and whether `data` follows them."""

    message: Callable[..., Message]
    struct: struct.Struct
    names: tuple[str, ...]
    tail: bool

    def values(self, message: Message) -> list[int | float]:
        return [getattr(message, name) for name in self.names]


def _layout(message: type[Message], codes: str) -> _Layout:
    names = tuple(message.__dataclass_fields__)
    tail = names[-1] == "data"
    return _Layout(message, struct.Struct("<B" + codes), names[:-1] if tail else names, tail)


_LAYOUTS: Mapping[int, _Layout] = {
    MessageType.IDENTIFY: _layout(Identify, "BB"),
    MessageType.READ: _layout(Read, "BHB"),
    MessageType.WRITE: _layout(Write, "BHB"),
    MessageType.OPEN: _layout(Open, "BHB"),
    MessageType.CHUNKS: _layout(Chunks, "BBIH"),
    MessageType.SETPOINT: _layout(Setpoint, "Iff"),
    MessageType.HOST_HEARTBEAT: _layout(HostHeartbeat, "BB"),
    MessageType.NMT: _layout(Nmt, "B"),
    MessageType.HEARTBEAT: _layout(Heartbeat, "BI"),
    MessageType.BATCH: _layout(Batch, "HIIHB"),
    MessageType.READ_REPLY: _layout(ReadReply, "BIHB"),
    MessageType.WRITE_REPLY: _layout(WriteReply, "BIHB"),
    MessageType.OPEN_REPLY: _layout(OpenReply, "BIHBBIHI"),
    MessageType.CHUNK_REPLY: _layout(ChunkReply, "BIBI"),
    MessageType.STREAM_REPLY: _layout(StreamReply, "BIHII"),
    MessageType.REJECT: _layout(Reject, "BBB"),
}
_TYPES = {layout.message: kind for kind, layout in _LAYOUTS.items()}

_IDENTITY_HEAD = struct.Struct("<BBIBBBxI")  # the same in every version
_IDENTITY_REST = struct.Struct("<5IHHB")
_IDENTITY_NAMES = tuple(Identity.__dataclass_fields__)
_IDENTITY_HEAD_NAMES, _IDENTITY_REST_NAMES = _IDENTITY_NAMES[:6], _IDENTITY_NAMES[6:-1]
_STREAM_HEAD = struct.Struct("<BBHBBB")
_EVENT_HEAD = struct.Struct("<BBI")
_SCALES_PER_CHANNEL: Mapping[int, int] = {StreamFormat.WORDS: 0, StreamFormat.INT16: 1}
_WORD = 4
_LONGEST_NAME = 0xFF
_REQUESTS = range(0x01, 0x10)  # types that are answered


def encode_message(message: Message) -> bytes:
    """Return the payload of a message.

    Raises:
        ValueRefused: a field does not fit its place on the wire.
    """
    try:
        match message:
            case Identity():
                return _encode_identity(message)
            case Stream():
                return _encode_stream(message)
            case Event():
                head = _EVENT_HEAD.pack(MessageType.EVENT, message.sequence, message.tick)
                return head + message.emergency.encode()
            case _:
                kind = _TYPES[type(message)]
                layout = _LAYOUTS[kind]
                tail: bytes = getattr(message, "data", b"")
                payload = layout.struct.pack(kind, *layout.values(message)) + tail
    except (struct.error, OverflowError) as reason:
        raise ValueRefused(
            f"{type(message).__name__} cannot be sent, {reason}: give values that fit their fields"
        ) from None
    if not _sound(message):
        raise ValueRefused(
            f"{type(message).__name__} with {len(tail)} bytes of data, which its other fields do not allow: "
            f"give data that fit them"
        )
    return payload


def decode_request(payload: bytes) -> Request | Reject | None:
    """Return what a host says; the answer to a request that cannot be taken; None if it is to be dropped.

    Never raises.
    """
    if not payload:
        return None
    kind = payload[0]
    message: Message | None
    if kind == MessageType.STREAM:
        message = _decode_stream(payload)
    elif kind < MessageType.HEARTBEAT:
        message = _decode(payload)
    else:
        return None
    if message is None and kind in _REQUESTS:
        known = kind in _LAYOUTS or kind == MessageType.STREAM
        reason = RejectReason.WRONG_LENGTH if known else RejectReason.UNKNOWN_TYPE
        return Reject(payload[1] if len(payload) > 1 else 0, kind, reason)
    assert message is None or isinstance(message, Request)
    return message


def decode_reply(payload: bytes) -> Reply | None:
    """Return the message of a drive; None if it is to be dropped. Never raises."""
    if not payload or payload[0] < MessageType.HEARTBEAT:
        return None
    if payload[0] == MessageType.IDENTITY:
        return _decode_identity(payload)
    if payload[0] == MessageType.EVENT:
        return _decode_event(payload)
    message = _decode(payload)
    assert message is None or isinstance(message, Reply)
    return message


def _decode(payload: bytes) -> Message | None:
    layout = _LAYOUTS.get(payload[0])
    if layout is None or len(payload) < layout.struct.size:
        return None
    _, *values = layout.struct.unpack_from(payload)
    tail = payload[layout.struct.size :]
    if layout.tail:
        message = layout.message(*values, tail)
        return message if _sound(message) else None
    return None if tail else layout.message(*values)


def _sound(message: Message) -> bool:
    """Return whether the length of the data fits the other fields."""
    match message:
        case Write():
            return bool(message.data)
        case ReadReply():
            return not (message.status and message.data)
        case ChunkReply():
            return bool(message.data) == (message.status == 0)
        case Batch():
            return message.n > 0 and bool(message.data) and len(message.data) % message.n == 0
        case _:
            return True


def _encode_identity(message: Identity) -> bytes:
    name = message.device_name.encode()
    if len(name) > _LONGEST_NAME:
        raise ValueRefused(f"a device name of {len(name)} bytes, {_LONGEST_NAME} fit: shorten it")
    head = (getattr(message, each) for each in _IDENTITY_HEAD_NAMES)
    rest = (getattr(message, each) for each in _IDENTITY_REST_NAMES)
    return _IDENTITY_HEAD.pack(MessageType.IDENTITY, *head) + _IDENTITY_REST.pack(*rest, len(name)) + name


def _decode_identity(payload: bytes) -> Identity | None:
    if len(payload) < _IDENTITY_HEAD.size:
        return None
    _, *values = _IDENTITY_HEAD.unpack_from(payload)
    head = dict(zip(_IDENTITY_HEAD_NAMES, values, strict=True))
    if head["version"] != VERSION:
        return Identity(**head)
    start = _IDENTITY_HEAD.size + _IDENTITY_REST.size
    if len(payload) < start:
        return None
    *values, length = _IDENTITY_REST.unpack_from(payload, _IDENTITY_HEAD.size)
    name = payload[start:]
    if len(name) != length:
        return None
    rest = dict(zip(_IDENTITY_REST_NAMES, values, strict=True))
    return Identity(**head, **rest, device_name=name.decode(errors="replace"))


def _encode_stream(message: Stream) -> bytes:
    n = len(message.mappings)
    if message.format not in _SCALES_PER_CHANNEL:
        raise ValueRefused(f"format {message.format} of a stream, 0 or 1 is expected: choose one of them")
    scales = n * _SCALES_PER_CHANNEL[message.format]
    if len(message.scales) != scales:
        raise ValueRefused(
            f"{len(message.scales)} scales for {n} channels of format {message.format}, {scales} are "
            f"expected: give one for each channel of format 1, none of format 0"
        )
    head = _STREAM_HEAD.pack(
        MessageType.STREAM, message.tag, message.stride, message.batch, message.format, n
    )
    return head + struct.pack(f"<{n}I{scales}f", *message.mappings, *message.scales)


def _decode_stream(payload: bytes) -> Stream | None:
    if len(payload) < _STREAM_HEAD.size:
        return None
    _, tag, stride, batch, layout, n = _STREAM_HEAD.unpack_from(payload)
    if layout not in _SCALES_PER_CHANNEL:  # then the length of the message is unknown
        return None
    scales = n * _SCALES_PER_CHANNEL[layout]
    rest = payload[_STREAM_HEAD.size :]
    if len(rest) != _WORD * (n + scales):
        return None
    values = struct.unpack(f"<{n}I{scales}f", rest)
    return Stream(tag, stride, batch, layout, values[:n], values[n:])


def _decode_event(payload: bytes) -> Event | None:
    if len(payload) < _EVENT_HEAD.size:
        return None
    _, sequence, tick = _EVENT_HEAD.unpack_from(payload)
    emergency = Emergency.decode(payload[_EVENT_HEAD.size :])
    return None if emergency is None else Event(sequence, tick, emergency)
