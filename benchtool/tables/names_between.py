"""Lines of names between the rows of a table, as of a second table below the first."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

from benchtool.tables.cells import kind_of_word
from benchtool.tables.head import bare_line, fitted, has_number, is_comment
from benchtool.tables.text import Rows, TextTable

_WORDS = re.compile(rb'^[ \t"|\[(]*[A-Za-z_\x80-\xff].*$', re.MULTILINE)
_COMMENT = re.compile(rb"^[ \t]*[#%].*$", re.MULTILINE)
_MOST_LINES = 10_000  # that are looked at: where a column of words comes first, every row begins like names


@dataclass(frozen=True)
class Names:
    """A line of names: its `text`, its number in the file, from 1, and the row that it is or is above, as
    `Rows.place` counts them."""

    text: str
    line: int
    place: int


def names_between(table: TextTable, rows: Rows) -> tuple[Names, ...]:
    """Return the lines between the first row and the last that name the columns, those right below each other
    once.

    It is the head again, perhaps as a comment, or another line of words alone, one for each column.
    """
    if not len(rows.place):
        return ()
    body, found = table.text[table.layout.begin :], list[Names]()
    place, line, counted, last = 0, table.layout.head_lines + 1, 0, 0
    for begin, text in _lines_of_names(table, body, has_words=bool(rows.dropped)):
        passed = body[counted:begin]
        inner = [each for each in passed.split(b"\n") if each.strip() and not is_comment(each)]
        place, line, counted = place + len(inner), line + passed.count(b"\n"), begin
        if line != last + 1 and rows.place[0] < place <= rows.place[-1]:
            found.append(Names(text, line, place))
        last = line
    return tuple(found)


def _lines_of_names(table: TextTable, body: bytes, *, has_words: bool) -> Iterator[tuple[int, str]]:
    """Yield where in the text below the head a line of names begins, and the line."""
    names = [column.name for column in table.layout.columns]
    patterns = [_COMMENT] if b"#" in body or b"%" in body else []
    patterns += [_WORDS] if has_words else []
    matches = itertools.chain.from_iterable(
        itertools.islice(pattern.finditer(body), _MOST_LINES) for pattern in patterns
    )
    for match in sorted(matches, key=re.Match.start):
        text = bare_line(match[0].decode(errors="replace"))
        cells = fitted(text, table.layout.delimiter, len(names))
        if cells is None:
            continue
        are_words = len(cells) > 1 and not is_comment(match[0]) and all(map(_is_word, cells))
        if are_words or (any(names) and cells == names):
            yield match.start(), text[:40]


def _is_word(cell: str) -> bool:
    return bool(cell) and not has_number(cell) and kind_of_word(cell) is None
