"""The operator at the bench, who does by hand what no equipment does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from benchtool.errors import UsageError
from benchtool.plan import OperatingPoint


class Confirmation(StrEnum):
    """How an action of the operator was confirmed; stored in the manifest."""

    BY_OPERATOR = "confirmed by the operator"
    BEFOREHAND = "taken as done beforehand"


Prompt = Callable[[str], Confirmation]
"""Asks the operator for an action and returns once it is confirmed; raises UsageError at the end of input."""

UNLOAD = "free the shaft: take off the load, or stop what turns it"


@dataclass(frozen=True)
class Done:
    """An action that the operator was asked for, and how it was confirmed."""

    what: str
    confirmed: Confirmation

    def __str__(self) -> str:
        return f"operator was to {self.what}: {self.confirmed}"


def no_operator(what: str) -> UsageError:
    """Return the error for a bench without an operator to ask."""
    return UsageError(
        f"this bench has no load machine: the operator has to {what}, and there is no prompt; run it on a "
        f"terminal, without --json and --jobs, or give --yes once that is done; the drive was not enabled"
    )


def confirmed_beforehand(what: str) -> Confirmation:
    """Confirm every action as done (`--yes`)."""
    return Confirmation.BEFOREHAND


def instruction(point: OperatingPoint) -> str:
    """Return the action of the operator for an operating point without a load machine; empty if none."""
    if point.hold_speed_rad_s is not None:
        return (
            f"turn the shaft at {abs(point.hold_speed_rad_s):g} rad/s in {_rotation(point.hold_speed_rad_s)}"
        )
    if point.load_torque_Nm:
        side = "against" if point.load_torque_Nm > 0.0 else "towards"
        return f"load the shaft with {abs(point.load_torque_Nm):g} Nm {side} positive rotation"
    return ""


def ask(prompt: Prompt | None, what: str) -> Done | None:
    """Ask the operator for an action; None if there is none to do.

    Raises:
        UsageError: there is no prompt, and so no operator to ask.
    """
    if not what:
        return None
    if prompt is None:
        raise no_operator(what)
    return Done(what, prompt(what))


def _rotation(omega_m_rad_s: float) -> str:
    return "negative rotation" if omega_m_rad_s < 0.0 else "positive rotation"
