"""What a step may rest on: the nameplate, the drive as it is found, and what earlier steps have estimated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Measurement
from benchtool.drive import RemoteDrive
from benchtool.errors import ValueRefused
from benchtool.profile import Motor
from benchtool.protocol.dictionary import Value, Variable

_SAMPLED_S = 0.01
_OF_THE_SWING = 0.7
_SLOWEST_RAD_S = 30.0  # so that a level of some tenths of a second settles
_LONGEST_DEAD_TIME_S = 2e-5  # that a drive compensates
_READ = ("law", "encoder_lines")
_USUAL_LINES = 2500
_SEEN = 3.0  # standard uncertainties, below which nothing is compensated
_NONE: Mapping[str, Measurement] = MappingProxyType({})


@dataclass(frozen=True)
class Known:
    """The host's knowledge of motor and drive; nothing of it is the truth of an emulated bench.

    `motor` is the nameplate; `variables` are the parameters of the drive that can be set, `held` what it holds
    while steps are run, and `estimates` what was estimated, by the dictionary's names.
    """

    motor: Motor
    control_period_s: float
    u_dc_V: float
    u_dc_full_scale_V: float = 0.0
    pwm_period_s: float = 0.0
    variables: Mapping[str, Variable] = field(default_factory=lambda: MappingProxyType({}))
    held: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))
    estimates: Mapping[str, Measurement] = field(default_factory=lambda: _NONE)

    @classmethod
    def of(cls, drive: RemoteDrive, motor: Motor, stated: Mapping[str, Value] | None = None) -> Self:
        """Return what is known before the first step.

        Args:
            drive: connected.
            motor: the nameplate.
            stated: what the drive is to hold meanwhile, by name; the rest as it holds it now.

        Raises:
            NoAnswer, SdoAbort: the drive does not answer, or refused.
            ValueRefused: it reads no dc link.
        """
        drive.wait(_SAMPLED_S)
        u_dc_V = drive.number("u_dc")
        if not u_dc_V > 0.0:
            raise ValueRefused(f"the drive reads a dc link of {u_dc_V:g} V: power it; nothing was sent")
        period_s = round(drive.number("control_period") * 1e9) * 1e-9  # the drive has it as a float32
        pwm_s = round(drive.number("pwm_period") * 1e9) * 1e-9
        variables = {
            each.name: each for each in drive.dictionary if each.role == "parameter" and each.writable
        }
        held = {name: drive.read(name) for name in _READ if name in variables} | dict(stated or {})
        return cls(motor, period_s, u_dc_V, drive.number("u_dc_full_scale"), pwm_s, variables, held)

    def with_estimates(self, found: Mapping[str, Measurement]) -> Self:
        """Return this with more estimates; those without a value are left out."""
        defined = {name: each for name, each in found.items() if math.isfinite(each.value)}
        return replace(self, estimates=MappingProxyType({**self.estimates, **defined}))

    def with_drop(self, drop_V: float) -> Self:
        """Return this with the voltage that dead time and devices take of a phase."""
        return self.with_estimates({"dead_time_voltage": Measurement("dead_time_voltage", drop_V, "V", "")})

    def value(self, name: str, nameplate: float) -> float:
        """Return the estimate of a parameter, or what the nameplate says."""
        found = self.estimates.get(name)
        return nameplate if found is None else found.value

    @property
    def in_force(self) -> dict[str, Value]:
        """What was estimated, as the drive's parameters have it; what is no parameter of it is left out.

        The drive compensates dead time and drop by a time: that in which the dc link makes the voltage they
        take.
        """
        found = {name: each.value for name, each in self.estimates.items()}
        if (drop := self.estimates.get("dead_time_voltage")) is not None:
            standard = 0.0 if drop.uncertainty is None else drop.uncertainty.standard
            seen = drop.value if drop.value > _SEEN * standard else 0.0
            lost_s = seen * (self.pwm_period_s or self.control_period_s)
            found["dead_time_compensation"] = min(lost_s / self.u_dc_V, _LONGEST_DEAD_TIME_S)
        return {
            name: _as_held(self.variables[name], value)
            for name, value in found.items()
            if name in self.variables
        }

    @property
    def law(self) -> str:
        """Control law that the drive is to run with."""
        return str(self.held.get("law", ""))

    @property
    def encoder_lines(self) -> int:
        """Lines of the encoder, four counts each."""
        return int(self.held.get("encoder_lines", _USUAL_LINES))

    @property
    def pole_pairs(self) -> int:
        """Pole pairs, as found or as stated."""
        return round(self.value("pole_pairs", self.motor.pole_pairs))

    @property
    def I_N_A(self) -> float:
        """Rated current, peak."""
        return math.sqrt(2.0) * self.motor.I_N_A_rms

    @property
    def swing_rad_s(self) -> float:
        """Angular frequency at which the rotor swings about a standing vector of the rated current."""
        stiffness = 1.5 * self.motor.pole_pairs**2 * self.motor.psi_r_Wb * self.I_N_A
        return math.sqrt(stiffness / self.motor.J_kgm2)

    @property
    def damping_bandwidth_rad_s(self) -> float:
        """Bandwidth of the current loop with which the stator damps that swing best.

        Above it the current does not yield to the EMF, far below it only the resistance damps, which is
        little beside a large inductance.
        """
        return min(max(_OF_THE_SWING * self.swing_rad_s, _SLOWEST_RAD_S), 0.1 / self.control_period_s)

    @property
    def R_s_ohm(self) -> float:
        """Resistance per phase."""
        return self.value("R_s", self.motor.R_s_ohm)

    @property
    def drop_V(self) -> float:
        """Voltage that dead time and devices take of a phase; 0 as long as it was not estimated."""
        return self.value("dead_time_voltage", 0.0)

    @property
    def offsets(self) -> dict[str, Value]:
        """Parameters of the drive that take the offsets of the current sensors off, as far as estimated."""
        names = [f"current_offset_{phase}" for phase in "abc"]
        return {name: self.estimates[name].value for name in names if name in self.estimates}

    @property
    def gains(self) -> NDArray[np.float64]:
        """Corrections of the gains of the current sensors, shape (3,)."""
        return np.array([self.value(f"current_gain_{phase}", 1.0) for phase in "abc"])


def _as_held(variable: Variable, value: float) -> Value:
    """Return a number as a drive reads it back: rounded to its type, an enumeration by name."""
    if variable.values is not None:
        return next(name for name, number in variable.values.items() if number == round(value))
    whole = variable.type.numpy is not None and np.issubdtype(variable.type.numpy, np.integer)
    return variable.decode(variable.encode(round(value) if whole and variable.factor == 1.0 else value))
