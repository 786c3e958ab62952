"""Which pages are generated, each with its introduction."""

from __future__ import annotations

import functools

from benchtool.plan.model import Plan
from benchtool.profile import Profile
from docs.generate import command_line, decisions, faults, json_page, models, motors

_PROFILE = """
A profile is a TOML file that describes one motor on one drive, and the bench they stand on. A key ends in its
unit. Motor quantities are per phase and amplitude-invariant (peak), see [notation](notation.md). A key that
this page does not list is refused. This page is generated from the models that read a profile.
"""

_PLAN = """
A plan is a TOML file that describes one test: what to set up, where to run, what to play and record, what to
measure, and the limits. A key ends in its unit. A key that this page does not list is refused. This page is
generated from the models that read a plan; [write a plan](../how_to/write_a_plan.md) explains how the parts
work together.
"""


@functools.cache
def all_pages() -> dict[str, str]:
    """Every generated page by the name of its file, from docs on."""
    profiles, plans = models.documents_of("profile"), models.documents_of("plan")
    return {
        "reference/profile.md": models.page("Keys of a profile", _PROFILE, Profile, profiles),
        "reference/plan.md": models.page("Keys of a plan", _PLAN, Plan, plans),
        "reference/motors.md": motors.page(),
        "reference/json_documents.md": json_page.page(),
        "reference/command_line.md": command_line.page(),
        "reference/exit_codes.md": command_line.exit_codes(),
        "faults.md": faults.page(),
        "decisions/index.md": decisions.page(),
    }
