"""The table of objects from its source file, and its hash."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

Number = int | float


class DataType(StrEnum):
    """Types of the table, and those of 64 bits in files of other vendors, with their names in CiA 301."""

    I8 = "i8"
    U8 = "u8"
    I16 = "i16"
    U16 = "u16"
    I32 = "i32"
    U32 = "u32"
    I64 = "i64"
    U64 = "u64"
    F32 = "f32"
    F64 = "f64"
    STRING = "string"
    DOMAIN = "domain"

    @property
    def code(self) -> int:
        """Data type index of CiA 301, table 44."""
        return _CODE[self]

    @property
    def numpy(self) -> np.dtype[Any] | None:
        """Little-endian numpy type; None for strings and domains."""
        return _NUMPY.get(self)

    @property
    def bits(self) -> int:
        """Length in bits; 0 for strings and domains."""
        return 8 * self.numpy.itemsize if self.numpy is not None else 0

    @property
    def limits(self) -> tuple[Number, Number]:
        """Lowest and highest finite value; (0, 0) for strings and domains."""
        if self.numpy is None:
            return 0, 0
        if self.numpy.kind == "f":
            return float(np.finfo(self.numpy).min), float(np.finfo(self.numpy).max)
        return int(np.iinfo(self.numpy).min), int(np.iinfo(self.numpy).max)


_CODE = {
    DataType.I8: 0x02,
    DataType.I16: 0x03,
    DataType.I32: 0x04,
    DataType.U8: 0x05,
    DataType.U16: 0x06,
    DataType.U32: 0x07,
    DataType.F32: 0x08,
    DataType.STRING: 0x09,
    DataType.DOMAIN: 0x0F,
    DataType.F64: 0x11,
    DataType.I64: 0x15,
    DataType.U64: 0x1B,
}
_NUMPY: dict[DataType, np.dtype[Any]] = {
    DataType.I8: np.dtype("<i1"),
    DataType.U8: np.dtype("<u1"),
    DataType.I16: np.dtype("<i2"),
    DataType.U16: np.dtype("<u2"),
    DataType.I32: np.dtype("<i4"),
    DataType.U32: np.dtype("<u4"),
    DataType.I64: np.dtype("<i8"),
    DataType.U64: np.dtype("<u8"),
    DataType.F32: np.dtype("<f4"),
    DataType.F64: np.dtype("<f8"),
}


@dataclass(frozen=True)
class Entry:
    """One value of the dictionary; `raw * factor` is the physical value in `unit`.

    `min_entry` and `max_entry` name entries whose values are limits as well, `min_times` and `max_times` of
    them; a 0 there is none.
    """

    index: int
    sub: int
    name: str
    type: DataType
    role: str
    access: str
    description: str
    unit: str = ""
    factor: float = 1.0
    minimum: Number | None = None
    maximum: Number | None = None
    min_entry: str = ""
    min_times: float = 1.0
    max_entry: str = ""
    max_times: float = 1.0
    default: Number | str | None = None
    values: Mapping[str, int] | None = None
    enabled_write: bool = True
    add_node_id: bool = False

    @property
    def mapping(self) -> int:
        """The entry as a PDO mapping names it: index << 16 | sub-index << 8 | bits."""
        return self.index << 16 | self.sub << 8 | self.type.bits

    @property
    def mappable(self) -> bool:
        """Whether it may be mapped to a PDO: signals, setpoints, and state objects of CiA 402."""
        cyclic = self.role in ("signal", "command") or (self.role == "status" and self.index >= 0x6000)
        return cyclic and self.type.bits > 0


@dataclass(frozen=True)
class Object:
    """One index: a var (one entry), a record or an array (entry 0 counts the others)."""

    index: int
    name: str
    kind: str
    description: str
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class ObjectTable:
    """Every object of the drive, ordered by index."""

    device: Mapping[str, Any]
    objects: tuple[Object, ...]

    def __iter__(self) -> Iterator[Entry]:
        return (entry for item in self.objects for entry in item.entries)

    @cached_property
    def by_name(self) -> Mapping[str, Entry]:
        return {entry.name: entry for entry in self}

    @cached_property
    def by_key(self) -> Mapping[tuple[int, int], Entry]:
        return {(entry.index, entry.sub): entry for entry in self}

    @cached_property
    def hash(self) -> int:
        """First four bytes of SHA-256 over everything that host and drive must agree on.

        Descriptions, and the default of the object that holds the hash, are excluded.
        """
        rows = [
            [
                *(e.index, e.sub, e.name, e.type, e.unit, e.factor, e.role, e.access, e.minimum, e.maximum),
                *(None if e.name == "dictionary_hash" else e.default, e.values, e.enabled_write),
                *(e.min_entry, e.min_times, e.max_entry, e.max_times),
            ]
            for e in self
        ]
        digest = hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).digest()
        return int.from_bytes(digest[:4], "big")


def load_table(path: Path) -> ObjectTable:
    """Return the table of the file at `path`; the same content is parsed once."""
    return _parsed(path.read_text(encoding="utf-8"))


@lru_cache(maxsize=4)
def _parsed(text: str) -> ObjectTable:
    return table_from_toml(tomllib.loads(text))


def table_from_toml(document: Mapping[str, Any]) -> ObjectTable:
    """Return the table of a parsed `objects.toml`.

    Raises:
        KeyError, TypeError, ValueError: the document is not of the form its head comment describes.
    """
    rows = (copy for raw in document["object"] for copy in _copies(raw))
    objects = tuple(sorted((_object(raw) for raw in rows), key=lambda item: item.index))
    table = ObjectTable(document["device"], objects)
    names = [entry.name for entry in table]
    if repeated := {name for name in names if names.count(name) > 1}:
        raise ValueError(f"names must be unique in the table; repeated: {', '.join(sorted(repeated))}")
    return table


def _copies(raw: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the object, or the objects generated by its `repeat`."""
    single = {key: value for key, value in raw.items() if key != "repeat"}
    return [
        {**_nth(single, number), "index": raw["index"] + number - 1}
        for number in range(1, raw.get("repeat", 1) + 1)
    ]


def _nth(row: Mapping[str, Any], number: int) -> dict[str, Any]:
    def nth(key: str, value: Any) -> Any:
        match value:
            case str():
                return value.replace("{n}", str(number))
            case dict() if key == "entries":
                return _nth(value, number)
            case list() if key == "entry":
                return [_nth(each, number) for each in value]
            case list() if key == "default":
                return value[number - 1]
        return value

    return {key: nth(key, value) for key, value in row.items()}


def _object(raw: Mapping[str, Any]) -> Object:
    index, name, kind, description = raw["index"], raw["name"], raw["kind"], raw["description"]
    if kind == "var":
        keys = {key: value for key, value in raw.items() if key not in ("index", "kind")}
        return Object(index, name, kind, description, (_entry(index, {"sub": 0, **keys}),))
    if kind == "array":
        shared = {
            key: value
            for key, value in raw.items()
            if key not in ("index", "kind", "name", "count", "entry_name", "sub0_access", "sub0_default")
        }
        rows = _numbered(raw["count"], raw["entry_name"], shared)
    elif "entries" in raw:
        shared = {key: value for key, value in raw["entries"].items() if key not in ("count", "name")}
        rows = _numbered(raw["entries"]["count"], raw["entries"]["name"], shared)
    else:
        rows = list(raw["entry"])
    count = {
        "sub": 0,
        "name": f"{name}_count",
        "type": "u8",
        "role": "status",
        "access": raw.get("sub0_access", "ro" if kind == "array" else "const"),
        "default": raw.get("sub0_default", max(row["sub"] for row in rows)),
        "description": "Highest sub-index",
    }
    return Object(index, name, kind, description, tuple(_entry(index, row) for row in [count, *rows]))


def _numbered(count: int, name: str, shared: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    if count == 1:
        return [{**shared, "sub": 1, "name": name}]
    return [{**shared, "sub": sub, "name": f"{name}_{sub}"} for sub in range(1, count + 1)]


def _entry(index: int, raw: Mapping[str, Any]) -> Entry:
    renamed = {"min": "minimum", "max": "maximum"}
    keys = {renamed.get(key, key): value for key, value in raw.items()}
    return Entry(index=index, **{**keys, "type": DataType(raw["type"])})
