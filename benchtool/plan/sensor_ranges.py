"""Check of a plan's trip levels against the sensor ranges of the emulated bench."""

from __future__ import annotations

from pathlib import Path

from benchtool.errors import PlanError
from benchtool.plan.cases import cases
from benchtool.plan.model import Plan
from benchtool.plan.source import Source
from benchtool.profile import Profile, altered
from benchtool.protocol.dictionary import Dictionary, first_breach


def require_protected(plan: Plan, path: Path | None, profile: Profile, dictionary: Dictionary) -> None:
    """Check that no case sets a level beyond the range of the emulated sensors, or beyond another level.

    A real drive refuses such a level when it is written.

    Raises:
        PlanError: a level is out of range; nothing was opened or sent.
        ProfileError: a case alters a key that the bench does not have.
    """
    source = Source.of(plan, path)
    for case in cases(plan):
        bench = altered(profile, case.emulator).emulator
        if bench is None:
            return
        powered = profile.stated_parameters
        ranges = bench.sensors.full_scales()
        breach = first_breach(dictionary, powered, ranges) or first_breach(
            dictionary, {**powered, **plan.setup, **case.setup}, ranges
        )
        if breach:
            raise PlanError(f"{source.place(('setup',))}: case {case.name}: {breach}; nothing was sent")
