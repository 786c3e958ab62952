"""Results over the repetitions of a case: mean of each measurement, its uncertainty, and verdicts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self

import numpy as np

from benchtool.analysis import (
    Basis,
    Contribution,
    Correction,
    InstrumentError,
    Measurement,
    Uncertainty,
    combined,
    combined_by_names,
    count_of,
    students_deviation,
)
from benchtool.plan import Limit, Plan, cases
from benchtool.results.agreement import disagreements, mean_difference_name, transducer_name
from benchtool.results.judged_repetitions import (
    JudgedTogether,
    bounds_of,
    limits_together,
    reasons_of,
    without_value,
    worst_of,
)

_ROUNDING = 1e-13  # relative: of a mean of equal numbers


@dataclass(frozen=True)
class Repeated:
    """One measurement over the `n` of `count` repetitions in which it was defined.

    `standard_uncertainty` is that of the mean by the scatter, the standard deviation over sqrt(n) with n - 1
    degrees of freedom (JCGM 100:2008, 4.2.3), and nan of fewer than two. That of `uncertainty` and of the
    JSON is the standard deviation of Student's distribution (JCGM 101:2008, 6.4.9.4), as of every other
    number: three repetitions are too few to know their scatter. It also contains what the scatter does not
    show: `instruments` are the errors of sensors and clock, `power` is what the power of their noise adds to
    each, `type_b` what else of type B a repetition states, all of which the repetitions share, and `within`
    what their own data say beyond the scatter. Of one repetition and of equal numbers, which no scatter tells
    of, it is that of a `single` one, and `single_reason` says why that is not known. `correction` is what was
    added to the mean for the sensors, `basis` that of the first repetition, and `judged` the limit that holds
    for them together; None without one. `lacking` is why repetitions have no value.

    Where some are only known to be less than something, the mean of the others alone would be too large:
    `mean` is nan then, and `below` what it is less than, if that is known of every repetition.
    """

    name: str
    unit: str
    mean: float
    standard_uncertainty: float
    n: int
    instruments: tuple[Contribution, ...] = ()
    power: tuple[Contribution, ...] = ()
    type_b: tuple[Contribution, ...] = ()
    within: tuple[Contribution, ...] = ()
    single: Uncertainty | None = None
    single_reason: str = ""
    correction: Correction | None = None
    basis: Basis = field(default_factory=Basis)
    judged: JudgedTogether | None = None
    count: int = 0
    lacking: str = ""
    below: float | None = None

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of the mean; None where there is none, or `uncertainty_reason` says why."""
        if not math.isfinite(self.mean) or self.uncertainty_reason:
            return None
        if self.n == 1 or self._agree:
            return self.single
        source, dof = f"scatter over {self.n} repetitions", self.n - 1.0
        standard = students_deviation(dof) * self.standard_uncertainty
        by_scatter = Contribution(source, "A", standard, dof, of_student=True)
        own = sorted((by_scatter, *self.within), key=lambda line: -line.standard)
        found = combined_by_names(own)
        assert found is not None  # lines of type A are known
        return found.with_power(self.power).with_instruments((*self.type_b, *self.instruments))

    @property
    def uncertainty_reason(self) -> str:
        """Why a mean has no uncertainty; empty where it has one, or there is no mean."""
        if not math.isfinite(self.mean):
            return ""
        if self.n == 1:
            return "" if self.single is not None else self.single_reason or "one repetition has no scatter"
        errors = (*self.power, *self.type_b, *self.instruments)
        unknown = [line.name for line in errors if not math.isfinite(line.standard)]
        if unknown:
            return f"not known of its sensors: {'; '.join(unknown)}"
        if self._agree and self.single is None:
            return f"{self.n} repetitions read the same, so that no scatter tells"
        return ""

    @property
    def remark(self) -> str:
        """That some repetitions have no value, with the reason; empty where all or none of them have one."""
        if not 0 < self.n < self.count:
            return ""
        why = f": {self.lacking}" if self.lacking else ""
        have = "has" if self.n == 1 else "have"
        alone = "" if math.isfinite(self.mean) else "; a mean of the former alone would be too large"
        return f"{self.n} of {self.count} repetitions {have} a value, the others have none{why}{alone}"

    @property
    def reason(self) -> str:
        """Why there is no mean; empty where there is one."""
        if math.isfinite(self.mean):
            return ""
        return self.remark or self.lacking or "no repetition has a value"

    @property
    def n_of_count(self) -> str:
        """In how many repetitions it was defined, and of how many where these are not all."""
        return f"{self.n} of {self.count}" if self.remark else str(self.n)

    @property
    def _agree(self) -> bool:
        """Whether several repetitions are one number: as read in steps, or as none that is below zero."""
        return self.n > 1 and self.standard_uncertainty <= _ROUNDING * abs(self.mean)

    @property
    def combined(self) -> float:
        """Standard uncertainty of the mean, what repetitions share in it; nan of fewer than two."""
        return math.nan if self.uncertainty is None else self.uncertainty.standard

    @property
    def measured(self) -> Measurement:
        """The mean as a measurement."""
        return Measurement(
            self.name,
            self.mean,
            self.unit,
            f"mean of {count_of(self.n, 'repetition')}",
            self.basis,
            self.uncertainty,
            self.reason,
            correction=self.correction,
            uncertainty_reason=self.uncertainty_reason,
            below=self.below,
        )

    def to_json(self) -> dict[str, Any]:
        """Return the fields; nan becomes null."""
        document: dict[str, Any] = {
            "mean": _finite(self.mean),
            "standard_uncertainty": _finite(self.combined),
            "n": self.n,
            "unit": self.unit,
        }
        document |= {"remark": self.remark} if self.remark else {}
        document |= {"reason": self.reason} if self.reason else {}
        document |= {"below": _finite(self.below)} if self.below is not None else {}
        if self.uncertainty is not None:
            document["uncertainty"] = self.uncertainty.to_json()
        elif self.uncertainty_reason:
            document["uncertainty_reason"] = self.uncertainty_reason
        if self.judged is not None:
            document["limit"] = self.judged.to_json()
            if self.judged.disagreement is not None:
                document["disagreement"] = self.judged.disagreement.to_json()
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
        name: tuple(_Group.of(group, plan).together(limits_together(plan, name)))
        for name, group in groups.items()
    }


def judged_together(
    repeated: Mapping[str, Sequence[Repeated]],
) -> Iterator[tuple[str, JudgedTogether]]:
    """Yield every limit over repetitions, each with the name of its case."""
    for case, together in repeated.items():
        yield from ((case, each.judged) for each in together if each.judged is not None)


@dataclass(frozen=True)
class _Group:
    """What each of `count` repetitions of a case measured, by name, and what its limits apply to."""

    found: Mapping[str, Sequence[Measurement]]
    count: int
    judge: Literal["each", "mean", "worst"]

    @classmethod
    def of(cls, measured: Sequence[Sequence[Measurement]], plan: Plan) -> Self:
        """Sort the measurements of all repetitions by their names."""
        found: dict[str, list[Measurement]] = {}
        for each in itertools.chain.from_iterable(measured):
            found.setdefault(each.name, []).append(each)
        return cls(found, len(measured), plan.judge)

    def together(self, limits: Mapping[str, Limit]) -> Iterator[Repeated]:
        """Yield every measurement and every limit over the repetitions."""
        for name in dict.fromkeys((*self.found, *limits)):
            together = _mean_of(name, self.found.get(name, ()), self.count)
            yield replace(together, judged=self._judged(name, limits[name])) if name in limits else together

    def _judged(self, name: str, limit: Limit) -> JudgedTogether:
        """Hold a limit against the value that it applies to, and that against the transducer's."""
        value, on_shaft = self._value(name, limit), self._value(transducer_name(name), limit)
        held = replace(JudgedTogether.of(name, limit, value), count=self.count)
        if self.judge == "worst":
            held = held.of_each(self.found.get(name, ()))
        # the worst of each need not be of one repetition, of which the difference is
        difference = None if self.judge == "worst" else self._value(mean_difference_name(name), limit)
        both = tuple(each for each in (value, on_shaft, difference) if each is not None)
        return replace(held, disagreement=next(iter(disagreements(both, {name: limit})), None))

    def _value(self, name: str, limit: Limit) -> Measurement | None:
        """Return the value that a limit on a measurement applies to; None where nothing was measured."""
        if not (found := self.found.get(name)):
            return None
        if self.judge == "worst":
            return worst_of(limit, found, self.count)
        return _judged_mean(found, self.count)


def _lines(each: Measurement) -> tuple[Contribution, ...]:
    """Return what is known of the errors of one repetition, of its sensors where its data tell nothing."""
    return each.of_sensors if each.uncertainty is None else each.uncertainty.budget


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


def _type_b(found: Sequence[Measurement]) -> Iterator[Contribution]:
    """Yield the lines of type B of a repetition, each as it is in the mean of their squares.

    All repetitions have such an error in common, as far as is known: a reading in steps is not better known
    by being repeated (JCGM 100:2008, 4.3.10 and F.2.2.1).
    """
    known = [_lines(each) for each in found if math.isfinite(each.value)]
    lines = [line for lines in known for line in lines if line.evaluation == "B"]
    own = [line for line in lines if line.instrument is None and not line.adds_power]
    for name in dict.fromkeys(line.name for line in own):
        square = sum(line.standard**2 for line in own if line.name == name)
        yield Contribution(name, "B", math.sqrt(square / len(known)))


def _within(found: Sequence[Measurement], spread: float) -> Iterator[Contribution]:
    """Yield the part of the repetitions' own uncertainties of type A that their standard deviation `spread`
    does not show.

    Few repetitions may agree by chance. The variance of one is at least what its own data say, of its value
    and of how far another record differs, pooled over all (JCGM 100:2008, 4.2.4): as far as the scatter has
    less, the rest is added.
    """
    known = [each for each in found if each.uncertainty and math.isfinite(each.value)]
    lines = (line for each in known if each.uncertainty for line in each.uncertainty.budget)
    own = [line for line in lines if line.evaluation == "A" and not line.adds_power]
    further = (each.repeatability for each in known if each.repeatability is not None)
    own += [line for line in further if math.isfinite(line.standard)]
    pooled = combined(own, "") if own else None
    if pooled is None or not pooled.experimental > 0.0:
        return
    beyond = pooled.experimental**2 / len(known) - spread**2
    if beyond > 0.0:
        factor = math.sqrt(beyond / len(known)) / pooled.experimental
        yield pooled.line("scatter within each repetition", factor)


def _least_known(found: Sequence[Measurement]) -> Uncertainty | None:
    """Return the largest uncertainty of repetitions, of all of which it is known, with how far another record
    differs: no scatter tells."""
    known = [each.uncertainty_of_state for each in found if math.isfinite(each.value)]
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


def _judged_mean(found: Sequence[Measurement], count: int) -> Measurement:
    """Return the mean of `count` repetitions as a limit applies to it; undefined if one of them has no
    value."""
    mean = _mean_of(found[0].name, found, count).measured
    definition = f"mean of {count} repetitions"
    if lacking := without_value(found, count):
        return replace(
            Measurement.undefined(mean.name, mean.unit, definition, lacking), below=mean.upper_bound
        )
    return replace(mean, definition=definition, in_common_band=_mean_in_band(found, mean))


def _mean_in_band(found: Sequence[Measurement], judged: Measurement) -> Measurement | None:
    """Return the mean of the repetitions in the band of a slower transducer; None where one has none."""
    narrow = [each.in_common_band for each in found if each.in_common_band is not None]
    if len(narrow) < len(found):
        return None
    together = _mean_of(judged.name, narrow, len(found))
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


def _mean_of(name: str, found: Sequence[Measurement], count: int) -> Repeated:
    """Return mean and standard deviation of the mean of `count` repetitions; no mean of those alone that have
    a value where others are only known to be less than something."""
    values = [each.value for each in found if math.isfinite(each.value)]
    is_bounded = any(each.upper_bound is not None for each in found)
    bounds = bounds_of(found, count) if is_bounded else None
    mean = float(np.mean(values)) if values and not is_bounded else math.nan
    spread = float(np.std(values, ddof=1)) if len(values) > 1 and not is_bounded else math.nan
    return Repeated(
        name,
        found[-1].unit if found else "",
        mean,
        spread / math.sqrt(len(values)) if values else math.nan,
        len(values),
        instruments=tuple(_shared(found)),
        power=tuple(_power(found)),
        type_b=tuple(_type_b(found)),
        within=tuple(_within(found, spread)),
        single=_least_known(found),
        single_reason=next((each.uncertainty_reason for each in found if each.uncertainty_reason), ""),
        correction=_mean_correction(found),
        basis=found[0].basis if found else Basis(),
        count=count,
        lacking=reasons_of(found),
        below=None if bounds is None else float(np.mean(bounds)),
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
