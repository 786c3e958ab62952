"""Equipment beside the drive as `[bench]` names it: load, torque transducer, dc supply and temperature.

Each table has a `kind`. Where a table is left out, an emulated bench has its own equipment, and a bench with
a real drive has none: the operator loads the shaft.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from benchtool.document import Section
from benchtool.profile.motor import NotNegative, Positive

DRIVES_BUS = "drive"
"""The `bus` of an instrument that is on the same CAN bus as the drive."""

Signal = Annotated[str, Field(min_length=1)]


class Emulated(Section):
    """What the emulated bench has, without a wire of its own."""

    kind: Literal["emulated"] = "emulated"
    """The emulated bench's own equipment."""


class EmulatedTemperature(Emulated):
    """Temperatures of an emulated bench: constants, as the emulated machine has no thermal model."""

    winding_degC: float = 25.0
    """Temperature of the winding."""
    ambient_degC: float = 25.0
    """Temperature of the surroundings."""


class Operator(Section):
    """The operator does it by hand, and confirms it."""

    kind: Literal["operator", "person"]
    """An operator is asked to load the shaft before the drive is enabled; "person" is its former name."""


class Absent(Section):
    """The bench has none."""

    kind: Literal["none"]
    """The bench has none."""


class CanFrames(Section):
    """Frames of an instrument on a CAN bus, as a DBC file describes them.

    `dbc` is a file beside the profile, `message` a message in it that comes `rate_Hz` times a second. `bus`
    is `drive` or the address of another bus, such as `can:socketcan:can1?bitrate=1000000`.
    """

    kind: Literal["can"]
    """An instrument on a CAN bus."""
    dbc: Signal
    """DBC file beside the profile that describes the frames."""
    message: Signal
    """Message of the DBC file."""
    rate_Hz: Positive
    """Frames per second."""
    bus: str = DRIVES_BUS
    """`drive` for the drive's own bus, or the address of another one as `--link` takes it."""

    @property
    def read_signals(self) -> tuple[str, ...]:
        """The signals of the message that are read."""
        return ()

    @field_validator("bus")
    @classmethod
    def _is_a_bus(cls, bus: str) -> str:
        if bus != DRIVES_BUS and not bus.startswith("can:"):
            raise ValueError("'drive' or an address as --link takes it is expected: can:INTERFACE:CHANNEL")
        return bus


class CanTransducer(CanFrames):
    """A torque transducer whose frames hold one sample, or some that follow each other, oldest first.

    `signals` names the signal of each sample; the samples of all frames are evenly spaced. `counter` names a
    signal that counts frames up and wraps: with one, lost frames are told from late ones. `delay_s` is how
    long before a frame arrives its last sample was taken (filter, conversion and transmission), less what the
    drive's own records take; it is known within +-`delay_limit_s`.
    """

    signals: Annotated[tuple[Signal, ...], Field(min_length=1, max_length=32, strict=False)]
    """Signal of each torque sample of a frame, oldest first."""
    counter: str = ""
    """Signal that counts frames up and wraps; it tells lost frames from late ones."""
    delay_s: NotNegative = 0.0
    """Time from the last sample of a frame to the frame's arrival."""
    delay_limit_s: NotNegative = 0.0
    """Limits within which `delay_s` is known."""

    @model_validator(mode="after")
    def _each_signal_once(self) -> Self:
        for name in self.read_signals:
            if self.read_signals.count(name) > 1:
                raise ValueError(
                    f"signal '{name}' is named twice, a signal for each sample and one that counts are "
                    f"expected: name the others"
                )
        return self

    @property
    def read_signals(self) -> tuple[str, ...]:
        """See `CanFrames.read_signals`."""
        return (*self.signals, *((self.counter,) if self.counter else ()))

    @property
    def sample_rate_Hz(self) -> float:
        """Samples per second."""
        return self.rate_Hz * len(self.signals)


class CanSupply(CanFrames):
    """A power analyser that tells the voltage of the dc link, and its current if `i_dc` is named."""

    u_dc: Signal
    """Signal with the voltage of the dc link."""
    i_dc: str = ""
    """Signal with the current of the dc link."""

    @property
    def read_signals(self) -> tuple[str, ...]:
        """See `CanFrames.read_signals`."""
        return (self.u_dc, *((self.i_dc,) if self.i_dc else ()))


class CanTemperature(CanFrames):
    """A thermometer of the winding, of the surroundings, or of both."""

    winding: str = ""
    """Signal with the temperature of the winding."""
    ambient: str = ""
    """Signal with the temperature of the surroundings."""

    @property
    def read_signals(self) -> tuple[str, ...]:
        """See `CanFrames.read_signals`."""
        return tuple(name for name in (self.winding, self.ambient) if name)

    @model_validator(mode="after")
    def _one_at_least(self) -> Self:
        if not (self.winding or self.ambient):
            raise ValueError("neither 'winding' nor 'ambient' names a signal: name one at least")
        return self


Load = Annotated[Emulated | Operator, Field(discriminator="kind")]
Transducer = Annotated[Emulated | CanTransducer | Absent, Field(discriminator="kind")]
Supply = Annotated[Emulated | CanSupply | Absent, Field(discriminator="kind")]
Temperature = Annotated[EmulatedTemperature | CanTemperature | Absent, Field(discriminator="kind")]
