"""Limits over the repetitions of a case: the value that each is held against, and whether all conform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self, TypeAlias

import numpy as np

from benchtool.analysis import Measurement, Uncertainty, equally_likely
from benchtool.plan import NAMES as REACHED, Case, JudgedLimit, Limit, Plan, Verdict
from benchtool.results.agreement import Disagreement
from benchtool.telemetry import certificate_units

Judge: TypeAlias = Literal["mean", "worst"]
"""What a limit over repetitions applies to, by `judge` of the plan."""

_ALIKE = equally_likely(256)  # errors in common


@dataclass(frozen=True)
class JudgedTogether(JudgedLimit):
    """A limit held against the repetitions of a case together: against their mean, or the worst of them.

    `conformance` is of the mean, or the probability that every repetition conforms. `disagreement` is set
    where a transducer contradicts the judged value.
    """

    judge: Judge = "mean"
    disagreement: Disagreement | None = None

    def of_each(self, found: Sequence[Measurement]) -> Self:
        """Return the limit on the worst repetition with the probability that every one found conforms."""
        if self.conformance is None:
            return replace(self, judge="worst")
        conformance = _all_conform(self.limit, found)
        reason = "the uncertainty of a repetition is not known" if conformance is None else ""
        return replace(self, judge="worst", conformance=conformance, conformance_reason=reason)

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
        return Measurement.undefined(found[0].name, found[0].unit, definition, lacking)
    order = list(Verdict)

    def merit(each: Measurement) -> tuple[int, float]:
        """Return the sort key of the worst repetition: verdict before distance, as with guard bands the
        widest uncertainty may fail."""
        return -order.index(limit.judge(each.value, each.uncertainty)), limit.headroom(each.value)

    return replace(min(found, key=merit), definition=definition)


def without_value(found: Sequence[Measurement], count: int) -> str:
    """Return that some of `count` repetitions have no value; empty if all have one."""
    lacking = count - sum(math.isfinite(each.value) for each in found)
    return f"{lacking} of {count} repetitions have no value" if lacking else ""


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
