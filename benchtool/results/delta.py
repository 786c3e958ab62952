"""The difference of one measurement between two runs: its size, its uncertainty, and what they decide."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from benchtool.analysis import NOTHING, Measurement, Uncertainty, number, placed, signed, with_expanded
from benchtool.plan import Limit
from benchtool.results.comparability import of_two_quantities, uncertainty_of_difference, why_undecided

Judgement: TypeAlias = Literal["", "better", "worse"]
"""What a limit says of a difference."""


@dataclass(frozen=True)
class Delta:
    """One measurement of a run against that of the reference, both in `unit`.

    `absolute` is the value less the reference, `percent` of the reference's magnitude; `percent_reason` says
    why a difference has none. `uncertainty` is that of the difference, with the repeatability of both; errors
    of instruments that both have in common cancel. It is None where one of them has none. `exceeds` tells
    whether the difference is more than the expanded uncertainty, with k from the effective degrees of freedom
    of both; None where there is none. `judgement` is empty where no limit defines which direction is better,
    or where the difference does not exceed its uncertainty. `reason` says why two values are not compared, so
    that nothing is decided, and `uncertainty_reason` why values of one quantity have no uncertainty of their
    difference.

    `reference_below` and `value_below` are what a value that is not there is less than. Of one that is not
    there the difference is known to be `above` or `below` something, with the expanded uncertainty of the
    other value, and exceeds that where it cannot be zero.
    """

    name: str
    unit: str
    reference: float
    value: float
    absolute: float
    percent: float
    uncertainty: Uncertainty | None
    exceeds: bool | None
    judgement: Judgement
    reason: str = ""
    uncertainty_reason: str = ""
    percent_reason: str = ""
    reference_below: float | None = None
    value_below: float | None = None
    above: float | None = None
    below: float | None = None

    @property
    def standard(self) -> float:
        """Standard uncertainty of the difference; nan where there is none."""
        return math.nan if self.uncertainty is None else self.uncertainty.standard

    @property
    def expanded(self) -> float | None:
        """Expanded uncertainty of the difference; None where there is none."""
        return None if self.uncertainty is None else self.uncertainty.expanded

    @property
    def text(self) -> str:
        """The difference with its sign and its expanded uncertainty, as far as there is one, or its bound."""
        if self.above is not None:
            return f"> {signed(self.above, 2)}"
        if self.below is not None:
            return f"< {signed(self.below, 2)}"
        text = with_expanded(self.absolute, self.uncertainty)
        return _with_sign(text, self.absolute) if "±" in text else signed(self.absolute)

    @property
    def percent_text(self) -> str:
        """It in percent, with its sign and to the place of its uncertainty; empty where it is not."""
        if not math.isfinite(self.percent):
            return ""
        if self.expanded is None or not math.isfinite(self.expanded):
            return signed(self.percent, 2)
        U = 100.0 * self.expanded / abs(self.reference)
        return _with_sign(placed(self.percent, U), self.percent)

    def marked_percent(self, unit: str = "") -> str:
        """Return it in percent, with that behind it, and whether it exceeds its uncertainty (`*`) or does not
        (`~`); a dash where neither is known."""
        mark = {True: "*", False: "~", None: ""}[self.exceeds]
        percent = f"{self.percent_text}{unit}" if self.percent_text else ""
        return f"{percent}{mark}" or NOTHING

    @property
    def reference_text(self) -> str:
        """The reference to the place of the uncertainty of the difference, so that it shows it."""
        return self._placed(self.reference, self.reference_below)

    @property
    def value_text(self) -> str:
        """The value to the place of the uncertainty of the difference."""
        return self._placed(self.value, self.value_below)

    def _placed(self, value: float, below: float | None) -> str:
        return placed(value, self.expanded) if below is None else f"< {number(below, 2)}"

    def to_json(self) -> dict[str, Any]:
        """Return the fields; nan, and a judgement that is not made, become null."""
        known = {
            "above": self.above,
            "below": self.below,
            "reason": self.reason or None,
            "uncertainty_reason": self.uncertainty_reason or None,
            "percent_reason": self.percent_reason or None,
        }
        return {
            "unit": self.unit,
            "reference": _finite(self.reference),
            "value": _finite(self.value),
            "absolute": _finite(self.absolute),
            "percent": _finite(self.percent),
            "standard_uncertainty": _finite(self.standard),
            "experimental_uncertainty": None
            if self.uncertainty is None
            else _finite(self.uncertainty.experimental),
            "dof": None if self.uncertainty is None else _finite(self.uncertainty.dof),
            "student_factor": None if self.uncertainty is None else self.uncertainty.student_factor,
            "k": None if self.uncertainty is None else _finite(self.uncertainty.k),
            "expanded_uncertainty": None if self.expanded is None else _finite(self.expanded),
            "exceeds_uncertainty": self.exceeds,
            "judgement": self.judgement or None,
            **{key: value for key, value in known.items() if value is not None},
        }


class Measured(Protocol):
    """What was measured, with the limits that say which direction is good."""

    @property
    def measurements(self) -> tuple[Measurement, ...]: ...

    @property
    def limits(self) -> Mapping[str, Limit]: ...


def deltas(reference: Measured, other: Measured) -> tuple[Delta, ...]:
    """Return the differences of every measurement that both have in the same unit."""
    return tuple(_deltas(reference, other))


def _deltas(reference: Measured, other: Measured) -> Iterator[Delta]:
    found = {each.name: each for each in other.measurements}
    for one in reference.measurements:
        two = found.get(one.name)
        if two is not None and two.unit == one.unit:
            limits = [each.limits[one.name] for each in (reference, other) if one.name in each.limits]
            yield _delta(one, two, limits)


def _delta(one: Measurement, two: Measurement, limits: Sequence[Limit]) -> Delta:
    """Return the difference of a measurement to that of the reference, `one`."""
    absolute = two.value - one.value
    reason = _untold(one, two) or of_two_quantities(one, two)
    above, below = (None, None) if reason else _bounds(one, two)
    percent, percent_reason = _percent(absolute, one)
    if above is not None or below is not None:
        percent_reason = "of one value no more is known than what it is less than"
    uncertainty = None if reason else uncertainty_of_difference(one, two)
    # where either is missing, nothing is decided
    U = math.nan if uncertainty is None else uncertainty.expanded
    exceeds = bool(abs(absolute) > U) if math.isfinite(absolute) and math.isfinite(U) else None
    direction = absolute
    if above is not None:
        exceeds, direction = above > 0.0, above
    elif below is not None:
        exceeds, direction = below < 0.0, below
    return Delta(
        one.name,
        one.unit,
        one.value,
        two.value,
        absolute,
        percent,
        uncertainty,
        exceeds,
        _judge(direction, exceeds, limits),
        reason,
        "" if reason else why_undecided(one, two),
        percent_reason,
        one.upper_bound,
        two.upper_bound,
        above,
        below,
    )


def _percent(absolute: float, reference: Measurement) -> tuple[float, str]:
    """Return a difference in percent of the reference's magnitude, or nan and why it is none: of what may be
    zero it is any number."""
    if not math.isfinite(absolute):
        return math.nan, ""
    if reference.value == 0.0:
        return math.nan, "the reference is zero"
    if reference.uncertainty is not None and not abs(reference.value) > reference.uncertainty.expanded:
        return math.nan, "the reference is zero within its U"
    return 100.0 * absolute / abs(reference.value), ""


def _untold(one: Measurement, two: Measurement) -> str:
    """Return why values are not compared of which one says nothing, or both only what they are less than;
    empty if they are."""
    if one.upper_bound is not None and two.upper_bound is not None:
        return "of both no more is known than what they are less than"
    if one.is_told and two.is_told:
        return ""
    if not (one.is_told or two.is_told):
        return ""
    undefined, where = (two, "here") if one.is_told else (one, "in the reference")
    return f"undefined {where}: {undefined.reason}" if undefined.reason else f"undefined {where}"


def _bounds(one: Measurement, two: Measurement) -> tuple[float | None, float | None]:
    """Return what the difference is more, or less, than where of one value only what it is less than is
    known, by the expanded uncertainty of the other; None where that has none, and of what does not apply."""
    known = two if one.upper_bound is not None else one
    uncertainty = known.uncertainty_of_state
    if not math.isfinite(known.value) or uncertainty is None or not math.isfinite(uncertainty.expanded):
        return None, None
    if one.upper_bound is not None:
        return two.value - uncertainty.expanded - one.upper_bound, None
    return None, None if two.upper_bound is None else two.upper_bound - (one.value - uncertainty.expanded)


def _judge(difference: float, exceeds: bool | None, limits: Sequence[Limit]) -> Judgement:
    """Return judgement: less is better under upper limits, more under lower ones; with two bounds neither."""
    signs = {(-1 if each.max is not None else 0) + (1 if each.min is not None else 0) for each in limits}
    if len(signs) != 1 or not exceeds:
        return ""
    gain = signs.pop() * difference
    return "better" if gain > 0 else "worse" if gain < 0 else ""


def _with_sign(text: str, value: float) -> str:
    """Return a number as it is written with a plus where it is above zero, and not rounded to that."""
    rounded, _, _ = text.partition("±")
    if value <= 0.0 or not re.search("[1-9]", rounded.partition("×")[0]):
        return text
    return f"(+{text[1:]}" if text.startswith("(") else f"+{text}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
