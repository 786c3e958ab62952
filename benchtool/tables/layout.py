"""Layout of a table in a text file: delimiter, decimal sign, header and names."""

from __future__ import annotations

import csv
import itertools
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchtool.errors import RecordingError
from benchtool.tables.stamps import is_stamp
from benchtool.tables.units import is_scale, is_unit

BLANKS = " "
"""The delimiter for any run of blanks and tabs."""

_HEAD_BYTES = 256 * 1024
_SAMPLE_BYTES = 32 * 1024
_MOST_COLUMNS = 4096
# the first that fits; numbers with decimal commas between commas are in quotation marks
_LAYOUTS = (
    (",", "."),
    (";", "."),
    (";", ","),
    ("\t", "."),
    ("\t", ","),
    (BLANKS, "."),
    (BLANKS, ","),
    (",", ","),
)
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_NO_NUMBER = frozenset(("", "nan", "inf", "+inf", "-inf", "infinity", "null", "na", "n/a"))
_BRACKETED = re.compile(r"\(.*\)|\[.*\]")
_BRACKETS = re.compile(r"\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")
_SUFFIXES = (1, 2, 4)  # the last 1/n of the lines, in which a long head no longer counts
_ROWS_IN_HEAD = 0.25  # of the rows below the names: more rows above them are data


@dataclass(frozen=True)
class Column:
    """One column: `name` as the head has it (empty without one), `unit` as the head states it, or empty.

    What the name has in brackets is its unit where that is a unit, or a scale of which no SI unit is known
    (`[counts]`, `[%]`); `Iq[0]` and `i (phase a)` have none. Of a quotient of quantity and unit (`t/s`,
    `n/(1/min)`; ISO 80000-1:2022, 7.1.4) it is the latter. The cells of a column with `stamps` are times of
    day, perhaps with a date, which count in seconds.
    """

    name: str
    unit: str
    stamps: bool = False

    @property
    def bare_name(self) -> str:
        """The name without the unit behind it."""
        quantity, unit = _quotient(self.name)
        return quantity if unit else _BRACKETS.sub("", self.name).strip() or self.name


@dataclass(frozen=True)
class Layout:
    """Numbers begin at byte `begin`, after `head_lines` lines; `delimiter` is one character, or `BLANKS`."""

    delimiter: str
    decimal: str
    columns: tuple[Column, ...]
    head_lines: int
    begin: int


def find_layout(text: bytes, source: str) -> Layout:
    """Return the layout of a table in UTF-8, lines ended by newlines; `source` stands in the messages.

    The delimiter and decimal sign are those by which most cells of most lines, sampled from the beginning,
    the middle and the end, are numbers. What comes before the first such line is the head: the line of it
    nearest the numbers that has a name for each column names them, and of two such lines the second may hold
    their units. Lines right above the numbers whose cells are numbers or empty are rows as well. Where no
    line above the first numbers names columns and one below a few of them does, those few belong to the head
    as well. Lines that begin with # or % are comments, which may name the columns too.

    Raises:
        RecordingError: no two columns of numbers are there.
    """
    head = text[:_HEAD_BYTES]
    lines = head.split(b"\n")
    if len(text) > len(head):
        del lines[-1]  # cut short
    sample = [line for line in _sampled(text, lines) if line.strip() and not is_comment(line)]
    found = _best(sample)
    if found is None:
        seen = _almost_a_number(sample)
        raise RecordingError(
            f"{source}: no table of numbers found{seen and f', {seen!r} is none'}; lines of at least two "
            f"numbers are expected, separated by comma, semicolon, tab or blanks, times in seconds or as "
            f"2026-01-31 23:59:59.5, no thousands separators: export it as such"
        )
    delimiter, decimal, width, numeric = found
    rows = [
        not is_comment(line)
        and _is_row(split(line.decode(errors="replace"), delimiter), decimal, width, numeric)
        for line in lines
    ]
    if not any(rows):
        raise RecordingError(
            f"{source}: no line of numbers within the first {len(head)} bytes, a head of a few lines is "
            f"expected: cut the head"
        )
    texts = [line.decode(errors="replace") for line in lines]
    for place in range(rows.index(True) - 1, -1, -1):
        cells = split(texts[place], delimiter)
        rows[place] = not is_comment(lines[place]) and _is_row(cells, decimal, width, numeric, fewest=1)
        if not rows[place]:
            break
    cells_of = [split(line.decode(errors="replace"), delimiter) for line in sample]
    by_column = list(zip(*(cells for cells in cells_of if len(cells) == width), strict=True))
    # columns at the end that are empty in every line are delimiters that end a line
    used = max((number for number, cells in enumerate(by_column, 1) if any(cells)), default=width)
    head_lines = rows.index(True)
    columns = _columns(texts[:head_lines], delimiter, used)
    if not columns:
        head_lines = _below_names(texts, rows, delimiter, numeric) or head_lines
        columns = _columns(texts[:head_lines], delimiter, used)
    begin = sum(len(line) + 1 for line in lines[:head_lines])
    columns += tuple(Column("", "") for _ in range(width - len(columns)))
    columns = tuple(
        Column(each.name, "s", stamps=True) if _is_stamped(cells) else each
        for each, cells in zip(columns, by_column, strict=True)
    )
    return Layout(delimiter, decimal, columns, head_lines, begin)


def is_comment(line: bytes) -> bool:
    return line.lstrip()[:1] in (b"#", b"%")


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the blanks about them."""
    if delimiter == BLANKS:
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]
        except csv.Error:
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def _almost_a_number(sample: Sequence[bytes]) -> str:
    """Return a cell of the lines that only begins like a number, such as a date; empty if there is none."""
    for line in sample[1:]:
        for delimiter in (",", ";", "\t", BLANKS):
            cells = split(line.decode(errors="replace"), delimiter)
            for cell in cells if len(cells) > 1 else ():
                if cell[:1].isdigit() and not _is_number(cell, ".") and not _is_number(cell, ","):
                    return cell[:40]
    return ""


def _sampled(text: bytes, head: Sequence[bytes]) -> Iterator[bytes]:
    yield from head[:1000]
    yield from head[max(1000, len(head) - 500) :]
    if len(text) > _HEAD_BYTES:
        for begin in (len(text) // 2, len(text) - _SAMPLE_BYTES):
            yield from text[begin : begin + _SAMPLE_BYTES].split(b"\n")[1:-1]


def _best(sample: Sequence[bytes]) -> tuple[str, str, int, tuple[bool, ...]] | None:
    """Return delimiter, decimal sign, width, and which columns hold numbers; None where fewer than two do."""
    best, best_score = None, 0.0
    for delimiter, decimal in _LAYOUTS:
        by_width: dict[int, list[list[str]]] = defaultdict(list)
        for line in sample:
            cells = split(line.decode(errors="replace"), delimiter)
            if 2 <= len(cells) <= _MOST_COLUMNS:
                by_width[len(cells)].append(cells)
        for (width, found), part in itertools.product(by_width.items(), _SUFFIXES):
            rows = found[-(-len(found) * (part - 1) // part) :]
            counts = [sum(_is_number(row[column], decimal) for row in rows) for column in range(width)]
            filled = [sum(bool(row[column]) for row in rows) for column in range(width)]
            numeric = tuple(
                count > 0 and count >= some / 2 for count, some in zip(counts, filled, strict=True)
            )
            numbers = sum(count for count, kept in zip(counts, numeric, strict=True) if kept)
            score = numbers * numbers / max(1, sum(filled))  # many numbers, and few cells that are not
            if sum(numeric) >= 2 and score > best_score:
                best, best_score = (delimiter, decimal, width, numeric), score
    return best


def _is_number(cell: str, decimal: str) -> bool:
    """Return whether a cell is a number, or a time that stands for one."""
    if ":" in cell:
        return is_stamp(cell)
    if decimal == ",":
        cell = "" if "." in cell else cell.replace(",", ".")
    return _NUMBER.fullmatch(cell) is not None


def _is_row(
    cells: Sequence[str], decimal: str, width: int, numeric: Sequence[bool], fewest: int | None = None
) -> bool:
    """Return whether the cells are a row: `fewest` numbers or, without it, half of them; the rest empty."""
    if len(cells) != width:
        return False
    wanted = [cell for cell, is_numeric in zip(cells, numeric, strict=True) if is_numeric]
    numbers = [_is_number(cell, decimal) for cell in wanted]
    fits = (good or cell.lower() in _NO_NUMBER for cell, good in zip(wanted, numbers, strict=True))
    return sum(numbers) >= (0.5 * len(numbers) if fewest is None else fewest) and all(fits)


def _is_stamped(cells: Sequence[str]) -> bool:
    """Return whether most cells of a column that are not empty are times of day."""
    return 2 * sum(map(is_stamp, cells)) > sum(map(bool, cells))


def _columns(preamble: Sequence[str], delimiter: str, width: int) -> tuple[Column, ...]:
    """Return the names and units from the lines before the numbers; none where no line fits."""
    fitting: list[list[str]] = []
    for line in reversed(preamble):
        if not line.strip():
            continue
        cells = _fitted(line.strip().lstrip("#%").strip(), delimiter, width)
        if cells is None:
            if fitting:
                break
            continue
        fitting.append(cells)
        if len(fitting) == 2 or not _are_units(cells):
            break
    if not fitting:
        return ()
    if len(fitting) == 2:
        units = [cell.strip("()[] ") for cell in fitting[0]]
        return tuple(Column(name, unit) for name, unit in zip(fitting[1], units, strict=True))
    return tuple(Column(name, _unit_in(name)) for name in fitting[0])


def _below_names(
    texts: Sequence[str], rows: Sequence[bool], delimiter: str, numeric: Sequence[bool]
) -> int | None:
    """Return where the rows begin below a line of names with only a few rows of numbers above it."""
    first, last = rows.index(True), len(rows) - 1 - list(reversed(rows)).index(True)
    for place in range(first + 1, last):
        if rows[place]:
            continue
        cells = _fitted(texts[place].strip().lstrip("#%").strip(), delimiter, len(numeric))
        names = [] if cells is None else [cell for cell, kept in zip(cells, numeric, strict=True) if kept]
        if not names or any(not cell or _has_number(cell) or cell.lower() in _NO_NUMBER for cell in names):
            continue
        return rows.index(True, place) if sum(rows[:place]) <= _ROWS_IN_HEAD * sum(rows[place:]) else None
    return None


def _has_number(cell: str) -> bool:
    return _is_number(cell, ".") or _is_number(cell, ",")


def _fitted(line: str, delimiter: str, width: int) -> list[str] | None:
    """Return the cells of a head line, one for each column, or None; its delimiter may not be the body's."""
    ways = (split(line, delimiter), *(split(line, other) for other in ",;\t"), re.split(r"\s{2,}|\t", line))
    for cells in ways:
        while len(cells) > width and not cells[-1]:
            del cells[-1]
        if len(cells) == width and any(cells):
            return cells
    return None


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether most cells are units, perhaps with unknown ones, or all are in brackets."""
    filled = [cell for cell in cells if cell]
    bare = [cell.strip("()[] ") for cell in filled]
    units = sum(is_unit(cell) for cell in bare)
    others = sum(cell in ("-", "1", "%") for cell in bare)
    bracketed = all(_BRACKETED.fullmatch(cell) for cell in filled)
    return units > 0 and (bracketed or units + others == len(filled) or 2 * units > len(filled))


def _unit_in(name: str) -> str:
    """Return the last of what stands in brackets that is a unit, else the last that is another scale, or
    nothing."""
    _, unit = _quotient(name)
    if unit:
        return unit
    found = [str(match["round"] or match["square"] or "").strip() for match in _BRACKETS.finditer(name)]
    for is_one in (is_unit, is_scale):
        for text in reversed(found):
            if is_one(text):
                return text
    return ""


def _quotient(name: str) -> tuple[str, str]:
    """Return quantity and unit of a name that is a quotient of both, else the name and no unit."""
    quantity, solidus, unit = (part.strip() for part in name.partition("/"))
    unit = unit[1:-1] if unit.startswith("(") and unit.endswith(")") else unit
    return (quantity, unit) if solidus and quantity and is_unit(unit) and not is_unit(name) else (name, "")
