"""Random bytes for everything that reads slcan: `python -m tests.fuzz.slcan --seconds 60 --seed 0`.

A stream is made of frames, commands, answers, noise, and damaged copies of all of them, and cut at random.
What must hold, whatever it is: nothing raises; the cuts make no difference; every frame that stands whole
between two CRs arrives, and nothing else does; the buffers stay small; adapter and bus still work afterwards.
"""

from __future__ import annotations

import argparse
import random
import re
import time
from dataclasses import dataclass

import can

from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.link.canopen.slcan import SlcanBus
from benchtool.protocol.slcan import MAX_LINE, AdapterLines, SlcanFrame, format_frame

_COMMANDS = (b"O", b"L", b"C", b"S6", b"S0", b"s031C", b"F", b"V", b"N", b"Z1", b"Z0", b"M0", b"m00000000")
_ANSWERS = (b"", b"\a", b"z", b"Z", b"V1013", b"NA123", b"F00")
_STANDARD = re.compile(r"([tr])([0-7][0-9A-Fa-f]{2})([0-8])([0-9A-Fa-f]*)")
_EXTENDED = re.compile(r"([TR])([01][0-9A-Fa-f]{7})([0-8])([0-9A-Fa-f]*)")
_LETTERS = b"tTrRdDbBzZVNFOCLSsMm0123456789abcdefABCDEF\a\n "


@dataclass
class Outcome:
    """What was tried."""

    streams: int = 0
    bytes: int = 0
    frames: int = 0
    malformed: int = 0


class ListedPort:
    """A port that holds the pieces it was given, and keeps nothing that is written to it."""

    def __init__(self) -> None:
        self.pieces: list[bytes] = []

    def read(self) -> bytes:
        return self.pieces.pop(0) if self.pieces else b""

    def write(self, data: bytes) -> None:
        pass

    def close(self) -> None:
        pass


def frame(chance: random.Random) -> SlcanFrame:
    """Any frame."""
    extended, remote = chance.random() < 0.3, chance.random() < 0.1
    data = chance.randbytes(chance.randint(0, 8))
    return SlcanFrame(
        chance.randrange(0x20000000 if extended else 0x800),
        b"" if remote else data,
        len(data),
        extended,
        remote,
        chance.randrange(60_000) if chance.random() < 0.3 else None,
    )


def damaged(chance: random.Random, line: bytes) -> bytes:
    """A copy with a flipped bit, a byte too few or too many, or its end missing."""
    if not line:
        return line
    place = chance.randrange(len(line))
    match chance.randrange(4):
        case 0:
            return line[:place] + bytes([line[place] ^ 1 << chance.randrange(8)]) + line[place + 1 :]
        case 1:
            return line[:place] + line[place + 1 :]
        case 2:
            return line[:place] + bytes([chance.randrange(256)]) + line[place:]
    return line[:place]


def stream(chance: random.Random) -> bytes:
    """A stream, which ends with CR."""
    parts = []
    for _ in range(chance.randint(1, 40)):
        kind = chance.random()
        if kind < 0.5:
            part = format_frame(frame(chance))
        elif kind < 0.65:
            part = chance.choice(_COMMANDS + _ANSWERS) + b"\r"
        elif kind < 0.75:
            part = chance.randbytes(chance.choice((1, 5, 30, 400)))
        elif kind < 0.85:
            part = bytes(chance.choices(_LETTERS, k=chance.choice((1, 5, 30, MAX_LINE, MAX_LINE + 1))))
        else:
            part = damaged(chance, format_frame(frame(chance)))
        parts.append(part)
    return b"".join(parts) + b"\r"


def cut(chance: random.Random, data: bytes) -> list[bytes]:
    """The stream in pieces."""
    pieces, start = [], 0
    while start < len(data):
        end = start + chance.choice((1, 2, 7, 64, 1000))
        pieces.append(data[start:end])
        start = end
    return pieces


def expected(data: bytes) -> list[SlcanFrame]:
    """The frames of a stream, found one line at a time and by other means than the parser's."""
    lines = data.replace(b"\n", b"").replace(b"\a", b"\a\r").split(b"\r")
    found = (_by_pattern(line) for line in lines if len(line) <= MAX_LINE)
    return [each for each in found if each is not None]


def _by_pattern(line: bytes) -> SlcanFrame | None:
    text = line.decode("latin-1")
    match = _STANDARD.fullmatch(text) or _EXTENDED.fullmatch(text)
    if match is None:
        return None
    letter, can_id, code, digits = match.groups()
    remote, dlc = letter in "rR", int(code)
    size = 0 if remote else 2 * dlc
    payload, stamp = digits[:size], digits[size:]
    if len(payload) != size or len(stamp) not in (0, 4) or (stamp and int(stamp, 16) >= 60_000):
        return None
    time_ms = int(stamp, 16) if stamp else None
    return SlcanFrame(int(can_id, 16), bytes.fromhex(payload), dlc, letter.isupper(), remote, time_ms)


def check_lines(chance: random.Random, data: bytes) -> int:
    """Cut and whole, the same frames and counts; how many lines were malformed."""
    whole, pieces = AdapterLines(), AdapterLines()
    frames, answers = whole.feed(data)
    assert frames == expected(data), data
    found = [pieces.feed(piece) for piece in cut(chance, data)]
    assert [each for got, _ in found for each in got] == frames, data
    assert [each for _, got in found for each in got] == answers, data
    assert pieces.malformed == whole.malformed, data
    return sum(whole.malformed.values())


def check_bus(chance: random.Random, data: bytes) -> None:
    """The host's bus receives what is expected, and a frame after it."""
    port = ListedPort()
    bus = SlcanBus(port, acknowledged=False)
    port.pieces = [*cut(chance, data), b"t1230\r"]
    received = []
    while port.pieces or bus._waiting:
        got = bus.recv(0.0)
        if got is not None:
            received.append((got.arbitration_id, bytes(got.data), got.dlc))
    wanted = [(each.can_id, each.data, each.dlc) for each in expected(data)]
    assert received == [*wanted, (0x123, b"", 0)], data
    bus.shutdown()


def check_adapter(chance: random.Random, data: bytes) -> None:
    """The adapter obeys the next host, whatever the one before has typed."""
    port = ListedPort()
    adapter = SlcanAdapter(port, bitrate=500_000, waiting=16)
    port.pieces = cut(chance, data)
    while port.pieces or adapter._received:
        adapter.recv(0.0)
        adapter.send(can.Message(arbitration_id=0x181, data=b"\x01", is_extended_id=False, timestamp=1.0))
    assert len(adapter._outgoing) <= 16 + 64
    port.pieces = [b"\rC\rO\rt1230\r"]
    got = adapter.recv(0.0)
    assert got is not None, data
    assert got.arbitration_id == 0x123, data
    adapter.shutdown()


def fuzz(seed: int, *, streams: int | None = None, seconds: float = 0.0) -> Outcome:
    """Try so many streams, or for so long.

    Raises:
        AssertionError: something did not hold; the message is the stream.
    """
    chance, outcome = random.Random(seed), Outcome()
    end_s = time.monotonic() + seconds
    while outcome.streams < streams if streams is not None else time.monotonic() < end_s:
        data = stream(chance)
        outcome.malformed += check_lines(chance, data)
        check_bus(chance, data)
        check_adapter(chance, data)
        outcome.streams += 1
        outcome.bytes += len(data)
        outcome.frames += len(expected(data))
    return outcome


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(fuzz(arguments.seed, seconds=arguments.seconds))  # noqa: T201


if __name__ == "__main__":
    main()
