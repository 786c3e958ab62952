"""Uncertainty in the terms of the GUM (JCGM 100:2008): standard, expanded, degrees of freedom, budget."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final, Literal

from benchtool.analysis.distributions import (
    normal_below,
    student_below,
    student_quantile,
    students_deviation,
)

_MANY = 1e6  # degrees of freedom: k of infinitely many is less by a millionth

SURE: Final = 3.0
"""Standard uncertainties, of many degrees of freedom, by which two values contradict each other."""

COVERAGE: Final = 0.95
"""Coverage probability of an expanded uncertainty."""


@dataclass(frozen=True)
class InstrumentError:
    """An error of an instrument that stays the same over all results made with it, such as that of its gain.

    `effect` says of what, `channel` what it measured. Two results have it in common where `effect` and serial
    number are the same and the certificate is, so that it was not adjusted in between; without serial number,
    where effect, channel and certificate are; without both it is unknown, and taken as different.
    """

    effect: str
    channel: str
    sensor: str = ""
    serial_number: str = ""
    certificate: str = ""

    def is_same(self, other: InstrumentError) -> bool:
        """Return whether the error of both is one and the same."""
        identified = bool(self.serial_number or self.certificate)
        return identified and self._identity == other._identity

    @property
    def _identity(self) -> tuple[str, ...]:
        if self.serial_number:
            return self.effect, self.sensor, self.serial_number, self.certificate
        return self.effect, self.channel, self.sensor, "", self.certificate


@dataclass(frozen=True)
class Contribution:
    """One line of a budget: a standard uncertainty in the unit of the result.

    `evaluation` is A where it comes from the statistics of repeated observations, B where it comes from
    anything else, such as a resolution (JCGM 100:2008, 2.3.2 and 2.3.3); `dof` are its degrees of freedom.
    `instrument` tells of which error of which instrument it comes, and `sign` whether the result grows (1)
    or falls (-1) as that error does: both are needed where results have the error in common.
    `of_student` tells that `standard` is the standard deviation of Student's distribution, which is
    sqrt(dof / (dof - 2)) times the experimental one (JCGM 101:2008, 6.4.9.4): few observations count in it.
    `adds_power` tells that it is by how much the power of noise makes a root of powers larger, which it does
    in every record of the same noise.
    """

    name: str
    evaluation: Literal["A", "B"]
    standard: float
    dof: float = math.inf
    instrument: InstrumentError | None = None
    sign: Literal[-1, 1] = 1
    of_student: bool = False
    adds_power: bool = False

    @property
    def experimental(self) -> float:
        """Standard uncertainty without what few observations add, which Student's factor covers."""
        return self.standard / students_deviation(self.dof) if self.of_student else self.standard

    @property
    def of(self) -> str:
        """What contributes, in a few words: the effect and the channel of an instrument."""
        return (
            self.name if self.instrument is None else f"{self.instrument.effect} of {self.instrument.channel}"
        )

    def power(self, value: float) -> float:
        """Return the power that makes the result `value` larger by this, where it `adds_power`."""
        return self.standard * (2.0 * abs(value) - self.standard)

    def scaled(self, factor: float) -> Contribution:
        """Return the contribution to the result times a constant."""
        sign: Literal[-1, 1] = 1 if (factor < 0.0) == (self.sign < 0) else -1
        return replace(self, standard=abs(factor) * self.standard, sign=sign)

    def to_json(self) -> dict[str, Any]:
        """Return its fields; infinite degrees of freedom are null."""
        document: dict[str, Any] = {
            "name": self.name,
            "evaluation": self.evaluation,
            "standard": _finite(self.standard),
            "dof": self.dof if self.dof < _MANY else None,
        }
        if self.instrument is not None:
            document |= {"instrument": asdict(self.instrument), "sign": self.sign}
        told = {"of_student": self.of_student, "adds_power": self.adds_power}
        return document | {key: value for key, value in told.items() if value}


@dataclass(frozen=True)
class Uncertainty:
    """Combined standard uncertainty of a result, in its unit (JCGM 100:2008, 2.3.1 and 2.3.4).

    `source` states what it was estimated from, the larger part first, and thus what it does not contain.
    `dof` are the effective degrees of freedom, `budget` the contributions: where it is left out, the one of
    type A that the source says. `half_width` is half of the interval that covers 95 % where a derived
    distribution gives one; it is then the expanded uncertainty in place of a multiple from Student's
    distribution.
    """

    standard: float
    source: str
    dof: float = math.inf
    budget: tuple[Contribution, ...] = ()
    half_width: float | None = None

    def __post_init__(self) -> None:
        if not self.budget:
            alone = Contribution(self.source, "A", self.standard, self.dof)
            object.__setattr__(self, "budget", (alone,))

    @property
    def expanded(self) -> float:
        """U, half of the interval that covers the true value with a probability of 95 %."""
        if self.half_width is not None:
            return self.half_width
        return coverage_factor(self.dof) * self.experimental

    @property
    def experimental(self) -> float:
        """Combined standard uncertainty without what few observations add to it: Student's factor covers
        them, and once is enough."""
        twice = sum(each.standard**2 - each.experimental**2 for each in self.budget if each.of_student)
        return math.sqrt(max(0.0, self.standard**2 - twice)) if twice else self.standard

    @property
    def student_factor(self) -> float | None:
        """Student's factor of 95 % and these degrees of freedom, U over the experimental standard uncertainty
        (JCGM 100:2008, G.3.2); None where U is half of the interval of a derived distribution."""
        return None if self.half_width is not None else coverage_factor(self.dof)

    @property
    def k(self) -> float:
        """Coverage factor, U over the standard uncertainty (JCGM 100:2008, 2.3.6). Where few observations
        add to that it is less than Student's factor."""
        if self.standard > 0.0 and math.isfinite(self.standard):
            return self.expanded / self.standard
        return coverage_factor(self.dof)

    def half_width_of(self, coverage: float) -> float:
        """Return half of the interval that covers the true value with another probability than 95 %: of
        Student's distribution with these degrees of freedom, as wide as the expanded uncertainty says."""
        return self.expanded * coverage_factor(self.dof, coverage) / coverage_factor(self.dof)

    def probability_within(self, least: float, greatest: float) -> float:
        """Return the probability that the true value less the result lies from `least` to `greatest`: of a
        normal distribution, of Student's with finite degrees of freedom, as wide as the expanded uncertainty
        says.
        """
        dof, U = max(1.0, self.dof), self.expanded
        if U <= 0.0:
            return 1.0 if least <= 0.0 <= greatest else 0.0
        low, high = (bound * coverage_factor(dof) / U for bound in (least, greatest))
        if math.isfinite(dof):
            return student_below(dof, high) - student_below(dof, low)
        return normal_below(high) - normal_below(low)

    def scaled(self, factor: float, source: str = "") -> Uncertainty:
        """That of the result times a constant."""
        size = abs(factor)
        budget = tuple(each.scaled(factor) for each in self.budget)
        width = None if self.half_width is None else size * self.half_width
        return Uncertainty(size * self.standard, source or self.source, self.dof, budget, width)

    def line(self, name: str, factor: float = 1.0) -> Contribution:
        """Return the one line of another budget, `name`, in which this result counts `factor` times.

        Both of its standard uncertainties are kept, by the degrees of freedom that make one of the other. It
        is of type B where most of its square is.
        """
        other2 = sum(each.experimental**2 for each in self.budget if each.evaluation == "B")
        kind: Literal["A", "B"] = "B" if other2 > 0.5 * self.experimental**2 else "A"
        ratio2 = (self.standard / self.experimental) ** 2 if self.experimental > 0.0 else 1.0
        if not ratio2 > 1.0:
            return Contribution(name, kind, abs(factor) * self.standard, self.dof)
        alone = math.isclose(ratio2, students_deviation(self.dof) ** 2, rel_tol=1e-9)
        dof = self.dof if alone else 2.0 * ratio2 / (ratio2 - 1.0)
        return Contribution(name, kind, abs(factor) * self.standard, dof, of_student=True)

    def with_instruments(self, errors: Sequence[Contribution]) -> Uncertainty:
        """That which the errors of instruments contribute to besides, as independent of all that is known.

        Where a derived distribution gives the half-width, the errors' is combined with it as standard
        uncertainties are.
        """
        if not errors:
            return self
        added = math.hypot(*(each.standard for each in errors))
        found = self._with(self.standard**2 + added**2, added, (*self.budget, *errors))
        parts = [self.source, *dict.fromkeys(each.of for each in errors)]
        if added > self.standard:
            parts = [*parts[1:], parts[0]]
        return replace(found, source=", ".join(filter(None, parts)))

    def without(self, errors: Sequence[Contribution]) -> Uncertainty:
        """That which is left without some lines of the budget, of infinite degrees of freedom."""
        if not errors:
            return self
        removed = math.hypot(*(each.standard for each in errors))
        left = tuple(each for each in self.budget if each not in errors)
        return self._with(max(0.0, self.standard**2 - removed**2), -removed, left)

    def with_power(self, added: Sequence[Contribution]) -> Uncertainty:
        """That of a root of powers to which noise adds by these lines: in its half-width, as in that of one
        record, they count as they stand."""
        if not added:
            return self
        power2 = sum(each.standard**2 for each in added)
        found = replace(self, half_width=None)._with(self.standard**2 + power2, 0.0, (*self.budget, *added))
        return replace(found, half_width=math.hypot(self.expanded, math.sqrt(power2)))

    def without_power(self) -> Uncertainty:
        """That which is left without what noise adds to a root of powers; of a half-width, in which it counts
        as it stands, too."""
        removed2 = sum(each.standard**2 for each in self.budget if each.adds_power)
        left = tuple(each for each in self.budget if not each.adds_power)
        found = replace(self, half_width=None)._with(max(0.0, self.standard**2 - removed2), 0.0, left)
        width = None if self.half_width is None else math.sqrt(max(0.0, self.half_width**2 - removed2))
        return replace(found, half_width=width)

    def _with(self, square: float, changed: float, budget: tuple[Contribution, ...]) -> Uncertainty:
        """Of this square of the standard uncertainty; `changed` is what was added or, negative, removed."""
        width = self.half_width
        if width is not None:
            moved = math.copysign((coverage_factor(math.inf) * changed) ** 2, changed)
            width = math.sqrt(max(0.0, width**2 + moved))
        own2 = self.experimental**2
        fourth = own2**2 / self.dof if self.dof > 0.0 else 0.0
        dof = _effective(max(0.0, own2 + square - self.standard**2), fourth)
        return Uncertainty(math.sqrt(square), self.source, dof, budget, width)

    def to_json(self) -> dict[str, Any]:
        """Return the fields, with what U is computed from and what covers how much; what is not finite is
        null."""
        document: dict[str, Any] = {
            "standard": _finite(self.standard),
            "experimental": _finite(self.experimental),
            "dof": self.dof if self.dof < _MANY else None,
            "student_factor": self.student_factor,
            "k": _finite(self.k),
            "coverage": COVERAGE,
            "expanded": _finite(self.expanded),
            "source": self.source,
        }
        if self.half_width is not None:
            document["half_width"] = _finite(self.half_width)
        document["budget"] = [each.to_json() for each in self.budget]
        return document


def combined(
    contributions: Iterable[Contribution], source: str, *, half_width: float | None = None
) -> Uncertainty | None:
    """Return the root of the sum of squares, with Welch and Satterthwaite's degrees of freedom (JCGM
    100:2008, G.4.1).

    None where a contribution is not known (nan): then the whole is not known either.
    """
    budget = tuple(contributions)
    squares = sum(each.standard**2 for each in budget)
    if not math.isfinite(squares):
        return None
    own = [each.experimental for each in budget]
    fourth = sum(u**4 / each.dof for u, each in zip(own, budget, strict=True))
    dof = _effective(sum(u**2 for u in own), fourth)
    return Uncertainty(math.sqrt(squares), source, dof, budget, half_width)


def combined_by_names(contributions: Iterable[Contribution]) -> Uncertainty | None:
    """`combined`, whose source is the names of the contributions: no other error is in it."""
    budget = tuple(contributions)
    return combined(budget, ", ".join(each.name for each in budget))


def of_difference(
    one: Uncertainty, two: Uncertainty, values: tuple[float, float] | None = None
) -> Uncertainty:
    """Return the uncertainty of the difference of two results (JCGM 100:2008, 5.1.2 and G.4.1).

    They are independent but for the errors of instruments that they have in common: of those remains what
    each moves one result more than the other (5.2.2, with a correlation of one). With the `values` of both,
    of the power that noise adds to them only what both powers differ by remains, as it makes the roots
    differ.
    Where a derived distribution gives the interval of one, the intervals' half-widths are combined as the
    standard uncertainties are.
    """
    if values is not None:
        added = [
            (a, b)
            for a in one.budget
            for b in two.budget
            if a.adds_power and b.adds_power and a.name == b.name
        ]
        sides = abs(values[0]) + abs(values[1])
        apart = [abs(a.power(values[0]) - b.power(values[1])) / sides for a, b in added] if sides else []
        rest = of_difference(one.without_power(), two.without_power()) if added else None
        if rest is not None:
            left = [Contribution(a.name, "B", u) for (a, _), u in zip(added, apart, strict=False) if u > 0.0]
            return rest.with_instruments(left)
    common = _in_common(one, two)
    if common:
        rest = of_difference(
            one.without([each for each, _ in common]), two.without([each for _, each in common])
        )
        left = [replace(a, standard=abs(a.sign * a.standard - b.sign * b.standard)) for a, b in common]
        return rest.with_instruments([each for each in left if each.standard > 0.0])
    experimental = math.hypot(one.experimental, two.experimental)
    fourth = (
        sum((each.experimental / experimental) ** 4 / max(1.0, each.dof) for each in (one, two))
        if experimental > 0.0
        else 0.0
    )
    derived = one.half_width is not None or two.half_width is not None
    return Uncertainty(
        math.hypot(one.standard, two.standard),
        "both values",
        _effective(1.0, fourth),
        (*one.budget, *two.budget),
        half_width=math.hypot(one.expanded, two.expanded) if derived else None,
    )


def sure_of(uncertain: Uncertainty | None, sigmas: float = SURE) -> float:
    """Return the difference that an uncertainty leaves as unlikely as so many standard uncertainties are of
    many degrees of freedom, by Student's distribution of those that it has; 0 without one."""
    return 0.0 if uncertain is None else uncertain.half_width_of(1.0 - 2.0 * normal_below(-sigmas))


def _in_common(one: Uncertainty, two: Uncertainty) -> list[tuple[Contribution, Contribution]]:
    """Return the lines of two budgets that are one error of one instrument, each once: those of one channel
    before others, as an instrument may have several."""
    left = [(b, b.instrument) for b in two.budget if b.instrument is not None]
    pairs = []
    for a in one.budget:
        of = a.instrument
        if of is None:
            continue
        same = [each for each in left if of.is_same(each[1])]
        if same:
            found = next((each for each in same if each[1].channel == of.channel), same[0])
            left.remove(found)
            pairs.append((a, found[0]))
    return pairs


def _effective(square: float, fourth: float) -> float:
    """Return the effective degrees of freedom, of the sums u^2 and u_i^4 / dof_i (JCGM 100:2008, G.4.1);
    infinite where they are so many that k is that of infinitely many. Further digits do not show in k."""
    return float(f"{square**2 / fourth:.7g}") if fourth * _MANY > square**2 else math.inf


def coverage_factor(dof: float, coverage: float = COVERAGE) -> float:
    """Return the k of a coverage probability, 95 % unless told: the two-sided quantile of Student's
    distribution (JCGM 100:2008, G.3.2), 1.96 for many."""
    return student_quantile(max(1.0, min(float(dof), 1e12)), 0.5 + 0.5 * coverage)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
