"""A plan's trip levels against the sensors of the emulated bench that each of its cases runs on."""

from __future__ import annotations

from pathlib import Path

from benchtool.document import line_of
from benchtool.errors import PlanError
from benchtool.plan.cases import cases
from benchtool.plan.model import Plan
from benchtool.profile import Profile, altered
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.relations import first_breach


def require_protected(plan: Plan, path: Path, profile: Profile, dictionary: Dictionary) -> None:
    """Check that on the emulated bench no case sets a level beyond what its sensors tell, or beyond another.

    A drive with a converter of its own refuses such a level itself, when it is written.

    Raises:
        PlanError: one does; nothing was opened or sent.
        ProfileError: a case alters what the bench has not.
    """
    text = path.read_text(encoding="utf-8")
    for case in cases(plan):
        bench = altered(profile, case.emulator).emulator
        if bench is None:
            return
        powered = profile.commissioned()
        ranges = bench.sensors.full_scales()
        breach = first_breach(dictionary, powered, ranges) or first_breach(
            dictionary, {**powered, **plan.setup, **case.setup}, ranges
        )
        if breach:
            raise PlanError(
                f"{path}{line_of(text, ('setup',))}: case {case.name}: {breach}; nothing was sent"
            )
