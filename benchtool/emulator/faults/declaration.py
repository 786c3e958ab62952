"""What a fault is: its name, its parameters, what it does, and what is expected of drive and host."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

Setting = float | str


class Place(StrEnum):
    """Where a fault is."""

    WIRE = "wire"
    HOST = "host"
    DRIVE = "drive"
    PLANT = "plant"


class Outcome(StrEnum):
    """What is to become of a drive that is enabled when the fault begins."""

    STOPS = "stops"
    """The torque ends by the drive's own doing, and the drive stays off."""
    ENDED = "ended"
    """The drive does not notice; the host does by what it streams or reads, and disables it."""
    GOES_ON = "goes on"
    """The work goes on; what was lost is counted."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a fault.

    `choices` are its values if it is a word. `least` and `most` bound a number.
    """

    name: str
    default: Setting
    unit: str
    meaning: str
    least: float = 0.0
    most: float = 1e9
    choices: tuple[str, ...] = ()

    @property
    def spelling(self) -> str:
        """Name, default and unit, as a table prints them."""
        value = self.default if isinstance(self.default, str) else f"{self.default:g}"
        return f"{self.name}={value}"


@dataclass(frozen=True)
class Kind:
    """A fault as the table declares it.

    Attributes:
        name: as it is spelled.
        place: what fails.
        does: one sentence.
        outcome: of a drive that is enabled.
        named: what the host is to say or count, in the words that it uses.
        parameters: in the order of the table.
        can_only: it is one of a CAN bus.
        compiles: what it takes may have to be compiled first.
    """

    name: str
    place: Place
    does: str
    outcome: Outcome
    named: str
    parameters: tuple[Parameter, ...] = ()
    can_only: bool = False
    compiles: bool = False

    @property
    def defaults(self) -> dict[str, Setting]:
        """The parameters as they are where none is given."""
        return {each.name: each.default for each in self.parameters}


@dataclass(frozen=True)
class Fault:
    """A fault to be injected, `at_s` seconds after it was armed."""

    kind: Kind
    values: Mapping[str, Setting]
    at_s: float = 0.0

    def number(self, name: str) -> float:
        """Return a parameter that is a number."""
        return float(self.values[name])

    def word(self, name: str) -> str:
        """Return a parameter that is a word."""
        return str(self.values[name])

    @property
    def duration_s(self) -> float:
        """How long it lasts; 0 until it is ended."""
        return float(self.values.get("duration_s", 0.0))

    def __str__(self) -> str:
        given = ",".join(
            f"{name}={value if isinstance(value, str) else f'{value:g}'}"
            for name, value in self.values.items()
            if value != self.kind.defaults[name]
        )
        return f"{self.kind.name}{':' if given else ''}{given}@{self.at_s:g}"
