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
from benchtool.protocol.dictionary import Value

_SAMPLED_S = 0.01
_OF_THE_SWING = 0.7
_SLOWEST_RAD_S = 30.0  # so that a level of some tenths of a second settles
_LONGEST_DEAD_TIME_S = 2e-5  # that a drive compensates
_NONE: Mapping[str, Measurement] = MappingProxyType({})


@dataclass(frozen=True)
class Known:
    """The host's knowledge of motor and drive; nothing of it is the truth of an emulated bench.

    `motor` is the nameplate; `estimates` has what was estimated, by the dictionary's names.
    """

    motor: Motor
    control_period_s: float
    u_dc_V: float
    u_dc_full_scale_V: float = 0.0
    pwm_period_s: float = 0.0
    estimates: Mapping[str, Measurement] = field(default_factory=lambda: _NONE)

    @classmethod
    def of(cls, drive: RemoteDrive, motor: Motor) -> Self:
        """Return what is known before the first step.

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
        return cls(motor, period_s, u_dc_V, drive.number("u_dc_full_scale"), pwm_s)

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
    def parameters(self) -> dict[str, float]:
        """What was estimated, by the names of the drive's parameters that it is for; what the drive has not
        is left out by the caller.

        The drive compensates dead time and drop by a time: that in which the dc link makes the voltage they
        take.
        """
        found = {name: each.value for name, each in self.estimates.items()}
        if "dead_time_voltage" in found:
            lost_s = max(0.0, found["dead_time_voltage"]) * (self.pwm_period_s or self.control_period_s)
            found["dead_time_compensation"] = min(lost_s / self.u_dc_V, _LONGEST_DEAD_TIME_S)
        return found

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
