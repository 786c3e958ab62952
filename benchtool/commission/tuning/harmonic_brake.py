"""What harmonics of the EMF brake: the currents that they drive through the current loop.

A harmonic of the rotor flux is seen from the rotor as an EMF that turns, against which the loop holds the
current only as far as its bandwidth goes. The power that this EMF takes in is mechanical.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from benchtool.commission.tuning.loops import CurrentLoop

_APART: Final = 0.02  # of a speed, over which the torque's slope is taken


@dataclass(frozen=True)
class HarmonicBrake:
    """A rotor with harmonics of its flux, complex Wb by their order in stator coordinates, on a current loop.

    `loops` are those of i_d and i_q with their inductances in H; a current that turns past both sees their
    mean admittance.
    """

    pole_pairs: int
    harmonics_Wb: Mapping[int, complex]
    loops: Sequence[tuple[CurrentLoop, float]]

    def torque_Nm(self, omega_m_rad_s: float) -> float:
        """Return the mean torque by which it brakes at a speed."""
        taken_W = sum(1.5 * (e_V.conjugate() * i_A).real for e_V, i_A in self._emf_and_current(omega_m_rad_s))
        return taken_W / omega_m_rad_s if omega_m_rad_s else 0.0

    def damping_Nms(self, omega_m_rad_s: float) -> float:
        """Return by how much that torque grows with the speed."""
        apart = _APART * omega_m_rad_s
        ends = [self.torque_Nm(omega_m_rad_s + sign * apart) for sign in (-1.0, 1.0)]
        return (ends[1] - ends[0]) / (2.0 * apart) if apart else 0.0

    def current_squared_A2(self, omega_m_rad_s: float) -> float:
        """Return the mean square of the length of the current vector that they drive."""
        return sum(abs(i_A) ** 2 for _, i_A in self._emf_and_current(omega_m_rad_s))

    def _emf_and_current(self, omega_m_rad_s: float) -> list[tuple[complex, complex]]:
        """Return EMF and current of each harmonic, as vectors at rest in its own turning frame."""
        omega_e = self.pole_pairs * omega_m_rad_s
        found = []
        for order, psi_Wb in self.harmonics_Wb.items():
            e_V = 1j * order * omega_e * psi_Wb
            admittance = [loop.admittance((order - 1) * omega_e, L_H) for loop, L_H in self.loops]
            found.append((e_V, e_V * sum(admittance) / len(admittance)))
        return found
