"""What dead time and devices take from the voltage within one PWM period.

A leg that goes high or low waits for the dead time, in which the current holds it: out of the leg (i > 0) it
goes high late, into the leg it goes low late. A rising edge at i > 0 takes T_d u_dc from the leg's
volt-seconds, a falling edge at i < 0 gives as much. In a period with both edges that is T_d u_dc times the
mean of the signs of the current at the two, and what a device takes has nearly the same sign (J. Holtz, Proc.
IEEE 82 (1994) 1194). Where a current is close to zero at an edge it may be held at
zero, and its sign is not told: the balance of such a period is left out.

The modulation is taken to be centred with equal zero vectors (SVPWM), sampled at the ends of its periods.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.balances.space_vectors import Complex, Floats, phase_values, space_vector
from benchtool.analysis.validity import require_dc_link

_ALMOST = 1e-5  # of a period


@dataclass(frozen=True)
class _Edge:
    """An edge that each leg may have in each period, all of shape (3, n): when it comes, and by how many
    volt-seconds the phase has had more than its mean until then. `sign` is 1 for a rising one."""

    sign: int
    present: NDArray[np.bool_]
    at_s: Floats
    ripple_Vs: Floats

    def delayed(self, current: Floats) -> Floats:
        """Return the sign of the edge where dead time delays it: where the current of its leg, shape (3, n),
        holds that until the other switch turns on."""
        return np.asarray(self.sign * (self.present & (self.sign * current > 0.0)), dtype=np.float64)


@dataclass(frozen=True)
class Edges:
    """The edges of the legs in periods of `T_s`, by the voltage asked for.

    `pulse_s`, shape (n,), is the shortest time for which a leg that switches stays high or low, `unknown`,
    shape (n,), says in which periods the edges are not known.
    """

    T_s: float
    edges: tuple[_Edge, ...]
    pulse_s: Floats
    unknown: NDArray[np.bool_]

    @classmethod
    def of(cls, u_s: Complex, u_dc: Floats, T_s: float) -> Edges:
        """Return the edges of a voltage, shape (n,), on a dc link, shape (n,).

        A leg that is high, or low, for a whole period changes where two periods meet. Without voltage it is
        unknown whether the legs are all high, all low, switching or off.

        Raises:
            AnalysisError: the dc link is not above zero.
        """
        require_dc_link(u_dc)
        phases = phase_values(u_s)
        centre = 0.5 * (np.max(phases, axis=0) + np.min(phases, axis=0))
        duty = np.clip(0.5 + (phases - centre) / u_dc, 0.0, 1.0)
        high, low = duty > 1.0 - _ALMOST, duty < _ALMOST
        was_high = np.roll(high, 1, axis=1)
        rise_s, fall_s = 0.5 * (1.0 - duty) * T_s, 0.5 * (1.0 + duty) * T_s
        switches, start_s = ~(high | low), np.zeros_like(duty)
        edges = (
            _Edge(1, switches, rise_s, _ripple(rise_s, rise_s, duty, u_dc, T_s)),
            _Edge(-1, switches, fall_s, _ripple(fall_s, rise_s, duty, u_dc, T_s)),
            _Edge(1, high & ~was_high, start_s, start_s),
            _Edge(-1, ~high & was_high, start_s, start_s),
        )
        pulse_s = T_s * np.min(np.where(switches, np.minimum(duty, 1.0 - duty), 1.0), axis=0)
        off = u_s == 0.0
        after_off = np.roll(off, 1)
        after_off[:1] = True
        return cls(T_s, edges, pulse_s, off | (after_off & np.any(high, axis=0)))

    def signs(
        self, i_s: Complex, L: float, least: float, shortest_s: float
    ) -> tuple[Complex, NDArray[np.bool_]]:
        """Return the vector of the mean signs of the phase currents, and where one of them is not told.

        Args:
            i_s: current at the ends of the periods, shape (n + 1,).
            L: inductance by which the ripple within a period is computed.
            least: current at an edge below which its sign is not told.
            shortest_s: a shorter pulse may be lost in the dead time, and is not told either.
        """
        total, unsure = np.zeros((3, len(self.unknown))), self.unknown | (self.pulse_s < shortest_s)
        for edge, current in zip(self.edges, self._currents(i_s, L), strict=True):
            total += edge.delayed(current)
            unsure |= np.any(edge.present & (np.abs(current) < least), axis=0)
        return space_vector(total), unsure

    def before_middle(self, i_s: Complex, L: float) -> Complex:
        """Return the vector of the signs as `signs` has them, each times the share of the period by which its
        edge is before the middle: what comes there is in the mean of a period more than at its ends."""
        total = np.zeros((3, len(self.unknown)))
        for edge, current in zip(self.edges, self._currents(i_s, L), strict=True):
            total += edge.delayed(current) * (0.5 - edge.at_s / self.T_s)
        return space_vector(total)

    def _currents(self, i_s: Complex, L: float) -> Iterator[Floats]:
        """Yield the current of each leg at each edge, shape (3, n)."""
        phases = phase_values(i_s)
        begin, end = phases[:, :-1], phases[:, 1:]
        for edge in self.edges:
            yield begin + (end - begin) * (edge.at_s / self.T_s) + edge.ripple_Vs / L


def _ripple(at_s: Floats, rise_s: Floats, duty: Floats, u_dc: Floats, T_s: float) -> Floats:
    """Return the volt-seconds of each phase beyond those of its mean voltage, at a time of its own."""
    legs = [u_dc * (np.clip(at_s - rise_s[leg], 0.0, duty[leg] * T_s) - duty[leg] * at_s) for leg in range(3)]
    own = np.stack([legs[phase][phase] for phase in range(3)])
    return np.asarray(own - (legs[0] + legs[1] + legs[2]) / 3.0)
