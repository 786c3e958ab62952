"""What a drive of another maker lacks for a step: the step is left out, and says so."""

from __future__ import annotations

from collections.abc import Sequence

from benchtool.commission.excitation import Excitation
from benchtool.drive import Capability, RemoteDrive

_SHOWN = 4


def without(drive: RemoteDrive, capability: Capability) -> str:
    """Return why a step that takes a capability is left out; empty if the drive has it."""
    finding = drive.capabilities.findings[capability]
    if finding.available:
        return ""
    return f"it takes a {capability}, and the drive has not {_listed(finding.missing)}"


def objects_missing(drive: RemoteDrive, excitations: Sequence[Excitation]) -> str:
    """Return why excitations cannot be played on this drive; empty if they can."""
    if any(each.stimulus is not None for each in excitations) and (
        reason := without(drive, Capability.STIMULUS)
    ):
        return reason
    names = [name for each in excitations for name in (*each.request.channels, *each.parameters)]
    absent = [name for name in dict.fromkeys(names) if name not in drive.dictionary]
    return f"the drive has not {_listed(absent)}" if absent else ""


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _SHOWN
    return ", ".join(names[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
