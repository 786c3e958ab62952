"""Saturation and cross-coupling, an optional part of the machine: its states are flux linkages.

The currents are the slopes of one function of the flux linkages, the energy of the field, so that the map
between them is reciprocal by construction (Hinkkanen et al., "Sensorless self-commissioning of synchronous
reluctance motors at standstill without rotor locking", IEEE Trans. Ind. Appl. 53(3), 2017, eqs. 6 and 7, with
a constant magnetomotive force of the magnets, i_f):

    i_d = (a_d0 + a_dd |psi_d|^S + a_dq / (V + 2) |psi_d|^U |psi_q|^(V + 2)) psi_d - i_f
    i_q = (a_q0 + a_qq |psi_q|^T + a_dq / (U + 2) |psi_d|^(U + 2) |psi_q|^V) psi_q

`psi_d` has the flux of the magnets within; without current it is psi_r.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.asymmetry import Symmetric
from benchtool.errors import ValueRefused

_ITERATIONS = 100


class Flux(NamedTuple):
    """Flux linkages in Wb, a machine's states beside its currents where it saturates."""

    psi_d: float
    psi_q: float


class Saturation(NamedTuple):
    """Coefficients of the equations above, in A and Wb."""

    a_d0: float
    a_dd: float
    a_q0: float
    a_qq: float
    a_dq: float
    S: int
    T: int
    U: int
    V: int
    i_f: float


@njit
def currents_of(saturation: Saturation | None, y_d: float, y_q: float) -> tuple[float, float]:
    """Return the currents of these states: of flux linkages, or the states themselves without saturation."""
    return (y_d, y_q) if saturation is None else _of_flux(saturation, y_d, y_q)


@called
def _of_flux(saturation: Saturation, psi_d: float, psi_q: float) -> tuple[float, float]:
    s = saturation
    d, q = abs(psi_d), abs(psi_q)
    cross = s.a_dq * _power(d, s.U) * _power(q, s.V)
    per_d = s.a_d0 + s.a_dd * _power(d, s.S) + cross * q * q / (s.V + 2)
    per_q = s.a_q0 + s.a_qq * _power(q, s.T) + cross * d * d / (s.U + 2)
    return per_d * psi_d - s.i_f, per_q * psi_q


@called
def incremental(saturation: Saturation, psi_d: float, psi_q: float) -> Symmetric:
    """Return by what the currents change with the flux linkages, in 1/H."""
    s = saturation
    d, q = abs(psi_d), abs(psi_q)
    cross = s.a_dq * _power(d, s.U) * _power(q, s.V)
    return Symmetric(
        s.a_d0 + (s.S + 1) * s.a_dd * _power(d, s.S) + cross * q * q * (s.U + 1) / (s.V + 2),
        cross * psi_d * psi_q,
        s.a_q0 + (s.T + 1) * s.a_qq * _power(q, s.T) + cross * d * d * (s.V + 1) / (s.U + 2),
    )


@called
def field_energy(saturation: Saturation, flux: Flux) -> float:
    """Return the energy that brings the flux linkages from zero current to these, in J of a phase."""
    return _potential(saturation, flux.psi_d, flux.psi_q) - _potential(
        saturation, unexcited(saturation).psi_d, 0.0
    )


@njit
def _potential(s: Saturation, psi_d: float, psi_q: float) -> float:
    d, q = abs(psi_d), abs(psi_q)
    along = d * d * (0.5 * s.a_d0 + s.a_dd * _power(d, s.S) / (s.S + 2)) - s.i_f * psi_d
    across = q * q * (0.5 * s.a_q0 + s.a_qq * _power(q, s.T) / (s.T + 2))
    cross = s.a_dq * _power(d, s.U + 2) * _power(q, s.V + 2) / ((s.U + 2) * (s.V + 2))
    return along + across + cross


@njit
def unexcited(saturation: Saturation) -> Flux:
    """Return the flux linkages without current."""
    return flux_at(saturation, 0.0, 0.0, None)


@called
def flux_at(saturation: Saturation, i_d: float, i_q: float, guess: Flux | None) -> Flux:
    """Return the flux linkages of these currents, by Newton's method: `guess` itself if it is right."""
    psi_d, psi_q = _or_zero(guess)
    for _ in range(_ITERATIONS):
        at_d, at_q = currents_of(saturation, psi_d, psi_q)
        off_d, off_q = i_d - at_d, i_q - at_q
        scale = abs(i_d) + abs(i_q) + saturation.i_f
        if abs(off_d) + abs(off_q) <= 1e-14 * scale:
            break
        G = incremental(saturation, psi_d, psi_q)
        per = 1.0 / (G.dd * G.qq - G.dq * G.dq)
        psi_d += (G.qq * off_d - G.dq * off_q) * per
        psi_q += (G.dd * off_q - G.dq * off_d) * per
    return Flux(psi_d, psi_q)


@njit
def _or_zero(guess: Flux | None) -> tuple[float, float]:
    return (0.0, 0.0) if guess is None else (guess.psi_d, guess.psi_q)


@njit
def magnetised(saturation: Saturation | None, psi_r: float) -> Saturation | None:
    """Return the saturation with magnets that have this flux linkage without current."""
    if saturation is None:
        return saturation
    s = saturation
    i_f = (s.a_d0 + s.a_dd * _power(psi_r, s.S)) * psi_r
    return Saturation(s.a_d0, s.a_dd, s.a_q0, s.a_qq, s.a_dq, s.S, s.T, s.U, s.V, i_f)


@njit
def largest(G: Symmetric) -> float:
    """Return the largest eigenvalue; infinity if one is not above zero, where the map has no inverse."""
    if not G.dd * G.qq > G.dq * G.dq:
        return math.inf
    half = 0.5 * (G.dd - G.qq)
    return 0.5 * (G.dd + G.qq) + math.sqrt(half * half + G.dq * G.dq)


@njit
def _power(base: float, exponent: int) -> float:
    result = 1.0
    for _ in range(exponent):
        result *= base
    return result


@dataclass(frozen=True, kw_only=True)
class SaturationTruth:
    """How a machine saturates, by what is added to its inverse inductances without current.

    Raises:
        ValueRefused: by `coefficients`: that would leave no inductance along one of the axes.
    """

    a_dd: float = 0.0
    a_qq: float = 0.0
    a_dq: float = 0.0
    S: int = 5
    T: int = 1
    U: int = 1
    V: int = 0

    def coefficients(self, L_d_H: float, L_q_H: float, psi_r_Wb: float) -> Saturation:
        """Return the coefficients of a machine that has these incremental inductances without current."""
        by_magnets = float(self.a_dd * psi_r_Wb**self.S)
        a_d0 = 1.0 / L_d_H - (self.S + 1) * by_magnets
        a_q0 = 1.0 / L_q_H
        if self.V == 0:
            a_q0 -= self.a_dq / (self.U + 2) * psi_r_Wb ** (self.U + 2)
        for name, left, key in (("L_d_H", a_d0, "a_dd"), ("L_q_H", a_q0, "a_dq")):
            if not left > 0.0:
                raise ValueRefused(
                    f"emulator.motor.saturation: {key} = {getattr(self, key):g} with psi_r_Wb = {psi_r_Wb:g} "
                    f"saturates the machine beyond {name} without any current: lower {key}, or {name}"
                )
        i_f = (a_d0 + by_magnets) * psi_r_Wb
        return Saturation(a_d0, self.a_dd, a_q0, self.a_qq, self.a_dq, self.S, self.T, self.U, self.V, i_f)
