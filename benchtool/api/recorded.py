"""A block with what is known of its recording."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from benchtool.block import Block

if TYPE_CHECKING:
    from benchtool.bench import Session
    from benchtool.telemetry import Certificate


@dataclass(frozen=True, repr=False)
class RecordedBlock(Block):
    """A block that was recorded on a bench.

    `certificate` says how good the data are: rows expected and missing, gaps, counters of the link.
    `transducer` is what a torque transducer of the bench recorded at the same time.
    """

    certificate: Certificate | None = None
    transducer: Block | None = None


def recorded(session: Session, block: Block, transducer: Block | None = None) -> RecordedBlock:
    """Return a capture with its certificate."""
    from benchtool.telemetry import certify_recording

    certificate, _ = certify_recording(None, {"capture": block}, session.drive.link.counters)
    return with_certificate(block, certificate, transducer)


def with_certificate(
    block: Block, certificate: Certificate, transducer: Block | None = None
) -> RecordedBlock:
    """Return the same block, with what is known of it."""
    own = {each.name: getattr(block, each.name) for each in fields(Block)}
    return RecordedBlock(**own, certificate=certificate, transducer=transducer)
