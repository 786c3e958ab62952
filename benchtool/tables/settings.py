"""Settings of an instrument in the head of a table: a label, and what it states of columns and rows."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from benchtool.tables.cells import BLANKS
from benchtool.tables.head import Column, bare_line, has_number, split
from benchtool.tables.units import KNOWN, unit_factor

_UNIT = r"(?:units?(?:[ _-]*label)?|einheit(?:en)?)"
_OF_VALUES = re.compile(rf"(?:(?:vertical|y|v|channels?|signals?|data)[ _-]*)?{_UNIT}", re.IGNORECASE)
_OF_TIMES = re.compile(rf"(?:horizontal|x|h|time|zeit)[ _-]*{_UNIT}", re.IGNORECASE)
_DISTANCE = re.compile(
    r"(?:(?:sampl(?:e|ing)|x|t|time)[ _-]*)?(?:interval|increment)|[xt][ _-]?inc|time[ _-]*step"
    r"|sampl(?:e|ing)[ _-]*(?:period|time)|h[ _-]?resolution|delta[ _-]?[xt]|dt|clock"
    r"|abtast(?:intervall|zeit)",
    re.IGNORECASE,
)
_RATE = re.compile(r"sampl(?:e|ing)[ _-]*(?:rate|freq(?:uency)?)|abtastrate|fs", re.IGNORECASE)
_BELOW = re.compile(r"(?:[xt][ _-]?)?inc(?:rement)?", re.IGNORECASE)  # a label that its number is below
_AMOUNT = re.compile(r"(?:[^\W\d]\w*:)?\s*([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?)\s*([^\W\d_][\w/]*)?")
_WITH_UNIT = re.compile(r"(.+?)\s*[(\[]([^()\[\]]+)[)\]]")
_PER_SECOND = {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "sa/s": 1.0, "ksa/s": 1e3, "s/s": 1.0, "ks/s": 1e3}
_LONGEST_UNIT = 12


@dataclass(frozen=True)
class RowDistance:
    """What a line of the head states of the distance of rows in time."""

    seconds: float
    line: str


@dataclass(frozen=True)
class Setting:
    """A line of a label and its values, those at the end that are empty left out."""

    label: str
    values: tuple[str, ...]
    line: str


def settings_of(lines: Iterable[str], delimiter: str) -> tuple[Setting, ...]:
    """Return the lines that begin with a label, as `Sample Interval,1e-4`, `#UNITS:V`, and each assignment in
    a cell, as `tInc = 1e-4`."""
    return tuple(itertools.chain.from_iterable(_settings_in(line, delimiter) for line in lines))


def with_stated_units(
    columns: Sequence[Column], settings: Iterable[Setting], numeric: Sequence[bool]
) -> tuple[Column, ...]:
    """Return columns with the units that settings state for them.

    Values of a vertical unit are those of the columns, of all from the second on, or of channels by their
    names (`CH1:V`); one is that of all but the first of several columns of numbers, which is the time of a
    horizontal unit. Of one that is not SI it is left open which columns have it.
    """
    places = [place for place, is_numeric in enumerate(numeric) if is_numeric]
    found: dict[int, str] = {}
    for setting in settings:
        if _OF_TIMES.fullmatch(setting.label) and len(places) > 1:
            unit = next(filter(None, setting.values), "")
            known = next((each for each in (unit, unit.lower()) if unit_factor(each, "s") is not None), "")
            found |= {places[0]: known} if known and not _is_scaled(known) else {}
        elif _OF_VALUES.fullmatch(setting.label):
            found |= _by_place(setting.values, columns, places)
    return tuple(replace(column, stated_unit=found.get(place, "")) for place, column in enumerate(columns))


def row_distance(settings: Sequence[Setting], lines: Sequence[str], delimiter: str) -> RowDistance | None:
    """Return the distance of rows that the head states, as an interval or a rate; None where it states none,
    or several that differ."""
    stated = [
        RowDistance(seconds, setting.line)
        for setting in settings
        if (is_rate := _RATE.fullmatch(setting.label) is not None) or _DISTANCE.fullmatch(setting.label)
        for value in setting.values
        if math.isfinite(seconds := _seconds(value, is_rate=is_rate))
    ]
    for above, below in itertools.pairwise(lines):
        for label, value in zip(split(above, delimiter), split(below, delimiter), strict=False):
            if _BELOW.fullmatch(label) and math.isfinite(seconds := _seconds(value, is_rate=False)):
                stated.append(RowDistance(seconds, f"{label} {value}"))
    first = next(iter(stated), None)
    is_one = all(math.isclose(each.seconds, stated[0].seconds, rel_tol=1e-3) for each in stated)
    return first if is_one else None


def _settings_in(line: str, delimiter: str) -> Iterator[Setting]:
    text = bare_line(line)
    cells = re.split(r"\s{2,}|\t|,", text) if delimiter == BLANKS else split(text, delimiter)
    for place, cell in enumerate(cells):
        label, sign, value = _partition(cell)
        if sign and (place or len(cells) == 1):
            yield Setting(label, (value,), cell[:60])
    label, sign, value = _partition(cells[0]) if cells else ("", "", "")
    values = [*([value] if sign else []), *(each.strip("()[] ") for each in cells[1:])]
    values = ["" if each == label else each for each in values]  # label and value for each channel
    if match := _WITH_UNIT.fullmatch(label):
        label = match[1]
        values = [f"{each} {match[2]}" if has_number(each) else each for each in values]
    while values and not values[-1]:
        del values[-1]
    if label and values and not has_number(label):
        yield Setting(label, tuple(values), text[:60])


def _partition(cell: str) -> tuple[str, str, str]:
    label, sign, value = next(
        (parts for parts in (cell.partition("="), cell.partition(":")) if parts[1]), (cell, "", "")
    )
    return label.strip(), sign, value.strip("()[] ")


def _by_place(values: Sequence[str], columns: Sequence[Column], places: Sequence[int]) -> dict[int, str]:
    """Return the units by the places of their columns, of `places` with numbers."""
    named = [value.rpartition(":") for value in values if value]
    if all(name for name, _, _ in named):
        of_name = {column.name: place for place, column in enumerate(columns) if column.name}
        return {of_name[name]: unit for name, _, unit in named if name in of_name and _may_be_unit(unit)}
    units = [unit for _, _, unit in named]
    if not all(map(_may_be_unit, units)):
        return {}
    if len(units) == 1:
        return {} if _is_scaled(units[0]) else dict.fromkeys(places[1:] or places, units[0])
    shift = len(columns) - len(values)
    if shift not in (0, 1):
        return {}
    return {place + shift: unit for place, unit in enumerate(values) if unit}


def _is_scaled(unit: str) -> bool:
    """Return whether a unit is one that is known, and not SI."""
    factors = [unit_factor(unit, each) for each in KNOWN]
    return any(each is not None for each in factors) and 1.0 not in factors


def _may_be_unit(text: str) -> bool:
    return bool(text) and len(text) <= _LONGEST_UNIT and not has_number(text) and " " not in text


def _seconds(value: str, *, is_rate: bool) -> float:
    """Return the distance of rows by a cell, with a unit or in SI; nan where it is no such amount."""
    match = _AMOUNT.fullmatch(value)
    if match is None or not float(match[1]) > 0.0:
        return math.nan
    amount, unit = float(match[1]), match[2] or ("Hz" if is_rate else "s")
    if (per_second := _PER_SECOND.get(unit.lower())) is not None:
        return 1.0 / (amount * per_second)
    factors = (unit_factor(each, "s") for each in (unit, unit.lower()))
    return next((amount * factor for factor in factors if factor is not None), math.nan)
