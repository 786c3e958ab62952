"""The sensors of the emulated bench as a profile states them; those of each channel by the channel's name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from benchtool.document import Section, defaults

Gain = Annotated[float, Field(ge=-100, le=100)]
Current = Annotated[float, Field(ge=-1e5, le=1e5)]
Volts = Annotated[float, Field(ge=-1e6, le=1e6)]
Angle = Annotated[float, Field(ge=-100, le=100)]
Amplitude = Annotated[float, Field(ge=0, le=0.3)]
Corner = Annotated[float, Field(ge=1, le=1e9)]


class CurrentSensor(Section):
    """The emulated current sensor of a phase: (gain + drift) times the current, plus offset, drift and noise.

    The drifts are per kelvin of `warm_up_K`.
    """

    gain: Gain = 1.0
    """Gain of the reading; negative with the sensor mounted the other way round."""
    offset_A: Current = 0.0
    """Reading without a current."""
    noise_A_rms: Annotated[float, Field(ge=0, le=1e5)] | None = None
    """Noise of a sample; left out, `current_noise_A_rms`."""
    gain_drift_per_K: Annotated[float, Field(ge=-1, le=1)] = 0.0
    """Change of the gain per kelvin."""
    offset_drift_A_K: Annotated[float, Field(ge=-1e4, le=1e4)] = 0.0
    """Change of the offset per kelvin, in A."""
    bandwidth_Hz: Annotated[float, Field(ge=100, le=1e9)] | None = None
    """Where the sensor, a first-order lag, has lost 3 dB."""
    delay_s: Annotated[float, Field(ge=0, le=1e-3)] = 0.0
    """Dead time of the sensor and its converter."""
    stuck_A: Current | None = None
    """What the channel reads whatever the current."""


class VoltageSensor(Section):
    """The emulated sensor of the dc link: gain times the voltage, plus offset and noise."""

    gain: Gain = 1.0
    """Gain of the reading."""
    offset_V: Volts = 0.0
    """Reading without a voltage."""
    noise_V_rms: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Noise of a sample."""
    bandwidth_Hz: Corner | None = None
    """Where the sensor, a first-order lag, has lost 3 dB."""
    stuck_V: Volts | None = None
    """What the channel reads whatever the voltage."""


class TemperatureSensor(Section):
    """The emulated thermometers of winding and surroundings: gain times degrees Celsius, plus offset and
    noise."""

    gain: Gain = 1.0
    """Gain of the reading."""
    offset_K: Annotated[float, Field(ge=-1e3, le=1e3)] = 0.0
    """Reading at 0 °C."""
    noise_K_rms: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Noise of a reading."""
    lag_s: Annotated[float, Field(ge=0, le=1e5)] = 0.0
    """Time constant with which the reading follows the temperature."""
    resolution_K: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Step of the reading; 0: none."""


class EncoderFlaws(Section):
    """What is wrong with the emulated encoder; its angles are mechanical.

    The position that it shows is ahead of its disc by amplitude times sin(angle + phase) of the disc's angle,
    and the same of twice the angle.
    """

    reversed: bool = False
    """It counts down where the shaft turns up."""
    relative: bool = False
    """It counts from zero at power-up, wherever the shaft is, until the index passes."""
    index: bool = False
    """A pulse in each revolution sets the count to zero."""
    lost_every: Annotated[int, Field(ge=0, le=2**31)] = 0
    """Of so many edges one is not counted; 0: all are."""
    slip: Annotated[float, Field(ge=-1, le=1)] = 0.0
    """Part of the shaft's angle by which the disc stays behind."""
    eccentricity_1_rad: Amplitude = 0.0
    """Amplitude of the position's error once in a revolution."""
    eccentricity_1_phase_rad: Angle = 0.0
    """Its phase."""
    eccentricity_2_rad: Amplitude = 0.0
    """Amplitude of the position's error twice in a revolution."""
    eccentricity_2_phase_rad: Angle = 0.0
    """Its phase."""
    stuck: bool = False
    """The count never changes, as with its cable pulled."""


class Sensors(Section):
    """The emulated current, voltage and position measurement."""

    adc_bits: Annotated[int, Field(ge=4, le=24)] = 10
    """Resolution of the converters of current and voltage."""
    i_full_scale_A: Annotated[float, Field(ge=1e-3, le=1e5)]
    """Current at the end of the converter's range; it saturates there."""
    u_full_scale_V: Annotated[float, Field(ge=1e-3, le=1e6)]
    """Voltage of the dc link at the end of the converter's range."""
    current_noise_A_rms: Annotated[float, Field(ge=0, le=1e5)] = 0.0
    """Noise of a current sample, rms."""
    sampling_point: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Where in the PWM period the currents are sampled. 1: its end, where all lower switches are on."""
    shunt_settling_s: Annotated[float, Field(ge=1e-9, le=1e-4)] | None = None
    """Currents are measured by shunts in the lower legs, read once a leg's switch was on for this long."""
    warm_up_K: Annotated[float, Field(ge=-200, le=200)] = 0.0
    """Temperature by which the current sensors warm up after power-up."""
    warm_up_s: Annotated[float, Field(ge=1e-3, le=1e6)] = 600.0
    """Time constant of their warming up."""
    encoder_lines: Annotated[int, Field(gt=0, le=2**24)] = 2500
    """Lines of the incremental encoder; it counts four times as many edges in a revolution."""
    encoder_offset_rad: Annotated[float, Field(ge=-100, le=100)] = 0.0
    """Mechanical angle of the encoder's zero against the rotor flux on phase a."""
    i_a: CurrentSensor = defaults(CurrentSensor)
    """The current sensor of phase a."""
    i_b: CurrentSensor = defaults(CurrentSensor)
    """The current sensor of phase b."""
    i_c: CurrentSensor = defaults(CurrentSensor)
    """The current sensor of phase c."""
    u_dc: VoltageSensor = defaults(VoltageSensor)
    """The voltage sensor of the dc link."""
    encoder: EncoderFlaws = defaults(EncoderFlaws)
    """What is wrong with the encoder."""
    temperature: TemperatureSensor = defaults(TemperatureSensor)
    """The thermometers of winding and surroundings."""

    def full_scales(self) -> Mapping[str, float]:
        """Return the ends of the converter's ranges, by the keys of the objects that tell of them."""
        return {"i_full_scale_A": self.i_full_scale_A, "u_dc_full_scale_V": self.u_full_scale_V}
