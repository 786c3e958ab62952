"""The table of objects as a page to read."""

from __future__ import annotations

from benchtool.protocol.dictionary.objects import Entry, Number, Object, ObjectTable

_HEAD = """\
# Object dictionary

Generated from `objects.toml` by `python -m firmware_protocol.generate`; do not edit.

Vendor {vendor_id}, product {product_code}, revision {revision}, dictionary hash {hash}.

Range and default are in the unit of the column, after the factor: physical value = raw value * factor.
The value of an entry named in a range is a limit as well, unless it is 0.
Vectors are amplitude-invariant; currents and voltages are peak values unless a description says rms.
Access: *locked* is refused with 0x08000022 while the power stage is on, *P* may be mapped to a PDO.

In `drive.eds`, unit, factor, role, enumeration and description stand in `[Comments]`, one line per entry
(`2000sub2 Role=parameter Unit=ohm: Stator resistance per phase`), since CiA 306 has no keys for them.

## The data of a capture

Object 0x2042 reads as a header of 32 bytes and the rows, all little-endian. A row is `n_channels` values of
four bytes, u32 or f32 as the captured signal is, in the order of `capture_channels`.

| Offset | Type | Field | Meaning |
|---|---|---|---|
| 0 | 4 bytes | magic | `BTC1` |
| 4 | u16 | n_channels | captured signals, 1 to 16 |
| 6 | u16 | stride | ticks per row |
| 8 | u32 | tick_period_ns | length of a tick |
| 12 | u32 | rows | number of rows |
| 16 | u32 | first_tick | tick of the first row |
| 20 | u32 | trigger_tick | tick of the trigger |
| 24 | u32 | sequence | `capture_sequence` of this capture |
| 28 | u32 | crc | CRC-32 (IEEE 802.3, as in zlib) of the 28 bytes before it and of all rows |
"""
_COLUMNS = "| Index | Name | Type | Unit | Range | Default | Access | Description |\n|" + 8 * "---|"


def render(table: ObjectTable) -> str:
    """Return the text of the page, in Markdown."""
    device = {name: f"0x{table.device[name]:08X}" for name in ("vendor_id", "product_code", "revision")}
    head = _HEAD.format(**device, hash=f"`0x{table.hash:08X}`")
    return head + "".join(_object(item, table) for item in table.objects)


def _object(item: Object, table: ObjectTable) -> str:
    rows = "\n".join(_row(entry, table) for entry in item.entries)
    return f"\n## 0x{item.index:04X} {item.name}\n\n{item.description} ({item.kind}).\n\n{_COLUMNS}\n{rows}\n"


def _row(entry: Entry, table: ObjectTable) -> str:
    default = table.hash if entry.name == "dictionary_hash" else entry.default
    cells = (
        f"0x{entry.index:04X}:{entry.sub}",
        f"`{entry.name}`",
        entry.type,
        entry.unit,
        _range(entry),
        _default(entry, default),
        _access(entry),
        _description(entry),
    )
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _range(entry: Entry) -> str:
    if entry.minimum is None and entry.maximum is None:
        return ""
    ends = ["" if end is None else _physical(entry, end) for end in (entry.minimum, entry.maximum)]
    if entry.min_entry:
        ends[0] += f", {'' if entry.min_times == 1 else f'{entry.min_times:g} '}`{entry.min_entry}`"
    if entry.max_entry:
        ends[1] += f", {'' if entry.max_times == 1 else f'{entry.max_times:g} '}`{entry.max_entry}`"
    return " to ".join(ends)


def _default(entry: Entry, default: Number | str | None) -> str:
    if default is None or isinstance(default, str):
        return default or ""
    for name, number in (entry.values or {}).items():
        if number == default:
            return name
    return f"node id + 0x{default:X}" if entry.add_node_id else _physical(entry, default)


def _physical(entry: Entry, raw: Number) -> str:
    return f"{raw * entry.factor:.10g}"


def _access(entry: Entry) -> str:
    return entry.access + ("" if entry.enabled_write else ", locked") + (", P" if entry.mappable else "")


def _description(entry: Entry) -> str:
    factor = "" if entry.factor == 1 else f" Factor {entry.factor:g}."
    values = ", ".join(f"`{name}` = {number}" for name, number in (entry.values or {}).items())
    return f"{entry.role.capitalize()}. {entry.description}.{factor}{f' Values: {values}.' if values else ''}"
