"""The emulated drive's process data (CiA 301, 7.2.2): mapping by the host, TPDOs in drive time, RPDOs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.protocol.canopen import (
    CAN_ID,
    INVALID,
    MAX_BITS,
    MAX_ENTRIES,
    PDO_PARAMETERS,
    Abort,
    cob_id,
    event_timer_ticks,
)
from benchtool.protocol.dictionary import Entry, Number
from benchtool.ticks import wrap_tick

_NEVER = 1 << 62


@dataclass(frozen=True)
class _Active:
    """A PDO in use; `ticks` between two transmissions, 0 for one that is received."""

    name: str
    can_id: int
    entries: tuple[Entry, ...]
    ticks: int

    @property
    def length(self) -> int:
        return sum(entry.type.bits for entry in self.entries) // 8


class ProcessData:
    """The PDO objects of one drive, and what they do while it is operational.

    Args:
        objects: the drive's dictionary, whose PDO objects get their rules here.
        node_id: of the identifiers after a reset.
        period_s: length of a tick.
        send: takes identifier and data of a frame.
        feed_link: what a setpoint that was taken does besides.
    """

    def __init__(
        self,
        objects: ObjectStore,
        node_id: int,
        period_s: float,
        send: Callable[[int, bytes], None],
        feed_link: Callable[[], None],
    ) -> None:
        self._objects = objects
        self._node_id = node_id
        self._period_s = period_s
        self._send = send
        self._feed_link = feed_link
        self._transmitted: tuple[_Active, ...] = ()
        self._received: dict[int, _Active] = {}
        for name in _names():
            self._wire(name)

    def reset(self) -> None:
        """Set every communication and mapping parameter to its default: no PDO is in use."""
        for entry in self._objects.table:
            if entry.index in PDO_PARAMETERS and isinstance(entry.default, int):
                self._objects[entry.name] = entry.default + (self._node_id if entry.add_node_id else 0)
        self._renew()

    def next_tick(self, tick: int) -> int:
        """Return the first tick after `tick` in which a PDO is to be sent."""
        return min(((tick // pdo.ticks + 1) * pdo.ticks for pdo in self._transmitted), default=_NEVER)

    def transmit(self, tick: int) -> None:
        """Send what is due in this tick, lowest identifier first as the bus would have it."""
        due = [pdo for pdo in self._transmitted if tick % pdo.ticks == 0]
        if any(pdo.name == "tpdo1" for pdo in due):
            self._objects["stream_sequence"] = wrap_tick(int(self._objects["stream_sequence"]) + 1)
        for pdo in due:
            self._send(pdo.can_id, b"".join(self._objects.read(e.index, e.sub) for e in pdo.entries))

    def receive(self, can_id: int, data: bytes) -> None:
        """Take a setpoint frame as a whole or not at all; other identifiers are ignored."""
        pdo = self._received.get(can_id)
        if pdo is None:
            return
        if len(data) < pdo.length or not self._take(pdo, data):
            self._objects["rpdo_dropped"] = int(self._objects["rpdo_dropped"]) + 1
            return
        self._feed_link()

    def _take(self, pdo: _Active, data: bytes) -> bool:
        values, start = [], 0
        for entry in pdo.entries:
            end = start + entry.type.bits // 8
            values.append((entry, data[start:end]))
            start = end
        try:
            self._objects.write_all(values)
        except Refused:
            return False
        return True

    # ---- the objects -------------------------------------------------------------------------------------

    def _wire(self, name: str) -> None:
        objects = self._objects
        objects.check(f"{name}_cob_id", partial(self._check_cob_id, name))
        objects.on_write(f"{name}_cob_id", lambda _: self._renew())
        objects.check(f"{name}_mapping_count", partial(self._check_count, name))
        for position in range(1, MAX_ENTRIES + 1):
            objects.check(f"{name}_mapping_{position}", partial(self._check_mapping, name))
        if name.startswith("t"):
            objects.on_write(f"{name}_event_timer", lambda _: self._renew())

    def _is_used(self, name: str) -> bool:
        return not int(self._objects[f"{name}_cob_id"]) & INVALID

    def _check_cob_id(self, name: str, raw: Number) -> None:
        raw_id = int(raw)
        if self._is_used(name) and not raw_id & INVALID and raw_id != self._objects[f"{name}_cob_id"]:
            raise Refused(Abort.VALUE)
        # 29-bit identifiers are not supported.
        if raw_id >> 11 & 0x7FFFF or not cob_id.FIRST_OF_PDO <= raw_id & CAN_ID <= cob_id.LAST_OF_PDO:
            raise Refused(Abort.VALUE)

    def _check_mapping(self, name: str, raw: Number) -> None:
        if self._is_used(name) or self._objects[f"{name}_mapping_count"]:
            raise Refused(Abort.UNSUPPORTED_ACCESS)
        if raw:
            self._mapped(name, int(raw))

    def _check_count(self, name: str, raw: Number) -> None:
        count = int(raw)
        if self._is_used(name):
            raise Refused(Abort.UNSUPPORTED_ACCESS)
        if count > MAX_ENTRIES:
            raise Refused(Abort.VALUE_HIGH)
        if sum(entry.type.bits for entry in self._entries(name, count)) > MAX_BITS:
            raise Refused(Abort.MAPPING_TOO_LONG)

    def _entries(self, name: str, count: int) -> tuple[Entry, ...]:
        mappings = [int(self._objects[f"{name}_mapping_{position + 1}"]) for position in range(count)]
        return tuple(self._mapped(name, mapping) for mapping in mappings)

    def _mapped(self, name: str, mapping: int) -> Entry:
        entry = self._objects.table.by_key.get((mapping >> 16, mapping >> 8 & 0xFF))
        if entry is None:
            raise Refused(Abort.NO_OBJECT)
        wanted = entry.access != "wo" if name.startswith("t") else entry.access in ("rw", "wo")
        if not (entry.mappable and wanted) or entry.mapping != mapping:
            raise Refused(Abort.NOT_MAPPABLE)
        return entry

    def _renew(self) -> None:
        active = {name: self._active(name) for name in _names() if self._is_used(name)}
        transmitted = [pdo for name, pdo in active.items() if name.startswith("t") and pdo.ticks]
        self._transmitted = tuple(sorted(transmitted, key=lambda pdo: pdo.can_id))
        self._received = {pdo.can_id: pdo for name, pdo in active.items() if name.startswith("r")}

    def _active(self, name: str) -> _Active:
        objects = self._objects
        can_id = int(objects[f"{name}_cob_id"]) & CAN_ID
        entries = self._entries(name, int(objects[f"{name}_mapping_count"]))
        timer_ms = int(objects[f"{name}_event_timer"]) if name.startswith("t") else 0
        return _Active(name, can_id, entries, event_timer_ticks(timer_ms, self._period_s))


def _names() -> list[str]:
    transmit = [f"tpdo{number}" for number in range(1, len(cob_id.TPDO) + 1)]
    return transmit + [f"rpdo{number}" for number in range(1, len(cob_id.RPDO) + 1)]
