"""Claims of a publication compared with measured numbers, in the literal and in the chosen reading.

A plan runs the publication literally in a variant called `literal`; its other cases follow the choices of the
profile. A case that is the same in both readings has no such variant. A claim is judged as a limit with
`margin = "U"` is: numbers closer to each other than the uncertainty of their difference leave it undecided
(JCGM 106:2012, 8.3), and so does a number whose uncertainty is not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from benchtool.analysis import Measurement, Uncertainty, of_difference, with_expanded
from benchtool.profile import Claim, Comparison

LITERAL = "literal"
_EXACT = Uncertainty(0.0, "as stated")

Figures = Mapping[str, Mapping[str, Sequence[Measurement]]]  # by plan, then by case


class Standing(StrEnum):
    """Whether a claim holds; of several comparisons the last of these that occurs counts."""

    HOLDS = "yes"
    UNDECIDED = "undecided"
    FAILS = "no"
    NOT_MEASURED = "not measured"


_SIGNS = {
    "below": {Standing.HOLDS: "<", Standing.FAILS: "≮", Standing.UNDECIDED: "≷"},
    "above": {Standing.HOLDS: ">", Standing.FAILS: "≯", Standing.UNDECIDED: "≷"},
    "near": {Standing.HOLDS: "≈", Standing.FAILS: "≉", Standing.UNDECIDED: "≟"},
}


@dataclass(frozen=True)
class Finding:
    """Whether a claim holds in one reading, and its numbers."""

    standing: Standing
    numbers: tuple[str, ...]


def literal(case: str) -> str:
    """Return the name of a case in the literal reading."""
    return f"{LITERAL},{case}"


def claims_table(claims: Sequence[Claim], figures: Figures) -> Iterator[str]:
    """Yield the rows of Markdown: each claim, its verdict, and the numbers of both readings."""
    yield from ("| claim | where | verdict | as run here | literally |", "|---|---|---|---|---|")
    for claim in claims:
        here = finding(claim, figures, by_the_letter=False)
        letter = finding(claim, figures, by_the_letter=True)
        same = letter.numbers == here.numbers
        cells = ["<br>".join(here.numbers), "the same" if same else "<br>".join(letter.numbers)]
        yield f"| {claim.claim} | {claim.source} | {verdict(here, letter)} | {' | '.join(cells)} |"


def verdict(here: Finding, letter: Finding) -> str:
    """Return the verdict that both readings share, or that of each."""
    match here.standing, letter.standing:
        case (Standing.NOT_MEASURED, _) | (_, Standing.NOT_MEASURED):
            return Standing.NOT_MEASURED
        case Standing.HOLDS, Standing.FAILS:
            return "only if improved as here"
        case Standing.FAILS, Standing.HOLDS:
            return "only if read literally"
        case same, other if same is other:
            return same
    return f"{here.standing} if improved as here, {letter.standing} if read literally"


def finding(claim: Claim, figures: Figures, *, by_the_letter: bool) -> Finding:
    """Return a claim in one reading: it holds where all of its comparisons do."""
    results = [_compared(each, figures, by_the_letter) for each in claim.comparisons]
    return Finding(_last(standing for standing, _ in results), tuple(text for _, text in results))


def _last(standings: Iterable[Standing]) -> Standing:
    order = list(Standing)
    return max(standings, key=order.index)


def _compared(comparison: Comparison, figures: Figures, by_the_letter: bool) -> tuple[Standing, str]:
    place = comparison.plan, comparison.case, comparison.measurement
    left = _measured(figures, *place, by_the_letter)
    name = f"{comparison.plan} {comparison.case} {comparison.measurement}"
    if left is None:
        return Standing.NOT_MEASURED, f"{name} not measured"
    if comparison.other is not None:
        other = comparison.other
        there = (other.plan or place[0], other.case or place[1], other.measurement or place[2])
        right = _measured(figures, *there, by_the_letter)
        beside = " ".join(part for part, mine in zip(there, place, strict=True) if part != mine) + " "
    else:
        right, beside = _Number(float(comparison.value or 0.0), left.unit, _EXACT), ""
    if right is None:
        return Standing.NOT_MEASURED, f"{name} not measured"
    times = comparison.times
    standing = _standing(comparison.relation, left, right, times)
    factor = "" if times == 1 else f"{times:g} × " if comparison.relation != "near" else ""
    within = f" (within a factor of {times:g})" if comparison.relation == "near" else ""
    sign = _SIGNS[comparison.relation][standing]
    return standing, f"{name} {left} {sign} {factor}{beside}{right}{within}"


@dataclass(frozen=True)
class _Number:
    """A finite value and its uncertainty for any record of the same state; None where that is not known."""

    value: float
    unit: str
    uncertainty: Uncertainty | None

    def __str__(self) -> str:
        if self.uncertainty is None:
            return f"{self.value:.4g} {self.unit}".rstrip() + " without U"
        exact = self.uncertainty.standard == 0.0
        value = f"{self.value:.4g}" if exact else with_expanded(self.value, self.uncertainty)
        return f"{value} {self.unit}".rstrip()

    def __mul__(self, factor: float) -> _Number:
        scaled = None if self.uncertainty is None else self.uncertainty.scaled(factor)
        return _Number(factor * self.value, self.unit, scaled)

    def above(self, other: _Number) -> Standing:
        """Tell whether this number is the greater one by more than the uncertainty of the difference."""
        if self.uncertainty is None or other.uncertainty is None:
            return Standing.UNDECIDED
        room = self.value - other.value
        of_both = of_difference(self.uncertainty, other.uncertainty, (self.value, other.value))
        if abs(room) < of_both.expanded:
            return Standing.UNDECIDED
        return Standing.HOLDS if room > 0.0 else Standing.FAILS


def _standing(relation: str, value: _Number, bound: _Number, times: float) -> Standing:
    match relation:
        case "below":
            return (bound * times).above(value)
        case "above":
            return value.above(bound * times)
    sign = math.copysign(1.0, bound.value)
    value, bound = value * sign, bound * sign
    return _last((value.above(bound * (1.0 / times)), (bound * times).above(value)))


def _measured(figures: Figures, plan: str, case: str, name: str, by_the_letter: bool) -> _Number | None:
    """Return what was measured in a case; None where that has no value."""
    cases = figures.get(plan, {})
    found = cases.get(literal(case)) if by_the_letter else None
    each = next((each for each in found or cases.get(case, ()) if each.name == name), None)
    if each is None or not math.isfinite(each.value):
        return None
    uncertainty = each.uncertainty_of_state
    known = uncertainty is not None and math.isfinite(uncertainty.expanded)
    return _Number(each.value, each.unit, uncertainty if known else None)
