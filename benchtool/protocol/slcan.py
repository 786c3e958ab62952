"""CAN frames as lines of text (slcan), as used by serial CAN adapters.

Sources are the manuals of LAWICEL's CAN232 and CANUSB, and the line discipline `slcan` of Linux.
A line ends with CR. Digits are hexadecimal, of either case; `L` is the length code, 0 to 8:

    tIIILDD..  data, 11-bit identifier       TIIIIIIIILDD..  data, 29-bit identifier
    rIIIL      remote request, 11 bit        RIIIIIIIIL      remote request, 29 bit

An adapter with time stamps switched on appends four digits: milliseconds modulo 60000. Everything else is a
command of the host or an answer of the adapter. A line that is neither is dropped and counted by its cause;
received data never raise.
"""

from __future__ import annotations

import re
from binascii import unhexlify
from enum import StrEnum
from typing import NamedTuple

BITRATES_BIT_S = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""Bit rates of the commands S0 to S8."""

OK = b"\r"
REFUSED = b"\a"

TIME_MODULUS_ms = 60_000
MAX_LINE = 160
"""Bytes of a line; the longest valid line is a CAN FD frame of 64 bytes with time stamp: 142."""

_MAX_ID = 0x7FF
_MAX_EXTENDED_ID = 0x1FFFFFFF
_MAX_DLC = 8
_STAMP = 2  # bytes of a time stamp, two digits each


class Cause(StrEnum):
    """Why a line was dropped."""

    LETTER = "letter"  # unknown first letter
    DIGIT = "digit"  # not a hexadecimal digit
    LENGTH = "length"  # too few or too many digits
    DLC = "dlc"  # length code above 8
    IDENTIFIER = "identifier"  # above 7FF, or 1FFFFFFF
    TIME_STAMP = "time_stamp"  # not below 60000 ms
    TOO_LONG = "too_long"  # no end of line within MAX_LINE bytes
    UNSUPPORTED = "unsupported"  # a CAN FD frame


class SlcanFrame(NamedTuple):
    """A frame; `data` of a remote request is empty whatever `dlc` it has. `time_ms` is below 60000."""

    can_id: int
    data: bytes
    dlc: int
    extended: bool = False
    remote: bool = False
    time_ms: int | None = None


class Answer(NamedTuple):
    """Response of an adapter to a command; `text` is the text after the letter of a query's response."""

    kind: str  # "ok", "refused", "sent", "version", "serial_number" or "flags"
    text: str = ""


class SlcanCommand(NamedTuple):
    """A command of the host that is not a frame, such as `S6`."""

    letter: str
    argument: str = ""


_KINDS = {b"t": (False, False), b"T": (True, False), b"r": (False, True), b"R": (True, True)}
_FD = frozenset([b"d", b"D", b"b", b"B"])
_NO_DIGIT = re.compile(rb"[^0-9A-Fa-f]")
_QUERIES = {b"V": "version", b"N": "serial_number", b"F": "flags"}
_ANSWER = re.compile(rb"[VN][\x20-\x7E]{1,64}|F[0-9A-Fa-f]{2}")
_COMMAND = re.compile(
    rb"[OLCFVN]|S[0-8]|s[0-9A-Fa-f]{4}|Z[01]|[Mm][0-9A-Fa-f]{8}"  # BTR0 and BTR1; acceptance code and mask
)


def parse_frame(line: bytes) -> SlcanFrame | Cause:
    """Return the frame on a line without its CR, or the cause of a fault. Never raises."""
    kind = _KINDS.get(line[:1])
    if kind is None:
        return Cause.UNSUPPORTED if line[:1] in _FD else Cause.LETTER
    extended, remote = kind
    # Identifier and length code are 4 digits or 9: with a zero before the 9, whole bytes in both forms.
    try:
        raw = unhexlify(b"0" + line[1:] if extended else line[1:])
    except ValueError:
        return Cause.DIGIT if _NO_DIGIT.search(line, 1) else Cause.LENGTH
    head = 5 if extended else 2
    if len(raw) < head:
        return Cause.LENGTH
    code = int.from_bytes(raw[:head], "big")
    can_id, dlc = code >> 4, code & 0xF
    if dlc > _MAX_DLC:
        return Cause.DLC
    if can_id > (_MAX_EXTENDED_ID if extended else _MAX_ID):
        return Cause.IDENTIFIER
    end = head if remote else head + dlc
    if len(raw) == end:
        return SlcanFrame(can_id, raw[head:end], dlc, extended, remote)
    if len(raw) != end + _STAMP:
        return Cause.LENGTH
    time_ms = int.from_bytes(raw[end:], "big")
    if time_ms >= TIME_MODULUS_ms:
        return Cause.TIME_STAMP
    return SlcanFrame(can_id, raw[head:end], dlc, extended, remote, time_ms)


def format_frame(frame: SlcanFrame) -> bytes:
    """Return the line of a frame, with CR, and with a time stamp if the frame has a time.

    Raises:
        ValueError: identifier, length or time is out of range.
    """
    most = _MAX_EXTENDED_ID if frame.extended else _MAX_ID
    if not 0 <= frame.can_id <= most:
        raise ValueError(f"identifier 0x{frame.can_id:X} is beyond 0x{most:X}: choose one that fits")
    if not 0 <= frame.dlc <= _MAX_DLC or len(frame.data) != (0 if frame.remote else frame.dlc):
        raise ValueError(
            f"{len(frame.data)} bytes with length code {frame.dlc} cannot be: "
            f"send 0 to 8, as many as the code says, and none with a remote request"
        )
    stamp = ""
    if frame.time_ms is not None:
        if not 0 <= frame.time_ms < TIME_MODULUS_ms:
            raise ValueError(f"a time of {frame.time_ms} ms cannot be: take it modulo {TIME_MODULUS_ms} ms")
        stamp = f"{frame.time_ms:04X}"
    letter = "r" if frame.remote else "t"
    head = f"{letter.upper()}{frame.can_id:08X}" if frame.extended else f"{letter}{frame.can_id:03X}"
    return f"{head}{frame.dlc}{frame.data.hex().upper()}{stamp}\r".encode()


def parse_answer(line: bytes) -> Answer | Cause:
    """Return the response on an adapter's line without its CR; BELL is a response of its own."""
    if line == b"":
        return Answer("ok")
    if line == REFUSED:
        return Answer("refused")
    if line in (b"z", b"Z"):
        return Answer("sent")
    if _ANSWER.fullmatch(line):
        return Answer(_QUERIES[line[:1]], line[1:].decode("ascii"))
    return Cause.LETTER if line[:1] not in _QUERIES else Cause.LENGTH


def parse_command(line: bytes) -> SlcanCommand | SlcanFrame | Cause:
    """Return the command or frame on a host's line without its CR; a host's frame has no time stamp."""
    if _COMMAND.fullmatch(line):
        text = line.decode("ascii")
        return SlcanCommand(text[0], text[1:])
    found = parse_frame(line)
    return Cause.LENGTH if isinstance(found, SlcanFrame) and found.time_ms is not None else found


class Lines:
    """Splits received data into lines, however they were divided."""

    def __init__(self) -> None:
        self.too_long = 0
        self._tail = b""
        self._skipping = False

    def split(self, data: bytes) -> list[bytes]:
        """Return the lines that end in `data`, without their CR."""
        *lines, self._tail = (self._tail + data).split(b"\r")
        if lines and self._skipping:
            del lines[0]
            self._skipping = False
        if lines and max(map(len, lines)) > MAX_LINE:
            short = [line for line in lines if len(line) <= MAX_LINE]
            self.too_long += len(lines) - len(short)
            lines = short
        if len(self._tail) > MAX_LINE:
            self.too_long += not self._skipping
            self._tail, self._skipping = b"", True
        return lines

    def clear(self) -> None:
        """Discard the incomplete line."""
        self._tail, self._skipping = b"", False


class AdapterLines:
    """Parser of an adapter's lines: frames, responses, and counts of invalid lines by cause."""

    def __init__(self) -> None:
        self._lines = Lines()
        self._dropped: dict[Cause, int] = {}

    @property
    def malformed(self) -> dict[Cause, int]:
        """Lines dropped so far, by cause."""
        counts = self._dropped.copy()
        if self._lines.too_long:
            counts[Cause.TOO_LONG] = self._lines.too_long
        return counts

    def feed(self, data: bytes) -> tuple[list[SlcanFrame], list[Answer]]:
        """Return the frames and answers that are complete with `data`. Never raises."""
        frames: list[SlcanFrame] = []
        answers: list[Answer] = []
        # Some adapters add LF to CR. BELL has no CR; given one, it is a line or the end of a damaged line.
        for line in self._lines.split(data.replace(b"\n", b"").replace(REFUSED, b"\a\r")):
            found = parse_frame(line)
            if isinstance(found, SlcanFrame):
                frames.append(found)
                continue
            answer = parse_answer(line[-1:] if line.endswith(REFUSED) else line)
            if isinstance(answer, Answer):
                answers.append(answer)
            if not isinstance(answer, Answer) or (answer.kind == "refused" and line != REFUSED):
                cause = answer if isinstance(answer, Cause) and found is Cause.LETTER else found
                self._dropped[cause] = self._dropped.get(cause, 0) + 1
        return frames, answers
