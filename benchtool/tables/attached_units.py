"""Numbers with a unit, or the prefix of one, behind them in their cells: `0.1 ms`, `980mA`, `1.2m`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from benchtool.tables.head import BAR, is_comment, split
from benchtool.tables.units import PERCENT, is_unit

_SNIFFED_BYTES, _FEWEST_LINES = 64 * 1024, 2
_FEWEST_VALUES = 8  # of a column in so many lines: labels such as 1A and 2A are fewer
_NEARLY_ALL = 0.95  # of the cells with a unit: others are no numbers of their column
_MAY_BE = re.compile(rb"[0-9.][ \t]?[^\W\d\n][^,;|\n]{0,7}[,;|\t\n]|[0-9.][ \t]?[%\xc2]")
_CELL = re.compile(
    r"([+-]?(?:[0-9][0-9.,]*|[.,][0-9]+))(?:[eE]([+-]?[0-9]+))?[ \t]*((?![0-9.,])[^\s,;|]{1,8})?"
)
_EXPONENTS = {"p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "": 0, "k": 3, "K": 3, "M": 6, "G": 9}


@dataclass(frozen=True)
class _Cell:
    """A number, the power of ten behind it, and what stands behind both."""

    number: str
    exponent: int
    suffix: str

    @property
    def is_zero(self) -> bool:
        return not self.number.strip("+-0.,")


def without_units(text: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Return a table without the units in its cells, and the unit that each column has there; a text without
    such cells as it is.

    More than half of the lines have such a cell in the same columns. Where all cells of a column have the
    same unit, their numbers are left as they are; where they differ by prefixes alone, as `1.2 A` and `980
    mA`, they are in that without any. The text is in UTF-8 with lines ended by newlines.
    """
    sniffed = text[:_SNIFFED_BYTES]
    if _MAY_BE.search(sniffed) is None:
        return text, ()
    sample = [line.decode(errors="replace") for line in sniffed.split(b"\n")[:-1] if _has_cells(line)]
    delimiter, columns = max((_columns(sample, each) for each in (",", ";", "\t", BAR)), key=_score)
    if not any(each is not None for each in columns):
        return text, ()
    lines = text.decode(errors="replace").split("\n")
    rows = [_row(line, delimiter, columns) for line in lines]
    units = tuple("" if each is None else each.unit for each in columns)
    written = "\n".join(line if row is None else row for line, row in zip(lines, rows, strict=True))
    return written.encode(), units


@dataclass(frozen=True)
class _Column:
    """A column whose cells have `unit`, as it stands in all of them or, where `is_mixed`, behind prefixes."""

    unit: str
    is_mixed: bool

    def plain(self, cell: str) -> str | None:
        """Return the number of a cell in the column's unit; None where it has another one."""
        found = _parsed(cell)
        if found is None:
            return None
        exponent: int | None = found.exponent
        if self.is_mixed:
            prefix, base = _divided(found.suffix)
            fits = base == self.unit or found.suffix == ""
            exponent = found.exponent + _EXPONENTS[prefix] if fits else None
        elif found.suffix != self.unit and not found.is_zero:
            exponent = None
        if exponent is None:
            return None
        return found.number + (f"e{exponent}" if exponent else "")


def _score(of: tuple[str, Sequence[_Column | None]]) -> int:
    return sum(each is not None for each in of[1])


def _has_cells(line: bytes) -> bool:
    return bool(line.strip()) and not is_comment(line)


def _columns(sample: Sequence[str], delimiter: str) -> tuple[str, list[_Column | None]]:
    """Return the delimiter and, for each column that it separates, whether its cells have units."""
    rows = [split(line, delimiter) for line in sample]
    width, count = Counter(map(len, rows)).most_common(1)[0] if rows else (0, 0)
    if width < 2 or count < _FEWEST_LINES:
        return delimiter, []
    fitting = [cells for cells in rows if len(cells) == width]
    return delimiter, [_column(cells, len(sample)) for cells in zip(*fitting, strict=True)]


def _column(texts: Sequence[str], lines: int) -> _Column | None:
    found = [each for each in map(_parsed, texts) if each is not None]
    suffixed = [each for each in found if each.suffix]
    are_prefixes = all(each.suffix in _EXPONENTS for each in suffixed)  # which most numbers may be without
    if not suffixed or 2 * len(found) <= lines or not (are_prefixes or 2 * len(suffixed) > len(found)):
        return None
    if len({each.number for each in suffixed}) < min(_FEWEST_VALUES, len(suffixed)):
        return None
    of_numbers = (each.suffix for each in found if each.suffix or not each.is_zero)
    suffix, count = Counter(of_numbers).most_common(1)[0]
    if count > _NEARLY_ALL * len(suffixed) and suffix not in _EXPONENTS:
        return _Column(suffix, is_mixed=False)
    base, count = Counter(_divided(each.suffix)[1] for each in suffixed).most_common(1)[0]
    return _Column(base, is_mixed=True) if count > _NEARLY_ALL * len(suffixed) else None


def _parsed(cell: str) -> _Cell | None:
    """Return a cell that is a number, perhaps with a unit or a prefix behind it; None for any other."""
    match = _CELL.fullmatch(cell)
    if match is None:
        return None
    suffix = match[3] or ""
    if suffix and not (suffix in _EXPONENTS or suffix in PERCENT or is_unit(suffix)):
        return None
    return _Cell(match[1], int(match[2] or 0), suffix)


def _divided(suffix: str) -> tuple[str, str]:
    """Return the prefix and the unit of what stands behind a number."""
    if suffix in _EXPONENTS:
        return suffix, ""
    prefix, base = suffix[0], suffix[1:]
    return (prefix, base) if prefix in _EXPONENTS and is_unit(base) else ("", suffix)


def _row(line: str, delimiter: str, columns: Sequence[_Column | None]) -> str | None:
    """Return a line with plain numbers in the columns that have units; None where it is no row of these."""
    cells = split(line, delimiter)
    if len(cells) != len(columns) or not _has_cells(line.encode()):
        return None
    plain = [cell if of is None else of.plain(cell) for cell, of in zip(cells, columns, strict=True)]
    if all(new is None for new, of in zip(plain, columns, strict=True) if of is not None):
        return None
    written = [old if new is None else new for old, new in zip(cells, plain, strict=True)]
    return delimiter.join(f'"{cell}"' if delimiter in cell else cell for cell in written)
