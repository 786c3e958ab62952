"""What is said of a run that did not come to its end, by every command that reads it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchtool.recording import Bundle

_KILLED = "its process ended"
_MOST_NAMED = 4


def cut_short(bundle: Bundle) -> str:
    """Return why a bundle was not finished; empty where it was."""
    return "" if bundle.complete else str(bundle.manifest.details.get("failure", _KILLED))


def incomplete(folder: Path, bundles: Sequence[tuple[str, Bundle]], missing: Sequence[str] = ()) -> str:
    """Return that a run is incomplete, what of it is there, and what to do; empty where it is complete.

    Args:
        folder: of the run, or of one bundle.
        bundles: that are there, each by the name of its case.
        missing: cases of the plan that have no recording.
    """
    reasons = {name: why for name, bundle in bundles if (why := cut_short(bundle))}
    if not reasons and not missing:
        return ""
    if len(bundles) == 1 and not missing:
        (why,) = reasons.values()
        there = f"it was cut short ({why}), what was recorded until then is there"
        return f"{folder} is incomplete: {there}{_remedy(folder, bundles)}"
    told = [f"{len(bundles) - len(reasons)} of {len(bundles) + len(missing)} cases are complete"]
    told += [f"{name} was cut short ({why})" for name, why in reasons.items()]
    more = f" and {len(missing) - _MOST_NAMED} more" if len(missing) > _MOST_NAMED else ""
    told += [f"without a recording: {', '.join(missing[:_MOST_NAMED])}{more}"] if missing else []
    return f"{folder} is incomplete: {'; '.join(told)}{_remedy(folder, bundles)}"


def _remedy(folder: Path, bundles: Sequence[tuple[str, Bundle]]) -> str:
    """Return how a run of a plan goes on; empty of another recording, which cannot."""
    bundle = next((each for _, each in bundles if "plan" in each.manifest.details), None)
    if bundle is None:
        return ""
    line = bundle.manifest.command_line
    plan = line[1] if len(line) > 1 and line[0] == "run" and not line[1].startswith("-") else "PLAN"
    return f"; 'benchtool run {plan} --resume {folder}' goes on"
