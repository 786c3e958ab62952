"""A motor from what its nameplate or data sheet states, each value in the convention that it is stated in.

The conventions cost a factor when they are mixed up: between two terminals or per phase (2), peak or rms
(sqrt 2), line to line or phase voltage (sqrt 3). None is assumed: every value comes with its own.
Inside, everything is per phase and amplitude-invariant (peak), so that T = 3/2 p psi_r i_q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from benchtool.errors import ProfileError
from benchtool.profile.motor import Motor

VOLTAGE_SHARE: Final = 0.9
"""Of u_dc / sqrt 3, the largest mean voltage in every direction (Holtz, Proc. IEEE 82 (1994) no. 8), what the
rated point takes where the nameplate states no speed; the rest is for control."""

_NEAR = 1.25  # factor within which two statements of one quantity agree


class Winding(StrEnum):
    """Between what a resistance or an inductance was measured, of a star or of its equivalent."""

    PHASE = "phase"
    LINE_TO_LINE = "ll"

    @property
    def per_phase(self) -> float:
        """What a stated value is multiplied by to be that of one phase."""
        return 0.5 if self is Winding.LINE_TO_LINE else 1.0


class Amplitude(StrEnum):
    """Of an alternating current."""

    PEAK = "peak"
    RMS = "rms"

    @property
    def peaks(self) -> float:
        """What a stated value is multiplied by to be a peak value."""
        return math.sqrt(2.0) if self is Amplitude.RMS else 1.0


class Voltage(StrEnum):
    """Which voltage a constant of a motor refers to, at no load."""

    LINE_PEAK = "ll-peak"
    LINE_RMS = "ll-rms"
    PHASE_PEAK = "phase-peak"
    PHASE_RMS = "phase-rms"

    @property
    def phase_peaks(self) -> float:
        """What a stated voltage is multiplied by to be the peak value of a phase."""
        between, _, amplitude = self.value.partition("-")
        return Amplitude(amplitude).peaks / (math.sqrt(3.0) if between == "ll" else 1.0)


def flux_of_ke(Ke_Vs_rad: float, voltage: Voltage, pole_pairs: int) -> float:
    """Return the psi_r in Wb peak of a back-EMF constant per mechanical rad/s: e = p omega_m psi_r."""
    return Ke_Vs_rad * voltage.phase_peaks / pole_pairs


def flux_of_kv(Kv_rad_Vs: float, voltage: Voltage, pole_pairs: int) -> float:
    """Return the psi_r in Wb peak of a speed constant, mechanical rad/s per volt: the inverse of the
    back-EMF's."""
    return flux_of_ke(1.0 / Kv_rad_Vs, voltage, pole_pairs)


def flux_of_kt(Kt_Nm_A: float, current: Amplitude, pole_pairs: int) -> float:
    """Return the psi_r in Wb peak of a torque constant per A of phase current: T = 3/2 p psi_r i_q."""
    return Kt_Nm_A / current.peaks / (1.5 * pole_pairs)


@dataclass(frozen=True, kw_only=True)
class Nameplate:
    """What is known of a motor, per phase and peak; torque and speed may be left to be derived."""

    pole_pairs: int
    R_s_ohm: float
    L_d_H: float
    L_q_H: float
    psi_r_Wb: float
    J_kgm2: float
    u_dc_V: float
    I_N_A: float
    T_N_Nm: float | None = None
    omega_m_N_rad_s: float | None = None

    def motor(self) -> Motor:
        """Return motor, its rated torque and speed by `most_torque` and `rated_speed` where none is stated.

        Raises:
            ProfileError: the dc link does not suffice for the rated current at any speed.
        """
        given = {
            key: getattr(self, key)
            for key in ("pole_pairs", "R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2")
        }
        return Motor(
            **given,
            T_N_Nm=self.most_torque if self.T_N_Nm is None else self.T_N_Nm,
            omega_m_N_rad_s=self.rated_speed if self.omega_m_N_rad_s is None else self.omega_m_N_rad_s,
            I_N_A_rms=self.I_N_A / math.sqrt(2.0),
        )

    def contradictions(self) -> list[str]:
        """Return what the stated torque and speed contradict: signs of a convention that was mixed up."""
        found = []
        if self.T_N_Nm is not None and not 1.0 / _NEAR < self.T_N_Nm / self.most_torque < _NEAR:
            found.append(
                f"the rated current makes {self.most_torque:.3g} Nm with this flux, and the rated torque is "
                f"{self.T_N_Nm:.3g} Nm: check whether the current is rms or peak, and of what the constant is"
            )
        if self.omega_m_N_rad_s is not None and self.omega_m_N_rad_s > _NEAR * self.rated_speed:
            found.append(
                f"the dc link allows {self.rated_speed:.4g} rad/s at the rated current, and the rated speed "
                f"is {self.omega_m_N_rad_s:.4g} rad/s: check of what voltage the constant is, and the dc link"
            )
        return found

    @property
    def _currents(self) -> tuple[float, float]:
        """(i_d, i_q) of the rated current that make the most torque (maximum torque per ampere; Morimoto et
        al., IEEE Trans. Ind. Appl. 26 (1990) no. 5)."""
        saliency = self.L_q_H - self.L_d_H
        root = math.sqrt(self.psi_r_Wb**2 + 8.0 * (saliency * self.I_N_A) ** 2)
        i_d = -2.0 * saliency * self.I_N_A**2 / (self.psi_r_Wb + root)
        return i_d, math.sqrt(self.I_N_A**2 - i_d**2)

    @property
    def most_torque(self) -> float:
        """Torque of the rated current in Nm: T = 3/2 p (psi_r - (L_q - L_d) i_d) i_q."""
        i_d, i_q = self._currents
        return 1.5 * self.pole_pairs * (self.psi_r_Wb - (self.L_q_H - self.L_d_H) * i_d) * i_q

    @property
    def rated_speed(self) -> float:
        """Mechanical speed in rad/s at which the rated current takes `VOLTAGE_SHARE` of the voltage:

            (R_s i_d - omega_e L_q i_q)^2 + (R_s i_q + omega_e (psi_r + L_d i_d))^2 = u^2

        Raises:
            ProfileError: the voltage does not suffice at standstill.
        """
        i_d, i_q = self._currents
        u = VOLTAGE_SHARE * self.u_dc_V / math.sqrt(3.0)
        psi_d, psi_q = self.psi_r_Wb + self.L_d_H * i_d, self.L_q_H * i_q
        a = psi_d**2 + psi_q**2
        b = self.R_s_ohm * (i_q * psi_d - i_d * psi_q)
        c = (self.R_s_ohm * self.I_N_A) ** 2 - u**2
        if c >= 0.0:
            raise ProfileError(
                f"the rated current of {self.I_N_A:.4g} A peak takes {self.R_s_ohm * self.I_N_A:.4g} V per "
                f"phase at standstill, a dc link of {self.u_dc_V:g} V leaves {u:.4g} V: check R_s (phase or "
                f"ll), the rated current (rms or peak) and u_dc"
            )
        return (math.sqrt(b * b - a * c) - b) / a / self.pole_pairs
