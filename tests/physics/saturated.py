"""A machine that saturates, in stator coordinates: all of it follows from the energy of its field.

Currents are the slopes of the energy by the complex step, the torque is the numerical derivative of the
co-energy, the Legendre transform of the energy, by the angle at constant current.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.physics.alpha_beta import PHASES, Reference, Vector

_H = 1e-30


def turn(theta: float) -> Vector:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s], [s, c]])


@dataclass(frozen=True)
class Saturated(Reference):
    """`energy` of the flux linkages (psi_d, psi_q), for complex numbers; the first harmonic is in it."""

    energy: Callable[[complex, complex], complex] = lambda d, q: d + q

    def gradient(self, psi: Vector) -> Vector:
        return np.array(
            [
                self.energy(psi[0] + 1j * _H, psi[1]).imag / _H,
                self.energy(psi[0], psi[1] + 1j * _H).imag / _H,
            ]
        )

    def _hessian(self, psi: Vector) -> Vector:
        h = 1e-6
        ends = [(psi + h * axis, psi - h * axis) for axis in np.eye(2)]
        return np.array([(self.gradient(a) - self.gradient(b)) / (2 * h) for a, b in ends]).T

    def flux(self, i: Vector) -> Vector:
        """The flux linkages in d/q of these currents."""
        psi = np.array([self.harmonics[1], 0.0])
        for _ in range(50):
            off = i - self.gradient(psi)
            if np.abs(off).max() < 1e-12 * (1.0 + np.abs(i).max()):
                break
            psi = psi + np.linalg.solve(self._hessian(psi), off)
        return psi

    def others(self, theta: float) -> Vector:
        """The rotor flux that is not in the energy: harmonics and unbalance."""
        mean = sum(self.psi_of_phase) / 3.0 * self.harmonics[1]
        return self.rotor_flux(theta) - mean * np.array([math.cos(theta), math.sin(theta)])

    def leakage(self) -> Vector:
        return np.asarray(2.0 / 3.0 * PHASES.T @ np.diag(self.series_L) @ PHASES, np.float64)

    def current(self, y: Vector) -> Vector:
        to_stator, leakage = turn(y[3]), self.leakage()
        total = y[:2] - self.others(y[3])
        psi = to_stator.T @ total
        for _ in range(50):
            i = to_stator @ self.gradient(psi)
            off = to_stator.T @ (total - leakage @ i) - psi
            if np.abs(off).max() < 1e-15:
                break
            slope = np.eye(2) + to_stator.T @ leakage @ to_stator @ self._hessian(psi)
            psi = psi + np.linalg.solve(slope, off)
        return np.asarray(to_stator @ self.gradient(psi), np.float64)

    def state(self, i_d: float, i_q: float, omega_m: float, theta: float) -> Vector:
        i = turn(theta) @ np.array([i_d, i_q])
        linked = turn(theta) @ self.flux(np.array([i_d, i_q])) + self.others(theta) + self.leakage() @ i
        return np.array([*linked, omega_m, theta])

    def torque(self, i: Vector, theta: float) -> float:
        h = 1e-3

        def coenergy(at: float) -> float:
            i_dq = turn(at).T @ i
            psi = self.flux(i_dq)
            return 1.5 * float(i_dq @ psi - self.energy(*psi).real + i @ self.others(at))

        far = coenergy(theta + 2 * h) - coenergy(theta - 2 * h)
        return self.p * (8.0 * (coenergy(theta + h) - coenergy(theta - h)) - far) / (12.0 * h)
