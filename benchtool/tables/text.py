"""Tables of numbers that other tools wrote as text: CSV of an oscilloscope, a spreadsheet, a logger."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray
from pyarrow import csv

from benchtool.errors import NoSuchRecording, RecordingError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.tables.attached_units import without_units
from benchtool.tables.broken_names import with_whole_names
from benchtool.tables.cells import BLANKS, Cell, ascii_numbers, kind_of_word, numbers_of
from benchtool.tables.cut_short import without_cut_number
from benchtool.tables.grouping import Use, use_of
from benchtool.tables.head import BAR
from benchtool.tables.labelled_values import as_columns
from benchtool.tables.layout import Layout, find_layout
from benchtool.tables.selection import Selection, listed, selection_of
from benchtool.tables.stamps import seconds_of

_BLOCK_BYTES = 4 << 20
_SNIFFED_BYTES = 64 * 1024
_ZEROS_OF_UTF_16 = 0.35  # share of zero bytes among every other one; text in Latin letters has nearly all
_NO_TEXT = {b"PAR1": "a Parquet file", b"ARROW1": "an Arrow file", b"PK\x03\x04": "a ZIP archive (or XLSX)"}
_CONTROL = bytes({*range(1, 32)} - set(b"\t\n\v\f\r\x1a"))  # zeros fill the end of a text that was cut short
_CONTROL_OF_BINARY = 0.04  # share of the bytes
_NO_READING = 9.9e37  # instruments send 9.9e37 for infinity and 9.91e37 for no reading (SCPI-99)
_LEAST_MARK, _MARK_APART = 999.0, 10.0  # of a number that marks no reading: its size, and by how much
_ANYTHING = re.compile(rb"\S")
_COMMENT = re.compile(rb"^[ \t]*[#%].*$", re.MULTILINE)
_LONG_QUOTE = re.compile(rb'"[^"\n]*(?:\n[^"\n]*){9,}"')  # stray marks, which would join rows
_BLANK_LINE = re.compile(rb"^[ \t]*$", re.MULTILINE)
_FEW_BLANK = 0.25  # of the lines: more of them are between all
_BLANKS = re.compile(rb"[ \t]+")
_LINE_ENDS = re.compile(rb"^ | $", re.MULTILINE)
_OUTER_BARS = re.compile(rb"^[ \t]*\|(.*)\|[ \t]*$", re.MULTILINE)
_BEYOND_ASCII = re.compile(rb"[\x80-\xff]+")
_TWO_CHARACTERS, _FEWEST_WORDS = 4, 2  # bytes; so many of them are no chance
_NOT_A_NUMBER = (9.905e37, 9.915e37)
# one byte for one: a non-ASCII byte is not part of a number, and a zero byte must not join its neighbours
_ASCII_ONLY = bytes(byte if 0 < byte < 128 else (ord("?") if byte else ord(" ")) for byte in range(256))


@dataclass(frozen=True)
class LeftOut:
    """Rows with a cell that is no number: which of the rows of the right width each is, shape (k,), its
    numbers, shape (k, columns), nan where there is none, and what each cell is (`Cell`), of the same shape.

    `broken` rows have a wrong number of cells, and are not the last line, cut short.
    """

    place: NDArray[np.int64]
    data: NDArray[np.float64]
    cells: NDArray[np.int8]
    broken: int = 0


@dataclass(frozen=True)
class Rows:
    """Numbers of some columns in SI units, shape (n, columns), all finite: rows in which each cell is one.

    `read` rows were found, and `dropped` says how many of them were left out, by reason. `place` is which of
    the rows of the right width each is, from 0, shape (n,).
    """

    data: NDArray[np.float64]
    read: int
    dropped: Mapping[str, int]
    place: NDArray[np.int64]
    left_out: LeftOut


@dataclass(frozen=True)
class TextTable:
    """A file whose layout is known; `text` is UTF-8 with lines ended by newlines, whatever the file has, and
    with columns in place of labelled values (`as_columns`), and without units in its cells
    (`without_units`)."""

    path: Path
    encoding: str
    layout: Layout
    text: bytes

    @classmethod
    def open(cls, path: Path, decimal: str = "", *, timed: bool = True) -> TextTable:
        """Read a file and determine its layout: see `find_layout`; a decimal sign may be stated, and that
        rows are not timed by a column.

        UTF-8 and UTF-16, each with a byte order mark or without, GB 2312 where all words are of its
        characters, else Windows-1252 (Latin-1); lines end by newline, carriage return or both.

        Raises:
            NoSuchRecording: it is not there, or holds no table of numbers.
            RecordingError: it cannot be read.
        """
        if told := mistaken(path, FileKind.TABLE):
            raise NoSuchRecording(told)
        try:
            content = path.read_bytes()
        except (OSError, ValueError) as reason:
            what = getattr(reason, "strerror", None) or reason
            absent = isinstance(reason, FileNotFoundError | IsADirectoryError)
            kind = NoSuchRecording if absent else RecordingError
            raise kind(
                f"cannot read {path}: {what}; a text file with columns of numbers is expected: check the name"
            ) from None
        if _ANYTHING.search(content) is None:
            raise NoSuchRecording(f"{path} is empty, a text file with columns of numbers is expected")
        for mark, what in _NO_TEXT.items():
            if content.startswith(mark):
                raise NoSuchRecording(f"{path} is {what} and no text: export it as CSV")
        text, encoding = _to_utf_8(content)
        sniffed = text[:_SNIFFED_BYTES]
        if len(sniffed) - len(sniffed.translate(None, _CONTROL)) > _CONTROL_OF_BINARY * len(sniffed):
            raise NoSuchRecording(f"{path} is binary and no text: export it as text with columns of numbers")
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        text, joined = with_whole_names(text)
        text, added = as_columns(ascii_numbers(text))
        text, units = without_units(text)
        layout = find_layout(text, str(path), decimal, timed=timed).with_units(units)
        text = without_cut_number(text, layout)
        table = cls(path, encoding, replace(layout, head_lines=layout.head_lines - added + joined), text)
        return table._settled() if table.layout.is_open and not decimal else table

    @property
    def listed(self) -> str:
        """What the columns are called, for a message."""
        return listed(self.layout)

    def select(self, wanted: str, si_unit: str, rated: float | None = None) -> Selection:
        """Return the column that `wanted` names, in a unit of the kind of `si_unit`.

        `wanted` is a name, or a number counted from 1; behind a colon may stand the unit of its values, a
        gain and an offset, see `scaling`. A name is looked for as it is written, then without the unit behind
        it, then in another case; text that is not a name is taken as a number, and text that is neither is
        split at its last colon. A unit of percent is that of `rated`, in `si_unit`. Times of day are in
        seconds since the first of them.

        Raises:
            AnalysisError: no such column, several of that name, what the option or else the head states as
                the unit is not one of that kind, or is asked of times of day, or the decimal sign is open.
        """
        return selection_of(self.path, self.layout, wanted, si_unit, rated)

    def rows(self, selections: Sequence[Selection]) -> Rows:
        """Return the numbers of some columns, in SI units.

        A row with another number of cells than the table has columns, with a cell of these columns that is
        empty, not a number, 9.9e37 and more, or a mark of no reading, or that begins with a word in a column
        of numbers, as a summary does (`Mean`), is left out and counted; blank lines and comments do not
        count.

        Raises:
            RecordingError: the text cannot be split into rows and cells.
        """
        wanted = [each.number - 1 for each in selections]
        first = [0] if self.layout.is_number_first else []
        table, texts, wrong = self._parse(list(dict.fromkeys([*wanted, *first])))
        data = np.empty((table.num_rows, len(wanted)), order="F")
        cells = np.zeros(data.shape, dtype=np.int8)
        marks: dict[str, NDArray[np.bool_]] = {}
        for place, (column, selection) in enumerate(zip(wanted, selections, strict=True)):
            row = 0
            for chunk in table[str(column)].chunks:
                # not to_numpy, which imports pandas if installed, which takes a second
                values = np.from_dlpack(chunk.fill_null(np.nan) if chunk.null_count else chunk)
                target = data[row : row + len(values), place]
                target[:] = values
                row += len(values)
            cells[:, place] = _cells(data[:, place], None if texts is None else texts[str(column)])
            if mark := _mark_of_no_reading(data[:, place]):
                is_mark = np.abs(data[:, place]) == mark
                cells[is_mark, place] = Cell.MISSING
                why = f"a cell is {data[np.argmax(is_mark), place]:.0f}, which marks no reading"
                marks[why] = marks.get(why, False) | is_mark
            data[:, place] *= selection.gain * selection.factor
            data[:, place] += selection.offset * selection.factor
        cells[(cells == Cell.NUMBER) & ~(np.abs(data) < _NO_READING)] = Cell.MISSING
        if first and texts is not None:
            begins = texts["0"].combine_chunks()
            is_word = np.array([_is_label(each) for each in begins.to_pylist()], dtype=np.bool_)
            if is_word.any():
                cells[is_word] = Cell.MISSING
                marks["a word in the first cell"] = is_word
        kept = (cells == Cell.NUMBER).all(axis=1)
        lost = np.flatnonzero(~kept)
        counts = {why: int(np.count_nonzero(each)) for why, each in marks.items()}
        no_number = len(lost) - int(np.count_nonzero(np.logical_or.reduce(list(marks.values()))))
        counts = {"wrong number of cells": len(wrong), "a cell is no number": no_number} | counts
        dropped = {why: count for why, count in counts.items() if count}
        is_cut_short = wrong and self.text.rstrip().endswith(wrong[-1].encode())
        left_out = LeftOut(lost, data[lost], cells[lost], len(wrong) - bool(is_cut_short))
        if len(lost):
            data = np.asfortranarray(data[kept])
        return Rows(data, table.num_rows + len(wrong), dropped, np.flatnonzero(kept), left_out)

    def first_left_out(self, rows: Rows, selections: Sequence[Selection]) -> str:
        """Return the first cell for which one of the rows was left out; empty if there is none."""
        return self.unreadable_cell(selections) if len(rows.left_out.place) else ""

    def unreadable_cell(self, selections: Sequence[Selection]) -> str:
        """Return the first cell of these columns that is not a number, as in the file; empty if none."""
        wanted = list(dict.fromkeys(each.number - 1 for each in selections))
        with suppress(pa.ArrowException):
            table, _ = self._read(self._body(as_ascii=False), wanted, pa.string())
            for name in table.column_names:
                bad = pc.is_null(self._numbers(name, table[name]))
                if pc.any(bad).as_py():
                    cell = str(table[name].filter(bad)[0].as_py() or "").strip()
                    return f"'{cell:.40}' in column {int(name) + 1}"
        return ""

    def _parse(self, wanted: Sequence[int]) -> tuple[pa.Table, pa.Table | None, list[str]]:
        """Return the columns as numbers, and as text where a cell of them is none."""
        body = self._body()
        if _ANYTHING.search(body) is None:
            return pa.table({str(column): pa.array([], pa.float64()) for column in wanted}), None, []
        with suppress(pa.ArrowException):  # a cell is not a number: read as text to find it
            if not any(self.layout.columns[column].stamps for column in wanted):
                table, wrong = self._read(body, wanted, pa.float64())
                return table, None, wrong
        try:
            texts, wrong = self._read(body, wanted, pa.string())
            numbers = {name: self._numbers(name, texts[name]) for name in texts.column_names}
            return pa.table(numbers), texts, wrong
        except pa.ArrowException as reason:
            raise RecordingError(
                f"{self.path}: rows cannot be separated ({str(reason).splitlines()[0]:.100}), a line for "
                f"each row is expected: export it again"
            ) from None

    def _body(self, *, as_ascii: bool = True) -> bytes:
        body = self.text[self.layout.begin :]
        if b'"' in body and _LONG_QUOTE.search(body):
            body = _LONG_QUOTE.sub(lambda match: match[0].replace(b'"', b" "), body)
        if len(self.layout.columns) == 1:
            body = _with_empty_cells(body)
        if as_ascii and (not body.isascii() or b"\0" in body):
            body = body.translate(_ASCII_ONLY)
        if b"#" in body or b"%" in body:
            body = _COMMENT.sub(b"", body)
        if self.layout.delimiter == BAR:
            body = _OUTER_BARS.sub(rb"\1", body)
        if self.layout.delimiter == BLANKS:
            body = _LINE_ENDS.sub(b"", _BLANKS.sub(b" ", body))
        return body

    def _read(self, body: bytes, wanted: Sequence[int], type_: pa.DataType) -> tuple[pa.Table, list[str]]:
        wrong: list[str] = []

        def skip(row: csv.InvalidRow) -> str:
            if (row.text or "").strip():
                wrong.append(row.text.strip())
            return "skip"

        names = [str(number) for number in range(len(self.layout.columns))]
        chosen = [str(number) for number in wanted]
        table = csv.read_csv(
            pa.BufferReader(body),
            read_options=csv.ReadOptions(column_names=names, use_threads=False, block_size=_BLOCK_BYTES),
            parse_options=csv.ParseOptions(
                delimiter=self.layout.delimiter,
                quote_char='"' if b'"' in body else False,
                invalid_row_handler=skip,
            ),
            convert_options=csv.ConvertOptions(
                include_columns=chosen,
                column_types=dict.fromkeys(chosen, type_),
                decimal_point=self.layout.decimal,
            ),
        )
        return table, wrong

    def _numbers(self, name: str, cells: pa.ChunkedArray) -> pa.ChunkedArray:
        """Return the cells of text of a column as numbers, null where they are not numbers."""
        if self.layout.columns[int(name)].stamps:
            return seconds_of(cells)
        return numbers_of(cells, self.layout.decimal, self.layout.delimiter)

    def _settled(self) -> TextTable:
        """Return the table with the use of its decimal sign as all of its cells show it, not the sample
        alone; columns that leave it open are so."""
        layout, sign = self.layout, self.layout.decimal
        numbers = [number for number, each in enumerate(layout.columns) if not each.stamps]
        try:
            texts, _ = self._read(self._body(), numbers, pa.string())
        except pa.ArrowException:
            return self
        other = "." if sign == "," else ","
        cells = [
            [cell.strip() for cell in texts[name].to_pylist() if cell is not None]
            for name in texts.column_names
        ]
        uses = [use_of(sign, each) for each in cells]
        if max(uses) == Use.THOUSANDS:
            return replace(self, layout=replace(layout, decimal=other))
        columns = list(layout.columns)
        is_known = max(uses) == Use.DECIMALS or (layout.delimiter, sign) == (",", ".")
        for number, use, each in zip(numbers, uses, cells, strict=True):
            is_either = not is_known and use == Use.EITHER
            of_other = other if use_of(other, each) == Use.EITHER else ""
            columns[number] = replace(columns[number], open_sign=sign if is_either else of_other)
        return replace(self, layout=replace(layout, columns=tuple(columns)))


def _with_empty_cells(body: bytes) -> bytes:
    """Return rows of one cell in which a few blank lines, each an empty cell, are in quotation marks."""
    body = body.rstrip()
    blank = len(_BLANK_LINE.findall(body))
    return _BLANK_LINE.sub(b'""', body) if 0 < blank < _FEW_BLANK * body.count(b"\n") else body


def _is_label(cell: str | None) -> bool:
    """Return whether the first cell of a row is a word that stands in place of no number."""
    return cell is not None and cell.strip()[:1].isalpha() and kind_of_word(cell) is None


def _cells(values: NDArray[np.float64], texts: pa.ChunkedArray | None) -> NDArray[np.int8]:
    """Return what each cell of a column is, shape (n,), by its value and its text."""
    is_no_reading = (np.abs(values) > _NOT_A_NUMBER[0]) & (np.abs(values) < _NOT_A_NUMBER[1])
    cells = np.where(np.abs(values) >= _NO_READING, np.int8(Cell.OVERLOAD), np.int8(Cell.NUMBER))
    cells[np.isnan(values) | is_no_reading] = Cell.MISSING
    if texts is not None:
        bad = np.flatnonzero(np.isnan(values))
        words = texts.take(pa.array(bad)).to_pylist()
        cells[bad] = [kind_of_word(word or "") or Cell.MISSING for word in words]
    return np.asarray(cells, dtype=np.int8)


def _mark_of_no_reading(values: NDArray[np.float64]) -> float:
    """Return the size of the number that marks no reading in a column, as -999 and 9999 do; 0 if none does.

    It is a whole number of nines and ten times as large as all others.
    """
    sizes = np.abs(values[np.abs(values) < _NO_READING])
    mark = float(sizes.max(initial=0.0))
    is_of_nines = mark >= _LEAST_MARK and mark < 1e15 and set(f"{mark:.15g}") == {"9"}
    if not is_of_nines:
        return 0.0
    others = sizes[sizes < mark]
    return mark if len(others) and _MARK_APART * float(others.max()) <= mark else 0.0


def _to_utf_8(content: bytes) -> tuple[bytes, str]:
    """Return the content as UTF-8 without a byte order mark, and the encoding that it had."""
    if content.startswith(b"\xef\xbb\xbf"):
        return content[3:], "utf-8-sig"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace").encode("utf-8", errors="replace"), "utf-16"
    sample = content[:_SNIFFED_BYTES]
    even, odd = sample[0::2].count(0), sample[1::2].count(0)
    for encoding, zeros, others in (("utf-16-le", odd, even), ("utf-16-be", even, odd)):
        if zeros > _ZEROS_OF_UTF_16 * len(sample) / 2 and others < zeros / 10:
            return content.decode(encoding, errors="replace").encode("utf-8", errors="replace"), encoding
    try:
        sample[: sample.rfind(b"\n") + 1 or None].decode("utf-8")
    except UnicodeDecodeError:
        encoding = "gb18030" if _is_chinese(sample) else "cp1252"
        return content.decode(encoding, errors="replace").encode("utf-8", errors="replace"), encoding
    return content, "utf-8"


def _is_chinese(sample: bytes) -> bool:
    """Return whether what is not ASCII is words in the characters of GB 2312, of two bytes each; in Western
    languages such letters do not stand side by side in each word."""
    words = _BEYOND_ASCII.findall(sample)
    if sum(len(word) >= _TWO_CHARACTERS for word in words) < _FEWEST_WORDS:
        return False
    try:
        return all(word.decode("gb2312") for word in words)
    except UnicodeDecodeError:
        return False
