"""Choice of a column of a table, with the unit, gain and offset of its values."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchtool.errors import AnalysisError
from benchtool.tables.head import Column
from benchtool.tables.layout import Layout
from benchtool.tables.scaling import Scaling, scaling, speed_hint
from benchtool.tables.unit_in_name import (
    name_before_last_unit,
    name_before_unit,
    perhaps_in_name,
    unit_in_name,
)
from benchtool.tables.units import (
    PERCENT,
    is_reciprocal_second,
    unit_factor,
    units_of,
)

_SPEED, _TORQUE = "rad/s", "Nm"
_FACTOR = re.compile(
    r"(?<![A-Za-z0-9])[xX]\s*(?:10+(?!\d)|0\.\d+)|[×*·]\s*(?:10+(?!\d)|0\.\d+)|(?<!\d)10+\s*[xX×*](?![A-Za-z0-9])"
    r"|10\^[+-]?\d+|(?<![\w.])1[eE][+-]?\d+(?!\w)"
)
_SCALED = re.compile(r"(?P<name>[^*+]+?)\s*(?P<by>[*+-].+)")
_OF_AN_ANGLE = re.compile(r"omega|ω|^w([_\s(\[]|$)|angular|winkelgeschw|kreisfreq", re.IGNORECASE)


@dataclass(frozen=True)
class Selection:
    """A column that was asked for: `number` counts from 1, (cell x gain + offset) x factor is in `si_unit`.

    `unit_from` is "option", "head", or "assumed" where neither states anything, "size" where that of a time
    tells it; `unit` is that of the value after gain and offset. `unit_in_head` is set where the option states
    another one of the same kind, and no gain that would lie between them.
    """

    number: int
    name: str
    unit: str
    unit_from: str
    factor: float
    si_unit: str
    gain: float = 1.0
    offset: float = 0.0
    unit_in_head: str = ""

    @property
    def in_option(self) -> str:
        """What an option calls it: its name or, of a column without one, its number."""
        return self.name or str(self.number)

    @property
    def scale(self) -> tuple[str, float, float, float]:
        """What makes values in SI of the cells: unit, factor, gain and offset."""
        return self.si_unit, self.factor, self.gain, self.offset

    @property
    def scale_text(self) -> str:
        """The unit, with gain and offset, as an option states them."""
        gain = "" if self.gain == 1.0 else f"*{self.gain:g}"
        return f"{self.unit}{gain}{f'{self.offset:+g}' if self.offset else ''}"


def selection_of(path: Path, layout: Layout, wanted: str, si_unit: str, rated: float | None) -> Selection:
    """`TextTable.select` of a layout; `path` stands in the messages."""
    number = _find(path, layout, wanted)
    stated = Scaling("")
    if number is None and ":" in wanted:
        name, _, behind = wanted.rpartition(":")
        number, stated = _find(path, layout, name), scaling(behind, si_unit)
        wanted = name
    if number is None:
        hint = speed_hint(wanted) if si_unit == _SPEED else ""
        parts = wanted.split(",")
        if not hint and len(parts) > 1 and all(_find(path, layout, part) is not None for part in parts):
            hint = ", and the option once for each column"
        scaled = _SCALED.fullmatch(wanted)
        if not hint and scaled is not None and _find(path, layout, scaled["name"]) is not None:
            hint = f"; gain and offset follow a unit, as '{scaled['name']}:{si_unit}{scaled['by']}'"
        raise AnalysisError(
            f"{path} has no column '{wanted}', {listed(layout)}: give a name or a number{hint}"
        )
    column = layout.columns[number].called(wanted)
    asked = stated.unit or si_unit
    if column.stamps and asked != "s":
        raise AnalysisError(
            f"column '{wanted}' of {path} holds times of day, numbers in {asked} are expected: "
            f"choose another column, or name this one as the time"
        )
    if column.open_sign:
        raise AnalysisError(
            f"'{column.open_sign}' in column '{wanted}' of {path} may be the decimal sign or stand between "
            f"thousands, as every number that has one has three digits behind it: state --decimal . or "
            f"--decimal ,"
        )
    unit, unit_from = _unit(column, si_unit)
    unit_in_head = unit if unit_from == "head" and _differs(unit, stated, si_unit) else ""
    if stated.unit:
        unit, unit_from = stated.unit, "option"
    if stated.unit and "*" in stated.unit and unit_factor(unit, si_unit) is None:
        raise AnalysisError(
            f"'{unit}' of column '{wanted}' is no unit with a gain and an offset: they are written as "
            f"A*10-0.2, with decimal points, the value is cell x gain + offset"
        )
    factor = unit_factor(unit, si_unit)
    if factor is None and rated is not None and unit.lower() in PERCENT:
        factor = rated / 100.0
    if unit_from == "assumed" and (elsewhere := _unit_elsewhere(layout, si_unit)):
        raise AnalysisError(
            f"{path} has the unit '{elsewhere}', but not of which column; '{wanted}' has none: "
            f"state it in the option, as '{wanted}:{si_unit}' or '{wanted}:{elsewhere}'"
        )
    if unit_from == "assumed" and (perhaps := perhaps_in_name(column.bare_name, si_unit)):
        example = perhaps if unit_factor(perhaps, si_unit) is not None else si_unit
        raise AnalysisError(
            f"the name of column '{wanted}' of {path} has '{perhaps}' in it, which may be its unit or scale: "
            f"state it in the option, as '{wanted}:{example}', with a gain where one step is another size, "
            f"as '{wanted}:{si_unit}*0.01'"
        )
    if factor is None:
        is_percent = si_unit == _TORQUE and unit.lower() in PERCENT
        of_rated = "; of percent state what 100 % is, as --rated-torque 2" if is_percent else ""
        by = "which its head states" if unit_from == "head" else "as given"
        counts = "; of a column that counts rows state --rate instead" if si_unit == "s" else ""
        if counts and layout.row_distance is not None:
            counts += f", by the head --rate {1.0 / layout.row_distance.seconds:g}"
        raise AnalysisError(
            f"'{unit}' is no unit of column '{wanted}', {by}; expected is one of "
            f"{units_of(si_unit)}: state it in the option, as '{wanted}:{si_unit}', with a gain where "
            f"one step is another size, as '{wanted}:{si_unit}*0.01'{of_rated}{counts}"
        )
    if not stated.unit and (match := _FACTOR.search(column.name)):
        raise AnalysisError(
            f"'{match[0]}' in the name of column '{wanted}' of {path} may be a factor of its values: state "
            f"the unit of a cell, as '{wanted}:{unit}', with the gain if it is one, as '{wanted}:{unit}*0.01'"
        )
    if unit_from == "head" and is_reciprocal_second(unit) and _OF_AN_ANGLE.search(column.name):
        raise AnalysisError(
            f"'{unit}' of column '{wanted}' may be rad/s, as its name says, or revolutions per second: state "
            f"it in the option, as '{wanted}:rad/s' or '{wanted}:rev/s'"
        )
    return Selection(
        number + 1, column.name, unit, unit_from, factor, si_unit, stated.gain, stated.offset, unit_in_head
    )


def _unit(column: Column, si_unit: str) -> tuple[str, str]:
    """Return the unit of a column, and where it is from: "head", or "assumed" if that states none.

    What may be an index is a unit where it is one of the kind (`t [d]`), as is the end of a name (`Iq_mA`).
    """
    if column.unit:
        return column.unit, "head"
    if column.in_brackets and unit_factor(column.in_brackets, si_unit) is not None:
        return column.in_brackets, "head"
    named = unit_in_name(column.bare_name, si_unit)
    if named or column.stated_unit:
        return named or column.stated_unit, "head"
    return si_unit, "assumed"


def _differs(unit: str, stated: Scaling, si_unit: str) -> bool:
    """Return whether an option states another unit of the kind than `unit`, and no gain between them.

    Of 1/s, which is two units, it states which.
    """
    factors = [unit_factor(each, si_unit) for each in (unit, stated.unit)]
    are_open = is_reciprocal_second(unit) or stated.gain != 1.0 or not stated.unit
    return not are_open and None not in factors and factors[0] != factors[1]


def _unit_elsewhere(layout: Layout, si_unit: str) -> str:
    """Return a unit of the kind in the head, or beside the numbers, that is not SI and of no column; empty if
    there is none."""
    used = {column.unit for column in layout.columns}
    other = (each for each in layout.head_units if each not in used)
    return next((each for each in other if unit_factor(each, si_unit) not in (None, 1.0)), "")


def by_number(wanted: str) -> int | None:
    """Return the number that a column is asked for by, without its unit: `2`, `2:mA`; None for a name."""
    text = wanted.partition(":")[0].strip()
    return int(text) if re.fullmatch(r"[0-9]{1,6}", text) else None


def hides(layout: Layout, number: int) -> int | None:
    """Return the number of the column that is called by another one's number; None where there is none."""
    if not 1 <= number <= len(layout.columns):
        return None
    called = [place for place, column in enumerate(layout.columns, 1) if column.bare_name == str(number)]
    return called[0] if called and called[0] != number else None


def _find(path: Path, layout: Layout, wanted: str) -> int | None:
    """Return the place of the column of that name or number, None where there is none."""
    wanted = wanted.strip()
    columns = layout.columns
    if match := re.fullmatch(r"#([0-9]{1,6})", wanted):
        return int(match[1]) - 1 if 1 <= int(match[1]) <= len(columns) else None
    names = [column.name for column in columns]
    bare = [column.bare_name for column in columns]
    joined = [name_before_unit(name) for name in bare]
    exact: list[Sequence[tuple[str, ...]]] = [
        *([(name,) for name in each] for each in (names, bare, joined)),
        [(column.name_before_brackets, name_before_last_unit(column.name)) for column in columns],
        [(column.other_name, *column.aliases) for column in columns],
    ]
    ways: list[tuple[Sequence[tuple[str, ...]], str]] = [(spelt, wanted) for spelt in exact]
    ways += [([tuple(map(str.lower, each)) for each in spelt], wanted.lower()) for spelt in exact]
    for spelt, name in ways:
        places = [place for place, each in enumerate(spelt) if name and name in each]
        if len(places) > 1:
            numbers = ", ".join(str(place + 1) for place in places)
            raise AnalysisError(
                f"{path} has {len(places)} columns '{wanted}', with the numbers {numbers}: give one"
            )
        if places:
            return places[0]
    if re.fullmatch(r"[0-9]{1,6}", wanted) and 1 <= int(wanted) <= len(columns):
        return int(wanted) - 1
    return None


def _called(column: Column) -> str:
    """Return the name of a column, and what further lines of the head call it."""
    others = " or ".join(f"'{alias}'" for alias in column.aliases)
    return f"'{column.name}' ({others})" if others else f"'{column.name}'"


def listed(layout: Layout) -> str:
    """Return what the columns are called, for a message."""
    columns = layout.columns
    if not any(column.name for column in columns):
        head = f" (its head '{layout.head:.40}' is not of {len(columns)} cells)" if layout.head else ""
        separated = {"\t": "tabs", " ": "blanks"}.get(layout.delimiter, f"'{layout.delimiter}'")
        return f"it has no names{head}, and columns 1 to {len(columns)} separated by {separated}"
    listed = [f"{number} {_called(column)}" for number, column in enumerate(columns[:20], 1)]
    more = f" and {len(columns) - 20} more" if len(columns) > 20 else ""
    return f"it has {', '.join(listed)}{more}"
