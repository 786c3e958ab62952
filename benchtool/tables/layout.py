"""Layout of a table in a text file: where its rows begin, and what the head above them says."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from benchtool.errors import NoSuchRecording, RecordingError
from benchtool.tables.cells import is_no_name, kind_of_word
from benchtool.tables.first_rows import ROWS, lines_of_head
from benchtool.tables.fit import Fit, almost_a_number, best_fit
from benchtool.tables.grouping import Use, use_of
from benchtool.tables.head import (
    Column,
    are_units,
    bare_line,
    columns_of,
    has_number,
    is_comment,
    rows_below_names,
    split,
    units_in,
)
from benchtool.tables.long_form import signal_column
from benchtool.tables.settings import RowDistance, row_distance, settings_of, with_stated_units
from benchtool.tables.stamps import is_stamp
from benchtool.tables.units import is_unit

_HEAD_BYTES = 256 * 1024
_SAMPLE_BYTES = 32 * 1024
_WHOLE = re.compile(r"[0-9]+")
_FACTORS = re.compile(
    r"\W*(?:(?:scal(?:e|ing)|conversion|calibration)?[ _]?(?:fa[ck]t(?:eu|o)r(?:s|en)?|gains?|multipliers?)"
    r"|scal(?:e|ing)|slope|sensitivity|skalierung|verstärkung|empfindlichkeit)\W*",
    re.IGNORECASE,
)
_OFFSETS = re.compile(r"\W*(?:offsets?|bias|versatz|nullpunkt)\W*", re.IGNORECASE)
_ZEROS_FIRST = re.compile(r"0[0-9]+")
_FEW = 0.05  # of the cells of a column


@dataclass(frozen=True)
class Layout:
    """Numbers begin at byte `begin`, after `head_lines` lines; `delimiter` is one character, or `BLANKS`.

    `head` is the line nearest the numbers that is neither blank nor a comment where no line names the
    columns. Where `is_open`, the sample has the decimal sign, or the other one, only where one between
    thousands might be. `head_units` are all units in the head, whether of a column or not, and those of two
    letters or more in cells beside and below the numbers. `head_numbers` is the last line of numbers right
    above the rows that was taken for one of the head.
    `signals` is the number of a column, from 1, that says which signal each row has, 0 without one;
    `is_number_first` is whether the first column is one of numbers. `head_factors` are the lines of the
    head that by their first cells state factors or offsets, but for `head_numbers`, `row_distance` what it
    states of the distance of rows in time.
    """

    delimiter: str
    decimal: str
    columns: tuple[Column, ...]
    head_lines: int
    begin: int
    head: str = ""
    is_open: bool = False
    head_units: tuple[str, ...] = ()
    head_numbers: str = ""
    signals: int = 0
    is_number_first: bool = False
    head_factors: tuple[str, ...] = ()
    row_distance: RowDistance | None = None

    def with_units(self, units: Sequence[str]) -> Layout:
        """Return the layout with the units that stand in the cells of its columns, in place of the head's."""
        if len(units) != len(self.columns):
            return self
        named = zip(self.columns, units, strict=True)
        return replace(self, columns=tuple(replace(each, unit=unit or each.unit) for each, unit in named))


def find_layout(text: bytes, source: str, decimal: str = "", *, timed: bool = True) -> Layout:
    """Return the layout of a table in UTF-8, lines ended by newlines; `source` stands in the messages.

    A table has two columns of numbers at least; one is enough where its rows are not `timed` by a column.

    The delimiter and the decimal sign, if that is not stated, are those by which most cells of most lines,
    sampled from the beginning, the middle and the end, are numbers. What comes before the first such line is
    the head: the line of it nearest the numbers that has a name for each column names them, and of two such
    lines the second may hold their units. Lines right above the numbers that have one in a column of numbers,
    or nothing but words that stand in place of one (OVER, --), are rows as well. Where no line above the
    first numbers names columns and one below a few of them does, those few belong to the head as well. Lines
    that begin with # or % are comments, which may name the columns too.

    Raises:
        RecordingError: no such columns of numbers are there, or the delimiter separates decimals as well.
    """
    head = text[:_HEAD_BYTES]
    lines = head.split(b"\n")
    if len(text) > len(head):
        del lines[-1]  # cut short
    sample = [line for line in _sampled(text, lines) if line.strip() and not is_comment(line)]
    fit = best_fit(sample, decimal, timed=timed)
    if fit is None:
        seen = almost_a_number(sample)
        fewest = "at least two numbers" if timed else "numbers"
        raise NoSuchRecording(
            f"{source}: no table of numbers found{seen and f', {seen!r} is none'}; lines of {fewest} "
            f"are expected, separated by comma, semicolon, tab, | or blanks, times in seconds or as "
            f"2026-01-31 23:59:59.5: export it as such"
        )
    sampled = [line.decode(errors="replace") for line in sample]
    cells_of = [fit.cells(line) for line in sampled]
    by_column = list(zip(*(cells for cells in cells_of if len(cells) == fit.width), strict=True))
    texts = [line.decode(errors="replace") for line in lines]
    rows = _rows(lines, texts, fit, by_column)
    if not any(rows):
        raise RecordingError(
            f"{source}: no line of numbers within the first {len(head)} bytes, a head of a few lines is "
            f"expected: cut the head"
        )
    are_rows = [fit.is_line_of_row(line) for line in sampled]
    in_rows = list(itertools.compress(cells_of, are_rows))
    above = _head(texts, rows, fit, in_rows)
    in_head = texts[: above.lines]
    last = "" if above.columns else _last_of(in_head)
    if not above.columns and fit.delimiter == "," and all(map(_is_whole, by_column)):
        is_one = fit.width == 2 and any(map(_ZEROS_FIRST.fullmatch, by_column[1]))
        if is_one and not timed and not decimal:
            return find_layout(text, source, ",", timed=timed)
        _require_no_split_decimals(last, texts[above.lines], by_column, source)
    named = (*above.columns, *(Column("", "") for _ in range(fit.width - len(above.columns))))
    filled = _filled(by_column, fit)
    stating = [bare_line(line) for line in (*in_head, *_settings_aside(cells_of, filled, fit))]
    settings = settings_of(stating, fit.delimiter)
    named = with_stated_units(named, settings, filled)
    words = _aside(cells_of, are_rows, fit)
    comments = [line.decode(errors="replace") for line in _sampled(text, lines) if is_comment(line)]
    units = (*units_in([*in_head, *comments], fit.delimiter), *filter(is_unit, words))
    if any("max" in each.lower() for each in (*in_head, *words)):
        units = tuple(each for each in units if each.lower() != "min")  # the least value, and no minute
    return Layout(
        fit.delimiter,
        fit.decimal,
        tuple(
            Column(each.name, "s", stamps=True) if _is_stamped(cells) else each
            for each, cells in zip(named, by_column, strict=True)
        ),
        above.lines,
        begin=sum(len(line) + 1 for line in lines[: above.lines]),
        head=last,
        is_open=_is_open(fit, by_column),
        head_units=tuple(dict.fromkeys(units)),
        head_numbers=above.numbers,
        signals=signal_column(in_rows, fit.numeric),
        is_number_first=fit.numeric[0],
        row_distance=row_distance(settings, stating, fit.delimiter),
        head_factors=tuple(
            line
            for line in in_head
            if bare_line(line)[:80] != above.numbers and _are_factors(split(line, fit.delimiter))
        ),
    )


def _sampled(text: bytes, head: Sequence[bytes]) -> Iterator[bytes]:
    yield from head[:1000]
    yield from head[max(1000, len(head) - 500) :]
    if len(text) > _HEAD_BYTES:
        for begin in (len(text) // 2, len(text) - _SAMPLE_BYTES):
            yield from text[begin : begin + _SAMPLE_BYTES].split(b"\n")[1:-1]


def _rows(
    lines: Sequence[bytes], texts: Sequence[str], fit: Fit, by_column: Sequence[Sequence[str]]
) -> list[bool]:
    """Return which lines are rows: those that fit, and the ones right above that have a number in a column
    of numbers; `by_column` are the cells of the sample."""
    rows = [
        not is_comment(line) and fit.is_line_of_row(text) for line, text in zip(lines, texts, strict=True)
    ]
    whole = [_is_whole(cells) for cells in by_column]
    filled = _filled(by_column, fit)
    first = rows.index(True) if any(rows) else 0
    for place in range(first - 1, -1, -1):
        cells = [] if is_comment(lines[place]) else fit.cells(texts[place])
        if not _is_first_row(cells, fit, filled, whole):
            break
        rows[place] = True
    return rows


@dataclass(frozen=True)
class _Head:
    """What stands above the rows: so many `lines`, the `columns` that they name, and the last one of
    `numbers`, if any was taken for a row at first."""

    lines: int
    columns: tuple[Column, ...]
    numbers: str = ""


def _head(texts: Sequence[str], rows: list[bool], fit: Fit, in_rows: Sequence[Sequence[str]]) -> _Head:
    """Return the head above `rows`, which are marked among the lines; `in_rows` are cells of sampled rows."""
    # columns at the end that are empty in every row are delimiters that end a line
    used = max(
        (number for cells in in_rows for number, cell in enumerate(cells, 1) if cell), default=fit.width
    )
    # a first column that is empty in the rows has the labels of lines of the head
    is_labelled = not fit.numeric[0] and 2 * sum(not cells[0] for cells in in_rows) > len(in_rows)
    if is_labelled:
        rows = _below_labels(texts, rows, fit)
    places = [place for place, is_row in enumerate(rows) if is_row][: ROWS + 3]
    first = [fit.cells(texts[place]) for place in places]
    above = [*texts[: places[0]]]
    if places[0] and _is_without_names_of_rows(above[-1], first, fit):
        above[-1] = f'""{fit.delimiter}{above[-1].strip()}'
    found = _Head(places[0], columns_of(above, fit.delimiter, used, fit.width, is_labelled=is_labelled))
    if not found.columns and (below := rows_below_names(texts, rows, fit.delimiter, fit.numeric)):
        found = _Head(below, columns_of(texts[:below], fit.delimiter, used, fit.width))
    if found.lines == places[0] and (count := lines_of_head(first, fit.numeric, fit.decimal, fit.delimiter)):
        # one with a label where the rows have nothing is of the head by that
        has_label = is_labelled and first[count - 1][0] and not first[count][0]
        lines, numbers = places[count], "" if has_label else bare_line(texts[places[count - 1]])[:80]
        columns = columns_of(texts[:lines], fit.delimiter, used, fit.width, is_labelled=is_labelled)
        return _Head(lines, columns, numbers)
    return found


def _is_without_names_of_rows(line: str, rows: Sequence[Sequence[str]], fit: Fit) -> bool:
    """Return whether a head has a cell less than rows that begin with their number, from 0 or 1 on, as R
    writes it."""
    counts = [cells[0].strip('"') for cells in rows]
    is_counted = any(counts == [str(place + start) for place in range(len(rows))] for start in (0, 1))
    cells = fit.cells(bare_line(line))
    return is_counted and len(rows) > 1 and len(cells) == fit.width - 1 and not any(map(has_number, cells))


def _is_open(fit: Fit, by_column: Sequence[Sequence[str]]) -> bool:
    """Return whether the decimal sign, or the other one, stands only where one between thousands might."""
    kept = list(itertools.compress(by_column, fit.numeric))
    other = "." if fit.decimal == "," else ","
    own = max(use_of(fit.decimal, cells) for cells in kept)
    return Use.NOTHING < own < Use.DECIMALS or any(use_of(other, cells) == Use.EITHER for cells in kept)


def _filled(by_column: Sequence[Sequence[str]], fit: Fit) -> tuple[bool, ...]:
    """Return which columns are filled with numbers: a few in a column are those of the head."""
    return tuple(
        kept and 2 * sum(map(bool, cells)) > len(cells)
        for cells, kept in zip(by_column, fit.numeric, strict=True)
    )


def _settings_aside(sample: Sequence[Sequence[str]], filled: Sequence[bool], fit: Fit) -> Iterator[str]:
    """Yield what stands before the first column of numbers of a row, as of an oscilloscope that writes its
    settings beside them."""
    first = filled.index(True) if any(filled) else 0
    for cells in sample:
        if first > 1 and cells[0] and not has_number(cells[0]):
            yield fit.delimiter.join(cells[:first])


def _aside(sample: Sequence[Sequence[str]], are_rows: Sequence[bool], fit: Fit) -> dict[str, None]:
    """Return what stands in the lines of a sample beside the numbers of a row, and in lines that are none;
    letters alone are left out."""
    found: dict[str, None] = {}
    for cells, is_row in zip(sample, are_rows, strict=True):
        words = (cell for place, cell in enumerate(cells) if not (is_row and fit.numeric[place]))
        found |= dict.fromkeys(bare for word in words if len(bare := word.strip("()[]{}<> ")) > 1)
    return found


def _is_first_row(cells: Sequence[str], fit: Fit, filled: Sequence[bool], whole: Sequence[bool]) -> bool:
    """Return whether cells above the rows are a row as well: a number in a column that is `filled` with
    numbers, or nothing but words in place of numbers.

    The numbers of channels (`t,1,2`) are whole above others that are not, and names of columns.
    """
    if len(cells) != fit.width or are_units(cells):
        return False
    wanted = list(itertools.compress(zip(cells, whole, strict=True), filled))
    numbers = [(cell, is_whole) for cell, is_whole in wanted if fit.is_number(cell)]
    if not numbers:
        return any(cell for cell, _ in wanted) and all(is_no_name(cell) for cell, _ in wanted)
    words = any(cell and kind_of_word(cell) is None for cell, _ in wanted if not has_number(cell))
    return not (words and all(_WHOLE.fullmatch(cell) and not is_whole for cell, is_whole in numbers))


def _below_labels(texts: Sequence[str], rows: Sequence[bool], fit: Fit) -> list[bool]:
    """Return which lines are rows: of those with a label in the first cell only the ones right above the rows
    without, as of an oscilloscope that writes its settings beside them."""
    bare = [is_row and not fit.cells(text)[0] for is_row, text in zip(rows, texts, strict=True)]
    first = bare.index(True) if any(bare) else 0
    others = [place for place in range(first) if not rows[place] and texts[place].strip()]
    return [is_row and place > max(others, default=-1) for place, is_row in enumerate(rows)]


def _is_whole(cells: Sequence[str]) -> bool:
    """Return whether the numbers of a column are whole, but for few."""
    numbers = [cell for cell in cells if has_number(cell)]
    return sum(_WHOLE.fullmatch(cell.lstrip("+-")) is None for cell in numbers) <= _FEW * len(numbers)


def _are_factors(cells: Sequence[str]) -> bool:
    """Return whether a line is one of factors by its first cell, at least one other than 1, or of offsets."""
    label = cells[0] if cells else ""
    numbers = {cell.replace(",", ".") for cell in cells[1:] if has_number(cell) and not is_stamp(cell)}
    if _OFFSETS.fullmatch(label):
        return any(float(each) != 0.0 for each in numbers)
    return _FACTORS.fullmatch(label) is not None and any(float(each) not in (0.0, 1.0) for each in numbers)


def _is_stamped(cells: Sequence[str]) -> bool:
    """Return whether most cells of a column that are not empty are times of day."""
    return 2 * sum(map(is_stamp, cells)) > sum(map(bool, cells))


def _last_of(head: Sequence[str]) -> str:
    """Return the last line of a head that is not blank."""
    return next((bare_line(line)[:80] for line in reversed(head) if line.strip()), "")


def _require_no_split_decimals(head: str, row: str, columns: Sequence[Sequence[str]], source: str) -> None:
    """Refuse decimal commas between commas: whole numbers below names for half as many columns, or an even
    number of them of which a second one has zeros before its digits.

    Raises:
        RecordingError: it is so.
    """
    width, names = len(columns), [name for name in split(head, ",") if name and not has_number(name)]
    if head and not width / 2 <= len(names) < width:
        return
    if not head and (width % 2 or not any(any(map(_ZEROS_FIRST.fullmatch, each)) for each in columns[1::2])):
        return
    names_of = f" and the head {len(names)} names, '{head:.40}'" if head else ""
    raise RecordingError(
        f"{source}: '{row.strip():.40}' has {width} cells between commas{names_of}: decimal commas and "
        f"commas between columns cannot be told apart, export it with semicolons between columns or with "
        f"decimal points{', or state --decimal , for one column' if width == 2 else ''}"
    )
