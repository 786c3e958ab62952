"""Readings of a gauge study from a table: one reading a line, with its part, operator and mounting."""

from __future__ import annotations

import csv
import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import count_of
from benchtool.errors import AnalysisError, NoSuchRecording, RecordingError
from benchtool.file_kinds import FileKind, mistaken

FACTORS = ("part", "operator", "mounting")
"""Columns that say whose a reading is; each may be absent, but not all."""

_REPETITION = "repetition"
_LARGEST_BYTES = 1 << 26
_DELIMITERS = ",;\t|"


@dataclass(frozen=True)
class Readings:
    """A balanced set of readings.

    `values` have shape (parts, operators, mountings, repetitions), in the unit of the table; a factor that
    the table does not have counts one. `name` is the column's, and `labels` those of parts and operators.
    """

    name: str
    values: NDArray[np.float64]
    parts: tuple[str, ...]
    operators: tuple[str, ...]


def read_readings(path: Path, column: str = "") -> Readings:
    """Read a table with a line for each reading.

    Columns `part`, `operator` and `mounting` are taken in any case, `repetition` is not needed: lines of the
    same labels are repetitions. Mountings are those of a part by an operator, whatever their labels are.

    Args:
        path: text with commas, semicolons, tabs or bars between the cells; with other separators than commas
            a decimal comma is understood.
        column: name of the readings' column, if several are left.

    Raises:
        RecordingError: the file cannot be read as such a table.
        AnalysisError: a column is missing, a reading is not a number, or the set is not balanced.
    """
    head, rows, delimiter = _cells(path)
    places = {name.strip().lower(): place for place, name in reversed(list(enumerate(head)))}
    factors = [factor for factor in FACTORS if factor in places]
    if not factors:
        raise AnalysisError(
            f"{path} has the columns {_listed(head)}: one or more of {', '.join(FACTORS)} are expected"
        )
    others = [name for name in head if name.strip().lower() not in (*FACTORS, _REPETITION)]
    if column and column not in others:
        raise AnalysisError(f"{path} has no readings '{column}', it has {_listed(others)}: give one of these")
    if not column and len(others) != 1:
        raise AnalysisError(
            f"{path} has {len(others)} columns beside the factors ({_listed(others)}), one with the readings "
            f"is expected: name it with --value"
        )
    name = column or others[0]
    groups: dict[tuple[str, ...], list[float]] = defaultdict(list)
    for line, row in rows:
        key = tuple(row[places[factor]].strip() if factor in factors else "" for factor in FACTORS)
        for factor, label in zip(FACTORS, key, strict=True):
            if factor in factors and not label:
                raise AnalysisError(f"{path}, line {line}: no {factor} is named: complete or remove the line")
        groups[key].append(_number(row[head.index(name)], delimiter, f"{path}, line {line}, '{name}'"))
    return _balanced(path, name.strip(), groups)


def _cells(path: Path) -> tuple[list[str], list[tuple[int, list[str]]], str]:
    """Return the names of the columns, the lines below with their numbers, and what separates cells."""
    if told := mistaken(path, FileKind.TABLE):
        raise NoSuchRecording(told)
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise RecordingError(f"{path} has more than 64 MiB: a line for each reading is expected")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as reason:
        what = getattr(reason, "strerror", None) or "it is not text in UTF-8"
        absent = isinstance(reason, FileNotFoundError | IsADirectoryError | ValueError)
        kind = NoSuchRecording if absent else RecordingError
        raise kind(
            f"cannot read {path}: {what}; a table with a line for each reading is expected: check the name"
        ) from None
    lines = text.splitlines()
    first = next((line for line in lines if line.strip()), "")
    delimiter = max(_DELIMITERS, key=first.count)
    try:
        rows = [(number, row) for number, row in _rows(lines, delimiter) if any(cell.strip() for cell in row)]
    except csv.Error as reason:
        raise RecordingError(f"{path} cannot be read as a table: {reason}: export it again as CSV") from None
    if len(rows) < 2:
        found = count_of(len(rows), "line")
        raise NoSuchRecording(f"{path} has {found}, a head and a line for each reading are expected")
    (_, head), *below = rows
    for number, row in below:
        if len(row) != len(head):
            raise RecordingError(
                f"{path}, line {number}: {len(row)} cells, the head has {len(head)}: correct the line"
            )
    return head, below, delimiter


def _rows(lines: Sequence[str], delimiter: str) -> list[tuple[int, list[str]]]:
    reader = csv.reader(lines, delimiter=delimiter)
    return [(reader.line_num, row) for row in reader]


def _number(cell: str, delimiter: str, where: str) -> float:
    text = cell.strip()
    if delimiter != "," and text.count(",") == 1 and "." not in text:
        text = text.replace(",", ".")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise AnalysisError(
            f"{where}: '{cell.strip():.40}' is no finite number: correct or repeat the reading"
        )
    return value


def _balanced(path: Path, name: str, groups: dict[tuple[str, ...], list[float]]) -> Readings:
    parts, operators = (tuple(dict.fromkeys(key[place] for key in groups)) for place in (0, 1))
    cells: dict[tuple[str, str], list[list[float]]] = defaultdict(list)
    for (part, operator, _), values in groups.items():
        cells[part, operator].append(values)
    absent = [(part, operator) for part in parts for operator in operators if (part, operator) not in cells]
    if absent:
        raise AnalysisError(
            f"{path} has no readings of part '{absent[0][0]}' by operator '{absent[0][1]}'"
            f"{f' and of {len(absent) - 1} more pairs' if len(absent) > 1 else ''}: each operator measures "
            f"each part as often"
        )
    counts = {
        key: (len(mountings), *(len(values) for values in mountings)) for key, mountings in cells.items()
    }
    usual = Counter(counts.values()).most_common(1)[0][0]
    for (part, operator), count in counts.items():
        if count != usual:
            raise AnalysisError(
                f"{path}: part '{part}' by operator '{operator}' has {_counted(count)}, others have "
                f"{_counted(usual)}: add or remove readings until all have as many"
            )
    if len(set(usual[1:])) > 1:
        raise AnalysisError(f"{path}: mountings have {_counted(usual)}: have as many of each")
    array: NDArray[np.float64] = np.array(
        [[cells[pair] for pair in product((part,), operators)] for part in parts]
    )
    if array.shape[3] == 1:
        if array.shape[2] == 1:
            raise AnalysisError(
                f"{path} has one reading of each part by each operator: two or more are needed, since the "
                f"spread of repetitions is what others are held against"
            )
        array = array.swapaxes(2, 3)  # one reading of each mounting: mountings are the repetitions
    return Readings(name, array, parts, operators)


def _counted(count: tuple[int, ...]) -> str:
    mountings, *readings = count
    listed = ", ".join(str(each) for each in dict.fromkeys(readings))
    return f"{listed} readings" if mountings == 1 else f"{mountings} mountings with {listed} readings"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"'{name.strip()}'" for name in names[:20]) or "none"
