"""The machine once more, independently of the emulator: stator coordinates, flux linkages, co-energy.

The states are the flux linkages along alpha and beta, the speed and the angle; the torque is the derivative
of the co-energy by the angle; scipy integrates. The potential of a leg falls steeply from its highest to its
lowest over a current of `WIDTH`, so that nothing decides when a device begins or ends to conduct.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

WIDTH = 2e-4  # A
LOW, HIGH, OFF = "low", "high", "off"
PHASES = np.array([[1.0, 0.0], [-0.5, math.sqrt(0.75)], [-0.5, -math.sqrt(0.75)]])
Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """A machine on an inverter; `harmonics` maps the order of a cosine in psi_a(theta_e) to its amplitude.

    Of the phases: what factor they link the fundamental by, and resistance and inductance in series.
    """

    p: int
    R: float
    L_d: float
    L_q: float
    harmonics: dict[int, float]
    J: float
    B: float = 0.0
    T_load: float = 0.0
    u_dc: float = 100.0
    drop: float = 0.0
    held: bool = False
    psi_of_phase: tuple[float, float, float] = (1.0, 1.0, 1.0)
    series_R: tuple[float, float, float] = (0.0, 0.0, 0.0)
    series_L: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def resistance(self) -> Vector:
        R = np.diag(np.add(self.R, self.series_R))
        return np.asarray(2.0 / 3.0 * PHASES.T @ R @ PHASES, np.float64)

    def inductance(self, theta: float) -> Vector:
        mean, half = 0.5 * (self.L_d + self.L_q), 0.5 * (self.L_d - self.L_q)
        c, s = math.cos(2.0 * theta), math.sin(2.0 * theta)
        rotor = np.array([[mean + half * c, half * s], [half * s, mean - half * c]])
        return np.asarray(rotor + 2.0 / 3.0 * PHASES.T @ np.diag(self.series_L) @ PHASES, np.float64)

    def rotor_flux(self, theta: float) -> Vector:
        phases = [theta - 2.0 * math.pi * k / 3.0 for k in range(3)]
        psi = np.array(
            [
                sum((factor if n == 1 else 1.0) * a * math.cos(n * at) for n, a in self.harmonics.items())
                for factor, at in zip(self.psi_of_phase, phases, strict=True)
            ]
        )
        return np.asarray(2.0 / 3.0 * PHASES.T @ psi, np.float64)

    def current(self, y: Vector) -> Vector:
        return np.asarray(np.linalg.solve(self.inductance(y[3]), y[:2] - self.rotor_flux(y[3])), np.float64)

    def state(self, i_d: float, i_q: float, omega_m: float, theta: float) -> Vector:
        c, s = math.cos(theta), math.sin(theta)
        i = np.array([i_d * c - i_q * s, i_d * s + i_q * c])
        return np.array([*(self.inductance(theta) @ i + self.rotor_flux(theta)), omega_m, theta])

    def dq(self, y: Vector) -> tuple[float, float]:
        i, c, s = self.current(y), math.cos(y[3]), math.sin(y[3])
        return i[0] * c + i[1] * s, i[1] * c - i[0] * s

    def torque(self, i: Vector, theta: float) -> float:
        h = 1e-5

        def coenergy(at: float) -> float:
            return 1.5 * float(0.5 * i @ self.inductance(at) @ i + i @ self.rotor_flux(at))

        far = coenergy(theta + 2 * h) - coenergy(theta - 2 * h)
        return self.p * (8.0 * (coenergy(theta + h) - coenergy(theta - h)) - far) / (12.0 * h)

    def potential(self, mode: str, i: float) -> float:
        low, high = {LOW: (0.0, 0.0), HIGH: (self.u_dc, self.u_dc), OFF: (0.0, self.u_dc)}[mode]
        low, high = low - self.drop, high + self.drop
        return min(max(0.5 * (low + high) - 0.5 * (high - low) * i / WIDTH, low), high)

    def run(self, y: Vector, span: tuple[float, float], modes: Sequence[str]) -> Vector:
        """The state after a span in which each leg stays in its mode."""

        resistance = self.resistance()

        def rates(_: float, y: Vector) -> list[float]:
            i = self.current(y)
            v = np.array([self.potential(mode, ik) for mode, ik in zip(modes, PHASES @ i, strict=True)])
            u = 2.0 / 3.0 * PHASES.T @ v
            torque = self.torque(i, y[3]) - self.B * y[2] - self.T_load
            return [*(u - resistance @ i), 0.0 if self.held else torque / self.J, self.p * y[2]]

        if span[1] <= span[0]:
            return y
        done = solve_ivp(rates, span, y, "LSODA", rtol=1e-9, atol=1e-11)
        end: Vector = done.y[:, -1]
        return end

    def follow(self, y: Vector, legs: Sequence[Sequence[tuple[float, str]]], end: float) -> Vector:
        """The state at the end of what the legs go through, each the times from which it is in a mode."""
        edges = sorted({0.0, end, *(at for leg in legs for at, _ in leg if 0.0 < at < end)})
        for start, stop in pairwise(edges):
            middle = 0.5 * (start + stop)
            y = self.run(y, (start, stop), [[mode for at, mode in leg if at <= middle][-1] for leg in legs])
        return y


def centred(duties: Sequence[float], T_s: float) -> list[tuple[float, bool]]:
    """What a leg is told in consecutive PWM periods of these duties."""
    commands: list[tuple[float, bool]] = []
    for k, duty in enumerate(duties):
        if duty >= 1.0:
            commands.append((k * T_s, True))
            continue
        commands.append((k * T_s, False))
        if duty > 0.0:
            commands += [((k + 0.5 - duty / 2) * T_s, True), ((k + 0.5 + duty / 2) * T_s, False)]
    return commands


def in_halves(duties: Sequence[float], T_s: float) -> list[tuple[float, bool]]:
    """The same of consecutive half periods: at the end of the first one high, from there on in the second."""
    commands: list[tuple[float, bool]] = []
    for k, duty in enumerate(duties):
        second = k % 2 == 1
        commands.append((k * T_s, duty >= 1.0 or (second and duty > 0.0)))
        if 0.0 < duty < 1.0:
            commands.append(((k + (duty if second else 1.0 - duty)) * T_s, not second))
    return commands


def gates(commands: Sequence[tuple[float, bool]], end: float, dead_time: float) -> list[tuple[float, str]]:
    """Times from which one leg is in a mode, by what it is told until the end.

    What does not change is left out; each change is followed by a dead time.
    """
    modes = [(-1.0, LOW)]
    state, waits_until = False, -1.0
    for at, command in [*commands, (end + 1.0, not commands[-1][1])]:
        if command == state:
            continue
        if 0.0 <= waits_until <= at:
            modes.append((waits_until, HIGH if state else LOW))
        state = command
        if dead_time > 0.0:
            modes.append((at, OFF))
            waits_until = at + dead_time
        else:
            modes.append((at, HIGH if command else LOW))
    return modes
