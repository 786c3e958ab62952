"""A node at the other end of a link, its objects by the names and units of its dictionary."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict

from benchtool.clock import Clock
from benchtool.drive.capabilities import Capabilities, Capability
from benchtool.drive.identity import Identity
from benchtool.errors import NoAnswer, SdoAbort, StateError, ValueRefused, WriteNotVerified
from benchtool.link import ClockAnchor, Link, TickAnchor
from benchtool.protocol.canopen import Abort, NmtState
from benchtool.protocol.dictionary import Dictionary, Role, Value, Variable
from benchtool.ticks import unwrap_tick


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
        self._anchor: TickAnchor | None = None

    @property
    def capabilities(self) -> Capabilities:
        """What the drive can do, by its dictionary."""
        return Capabilities.of(self.dictionary)

    def check(self) -> Identity:
        """Check that the drive of the dictionary answers, and return its identity; notes its tick. Only reads
        are sent.

        Raises:
            NoAnswer: the drive does not answer. IdentityMismatch, DictionaryMismatch: it is another drive.
            StateError: it is in NMT state stopped, in which its objects cannot be read.
        """
        try:
            identity = self.identify()
        except (NoAnswer, SdoAbort) as failed:
            if not self.is_stopped:
                raise
            raise StateError(
                f"the drive is in NMT state stopped, in which it answers nothing ({failed}): a host could "
                f"not disable it, or another master stopped it; make sure that the motor stands still, then "
                f"start it with `benchtool reset`, or switch its supply off and on"
            ) from failed
        identity.require(self.dictionary, self._source)
        self._note_tick()
        return identity

    def require_dictionary(self) -> None:
        """Refuse a drive whose firmware has become another one since `check`.

        Raises:
            IdentityMismatch, DictionaryMismatch: it has.
        """
        expected = self.dictionary.hash
        if expected is not None and self.optional_number("dictionary_hash") != expected:
            self.check()

    @property
    def is_stopped(self) -> bool:
        """Whether its last heartbeat told of NMT state stopped."""
        return self.link.heartbeat_state() is NmtState.STOPPED

    def _note_tick(self) -> None:
        if Capability.TICK in self.capabilities:
            tick_s = round(self.number("control_period") * 1e9) * 1e-9  # the drive has it as a float32
            tick = unwrap_tick(int(self.number("tick")), self.tick_now())
            self._anchor = TickAnchor(tick, self.clock.now_s(), tick_s)

    def clock_anchor(self, wall_s: float) -> dict[str, int | float] | None:
        """Return the drive's tick now, which is `wall_s` of wall time, as a manifest keeps it: the fields of
        a `ClockAnchor`; None as `tick_at`."""
        tick = self.tick_now()
        if tick is None or self._anchor is None:
            return None
        return asdict(ClockAnchor(tick, self._anchor.tick_s, wall_s))

    def tick_now(self) -> int | None:
        """Return the tick of the drive now, as `tick_at`."""
        return self.tick_at(self.clock.now_s())

    def tick_at(self, at_s: float) -> int | None:
        """Return the tick of the drive at a moment of this node's clock, by the last one that was read.

        Both clocks are taken as equal: 50 ppm between them make 3 ms a minute. None before `check`, and for a
        drive without a tick.
        """
        return None if self._anchor is None else self._anchor.tick_at(at_s)

    def identify(self) -> Identity:
        """Return the identity by the objects of CiA 301, whether or not the EDS lists them.

        Raises:
            NoAnswer: the drive does not answer.
        """
        return Identity(
            vendor_id=self._optional_number(Role.VENDOR_ID),
            product_code=self._optional_number(Role.PRODUCT_CODE),
            revision_number=self._optional_number(Role.REVISION_NUMBER),
            serial_number=self._optional_number(Role.SERIAL_NUMBER),
            device_name=self._optional_text(Role.DEVICE_NAME),
            hardware_version=self._optional_text(Role.HARDWARE_VERSION),
            firmware_version=self._optional_text(Role.FIRMWARE_VERSION),
            dictionary_hash=self.optional_number("dictionary_hash"),
        )

    def read(self, name: Role | str | Variable) -> Value:
        """Return the physical value of an object, in the unit of the dictionary; the name of an enumeration's
        value.

        Raises:
            ValueRefused: no such object.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        variable, shown = self._variable(name)
        with self._naming(f"reading '{shown}'"):
            return variable.decode(self._upload(variable))

    def number(self, name: Role | str | Variable) -> float:
        """Return the raw or physical number of an object, an enumeration's value as its number."""
        variable, shown = self._variable(name)
        value = variable.decode(self._upload(variable))
        if isinstance(value, str) and variable.values:
            return variable.values[value]
        if not isinstance(value, int | float):
            raise ValueRefused(f"'{shown}' is {value!r}, a number is expected: choose a numeric object")
        return value

    def optional_number(self, name: Role | str | Variable) -> int | None:
        """Return the whole number of an optional object; None if the dictionary or the drive lacks it.

        Raises:
            NoAnswer, SdoAbort: the drive did not answer, or has it and refused.
        """
        if not isinstance(name, Variable) and name not in self.dictionary:
            return None
        try:
            return int(self.number(name))
        except SdoAbort as abort:
            if abort.code in (Abort.NO_OBJECT, Abort.NO_SUB_INDEX):
                return None
            raise

    def write(self, name: Role | str | Variable, value: Value) -> None:
        """Check `value` against the dictionary, send it once, and read it back.

        Raises:
            ValueRefused: outside its limits; nothing was sent.
            SdoAbort: the drive refused.
            WriteNotVerified: the drive holds another value than was sent.
        """
        variable, shown = self._variable(name)
        sent = variable.encode(value)
        with self._naming(f"writing {value!r} to '{shown}'"):
            self.link.download(variable.index, variable.sub, sent)
            kept = self._upload(variable)
        if kept != sent:
            raise WriteNotVerified(
                f"'{shown}' reads back {variable.decode(kept)!r} after {value!r} was written: "
                f"check whether another master writes it too"
            )

    def _variable(self, name: Role | str | Variable) -> tuple[Variable, str]:
        """Return the object, and what it is called in messages."""
        variable = name if isinstance(name, Variable) else self.dictionary[name]
        return variable, name if isinstance(name, str) else variable.name

    def _upload(self, variable: Variable) -> bytes:
        return self.link.upload(variable.index, variable.sub, length=variable.type.bits // 8 or None)

    def _optional_number(self, role: Role) -> int | None:
        data = self._told(role)
        return int.from_bytes(data, "little") if data else None

    def _optional_text(self, role: Role) -> str | None:
        data = self._told(role)
        return None if data is None else data.rstrip(b"\0").decode(errors="replace")

    def _told(self, role: Role) -> bytes | None:
        """Return the bytes of an object, listed or not; None if the drive refuses it for any reason."""
        variable = self.dictionary.get(role)
        try:
            return self.link.upload(*(role.key if variable is None else variable.key))
        except SdoAbort:
            return None

    @contextmanager
    def _naming(self, doing: str) -> Iterator[None]:
        try:
            yield
        except SdoAbort as abort:
            raise SdoAbort(f"{doing}: {abort}", abort.code) from abort
