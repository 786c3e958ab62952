"""The equipment of a bench: interfaces for a session, and its declaration by profile and link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from benchtool.bench.wires import registry
from benchtool.bench.wires.canopen import require_interface
from benchtool.bench.wires.wire import FarEnd
from benchtool.block import Block
from benchtool.errors import ProfileError, UsageError
from benchtool.profile import (
    DRIVES_BUS,
    Absent,
    Bench,
    CanFrames,
    CanSupply,
    CanTemperature,
    CanTransducer,
    Emulated,
    EmulatedTemperature,
    Operator,
    Profile,
)
from benchtool.telemetry import ClockFit

if TYPE_CHECKING:
    from benchtool.emulator import EmulatedThermometer


class LoadMachine(Protocol):
    """Equipment on the shaft that loads the motor."""

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed. Its speed is free again."""

    def hold(self, omega_m_rad_s: float) -> None:
        """Hold the shaft at this speed at any torque."""


class Transducer(Protocol):
    """A torque transducer on the shaft with its own sampling."""

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""

    @property
    def late_s(self) -> float:
        """Longest delay between a moment and its sample at the host."""

    def require_alive(self) -> None:
        """Check that it measures.

        Raises:
            NoAnswer: no samples arrive.
        """

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""

    def block(self, clock: ClockFit | None = None) -> Block:
        """Return what was recorded, as channel `torque_transducer`, in drive time.

        `clock` is that of the drive's records, which a transducer with a clock of its own needs.

        Raises:
            NoAnswer: no samples arrive, or they stopped.
            EnvironmentFailure: it does not sample as the profile states, or there is no clock to align it
            with.
        """

    def facts(self) -> dict[str, Any]:
        """Return facts on the last recording for the manifest: counters, resolution, alignment."""


class EnergyMeter(Protocol):
    """Tells where the energy of the bench goes, which an emulated bench knows that keeps accounts of it."""

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""

    def block(self) -> Block:
        """Return what was recorded: channels `energy_supply` to `energy_load` in J, since power-up, a row per
        control period."""


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
    """Temperatures of winding and surroundings; None where there is no thermometer."""

    winding_degC: float | None
    ambient_degC: float | None


class Thermometer(Protocol):
    """A thermometer of the machine and its surroundings."""

    def temperatures(self) -> Temperatures:
        """Return the present temperatures.

        Raises:
            NoAnswer: the instrument is silent.
        """


@dataclass(frozen=True)
class EmulatedTemperatures:
    """The thermometers of an emulated bench."""

    source: EmulatedThermometer

    def temperatures(self) -> Temperatures:
        """See `Thermometer.temperatures`."""
        return Temperatures(*self.source.read())


@dataclass(frozen=True)
class Declared:
    """Equipment of a bench as its profile and the link of its drive declare it."""

    load: Emulated | Operator
    transducer: Emulated | CanTransducer | Absent
    supply: Emulated | CanSupply | Absent
    temperature: EmulatedTemperature | CanTemperature | Absent

    @property
    def has_transducer(self) -> bool:
        """Whether it has a torque transducer."""
        return not isinstance(self.transducer, Absent)

    def without_instruments(self, *, thermometer: bool = False) -> Declared:
        """Return the same bench without instruments on CAN, but for its `thermometer` if that is needed."""
        absent = Absent(kind="none")
        return Declared(
            self.load,
            absent if isinstance(self.transducer, CanFrames) else self.transducer,
            absent if isinstance(self.supply, CanFrames) else self.supply,
            absent if isinstance(self.temperature, CanFrames) and not thermometer else self.temperature,
        )

    def lines(self) -> dict[str, str]:
        """Return each piece of equipment in words, by the name of its table."""
        temperature = self.temperature
        if isinstance(temperature, EmulatedTemperature):
            winding_degC, ambient_degC = temperature.winding_degC, temperature.ambient_degC
            told = f"constant: winding {winding_degC:g} °C, surroundings {ambient_degC:g} °C"
        else:
            told = _frames(temperature)
        return {
            "load": "emulated load machine" if isinstance(self.load, Emulated) else "none: by the operator",
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
    """Return the equipment on the bench of a profile, by what is at the other end of the link.

    What the profile leaves out is emulated on an emulated bench, and not there on any other.

    Raises:
        ProfileError: it names emulated equipment, and the drive is a real one; or a bus that cannot be.
    """
    stated = Bench() if far_end is FarEnd.RECORDING else profile.bench
    _require_buses(stated, profile.title)
    if far_end is FarEnd.EMULATED_DRIVE:
        return Declared(
            load=stated.load or Emulated(),
            transducer=stated.transducer or Emulated(),
            supply=stated.supply or Emulated(),
            temperature=stated.temperature or EmulatedTemperature(),
        )
    for name in ("load", "transducer", "supply", "temperature"):
        if isinstance(getattr(stated, name), Emulated):
            raise ProfileError(
                f"bench.{name} of profile '{profile.title}' is emulated, and the drive is not: name what "
                f"stands on the bench, or leave the table out; or use --link emulated"
            )
    load, transducer, supply = stated.load, stated.transducer, stated.supply
    return Declared(
        load=load or Operator(kind="operator"),
        transducer=transducer or Absent(kind="none"),
        supply=supply or Absent(kind="none"),
        temperature=stated.temperature or Absent(kind="none"),
    )


def _require_buses(stated: Bench, title: str) -> None:
    """Refuse the address of an instrument's bus that cannot be; on an emulated bench too."""
    for name in ("transducer", "supply", "temperature"):
        table = getattr(stated, name)
        if not isinstance(table, CanFrames) or table.bus == DRIVES_BUS:
            continue
        try:
            require_interface(registry.parse(table.bus))
        except UsageError as refused:
            raise ProfileError(f"bench.{name}.bus of profile '{title}': {refused}") from None
