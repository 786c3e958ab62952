"""A stimulus as a value: what the drive is to play, in SI, and the objects that say so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, model_validator

from benchtool.document import Section
from benchtool.errors import ValueRefused
from benchtool.profile import Motor
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import Value

_SUFFIXES = {"torque": "Nm", "speed": "rad_s", "d_current": "A", "voltage": "V", "current": "A"}
_UNITS = {**_SUFFIXES, "speed": "rad/s"}
_MODES = {
    "torque": (Mode.TORQUE,),
    "speed": (Mode.VELOCITY,),
    "d_current": (Mode.TORQUE, Mode.VELOCITY),
    "voltage": (Mode.VOLTAGE,),
    "current": (Mode.CURRENT,),
}
_NEEDED: Mapping[str, tuple[str, ...]] = {
    "staircase": ("steps",),
    "sine": ("frequency_Hz",),
    "chirp_linear": ("frequency_start_Hz", "frequency_end_Hz"),
    "chirp_logarithmic": ("frequency_start_Hz", "frequency_end_Hz"),
    "prbs": ("prbs_clock_s", "prbs_length", "seed"),
}
_OF_VECTORS = ("voltage", "current")
_OVERLOAD = 1.1  # of the rated current, what an injected one may be
_OF_SHAPES = tuple(dict.fromkeys(key for keys in _NEEDED.values() for key in keys))
_ROUNDING = 1.0 + 1e-6  # a drive has its control period as a float32

Hertz = Annotated[float, Field(ge=0.0, le=40_000.0)]
Seconds = Annotated[float, Field(gt=0.0, le=3600.0)]


class Stimulus(Section):
    """A test signal, offset + amplitude x shape, that the drive adds to one of its references.

    Amplitude and offset are in the unit of the quantity: Nm, rad/s, A peak, V peak. A torque plays in torque
    mode, a speed in velocity mode, a d_current in either, by way of the flux reference that every law of the
    reference drive follows. A voltage takes the place of the law in voltage mode, a current in current mode,
    along `angle_rad` against phase a or, with `frame = "rotor"`, along the rotor flux. Against phase a either
    may turn with `omega_e_rad_s`, to which it comes up within `turn_s`; what lasts twice as long and more
    comes to rest again in the last `turn_s`.

    Shapes over the ticks of one repetition: `constant` 1; `step` 1, and 0 from the middle on; `staircase`
    1/n, 2/n to 1 in n `steps`; `ramp` from 0 towards 1; `sine`, `chirp_linear` and `chirp_logarithmic` from
    phase zero; `prbs` +-1, a maximum-length sequence of a register of `prbs_length` bits that `seed` starts,
    one bit per `prbs_clock_s`. `duration_s` is that of one repetition; a prbs without it lasts one period.
    """

    quantity: Literal["torque", "speed", "d_current", "voltage", "current"]
    """What is played."""
    shape: Literal[
        "constant", "step", "staircase", "ramp", "sine", "chirp_linear", "chirp_logarithmic", "prbs"
    ]
    """Its course over one repetition."""
    amplitude_Nm: float | None = None
    """Amplitude of a torque."""
    amplitude_rad_s: float | None = None
    """Amplitude of a speed."""
    amplitude_A: float | None = None
    """Amplitude of a d-current or a current, peak."""
    amplitude_V: float | None = None
    """Amplitude of a voltage, peak; no operating point of a plan is in voltage or current mode yet."""
    offset_Nm: float | None = None
    """Offset of a torque."""
    offset_rad_s: float | None = None
    """Offset of a speed."""
    offset_A: float | None = None
    """Offset of a d-current or a current, peak."""
    offset_V: float | None = None
    """Offset of a voltage, peak."""
    duration_s: Seconds | None = None
    """Length of one repetition; a PRBS without it lasts one period."""
    repetitions: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    """How often it is played, without a pause."""
    steps: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """Steps of a staircase."""
    frequency_Hz: Hertz | None = None
    """Frequency of a sine."""
    frequency_start_Hz: Hertz | None = None
    """Frequency at which a chirp begins."""
    frequency_end_Hz: Hertz | None = None
    """Frequency at which a chirp ends."""
    prbs_clock_s: Seconds | None = None
    """Length of one bit of a PRBS."""
    prbs_length: Annotated[int, Field(ge=2, le=20)] | None = None
    """Bits of the shift register of a PRBS."""
    seed: Annotated[int, Field(ge=1, le=0xFFFFF)] | None = None
    """Start of the shift register of a PRBS."""
    frame: Literal["stator", "rotor"] = "stator"
    """Frame of a voltage or current: phase a, or the rotor flux."""
    angle_rad: Annotated[float, Field(ge=-6.2832, le=6.2832)] = 0.0
    """Electrical angle of a voltage or current against phase a."""
    omega_e_rad_s: Annotated[float, Field(ge=-20_000.0, le=20_000.0)] = 0.0
    """Electrical speed with which a voltage or current turns."""
    turn_s: Annotated[float, Field(ge=0.0, le=3600.0)] = 0.0
    """Time in which a voltage or current comes up to that speed, evenly, and to rest before the end."""

    @model_validator(mode="after")
    def _keys_fit(self) -> Stimulus:
        suffix = _SUFFIXES[self.quantity]
        given = {key for key, value in self if value is not None}
        if f"amplitude_{suffix}" not in given:
            raise ValueError(f"a {self.quantity} needs its amplitude_{suffix}")
        for kind in ("amplitude", "offset"):
            for other in set(_SUFFIXES.values()) - {suffix}:
                if f"{kind}_{other}" in given:
                    raise ValueError(f"a {self.quantity} has {kind}_{suffix}, not {kind}_{other}")
        needed = _NEEDED.get(self.shape, ())
        if missing := [key for key in needed if key not in given]:
            raise ValueError(f"shape '{self.shape}' needs {', '.join(missing)}")
        if unused := [key for key in _OF_SHAPES if key in given and key not in needed]:
            raise ValueError(f"shape '{self.shape}' has no {', '.join(unused)}")
        if self.quantity not in _OF_VECTORS and (self.omega_e_rad_s or self.turn_s):
            raise ValueError(f"a {self.quantity} does not turn: it has no omega_e_rad_s and no turn_s")
        if self.duration_s is None and self.shape != "prbs":
            raise ValueError(f"shape '{self.shape}' needs duration_s")
        if self.shape == "chirp_logarithmic" and 0.0 in (self.frequency_start_Hz, self.frequency_end_Hz):
            raise ValueError("a logarithmic chirp has frequencies above 0")
        if self.seed is not None and self.seed & (1 << (self.prbs_length or 0)) - 1 == 0:
            raise ValueError(f"seed {self.seed} has no bit set within a register of {self.prbs_length}")
        return self

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return _UNITS[self.quantity]

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Modes of operation in which it plays."""
        return _MODES[self.quantity]

    @property
    def amplitude(self) -> float:
        """Amplitude in `unit`."""
        value: float = getattr(self, f"amplitude_{_SUFFIXES[self.quantity]}")
        return value

    @property
    def offset(self) -> float:
        """Offset in `unit`."""
        value: float | None = getattr(self, f"offset_{_SUFFIXES[self.quantity]}")
        return value or 0.0

    @property
    def peak(self) -> float:
        """Bound of its magnitude in `unit`."""
        return abs(self.offset) + abs(self.amplitude)

    def require_rated(self, motor: Motor) -> None:
        """Check that the motor may have it.

        Raises:
            ValueRefused: it is a torque or a speed beyond the profile's rating, or a current beyond 1.1
                times the rated one.
        """
        match self.quantity:
            case "torque":
                self.require_within(motor.T_N_Nm, "the profile's rated torque T_N")
            case "speed":
                self.require_within(motor.omega_m_N_rad_s, "the profile's rated speed omega_m_N")
            case "current":
                most_A = _OVERLOAD * math.sqrt(2.0) * motor.I_N_A_rms
                self.require_within(most_A, f"{_OVERLOAD:g} times the profile's rated current, peak,")

    def require_within(self, limit: float, name: str) -> None:
        """Check that it stays within a limit in `unit`.

        Raises:
            ValueRefused: it does not.
        """
        if self.peak > limit:
            raise ValueRefused(
                f"the {self.quantity} stimulus reaches {self.peak:.6g} {self.unit}, {name} is "
                f"{limit:.6g} {self.unit}: lower its amplitude or offset; nothing was written"
            )

    def ticks(self, control_period_s: float) -> int:
        """Control ticks of one repetition, the nearest whole number.

        Raises:
            ValueRefused: it is shorter than a tick.
        """
        if self.duration_s is not None:
            return _ticks("duration_s", self.duration_s, control_period_s)
        assert self.prbs_clock_s is not None
        assert self.prbs_length is not None
        bit = _ticks("prbs_clock_s", self.prbs_clock_s, control_period_s)
        return bit * ((1 << self.prbs_length) - 1)

    def table(self, control_period_s: float) -> dict[str, Value]:
        """Return the values of the drive's objects by name.

        Raises:
            ValueRefused: a duration is shorter than a tick, or a frequency above half of the control rate.
        """
        start_Hz = self.frequency_Hz if self.shape == "sine" else self.frequency_start_Hz
        highest_Hz = 0.5 / control_period_s
        for each_Hz in (start_Hz, self.frequency_end_Hz):
            if each_Hz is not None and each_Hz > highest_Hz * _ROUNDING:
                raise ValueRefused(
                    f"the stimulus reaches {each_Hz:g} Hz, a drive that controls every "
                    f"{control_period_s:g} s plays up to {highest_Hz:g} Hz: lower the frequency; nothing was "
                    f"written"
                )
        rows: dict[str, Value | None] = {
            "stimulus_quantity": self.quantity,
            "stimulus_shape": self.shape,
            "stimulus_amplitude": self.amplitude,
            "stimulus_offset": self.offset,
            "stimulus_ticks": self.ticks(control_period_s),
            "stimulus_repetitions": self.repetitions,
            "stimulus_frequency_start": start_Hz,
            "stimulus_frequency_end": self.frequency_end_Hz,
            "stimulus_steps": self.steps,
            "stimulus_prbs_length": self.prbs_length,
            "stimulus_seed": self.seed,
            "stimulus_frame": self.frame,
            "stimulus_angle": self.angle_rad,
        }
        if self.quantity in _OF_VECTORS:
            rows["stimulus_omega_e"] = self.omega_e_rad_s
            rows["stimulus_turn_ticks"] = round(self.turn_s / control_period_s)
        if self.prbs_clock_s is not None:
            rows["stimulus_prbs_clock"] = _ticks("prbs_clock_s", self.prbs_clock_s, control_period_s)
        return {name: value for name, value in rows.items() if value is not None}


def _ticks(name: str, duration_s: float, control_period_s: float) -> int:
    ticks = round(duration_s / control_period_s)
    if ticks < 1:
        raise ValueRefused(
            f"{name} = {duration_s:g} s is shorter than the control period of {control_period_s:g} s: "
            f"lengthen it; nothing was written"
        )
    return ticks
