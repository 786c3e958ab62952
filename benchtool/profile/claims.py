"""Choices and claims of a published source, compared with measured numbers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from benchtool.document import Array, Section
from benchtool.profile.motor import Positive


class Choice(Section):
    """Where a source leaves something open or contradicts itself: what was chosen and why."""

    about: str
    """What the source leaves open."""
    choice: str
    """What was chosen."""
    reason: str
    """Why."""
    effect: str
    """What it changes."""


class Reference(Section):
    """A measured number; what is left out is as in the comparison that refers to it."""

    plan: str = ""
    """Its plan."""
    case: str = ""
    """Its case."""
    measurement: str = ""
    """Its measurement."""


class Comparison(Section):
    """A measured number against `times` a value or another measured one; near: within that factor of it."""

    plan: str
    """Plan of the measured number."""
    case: str
    """Case of the measured number."""
    measurement: str
    """The measured number."""
    relation: Literal["below", "above", "near"]
    """What is claimed of it."""
    value: float | None = None
    """A value that it is compared with."""
    other: Reference | None = None
    """Another measured number that it is compared with."""
    times: Positive = 1.0
    """Factor on the value or the other number; for `near`, the ratio that is still near."""

    @model_validator(mode="after")
    def _has_one_partner(self) -> Comparison:
        if (self.value is None) == (self.other is None):
            raise ValueError("a comparison is with value or with other: give one of the two")
        return self


class Claim(Section):
    """What a source claims of its results, and the comparisons that all hold where it is right.

    Numbers that differ by less than the expanded uncertainty of their difference leave a claim undecided.
    """

    claim: str
    """The claim in a sentence."""
    source: str
    """Where the source makes it."""
    comparisons: Annotated[Array[Comparison], Field(min_length=1)]
    """Comparisons that all hold if the claim is right."""
