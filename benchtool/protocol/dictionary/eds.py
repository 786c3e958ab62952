"""The text of an EDS or DCF (CiA 306-1) as sections of keys and values, and the notation of its numbers.

Files of vendors differ in encoding, case and correctness. Invalid parts are skipped with a warning; only a
file that is not an EDS is refused.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from benchtool.errors import DictionaryError
from benchtool.protocol.dictionary.objects import DataType, Number

Keys = Mapping[str, str]

_ANNOTATION = re.compile(r"([0-9A-Fa-f]{4}(?:sub[0-9A-Fa-f]+)?)((?: \w+=\S+?)+?)(?:: (.*))?")
_OBJECT = re.compile(r"[0-9a-f]{4}(sub[0-9a-f]{1,2})?")


_COMMENT = re.compile(r"(?:^|\s);")
_HEADER = re.compile(r"\[\s*(.*?)\s*\]")


@dataclass(frozen=True)
class EdsFile:
    """Sections by name, their values by key (both lower case), and the parts that could not be parsed."""

    sections: Mapping[str, Keys]
    warnings: tuple[str, ...]


def read_eds(data: bytes, source: str) -> EdsFile:
    """Return the sections of a file.

    An object's section also gets the keys that `[Comments]` has for it in lines of the form
    `Line7=2000sub2 Role=parameter Unit=ohm: Stator resistance`; keys in the section itself go first.

    Args:
        data: the file's bytes: UTF-8, UTF-16 with a mark, or else Windows-1252.
        source: the name of the file in messages.

    Raises:
        DictionaryError: not text, or no section of an object in it.
    """
    text = _text(data)
    sections: dict[str, dict[str, str]] = {}
    warnings: list[str] = []
    current: dict[str, str] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        content = (_COMMENT.split(line, maxsplit=1)[0] if ";" in line else line).strip()
        if not content or content.startswith("#"):
            continue
        if content[0] == "[" and (header := _HEADER.fullmatch(content)):
            name = header[1].lower()
            if name in sections:
                warnings.append(f"line {number}: section [{header[1]}] again; both are read as one")
            current = sections.setdefault(name, {})
            continue
        key, equals, value = content.partition("=")
        if not equals or not sections:
            warnings.append(f"line {number}: '{content[:40]}' is neither a section nor a key; left out")
        else:
            current[key.strip().lower()] = value.strip()
    if "\0" in text or not any(_OBJECT.fullmatch(name) for name in sections):
        raise DictionaryError(
            f"{source}: no object in it, an EDS or DCF (CiA 306) is expected: give the EDS of the drive"
        )
    for name, keys in _annotations(sections.get("comments", {})):
        if name in sections:
            sections[name] = {**keys, **sections[name]}
    return EdsFile(sections, tuple(warnings))


def _text(data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _annotations(comments: Keys) -> Iterator[tuple[str, dict[str, str]]]:
    for line in comments.values():
        if match := _ANNOTATION.fullmatch(line):
            pairs = (pair.split("=", 1) for pair in match[2].split())
            keys = {key.lower(): value for key, value in pairs}
            yield match[1].lower(), {**keys, "description": match[3] or ""}


def parse_integer(text: str, node_id: int = 0) -> int:
    """Return an integer of an EDS: decimal or hexadecimal, with `$NODEID+` where it depends on the node.

    Raises:
        ValueError: not of that form.
    """
    plain = re.sub(r"\s|\$NODEID", "", text, flags=re.IGNORECASE)
    offset = node_id if "$" in text else 0
    if "$" in text:
        plain = plain.strip("+") or "0"
    return offset + (int(plain, 16) if re.match("[+-]?0[xX]", plain) else int(plain))


def parse_number(text: str, type_: DataType, node_id: int = 0) -> Number:
    """Return a limit or default of a numeric type, raw.

    Integers of signed types may be given in two's complement. A float is given by its bits in hexadecimal
    (CiA 306-1) or, as some vendors do, in decimals; one of 32 bits becomes the shortest decimal naming it.

    Raises:
        ValueError: not of that form, or outside the type.
    """
    if type_ in (DataType.F32, DataType.F64):
        return _parse_float(text, type_)
    value = parse_integer(text, node_id)
    low, high = (int(limit) for limit in type_.limits)
    if low < 0 and high < value <= high - low:
        value += 2 * low
    if not low <= value <= high:
        raise ValueError(f"{text} is outside {type_}")
    return value


def _parse_float(text: str, type_: DataType) -> float:
    if not re.match("0[xX]", text):
        value = float(text)
    elif type_ is DataType.F32:
        value = shortest(*struct.unpack(">f", int(text, 16).to_bytes(4, "big")))
    else:
        (value,) = struct.unpack(">d", int(text, 16).to_bytes(8, "big"))
    if not np.isfinite(value):
        raise ValueError(f"{text} is not a finite number")
    return value


def shortest(value: float) -> float:
    """Return the shortest decimal that names the same 32-bit float: 0.1 for 0.10000000149011612."""
    return float(str(np.float32(value)))
