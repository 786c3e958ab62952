"""Tables of numbers that other tools wrote as text: CSV of an oscilloscope, a spreadsheet, a logger."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray
from pyarrow import csv

from benchtool.errors import AnalysisError, RecordingError
from benchtool.tables.layout import BLANKS, Layout, find_layout
from benchtool.tables.scaling import Scaling, scaling
from benchtool.tables.stamps import seconds_of
from benchtool.tables.units import PERCENT, unit_factor, units_of

_BLOCK_BYTES = 4 << 20
_SNIFFED_BYTES = 64 * 1024
_ZEROS_OF_UTF_16 = 0.35  # share of zero bytes among every other one; text in Latin letters has nearly all
_NO_TEXT = {b"PAR1": "a Parquet file", b"ARROW1": "an Arrow file", b"PK\x03\x04": "a ZIP archive (or XLSX)"}
_CONTROL = bytes({*range(1, 32)} - set(b"\t\n\v\f\r\x1a"))  # zeros fill the end of a text that was cut short
_CONTROL_OF_BINARY = 0.04  # share of the bytes
_NO_READING = 9.9e37  # instruments send 9.9e37 for infinity and 9.91e37 for no reading (SCPI-99)
_ANYTHING = re.compile(rb"\S")
_COMMENT = re.compile(rb"^[ \t]*[#%].*$", re.MULTILINE)
_BLANKS = re.compile(rb"[ \t]+")
_LINE_ENDS = re.compile(rb"^ | $", re.MULTILINE)
_NUMBER = r"^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$"
# one byte for one: a non-ASCII byte is not part of a number, and a zero byte must not join its neighbours
_ASCII_ONLY = bytes(byte if 0 < byte < 128 else (ord("?") if byte else ord(" ")) for byte in range(256))


@dataclass(frozen=True)
class Selection:
    """A column that was asked for: `number` counts from 1, (cell x gain + offset) x factor is in `si_unit`.

    `unit_from` is "option", "head", or "assumed" where neither states anything; `unit` is that of the value
    after gain and offset.
    """

    number: int
    name: str
    unit: str
    unit_from: str
    factor: float
    si_unit: str
    gain: float = 1.0
    offset: float = 0.0


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


@dataclass(frozen=True)
class TextTable:
    """A file whose layout is known; `text` is UTF-8 with lines ended by newlines, whatever the file has."""

    path: Path
    encoding: str
    layout: Layout
    text: bytes

    @classmethod
    def open(cls, path: Path) -> TextTable:
        """Read a file and determine its layout: see `find_layout`.

        UTF-8 and UTF-16, each with a byte order mark or without, else Windows-1252 (Latin-1); lines end by
        newline, carriage return or both.

        Raises:
            RecordingError: it cannot be read, or holds no table of numbers.
        """
        try:
            content = path.read_bytes()
        except (OSError, ValueError) as reason:
            what = getattr(reason, "strerror", None) or reason
            raise RecordingError(
                f"cannot read {path}: {what}; a text file with columns of numbers is expected: check the name"
            ) from None
        if _ANYTHING.search(content) is None:
            raise RecordingError(f"{path} is empty, a text file with columns of numbers is expected")
        for mark, what in _NO_TEXT.items():
            if content.startswith(mark):
                raise RecordingError(f"{path} is {what} and no text: export it as CSV")
        text, encoding = _to_utf_8(content)
        sniffed = text[:_SNIFFED_BYTES]
        if len(sniffed) - len(sniffed.translate(None, _CONTROL)) > _CONTROL_OF_BINARY * len(sniffed):
            raise RecordingError(f"{path} is binary and no text: export it as text with columns of numbers")
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return cls(path, encoding, find_layout(text, str(path)), text)

    def select(self, wanted: str, si_unit: str, rated: float | None = None) -> Selection:
        """Return the column that `wanted` names, in a unit of the kind of `si_unit`.

        `wanted` is a name, or a number counted from 1; behind a colon may stand the unit of its values, a
        gain and an offset, see `scaling`. A name is looked for as it is written, then without the unit behind
        it, then in another case; text that is not a name is taken as a number, and text that is neither is
        split at its last colon. A unit of percent is that of `rated`, in `si_unit`. Times of day are in
        seconds since the first of them.

        Raises:
            AnalysisError: no such column, several of that name, or what the option or else the head states
                as the unit is not one of that kind, or is asked of times of day.
        """
        number = self._find(wanted)
        stated = Scaling("")
        if number is None and ":" in wanted:
            name, _, behind = wanted.rpartition(":")
            number, stated = self._find(name), scaling(behind, si_unit)
            wanted = name
        if number is None:
            raise AnalysisError(
                f"{self.path} has no column '{wanted}', {self._listed()}: give a name or a number"
            )
        column = self.layout.columns[number]
        asked = stated.unit or si_unit
        if column.stamps and asked != "s":
            raise AnalysisError(
                f"column '{wanted}' of {self.path} holds times of day, numbers in {asked} are expected: "
                f"choose another column, or name this one as the time"
            )
        unit, unit_from = (column.unit, "head") if column.unit else (si_unit, "assumed")
        if stated.unit:
            unit, unit_from = stated.unit, "option"
        factor = unit_factor(unit, si_unit)
        if factor is None and rated is not None and unit.lower() in PERCENT:
            factor = rated / 100.0
        if factor is None:
            by = "which its head states" if unit_from == "head" else "as given"
            raise AnalysisError(
                f"'{unit}' is no unit of column '{wanted}', {by}; expected is one of "
                f"{units_of(si_unit)}: state it in the option, as '{wanted}:{si_unit}', with a gain where "
                f"one step is another size, as '{wanted}:{si_unit}*0.01'"
            )
        return Selection(
            number + 1, column.name, unit, unit_from, factor, si_unit, stated.gain, stated.offset
        )

    def rows(self, selections: Sequence[Selection]) -> Rows:
        """Return the numbers of some columns, in SI units.

        A row with another number of cells than the table has columns, or with a cell of these columns that is
        empty, not a number, or 9.9e37 and more, is left out and counted; blank lines and comments do not
        count.

        Raises:
            RecordingError: the text cannot be split into rows and cells.
        """
        wanted = [each.number - 1 for each in selections]
        table, wrong_width = self._parse(list(dict.fromkeys(wanted)))
        data = np.empty((table.num_rows, len(wanted)), order="F")
        for place, (column, selection) in enumerate(zip(wanted, selections, strict=True)):
            row = 0
            for chunk in table[str(column)].chunks:
                # not to_numpy, which imports pandas if installed, which takes a second
                values = np.from_dlpack(chunk.fill_null(np.nan) if chunk.null_count else chunk)
                target = data[row : row + len(values), place]
                np.multiply(values, selection.gain * selection.factor, out=target)
                if selection.offset:
                    target += selection.offset * selection.factor
                row += len(values)
        kept = (np.abs(data) < _NO_READING).all(axis=1)  # false of nan as well
        no_number = int(np.count_nonzero(~kept))
        reasons = (("wrong number of cells", wrong_width), ("a cell is no number", no_number))
        if no_number:
            data = np.asfortranarray(data[kept])
        dropped = {why: count for why, count in reasons if count}
        return Rows(data, table.num_rows + wrong_width, dropped, np.flatnonzero(kept))

    def unreadable_cell(self, selections: Sequence[Selection]) -> str:
        """Return first cell of these columns that is not a number, as in the file; empty if there is none."""
        wanted = list(dict.fromkeys(each.number - 1 for each in selections))
        with suppress(pa.ArrowException):
            table, _ = self._read(self._body(), wanted, pa.string())
            for name in table.column_names:
                bad = pc.is_null(self._numbers(name, table[name]))
                if pc.any(bad).as_py():
                    cell = str(table[name].filter(bad)[0].as_py() or "").strip()
                    return f"'{cell:.40}' in column {int(name) + 1}"
        return ""

    def _parse(self, wanted: Sequence[int]) -> tuple[pa.Table, int]:
        body = self._body()
        if _ANYTHING.search(body) is None:
            return pa.table({str(column): pa.array([], pa.float64()) for column in wanted}), 0
        with suppress(pa.ArrowException):  # a cell is not a number: read as text to find it
            if not any(self.layout.columns[column].stamps for column in wanted):
                return self._read(body, wanted, pa.float64())
        try:
            table, wrong_width = self._read(body, wanted, pa.string())
            numbers = {name: self._numbers(name, table[name]) for name in table.column_names}
            return pa.table(numbers), wrong_width
        except pa.ArrowException as reason:
            raise RecordingError(
                f"{self.path}: rows cannot be separated ({str(reason).splitlines()[0]:.100}), a line for "
                f"each row is expected: export it again"
            ) from None

    def _body(self) -> bytes:
        body = self.text[self.layout.begin :]
        if not body.isascii() or b"\0" in body:
            body = body.translate(_ASCII_ONLY)
        if b"#" in body or b"%" in body:
            body = _COMMENT.sub(b"", body)
        if self.layout.delimiter == BLANKS:
            body = _LINE_ENDS.sub(b"", _BLANKS.sub(b" ", body))
        return body

    def _read(self, body: bytes, wanted: Sequence[int], type_: pa.DataType) -> tuple[pa.Table, int]:
        wrong_width = 0

        def skip(row: csv.InvalidRow) -> str:
            nonlocal wrong_width
            wrong_width += bool((row.text or "").strip())
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
        return table, wrong_width

    def _numbers(self, name: str, cells: pa.ChunkedArray) -> pa.ChunkedArray:
        """Return the cells of text of a column as numbers, null where they are not numbers."""
        if self.layout.columns[int(name)].stamps:
            return seconds_of(cells)
        cells = pc.ascii_trim_whitespace(cells)
        if self.layout.decimal == ",":
            cells = pc.replace_substring(cells, ",", ".")
        cells = pc.if_else(pc.match_substring_regex(cells, _NUMBER), cells, None)
        return pc.cast(pc.ascii_ltrim(cells, "+"), pa.float64())

    def _find(self, wanted: str) -> int | None:
        """Return the place of the column of that name or number, None where there is none."""
        wanted = wanted.strip()
        names = [column.name for column in self.layout.columns]
        bare = [column.bare_name for column in self.layout.columns]
        ways = [(names, wanted), (bare, wanted)]
        ways += [([name.lower() for name in spelt], wanted.lower()) for spelt in (names, bare)]
        for spelt, name in ways:
            places = [place for place, each in enumerate(spelt) if each == name != ""]
            if len(places) > 1:
                numbers = ", ".join(str(place + 1) for place in places)
                raise AnalysisError(
                    f"{self.path} has {len(places)} columns '{wanted}', with the numbers {numbers}: give one"
                )
            if places:
                return places[0]
        if re.fullmatch(r"[0-9]{1,6}", wanted) and 1 <= int(wanted) <= len(self.layout.columns):
            return int(wanted) - 1
        return None

    def _listed(self) -> str:
        columns = self.layout.columns
        if not any(column.name for column in columns):
            return f"it has no names, and columns 1 to {len(columns)}"
        listed = [f"{number} '{column.name}'" for number, column in enumerate(columns[:20], 1)]
        more = f" and {len(columns) - 20} more" if len(columns) > 20 else ""
        return f"it has {', '.join(listed)}{more}"


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
        return content.decode("cp1252", errors="replace").encode("utf-8"), "cp1252"
    return content, "utf-8"
