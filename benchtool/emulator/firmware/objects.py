"""The drive's side of the dictionary: access, limits and state checked before a value reaches memory."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchtool.protocol.canopen import Abort
from benchtool.protocol.dictionary import DataType, Entry, Number, ObjectTable

Value = Number | str | bytes


class Refused(Exception):
    """An access that the drive answers with an abort code instead of a value."""

    def __init__(self, code: Abort) -> None:
        super().__init__(code.name)
        self.code = code


class ObjectStore:
    """Values of the dictionary: in the drive's memory, or computed when they are read.

    Args:
        table: the objects.
        memory: structured array of shape (1,) with a field for every number of the table.
        power_stage_is_on: says whether writes with `enabled_write = false` are to be refused.
    """

    def __init__(
        self,
        table: ObjectTable,
        memory: np.ndarray[Any, Any],
        power_stage_is_on: Callable[[], bool],
    ) -> None:
        self.table = table
        self._memory = memory
        self._power_stage_is_on = power_stage_is_on
        self._computed: dict[str, Callable[[], Value]] = {}
        self._checks: dict[str, Callable[[Number], None]] = {}
        self._effects: dict[str, Callable[[Number], None]] = {}
        self._limited_by: dict[str, list[Entry]] = {}
        for entry in table:
            if entry.max_entry:
                self._limited_by.setdefault(entry.max_entry, []).append(entry)

    def compute(self, name: str, read: Callable[[], Value]) -> None:
        """Have `name` computed by `read` whenever it is read."""
        self._computed[name] = read

    def check(self, name: str, accept: Callable[[Number], None]) -> None:
        """Have `accept` raise `Refused` for raw values of `name` that must not be written."""
        self._checks[name] = accept

    def on_write(self, name: str, effect: Callable[[Number], None]) -> None:
        """Have `effect` called with the raw value after a write of `name`."""
        self._effects[name] = effect

    def is_computed(self, name: str) -> bool:
        """Return whether memory does not hold the value of `name`."""
        return name in self._computed

    def __getitem__(self, name: str) -> Number:
        """Return the raw number of `name` as memory holds it."""
        value: Number = self._memory[name][0].item()
        return value

    def __setitem__(self, name: str, raw: Number) -> None:
        self._memory[name][0] = raw

    def parameters(self) -> Mapping[str, Number]:
        """Return the raw values of every entry that `store_parameters` keeps."""
        return {entry.name: self[entry.name] for entry in self.table if entry.role == "parameter"}

    def read(self, index: int, sub: int) -> bytes:
        """Return the raw bytes of an entry.

        Raises:
            Refused: no such object, or it cannot be read now.
        """
        entry = self._entry(index, sub)
        if entry.access == "wo":
            raise Refused(Abort.WRITE_ONLY)
        value: Value
        if entry.name in self._computed:
            value = self._computed[entry.name]()
        else:
            value = str(entry.default) if entry.type is DataType.STRING else self[entry.name]
        if isinstance(value, bytes):
            return value
        if isinstance(value, str):
            return value.encode("ascii")
        return np.asarray(value, dtype=entry.type.numpy).tobytes()

    def length(self, index: int, sub: int) -> int | None:
        """Return the bytes of an entry; None if there is no such entry or its length varies."""
        entry = self.table.by_key.get((index, sub))
        return entry.type.bits // 8 or None if entry is not None else None

    def write(self, index: int, sub: int, data: bytes) -> None:
        """Check and take raw bytes for an entry.

        Raises:
            Refused: no such object, not writable, wrong length, out of limits, or not in this state; memory
                is as it was.
        """
        entry = self._entry(index, sub)
        raw = self._accept(entry, data)
        self._require_consistent(entry, raw)
        self[entry.name] = raw
        if entry.name in self._effects:
            self._effects[entry.name](raw)

    def load(self, name: str) -> None:
        """Set `name` to its default, cut or raised to what the entries that limit it allow."""
        entry = self.table.by_name[name]
        assert isinstance(entry.default, int | float)
        self[name] = min(max(entry.default, self._floor(entry)), self._ceiling(entry))

    def is_acceptable(self, name: str) -> bool:
        """Return whether a write of the value that memory holds for `name` would be within all limits."""
        entry = self.table.by_name[name]
        try:
            self._require_consistent(entry, _raw(entry, self.read(entry.index, entry.sub)))
        except Refused:
            return False
        return True

    def _require_consistent(self, entry: Entry, raw: Number) -> None:
        """Check a value against the entries that limit it, and against those that it limits.

        Raises:
            Refused: it is beyond one, or would leave another beyond it.
        """
        if raw > self._ceiling(entry):
            raise Refused(Abort.VALUE_HIGH)
        if raw < self._floor(entry):
            raise Refused(Abort.VALUE_LOW)
        for other in self._limited_by.get(entry.name, ()):
            if raw > 0 and self[other.name] > _rounded(other, raw * other.max_times):
                raise Refused(Abort.PARAMETER_INCOMPATIBLE)

    def _floor(self, entry: Entry) -> float:
        """Return what the entry that limits it allows at least; minus infinity where none does."""
        if not entry.min_entry:
            return -math.inf
        return _rounded(entry, self[entry.min_entry] * entry.min_times)

    def _ceiling(self, entry: Entry) -> float:
        """Return what the entry that limits it allows at most; infinity where none does, or it is not
        known."""
        most = _rounded(entry, self[entry.max_entry] * entry.max_times) if entry.max_entry else 0.0
        return most if most > 0.0 else math.inf

    def write_all(self, values: Sequence[tuple[Entry, bytes]]) -> None:
        """Write several entries, or none of them.

        Raises:
            Refused: one of them was. What came before a write that only those before it made impossible has
                its old value again.
        """
        for entry, data in values:
            self._accept(entry, data)
        before = [self.read(entry.index, entry.sub) for entry, _ in values]
        for number, (entry, data) in enumerate(values):
            try:
                self.write(entry.index, entry.sub, data)
            except Refused:
                for (taken, _), old in reversed(list(zip(values[:number], before, strict=False))):
                    self.write(taken.index, taken.sub, old)
                raise

    def _accept(self, entry: Entry, data: bytes) -> Number:
        """Return the raw number of `data`, which may be written to the entry now."""
        if entry.access not in ("rw", "wo"):
            raise Refused(Abort.READ_ONLY)
        raw = _raw(entry, data)
        if not entry.enabled_write and self._power_stage_is_on():
            raise Refused(Abort.DEVICE_STATE)
        if entry.name in self._checks:
            self._checks[entry.name](raw)
        return raw

    def _entry(self, index: int, sub: int) -> Entry:
        if (entry := self.table.by_key.get((index, sub))) is not None:
            return entry
        known = any(item.index == index for item in self.table.objects)
        raise Refused(Abort.NO_SUB_INDEX if known else Abort.NO_OBJECT)


def _raw(entry: Entry, data: bytes) -> Number:
    """Return the number that `data` states, within the limits of the entry."""
    dtype = entry.type.numpy
    if dtype is None:
        raise Refused(Abort.READ_ONLY)
    if len(data) != dtype.itemsize:
        raise Refused(Abort.LENGTH_HIGH if len(data) > dtype.itemsize else Abort.LENGTH_LOW)
    raw: Number = np.frombuffer(data, dtype=dtype)[0].item()
    if isinstance(raw, float) and not math.isfinite(raw):
        raise Refused(Abort.VALUE)
    if entry.values is not None and raw not in entry.values.values():
        raise Refused(Abort.VALUE)
    if entry.maximum is not None and raw > _rounded(entry, entry.maximum):
        raise Refused(Abort.VALUE_HIGH)
    if entry.minimum is not None and raw < _rounded(entry, entry.minimum):
        raise Refused(Abort.VALUE_LOW)
    return raw


def _rounded(entry: Entry, limit: Number) -> Number:
    """Return the limit as a drive in single precision holds it, so that the limit itself is accepted."""
    if entry.type is DataType.F32:
        value: float = struct.unpack("<f", struct.pack("<f", limit))[0]
        return value
    return limit
