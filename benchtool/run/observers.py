"""Observers of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from benchtool.bench import Session
from benchtool.block import Block
from benchtool.plan import Case
from benchtool.recording import Event, Manifest
from benchtool.results import Assessment
from benchtool.telemetry import Sink


class RunObserver(Protocol):
    """Observer of every case: `opened`, `captured` unless it failed before, `closed`; must not raise or
    block."""

    def opened(self, session: Session, case: Case, manifest: Manifest) -> Sequence[Sink]:
        """Handle the beginning of a case, before enabling; return further sinks for its slow stream.

        `manifest` is that of its bundle. The drive must not be accessed, as that would take time.
        """

    def happened(self, event: Event) -> None:
        """Handle a step of the case, a state of the drive or a fault."""

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """Handle the captures of the drive and the transducer; the drive is disabled again."""

    def closed(self, result: Assessment | None, failure: str) -> None:
        """Handle the end of a case, with a result or a failure."""


class NullRunObserver:
    """Ignores every notification."""

    def opened(self, session: Session, case: Case, manifest: Manifest) -> Sequence[Sink]:
        """Return no sinks."""
        return ()

    def happened(self, event: Event) -> None:
        """Does nothing."""

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """Does nothing."""

    def closed(self, result: Assessment | None, failure: str) -> None:
        """Does nothing."""
