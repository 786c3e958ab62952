"""Which part of the voltage that dead time and devices take is the dead time's, of a turning motor.

Standing currents do not tell them apart. Where the ripple takes a phase current through zero they differ
(`Legs`): in the balance of voltages over one control period,

    u - R_s i - L di/dt - taken(share) = EMF,

of which the EMF turns with the rotor and has the harmonics of that, 6, 12 and 18 times as fast, and what
remains is in proportion to the error of the share.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.legs import Legs

_ORDERS = (0, 6, -6, 12, -12, 18, -18)
_STEPS = (0.3, 0.1)  # of the share, to either side, in the first round and the second
_GUESS, _GUESS_STANDARD = 0.5, 1.0 / math.sqrt(12.0)  # of what nothing tells
_LEAST = 0.05  # standard uncertainty: what the course of a current leaves, decision 0191


@dataclass(frozen=True)
class Spun:
    """One capture of a turning motor: voltages asked for, shape (n,), currents at the ends of the periods,
    shape (n + 1,), electrical angle of the rotor and EMF in each, shapes (n,); `rows` are the periods that
    count."""

    u_V: NDArray[np.complex128]
    i_A: NDArray[np.complex128]
    rotor_rad: NDArray[np.float64]
    emf_V: NDArray[np.complex128]
    rows: NDArray[np.int64]


@dataclass(frozen=True)
class DeadShare:
    """The dead time's share with its standard uncertainty, and what dead time and devices take.

    `taken_V` are the voltages of each capture, shape (n,), and `per_share_V` by how much they change with it.
    """

    value: float
    standard: float
    taken_V: tuple[NDArray[np.complex128], ...]
    per_share_V: tuple[NDArray[np.complex128], ...]

    def taken_at(self, share: float) -> tuple[NDArray[np.complex128], ...]:
        """Return the voltages with another share."""
        both = zip(self.taken_V, self.per_share_V, strict=True)
        return tuple(taken + (share - self.value) * per for taken, per in both)


def dead_share(captures: Sequence[Spun], circuit: Circuit, L_d_H: float, L_q_H: float) -> DeadShare:
    """Return the share, by all captures; half, as likely as any other, where they do not tell."""
    legs, share, standard = circuit.legs(L_d_H, L_q_H), _GUESS, _GUESS_STANDARD
    parts: list[tuple[NDArray[np.complex128], NDArray[np.complex128]]] = []
    for step in _STEPS:
        lower, upper = max(0.0, share - step), min(1.0, share + step)
        middle, parts = 0.5 * (lower + upper), []
        for each in captures:
            low, high = (_taken(legs, circuit, each, at) for at in (lower, upper))
            parts.append((0.5 * (low + high), (high - low) / (upper - lower)))
        by_data, u_data = _fitted(captures, parts, circuit, L_d_H, L_q_H)
        weight = _GUESS_STANDARD**2 / (_GUESS_STANDARD**2 + u_data**2)
        share = float(np.clip(_GUESS + weight * (middle + by_data - _GUESS), 0.0, 1.0))
        standard = math.sqrt(1.0 - weight) * _GUESS_STANDARD
    found = tuple(taken + (share - middle) * per for taken, per in parts)
    return DeadShare(share, max(standard, _LEAST), found, tuple(per for _, per in parts))


def _taken(legs: Legs, circuit: Circuit, of: Spun, share: float) -> NDArray[np.complex128]:
    against = of.emf_V + circuit.R_s_ohm * 0.5 * (of.i_A[1:] + of.i_A[:-1])
    return legs.taken(of.u_V, of.i_A, of.rotor_rad, share, against)


def _fitted(
    captures: Sequence[Spun],
    parts: Sequence[tuple[NDArray[np.complex128], NDArray[np.complex128]]],
    circuit: Circuit,
    L_d_H: float,
    L_q_H: float,
) -> tuple[float, float]:
    """Return what is to be added to the share at which `parts` are, and its standard uncertainty, by the
    scatter about the balance and over the captures."""
    products, squares, left = [], [], 0.0
    rows = 0
    for each, (taken, per) in zip(captures, parts, strict=True):
        turned = np.exp(-1j * each.rotor_rad)
        di = np.diff(each.i_A) * turned
        induced = (L_d_H * di.real + 1j * L_q_H * di.imag) / circuit.T_s
        mean = 0.5 * (each.i_A[1:] + each.i_A[:-1])
        y = ((each.u_V - taken - circuit.R_s_ohm * mean) * turned - induced)[each.rows]
        x = (per * turned)[each.rows]
        basis, _ = np.linalg.qr(np.exp(1j * np.outer(each.rotor_rad[each.rows], _ORDERS)))
        y, x = (column - basis @ (basis.conj().T @ column) for column in (y, x))
        products.append(float(np.vdot(x, y).real))
        squares.append(float(np.vdot(x, x).real))
        left += float(np.vdot(y, y).real)
        rows += 2 * len(y)
    whole = sum(squares)
    if not whole > 0.0:
        return 0.0, math.inf
    found = sum(products) / whole
    of_each = [p - found * s for p, s in zip(products, squares, strict=True)]
    scatter = math.sqrt(sum(each**2 for each in of_each)) / whole
    return found, math.hypot(math.sqrt(left / rows / whole), scatter)
