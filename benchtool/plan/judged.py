"""A limit held against what was measured: the verdict, the probability of conformance, and both in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

from benchtool.analysis import NOTHING, Measurement, number, probability, raw, with_unit
from benchtool.plan.limits import Limit, Verdict


@dataclass(frozen=True)
class Missed:
    """A limit that was missed, met within its margin only, or undecided, in words."""

    name: str
    verdict: Verdict
    reason: str

    def __str__(self) -> str:
        return f"{self.name} {self.reason}"


@dataclass(frozen=True)
class JudgedLimit:
    """A limit held against what was measured.

    `measured` is None where nothing was. `conformance` is the probability that the limit is met (JCGM
    106:2012, 7); None where `conformance_reason` says why.
    """

    name: str
    limit: Limit
    measured: Measurement | None
    conformance: float | None
    conformance_reason: str = ""

    @classmethod
    def of(cls, name: str, limit: Limit, measured: Measurement | None) -> Self:
        """Hold a limit against one measurement, by whose uncertainty alone it conforms."""
        conformance = None if measured is None else limit.conformance(measured.value, measured.uncertainty)
        reason = _without_uncertainty(measured) if conformance is None else ""
        return cls(name, limit, measured, conformance, reason)

    @property
    def verdict(self) -> Verdict:
        """How the limit is met; what was not measured fails."""
        if self.measured is None:
            return Verdict.FAIL
        if self.measured.upper_bound is not None:
            return self.limit.judge_below(self.measured.upper_bound)
        return self.limit.judge(self.measured.value, self.measured.uncertainty)

    @property
    def counted(self) -> Verdict:
        """The verdict as it counts for the whole: none where the limit is not met, and waived."""
        return self.limit.counted(self.verdict)

    @property
    def headroom(self) -> float:
        """How far inside the nearer bound the value lies, or at least lies where only what it is less than is
        known; nan without either."""
        if self.measured is None:
            return math.nan
        if self.measured.upper_bound is not None:
            return self.limit.headroom_below(self.measured.upper_bound)
        return self.limit.headroom(self.measured.value)

    @property
    def headroom_text(self) -> str:
        """The headroom to three digits, `> 0.018` of a value of which only a bound is known, or a dash."""
        if not math.isfinite(self.headroom):
            return NOTHING
        sign = ""
        if self.measured is not None and self.measured.upper_bound is not None:
            sign = "< " if self.verdict is Verdict.FAIL else "> "
        return f"{sign}{raw(self.headroom, 3)}"

    @property
    def conformance_text(self) -> str:
        """The probability of conformance in words, or why there is none."""
        if self.conformance is None:
            return f"no {self.probability_of}: {self.conformance_reason}"
        return f"{self.probability_of} {probability(self.conformance)}"

    @property
    def without_conformance(self) -> str:
        """Why there is no probability of conformance, without the reasons that the measurement gives itself;
        empty where there is one."""
        reason = _without_uncertainty(self.measured)
        return _lacking(self.measured) if self.conformance_reason == reason else self.conformance_reason

    @property
    def remark(self) -> str:
        """That no value can pass the limit with such an uncertainty; empty where one can."""
        uncertainty = None if self.measured is None else self.measured.uncertainty
        if uncertainty is None or not self.limit.is_narrower(uncertainty.expanded):
            return ""
        return (
            f"no value can pass, as the bounds are closer together than 2 U = "
            f"{number(2.0 * uncertainty.expanded, 2)}: lower the uncertainty, or set them further apart"
        )

    @property
    def probability_of(self) -> str:
        """What its conformance is the probability of."""
        return "probability of conformance"

    @property
    def told(self) -> Missed | None:
        """Why the limit was not met, or met within its margin only; None where it was."""
        return None if self.verdict is Verdict.PASS else Missed(self.name, self.verdict, self._reason)

    @property
    def missed(self) -> Missed | None:
        """The limit that was not met and counts, or was met within its margin only; else None."""
        return self.told if self.counted is self.verdict else None

    @property
    def waived(self) -> Missed | None:
        """The limit that was not met, and is waived; else None."""
        return self.told if self.counted is not self.verdict else None

    def to_json(self) -> dict[str, Any]:
        """Return the bounds, the rule in words, the verdict, and the probability of conformance or why there
        is none."""
        document = self.limit.model_dump(exclude_none=True)
        document |= {"rule": self.limit.rule, "verdict": str(self.verdict)}
        document |= {"remark": self.remark} if self.remark else {}
        if self.conformance is None:
            return document | {"conformance_reason": self.conformance_reason}
        return document | {"conformance": self.conformance}

    @property
    def _reason(self) -> str:
        """What is told of a value that does not pass."""
        limit, measured = self.limit, self.measured
        if measured is None:
            return f"was not measured, {self.bounds} is asked for"
        if not math.isfinite(measured.value):
            why = measured.reason or measured.definition
            what = "undefined" if measured.upper_bound is None else measured.in_unit
            return f"is {what} ({why}), {self.bounds} is asked for"
        value = f"is {measured.in_unit}"
        if self.verdict is Verdict.MARGINAL:
            return f"{value}, within {with_unit(raw(limit.margin), measured.unit)} of its limit {self.bounds}"
        if limit.margin == "U":
            return f"{value}, {self._guarded(measured)}"
        return f"{value}, {limit.shortfall(measured.value, measured.unit)}"

    @property
    def bounds(self) -> str:
        """The bounds in the unit of the measurement, or in that which the limit states."""
        stated = self.limit.unit or ""
        return with_unit(self.limit.bounds, stated if self.measured is None else self.measured.unit)

    def _guarded(self, measured: Measurement) -> str:
        """Return why a finite value does not pass a limit with a guard band."""
        limit, uncertainty = self.limit, measured.uncertainty
        if uncertainty is None or not math.isfinite(uncertainty.expanded):
            why = _without_uncertainty(measured)
            return f'{why}, which margin = "U" of its limit {self.bounds} needs'
        place = limit.shortfall(measured.value, measured.unit)
        place = place or f"{with_unit(raw(self.headroom, 3), measured.unit)} inside its limit {self.bounds}"
        apart = f"{'more' if self.verdict is Verdict.FAIL else 'less'} than its U"
        remark = f"; {self.remark}" if self.remark else ""
        return f"{place}, {apart}; {self.conformance_text}{remark}"


def _lacking(measured: Measurement | None) -> str:
    """Return whether it is a measurement, its value or its uncertainty that is lacking."""
    if measured is None:
        return "it was not measured"
    if measured.upper_bound is not None:
        return "no more is known than what it is less than"
    return "its uncertainty is not known" if math.isfinite(measured.value) else "it is undefined"


def _without_uncertainty(measured: Measurement | None) -> str:
    """Return the same, with the reason of the measurement."""
    if measured is None:
        return _lacking(measured)
    reason = measured.reason or measured.definition
    why = measured.uncertainty_reason if math.isfinite(measured.value) else reason
    return f"{_lacking(measured)}{f' ({why})' if why else ''}"
