"""The table of objects as an electronic data sheet (CiA 306-1).

The standard has no keys for unit, factor, description, role and enumerations, and checkers refuse other keys
in an object's section. They stand in `[Comments]`, one line per entry, which every tool keeps:
`Line7=2000sub2 Role=parameter Unit=ohm: Stator resistance per phase`.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

from benchtool.protocol.canopen.pdo import RPDOS, TPDOS
from benchtool.protocol.dictionary.objects import DataType, Entry, Number, Object, ObjectTable

_MANDATORY = (0x1000, 0x1001, 0x1018)
_OBJECT_TYPES = {"var": 0x7, "array": 0x8, "record": 0x9}
_DOMAIN_OBJECT = 0x2
_BIT_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)
_FORMAT = (
    "Generated from objects.toml. Each line below tells of one section what the standard has no key for:",
    "section, then Role, Unit, Factor (physical value = raw value * Factor), Values (of an enumeration)",
    "EnabledWrite=0 (refused while the power stage is on), MinEntry, MinTimes, MaxEntry, MaxTimes (entries",
    "whose values are limits as well, so many times of it), then a colon and the description.",
)


def render(table: ObjectTable) -> str:
    """Return the text of the EDS; REAL32 values are given by their bits in hexadecimal."""
    groups = {
        "MandatoryObjects": [item for item in table.objects if item.index in _MANDATORY],
        "OptionalObjects": [
            item
            for item in table.objects
            if item.index not in _MANDATORY and not 0x2000 <= item.index < 0x6000
        ],
        "ManufacturerObjects": [item for item in table.objects if 0x2000 <= item.index < 0x6000],
    }
    lines = [*_file_info(table), *_device_info(table), *_comments(table)]
    for title, objects in groups.items():
        lines += ["", f"[{title}]", f"SupportedObjects={len(objects)}"]
        lines += [f"{number}=0x{item.index:04X}" for number, item in enumerate(objects, start=1)]
        for item in objects:
            lines += _object(item, table)
    return "\n".join(lines) + "\n"


def _file_info(table: ObjectTable) -> Iterator[str]:
    yield from ("[FileInfo]", "FileName=drive.eds", "FileVersion=1", "FileRevision=0", "EDSVersion=4.0")
    yield f"Description={table.device['product_name']}"
    yield f"CreatedBy={table.device['vendor_name']}"


def _device_info(table: ObjectTable) -> Iterator[str]:
    device = table.device
    yield from ("", "[DeviceInfo]")
    yield f"VendorName={device['vendor_name']}"
    yield f"VendorNumber=0x{device['vendor_id']:08X}"
    yield f"ProductName={device['product_name']}"
    yield f"ProductNumber=0x{device['product_code']:08X}"
    yield f"RevisionNumber=0x{device['revision']:08X}"
    yield f"OrderCode={device['product_code']}"
    yield from (f"BaudRate_{rate}=1" for rate in _BIT_RATES)
    yield from ("SimpleBootUpMaster=0", "SimpleBootUpSlave=1", "Granularity=8", "DynamicChannelsSupported=0")
    yield from ("CompactPDO=0", "GroupMessaging=0")
    yield f"NrOfRXPDO={sum(item.index in RPDOS for item in table.objects)}"
    yield f"NrOfTXPDO={sum(item.index in TPDOS for item in table.objects)}"
    yield "LSS_Supported=0"
    yield from ("", "[DummyUsage]")
    yield from (f"Dummy{number:04d}=0" for number in range(1, 8))


def _comments(table: ObjectTable) -> Iterator[str]:
    texts = [*_FORMAT, *(_annotation(entry, item) for item in table.objects for entry in item.entries)]
    yield from ("", "[Comments]", f"Lines={len(texts)}")
    yield from (f"Line{number}={_plain(text)}" for number, text in enumerate(texts, start=1))


def _annotation(entry: Entry, item: Object) -> str:
    keys = {
        "Role": entry.role,
        "Unit": entry.unit,
        "Factor": "" if entry.factor == 1 else repr(entry.factor),
        "Values": ",".join(f"{name}:{number}" for name, number in (entry.values or {}).items()),
        "EnabledWrite": "" if entry.enabled_write else "0",
        "MinEntry": entry.min_entry,
        "MinTimes": "" if entry.min_times == 1 else repr(entry.min_times),
        "MaxEntry": entry.max_entry,
        "MaxTimes": "" if entry.max_times == 1 else repr(entry.max_times),
    }
    stated = (f"{key}={value}" for key, value in keys.items() if value)
    return f"{_section(entry, item)} {' '.join(stated)}: {entry.description}"


def _object(item: Object, table: ObjectTable) -> Iterator[str]:
    if item.kind == "var":
        yield from _entry(item.entries[0], item, table)
        return
    yield from ("", f"[{item.index:04X}]", f"ParameterName={_plain(item.name)}")
    yield from (f"ObjectType=0x{_OBJECT_TYPES[item.kind]:X}", f"SubNumber={len(item.entries)}")
    for entry in item.entries:
        yield from _entry(entry, item, table)


def _entry(entry: Entry, item: Object, table: ObjectTable) -> Iterator[str]:
    default = table.hash if entry.name == "dictionary_hash" else entry.default
    yield from ("", f"[{_section(entry, item)}]", f"ParameterName={_plain(entry.name)}")
    yield f"ObjectType=0x{_DOMAIN_OBJECT if entry.type is DataType.DOMAIN else _OBJECT_TYPES['var']:X}"
    yield f"DataType=0x{entry.type.code:04X}"
    yield f"AccessType={entry.access}"
    if entry.minimum is not None:
        yield f"LowLimit={_number(entry, entry.minimum)}"
    if entry.maximum is not None:
        yield f"HighLimit={_number(entry, entry.maximum)}"
    if default is not None:
        text = _plain(default) if isinstance(default, str) else _number(entry, default)
        yield f"DefaultValue={'$NODEID+' if entry.add_node_id else ''}{text}"
    if (
        entry.type is not DataType.DOMAIN
    ):  # which has no mapping (CiA 306-1, table 5); strict readers refuse it
        yield f"PDOMapping={int(entry.mappable)}"


def _section(entry: Entry, item: Object) -> str:
    return f"{entry.index:04X}" if item.kind == "var" else f"{entry.index:04X}sub{entry.sub:X}"


def _number(entry: Entry, value: Number) -> str:
    if entry.type is DataType.F32:
        return f"0x{struct.pack('>f', value).hex().upper()}"
    return f"0x{value:X}" if entry.add_node_id else str(value)


def _plain(text: str) -> str:
    if re.search(r"(^|\s)[;#]|\n", text):
        raise ValueError(f"'{text}' would be cut in an EDS, where ; and # after a space begin a comment")
    return text
