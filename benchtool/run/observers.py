"""Whoever looks at a run while it goes on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from benchtool.bench.session import Session
from benchtool.block import Block
from benchtool.plan.cases import Case
from benchtool.recording import Event, Manifest
from benchtool.results.assessment import Assessment
from benchtool.telemetry import Sink


class Watcher(Protocol):
    """Told of every case: `opened`, `captured` if it came to that, `closed`; must not raise or wait long."""

    def opened(self, session: Session, case: Case, manifest: Manifest) -> Sequence[Sink]:
        """A case begins, set up but with nothing enabled yet; further sinks for its slow stream.

        `manifest` is that of its bundle. Nothing may be asked of the drive: that would take its time.
        """

    def happened(self, event: Event) -> None:
        """A step of the case, a state of the drive, a fault."""

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """What the drive and the transducer recorded; the drive is disabled again."""

    def closed(self, result: Assessment | None, failure: str) -> None:
        """A case has ended, with a result or with a failure."""


class Unwatched:
    """Nobody looks."""

    def opened(self, session: Session, case: Case, manifest: Manifest) -> Sequence[Sink]:
        """No sinks."""
        return ()

    def happened(self, event: Event) -> None:
        """Nothing."""

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """Nothing."""

    def closed(self, result: Assessment | None, failure: str) -> None:
        """Nothing."""
