"""Layout of a table in a text file: delimiter, decimal sign, header and names."""

from __future__ import annotations

import itertools
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchtool.errors import RecordingError
from benchtool.tables.cells import BLANKS, is_no_name, is_number, kind_of_word
from benchtool.tables.first_rows import ROWS, lines_of_head
from benchtool.tables.grouping import Use, use_of
from benchtool.tables.head import (
    BAR,
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
from benchtool.tables.stamps import is_stamp
from benchtool.tables.units import is_unit

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
    (BAR, "."),
    (BAR, ","),
    (BLANKS, "."),
    (BLANKS, ","),
    (",", ","),
)
_SUFFIXES = (1, 2, 4)  # the last 1/n of the lines, in which a long head no longer counts
_WHOLE = re.compile(r"[0-9]+")
_ZEROS_FIRST = re.compile(r"0[0-9]+")
_COMPLETE = 0.98  # share of numbers, but for a head
_FEW = 0.05  # of the cells of a column


@dataclass(frozen=True)
class Layout:
    """Numbers begin at byte `begin`, after `head_lines` lines; `delimiter` is one character, or `BLANKS`.

    `head` is the line nearest the numbers that is neither blank nor a comment where no line names the
    columns. Where `is_open`, the sample has the decimal sign, or the other one, only where one between
    thousands might be. `head_units` are all units in the head, whether of a column or not, and those of two
    letters or more in cells beside and below the numbers. `head_numbers` is the last line of numbers right
    above the rows that was taken for one of the head.
    `signals` is the number of a column, from 1, that says which signal each row has, 0 without one.
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


@dataclass(frozen=True)
class _Fit:
    """A layout of the sample, `share` of whose cells that are not empty are numbers."""

    delimiter: str
    decimal: str
    width: int
    numeric: tuple[bool, ...]
    score: float
    share: float


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
    found = _best(sample, decimal, timed=timed)
    if found is None:
        seen = _almost_a_number(sample)
        fewest = "at least two numbers" if timed else "numbers"
        raise RecordingError(
            f"{source}: no table of numbers found{seen and f', {seen!r} is none'}; lines of {fewest} "
            f"are expected, separated by comma, semicolon, tab, | or blanks, times in seconds or as "
            f"2026-01-31 23:59:59.5: export it as such"
        )
    delimiter, decimal, width, numeric = found.delimiter, found.decimal, found.width, found.numeric
    texts = [line.decode(errors="replace") for line in lines]
    rows = [
        not is_comment(line) and _is_row(split(each, delimiter), delimiter, decimal, width, numeric)
        for line, each in zip(lines, texts, strict=True)
    ]
    if not any(rows):
        raise RecordingError(
            f"{source}: no line of numbers within the first {len(head)} bytes, a head of a few lines is "
            f"expected: cut the head"
        )
    cells_of = [split(line.decode(errors="replace"), delimiter) for line in sample]
    by_column = list(zip(*(cells for cells in cells_of if len(cells) == width), strict=True))
    whole = [_is_whole(cells) for cells in by_column]
    # a few numbers in a column are those of the head
    filled = [
        kept and 2 * sum(map(bool, cells)) > len(cells)
        for cells, kept in zip(by_column, numeric, strict=True)
    ]
    for place in range(rows.index(True) - 1, -1, -1):
        cells = split(texts[place], delimiter)
        rows[place] = not is_comment(lines[place]) and _is_first_row(
            cells, delimiter, decimal, width, filled, whole
        )
        if not rows[place]:
            break
    # columns at the end that are empty in every row are delimiters that end a line
    in_rows = [cells for cells in cells_of if _is_row(cells, delimiter, decimal, width, numeric)]
    used = max((number for cells in in_rows for number, cell in enumerate(cells, 1) if cell), default=width)
    # a first column that is empty in the rows has the labels of lines of the head
    is_labelled = not numeric[0] and 2 * sum(not cells[0] for cells in in_rows) > len(in_rows)
    if is_labelled:
        rows = _below_labels(texts, rows, delimiter)
    head_lines = rows.index(True)
    places = [place for place in range(head_lines, len(rows)) if rows[place]][: ROWS + 3]
    first = [split(texts[place], delimiter) for place in places]
    columns = columns_of(texts[:head_lines], delimiter, used, width, is_labelled=is_labelled)
    if not columns and (below := rows_below_names(texts, rows, delimiter, numeric)):
        head_lines = below
        columns = columns_of(texts[:head_lines], delimiter, used, width)
    numbers = ""
    if head_lines == places[0] and (count := lines_of_head(first, numeric, decimal, delimiter)):
        head_lines, numbers = places[count], bare_line(texts[places[count - 1]])[:80]
        columns = columns_of(texts[:head_lines], delimiter, used, width, is_labelled=is_labelled)
    last = "" if columns else _last_of(texts[:head_lines])
    if not columns and delimiter == "," and all(whole):
        _require_no_split_decimals(last, texts[head_lines], by_column, source)
    begin = sum(len(line) + 1 for line in lines[:head_lines])
    columns += tuple(Column("", "") for _ in range(width - len(columns)))
    columns = tuple(
        Column(each.name, "s", stamps=True) if _is_stamped(cells) else each
        for each, cells in zip(columns, by_column, strict=True)
    )
    kept = [cells for cells, is_kept in zip(by_column, numeric, strict=True) if is_kept]
    other = "." if decimal == "," else ","
    is_open = Use.NOTHING < max(use_of(decimal, cells) for cells in kept) < Use.DECIMALS
    is_open |= any(use_of(other, cells) == Use.EITHER for cells in kept)
    aside = _aside(cells_of, delimiter, decimal, numeric)
    units = tuple(dict.fromkeys((*units_in(texts[:head_lines], delimiter), *filter(is_unit, aside))))
    names_of = signal_column(in_rows, numeric)
    return Layout(delimiter, decimal, columns, head_lines, begin, last, is_open, units, numbers, names_of)


def _aside(
    sample: Sequence[Sequence[str]], delimiter: str, decimal: str, numeric: Sequence[bool]
) -> dict[str, None]:
    """Return what stands in the lines of a sample beside the numbers of a row, and in lines that are none;
    letters alone are left out."""
    found: dict[str, None] = {}
    for cells in sample:
        is_row = _is_row(cells, delimiter, decimal, len(numeric), numeric)
        words = (cell for place, cell in enumerate(cells) if not (is_row and numeric[place]))
        found |= dict.fromkeys(bare for word in words if len(bare := word.strip("()[]{}<> ")) > 1)
    return found


def _almost_a_number(sample: Sequence[bytes]) -> str:
    """Return a cell of the lines that only begins like a number, such as a date; empty if there is none."""
    for line in sample[1:]:
        for delimiter in (",", ";", "\t", BAR, BLANKS):
            cells = split(line.decode(errors="replace"), delimiter)
            for cell in cells if len(cells) > 1 else ():
                if cell[:1].isdigit() and not has_number(cell):
                    return cell[:40]
    return ""


def _sampled(text: bytes, head: Sequence[bytes]) -> Iterator[bytes]:
    yield from head[:1000]
    yield from head[max(1000, len(head) - 500) :]
    if len(text) > _HEAD_BYTES:
        for begin in (len(text) // 2, len(text) - _SAMPLE_BYTES):
            yield from text[begin : begin + _SAMPLE_BYTES].split(b"\n")[1:-1]


def _best(sample: Sequence[bytes], stated: str, *, timed: bool) -> _Fit | None:
    """Return what fits best; None where no two columns are of numbers, nor one where that is enough.

    Numbers in groups of digits count where not all cells are plain numbers. Blanks that separate groups
    between tabs separate no columns.
    """
    texts = [line.decode(errors="replace") for line in sample]
    layouts = [each for each in _LAYOUTS if stated in ("", each[1])]
    if timed:
        return _best_fit(texts, layouts)
    # a stated decimal comma separates no columns
    quoted = [each for each in layouts if each[0] != stated or any('"' in text for text in texts)]
    return _best_fit(texts, quoted) or _best_of(texts, quoted, groups=False, fewest=1)


def _best_fit(texts: Sequence[str], layouts: Sequence[tuple[str, str]]) -> _Fit | None:
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
) -> _Fit | None:
    best: _Fit | None = None
    for delimiter, decimal in layouts:
        by_width: dict[int, list[list[str]]] = defaultdict(list)
        for text in texts:
            cells = split(text, delimiter)
            if fewest <= len(cells) <= _MOST_COLUMNS:
                by_width[len(cells)].append(cells)
        between = delimiter if groups else ""
        for (width, found), part in itertools.product(by_width.items(), _SUFFIXES):
            rows = found[-(-len(found) * (part - 1) // part) :]
            columns = list(zip(*rows, strict=True))
            others = [[cell for cell in cells if not is_number(cell, decimal, between)] for cells in columns]
            counts = [len(rows) - len(cells) for cells in others]
            filled = [
                count + sum(kind_of_word(cell) is None for cell in cells)
                for count, cells in zip(counts, others, strict=True)
            ]
            numeric = tuple(
                count > 0 and count >= some / 2 for count, some in zip(counts, filled, strict=True)
            )
            numbers = sum(count for count, kept in zip(counts, numeric, strict=True) if kept)
            share = numbers / max(1, sum(filled))
            # many numbers, and few cells that are not
            if sum(numeric) >= fewest and numbers * share**2 > (best.score if best else 0.0):
                best = _Fit(delimiter, decimal, width, numeric, numbers * share**2, share)
    return best


def _is_row(cells: Sequence[str], delimiter: str, decimal: str, width: int, numeric: Sequence[bool]) -> bool:
    """Return whether the cells are a row: at least half numbers; the rest empty or a word in place of one."""
    if len(cells) != width:
        return False
    wanted = [cell for cell, is_numeric in zip(cells, numeric, strict=True) if is_numeric]
    numbers = [is_number(cell, decimal, delimiter) for cell in wanted]
    fits = (good or kind_of_word(cell) is not None for cell, good in zip(wanted, numbers, strict=True))
    return sum(numbers) >= 0.5 * len(numbers) and all(fits)


def _is_first_row(
    cells: Sequence[str],
    delimiter: str,
    decimal: str,
    width: int,
    numeric: Sequence[bool],
    whole: Sequence[bool],
) -> bool:
    """Return whether cells above the rows are a row as well: a number in a column of numbers, or nothing but
    words in place of numbers.

    The numbers of channels (`t,1,2`) are whole above others that are not, and names of columns.
    """
    if len(cells) != width or are_units(cells):
        return False
    wanted = [
        (cell, is_whole)
        for cell, is_numeric, is_whole in zip(cells, numeric, whole, strict=True)
        if is_numeric
    ]
    numbers = [(cell, is_whole) for cell, is_whole in wanted if is_number(cell, decimal, delimiter)]
    if not numbers:
        return any(cell for cell, _ in wanted) and all(is_no_name(cell) for cell, _ in wanted)
    words = any(cell and kind_of_word(cell) is None for cell, _ in wanted if not has_number(cell))
    return not (words and all(_WHOLE.fullmatch(cell) and not is_whole for cell, is_whole in numbers))


def _below_labels(texts: Sequence[str], rows: Sequence[bool], delimiter: str) -> list[bool]:
    """Return which lines are rows: of those with a label in the first cell only the ones right above the rows
    without, as of an oscilloscope that writes its settings beside them."""
    bare = [is_row and not split(text, delimiter)[0] for is_row, text in zip(rows, texts, strict=True)]
    first = bare.index(True) if any(bare) else 0
    others = [place for place in range(first) if not rows[place] and texts[place].strip()]
    return [is_row and place > max(others, default=-1) for place, is_row in enumerate(rows)]


def _is_whole(cells: Sequence[str]) -> bool:
    """Return whether the numbers of a column are whole, but for few."""
    numbers = [cell for cell in cells if has_number(cell)]
    return sum(_WHOLE.fullmatch(cell.lstrip("+-")) is None for cell in numbers) <= _FEW * len(numbers)


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
        f"decimal points"
    )
