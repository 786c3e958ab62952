"""Result of a reconnection."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.drive.identity import Identity


@dataclass(frozen=True)
class Reconnection:
    """Identity of the drive, and whether it restarted meanwhile; None if that is unknown."""

    identity: Identity
    restarted: bool | None
