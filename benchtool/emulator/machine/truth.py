"""The emulated bench as it really is: values that control never sees, and the form the kernel reads."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchtool.emulator.machine.inverter import PowerStage
from benchtool.emulator.machine.plant import Machine, machine_of
from benchtool.emulator.machine.sensors import Sensing
from benchtool.errors import ValueRefused


@dataclass(frozen=True, kw_only=True)
class MotorTruth:
    """A permanent-magnet machine, amplitude-invariant and per phase.

    `cogging_order` counts periods of the cogging torque per mechanical revolution. `psi_5_Wb` and `psi_7_Wb`
    are the fifth and seventh harmonic of the rotor flux linkage of phase a, as cosines of 5 and 7 theta_e.

    Raises:
        ValueRefused: a value is not finite, negative, or zero where the machine could not move.
    """

    pole_pairs: int
    R_s_ohm: float
    L_d_H: float
    L_q_H: float
    psi_r_Wb: float
    J_kgm2: float
    friction_Nms: float = 0.0
    coulomb_Nm: float = 0.0
    cogging_Nm: float = 0.0
    cogging_order: int = 0
    psi_5_Wb: float = 0.0
    psi_7_Wb: float = 0.0

    def __post_init__(self) -> None:
        positive(pole_pairs=self.pole_pairs, L_d_H=self.L_d_H, L_q_H=self.L_q_H, J_kgm2=self.J_kgm2)
        not_negative(
            R_s_ohm=self.R_s_ohm,
            psi_r_Wb=self.psi_r_Wb,
            friction_Nms=self.friction_Nms,
            coulomb_Nm=self.coulomb_Nm,
            cogging_Nm=self.cogging_Nm,
            cogging_order=self.cogging_order,
        )
        finite(psi_5_Wb=self.psi_5_Wb, psi_7_Wb=self.psi_7_Wb)

    def machine(self, speed_held: bool = False) -> Machine:
        """Coefficients of the differential equations."""
        return machine_of(
            float(self.pole_pairs),
            self.R_s_ohm,
            self.L_d_H,
            self.L_q_H,
            self.psi_r_Wb,
            self.psi_5_Wb,
            self.psi_7_Wb,
            self.J_kgm2,
            self.friction_Nms,
            self.coulomb_Nm,
            self.cogging_Nm,
            float(self.cogging_order),
            speed_held,
            False,
        )


@dataclass(frozen=True, kw_only=True)
class InverterTruth:
    """A two-level inverter on a dc link behind a resistance.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    u_dc_V: float
    dc_link_R_ohm: float = 0.0
    dead_time_s: float = 0.0
    device_drop_V: float = 0.0

    def __post_init__(self) -> None:
        positive(u_dc_V=self.u_dc_V)
        not_negative(
            dc_link_R_ohm=self.dc_link_R_ohm,
            dead_time_s=self.dead_time_s,
            device_drop_V=self.device_drop_V,
        )

    def power_stage(self, T_s: float) -> PowerStage:
        """Coefficients for a PWM period of `T_s` seconds."""
        return PowerStage(T_s, self.u_dc_V, self.dc_link_R_ohm, self.dead_time_s, self.device_drop_V)


@dataclass(frozen=True, kw_only=True)
class SensorTruth:
    """Current, voltage and position measurement.

    A current reads gain times the true one plus offset plus Gaussian noise, converted with `adc_bits` over
    +-`i_full_scale_A`; the dc link is converted with as many bits over 0 to `u_full_scale_V`.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    i_full_scale_A: float
    u_full_scale_V: float
    adc_bits: int = 10
    current_noise_A_rms: float = 0.0
    current_gain: tuple[float, float, float] = (1.0, 1.0, 1.0)
    current_offset_A: tuple[float, float, float] = (0.0, 0.0, 0.0)
    encoder_lines: int = 2500
    encoder_offset_rad: float = 0.0

    def __post_init__(self) -> None:
        positive(
            i_full_scale_A=self.i_full_scale_A,
            u_full_scale_V=self.u_full_scale_V,
            adc_bits=self.adc_bits,
            encoder_lines=self.encoder_lines,
        )
        not_negative(current_noise_A_rms=self.current_noise_A_rms)
        finite(encoder_offset_rad=self.encoder_offset_rad)
        for phase, gain, offset in zip("abc", self.current_gain, self.current_offset_A, strict=True):
            finite(**{f"current_gain of phase {phase}": gain, f"current_offset_A of phase {phase}": offset})

    def sensing(self) -> Sensing:
        """Coefficients of the measurement."""
        codes = 2.0**self.adc_bits
        return Sensing(
            *self.current_gain,
            *self.current_offset_A,
            2.0 * self.i_full_scale_A / codes,
            codes / 2.0,
            self.u_full_scale_V / codes,
            4 * self.encoder_lines,
            self.encoder_offset_rad,
        )


def positive(**values: float) -> None:
    """Refuse what is not a finite number above zero."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name} = {value}, a finite number above 0 is needed: correct it")


def not_negative(**values: float) -> None:
    """Refuse what is not a finite number of zero or more."""
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueRefused(f"{name} = {value}, a finite number of 0 or more is needed: correct it")


def finite(**values: float) -> None:
    """Refuse infinities and what is not a number."""
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueRefused(f"{name} = {value}, a finite number is needed: correct it")
