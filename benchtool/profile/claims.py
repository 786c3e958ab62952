"""What a published source leaves open and what it claims, beside the numbers that were measured."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from benchtool.document import Array, Section
from benchtool.profile.motor import Positive


class Choice(Section):
    """Where a source leaves something open or contradicts itself: what was chosen and why."""

    about: str
    choice: str
    reason: str
    effect: str


class Reference(Section):
    """A measured number; what is left out is as in the comparison that refers to it."""

    plan: str = ""
    case: str = ""
    measurement: str = ""


class Comparison(Section):
    """A measured number against `times` a value or another measured one; near: within that factor of it."""

    plan: str
    case: str
    measurement: str
    relation: Literal["below", "above", "near"]
    value: float | None = None
    other: Reference | None = None
    times: Positive = 1.0

    @model_validator(mode="after")
    def _has_one_partner(self) -> Comparison:
        if (self.value is None) == (self.other is None):
            raise ValueError("a comparison is with value or with other: give one of the two")
        return self


class Claim(Section):
    """What a source claims of its results, and the comparisons that all hold where it is right."""

    claim: str
    source: str
    comparisons: Annotated[Array[Comparison], Field(min_length=1)]
