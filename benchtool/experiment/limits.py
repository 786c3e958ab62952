"""Limits with a margin, and the verdict they give."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, model_validator

from benchtool.document import Section

if TYPE_CHECKING:
    from benchtool.analysis import Measurement


class Verdict(StrEnum):
    """Outcome of a case or of a run, from best to worst; `NONE` where no limit was asked for."""

    NONE = "none"
    PASS = "pass"
    MARGINAL = "marginal"
    FAIL = "fail"


class Limit(Section):
    """Bounds of one measurement in its own unit; within `margin` of a bound the verdict is marginal."""

    min: float | None = None
    max: float | None = None
    margin: Annotated[float, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _bounded(self) -> Limit:
        if self.min is None and self.max is None:
            raise ValueError("a limit needs min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min} is above max {self.max}")
        return self

    def judge(self, value: float | None) -> Verdict:
        """Verdict on a value; a value that is missing or not finite fails."""
        if value is None or not math.isfinite(value):
            return Verdict.FAIL
        below = math.inf if self.min is None else value - self.min
        above = math.inf if self.max is None else self.max - value
        room = min(below, above)
        if room < 0:
            return Verdict.FAIL
        return Verdict.MARGINAL if room < self.margin else Verdict.PASS

    def shortfall(self, value: float) -> str:
        """The bound that a value fails by and how far beyond that it is; empty of one that does not."""
        if self.min is not None and value < self.min:
            return f"at least {self.min:g} is asked for: {self.min - value:.3g} too little"
        if self.max is not None and value > self.max:
            return f"at most {self.max:g} is allowed: {value - self.max:.3g} too much"
        return ""

    @property
    def bounds(self) -> str:
        """`>= 1, <= 2`."""
        signs = ((">=", self.min), ("<=", self.max))
        return ", ".join(f"{sign} {bound:g}" for sign, bound in signs if bound is not None)


@dataclass(frozen=True)
class Missed:
    """A limit that was not met, or met within its margin only, in words."""

    name: str
    verdict: Verdict
    reason: str

    def __str__(self) -> str:
        return f"{self.name} {self.reason}"


def missed(name: str, limit: Limit, measured: Measurement | None) -> Missed | None:
    """What is to be said of a limit and the measurement that it holds for; None where it was met."""
    verdict = limit.judge(None if measured is None else measured.value)
    if verdict is Verdict.PASS:
        return None
    if measured is None:
        return Missed(name, verdict, f"was not measured, {limit.bounds} is asked for")
    if not math.isfinite(measured.value):
        why = measured.reason or measured.definition
        return Missed(name, verdict, f"is undefined ({why}), {limit.bounds} is asked for")
    value = f"is {measured.value:.4g} {measured.unit}".rstrip()
    if verdict is Verdict.MARGINAL:
        return Missed(name, verdict, f"{value}, within {limit.margin:g} of its limit {limit.bounds}")
    return Missed(name, verdict, f"{value}, {limit.shortfall(measured.value)}")


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of several verdicts; `NONE` of none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.NONE)
