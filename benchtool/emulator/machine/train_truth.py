"""True values beyond the rotor, of shaft, load, load machine and flange, and their form for the kernel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchtool.emulator.machine.coupling import Coupling, Play
from benchtool.emulator.machine.drive_train import DriveTrain, Flange
from benchtool.emulator.machine.load import Curve, LoadMachine, OverAngle, OverTime, Unbalance
from benchtool.emulator.machine.transducer import FlangeError
from benchtool.emulator.machine.truth import finite, not_negative, positive
from benchtool.errors import ValueRefused

STANDARD_GRAVITY: Final = 9.80665  # m/s2, ISO 80000-3


@dataclass(frozen=True, kw_only=True)
class ShaftTruth:
    """What the rotor turns: the inertia of the load, by an elastic coupling if that has a stiffness.

    `backlash_rad` is the whole angle by which the coupling turns freely. `unbalance_kgm`, mass times radius
    of the load on a horizontal shaft, hangs down at angle 0.

    Raises:
        ValueRefused: a value is not finite or negative, or a coupling has nothing to drive.
    """

    J_load_kgm2: float = 0.0
    coupling_Nm_rad: float = 0.0
    coupling_Nms: float = 0.0
    backlash_rad: float = 0.0
    unbalance_kgm: float = 0.0

    def __post_init__(self) -> None:
        not_negative(**vars(self))
        if self.coupling_Nm_rad > 0.0 and self.J_load_kgm2 == 0.0:
            raise ValueRefused(
                f"shaft.coupling_Nm_rad = {self.coupling_Nm_rad:g} without shaft.J_load_kgm2: an elastic "
                f"coupling needs an inertia to drive, state it"
            )
        if self.coupling_Nm_rad == 0.0 and (self.backlash_rad > 0.0 or self.coupling_Nms > 0.0):
            raise ValueRefused(
                "shaft.backlash_rad or shaft.coupling_Nms without shaft.coupling_Nm_rad: state the stiffness"
            )

    def coupling(self) -> Coupling | None:
        """Return the elastic coupling; None where the load is rigid on the rotor."""
        if self.coupling_Nm_rad == 0.0:
            return None
        play = Play(0.5 * self.backlash_rad) if self.backlash_rad > 0.0 else None
        return Coupling(self.coupling_Nm_rad, self.coupling_Nms, 1.0 / self.J_load_kgm2, play)

    def unbalance(self) -> Unbalance | None:
        """Return the torque of the unbalance's weight."""
        return Unbalance(STANDARD_GRAVITY * self.unbalance_kgm) if self.unbalance_kgm > 0.0 else None


@dataclass(frozen=True, kw_only=True)
class LoadTruth:
    """Torques of the driven machine, against positive rotation, which add up with that of the load machine.

    `over_angle_Nm` are at even angles of a revolution of the load, the first at angle 0, and `over_time_Nm`
    at even times of a cycle of `over_time_s`, which begins when the bench is powered up; between them torques
    are linear, and the first follows the last.

    Raises:
        ValueRefused: a value is not finite, a slope negative, or a cycle has no duration.
    """

    linear_Nms: float = 0.0
    quadratic_Nms2: float = 0.0
    over_angle_Nm: tuple[float, ...] = ()
    over_time_Nm: tuple[float, ...] = ()
    over_time_s: float = 0.0

    def __post_init__(self) -> None:
        not_negative(
            linear_Nms=self.linear_Nms, quadratic_Nms2=self.quadratic_Nms2, over_time_s=self.over_time_s
        )
        for torque in self.over_angle_Nm:
            finite(over_angle_Nm=torque)
        for torque in self.over_time_Nm:
            finite(over_time_Nm=torque)
        if bool(self.over_time_Nm) != (self.over_time_s > 0.0):
            raise ValueRefused(
                f"load.over_time_Nm of {len(self.over_time_Nm)} torques in load.over_time_s = "
                f"{self.over_time_s:g}: state both, torques and the duration of their cycle"
            )

    def curve(self) -> Curve | None:
        """Return the torque by speed."""
        if self.linear_Nms == 0.0 and self.quadratic_Nms2 == 0.0:
            return None
        return Curve(self.linear_Nms, self.quadratic_Nms2)

    def over_angle(self) -> OverAngle | None:
        """Return the torques by angle."""
        if not any(self.over_angle_Nm):
            return None
        torques = np.array(self.over_angle_Nm)
        steps = np.abs(np.diff(torques, append=torques[:1]))
        slope = float(steps.max()) * len(torques) / (2.0 * math.pi)
        return OverAngle(torques, float(np.abs(torques).max()), slope)

    def over_time(self) -> OverTime | None:
        """Return the torques by time."""
        if not any(self.over_time_Nm):
            return None
        return OverTime(np.array(self.over_time_Nm), 1.0 / self.over_time_s)


@dataclass(frozen=True, kw_only=True)
class LoadMachineTruth:
    """A load machine that is not ideal: its torque lags by a first order of `bandwidth_Hz`, and it holds a
    speed by `stiffness_Nms` times what that is off, both up to `torque_limit_Nm`.

    Raises:
        ValueRefused: a value is not above zero.
    """

    bandwidth_Hz: float
    stiffness_Nms: float
    torque_limit_Nm: float = math.inf

    def __post_init__(self) -> None:
        positive(bandwidth_Hz=self.bandwidth_Hz, stiffness_Nms=self.stiffness_Nms)
        if not self.torque_limit_Nm > 0.0:
            raise ValueRefused(
                f"torque_limit_Nm = {self.torque_limit_Nm}, a number above 0 is needed: correct it"
            )

    def machine(self) -> LoadMachine:
        """Return its coefficients, holding nothing."""
        return LoadMachine(
            2.0 * math.pi * self.bandwidth_Hz, self.stiffness_Nms, self.torque_limit_Nm, False, 0.0
        )


@dataclass(frozen=True, kw_only=True)
class FlangeTruth:
    """A torque transducer at the flange: a lag of first order, then gain, offset and noise.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    gain: float = 1.0
    offset_Nm: float = 0.0
    noise_Nm_rms: float = 0.0
    bandwidth_Hz: float = 1000.0

    def __post_init__(self) -> None:
        finite(gain=self.gain, offset_Nm=self.offset_Nm)
        not_negative(noise_Nm_rms=self.noise_Nm_rms)
        positive(bandwidth_Hz=self.bandwidth_Hz)

    def error(self, seed: int) -> FlangeError:
        """Return what it adds to a torque."""
        return FlangeError(self.gain, self.offset_Nm, self.noise_Nm_rms, seed)


@dataclass(frozen=True, kw_only=True)
class TrainTruth:
    """Everything beyond the rotor; by default an ideal load machine on the rotor itself."""

    shaft: ShaftTruth = ShaftTruth()
    load: LoadTruth = LoadTruth()
    load_machine: LoadMachineTruth | None = None
    flange: FlangeTruth | None = None

    @property
    def rigid_kgm2(self) -> float:
        """Inertia that turns as the rotor does."""
        return 0.0 if self.shaft.coupling_Nm_rad > 0.0 else self.shaft.J_load_kgm2

    def train(self, pole_pairs: int) -> DriveTrain | None:
        """Return what the kernel knows of it; None where there is nothing but rigid inertia."""
        parts = (
            self.shaft.coupling(),
            self.load.curve(),
            self.load.over_angle(),
            self.load.over_time(),
            self.shaft.unbalance(),
            self.load_machine.machine() if self.load_machine is not None else None,
            Flange(2.0 * math.pi * self.flange.bandwidth_Hz) if self.flange is not None else None,
        )
        if all(part is None for part in parts):
            return None
        return DriveTrain(1.0 / pole_pairs, *parts)

    def processes(self, J_kgm2: float) -> Iterator[tuple[str, float]]:
        """Yield the processes of it on this rotor, by their keys, and their rates in 1/s."""
        shaft, load = self.shaft, self.load
        inertia = f"shaft.J_load_kgm2 = {shaft.J_load_kgm2:g} and motor.J_kgm2 = {J_kgm2:g}"
        J = J_kgm2 + self.rigid_kgm2
        inv_J = 1.0 / J if self.shaft.coupling_Nm_rad == 0.0 else 1.0 / shaft.J_load_kgm2
        if shaft.coupling_Nm_rad > 0.0:
            both = 1.0 / J_kgm2 + inv_J
            yield (
                f"shaft.coupling_Nm_rad = {shaft.coupling_Nm_rad:g} on {inertia}",
                math.sqrt(shaft.coupling_Nm_rad * both),
            )
            yield f"shaft.coupling_Nms = {shaft.coupling_Nms:g} on {inertia}", shaft.coupling_Nms * both
        yield f"load.linear_Nms = {load.linear_Nms:g} on {inertia}", load.linear_Nms * inv_J
        if (table := load.over_angle()) is not None:
            yield (
                f"load.over_angle_Nm, {table.slope:g} Nm/rad at its steepest, on {inertia}",
                math.sqrt(table.slope * inv_J),
            )
        if (unbalance := shaft.unbalance()) is not None:
            yield (
                f"shaft.unbalance_kgm = {shaft.unbalance_kgm:g} on {inertia}",
                math.sqrt(unbalance.torque * inv_J),
            )
        if self.load_machine is not None:
            machine = self.load_machine.machine()
            yield f"load_machine.bandwidth_Hz = {self.load_machine.bandwidth_Hz:g}", machine.omega_c
            yield (
                f"load_machine.stiffness_Nms = {machine.stiffness:g} with load_machine.bandwidth_Hz = "
                f"{self.load_machine.bandwidth_Hz:g} on {inertia}",
                math.sqrt(machine.stiffness * machine.omega_c * inv_J),
            )


NOTHING: Final = TrainTruth()
"""An ideal load machine on the rotor itself."""
