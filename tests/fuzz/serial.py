"""Feed a serial receiver with damaged lines for a given time.

python -m tests.fuzz.serial --seconds 60 --seed 0 [--json]

A round makes messages of both sides and a stream of batches, drops, repeats and reorders some, damages the
line (bits, bytes, lengths, noise), cuts it anywhere, and looks at what comes out. A round fails if anything
raises, if a payload comes out that was not sent, if the way of cutting matters, if the frame behind damage is
lost, or if a row of the stream is not the one of its tick. Damage has its 2**-32 chance to pass the CRC: a
single failure in some 10**9 damaged frames is none. The same seed makes the same rounds.
"""

from __future__ import annotations

import argparse
import json
import random
import struct
import sys
import time
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from benchtool.block import Block
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Variable
from benchtool.protocol.serial import (
    Batch,
    BatchDecoder,
    FrameSplitter,
    Identity,
    Reject,
    Setpoint,
    Stream,
    decode_reply,
    decode_request,
    encode_frame,
    encode_message,
)

_CHANNELS = (
    Variable(0x2030, 2, "i_a", DataType.F32, "A"),
    Variable(0x2030, 3, "row", DataType.U32),
)
_SCHEMA, _STRIDE = 3, 5
_PROBE = b"\x02the frame behind the damage"
_LIMIT = 300

# Length of the fixed part by type, so that many random payloads are whole messages.
_HEADS = {
    0x01: 3,
    0x02: 5,
    0x03: 6,
    0x04: 5,
    0x05: 9,
    0x06: 7,
    0x10: 13,
    0x11: 3,
    0x12: 2,
    0x41: 6,
    0x42: 14,
    0x43: 14,
    0x81: 39,
    0x82: 9,
    0x83: 9,
    0x84: 20,
    0x85: 11,
    0x86: 16,
    0xFF: 4,
    0x07: 2,
    0x44: 4,
}


def fuzz(seed: int, *, rounds: int | None = None, seconds: float | None = None) -> Counter[str]:
    """Run rounds until their number or the time is over; what they met, by kind.

    Raises:
        AssertionError: a round failed; its message names the seed and the round.
    """
    met: Counter[str] = Counter()
    end_s = None if seconds is None else time.monotonic() + seconds
    while (rounds is None or met["rounds"] < rounds) and (end_s is None or time.monotonic() < end_s):
        source = random.Random(f"{seed}/{met['rounds']}")
        try:
            _round(source, met)
        except Exception as failure:
            raise AssertionError(f"seed {seed}, round {met['rounds']}: {failure!r}") from failure
        met["rounds"] += 1
    return met


def _round(source: random.Random, met: Counter[str]) -> None:
    start = source.choice((0, 1000, 2**32 - 40))
    batches = _batches(source, start)
    payloads = [encode_message(each) for each in batches]
    for _ in range(source.randrange(8)):
        payloads.insert(source.randrange(len(payloads) + 1), _payload(source))
    line = b"".join(_damaged(source, encode_frame(each), met) for each in payloads) + b"\0"
    line += encode_frame(_PROBE)

    received = _received(line, source, met)
    _require(received[-1] == _PROBE, "the frame behind the damage was lost")
    sent = iter(payloads)
    for payload in received[:-1]:
        while (each := next(sent, None)) is not None and each != payload:
            met["frames_lost"] += 1
        _require(each is not None, f"{payload.hex()} was not sent, or not then")
        _understand(payload, met)
    for _ in range(4):
        _understand(source.randbytes(source.randrange(40)), met)
    _follow(received, start, met)


def _received(line: bytes, source: random.Random, met: Counter[str]) -> list[bytes]:
    whole, cut = FrameSplitter(_LIMIT), FrameSplitter(_LIMIT)
    expected = whole.feed(line)
    received, place = [], 0
    while place < len(line):
        length = source.choice((1, 2, 7, 64, 500))
        received += cut.feed(line[place : place + length])
        place += length
    counts = [
        (each.frames, each.too_long, each.bad_stuffing, each.too_short, each.bad_crc) for each in (whole, cut)
    ]
    _require(received == expected and counts[0] == counts[1], "how the line was cut made a difference")
    for cause in ("frames", "too_long", "bad_stuffing", "too_short", "bad_crc"):
        met[cause] += getattr(whole, cause)
    return received


def _understand(payload: bytes, met: Counter[str]) -> None:
    """Decode from both sides; what is understood must be what was said."""
    request, reply = decode_request(payload), decode_reply(payload)
    _require(request is None or reply is None, f"{payload.hex()} is of both sides")
    message = reply if request is None else request
    if isinstance(request, Reject):
        met["rejected"] += 1
        return
    if message is None:
        met["not_understood"] += 1
        return
    met["understood"] += 1
    # A NaN may change its bits in Python, a name that is no UTF-8 its bytes.
    if not isinstance(message, Setpoint | Stream | Identity):
        _require(encode_message(message) == payload, f"{payload.hex()} is not {message}")


def _follow(received: Sequence[bytes], start: int, met: Counter[str]) -> None:
    """Put the batches together; each row must carry the number that its tick tells."""
    decoder = BatchDecoder(_CHANNELS, _STRIDE, 1e-4, 0, (), _SCHEMA)
    blocks: list[Block] = []
    for payload in received:
        message = decode_reply(payload)
        if isinstance(message, Batch):
            decoder.feed(message, 0.0)
            if decoder.rows > 20 and (block := decoder.pop_block()) is not None:
                blocks.append(block)
    if (block := decoder.pop_block()) is not None:
        blocks.append(block)
    ticks = [int(tick) % 2**32 for block in blocks for tick in block.ticks()]
    numbers = [int(number) for block in blocks for number in block.column("row")]
    right = [(start + _STRIDE * number) % 2**32 for number in numbers]
    _require(ticks == right, "a row is not of its tick")
    _require(all(a < b for a, b in pairwise(numbers)), "a row came again")
    counters = decoder.counters
    span = numbers[-1] - numbers[0] + 1 if numbers else 0
    _require(counters.received + counters.missing == span, f"{counters} of {span} rows")
    met["rows"] += counters.received
    met["rows_missing"] += counters.missing
    met["rows_refused"] += counters.off_grid


def _batches(source: random.Random, start: int) -> list[Batch]:
    """Batches of one stream, some of them lost, again, or late; each row carries its number."""
    batches, row = [], 0
    for sequence in range(source.randrange(1, 20)):
        n = source.choice((1, 2, 9))
        data = b"".join(struct.pack("<fI", source.random(), each) for each in range(row, row + n))
        tick = (start + row * _STRIDE) % 2**32
        batches.append(Batch(_SCHEMA, (sequence + 2**32 - 4) % 2**32, tick, _STRIDE, n, data))
        row += n + source.choice((0, 0, 0, 3))
    sent = [each for each in batches if source.random() > 0.1]
    for _ in range(source.choice((0, 0, 1, 3))):
        sent.insert(source.randrange(len(sent) + 1), source.choice(batches))
    if source.random() < 0.2:
        sent.reverse()
    return sent


def _payload(source: random.Random) -> bytes:
    """A payload of some type, often of the right length; never one of a batch of the stream."""
    kind = source.choice(list(_HEADS))
    length = _HEADS[kind] + source.choice((0, 0, 0, -1, 1, 4, 40))
    body = bytearray(source.randbytes(length - 1))
    if source.random() < 0.5:
        body = bytearray(len(body))
    if kind == 0x42 and len(body) > 1:
        body[:2] = struct.pack("<H", _SCHEMA + 1)
    return bytes([kind]) + bytes(body)


def _damaged(source: random.Random, frame: bytes, met: Counter[str]) -> bytes:
    """A frame as a bad line brings it, most often untouched; never two whole frames of one."""
    damage = source.choice(("", "", "", "", "bits", "cut", "noise", "swap", "insert", "join", "endless"))
    met[f"damage_{damage or 'none'}"] += 1
    changed = bytearray(frame)
    place = source.randrange(len(frame))
    match damage:
        case "bits":
            for _ in range(source.choice((1, 1, 2, 3, 9))):
                changed[source.randrange(len(frame))] ^= 1 << source.randrange(8)
        case "cut":
            del changed[place : place + source.choice((1, 2, 30))]
        case "noise":
            changed[:0] = source.randbytes(source.randrange(50))
        case "swap":
            changed[1:-1] = changed[-2:0:-1]
        case "insert":
            changed[place:place] = source.randbytes(source.choice((1, 1, 5)))
        case "join":
            changed = changed[1:-1]
        case "endless":
            changed = changed[:-1] + source.randbytes(2 * _LIMIT).replace(b"\0", b"\1")
        case _:
            pass
    return bytes(changed)


def _require(condition: bool, complaint: str) -> None:
    if not condition:
        raise AssertionError(complaint)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and report; the process's exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz.serial", description="Feed a serial receiver with damaged lines."
    )
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args(arguments)
    try:
        met = fuzz(options.seed, seconds=options.seconds)
    except AssertionError as failure:
        sys.stderr.write(f"{failure}\n")
        return 1
    if options.json:
        sys.stdout.write(json.dumps({"seed": options.seed, **dict(sorted(met.items()))}, indent=2) + "\n")
    else:
        sys.stdout.write("".join(f"{name:20s} {count}\n" for name, count in sorted(met.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
