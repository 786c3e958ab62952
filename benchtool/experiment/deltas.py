"""How the measurements of one run differ from those of another, and whether the difference means anything."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from benchtool.analysis import Measurement
from benchtool.experiment.agreement import COVERAGE
from benchtool.experiment.assessment import Assessment
from benchtool.experiment.limits import Limit

_SAME_LENGTH = 0.01  # of the longer record: whole periods differ by less


@dataclass(frozen=True)
class Delta:
    """One measurement of a run against that of the reference, both in `unit`.

    `absolute` is the value less the reference, `percent` of the reference's magnitude. `standard` is the
    combined standard uncertainty sqrt(u_1^2 + u_2^2) (JCGM 100:2008, 5.1.2, of two values without
    correlation), nan where one of them has none. `exceeds` tells whether the difference is more than
    `COVERAGE` times that; None where there is none. `judgement` is empty where no limit tells which direction
    is good, or where the difference is not known to exceed its uncertainty.
    """

    name: str
    unit: str
    reference: float
    value: float
    absolute: float
    percent: float
    standard: float
    exceeds: bool | None
    judgement: Literal["", "better", "worse"]

    def to_json(self) -> dict[str, Any]:
        """JSON has no nan, so that it becomes null; so does a judgement that is not made."""
        return {
            "unit": self.unit,
            "reference": _finite(self.reference),
            "value": _finite(self.value),
            "absolute": _finite(self.absolute),
            "percent": _finite(self.percent),
            "standard_uncertainty": _finite(self.standard),
            "exceeds_uncertainty": self.exceeds,
            "judgement": self.judgement or None,
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
        standard = _combined(one, two)
        # nan where either is missing, and then nothing is decided
        known = math.isfinite(absolute) and math.isfinite(standard)
        exceeds = bool(abs(absolute) > COVERAGE * standard) if known else None
        limits = [each.limits[one.name] for each in (reference, other) if one.name in each.limits]
        judgement = _judge(absolute, exceeds, limits)
        yield Delta(one.name, one.unit, one.value, two.value, absolute, percent, standard, exceeds, judgement)


def _duration_s(result: Assessment) -> float:
    """Of the longest basis of all measurements; 0 if none says."""
    return max((each.basis.duration_s or 0.0 for each in result.measurements), default=0.0)


def _combined(one: Measurement, two: Measurement) -> float:
    if one.uncertainty is None or two.uncertainty is None:
        return math.nan
    return math.hypot(one.uncertainty.standard, two.uncertainty.standard)


def _judge(absolute: float, exceeds: bool | None, limits: Sequence[Limit]) -> Literal["", "better", "worse"]:
    """Less is better under limits from above, more under limits from below; between two bounds neither is."""
    signs = {(-1 if each.max is not None else 0) + (1 if each.min is not None else 0) for each in limits}
    if len(signs) != 1 or not exceeds:
        return ""
    gain = signs.pop() * absolute
    return "better" if gain > 0 else "worse" if gain < 0 else ""


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
