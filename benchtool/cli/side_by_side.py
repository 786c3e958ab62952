"""Several cases, runs or quantities beside each other in the terminal: as many as a line has room for, the
others in further tables below, so that a value and its uncertainty are never broken."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.text import Text

from benchtool.cli.fitting import broken
from benchtool.cli.output import Output
from benchtool.cli.table_layout import SEPARATOR

_NAME = 24  # cells that names need; longer ones are broken
_HEADING = 10  # narrower than this no heading is broken

Cell = str | Text


@dataclass(frozen=True)
class Column:
    """A column: its heading, which begins with `>` where cells are right-aligned, and a cell for each row."""

    heading: str
    cells: tuple[Cell, ...]

    @property
    def width(self) -> int:
        """Cells that it needs, where the heading may be broken as long as it is wider than what is below."""
        widest = max((cell_len(str(cell)) for cell in self.cells), default=0)
        heading = broken(self.heading.removeprefix(">"), max(widest, _HEADING))
        return max(widest, *(cell_len(line) for line in heading.split("\n")))

    @property
    def fitted(self) -> str:
        """The heading in lines no wider than the column."""
        name = self.heading.removeprefix(">")
        return f"{'>' if name != self.heading else ''}{broken(name, self.width)}"


def show_beside(
    output: Output,
    title: str,
    first: Sequence[Column],
    groups: Sequence[Sequence[Column]],
    last: Sequence[Column] = (),
) -> None:
    """Print groups of columns between the first columns, which begin with the names of the rows, and the
    last, a group always whole.

    The first and the last columns stand in each of the tables that the groups take.
    """
    names, *beside = first
    ends = sum(column.width + SEPARATOR for column in (*beside, *last))
    room = output.width - min(names.width, _NAME) - ends
    for place, columns in enumerate(_tables(groups, room)):
        shown = [*first, *columns, *last]
        rows = list(zip(*(column.cells for column in shown), strict=True))
        heading = title if place == 0 else f"{title} (continued)"
        output.table(heading, tuple(column.fitted for column in shown), rows)


def _tables(groups: Sequence[Sequence[Column]], room: int) -> Iterator[list[Column]]:
    """Yield the columns of each table, of as few tables as the widest group allows, which are as wide as each
    other."""
    widest = max((sum(column.width + SEPARATOR for column in group) for group in groups), default=1)
    most = max(1, room // widest)
    count = math.ceil(len(groups) / most)
    each, larger = divmod(len(groups), max(1, count))
    remaining = iter(groups)
    for place in range(count):
        taken = itertools.islice(remaining, each + (place < larger))
        yield [column for group in taken for column in group]
