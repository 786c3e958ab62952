"""What is known of a drive whose link was lost and came back."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.drive.identity import Identity


@dataclass(frozen=True)
class Reconnection:
    """Who answers, and whether the drive restarted meanwhile; None where its ticks do not tell."""

    identity: Identity
    restarted: bool | None
