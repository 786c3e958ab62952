"""What is beyond the rotor of the emulated machine, as a profile states it: shaft, load, flange."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from benchtool.document import Array, Section

Torque = Annotated[float, Field(ge=-1e5, le=1e5)]
Torques = Annotated[Array[Torque], Field(max_length=4096)]


class Shaft(Section):
    """What the rotor of the emulated machine turns: the inertia of the load, rigid or by a coupling."""

    J_load_kgm2: Annotated[float, Field(ge=0, le=1e4)] = 0.0
    """Moment of inertia of the load, beyond the flange."""
    coupling_Nm_rad: Annotated[float, Field(ge=0, le=1e9)] = 0.0
    """Torsional stiffness of an elastic coupling; 0: rigid."""
    coupling_Nms: Annotated[float, Field(ge=0, le=1e4)] = 0.0
    """Damping of the coupling: torque per difference of the speeds."""
    backlash_rad: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Whole angle by which the coupling turns freely."""
    unbalance_kgm: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Unbalance of the load on a horizontal shaft, mass times radius; it hangs down at angle 0."""


class DrivenLoad(Section):
    """The machine that is driven on the emulated bench; its torques add to what a plan has the load machine
    make."""

    linear_Nms: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Torque in proportion to the speed, of a generator or an eddy-current brake."""
    quadratic_Nms2: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Torque in proportion to the square of the speed, of a fan or a centrifugal pump."""
    over_angle_Nm: Torques = ()
    """Torques at even angles of a revolution of the load, the first at angle 0, linear in between."""
    over_time_Nm: Torques = ()
    """Torques at even times of a cycle that begins with power-up, linear in between."""
    over_time_s: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Duration of the cycle of `over_time_Nm`."""

    def mean_torque_Nm(self, omega_m_rad_s: float) -> float:
        """Return the mean torque of whole revolutions and whole cycles at this speed."""
        by_speed = (self.linear_Nms + self.quadratic_Nms2 * abs(omega_m_rad_s)) * omega_m_rad_s
        return by_speed + _mean(self.over_angle_Nm) + _mean(self.over_time_Nm)


class EmulatedLoadMachine(Section):
    """A load machine of the emulated bench that gives way; without this table it is ideal."""

    bandwidth_Hz: Annotated[float, Field(ge=1e-3, le=1e5)]
    """Where its torque, a lag of first order, has lost 3 dB."""
    stiffness_Nms: Annotated[float, Field(ge=1e-9, le=1e6)]
    """Torque by which it holds a speed, per rad/s that this is off."""
    torque_limit_Nm: Annotated[float, Field(gt=0, le=1e6)] = 1e6
    """The torque that it has."""


class FlangeTransducer(Section):
    """A torque transducer at the flange between the emulated machine and its load.

    With this table it is what `[bench.transducer]` records, and the air-gap torque a channel beside it.
    """

    gain: Annotated[float, Field(ge=-10, le=10)] = 1.0
    """Its gain; 1 without error."""
    offset_Nm: Torque = 0.0
    """Its offset."""
    noise_Nm_rms: Annotated[float, Field(ge=0, le=1e5)] = 0.0
    """Noise of a sample, rms."""
    bandwidth_Hz: Annotated[float, Field(ge=1e-3, le=1e7)] = 1000.0
    """Where it, a lag of first order, has lost 3 dB."""


def _mean(values: tuple[float, ...]) -> float:
    return sum(values) / len(values) if values else 0.0
