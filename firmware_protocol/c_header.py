"""The table of objects for firmware in C99: indices, sub-indices, enumerations and one row per entry."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.protocol.dictionary.eds import shortest
from benchtool.protocol.dictionary.objects import DataType, Entry, Number, ObjectTable

_ACCESSES = ("ro", "rw", "wo", "const")
_ROLES = ("parameter", "command", "signal", "status")
_VALUE_COMMENT = """\
/* What an enumeration may be: X(name, value) for each of its values, in the order of BT_ENTRIES. Any other is
 * refused. */"""
_RELATION_COMMENT = """\
/* Entries that another's value limits as well: X(name, least, times) with the limit least * times, and
 * X(name, most, times) with the limit most * times. A limit of 0 is not known, and none. */"""
_ROW_COMMENT = """\
/* Every entry as
 *   X(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, minimum, maximum, initial)
 * with raw values; where the table has no limit, that of the type. A string's or domain's limits are 0.
 * name is a C identifier; TYPE, ACCESS and ROLE go behind BT_TYPE_, BT_ACCESS_ and BT_ROLE_, TYPE also behind
 * BT_SIZE_. Where a value is kept is not said here. */"""


def render(table: ObjectTable) -> str:
    """Return the text of the header.

    Raises:
        ValueError: two names differ only in case.
    """
    lines = [
        "/* SPDX-FileCopyrightText: 2026 The benchtool authors",
        " * SPDX-License-Identifier: MIT */",
        "/* Generated from objects.toml by python -m firmware_protocol.generate; do not edit. */",
        "#ifndef BENCHTOOL_DRIVE_OBJECTS_H",
        "#define BENCHTOOL_DRIVE_OBJECTS_H",
        "",
        "#ifdef __cplusplus",
        'extern "C" {',
        "#endif",
        "",
        f"#define BT_DICTIONARY_HASH 0x{table.hash:08X}u",
        f"#define BT_VENDOR_ID 0x{table.device['vendor_id']:08X}u",
        f"#define BT_PRODUCT_CODE 0x{table.device['product_code']:08X}u",
        f"#define BT_REVISION 0x{table.device['revision']:08X}u",
        "",
        "/* CiA 301 data types */",
        *_enumeration("type", ((type_.name, type_.code) for type_ in DataType)),
        "",
        "/* Bytes of a value; 0 where they are not the same for all of the type */",
        *(f"#define BT_SIZE_{type_.name} {type_.bits // 8}u" for type_ in DataType),
        "",
        *_enumeration("access", ((name, number) for number, name in enumerate(_ACCESSES))),
        "",
        *_enumeration("role", ((name, number) for number, name in enumerate(_ROLES))),
        "",
        "/* Indices of the objects */",
        *(f"#define BT_INDEX_{item.name.upper()} 0x{item.index:04X}u" for item in table.objects),
        "",
        "/* Sub-indices of the entries */",
        *(f"#define BT_SUB_{entry.name.upper()} {entry.sub}u" for entry in table),
        "",
        "/* Enumerations */",
        *(line for entry in table if entry.values for line in [*_values(entry), ""]),
        _ROW_COMMENT,
        "#define BT_ENTRIES(X) \\",
        *(f"    {_row(entry, table)} \\" for entry in table),
        "    /* end */",
        "",
        f"#define BT_ENTRY_COUNT {len(list(table))}u",
        "",
        _VALUE_COMMENT,
        "#define BT_VALUES(X) \\",
        *(f"    X({entry.name}, {value}) \\" for entry in table for value in (entry.values or {}).values()),
        "    /* end */",
        "",
        f"#define BT_VALUE_COUNT {sum(len(entry.values or {}) for entry in table)}u",
        "",
        _RELATION_COMMENT,
        "#define BT_MIN_ENTRIES(X) \\",
        *(
            f"    X({entry.name}, {entry.min_entry}, {entry.min_times!r}f) \\"
            for entry in table
            if entry.min_entry
        ),
        "    /* end */",
        "#define BT_MAX_ENTRIES(X) \\",
        *(
            f"    X({entry.name}, {entry.max_entry}, {entry.max_times!r}f) \\"
            for entry in table
            if entry.max_entry
        ),
        "    /* end */",
        "",
        "#ifdef __cplusplus",
        "}",
        "#endif",
        "",
        "#endif",
    ]
    related = {
        name
        for entry in table
        if entry.min_entry or entry.max_entry
        for name in (entry.name, entry.min_entry, entry.max_entry)
        if name
    }
    if others := sorted(name for name in related if table.by_name[name].type is not DataType.F32):
        raise ValueError(f"entries that limit others must be f32, as these; others: {', '.join(others)}")
    macros = [line.split()[1] for line in lines if line.startswith("#define")]
    if repeated := {macro for macro in macros if macros.count(macro) > 1}:
        raise ValueError(f"names must differ in more than case; repeated: {', '.join(sorted(repeated))}")
    return "\n".join(lines) + "\n"


def _enumeration(name: str, members: Iterator[tuple[str, int]]) -> list[str]:
    rows = [f"    BT_{name.upper()}_{member.upper()} = {number}," for member, number in members]
    return [f"enum bt_{name} {{", *rows[:-1], rows[-1].rstrip(","), "};"]


def _values(entry: Entry) -> list[str]:
    return _enumeration(entry.name, iter((entry.values or {}).items()))


def _row(entry: Entry, table: ObjectTable) -> str:
    initial = table.hash if entry.name == "dictionary_hash" else entry.default
    low, high = _limits(entry)
    cells = (
        f"0x{entry.index:04X}u",
        f"{entry.sub}u",
        entry.name,
        entry.type.name,
        entry.access.upper(),
        entry.role.upper(),
        str(int(entry.enabled_write)),
        str(int(entry.add_node_id)),
        low,
        high,
        f'"{initial}"' if isinstance(initial, str) else _literal(entry, 0 if initial is None else initial),
    )
    return f"X({', '.join(cells)})"


def _limits(entry: Entry) -> tuple[str, str]:
    low, high = entry.type.limits
    return (
        _literal(entry, low if entry.minimum is None else entry.minimum),
        _literal(entry, high if entry.maximum is None else entry.maximum),
    )


def _literal(entry: Entry, value: Number) -> str:
    """Return a C literal; the lowest 32-bit integer as a difference, since C negates a literal after reading
    it."""
    if entry.type is DataType.F32:
        return f"{shortest(value)!r}f"
    if entry.type in (DataType.U8, DataType.U16, DataType.U32):
        return f"{value}u"
    return f"({value + 1} - 1)" if value == -(2**31) else str(value)
