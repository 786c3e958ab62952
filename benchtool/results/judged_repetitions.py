"""Limits over the repetitions of a case: the value that each is held against, and whether all conform."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, TypeAlias

import numpy as np

from benchtool.analysis import Measurement, Uncertainty, catalogue, count_of, equally_likely, with_unit
from benchtool.plan import NAMES as REACHED, Case, JudgedLimit, Limit, Plan, Verdict
from benchtool.results.agreement import Disagreement
from benchtool.telemetry import certificate_units

Judge: TypeAlias = Literal["mean", "worst"]
"""What a limit over repetitions applies to, by `judge` of the plan."""

_ALIKE = equally_likely(256)  # errors in common


@dataclass(frozen=True)
class LimitsTogether:
    """Limits that hold for all `count` repetitions of a case together: for their mean, or for the worst of
    them. One repetition alone does not tell whether they are met."""

    judge: Judge
    count: int
    limits: Mapping[str, Limit]

    @classmethod
    def of(cls, plan: Plan, group: str) -> Self | None:
        """Return those that a plan sets for a case; None if each repetition is held against all limits."""
        limits = limits_together(plan, group)
        if plan.judge == "each" or not limits:
            return None
        return cls(plan.judge, plan.repetitions, limits)

    def __str__(self) -> str:
        """Return the limits, and what each is held against."""
        bounds = ", ".join(
            f"{name} {with_unit(limit.bounds, _unit_of(name))}" for name, limit in self.limits.items()
        )
        hold = "holds" if len(self.limits) == 1 else "hold"
        return f"{bounds} {hold} for the {self.judge} of {count_of(self.count, 'repetition')}"

    @property
    def of_one(self) -> str:
        """The same beside one repetition, whose own verdict theirs is not."""
        return f"{self}, of which this is one: measure the folder of the run, which tells"

    def to_json(self) -> dict[str, Any]:
        """Return what is judged, how many repetitions that needs, and the limits with their rules."""
        limits = {
            name: limit.model_dump(exclude_none=True) | {"rule": limit.rule}
            for name, limit in self.limits.items()
        }
        return {"judge": self.judge, "repetitions": self.count, "limits": limits}


@dataclass(frozen=True)
class JudgedTogether(JudgedLimit):
    """A limit held against the `count` repetitions of a case together: against their mean, or the worst.

    `conformance` is of the mean, or the probability that every repetition conforms. `disagreement` is set
    where a transducer contradicts the judged value.
    """

    judge: Judge = "mean"
    count: int = 0
    disagreement: Disagreement | None = None

    def of_each(self, found: Sequence[Measurement]) -> Self:
        """Return the limit on the worst repetition with the probability that every one found conforms."""
        if self.conformance is None:
            return replace(self, judge="worst")
        conformance = _all_conform(self.limit, found)
        reason = "the uncertainty of a repetition is not known" if conformance is None else ""
        return replace(self, judge="worst", conformance=conformance, conformance_reason=reason)

    @property
    def probability_of(self) -> str:
        """What its conformance is the probability of."""
        if self.judge == "mean":
            return super().probability_of
        return f"probability that all {self.count} repetitions conform"

    @property
    def verdict_by_transducer(self) -> Verdict:
        """The verdict with the transducer's number where that contradicts the estimate, as it counts for the
        whole."""
        by_transducer = None if self.disagreement is None else self.disagreement.verdict
        return self.counted if by_transducer is None else self.limit.counted(by_transducer)


def limits_together(plan: Plan, group: str) -> dict[str, Limit]:
    """Return the limits of a case that hold for all of its repetitions together, by `judge` of the plan."""
    if plan.judge == "each":
        return {}
    each = {*REACHED, *certificate_units(stream=True)}
    limits = {**plan.limits, **plan.case_limits.get(group, {})}
    return {name: limit for name, limit in limits.items() if name not in each}


def limits_alone(plan: Plan, case: Case) -> dict[str, Limit]:
    """Return limits that a plan sets for one case by itself: for every case, for its group, for itself."""
    together = limits_together(plan, case.group)
    shared = {**plan.limits, **plan.case_limits.get(case.group, {})}
    alone = {name: limit for name, limit in shared.items() if name not in together}
    return alone | plan.case_limits.get(case.name, {})


def worst_of(limit: Limit, found: Sequence[Measurement], count: int) -> Measurement:
    """Return the worst of `count` repetitions by a limit; undefined if one of them has no value."""
    definition = f"worst of {count} repetitions"
    if lacking := without_value(found, count):
        bounds = bounds_of(found, count)
        undefined = Measurement.undefined(found[0].name, found[0].unit, definition, lacking)
        return replace(undefined, below=None if bounds is None else max(bounds))
    order = list(Verdict)

    def merit(each: Measurement) -> tuple[int, float]:
        """Return the sort key of the worst repetition: verdict before distance, as with guard bands the
        widest uncertainty may fail."""
        return -order.index(limit.judge(each.value, each.uncertainty)), limit.headroom(each.value)

    return replace(min(found, key=merit), definition=definition)


def bounds_of(found: Sequence[Measurement], count: int) -> list[float] | None:
    """Return what each of `count` repetitions is less than, by its uncertainty or as no line stands out of
    its noise; None where one of them tells neither."""
    told = [
        each.value + (0.0 if each.uncertainty is None else each.uncertainty.expanded)
        if math.isfinite(each.value)
        else each.upper_bound
        for each in found
    ]
    known = [each for each in told if each is not None]
    return known if len(known) == count else None


def without_value(found: Sequence[Measurement], count: int) -> str:
    """Return that some of `count` repetitions have no value, and why; empty if all have one."""
    lacking = count - sum(math.isfinite(each.value) for each in found)
    why = reasons_of(found)
    return f"{lacking} of {count} repetitions have no value{f': {why}' if why else ''}" if lacking else ""


def reasons_of(found: Sequence[Measurement]) -> str:
    """Return why repetitions have no value, each reason once; empty where all have one."""
    return "; ".join(dict.fromkeys(each.reason for each in found if each.reason))


def _unit_of(name: str) -> str:
    """Return the unit that a measurement is declared with; empty where it depends on what is measured."""
    declared = catalogue().quantity(name)
    return declared.unit if declared is not None and isinstance(declared.unit, str) else ""


def _all_conform(limit: Limit, found: Sequence[Measurement]) -> float | None:
    """Return the probability that the true values of all repetitions meet a limit (JCGM 106:2012, 7); None
    where the uncertainty of one is not known.

    Errors of instruments move all repetitions alike, and it is the mean over them. Others are taken as
    independent, and it is the least that it may be where they are not (Slepian, Bell Syst. Tech. J. 41 (1962)
    463). It is at most that of any one of them, which is what is left where they share nearly all errors.
    """
    own: list[tuple[float, float, Uncertainty]] = []
    for each in found:
        if each.uncertainty is None:
            return None
        shared = [line for line in each.uncertainty.budget if line.instrument is not None]
        size = math.hypot(*(line.standard for line in shared))
        moved = math.copysign(size, sum(line.sign * line.standard for line in shared))
        own.append((each.value, moved, each.uncertainty.without(shared)))
    chances = [[limit.conformance(value + by * moved, alone) for value, moved, alone in own] for by in _ALIKE]
    known = [[each for each in of_all if each is not None] for of_all in chances]
    if known != chances:
        return None
    of_each = [limit.conformance(each.value, each.uncertainty) for each in found]
    together = float(np.mean([math.prod(of_all) for of_all in known]))
    return min([together, *(each for each in of_each if each is not None)])
