"""From the sections of an EDS to variables, object by object (CiA 306-1, 4.6.3)."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from benchtool.protocol.dictionary.eds import EdsFile, Keys, parse_integer, parse_number
from benchtool.protocol.dictionary.objects import DataType, Number
from benchtool.protocol.dictionary.variable import Value, Variable

_TYPES = {type_.code: type_ for type_ in DataType} | {0x01: DataType.U8, 0x0A: DataType.DOMAIN}
_LAST_STANDARD_TYPE = 0x1B
_DOMAIN_OBJECT = 2
_ACCESS = {"ro": "ro", "wo": "wo", "rw": "rw", "rwr": "rw", "rww": "rw", "const": "const"}

_Parsed = TypeVar("_Parsed")


@dataclass(frozen=True)
class Identity:
    """Identity of the drive in the file; None where the file does not state it."""

    vendor_name: str
    vendor_id: int | None
    product_name: str
    product_code: int | None
    revision: int | None


class EdsObjects:
    """The variables and the identity in the sections of one file, with `warnings` about faults in them."""

    def __init__(self, file: EdsFile, node_id: int) -> None:
        self._sections = file.sections
        self._node_id = node_id
        self.warnings = list(file.warnings)
        self.identity = self._identity()
        self.variables = self._variables()

    def _identity(self) -> Identity:
        keys = self._sections.get("deviceinfo", {})
        vendor, product, revision = (
            self._parsed("DeviceInfo", keys, key, parse_integer)
            for key in ("VendorNumber", "ProductNumber", "RevisionNumber")
        )
        return Identity(keys.get("vendorname", ""), vendor, keys.get("productname", ""), product, revision)

    def _variables(self) -> Mapping[str, Variable]:
        found = list(self._entries())
        names = Counter(variable.name for _, variable in found)
        qualified = [
            variable if names[variable.name] == 1 else replace(variable, name=f"{parent}.{variable.name}")
            for parent, variable in found
        ]
        names = Counter(variable.name for variable in qualified)
        unique = [
            each if names[each.name] == 1 else replace(each, name=f"{each.name} {each.label}")
            for each in qualified
        ]
        return {variable.name: variable for variable in unique}

    def _entries(self) -> Iterator[tuple[str, Variable]]:
        for index, rows in sorted(self._indices().items()):
            section = f"{index:04x}"
            keys = self._sections.get(section, {})
            name = keys.get("parametername") or f"0x{index:04X}"
            described = self._described(index, section, keys, rows)
            if described:
                yield from (
                    (name, self._variable(index, sub, row, each)) for sub, (row, each) in described.items()
                )
            elif self._parsed(section, keys, "CompactSubObj", parse_integer):
                yield from ((name, variable) for variable in self._compact(index, section, keys))
            elif self._kind(section, keys) in (8, 9):
                self._warn(section, "a record or array without sub-indices; left out")
            else:
                yield name, self._variable(index, 0, section, keys)

    def _indices(self) -> dict[int, dict[int, str]]:
        """Return the section of every sub-index of every object; data types, below 0x1000, are skipped."""
        indices: dict[int, dict[int, str]] = {}
        for section in self._sections:
            match = re.fullmatch(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,2}))?", section)
            if match is None or int(match[1], 16) < 0x1000:
                continue
            rows = indices.setdefault(int(match[1], 16), {})
            if match[2] is not None and rows.setdefault(sub := int(match[2], 16), section) != section:
                self._warn(section, f"sub-index {sub} again; left out")
        return indices

    def _described(
        self, index: int, section: str, keys: Keys, rows: Mapping[int, str]
    ) -> dict[int, tuple[str, Keys]]:
        """Return the section and keys of every sub-index that the file describes.

        Some editors leave a sub-section without a type and a name. For sub-index 0, the section of the object
        describes it; others are skipped.
        """
        plain = self._kind(section, keys) not in (8, 9) and "datatype" in keys
        described: dict[int, tuple[str, Keys]] = {}
        for sub, row in sorted(rows.items()):
            own = self._sections[row]
            if own.keys() & {"datatype", "parametername"} or self._kind(row, own) == _DOMAIN_OBJECT:
                described[sub] = row, {**keys, **own} if plain and sub == 0 else own
            elif plain and sub == 0:
                self._warn(row, f"it is empty; '{keys.get('parametername', '')}' is read from [{section}]")
            else:
                self._warn(
                    row, f"it is empty; sub-index {sub} of '{keys.get('parametername', '')}' is left out"
                )
        return described

    def _compact(self, index: int, section: str, keys: Keys) -> Iterator[Variable]:
        count = min(self._parsed(section, keys, "CompactSubObj", parse_integer) or 0, 0xFE)
        names = self._sections.get(f"{section}name", {})
        configured = self._sections.get(f"{section}value", {})
        head = {
            "parametername": "NrOfObjects",
            "datatype": "5",
            "accesstype": "ro",
            "defaultvalue": str(count),
        }
        yield self._variable(index, 0, section, head)
        for sub in range(1, count + 1):
            name = names.get(str(sub)) or f"{keys.get('parametername', section)}{sub}"
            value = configured.get(str(sub), keys.get("parametervalue", ""))
            each = {**keys, "parametername": name, "parametervalue": value}
            yield self._variable(index, sub, section, each)

    def _variable(self, index: int, sub: int, section: str, keys: Keys) -> Variable:
        type_ = self._type(section, keys)
        values = self._parsed(section, keys, "Values", _parse_values)
        minimum = self._number(section, keys, "LowLimit", type_)
        maximum = self._number(section, keys, "HighLimit", type_)
        if minimum is not None and maximum is not None and minimum > maximum:
            self._warn(section, f"LowLimit {minimum} is above HighLimit {maximum}; no limits are used")
            minimum = maximum = None
        return Variable(
            index=index,
            sub=sub,
            name=self._name(index, sub, section, keys),
            type=type_,
            unit=keys.get("unit", ""),
            factor=self._parsed(section, keys, "Factor", _parse_factor) or 1.0,
            raw_minimum=minimum,
            raw_maximum=maximum,
            raw_default=self._value(section, keys, "DefaultValue", type_),
            raw_configured=self._configured(section, keys, type_),
            access=self._access(section, keys),
            role=keys.get("role", "status"),
            values=values,
            enabled_write=keys.get("enabledwrite", "1") != "0",
            description=keys.get("description", ""),
            mappable=bool(self._parsed(section, keys, "PDOMapping", parse_integer)),
            min_entry=keys.get("minentry", ""),
            min_times=self._parsed(section, keys, "MinTimes", _parse_factor) or 1.0,
            max_entry=keys.get("maxentry", ""),
            max_times=self._parsed(section, keys, "MaxTimes", _parse_factor) or 1.0,
        )

    def _name(self, index: int, sub: int, section: str, keys: Keys) -> str:
        if name := keys.get("parametername"):
            return name
        self._warn(section, f"no ParameterName; called 0x{index:04X}:{sub}")
        return f"0x{index:04X}:{sub}"

    def _kind(self, section: str, keys: Keys) -> int | None:
        return self._parsed(section, keys, "ObjectType", parse_integer)

    def _type(self, section: str, keys: Keys) -> DataType:
        code = self._parsed(section, keys, "DataType", parse_integer)
        if code is None and self._kind(section, keys) == _DOMAIN_OBJECT:
            return DataType.DOMAIN
        if code is not None and code > _LAST_STANDARD_TYPE:
            # Some editors give an object with limits a type of its own, whose sub-index 1 is the plain type.
            code = self._parsed(
                section, self._sections.get(f"{code:x}sub1", {}), "DefaultValue", parse_integer
            )
        if code in _TYPES:
            return _TYPES[code]
        given = keys.get("datatype")
        self._warn(
            section,
            f"DataType {given} is unknown; bytes are used" if given else "no DataType; bytes are used",
        )
        return DataType.DOMAIN

    def _access(self, section: str, keys: Keys) -> str:
        given = keys.get("accesstype", "").lower()
        if given not in _ACCESS:
            self._warn(section, f"AccessType '{given}' is unknown; ro is used")
        return _ACCESS.get(given, "ro")

    def _value(self, section: str, keys: Keys, key: str, type_: DataType) -> Value | None:
        if type_ is DataType.STRING:
            return keys.get(key.lower(), "")
        if type_ is DataType.DOMAIN:
            return None
        return self._number(section, keys, key, type_)

    def _configured(self, section: str, keys: Keys, type_: DataType) -> Value | None:
        if not keys.get("parametervalue"):
            return None
        return self._value(section, keys, "ParameterValue", type_)

    def _number(self, section: str, keys: Keys, key: str, type_: DataType) -> Number | None:
        if type_.numpy is None:
            return None
        return self._parsed(section, keys, key, lambda text: parse_number(text, type_, self._node_id))

    def _parsed(self, section: str, keys: Keys, key: str, parse: Callable[[str], _Parsed]) -> _Parsed | None:
        text = keys.get(key.lower())
        if not text:
            return None
        try:
            return parse(text)
        except (ValueError, OverflowError):
            self._warn(section, f"{key} '{text}' is not understood; left out")
            return None

    def _warn(self, section: str, what: str) -> None:
        self.warnings.append(f"[{section}] {what}")


def _parse_factor(text: str) -> float:
    factor = float(text)
    if factor == 0 or not math.isfinite(factor):
        raise ValueError(f"{text} is no factor")
    return factor


def _parse_values(text: str) -> dict[str, int]:
    pairs = (pair.partition(":") for pair in text.split(","))
    return {name: int(number) for name, _, number in pairs}
