"""One variable of a drive: conversion between values in SI units and bytes on the wire."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from benchtool.errors import DictionaryMismatch, ValueRefused
from benchtool.protocol.dictionary.eds import shortest
from benchtool.protocol.dictionary.objects import DataType, Number

Value = int | float | str | bytes

_LARGEST = 1e300


@dataclass(frozen=True)
class Variable:
    """One value of the dictionary as the host knows it; `raw * factor` is the physical value in `unit`.

    `raw_configured` is the value that a DCF configures the device with (its `ParameterValue`, CiA 306-1); an
    EDS has none. `role` is parameter, command, signal or status, `access` ro, rw, wo or const, as
    `objects.toml` describes. `min_entry` and `max_entry` name variables whose values are limits as well,
    `min_times` and `max_times` of them.
    """

    index: int
    sub: int
    name: str
    type: DataType
    unit: str = ""
    factor: float = 1.0
    raw_minimum: Number | None = None
    raw_maximum: Number | None = None
    raw_default: Value | None = None
    raw_configured: Value | None = None
    access: str = "rw"
    role: str = "status"
    values: Mapping[str, int] | None = None
    enabled_write: bool = True
    description: str = ""
    mappable: bool = False
    min_entry: str = ""
    min_times: float = 1.0
    max_entry: str = ""
    max_times: float = 1.0

    @property
    def key(self) -> tuple[int, int]:
        """Index and sub-index."""
        return self.index, self.sub

    @property
    def label(self) -> str:
        """Index and sub-index as text, `0x2000:2`."""
        return f"0x{self.index:04X}:{self.sub}"

    @property
    def mapping(self) -> int:
        """The variable as a PDO mapping or a capture names it: index << 16 | sub-index << 8 | bits."""
        return self.index << 16 | self.sub << 8 | self.type.bits

    @property
    def minimum(self) -> Number | None:
        """Lower limit in `unit`; None without one."""
        return None if self.raw_minimum is None else self._physical(self.raw_minimum)

    @property
    def maximum(self) -> Number | None:
        """Upper limit in `unit`; None without one."""
        return None if self.raw_maximum is None else self._physical(self.raw_maximum)

    @property
    def default(self) -> Value | None:
        """Default in `unit`, an enumeration's as its name; None without one."""
        raw = self.raw_default
        return raw if raw is None or isinstance(raw, str | bytes) else self._named(raw)

    @property
    def configured(self) -> Value | None:
        """What a DCF configures, in `unit`, an enumeration's as its name; None without it."""
        raw = self.raw_configured
        return raw if raw is None or isinstance(raw, str | bytes) else self._named(raw)

    @property
    def readable(self) -> bool:
        return self.access != "wo"

    @property
    def writable(self) -> bool:
        return self.access in ("rw", "wo")

    def encode(self, value: Value) -> bytes:
        """Return the bytes of a value: a number in `unit`, a name of the enumeration, the text of either, or
        a string.

        An integer with a factor is rounded to the nearest step. `access` is not checked.

        Raises:
            ValueRefused: not a value of this type, no such name, or outside the limits.
        """
        if self.type in (DataType.STRING, DataType.DOMAIN):
            if isinstance(value, str | bytes):
                return value.encode() if isinstance(value, str) else value
            raise self._refusal(value, "text or bytes are expected")
        raw = self._raw(value)
        low, high = self._raw_limits()
        if not low <= raw <= high:
            raise self._refusal(value, f"its limits are {self._span(low, high)}")
        assert self.type.numpy is not None  # every type but the two above has one
        return np.array(raw, dtype=self.type.numpy).tobytes()

    def decode(self, data: bytes) -> Value:
        """Return the value in bytes: a number in `unit`, a name of the enumeration (its number if it has no
        name), a string or, of a domain, the bytes. A 32-bit float becomes the shortest decimal that names it.

        Raises:
            DictionaryMismatch: the length is not that of the type.
        """
        if self.type is DataType.DOMAIN:
            return data
        if self.type is DataType.STRING:
            return data.rstrip(b"\0").decode(errors="replace")
        if 8 * len(data) != self.type.bits:
            raise DictionaryMismatch(
                f"{self.name} ({self.label}) came with {len(data)} bytes, {self.type} has "
                f"{self.type.bits // 8}: use the EDS of the drive's firmware"
            )
        raw = np.frombuffer(data, dtype=self.type.numpy)[0].item()
        return self._named(shortest(raw) if self.type is DataType.F32 else raw)

    def _named(self, raw: Number) -> Value:
        for name, number in (self.values or {}).items():
            if number == raw:
                return name
        return self._physical(raw)

    def _physical(self, raw: Number) -> Number:
        return raw if self.factor == 1 else raw * self.factor

    def _raw(self, value: Value) -> Number:
        number = self._number(value)
        if self.values is not None and number not in self.values.values():
            raise self._refusal(value, f"the values are {', '.join(self.values)}")
        if not -_LARGEST < number < _LARGEST:  # not NaN either
            raise self._refusal(value, "a finite number is expected")
        raw = number if self.factor == 1 else number / self.factor
        if self.type is DataType.F32:
            return self._as_f32(value, raw)
        if self.type is DataType.F64:
            return raw
        if self.factor == 1 and raw != int(raw):
            raise self._refusal(value, "a whole number is expected")
        return int(raw) if self.factor == 1 else round(raw)

    def _as_f32(self, value: Value, raw: float) -> float:
        try:
            return shortest(*struct.unpack("<f", struct.pack("<f", raw)))
        except OverflowError:
            raise self._refusal(value, "a 32-bit float does not reach that far") from None

    def _number(self, value: Value) -> Number:
        if isinstance(value, bytes):
            raise self._refusal(value, "a number is expected")
        if not isinstance(value, str):
            return value
        if self.values is not None and value in self.values:
            return self.values[value]
        for parse in (lambda text: int(text, 0), float):
            try:
                number: Number = parse(value)
            except ValueError:
                continue
            return number
        names = f"one of {', '.join(self.values)}" if self.values else "a number"
        raise self._refusal(value, f"{names} is expected")

    def _raw_limits(self) -> tuple[Number, Number]:
        low, high = self.type.limits
        return (
            low if self.raw_minimum is None else self.raw_minimum,
            high if self.raw_maximum is None else self.raw_maximum,
        )

    def _span(self, low: Number, high: Number) -> str:
        return f"{self._physical(low):.10g} to {self._physical(high):.10g} {self.unit}".rstrip()

    def _refusal(self, value: Value, expected: str) -> ValueRefused:
        shown = f"{value:.9g} {self.unit}".rstrip() if isinstance(value, float) else repr(value)[:40]
        return ValueRefused(f"{self.name} = {shown}: {expected}; nothing was sent, give such a value")
