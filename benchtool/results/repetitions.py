"""Results over the repetitions of a case: mean of each measurement, its uncertainty, and verdicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from benchtool.analysis import Contribution, Correction, InstrumentError, Measurement, Uncertainty
from benchtool.plan import NAMES as REACHED, Case, Limit, Missed, Plan, Verdict, cases, missed
from benchtool.results.agreement import Disagreement, disagreements, transducer_name
from benchtool.telemetry import certificate_units


@dataclass(frozen=True)
class Repeated:
    """One measurement over `n` repetitions in which it was defined.

    `standard_uncertainty` is that of the mean, the standard deviation over sqrt(n) with n - 1 degrees of
    freedom (JCGM 100:2008, 4.2.3), and nan of fewer than two. It does not contain errors that all repetitions
    share, which `uncertainty` and the JSON add: `instruments` are those of sensors and clock, `power` is what
    the power of their noise adds to each. `limit` is the
    one that holds for them together and `judged` the value it applies to: by `judge` of the plan the mean, or
    the worst repetition; None where the plan judges each, or where nothing was measured. `disagreement` is
    set where a transducer contradicts the judged value.
    """

    name: str
    unit: str
    mean: float
    standard_uncertainty: float
    n: int
    limit: Limit | None = None
    judged: Measurement | None = None
    instruments: tuple[Contribution, ...] = ()
    power: tuple[Contribution, ...] = ()
    judge: Literal["each", "mean", "worst"] = "each"
    disagreement: Disagreement | None = None

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of the mean; None of fewer than two repetitions."""
        if self.n < 2:
            return None
        source = f"scatter over {self.n} repetitions"
        scatter = Uncertainty(self.standard_uncertainty, source, self.n - 1.0)
        return scatter.with_power(self.power).with_instruments(self.instruments)

    @property
    def combined(self) -> float:
        """Standard uncertainty of the mean, what repetitions share in it; nan of fewer than two."""
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
    def counted(self) -> Verdict:
        """The verdict as it counts for the whole: none where the limit is not met, and waived."""
        return self.verdict if self.limit is None else self.limit.counted(self.verdict)

    @property
    def verdict_by_transducer(self) -> Verdict:
        """The verdict with the transducer's number where that contradicts the estimate, as it counts for the
        whole."""
        by_transducer = None if self.disagreement is None else self.disagreement.verdict
        if self.limit is None or by_transducer is None:
            return self.counted
        return self.limit.counted(by_transducer)

    @property
    def missed(self) -> Missed | None:
        """The missed limit; None if it is met or there is none."""
        return None if self.limit is None else missed(self.name, self.limit, self.judged)

    def to_json(self) -> dict[str, Any]:
        """Return the fields; nan becomes null."""
        document: dict[str, Any] = {
            "mean": _finite(self.mean),
            "standard_uncertainty": _finite(self.combined),
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
    """Return every measurement of every case over its repetitions, by the case's name without their number.

    Args:
        plan: with one repetition only, the result is empty.
        measured: the measurements of its cases by name; a missing case has no measurements.
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


def _together(
    group: Sequence[Sequence[Measurement]],
    judge: Literal["each", "mean", "worst"],
    limits: Mapping[str, Limit],
) -> Iterator[Repeated]:
    units = {each.name: each.unit for measurements in group for each in measurements}
    done: dict[str, Repeated] = {}
    for name in dict.fromkeys((*units, *limits)):
        found = [each for measurements in group for each in measurements if each.name == name]
        limit = limits.get(name)
        together = replace(_mean_of(name, units.get(name, ""), found), limit=limit, judge=judge)
        if limit is not None and found:
            together = replace(together, judged=_judged(together, found, len(group), judge == "mean"))
        done[name] = together
    for name, together in done.items():
        limit, true = together.limit, done.get(transducer_name(name))
        if limit is not None and together.judged is not None and true is not None:
            on_shaft = [each for measurements in group for each in measurements if each.name == true.name]
            shaft = _judged(replace(true, limit=limit), on_shaft, len(group), judge == "mean")
            found_apart = disagreements((together.judged, shaft), {name: limit})
            yield replace(together, disagreement=next(iter(found_apart), None))
        else:
            yield together


def _shared(found: Sequence[Measurement]) -> Iterator[Contribution]:
    """Yield errors of instruments, each of which moves the mean as it moves the repetitions on average."""
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


def _power(found: Sequence[Measurement]) -> Iterator[Contribution]:
    """Yield what the power of noise adds to the mean: it does so in every repetition, and no scatter shows
    it."""
    known = [each.uncertainty for each in found if each.uncertainty and math.isfinite(each.value)]
    lines = [line for each in known for line in each.budget if line.adds_power]
    for name in dict.fromkeys(line.name for line in lines):
        same = [line for line in lines if line.name == name]
        yield replace(same[0], standard=sum(line.standard for line in same) / len(known))


def _judged(together: Repeated, found: Sequence[Measurement], count: int, of_mean: bool) -> Measurement:
    """Return value that a limit over `count` repetitions applies to; undefined if one of them has none."""
    limit, name, unit = together.limit, together.name, together.unit
    assert limit is not None
    definition = f"{'mean' if of_mean else 'worst'} of {count} repetitions"
    if together.n < count:
        reason = f"{count - together.n} of {count} repetitions have no value"
        return Measurement.undefined(name, unit, definition, reason)
    if of_mean:
        judged = Measurement(
            name,
            together.mean,
            unit,
            definition,
            uncertainty=together.uncertainty,
            correction=_mean_correction(found),
        )
        return replace(judged, in_common_band=_mean_in_band(found, judged))
    order = list(Verdict)

    def merit(each: Measurement) -> tuple[int, float]:
        """Return the sort key of the worst repetition: verdict before distance, as with guard bands the
        widest uncertainty may fail."""
        return -order.index(limit.judge(each.value, each.uncertainty)), limit.headroom(each.value)

    return replace(min(found, key=merit), definition=definition)


def _mean_in_band(found: Sequence[Measurement], judged: Measurement) -> Measurement | None:
    """Return the mean of the repetitions in the band of a slower transducer; None where one has none."""
    narrow = [each.in_common_band for each in found if each.in_common_band is not None]
    if len(narrow) < len(found):
        return None
    together = _mean_of(judged.name, judged.unit, narrow)
    basis = narrow[0].basis
    return Measurement(
        judged.name, together.mean, judged.unit, judged.definition, basis, together.uncertainty
    )


def _mean_correction(found: Sequence[Measurement]) -> Correction | None:
    """Return what was added to the mean of repetitions for their sensors; None if nothing was."""
    corrections = [each.correction for each in found if each.correction is not None]
    if not corrections:
        return None
    return Correction(sum(each.added for each in corrections) / len(found), corrections[0].of)


def _mean_of(name: str, unit: str, found: Sequence[Measurement]) -> Repeated:
    """Return mean and standard deviation of the mean of repetitions."""
    values = [each.value for each in found if math.isfinite(each.value)]
    mean = float(np.mean(values)) if values else math.nan
    spread = float(np.std(values, ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else math.nan
    shared, power = tuple(_shared(found)), tuple(_power(found))
    return Repeated(name, unit, mean, spread, len(values), instruments=shared, power=power)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
