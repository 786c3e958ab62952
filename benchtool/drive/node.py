"""A node at the other end of a link, its objects by the names and units of its dictionary."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict

from benchtool.clock import Clock
from benchtool.drive.identity import Identity
from benchtool.errors import SdoAbort, ValueRefused, WriteNotVerified
from benchtool.link import Link
from benchtool.link.ticks import TickMark, WallMark
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.variable import Value, Variable
from benchtool.ticks import counted_on


class RemoteNode:
    """Objects of one node, read and written one at a time.

    Args:
        link: open link to the node.
        dictionary: what its EDS says.
        source: name of that EDS, for messages.
        clock: the clock that waiting goes by.
    """

    def __init__(self, link: Link, dictionary: Dictionary, source: str, clock: Clock) -> None:
        self.link = link
        self.dictionary = dictionary
        self.clock = clock
        self._source = source
        self._mark: TickMark | None = None

    def check(self) -> Identity:
        """Who answers, which is the drive of the dictionary; notes its tick. Only reads are sent.

        Raises:
            NoAnswer, IdentityMismatch, DictionaryMismatch: as their names say.
        """
        identity = self.identify()
        identity.require(self.dictionary, self._source)
        self._note_tick()
        return identity

    def _note_tick(self) -> None:
        if all(name in self.dictionary for name in ("tick", "control_period")):
            tick_s = round(self.number("control_period") * 1e9) * 1e-9  # the drive has it as a float32
            tick = counted_on(int(self.number("tick")), self.tick_now())
            self._mark = TickMark(tick, self.clock.now_s(), tick_s)

    def wall_mark(self, wall_s: float) -> dict[str, int | float] | None:
        """The drive's tick now, which is `wall_s` of wall time, as a manifest keeps it: the fields of a
        `WallMark`; None as `tick_at`."""
        tick = self.tick_now()
        if tick is None or self._mark is None:
            return None
        return asdict(WallMark(tick, self._mark.tick_s, wall_s))

    def tick_now(self) -> int | None:
        """Tick of the drive now, as `tick_at`."""
        return self.tick_at(self.clock.now_s())

    def tick_at(self, at_s: float) -> int | None:
        """Tick of the drive at a moment of this node's clock, by the last one that was read.

        Both clocks are taken as equal: 50 ppm between them make 3 ms a minute. None before `check`, and of a
        drive that does not tell its tick.
        """
        return None if self._mark is None else self._mark.tick_at(at_s)

    def identify(self) -> Identity:
        """Who answers, by the objects that CiA 301 has for it, whether the EDS lists them or not.

        Raises:
            NoAnswer: nobody does.
        """
        return Identity(
            vendor_id=self._told_number(1),
            product_code=self._told_number(2),
            revision_number=self._told_number(3),
            serial_number=self._told_number(4),
            device_name=self._told_text(0x1008),
            hardware_version=self._told_text(0x1009),
            firmware_version=self._told_text(0x100A),
            dictionary_hash=self._optional_int("dictionary_hash"),
        )

    def read(self, name: str) -> Value:
        """Physical value of `name`, in the unit of the dictionary; the name of an enumeration's value.

        Raises:
            ValueRefused: no such name.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        variable = self.dictionary[name]
        with self._naming(f"reading '{name}'"):
            return variable.decode(self._upload(variable))

    def number(self, name: str) -> float:
        """Raw or physical number of `name`, an enumeration's value as its number."""
        variable = self.dictionary[name]
        value = variable.decode(self._upload(variable))
        if isinstance(value, str) and variable.values:
            return variable.values[value]
        if not isinstance(value, int | float):
            raise ValueRefused(f"'{name}' is {value!r}, a number is expected: choose a numeric object")
        return value

    def write(self, name: str, value: Value) -> None:
        """Check `value` against the dictionary, send it once, and read it back.

        Raises:
            ValueRefused: outside its limits; nothing was sent.
            SdoAbort: the drive refused.
            WriteNotVerified: the drive holds another value than was sent.
        """
        variable = self.dictionary[name]
        sent = variable.encode(value)
        with self._naming(f"writing {value!r} to '{name}'"):
            self.link.download(variable.index, variable.sub, sent)
            kept = self._upload(variable)
        if kept != sent:
            raise WriteNotVerified(
                f"'{name}' reads back {variable.decode(kept)!r} after {value!r} was written: "
                f"check whether another master writes it too"
            )

    def _upload(self, variable: Variable) -> bytes:
        return self.link.upload(variable.index, variable.sub, length=variable.type.bits // 8 or None)

    def _told_number(self, sub: int) -> int | None:
        """An entry of 0x1018."""
        data = self._told(0x1018, sub)
        return int.from_bytes(data, "little") if data else None

    def _told_text(self, index: int) -> str | None:
        data = self._told(index, 0)
        return None if data is None else data.rstrip(b"\0").decode(errors="replace")

    def _told(self, index: int, sub: int) -> bytes | None:
        """Bytes of an object; None if the drive refuses it, with whatever reason."""
        try:
            return self.link.upload(index, sub)
        except SdoAbort:
            return None

    def _optional_int(self, name: str) -> int | None:
        value = self._optional(name)
        return value if isinstance(value, int) else None

    def _optional(self, name: str) -> Value | None:
        if name not in self.dictionary:
            return None
        try:
            return self.read(name)
        except SdoAbort as abort:
            if abort.code in (Abort.NO_OBJECT, Abort.NO_SUB_INDEX):
                return None
            raise

    @contextmanager
    def _naming(self, doing: str) -> Iterator[None]:
        try:
            yield
        except SdoAbort as abort:
            raise SdoAbort(f"{doing}: {abort}", abort.code) from abort
