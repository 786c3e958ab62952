"""Claims of a publication compared with measured numbers, in the literal and in the chosen reading.

A plan runs the publication literally in a variant called `literal`; its other cases follow the choices of the
profile. A case that is the same in both readings has no such variant.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from benchtool.analysis import Measurement
from benchtool.profile import Claim, Comparison

LITERAL = "literal"
_SIGNS = {"below": "<≮", "above": ">≯", "near": "≈≉"}  # where it holds, and where it does not

Figures = Mapping[str, Mapping[str, Sequence[Measurement]]]  # by plan, then by case


@dataclass(frozen=True)
class Finding:
    """Whether a claim holds in one reading, and its numbers; None where one was not measured."""

    holds: bool | None
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
    """Yes, no, or in which of the readings alone."""
    match here.holds, letter.holds:
        case (None, _) | (_, None):
            return "not measured"
        case True, True:
            return "yes"
        case True, False:
            return "only if improved as here"
        case False, True:
            return "only if read literally"
    return "no"


def finding(claim: Claim, figures: Figures, *, by_the_letter: bool) -> Finding:
    """Return a claim in one reading: it holds where all of its comparisons do."""
    results = [_compared(each, figures, by_the_letter) for each in claim.comparisons]
    states = [state for state, _ in results]
    return Finding(None if None in states else all(states), tuple(text for _, text in results))


def _compared(comparison: Comparison, figures: Figures, by_the_letter: bool) -> tuple[bool | None, str]:
    place = comparison.plan, comparison.case, comparison.measurement
    left = _measured(figures, *place, by_the_letter)
    name = f"{comparison.plan} {comparison.case} {comparison.measurement}"
    times = comparison.times
    if comparison.other is not None:
        other = comparison.other
        there = (other.plan or place[0], other.case or place[1], other.measurement or place[2])
        right = _measured(figures, *there, by_the_letter)
        beside = " ".join(part for part, mine in zip(there, place, strict=True) if part != mine)
        bound = right.value if right else math.nan
    else:
        bound, beside = float(comparison.value or 0.0), ""
    if left is None or not (math.isfinite(left.value) and math.isfinite(bound)):
        return None, f"{name} not measured"
    stated = f"{bound:.3g} {left.unit}".rstrip()
    factor = "" if times == 1 else f"{times:g} × " if comparison.relation != "near" else ""
    within = f" (within a factor of {times:g})" if comparison.relation == "near" else ""
    partner = f"{beside} {stated}" if beside else stated
    holds = _holds(comparison.relation, left.value, bound, times)
    sign = _SIGNS[comparison.relation][0 if holds else 1]
    return holds, f"{name} {left.value:.3g} {left.unit} {sign} {factor}{partner}{within}"


def _holds(relation: str, value: float, bound: float, times: float) -> bool:
    match relation:
        case "below":
            return value < times * bound
        case "above":
            return value > times * bound
    return abs(bound) / times <= abs(value) <= abs(bound) * times and value * bound > 0


def _measured(figures: Figures, plan: str, case: str, name: str, by_the_letter: bool) -> Measurement | None:
    cases = figures.get(plan, {})
    found = cases.get(literal(case)) if by_the_letter else None
    return next((each for each in found or cases.get(case, ()) if each.name == name), None)
