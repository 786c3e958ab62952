"""Results over the repetitions of a case: mean of each measurement, its uncertainty, and verdicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from benchtool.analysis import (
    Contribution,
    Correction,
    InstrumentError,
    Measurement,
    Uncertainty,
    equally_likely,
)
from benchtool.plan import NAMES as REACHED, Case, Limit, Missed, Plan, Verdict, cases, missed
from benchtool.results.agreement import Disagreement, disagreements, transducer_name
from benchtool.telemetry import certificate_units

_ROUNDING = 1e-13  # relative: of a mean of equal numbers
_ALIKE = equally_likely(64)  # errors in common


@dataclass(frozen=True)
class Repeated:
    """One measurement over `n` repetitions in which it was defined.

    `standard_uncertainty` is that of the mean, the standard deviation over sqrt(n) with n - 1 degrees of
    freedom (JCGM 100:2008, 4.2.3), and nan of fewer than two. It does not contain errors that all repetitions
    share, which `uncertainty` and the JSON add: `instruments` are those of sensors and clock, `power` is what
    the power of their noise adds to each, `unshown` what else of type B the scatter is too small to show.
    Of equal numbers, which no scatter tells of, it is that of a `single` one.
    `limit` is the one that holds for them together and `judged` the value it applies to: by `judge` of the
    plan the mean, or the worst repetition; None where the plan judges each, or where nothing was measured.
    `of_all` is the probability that every repetition conforms, where the worst is judged and all have an
    uncertainty.
    `disagreement` is set where a transducer contradicts the judged value.
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
    unshown: tuple[Contribution, ...] = ()
    single: Uncertainty | None = None
    judge: Literal["each", "mean", "worst"] = "each"
    of_all: float | None = None
    disagreement: Disagreement | None = None

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of the mean; None where `uncertainty_reason` says why."""
        if self.n < 2 or self.uncertainty_reason:
            return None
        if self._agree:
            return self.single
        source = f"scatter over {self.n} repetitions"
        scatter = Uncertainty(self.standard_uncertainty, source, self.n - 1.0)
        return scatter.with_power(self.power).with_instruments((*self.unshown, *self.instruments))

    @property
    def uncertainty_reason(self) -> str:
        """Why a mean of two repetitions and more has no uncertainty; empty where it has one."""
        errors = (*self.power, *self.unshown, *self.instruments)
        unknown = [line.name for line in errors if not math.isfinite(line.standard)]
        if unknown:
            return f"not known of its sensors: {'; '.join(unknown)}"
        if self._agree and self.single is None:
            return f"{self.n} repetitions read the same, so that no scatter tells"
        return ""

    @property
    def _agree(self) -> bool:
        """Whether several repetitions are one number: as read in steps, or as none that is below zero."""
        return self.n > 1 and self.standard_uncertainty <= _ROUNDING * abs(self.mean)

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
        """The limit that was not met and counts, or was met within its margin only; None without one."""
        return None if self._is_waived else self._missed

    @property
    def waived(self) -> Missed | None:
        """The limit that was not met, and is waived; None without one."""
        return self._missed if self._is_waived else None

    @property
    def _missed(self) -> Missed | None:
        return None if self.limit is None else missed(self.name, self.limit, self.judged, self.of_all)

    @property
    def _is_waived(self) -> bool:
        return self.counted is not self.verdict

    @property
    def conformance(self) -> float | None:
        """Probability that the limit is met, by all repetitions where the worst is judged; None without one,
        or where the uncertainty is not known."""
        if self.limit is None or self.judged is None:
            return None
        if self.judge == "worst":
            return self.of_all
        return self.limit.conformance(self.judged.value, self.judged.uncertainty)

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
        elif self.uncertainty_reason:
            document["uncertainty_reason"] = self.uncertainty_reason
        if self.limit is not None:
            document["limit"] = self.limit.to_json(self.judged, self.of_all)
            if self.judge == "worst" and self.of_all is None and document["limit"].pop("conformance", None):
                document["limit"]["conformance_reason"] = "the uncertainty of a repetition is not known"
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
            judged = _judged(together, found, len(group), judge == "mean")
            of_all = _all_conform(limit, found) if judge == "worst" and together.n == len(group) else None
            together = replace(together, judged=judged, of_all=of_all)
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


def _lines(each: Measurement) -> tuple[Contribution, ...]:
    """Return what is known of the errors of one repetition, of its sensors where its data tell nothing."""
    return each.of_sensors if each.uncertainty is None else each.uncertainty.lines


def _shared(found: Sequence[Measurement]) -> Iterator[Contribution]:
    """Yield errors of instruments, each of which moves the mean as it moves the repetitions on average."""
    lines: dict[InstrumentError, list[Contribution]] = {}
    count = sum(math.isfinite(each.value) for each in found)
    for each in found:
        if math.isfinite(each.value):
            for line in _lines(each):
                if line.instrument is not None:
                    lines.setdefault(line.instrument, []).append(line)
    for same in lines.values():
        mean = sum(line.sign * line.standard for line in same) / count
        yield replace(same[0], standard=abs(mean), sign=-1 if mean < 0.0 else 1)


def _unshown(found: Sequence[Measurement], spread: float) -> Iterator[Contribution]:
    """Yield the lines of type B of a repetition, less what the scatter shows of them.

    Repetitions that have an error in common do not scatter by it: readings that end on one step agree, and
    each is off by it. Of the variance that these lines state the scatter shows as much as the standard
    deviation `spread` has beyond that of type A; the rest all repetitions share (JCGM 100:2008, 4.3.10 and
    F.2.2.1).
    """
    known = [_lines(each) for each in found if math.isfinite(each.value)]
    own = [line for lines in known for line in lines if line.instrument is None and not line.adds_power]
    by_data = sum(line.experimental**2 for line in own if line.evaluation == "A") / max(1, len(known))
    names = dict.fromkeys(line.name for line in own if line.evaluation == "B")
    means = {
        name: math.sqrt(
            sum(line.standard**2 for line in own if line.evaluation == "B" and line.name == name) / len(known)
        )
        for name in names
    }
    stated = math.hypot(*means.values())
    left = stated**2 - max(0.0, spread**2 - by_data)
    if not left <= 0.0:  # nan where it is not known
        for name, standard in means.items():
            yield Contribution(name, "B", standard * math.sqrt(left) / stated)


def _least_known(found: Sequence[Measurement]) -> Uncertainty | None:
    """Return the largest uncertainty of repetitions, of all of which it is known."""
    known = [each.uncertainty for each in found if math.isfinite(each.value)]
    each_of_them = [each for each in known if each is not None]
    if not each_of_them or len(each_of_them) < len(known):
        return None
    return max(each_of_them, key=lambda each: each.expanded)


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
            uncertainty_reason=together.uncertainty_reason,
        )
        return replace(judged, in_common_band=_mean_in_band(found, judged))
    order = list(Verdict)

    def merit(each: Measurement) -> tuple[int, float]:
        """Return the sort key of the worst repetition: verdict before distance, as with guard bands the
        widest uncertainty may fail."""
        return -order.index(limit.judge(each.value, each.uncertainty)), limit.headroom(each.value)

    return replace(min(found, key=merit), definition=definition)


def _all_conform(limit: Limit, found: Sequence[Measurement]) -> float | None:
    """Return the probability that the true values of all repetitions meet a limit (JCGM 106:2012, 7); None
    where one has no uncertainty.

    Errors of instruments move all repetitions alike, and it is the mean over them. Others are taken as
    independent, and it is the least that it may be where they are not (Slepian, Bell Syst. Tech. J. 41 (1962)
    463).
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
    return float(np.mean([math.prod(each or 0.0 for each in of_one) for of_one in chances]))


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
    spread = float(np.std(values, ddof=1)) if len(values) > 1 else math.nan
    return Repeated(
        name,
        unit,
        mean,
        spread / math.sqrt(len(values)) if values else math.nan,
        len(values),
        instruments=tuple(_shared(found)),
        power=tuple(_power(found)),
        unshown=tuple(_unshown(found, spread)),
        single=_least_known(found),
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
