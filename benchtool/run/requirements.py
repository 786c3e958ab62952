"""What a plan takes of a drive, before anything is sent to it."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.drive import Mode
from benchtool.drive.capabilities import Capabilities, Capability
from benchtool.plan.cases import Case
from benchtool.plan.model import Plan

_OF_MODES = {Mode.TORQUE: Capability.TORQUE, Mode.VELOCITY: Capability.VELOCITY}


def require_capable(capabilities: Capabilities, plan: Plan, case: Case) -> None:
    """Check that a drive can do what a case of a plan takes.

    Whether it can be supervised is found out when it is connected: a profile may let it run without.

    Raises:
        CapabilityMissing: it cannot.
    """
    capabilities.require(*_needed(plan, case), purpose=f"case '{case.name}' of the plan")


def _needed(plan: Plan, case: Case) -> Iterator[Capability]:
    mode = case.operating_point.mode_of_operation
    if mode in _OF_MODES:
        yield _OF_MODES[mode]
    yield Capability.CAPTURE
    if plan.stimulus is not None:
        yield Capability.STIMULUS
