"""Remarks on the units that the columns of a table were taken in."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from benchtool.tables.asked_columns import known_analysis
from benchtool.tables.head import Column
from benchtool.tables.record import Record
from benchtool.tables.remarks import Remark, RemarkKind
from benchtool.tables.selection import Selection
from benchtool.tables.units import is_listed, unit_factor

_OFTEN_IN: Mapping[str, tuple[str, str, str]] = {
    "time": ("seconds were", "every frequency rests", "ms"),
    "speed": ("rad/s was", "all of its numbers rest", "rpm"),
    "angle": ("rad was", "every order rests", "deg"),
}
_ELECTRICAL = re.compile(
    r"(?<![a-z])(?:el|elec\w*|elektr\w*|électr\w*|erpm)(?![a-z])"
    r"|(?<![a-z])(?:theta|omega|phi|w|[θωφ])_?e(?:l|lec)?(?![a-z])",
    re.IGNORECASE,
)
_SEVERAL = 3.0  # times its reference: a response that ends there is rather in another unit
_NEAR = 0.03  # by which a reference differs from its level, and a response from the ratio of two units
_OFTEN_MISTAKEN: Mapping[str, tuple[tuple[float, str, str], ...]] = {
    "rad/s": (
        (30.0 / math.pi, "rpm", "rad/s"),
        (60.0, "rpm", "rev/s"),
        (6.0, "deg/s", "rpm"),
        (180.0 / math.pi, "deg/s", "rad/s"),
        (2.0 * math.pi, "rad/s", "rev/s"),
    ),
    "rad": ((180.0 / math.pi, "deg", "rad"), (2.0 * math.pi, "rad", "rev"), (360.0, "deg", "rev")),
    "Nm": ((100.0, "Ncm", "Nm"),),
}
"""Ratios of numbers of one quantity by its SI unit, that of the larger ones and that of the smaller."""


def units_assumed(chosen: Mapping[str, Selection]) -> Iterator[Remark]:
    """Yield that SI was assumed of a time, speed or angle without a unit, which often are in another one, and
    of a column with words in brackets that are not known to describe one."""
    for what, each in chosen.items():
        if each.unit_from != "assumed":
            continue
        name, words = each.in_option, Column(each.name, "").in_brackets
        if words and not is_listed(words):
            text = (
                f"'{words}' in the head of column '{name}' was taken for a description, and {each.si_unit} "
                f"assumed: if it is a unit, state it, as --{what.partition('_')[0]} '{each.number}:UNIT*GAIN'"
            )
            yield Remark(RemarkKind.UNIT_ASSUMED, what, text)
        elif what in _OFTEN_IN:
            taken, on_it, other = _OFTEN_IN[what]
            text = (
                f"the unit of the {what} '{name}' is not stated, {taken} taken, and {on_it} on that: state "
                f"it, as --{what} '{name}:{other}'"
            )
            yield Remark(RemarkKind.UNIT_ASSUMED, what, text)


def electrical(chosen: Mapping[str, Selection], pole_pairs: int | None) -> Iterator[Remark]:
    """Yield that a speed or an angle is by its name an electrical one, where no gain makes it mechanical."""
    for what in ("speed", "angle"):
        each = chosen.get(what)
        if each is None or each.gain != 1.0 or not _ELECTRICAL.search(each.name):
            continue
        of, pairs = each.in_option, pole_pairs or 4
        effect = (
            f"a mechanical one is smaller by the pole pairs: state the gain, as --speed "
            f"'{of}:{each.unit}*{1.0 / pairs:.4g}' for {pairs}"
            if what == "speed"
            else "orders are counted in each of its turns, not in those of the shaft"
        )
        text = f"the {what} '{of}' is by its name electrical, and was taken as mechanical: {effect}"
        yield Remark(RemarkKind.ELECTRICAL, what, text)


def units_contradicted(chosen: Mapping[str, Selection]) -> Iterator[Remark]:
    """Yield that an option states another unit than the head does, of the same kind."""
    for what, each in chosen.items():
        if not each.unit_in_head:
            continue
        in_head, in_option = (unit_factor(unit, each.si_unit) for unit in (each.unit_in_head, each.unit))
        if in_head and in_option:
            text = (
                f"the head has '{each.unit_in_head}' for column '{each.in_option}', and the option "
                f"'{each.unit}', which was taken: its numbers are {in_option / in_head:.4g} times those by "
                f"the head; if the head is right, leave the unit out of the option"
            )
            yield Remark(RemarkKind.UNIT_CONTRADICTED, what, text)


def other_units(
    record: Record, asked: Mapping[str, Mapping[str, str]], chosen: Mapping[str, Selection]
) -> Iterator[Remark]:
    """Yield that the signal of a step ends at several times its reference, or at a small part of it, where
    the head does not state the units of both; `asked` are the analyses, with kinds of `chosen`."""
    for name, settings in asked.items():
        if not {"signal", "reference"} <= set(known_analysis(name).channel_settings):
            continue
        kinds = [settings.get(key, "") for key in ("signal", "reference")]
        if not all(kinds) or all(chosen[kind].unit_from == "head" for kind in kinds):
            continue
        ratio = _ratio_at_end(*map(record.column, kinds))
        if not math.isfinite(ratio) or 1.0 / _SEVERAL < abs(ratio) < _SEVERAL:
            continue
        signal, reference = (chosen[kind].in_option for kind in kinds)
        text = (
            f"'{signal}' ends at {ratio:.4g} times its reference '{reference}', and the head does not state "
            f"the units of both{_likely(abs(ratio), chosen[kinds[0]].si_unit, signal, reference)}: state "
            f"them where the columns are asked for, as '{signal}:UNIT'"
        )
        yield Remark(RemarkKind.OTHER_UNITS, kinds[0], text)


def _ratio_at_end(signal: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the change of a signal over that of its reference, from before the reference's largest change
    to the later half of the rows that have it; nan where the reference does not change."""
    changes = reference - reference[0]
    largest = float(changes[np.argmax(np.abs(changes))])
    if largest == 0.0:
        return math.nan
    before = np.abs(changes) < _NEAR * abs(largest)
    there = np.flatnonzero(np.abs(changes - largest) < _NEAR * abs(largest))
    late = there[len(there) // 2 :]
    rise = float(np.median(signal[late]) - np.median(signal[before]))
    return rise / float(np.median(changes[late]))


def _likely(ratio: float, unit: str, signal: str, reference: str) -> str:
    """Return which two units have that ratio, as words to add; empty where none is known."""
    larger, smaller = (signal, reference) if ratio > 1.0 else (reference, signal)
    times = max(ratio, 1.0 / ratio) if ratio else math.inf
    for each, of_larger, of_smaller in (*_OFTEN_MISTAKEN.get(unit, ()), (1000.0, f"m{unit}", unit)):
        if abs(times / each - 1.0) < _NEAR:
            return (
                f"; that is the ratio of {of_larger} to {of_smaller}, '{larger}' may be in {of_larger} and "
                f"'{smaller}' in {of_smaller}"
            )
    return ""
