"""Capabilities that a plan needs of a drive, checked before anything is sent."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.drive import Capabilities, Capability
from benchtool.plan import Case, Plan
from benchtool.protocol import Mode

_OF_MODES = {Mode.TORQUE: Capability.TORQUE, Mode.VELOCITY: Capability.VELOCITY}


def require_capable(capabilities: Capabilities, plan: Plan, case: Case) -> None:
    """Check that a drive has the capabilities that a plan needs.

    Link supervision is checked at connection, as a profile may allow a drive without.

    Raises:
        CapabilityMissing: one is missing.
    """
    capabilities.require(*_needed(plan, case), purpose=f"case '{case.name}' of the plan")


def _needed(plan: Plan, case: Case) -> Iterator[Capability]:
    mode = case.operating_point.mode_of_operation
    if mode in _OF_MODES:
        yield _OF_MODES[mode]
    yield Capability.CAPTURE
    if plan.stimulus is not None:
        yield Capability.STIMULUS
