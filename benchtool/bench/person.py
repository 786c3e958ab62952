"""A person at the bench, who does what no equipment does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from benchtool.errors import UsageError
from benchtool.plan.model import OperatingPoint


class Confirmed(StrEnum):
    """How it is known that a person has done something; a manifest keeps it."""

    BY_THE_PERSON = "confirmed by the person"
    BEFOREHAND = "taken as done beforehand"


Prompt = Callable[[str], Confirmed]
"""Says what a person has to do and returns once it is done; raises UsageError where the person has gone."""

UNLOAD = "free the shaft: take off the load, or stop what turns it"


@dataclass(frozen=True)
class Done:
    """What a person was asked to do, and how it is known to be done."""

    what: str
    confirmed: Confirmed

    def __str__(self) -> str:
        return f"a person was to {self.what}: {self.confirmed}"


def unasked(what: str) -> UsageError:
    """The refusal where there is no person to ask."""
    return UsageError(
        f"this bench has no load machine: a person has to {what}, and there is none to ask; run it on a "
        f"terminal, without --json and --jobs, or give --yes once that is done; the drive was not enabled"
    )


def beforehand(what: str) -> Confirmed:
    """A prompt that takes everything as done."""
    return Confirmed.BEFOREHAND


def instruction(point: OperatingPoint) -> str:
    """What a person has to do for an operating point where no load machine does it; empty for nothing."""
    if point.hold_speed_rad_s is not None:
        return (
            f"turn the shaft at {abs(point.hold_speed_rad_s):g} rad/s in {_rotation(point.hold_speed_rad_s)}"
        )
    if point.load_torque_Nm:
        side = "against" if point.load_torque_Nm > 0.0 else "towards"
        return f"load the shaft with {abs(point.load_torque_Nm):g} Nm {side} positive rotation"
    return ""


def ask(prompt: Prompt | None, what: str) -> Done | None:
    """Ask for something; None if there is nothing to do. Without a prompt there is no person to ask.

    Raises:
        UsageError: there is no person to ask.
    """
    if not what:
        return None
    if prompt is None:
        raise unasked(what)
    return Done(what, prompt(what))


def _rotation(omega_m_rad_s: float) -> str:
    return "negative rotation" if omega_m_rad_s < 0.0 else "positive rotation"
