"""The equipment of a bench: what a session may ask of it, and what a profile and a link say there is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from benchtool.bench.wires.wire import FarEnd
from benchtool.block import Block
from benchtool.errors import ProfileError
from benchtool.profile import Bench, Profile
from benchtool.profile.equipment import (
    DRIVES_BUS,
    Absent,
    CanFrames,
    CanSupply,
    CanTemperature,
    CanTransducer,
    Emulated,
    EmulatedTemperature,
    Person,
)
from benchtool.telemetry import ClockFit


class LoadMachine(Protocol):
    """Equipment on the shaft that loads the motor."""

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed. It may turn as it likes again."""

    def hold(self, omega_m_rad_s: float) -> None:
        """Turn the shaft at this speed, whatever torque that takes."""


class Transducer(Protocol):
    """A torque transducer on the shaft, with a sampling of its own."""

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""

    @property
    def late_s(self) -> float:
        """How long after a moment the host has its sample for certain."""

    def require_alive(self) -> None:
        """Check that it measures.

        Raises:
            NoAnswer: it is silent.
        """

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""

    def block(self, clock: ClockFit | None = None) -> Block:
        """What was recorded, as channel `torque_transducer`, in drive time.

        `clock` is that of the drive's records, which a transducer with a clock of its own needs.

        Raises:
            NoAnswer: it is or fell silent.
            EnvironmentFailure: it does not sample as the profile states, or has no clock to be aligned with.
        """

    def facts(self) -> dict[str, Any]:
        """What is to be kept of the last recording beside its samples: counters, resolution, alignment."""


class Supply(Protocol):
    """The supply of the drive's dc link, or a power analyser at it."""

    @property
    def u_dc_V(self) -> float:
        """Voltage of the dc link now.

        Raises:
            NoAnswer: the instrument is silent.
        """

    @property
    def i_dc_A(self) -> float | None:
        """Current into the dc link now; None where it is not measured.

        Raises:
            NoAnswer: the instrument is silent.
        """

    def set_voltage(self, u_dc_V: float) -> None:
        """Supply another voltage.

        Raises:
            ValueRefused: it cannot be, or this equipment only measures.
        """


@dataclass(frozen=True)
class Temperatures:
    """Temperatures of winding and surroundings; None where no thermometer is."""

    winding_degC: float | None
    ambient_degC: float | None


class Thermometer(Protocol):
    """What tells temperatures of the machine and its surroundings."""

    def temperatures(self) -> Temperatures:
        """Those of now.

        Raises:
            NoAnswer: the instrument is silent.
        """


@dataclass(frozen=True)
class ConstantTemperatures:
    """The thermometer of an emulated bench, whose machine has no thermal model: what the profile states."""

    stated: EmulatedTemperature

    def temperatures(self) -> Temperatures:
        """See `Thermometer.temperatures`; always the same."""
        return Temperatures(self.stated.winding_degC, self.stated.ambient_degC)


@dataclass(frozen=True)
class Declared:
    """What stands on a bench by its profile and the link of its drive."""

    load: Emulated | Person
    transducer: Emulated | CanTransducer | Absent
    supply: Emulated | CanSupply | Absent
    temperature: EmulatedTemperature | CanTemperature | Absent

    @property
    def has_transducer(self) -> bool:
        """Whether it has a torque transducer."""
        return not isinstance(self.transducer, Absent)

    def without_instruments(self) -> Declared:
        """The same bench without what has frames of its own."""
        absent = Absent(kind="none")
        return Declared(
            self.load,
            absent if isinstance(self.transducer, CanFrames) else self.transducer,
            absent if isinstance(self.supply, CanFrames) else self.supply,
            absent if isinstance(self.temperature, CanFrames) else self.temperature,
        )

    def lines(self) -> dict[str, str]:
        """Each piece of equipment in words, by the name of its table."""
        temperature = self.temperature
        if isinstance(temperature, EmulatedTemperature):
            winding_degC, ambient_degC = temperature.winding_degC, temperature.ambient_degC
            told = f"constant: winding {winding_degC:g} °C, surroundings {ambient_degC:g} °C"
        else:
            told = _frames(temperature)
        return {
            "load": "emulated load machine" if isinstance(self.load, Emulated) else "none: a person does it",
            "transducer": (
                "emulated, on the drive's time base"
                if isinstance(self.transducer, Emulated)
                else _frames(self.transducer)
            ),
            "supply": "emulated" if isinstance(self.supply, Emulated) else _frames(self.supply),
            "temperature": told,
        }


def _frames(stated: CanFrames | Absent) -> str:
    if isinstance(stated, Absent):
        return "none"
    bus = "the drive's bus" if stated.bus == DRIVES_BUS else stated.bus
    return f"message '{stated.message}' of {stated.dbc}, {stated.rate_Hz:g} frames/s on {bus}"


def declared(profile: Profile, far_end: FarEnd) -> Declared:
    """What stands on the bench of a profile, by what is at the other end of the link.

    What the profile leaves out is emulated on an emulated bench, and not there on any other.

    Raises:
        ProfileError: it names emulated equipment, and the drive is a real one.
    """
    stated = profile.bench
    if far_end is FarEnd.EMULATED_DRIVE:
        return Declared(
            load=stated.load or Emulated(),
            transducer=stated.transducer or Emulated(),
            supply=stated.supply or Emulated(),
            temperature=stated.temperature or EmulatedTemperature(),
        )
    if far_end is FarEnd.RECORDING:
        stated = Bench()
    for name in ("load", "transducer", "supply", "temperature"):
        if isinstance(getattr(stated, name), Emulated):
            raise ProfileError(
                f"bench.{name} of profile '{profile.title}' is emulated, and the drive is not: name what "
                f"stands on the bench, or leave the table out; or use --link emulated"
            )
    load, transducer, supply = stated.load, stated.transducer, stated.supply
    return Declared(
        load=load or Person(kind="person"),
        transducer=transducer or Absent(kind="none"),
        supply=supply or Absent(kind="none"),
        temperature=stated.temperature or Absent(kind="none"),
    )
