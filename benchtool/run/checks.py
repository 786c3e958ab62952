"""A plan against the profile, the drive and the bench it will run on, before anything is opened or sent."""

from __future__ import annotations

from pathlib import Path

from benchtool.bench import dictionary_of, equipment_of, require_faults
from benchtool.bench.wires import FarEnd, registry
from benchtool.drive import Capabilities
from benchtool.plan import Plan, cases, require_known, require_protected
from benchtool.profile import load_profile, profile_path
from benchtool.run.requirements import require_capable


def check_plan(plan: Plan, path: Path | None, profile_name: str, link: str) -> None:
    """Refuse a plan that cannot be run.

    Args:
        plan: as it was read, or made.
        path: of its file, for messages; None of a plan that was made in Python.
        profile_name: of the profile that it runs with.
        link: address of the drive.

    Raises:
        CapabilityMissing: the drive cannot do what a case takes.
        PlanError: something is unknown, out of its limits or cannot be measured.
        ProfileError, UsageError: profile and link are wrong, or do not fit each other.
    """
    require_faults(plan.faults, link)
    profile = load_profile(profile_name)
    dictionary, equipment = dictionary_of(profile_name), equipment_of(profile_name, link)
    capabilities = Capabilities.of(dictionary)
    for case in cases(plan):
        require_capable(capabilities, plan, case)
    require_known(
        plan,
        path,
        profile,
        dictionary,
        transducer=equipment.has_transducer,
        profile_file=profile_path(profile_name),
    )
    if registry.far_end(link) is FarEnd.EMULATED_DRIVE:
        require_protected(plan, path, profile, dictionary)
