"""How the measurements of one run differ from those of another, and whether the difference means anything."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.uncertainty import COVERAGE, of_difference
from benchtool.plan.limits import Limit
from benchtool.results.assessment import Assessment
from benchtool.results.calibration import Overdue

_SAME_LENGTH = 0.01  # of the longer record: whole periods differ by less


@dataclass(frozen=True)
class Delta:
    """One measurement of a run against that of the reference, both in `unit`.

    `absolute` is the value less the reference, `percent` of the reference's magnitude. `uncertainty` is
    that of the difference, in which errors of instruments that both have in common cancel; None where one of
    them has none. `exceeds` tells whether the difference is more than the expanded uncertainty, with k from
    the effective degrees of freedom of both; None where there is none. `judgement` is empty where no limit
    tells which direction is good, or where the difference is not known to exceed its uncertainty.
    """

    name: str
    unit: str
    reference: float
    value: float
    absolute: float
    percent: float
    uncertainty: Uncertainty | None
    exceeds: bool | None
    judgement: Literal["", "better", "worse"]

    @property
    def standard(self) -> float:
        """Standard uncertainty of the difference; nan where there is none."""
        return math.nan if self.uncertainty is None else self.uncertainty.standard

    def to_json(self) -> dict[str, Any]:
        """JSON has no nan, so that it becomes null; so does a judgement that is not made."""
        return {
            "unit": self.unit,
            "reference": _finite(self.reference),
            "value": _finite(self.value),
            "absolute": _finite(self.absolute),
            "percent": _finite(self.percent),
            "standard_uncertainty": _finite(self.standard),
            "dof": None if self.uncertainty is None else _finite(self.uncertainty.dof),
            "k": None if self.uncertainty is None else _finite(self.uncertainty.k),
            "expanded_uncertainty": None if self.uncertainty is None else _finite(self.uncertainty.expanded),
            "exceeds_uncertainty": self.exceeds,
            "judgement": self.judgement or None,
        }


@dataclass(frozen=True)
class Chance:
    """Of `decided` differences, how many exceed their uncertainty; nothing is corrected for their number."""

    decided: int
    exceeding: int

    @classmethod
    def of(cls, deltas: Sequence[Delta]) -> Self:
        """Count those that have an uncertainty."""
        decided = [each.exceeds for each in deltas if each.exceeds is not None]
        return cls(len(decided), sum(decided))

    @property
    def expected(self) -> float:
        """Mean number of false alarms if nothing differed; it holds for differences that depend on each other
        too, which then come together or not at all."""
        return self.decided * (1.0 - COVERAGE)

    def __str__(self) -> str:
        """A sentence; empty where none or one is decided."""
        if self.decided < 2:
            return ""
        return (
            f"{self.exceeding} of {self.decided} differences exceed their uncertainty; if nothing differed, "
            f"chance would make {self.expected:.2g} of them do so on average."
        )

    def to_json(self) -> dict[str, Any]:
        """The counts and the number expected by chance."""
        return {
            "decided": self.decided,
            "exceeding": self.exceeding,
            "expected_by_chance": self.expected,
        }


@dataclass(frozen=True)
class Comparison:
    """The same case of several runs; the first is the reference. `deltas` are of the others, by label."""

    case: str
    results: Mapping[str, Assessment]
    deltas: Mapping[str, tuple[Delta, ...]]

    @classmethod
    def of(cls, case: str, results: Mapping[str, Assessment]) -> Comparison:
        """Compare `results`, by label, with the first of them."""
        (_, reference), *others = results.items()
        return cls(case, results, {label: deltas(reference, other) for label, other in others})

    @property
    def names(self) -> tuple[str, ...]:
        """Every measurement that one of the runs has."""
        found = (each.name for result in self.results.values() for each in result.measurements)
        return tuple(dict.fromkeys(found))

    @property
    def overdue(self) -> tuple[Overdue, ...]:
        """The instruments of any of the runs whose calibration was due before it."""
        return tuple(dict.fromkeys(late for result in self.results.values() for late in result.overdue))

    @property
    def chance(self) -> Chance:
        """How the differences of all runs to the first compare with what chance makes of as many."""
        return Chance.of([each for found in self.deltas.values() for each in found])

    @property
    def lengths(self) -> str:
        """A sentence where the runs were measured over other times than the first; else empty."""
        lasting = {label: _duration_s(result) for label, result in self.results.items()}
        first, *others = lasting
        unlike = [
            label
            for label in others
            if abs(lasting[label] - lasting[first]) > _SAME_LENGTH * max(lasting[label], lasting[first])
        ]
        if not unlike:
            return ""
        shown = ", ".join(f"{label} over {lasting[label]:.4g} s" for label in (first, *unlike))
        return (
            f"Measured over other times: {shown}. A peak-to-peak value grows with the length of a record, "
            f"and what noise adds to amplitudes and distortions falls."
        )


def compare_cases(runs: Mapping[str, Sequence[Assessment]]) -> tuple[tuple[Comparison, ...], tuple[str, ...]]:
    """The cases of several runs matched by their names, and what has no counterpart in the first run.

    Runs of one case each are compared whatever their cases are called; of one run alone, its cases are
    compared with its first.
    """
    if len(runs) == 1:
        ((_, found),) = runs.items()
        return (Comparison.of("", {each.case: each for each in found}),), ()
    if all(len(found) == 1 for found in runs.values()):
        return (Comparison.of("", {label: found[0] for label, found in runs.items()}),), ()
    by_name = {label: {each.case: each for each in found} for label, found in runs.items()}
    first, *others = by_name
    comparisons = []
    for case, reference in by_name[first].items():
        matched = {label: by_name[label][case] for label in others if case in by_name[label]}
        if matched:
            comparisons.append(Comparison.of(case, {first: reference, **matched}))
    alone = [
        f"{label}: {case}"
        for label, found in by_name.items()
        for case in found
        if not any(case == each.case and label in each.results for each in comparisons)
    ]
    return tuple(comparisons), tuple(alone)


def deltas(reference: Assessment, other: Assessment) -> tuple[Delta, ...]:
    """Differences of every measurement that both have in the same unit."""
    return tuple(_deltas(reference, other))


def _deltas(reference: Assessment, other: Assessment) -> Iterator[Delta]:
    found = {each.name: each for each in other.measurements}
    for one in reference.measurements:
        two = found.get(one.name)
        if two is None or two.unit != one.unit:
            continue
        absolute = two.value - one.value
        percent = 100.0 * absolute / abs(one.value) if one.value else math.nan
        uncertainty = _combined(one, two)
        # where either is missing, nothing is decided
        U = math.nan if uncertainty is None else uncertainty.expanded
        exceeds = bool(abs(absolute) > U) if math.isfinite(absolute) and math.isfinite(U) else None
        limits = [each.limits[one.name] for each in (reference, other) if one.name in each.limits]
        judgement = _judge(absolute, exceeds, limits)
        yield Delta(
            one.name, one.unit, one.value, two.value, absolute, percent, uncertainty, exceeds, judgement
        )


def _duration_s(result: Assessment) -> float:
    """Of the longest basis of all measurements; 0 if none says."""
    return max((each.basis.duration_s or 0.0 for each in result.measurements), default=0.0)


def _combined(one: Measurement, two: Measurement) -> Uncertainty | None:
    if one.uncertainty is None or two.uncertainty is None:
        return None
    return of_difference(one.uncertainty, two.uncertainty)


def _judge(absolute: float, exceeds: bool | None, limits: Sequence[Limit]) -> Literal["", "better", "worse"]:
    """Less is better under limits from above, more under limits from below; between two bounds neither is."""
    signs = {(-1 if each.max is not None else 0) + (1 if each.min is not None else 0) for each in limits}
    if len(signs) != 1 or not exceeds:
        return ""
    gain = signs.pop() * absolute
    return "better" if gain > 0 else "worse" if gain < 0 else ""


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
