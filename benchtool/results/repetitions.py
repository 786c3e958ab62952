"""What the repetitions of a case come to together: the mean of each measurement, what it is worth, and how it
meets a limit that holds for all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from benchtool.analysis import Contribution, Measurement, Uncertainty
from benchtool.analysis.uncertainty import InstrumentError
from benchtool.plan.cases import Case, cases
from benchtool.plan.limits import Limit, Missed, Verdict, missed
from benchtool.plan.model import Plan
from benchtool.plan.operating_point import NAMES as REACHED
from benchtool.results.agreement import Disagreement, disagreements, true_name
from benchtool.telemetry.certificate import certificate_units


@dataclass(frozen=True)
class Repeated:
    """One measurement over `n` repetitions in which it was defined.

    `standard_uncertainty` is that of the mean, the standard deviation over sqrt(n) with n - 1 degrees of
    freedom (JCGM 100:2008, 4.2.3), and nan of fewer than two. It knows nothing of what all repetitions share;
    of that, `instruments` are the errors of sensors and clock, which `uncertainty` contains besides.
    `limit` is the one that holds for them together and `judged` what it is put to: by `judge` of the plan the
    mean, or the worst repetition; None where the plan judges each, or where nothing was measured.
    `disagreement` is there where a transducer contradicts what is judged.
    """

    name: str
    unit: str
    mean: float
    standard_uncertainty: float
    n: int
    limit: Limit | None = None
    judged: Measurement | None = None
    instruments: tuple[Contribution, ...] = ()
    judge: Literal["each", "mean", "worst"] = "each"
    disagreement: Disagreement | None = None

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of the mean; None of fewer than two repetitions."""
        if self.n < 2:
            return None
        source = f"scatter over {self.n} repetitions"
        scatter = Uncertainty(self.standard_uncertainty, source, self.n - 1.0)
        return scatter.with_instruments(self.instruments)

    @property
    def combined(self) -> float:
        """Standard uncertainty of the mean, the instruments in it; nan of fewer than two repetitions."""
        return math.nan if self.uncertainty is None else self.uncertainty.standard

    @property
    def verdict(self) -> Verdict:
        """How the limit is met; `NONE` without one."""
        if self.limit is None:
            return Verdict.NONE
        if self.judged is None:
            return Verdict.FAIL
        return self.limit.judge(self.judged.value, self.judged.uncertainty)

    @property
    def verdict_by_transducer(self) -> Verdict:
        """The verdict with the transducer's number where that contradicts the estimate."""
        by_transducer = None if self.disagreement is None else self.disagreement.verdict
        return self.verdict if by_transducer is None else by_transducer

    @property
    def missed(self) -> Missed | None:
        """What is to be said of the limit; None where it is met or where there is none."""
        return None if self.limit is None else missed(self.name, self.limit, self.judged)

    def to_json(self) -> dict[str, Any]:
        """JSON has no nan, so that it becomes null."""
        document: dict[str, Any] = {
            "mean": _finite(self.mean),
            "standard_uncertainty": _finite(self.standard_uncertainty),
            "n": self.n,
            "unit": self.unit,
        }
        if self.uncertainty is not None:
            document["uncertainty"] = self.uncertainty.to_json()
        if self.limit is not None:
            document["limit"] = self.limit.to_json(self.judged)
        if self.disagreement is not None:
            document["disagreement"] = self.disagreement.to_json()
        return document


def over_repetitions(
    plan: Plan, measured: Mapping[str, Sequence[Measurement]]
) -> dict[str, tuple[Repeated, ...]]:
    """Every measurement of every case over its repetitions, by the case's name without their number.

    Args:
        plan: if it has one repetition only, there is nothing to say.
        measured: the measurements of its cases by name; a case that is missing has measured nothing.
    """
    if plan.repetitions < 2:
        return {}
    groups: dict[str, list[Sequence[Measurement]]] = {}
    for case in cases(plan):
        groups.setdefault(case.group, []).append(measured.get(case.name, ()))
    return {
        name: tuple(_together(group, plan.judge, limits_together(plan, name)))
        for name, group in groups.items()
    }


def limits_together(plan: Plan, group: str) -> dict[str, Limit]:
    """The limits of a case that hold for all of its repetitions together, by `judge` of the plan."""
    if plan.judge == "each":
        return {}
    each = {*REACHED, *certificate_units(stream=True)}
    limits = {**plan.limits, **plan.case_limits.get(group, {})}
    return {name: limit for name, limit in limits.items() if name not in each}


def limits_alone(plan: Plan, case: Case) -> dict[str, Limit]:
    """The limits that a plan sets for one case by itself: for every case, for its group, for itself."""
    together = limits_together(plan, case.group)
    shared = {**plan.limits, **plan.case_limits.get(case.group, {})}
    alone = {name: limit for name, limit in shared.items() if name not in together}
    return alone | plan.case_limits.get(case.name, {})


def _together(
    group: Sequence[Sequence[Measurement]],
    judge: Literal["each", "mean", "worst"],
    limits: Mapping[str, Limit],
) -> Iterator[Repeated]:
    units = {each.name: each.unit for measurements in group for each in measurements}
    done: dict[str, Repeated] = {}
    for name in dict.fromkeys((*units, *limits)):
        found = [each for measurements in group for each in measurements if each.name == name]
        values = [each.value for each in found if math.isfinite(each.value)]
        mean = float(np.mean(values)) if values else math.nan
        spread = float(np.std(values, ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else math.nan
        limit = limits.get(name)
        shared = tuple(_shared(found))
        together = Repeated(
            name, units.get(name, ""), mean, spread, len(values), limit, judge=judge, instruments=shared
        )
        if limit is not None and found:
            together = replace(together, judged=_judged(together, found, len(group), judge == "mean"))
        done[name] = together
    for name, together in done.items():
        limit, true = together.limit, done.get(true_name(name))
        if limit is not None and together.judged is not None and true is not None:
            on_shaft = [each for measurements in group for each in measurements if each.name == true.name]
            shaft = _judged(replace(true, limit=limit), on_shaft, len(group), judge == "mean")
            found_apart = disagreements((together.judged, shaft), {name: limit})
            yield replace(together, disagreement=next(iter(found_apart), None))
        else:
            yield together


def _shared(found: Sequence[Measurement]) -> Iterator[Contribution]:
    """The errors of instruments, each of which moves the mean as it moves the repetitions on average."""
    lines: dict[InstrumentError, list[Contribution]] = {}
    count = sum(math.isfinite(each.value) for each in found)
    for each in found:
        if each.uncertainty is not None and math.isfinite(each.value):
            for line in each.uncertainty.budget:
                if line.instrument is not None:
                    lines.setdefault(line.instrument, []).append(line)
    for same in lines.values():
        mean = sum(line.sign * line.standard for line in same) / count
        yield replace(same[0], standard=abs(mean), sign=-1 if mean < 0.0 else 1)


def _judged(together: Repeated, found: Sequence[Measurement], count: int, of_mean: bool) -> Measurement:
    """What a limit over `count` repetitions is put to; undefined where one of them has no value."""
    limit, name, unit = together.limit, together.name, together.unit
    assert limit is not None
    definition = f"{'mean' if of_mean else 'worst'} of {count} repetitions"
    if together.n < count:
        reason = f"{count - together.n} of {count} repetitions have no value"
        return Measurement.undefined(name, unit, definition, reason)
    if of_mean:
        return Measurement(name, together.mean, unit, definition, uncertainty=together.uncertainty)
    order = list(Verdict)

    def merit(each: Measurement) -> tuple[int, float]:
        """Verdict before distance: with guard bands, the widest uncertainty may be what misses."""
        return -order.index(limit.judge(each.value, each.uncertainty)), limit.room(each.value)

    return replace(min(found, key=merit), definition=definition)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
