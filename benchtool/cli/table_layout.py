"""Columns of a table on a terminal: words give way first, then headings and names, numbers never; columns
that have no room stand in a further table below."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum

from rich.cells import cell_len

from benchtool.cli.fitting import longest_part

SEPARATOR = 3  # cells between columns
RIGHT = ">"  # begins the heading of a column of numbers, which are right-aligned
_ENOUGH_WORDS = 24  # cells of a column of words that is read easily
_LEAST_NAME = 12


class _Step(IntEnum):
    """What has given way so far."""

    NOTHING = 0
    LONG_TEXTS = 1
    HEADINGS = 2
    WORDS = 3
    NAMES = 4


@dataclass(frozen=True)
class Shown:
    """A table that fits: the `places` of its columns among all, and how wide each is."""

    places: tuple[int, ...]
    widths: tuple[int, ...]


@dataclass(frozen=True)
class _Column:
    """Texts of a column, its heading first; the first column of a table has names, a column of numbers a
    heading that begins with `>`."""

    place: int
    texts: tuple[str, ...]

    @property
    def is_of_numbers(self) -> bool:
        return self.texts[0].startswith(RIGHT)

    @property
    def widths(self) -> tuple[int, ...]:
        """How wide it has to be after each step."""
        heading, *cells = self.texts
        heading = heading.removeprefix(RIGHT)
        natural = max(cell_len(line) for text in (heading, *cells) for line in text.split("\n"))
        if self.is_of_numbers:
            widest = max((cell_len(line) for text in cells for line in text.split("\n")), default=0)
            least = max(widest, longest_part(heading, within_names=True))
            return (natural, natural, least, least, least)
        least = max(longest_part(text, within_names=True) for text in (heading, *cells))
        if self.place == 0:
            words = max(longest_part(text, within_names=False) for text in (heading, *cells))
            some = max(words, min(natural, _ENOUGH_WORDS))
            return (natural, natural, natural, some, max(least, min(words, _LEAST_NAME)))
        some = max(least, min(natural, _ENOUGH_WORDS))
        return (natural, some, some, least, least)


def tables(columns: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> Iterator[Shown]:
    """Yield the tables that columns with these headings take on a terminal of `width` cells, each with the
    first column; names give way in the last one, rather than that there are more."""
    texts = zip(columns, *rows, strict=True)
    first, *others = (_Column(place, tuple(each)) for place, each in enumerate(texts))
    rest = _fitted([first, *others], width)
    while others and rest is None:
        taken, shown = 1, _fitted([first, others[0]], width) or _too_wide([first, others[0]], width)
        while taken < len(others):
            more = _fitted([first, *others[: taken + 1]], width, _Step.WORDS)
            if more is None:
                break
            taken, shown = taken + 1, more
        yield shown
        others = others[taken:]
        rest = _fitted([first, *others], width) if others else None
    if rest is not None:
        yield rest


def _fitted(columns: Sequence[_Column], width: int, last: _Step = _Step.NAMES) -> Shown | None:
    """Return the widths of columns after as few steps as fit, the last of which gives way no further than
    needed; None where they do not fit."""
    room = width - SEPARATOR * (len(columns) - 1)
    needed = [column.widths for column in columns]
    for step in _Step:
        least = [each[step] for each in needed]
        if step <= last and sum(least) <= room:
            before = [each[max(0, step - 1)] for each in needed]
            widths = _widened(least, before, room)
            return Shown(tuple(column.place for column in columns), tuple(widths))
    return None


def _widened(least: Sequence[int], most: Sequence[int], room: int) -> list[int]:
    """Return widths from `least` to `most` that fill the room, those that are narrowest widened first."""
    widths = list(least)
    for _ in range(room - sum(widths)):
        narrow = [place for place, wide in enumerate(widths) if wide < most[place]]
        if not narrow:
            break
        widths[min(narrow, key=lambda place: widths[place])] += 1
    return widths


def _too_wide(columns: Sequence[_Column], width: int) -> Shown:
    """Return the widths of two columns that do not fit: the one of words takes what is left, and has its
    words cut."""
    first, other = (column.widths[_Step.NAMES] for column in columns)
    if not columns[1].is_of_numbers:
        first = min(first, max(_LEAST_NAME, width // 2))
        other = max(_LEAST_NAME, width - SEPARATOR - first)
    return Shown(tuple(column.place for column in columns), (first, other))
