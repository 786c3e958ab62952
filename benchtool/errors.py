"""Every exception that benchtool raises on purpose, as one tree.

Each message is one line that says what was seen, what was expected and what to do; the command line
prints it as it is. `exit_code` is what a command ends with when the error reaches it: 1 limits failed,
2 usage, 3 cannot connect / environment, 4 drive fault.

    BenchError
    ├── UsageError                 2  the caller asked for something impossible
    │   ├── ProfileError              a profile is unknown, unreadable or wrong
    │   ├── PlanError                 a plan is unknown, unreadable or wrong
    │   ├── ParameterFileError        a parameter file is unreadable, wrong or of another drive
    │   ├── ValueRefused              a value is outside its limits, unit or state; nothing was sent
    │   ├── CapabilityMissing         the drive lacks objects that are needed; nothing was sent
    │   ├── EmulationError            the emulated machine runs away beyond what can be computed
    │   ├── AnalysisError             the data cannot answer the question (gap, too short, no channel)
    │   ├── NoSuchRecording           a recording, run or table is not there, or is another kind of file
    │   ├── NoSuchDictionary          likewise a dictionary file
    │   └── NoSuchAttribute           an object of the API has no attribute of that name
    ├── EnvironmentFailure         3  the environment of the tool is not as needed
    │   ├── LinkError                 frames or bytes do not move
    │   │   ├── NoAnswer              nothing came back in time
    │   │   └── LinkClosed            the link was closed or its adapter vanished
    │   ├── IdentityMismatch          the node is not the drive the profile names
    │   ├── DictionaryMismatch        the drive speaks another dictionary version
    │   ├── ParameterMismatch         the drive holds other parameters than the profile states
    │   ├── DictionaryError           a dictionary file cannot be read
    │   ├── PlugInError               a plug-in of another package is broken
    │   └── RecordingError            a recording cannot be written or read
    └── DriveError                 4  the drive answered, and refused or failed
        ├── SdoAbort                  a read or write was refused with an abort code
        ├── WriteNotVerified          a value read back differs from the value written
        ├── StateError                a CiA 402 transition did not happen
        ├── DriveFault                the drive is in fault
        ├── LimitTrip                 a limit that the host supervises was passed
        ├── CaptureError              the on-drive capture did not complete
        └── StimulusError             the on-drive stimulus was stopped before its end
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Self, TypeVar

MOST_REASONS = 40

_Given = TypeVar("_Given")
_Found = TypeVar("_Found")


class BenchError(Exception):
    """Base of every error that benchtool raises on purpose."""

    exit_code = 1

    @classmethod
    def of_all(cls, reasons: Sequence[str], count: int = 0) -> Self:
        """Return an error of several reasons, a line each: the first is the message, the others are its
        notes, `MOST_REASONS` at most. `count`, if given, is how many there are, of which `reasons` has the
        first."""
        error = cls(reasons[0])
        for reason in reasons[1:MOST_REASONS]:
            error.add_note(reason)
        if (more := max(count, len(reasons)) - MOST_REASONS) > 0:
            error.add_note(f"and {more} more: fix these first")
        return error


class UsageError(BenchError):
    """The caller asked for something impossible."""

    exit_code = 2


class ProfileError(UsageError):
    """A profile is unknown, unreadable or wrong."""


class PlanError(UsageError):
    """A plan is unknown, unreadable or wrong."""


class ParameterFileError(UsageError):
    """A parameter file is unreadable, wrong, or of another drive or dictionary."""


class ValueRefused(UsageError):
    """A value is outside its limits, unit or state; nothing was sent."""


class CapabilityMissing(UsageError):
    """The drive lacks objects that are needed; nothing was sent."""


class EmulationError(UsageError):
    """The emulated machine, as its profile and its load state it, runs away beyond what can be computed."""


class AnalysisError(UsageError):
    """The data cannot answer the question: a gap, too short, a channel missing."""


class SetUpError(AnalysisError):
    """The data tell of a set-up that is wrong: what was seen, its probable cause, the remedy."""

    def __init__(self, what: str, cause: str, remedy: str) -> None:
        super().__init__(f"{what}: {cause}; {remedy}")
        self.what, self.cause, self.remedy = what, cause, remedy


class NoSuchAttribute(UsageError, AttributeError):
    """An object of the API has no attribute of that name, such as a setpoint that is misspelt."""


class EnvironmentFailure(BenchError):
    """The environment of the tool is not as needed."""

    exit_code = 3


class LinkError(EnvironmentFailure):
    """Frames or bytes do not move."""


class NoAnswer(LinkError):
    """Nothing came back in time."""


class LinkClosed(LinkError):
    """The link was closed or its adapter vanished."""


class IdentityMismatch(EnvironmentFailure):
    """The node is not the drive that the profile names."""


class DictionaryMismatch(EnvironmentFailure):
    """The drive speaks another version of the dictionary."""


class ParameterMismatch(EnvironmentFailure):
    """The drive holds other parameters than the profile states."""


class DictionaryError(EnvironmentFailure):
    """A dictionary file cannot be read."""


class NoSuchDictionary(UsageError, DictionaryError):
    """What was named as a dictionary file is not there, or is none."""


class PlugInError(EnvironmentFailure):
    """A plug-in of another package is broken."""


class RecordingError(EnvironmentFailure):
    """A recording cannot be written or read."""


class NoSuchRecording(UsageError, RecordingError):
    """What was named as a recording, a stream of it, a run or a table is not there, or is none."""


class DriveError(BenchError):
    """The drive answered, and refused or failed."""

    exit_code = 4


class SdoAbort(DriveError):
    """A read or write was refused with an SDO abort code (CiA 301, 7.2.4.3.17)."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code

    def __reduce__(self) -> tuple[type[SdoAbort], tuple[str, int]]:
        return type(self), (str(self), self.code)


class WriteNotVerified(DriveError):
    """A value read back differs from the value written."""


class StateError(DriveError):
    """A CiA 402 transition did not happen."""


class DriveFault(DriveError):
    """The drive is in fault."""


class LimitTrip(DriveError):
    """A limit that the host supervises was passed; the drive was told to stop."""


class CaptureError(DriveError):
    """The on-drive capture did not complete."""


class StimulusError(DriveError):
    """The on-drive stimulus was stopped before its end."""


def of_each(find: Callable[[_Given], _Found], given: Iterable[_Given]) -> list[_Found]:
    """Apply `find` to every item and return the results, or raise all refusals at once.

    Raises:
        BenchError: that of the first that is refused, with those of the others as its notes.
    """
    found, refused = [], []
    for each in given:
        try:
            found.append(find(each))
        except BenchError as error:
            refused.append(error)
    if not refused:
        return found
    first, *others = refused
    told = {str(first), *getattr(first, "__notes__", ())}
    for other in others:
        for reason in (str(other), *getattr(other, "__notes__", ())):
            if reason not in told and len(told) < MOST_REASONS:
                first.add_note(reason)
                told.add(reason)
    raise first
