"""Limits with a margin, and the verdict they give."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import Annotated

from pydantic import Field, model_validator

from benchtool.document import Section


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


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of several verdicts; `NONE` of none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.NONE)
