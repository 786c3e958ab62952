"""Head of a table: the lines of names and of units above its numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from benchtool.tables.cells import BLANKS, is_number, kind_of_word
from benchtool.tables.units import is_description, is_scale, is_unit

_BRACKETED = re.compile(r"\(.*\)|\[.*\]")
_IN_BRACKETS = re.compile(r"\(([^()]*)\)|\[([^\[\]]*)\]|\{([^{}]*)\}|<([^<>]*)>")
_BRACKETS = re.compile(rf"\s*(?:{_IN_BRACKETS.pattern})")
_RULE_SIGNS = frozenset("-=_+|:~* \t")
_ROWS_IN_HEAD = 0.25  # of the rows below the names: more rows above them are data


@dataclass(frozen=True)
class Column:
    """One column: `name` as the head has it (empty without one), `unit` as the head states it, or empty.

    What the name has in brackets is its unit, known or not (`[mA]`, `[counts]`, `[kp cm2]`), but for an index
    or words that describe the column: `Iq[0]` and `i (phase a)` have none. Of a quotient of quantity and unit
    (`t/s`, `n/(1/min)`; ISO 80000-1:2022, 7.1.4) it is the latter. The cells of a column with `stamps` are
    times of day, perhaps with a date, which count in seconds. `open_sign` may be the decimal sign, or stand
    between thousands. `other_name` is what the head has instead of a unit, where that may be a name.
    """

    name: str
    unit: str
    stamps: bool = False
    open_sign: str = ""
    other_name: str = ""

    def called(self, name: str) -> Column:
        """Return the column by its other name, if `name` is that."""
        if not self.other_name or name.strip().lower() != self.other_name.lower():
            return self
        return replace(self, name=self.other_name, unit=_unit_in(self.other_name), other_name="")

    @property
    def bare_name(self) -> str:
        """The name without the unit behind it."""
        quantity, unit = _quotient(self.name)
        return quantity if unit else _BRACKETS.sub("", self.name).strip() or self.name

    @property
    def in_brackets(self) -> str:
        """What stands in the last brackets of the name, or nothing."""
        return next(reversed(_in_brackets(self.name)), "")


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


def columns_of(preamble: Sequence[str], delimiter: str, width: int) -> tuple[Column, ...]:
    """Return the names and units from the lines before the numbers; none where no line fits.

    Of two lines right above each other that fit, the second holds units if most of it are units, or if any is
    and the first is one of words alone; it may then hold other names.
    """
    fitting: list[list[str]] = []
    for line in reversed(preamble):
        if not line.strip() or _is_rule(line.strip()):
            continue
        cells = fitted(bare_line(line), delimiter, width)
        if cells is None:
            if fitting:
                break
            continue
        fitting.append(cells)
        if len(fitting) == 2 or not any(map(_is_unit_cell, cells)):
            break
    if not fitting:
        return ()
    if len(fitting) == 2 and (are_units(fitting[0]) or _are_words(fitting[1])):
        below = [""] * len(fitting[0]) if are_units(fitting[0]) else fitting[0]
        return tuple(
            Column(name, unit.strip("()[] "), other_name=other)
            for name, unit, other in zip(fitting[1], fitting[0], below, strict=True)
        )
    return tuple(Column(name, _unit_in(name)) for name in fitting[0])


def units_in(preamble: Sequence[str], delimiter: str) -> tuple[str, ...]:
    """Return the units in brackets and in cells of their own of all lines above the numbers."""
    found: dict[str, None] = {}
    for line in preamble:
        texts = [
            *_in_brackets(line),
            *(cell.strip("()[]{}<> ") for cell in split(bare_line(line), delimiter)),
        ]
        found |= dict.fromkeys(text for text in texts if text and is_unit(text))
    return tuple(found)


def rows_below_names(
    texts: Sequence[str], rows: Sequence[bool], delimiter: str, numeric: Sequence[bool]
) -> int | None:
    """Return where the rows begin below a line of names with only a few rows of numbers above it."""
    first, last = rows.index(True), len(rows) - 1 - list(reversed(rows)).index(True)
    for place in range(first + 1, last):
        if rows[place]:
            continue
        cells = fitted(bare_line(texts[place]), delimiter, len(numeric))
        names = [] if cells is None else [cell for cell, kept in zip(cells, numeric, strict=True) if kept]
        if not names or any(not cell or has_number(cell) or kind_of_word(cell) is not None for cell in names):
            continue
        return rows.index(True, place) if sum(rows[:place]) <= _ROWS_IN_HEAD * sum(rows[place:]) else None
    return None


def has_number(cell: str) -> bool:
    """Return whether a cell is a number with either decimal sign."""
    return is_number(cell, ".") or is_number(cell, ",")


def bare_line(line: str) -> str:
    """Return a line without the sign of a comment before it."""
    return line.strip().lstrip("#%").strip()


def fitted(line: str, delimiter: str, width: int) -> list[str] | None:
    """Return the cells of a head line, one for each column, or None; its delimiter may not be the body's."""
    ways = [split(line, delimiter), *(split(line, other) for other in ",;\t"), re.split(r"\s{2,}|\t", line)]
    if delimiter != BLANKS:  # one in brackets separates nothing: [mA; DC]
        outside = rf"{re.escape(delimiter)}(?![^\[]*\])(?![^(]*\))"
        ways.append([cell.strip() for cell in re.split(outside, line)])
    for cells in ways:
        while len(cells) > width and not cells[-1]:
            del cells[-1]
        if len(cells) == width and any(cells):
            return cells
    return None


def are_units(cells: Sequence[str]) -> bool:
    """Return whether most cells are units, perhaps with unknown ones, or all are in brackets."""
    filled = [cell for cell in cells if cell]
    bare = [cell.strip("()[] ") for cell in filled]
    units = sum(is_unit(cell) for cell in bare)
    others = sum(cell in ("-", "1", "%") for cell in bare)
    bracketed = all(_BRACKETED.fullmatch(cell) for cell in filled)
    return units > 0 and (bracketed or units + others == len(filled) or 2 * units > len(filled))


def _is_rule(line: str) -> bool:
    """Return whether a line is drawn, below names for example."""
    return set(line) <= _RULE_SIGNS and any(3 * sign in line for sign in "-=_")


def _is_unit_cell(cell: str) -> bool:
    return is_unit(cell.strip("()[] "))


def _are_words(cells: Sequence[str]) -> bool:
    """Return whether every cell of a line is there and is a word: none a number, a unit or empty."""
    return not any(not cell or has_number(cell) or _is_unit_cell(cell) for cell in cells)


def _unit_in(name: str) -> str:
    """Return the last of what stands in brackets that is a unit, else the last that is another scale, else
    the last that is neither an index nor a description, or nothing."""
    _, unit = _quotient(name)
    if unit:
        return unit
    found = _in_brackets(name)
    for fits in (is_unit, is_scale, _is_foreign):
        for text in reversed(found):
            if fits(text):
                return text
    return ""


def _is_foreign(text: str) -> bool:
    return not is_description(text)


def _in_brackets(name: str) -> list[str]:
    return ["".join(each).strip() for each in _IN_BRACKETS.findall(name)]


def _quotient(name: str) -> tuple[str, str]:
    """Return quantity and unit of a name that is a quotient of both, else the name and no unit."""
    quantity, solidus, unit = (part.strip() for part in name.partition("/"))
    unit = unit[1:-1] if unit.startswith("(") and unit.endswith(")") else unit
    return (quantity, unit) if solidus and quantity and is_unit(unit) and not is_unit(name) else (name, "")
