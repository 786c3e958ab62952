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

    With `fails` the step fails, and nothing of it is to be used. With `withholds` the drive does not store
    what was found; without, it is of no account for the parameters.
    """

    what: str
    cause: str
    remedy: str
    fails: bool = True
    withholds: bool = True

    def to_json(self) -> dict[str, str]:
        """Return its sentences."""
        return {"what": self.what, "cause": self.cause, "remedy": self.remedy}


@dataclass(frozen=True)
class Loop:
    """A capture that holds the response of a closed loop: by its number, with its title, the channels of the
    reference and of what follows it, and the rows of `analyze_response`."""

    capture: int
    title: str
    input: str
    output: str
    rows: Mapping[str, int]


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
class LoopStep(Protocol):
    """A step that measures a closed loop, which a report draws."""

    def loops(self, known: Known) -> tuple[Loop, ...]:
        """Return which of its captures hold responses."""


@runtime_checkable
class StagedStep(Protocol):
    """A step whose excitations grow, each like the one before, until one suffices; the others are left
    out."""

    def suffices(self, block: Block, known: Known) -> bool:
        """Return whether the capture of an excitation tells what the step is after."""


@runtime_checkable
class RefinedStep(Protocol):
    """A step that is played again where what its captures show is wrong, and tells how to play it better.

    `most_rounds` is how often it is played at most.
    """

    most_rounds: int

    def refined(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return what the next round is to rest on besides what is known; nothing where it would not be
        better. The step's estimates then contain it."""


@runtime_checkable
class FaultTelling(Protocol):
    """A step in which a fault of the drive means more than its code says."""

    def of_fault(self, code: int, known: Known) -> Finding | None:
        """Return what a fault of this code means; None where nothing more."""


@runtime_checkable
class Trial(Protocol):
    """A step that also tries what no excitation can: it drives the drive itself, and leaves it disabled and
    supervised on every exit."""

    def attempt(self, drive: RemoteDrive, known: Known) -> Mapping[str, Measurement]:
        """Return the estimates by name."""
