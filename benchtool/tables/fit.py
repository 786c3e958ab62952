"""Delimiter and decimal sign of a table in a text file: those by which most of its cells are numbers."""

from __future__ import annotations

import itertools
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from benchtool.tables.cells import BLANKS, are_numbers, is_number, kind_of_word, plain
from benchtool.tables.head import BAR, has_number, split

_MOST_COLUMNS = 4096
# the first that fits; numbers with decimal commas between commas are in quotation marks
_LAYOUTS = (
    (",", "."),
    (";", "."),
    (";", ","),
    ("\t", "."),
    ("\t", ","),
    (BAR, "."),
    (BAR, ","),
    (BLANKS, "."),
    (BLANKS, ","),
    (",", ","),
)
_SUFFIXES = (1, 2, 4)  # the last 1/n of the lines, in which a long head no longer counts
_MANY = 4.0
_COMPLETE = 0.98  # share of numbers, but for a head
_FEW_COLUMNS = 64
_NOTHING = re.compile("(?!)")


@dataclass(frozen=True)
class Fit:
    """Lines of `width` cells by a `delimiter` and a `decimal` sign; which of the columns are `numeric`.

    `share` of the cells of the sample that are not empty are numbers; the higher the `score` the better.
    """

    delimiter: str
    decimal: str
    width: int
    numeric: tuple[bool, ...]
    score: float
    share: float

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line."""
        return split(line, self.delimiter)

    def is_number(self, cell: str) -> bool:
        """Return whether a cell is a number, in groups of digits where those cannot be columns."""
        return is_number(cell, self.decimal, self.delimiter)

    def is_line_of_row(self, line: str) -> bool:
        """Return whether a line is a row, as `is_row` of its cells."""
        return self._plain_row.fullmatch(line) is not None or self.is_row(self.cells(line))

    @cached_property
    def _plain_row(self) -> re.Pattern[str]:
        """The pattern of a line of nothing but plain numbers, as most are: that takes a part of the time that
        its cells do."""
        if self.delimiter == self.decimal or self.width > _FEW_COLUMNS:  # in quotation marks; long to compile
            return _NOTHING
        between = "[ \\t]+" if self.delimiter == BLANKS else f" *{re.escape(self.delimiter)} *"
        return re.compile(f" *{between.join([plain(self.decimal)] * self.width)} *")

    def is_row(self, cells: Sequence[str]) -> bool:
        """Return whether the cells are a row: at least half numbers; the rest empty or a word in place of
        one."""
        if len(cells) != self.width:
            return False
        wanted = list(itertools.compress(cells, self.numeric))
        numbers = are_numbers(wanted, self.decimal, self.delimiter)
        if all(numbers):
            return True
        fits = (good or kind_of_word(cell) is not None for cell, good in zip(wanted, numbers, strict=True))
        return sum(numbers) >= 0.5 * len(numbers) and all(fits)


def best_fit(sample: Sequence[bytes], stated: str, *, timed: bool) -> Fit | None:
    """Return what fits best; None where no two columns are of numbers, nor one where that is enough.

    Numbers in groups of digits count where not all cells are plain numbers. Blanks that separate groups
    between tabs separate no columns.
    """
    texts = [line.decode(errors="replace") for line in sample]
    layouts = [each for each in _LAYOUTS if stated in ("", each[1])]
    if timed:
        return _best_of_two(texts, layouts)
    # a stated decimal comma separates no columns
    quoted = [each for each in layouts if each[0] != stated or any('"' in text for text in texts)]
    two, one = _best_of_two(texts, quoted), _best_of(texts, quoted, groups=False, fewest=1)
    # two cells in a line of a head that is longer than any other are no table above a column of numbers
    return one if two is None or (one is not None and one.score > _MANY * two.score) else two


def _best_of_two(texts: Sequence[str], layouts: Sequence[tuple[str, str]]) -> Fit | None:
    """Return what fits best with two columns of numbers or more."""
    found = _best_of(texts, layouts, groups=False)
    tabbed = [each for each in layouts if each[0] == "\t"] if found and found.delimiter == BLANKS else []
    if tabbed and 2 * sum("\t" in text for text in texts) > len(texts):
        by_tabs = _best_of(texts, tabbed, groups=True)
        if by_tabs is not None and by_tabs.share > _COMPLETE:
            return by_tabs
    if found is not None and found.share > _COMPLETE:
        return found
    grouped = _best_of(texts, layouts, groups=True)
    return grouped if found is None or (grouped and grouped.score > found.score) else found


def _best_of(
    texts: Sequence[str], layouts: Sequence[tuple[str, str]], *, groups: bool, fewest: int = 2
) -> Fit | None:
    best: Fit | None = None
    of_delimiter = {delimiter: _by_width(texts, delimiter, fewest) for delimiter, _ in layouts}
    for delimiter, decimal in layouts:
        between = delimiter if groups else ""
        of_width = {
            width: [_numbers_and_filled(cells, decimal, between) for cells in columns]
            for width, columns in of_delimiter[delimiter].items()
        }
        for (width, columns), part in itertools.product(of_width.items(), _SUFFIXES):
            begin = -(-len(columns[0][0]) * (part - 1) // part)
            counts = [sum(are[begin:]) for are, _ in columns]
            filled = [sum(some[begin:]) for _, some in columns]
            numeric = tuple(
                count > 0 and count >= some / 2 for count, some in zip(counts, filled, strict=True)
            )
            numbers = sum(count for count, kept in zip(counts, numeric, strict=True) if kept)
            share = numbers / max(1, sum(filled))
            # many numbers, and few cells that are not
            if sum(numeric) >= fewest and numbers * share**2 > (best.score if best else 0.0):
                best = Fit(delimiter, decimal, width, numeric, numbers * share**2, share)
    return best


def _numbers_and_filled(cells: Sequence[str], decimal: str, delimiter: str) -> tuple[list[bool], list[bool]]:
    """Return of each cell of a column whether it is a number, and whether it is that or no word in place of
    one."""
    are = are_numbers(cells, decimal, delimiter)
    if all(are):
        return are, are
    return are, [good or kind_of_word(cell) is None for good, cell in zip(are, cells, strict=True)]


def _by_width(texts: Sequence[str], delimiter: str, fewest: int) -> dict[int, list[tuple[str, ...]]]:
    """Return the columns of lines of so many cells each."""
    found: dict[int, list[list[str]]] = defaultdict(list)
    for text in texts:
        if fewest > 1 and delimiter != BLANKS and delimiter not in text:
            continue
        cells = split(text, delimiter)
        if fewest <= len(cells) <= _MOST_COLUMNS:
            found[len(cells)].append(cells)
    return {width: list(zip(*rows, strict=True)) for width, rows in found.items()}


def almost_a_number(sample: Sequence[bytes]) -> str:
    """Return a cell of the lines that only begins like a number, such as a date; empty if there is none."""
    for line in sample[1:]:
        for delimiter in (",", ";", "\t", BAR, BLANKS):
            cells = split(line.decode(errors="replace"), delimiter)
            for cell in cells if len(cells) > 1 else ():
                if cell[:1].isdigit() and not has_number(cell):
                    return cell[:40]
    return ""
