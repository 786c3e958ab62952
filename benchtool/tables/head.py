"""Head of a table: the lines of names and of units above its numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from benchtool.tables.cells import BLANKS, kind_of_word, plain
from benchtool.tables.stamps import is_stamp
from benchtool.tables.units import is_description, is_scale, is_unit, unit_factor

BAR = "|"
"""A delimiter that may stand at both ends of each line as well."""

_BETWEEN_BARS = re.compile(r"\s*\|(.*)\|\s*")
_BRACKETED = re.compile(r"\(.*\)|\[.*\]")
_IN_BRACKETS = re.compile(
    r"\(([^()]*)\)|\[([^\[\]]*)\]|\{([^{}]*)\}|<([^<>]*)>|[（［〔【]([^（）［］〔〕【】]*)[）］〕】]"
)
_BRACKETS = re.compile(rf"\s*(?:{_IN_BRACKETS.pattern})")
_BRACKETS_AT_END = re.compile(rf"\s*(?:{_IN_BRACKETS.pattern})\s*$")
_RULE_SIGNS = frozenset("-=_+|:~* \t")
_ASSIGNED = re.compile(r"[^=]+=[^=]*")
_OF_ROWS = re.compile(r"(?:[xt#%]|time|zeit|temps|index|samples?)(?:[\W_].*)?", re.IGNORECASE)
_CHANNEL = re.compile(r"[0-9]{1,3}")
_DATE = re.compile(r"[0-9]{1,4}[-/.][0-9]{1,2}[-/.][0-9]{1,4}")
_REMARKS = frozenset(
    (
        "comment",
        "comments",
        "remark",
        "remarks",
        "note",
        "notes",
        "kommentar",
        "bemerkung",
        "commentaire",
        "commento",
    )
)
_TYPE = re.compile(r"(?:u?int|float|real|single|double|number|string|datetime|timestamp|[fiu])_?[0-9]{0,2}")
_STATED_UNIT = re.compile(r"(?:[=:]|\bin)[\s\"']*([^\W\d_][\w°/·^-]+)(?=[\s\"',;.})\]]|$)")
_ON_UNITS = re.compile(r"units?\b|einheit|unité|unidad|unità", re.IGNORECASE)
_WORD = re.compile(r"(?<![\w.,])(?<!\d\s)[^\W\d_][\w°/·^-]*")
_QUOTED_OR_WORD = re.compile(r'"[^"]*"(?!\S)|\S+')
_BLANK = " \r\n\f\v"
_NUMBER = re.compile(f"{plain('.')}|{plain(',')}")
_IN_A_UNIT = re.compile(r"(?:(.+?)\s+)?in\s+(\S+)")
_FEWEST_BEHIND_LABELS = 2  # columns: of one, any setting has a name for it
_ROWS_IN_HEAD = 0.25  # of the rows below the names: more rows above them are data


@dataclass(frozen=True)
class Column:
    """One column: `name` as the head has it (empty without one), `unit` as the head states it, or empty.

    What the name has in brackets is its unit, known or not (`[mA]`, `[counts]`, `[kp cm2]`), but for an index
    or words that describe the column: `Iq[0]` and `i (phase a)` have none. Of a quotient of quantity and unit
    (`t/s`, `n/(1/min)`; ISO 80000-1:2022, 7.1.4), and of `t in ms`, it is the latter. The cells of a
    column with `stamps` are times of day, perhaps with a date, which count in seconds. `open_sign` may be the
    decimal sign, or stand between thousands. `other_name` is what the head has instead of a unit, where that
    may be a name; `aliases` are what further lines of the head call the column. `stated_unit` is what a
    setting in the head says of columns that have no unit by themselves.
    """

    name: str
    unit: str
    stamps: bool = False
    open_sign: str = ""
    other_name: str = ""
    aliases: tuple[str, ...] = ()
    stated_unit: str = ""

    def called(self, name: str) -> Column:
        """Return the column by its other name, if `name` is that."""
        if name.strip() in self.aliases:
            return replace(self, name=name.strip())
        if not self.other_name or name.strip().lower() != self.other_name.lower():
            return self
        unit = self.other_name if _is_unit_cell(self.other_name) else _unit_in(self.other_name)
        return replace(self, name=self.other_name, unit=unit, other_name="")

    def also_called(self, names: Iterable[str]) -> Column:
        """Return the column with further names that other lines of the head have for it."""
        known = (self.name, self.other_name, *self.aliases)
        return replace(self, aliases=(*self.aliases, *(each for each in names if each not in known)))

    @property
    def bare_name(self) -> str:
        """The name without the unit behind it."""
        quantity, unit = _quotient(self.name)
        return quantity if unit else _BRACKETS.sub("", self.name).strip() or self.name

    @property
    def name_before_brackets(self) -> str:
        """The name without the last of its brackets, if it ends in one: `r69[0] I_a [A]` is `r69[0] I_a`."""
        return _BRACKETS_AT_END.sub("", self.name).strip() or self.name

    @property
    def in_brackets(self) -> str:
        """What stands in the last brackets of the name, or nothing."""
        return next(reversed(_in_brackets(self.name)), "")


def is_comment(line: bytes) -> bool:
    return line.lstrip()[:1] in (b"#", b"%")


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the blanks about them."""
    if delimiter == BLANKS:
        return [cell.strip('"') for cell in _QUOTED_OR_WORD.findall(line)] if '"' in line else line.split()
    if delimiter == BAR and (match := _BETWEEN_BARS.fullmatch(line)):
        line = match[1]
    if '"' in line:
        try:
            return [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]
        except csv.Error:
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def columns_of(
    preamble: Sequence[str], delimiter: str, used: int, width: int, *, is_labelled: bool = False
) -> tuple[Column, ...]:
    """Return the names and units from the lines before the numbers; none where no line fits.

    A line fits that has a cell for each of the `used` first columns, or for all of `width`, or that has more
    of which no column is asked for (`fitted`), and no cell that is a value, a date or a time. Lines right
    above each other that fit are one head.

    Of two lines right above each other the second holds units if most of it are units, or if any is
    and the first is one of words alone; it may then hold other names. Units may also stand above names of
    words alone, or names, units and one more line of words, as of the sensors. What a further line of single
    words has is another name. Lines that say the same of several columns, as of a module or a data type, are
    left out where another one tells them apart. Where the first cell of each row is empty, and so that of
    the head labels its lines (`is_labelled`), they need not be next to each other, nor where the lines have
    labels in a cell that no row has.
    """
    found = _lines_of_names(preamble, delimiter, used, width, is_labelled=is_labelled)
    if not found:
        return _behind_labels(preamble, delimiter, used, width)
    if is_labelled:
        return _labelled(found)
    found = [_without_label(line) for line in found]
    others = [line for line in found if _are_plain(line) and not are_units(line)]
    return tuple(
        column.also_called(line[place] for line in others) for place, column in enumerate(_columns(found))
    )


def _behind_labels(preamble: Sequence[str], delimiter: str, used: int, width: int) -> tuple[Column, ...]:
    """Return the columns of a head whose lines begin with labels that the rows have no cell for
    (`Channel:,t,I_a`), none if it has no such lines: a cell more may be a comma within a name, so that either
    the label has a colon or one of the lines has units behind it."""
    if used < _FEWEST_BEHIND_LABELS:
        return ()
    found = _lines_of_names(preamble, delimiter, used + 1, width + 1, is_labelled=True)
    found = [line for line in found if _WORD.match(line[0]) and not _is_unit_cell(line[0])]
    has_units = any(are_units(line[1:]) for line in found)
    return _labelled([line for line in found if has_units or line[0].endswith(":")])[1:]


def _without_label(cells: list[str]) -> list[str]:
    """Return a line of units without the label that it begins with, as `Vertical Units,V,A`."""
    label = cells[0].removesuffix(":")
    is_label = ":" not in label and _ON_UNITS.search(label) is not None and are_units(cells[1:])
    return ["", *cells[1:]] if is_label else cells


def _columns(found: Sequence[list[str]]) -> tuple[Column, ...]:
    """Return the columns that lines of names and units name, the last line first."""
    found = _without_descriptions(found)
    is_names_below = len(found) > 1 and are_units(found[1]) and _are_bare_words(found[0])
    if is_names_below and len(found) > 2 and _are_names(found[2]):
        return tuple(
            Column(name, unit.strip("()[] "), aliases=(alias,) if alias else ())
            for alias, unit, name in zip(*found[:3], strict=True)
        )
    if is_names_below and not are_units(found[0]):
        return _named(found[0], found[1], [])
    has_units = any(map(_is_unit_cell, found[0]))
    if len(found) > 1 and are_units(found[0]):
        return _named(found[1], found[0], found[2:3])
    if len(found) > 1 and has_units and _are_words(found[1]):
        return tuple(
            Column(name, unit.strip("()[] "), other_name=unit)
            for name, unit in zip(found[1], found[0], strict=True)
        )
    return tuple(Column(name, _unit_in(name).strip("()[] ")) for name in found[0])


def _named(names: Sequence[str], units: Sequence[str], others: Sequence[Sequence[str]]) -> tuple[Column, ...]:
    """Return columns by their names and units, and other lines that name them as well, as does a word among
    the units."""
    # a title with commas is none
    lines = list(filter(_are_plain, others))
    return tuple(
        Column(
            name,
            unit.strip("()[] "),
            other_name="" if _is_unit_cell(unit) or _BRACKETED.fullmatch(unit) else unit,
            aliases=tuple(line[place] for line in lines if line[place]),
        )
        for place, (name, unit) in enumerate(zip(names, units, strict=True))
    )


def _are_plain(cells: Sequence[str]) -> bool:
    """Return whether a line has one word for each column, none a number."""
    return all(each and " " not in each and not has_number(each) for each in cells)


def _without_descriptions(found: Sequence[list[str]]) -> list[list[str]]:
    """Return lines without those that say the same of several columns, or of which data type each is, if any
    other names them."""
    kept = [line for line in found if are_units(line) or not (_are_repeated(line) or _are_types(line))]
    return kept if any(not are_units(line) and _are_names(line) for line in kept) else list(found)


def _are_repeated(cells: Sequence[str]) -> bool:
    filled = [cell for cell in cells if cell]
    return len(set(filled)) < len(filled)


def _are_types(cells: Sequence[str]) -> bool:
    return all(_TYPE.fullmatch(cell.lower()) for cell in cells if cell)


def _lines_of_names(
    preamble: Sequence[str], delimiter: str, used: int, width: int, *, is_labelled: bool
) -> list[list[str]]:
    """Return the cells of the lines that may have names or units of the columns, the last line first, or
    those of a line of nothing but numbers if there are no other ones.

    A label and numbers beneath a line of names are a setting (`scale,2,1`); without one above they are names.
    """
    found: list[list[str]] = []
    numbers: list[list[str]] = []
    lengths_of_values: set[int] = set()
    for line in reversed(preamble):
        if not line.strip() or _is_rule(line.strip()):
            continue
        cells = _fitted_to(bare_line(line), delimiter, used, width, lengths_of_values)
        if cells is not None and not cells[0] and is_comment(line.encode()):
            cells[0] = line.lstrip()[0]  # the sign is a name: #,t,i
        if cells is not None and not _are_values(cells[:used]):
            (numbers if all(has_number(cell) for cell in cells if cell) else found).append(cells)
        elif cells is not None and found and all(map(_is_setting, (cells, *found))):
            continue
        elif (found or numbers) and not is_labelled:
            break
    names = (place for place, cells in enumerate(found) if _are_names(cells) and not are_units(cells))
    above = 0 if is_labelled else next(names, 0)
    return [each for place, each in enumerate(found) if place >= above or not _is_setting(each)] or numbers[
        :1
    ]


def _fitted_to(
    line: str, delimiter: str, used: int, width: int, lengths_of_values: set[int]
) -> list[str] | None:
    """Return the cells of a head line, `width` of them, or None where it does not fit.

    Cells at its end that no row has are left out where they name no column: they are empty, numbers,
    assignments (`tInc = 1e-4`), stand above numbers (`Increment`), or name a column of remarks, which most
    rows end before. `lengths_of_values` are how many cells lines have that end in numbers, to which this one
    is added.
    """
    for count in (used, width):
        cells = fitted(line, delimiter, count)
        if cells is not None:
            return cells + [""] * (width - count)
    cells = split(line, delimiter)
    while cells and not cells[-1]:
        del cells[-1]
    further = [cell for cell in cells[used:] if cell]
    is_above = len(cells) in lengths_of_values
    are_numbers = all(has_number(cell) or _ASSIGNED.fullmatch(cell) for cell in further)
    if further and any(cells[:used]):
        if are_numbers:
            lengths_of_values.add(len(cells))
        if are_numbers or is_above or all(cell.lower() in _REMARKS for cell in further):
            return cells[:used] + [""] * (width - used)
    return None


def _labelled(found: Sequence[Sequence[str]]) -> tuple[Column, ...]:
    """Return the columns of a head whose first cells are labels of its lines, the last line first.

    Of two lines of units one of times alone is that of the rows' distance.
    """
    units = [line for line in found if are_units(line[1:])]
    units = [line for line in units if not _are_times(line[1:])] or units
    of_columns = [" or ".join(dict.fromkeys(filter(None, cells))) for cells in zip(*units, strict=True)]
    names = [line for line in found if not are_units(line[1:]) and _are_names(line[1:])]
    distinct = [line for line in names if len(set(line[1:])) == len(line[1:])]
    if not names:
        return ()
    name_line = (distinct or names)[0]
    return tuple(
        Column(
            name,
            (of_columns[place].strip("()[] ") if place and of_columns else "") or _unit_in(name),
            aliases=tuple(line[place] for line in names if line is not name_line and line[place] and place),
        )
        for place, name in enumerate(name_line)
    )


def units_in(preamble: Sequence[str], delimiter: str) -> tuple[str, ...]:
    """Return the units in brackets, in cells of their own, behind a sign (`unit=mA`, `Y-Unit: mA`) or the
    word `in`, and anywhere in a line that names units, of all lines beside the numbers; what is behind a
    number is that of a setting."""
    found: dict[str, None] = {}
    for line in preamble:
        texts = [
            *_in_brackets(line),
            *(cell.strip("()[]{}<> ") for cell in split(bare_line(line), delimiter)),
            *_STATED_UNIT.findall(line),
        ]
        if _ON_UNITS.search(line):
            texts += [each for each in _WORD.findall(line) if len(each) > 1]
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
    return is_stamp(cell) if ":" in cell else _NUMBER.fullmatch(cell) is not None


def bare_line(line: str) -> str:
    """Return a line without the sign of a comment before it; tabs separate cells, which may be empty."""
    return line.strip(_BLANK).lstrip("#%").strip(_BLANK)


def fitted(line: str, delimiter: str, width: int) -> list[str] | None:
    """Return the cells of a head line, one for each column, or None; its delimiter may not be the body's."""
    ways = [
        split(line, delimiter),
        split(line.strip(), delimiter),
        *(split(line, other) for other in ",;\t|"),
        re.split(r"\s{2,}|\t", line),
    ]
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


def _are_values(cells: Sequence[str]) -> bool:
    """Return whether a line has a value, a date or a time: what names a column is a word, or a whole number
    of few digits that no other column has."""
    numbers = [cell for cell in cells if has_number(cell)]
    are_counted = all(_CHANNEL.fullmatch(cell) for cell in numbers) and len(set(numbers)) == len(numbers)
    return not are_counted or any(_DATE.fullmatch(cell) or is_stamp(cell) for cell in cells)


def _is_setting(cells: Sequence[str]) -> bool:
    """Return whether a line may be a label and the numbers that it states of the other columns; behind the
    name of a time or an axis they are names."""
    is_label = bool(cells[0]) and not has_number(cells[0]) and _OF_ROWS.fullmatch(cells[0]) is None
    return is_label and any(cells[1:]) and all(has_number(cell) for cell in cells[1:] if cell)


def _are_names(cells: Sequence[str]) -> bool:
    """Return whether a line of words has a name for more than half of the columns, none a number."""
    filled = [cell for cell in cells if cell]
    return 2 * len(filled) > len(cells) and not any(map(has_number, filled))


def _are_bare_words(cells: Sequence[str]) -> bool:
    """Return whether no cell of a line has a unit, by itself or in brackets."""
    return not any(_is_unit_cell(cell) or _unit_in(cell) for cell in cells)


def _are_times(cells: Sequence[str]) -> bool:
    return all(unit_factor(cell.strip("()[] "), "s") is not None for cell in cells if cell)


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
    """Return what stands in brackets, that of `in mA` without the preposition."""
    texts = ["".join(each).strip() for each in _IN_BRACKETS.findall(name)]
    matches = [_IN_A_UNIT.fullmatch(text) for text in texts]
    return [
        match[2] if match is not None and not match[1] and is_unit(match[2]) else text
        for text, match in zip(texts, matches, strict=True)
    ]


def _quotient(name: str) -> tuple[str, str]:
    """Return quantity and unit of a name that is a quotient of both, or that is the one in the other (`C1 in
    mA`), else the name and no unit."""
    if (match := _IN_A_UNIT.fullmatch(name.strip())) and is_unit(match[2]):
        return match[1] or name.strip(), match[2]
    *before, last = re.split(r"[_\s]+", name.strip())
    if before and "/" in last and is_unit(last):  # n_1/min, omega rad/s
        return name, ""
    of, _, per = last.partition("/")
    if before and len(of) > 1 and is_unit(of) and is_unit(per):  # a rate: torque Nm/s; of phase A/V it is V
        return name.strip().removesuffix(last).rstrip("_ "), last
    quantity, solidus, unit = (part.strip() for part in name.partition("/"))
    unit = unit[1:-1] if unit.startswith("(") and unit.endswith(")") else unit
    return (quantity, unit) if solidus and quantity and is_unit(unit) and not is_unit(name) else (name, "")
