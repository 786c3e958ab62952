"""Cells of a table: numbers as other tools and languages write them, and what stands in place of one."""

from __future__ import annotations

import re
from collections.abc import Iterable
from enum import IntEnum
from functools import cache, lru_cache

import pyarrow as pa
import pyarrow.compute as pc

from benchtool.tables.stamps import is_stamp

BLANKS = " "
"""The delimiter for any run of blanks and tabs."""

_EXPONENT = r"(?:[eE][+-]?[0-9]+)?"
_MINUS = rb"(?:\xe2\x88\x92|\xe2\x80[\x90-\x93]|\xef\xb9\xa3|\xef\xbc\x8d)"  # minus, hyphens and dashes
_MINUS_OF_A_NUMBER = re.compile(
    rb'(?:(?<=[\s,;"])|^|(?<=[0-9.][eEdD]))' + _MINUS + rb"(?=[0-9.,]|\xe2\x88\x9e)"
)
_INFINITY = "∞".encode()
# no-break and thin blanks, and apostrophes, between groups of three digits
_GROUPS = re.compile(
    rb"(?<![0-9.,'])[0-9]{1,3}(?:(?:\xc2\xa0|\xe2\x80[\x87-\x89\x99\xaf]|')[0-9]{3})+(?![0-9'])"
)
_BETWEEN_GROUPS = re.compile(rb"\xc2\xa0|\xe2\x80[\x87-\x89\x99\xaf]|'")
_FORTRAN = re.compile(rb"(?<=[0-9.])[dD](?=[+-][0-9]{2})")
_SNIFFED_BYTES = 64 * 1024
_OVERLOADS = re.compile(
    r"[+-]?(?:inf|infinity|1\.#inf\d*|(?:over|ov[lr]|ofl|clip|satur|under).*|o\.?l\.?|of|out of range"
    r"|.{0,2}(?:berlauf|bersteuer|berlast|bereich).*|hi|lo|d.{1,2}passement.*|fuori.*|fuera.*"
    r"|[<>]+.*|\++)",
    re.IGNORECASE,
)
_NO_VALUE = re.compile(
    r"|[+-]?(?:1\.#)?(?:nan|qnan|snan|ind)\d*|null|none|nil|n/?\.?a\.?|#.*|[-*?._]+|no ?data"
    r"|invalid|error|err|missing|fault|bad.*",
    re.IGNORECASE,
)

_SIGNS = "+-.,eE "
_OF_NUMBERS = f"0123456789{_SIGNS}"

_IN_PLACE = re.compile(r"nan|inf|null|none|na|ol|ovl|over|overflow|overload|no ?data", re.IGNORECASE)


class Cell(IntEnum):
    """What a cell of a column of numbers is."""

    NUMBER = 0
    MISSING = 1
    OVERLOAD = 2


def ascii_numbers(text: bytes) -> bytes:
    """Return text in UTF-8 with its numbers as a program writes them.

    A minus sign or dash before a number (U+2212) is a hyphen, the sign of infinity `inf`, an exponent behind
    D, as Fortran writes it, one behind E; apostrophes, no-break and thin blanks between groups of three
    digits are left out.
    """
    if not text.isascii():
        text = _MINUS_OF_A_NUMBER.sub(b"-", text).replace(_INFINITY, b"inf")
    if b"'" in text or not text.isascii():
        text = _GROUPS.sub(lambda match: _BETWEEN_GROUPS.sub(b"", match[0]), text)
    if _FORTRAN.search(text, 0, _SNIFFED_BYTES):
        text = _FORTRAN.sub(b"E", text)
    return text


@cache
def plain(decimal: str) -> str:
    """Return the pattern of a number with this decimal sign."""
    sign = re.escape(decimal)
    return rf"[+-]?(?:[0-9]+(?:{sign}[0-9]*)?|{sign}[0-9]+){_EXPONENT}"


@cache
def grouped(decimal: str, delimiter: str) -> str:
    """Return the pattern of a number in groups of three digits, by the other sign or by a blank."""
    other = "." if decimal == "," else ","
    between = [re.escape(other)] if delimiter != other or other == "," else []
    between += [" "] if delimiter in (";", "\t") else []
    each = "|".join(f"(?:{sign}[0-9]{{3}})+" for sign in between)
    return rf"[+-]?[1-9][0-9]{{0,2}}(?:{each})(?:{re.escape(decimal)}[0-9]*)?"


@cache
def _pattern(decimal: str, delimiter: str) -> re.Pattern[str]:
    either = plain(decimal) if not delimiter else f"{plain(decimal)}|{grouped(decimal, delimiter)}"
    return re.compile(either)


def is_number(cell: str, decimal: str, delimiter: str = "") -> bool:
    """Return whether a cell is a number, or a time that stands for one; in groups of digits too where the
    delimiter is given."""
    return are_numbers((cell,), decimal, delimiter)[0]


def are_numbers(cells: Iterable[str], decimal: str, delimiter: str = "") -> list[bool]:
    """Return of each cell whether it is a number, as `is_number` does."""
    fullmatch = _pattern(decimal, delimiter).fullmatch
    return [is_stamp(cell) if ":" in cell else fullmatch(cell) is not None for cell in cells]


def kind_of_word(cell: str) -> Cell | None:
    """Return what a cell that is no number stands for, by the words of instruments; None for other words."""
    if not cell.strip(_OF_NUMBERS) and cell.strip(_SIGNS):  # most cells of a table, by another delimiter
        return None
    return _kind_of_word(cell)


@lru_cache(maxsize=1024)
def _kind_of_word(cell: str) -> Cell | None:
    cell = cell.strip()
    if _OVERLOADS.fullmatch(cell):
        return Cell.OVERLOAD
    return Cell.MISSING if _NO_VALUE.fullmatch(cell) else None


def is_no_name(cell: str) -> bool:
    """Return whether a cell stands in place of a number and is no word that may name a column, as `error`."""
    is_word = re.fullmatch(r"[A-Za-z ]+", cell) and not _IN_PLACE.fullmatch(cell)
    return kind_of_word(cell) is not None and not is_word


def numbers_of(cells: pa.ChunkedArray, decimal: str, delimiter: str) -> pa.ChunkedArray:
    """Return the cells of text of a column as numbers, null where they are not numbers."""
    cells = pc.ascii_trim_whitespace(cells)
    is_grouped = pc.match_substring_regex(cells, f"^{grouped(decimal, delimiter)}$")
    if pc.any(is_grouped).as_py():
        other = "." if decimal == "," else ","
        joined = pc.replace_substring(pc.replace_substring(cells, other, ""), " ", "")
        cells = pc.if_else(is_grouped, joined, cells)
    cells = pc.if_else(pc.match_substring_regex(cells, f"^{plain(decimal)}$"), cells, None)
    if decimal == ",":
        cells = pc.replace_substring(cells, ",", ".")
    return pc.cast(pc.ascii_ltrim(cells, "+"), pa.float64())
