"""What a step of a commissioning is: it plans excitations, and estimates from what was captured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from benchtool.analysis import Measurement
from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.drive import RemoteDrive


@dataclass(frozen=True)
class Finding:
    """Something that is not as it should be, what probably causes it, and what to do about it.

    With `fails` the step fails, and nothing of it is to be used.
    """

    what: str
    cause: str
    remedy: str
    fails: bool = True

    def to_json(self) -> dict[str, str]:
        """Return its sentences."""
        return {"what": self.what, "cause": self.cause, "remedy": self.remedy}


class Step(Protocol):
    """One step. It sends nothing itself: its excitations are played by `commission.execution`.

    `name` is that of the command, `needs` names the steps whose estimates it cannot do without, `sets` the
    parameters of the drive that its estimates are for.
    """

    name: str
    needs: tuple[str, ...]
    sets: tuple[str, ...]

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return what is to be played, in this order."""

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return the estimates by name from the captures, one for each excitation.

        Raises:
            AnalysisError: they do not define them.
        """

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the estimates say about the set-up."""


@runtime_checkable
class Trial(Protocol):
    """A step that also tries what no excitation can: it drives the drive itself, and leaves it disabled and
    supervised on every exit."""

    def attempt(self, drive: RemoteDrive, known: Known) -> Mapping[str, Measurement]:
        """Return the estimates by name."""
