"""A table of flux linkages as the polynomial that the machine integrates.

The machine's map between currents and flux linkages is reciprocal by construction and explicit in the
direction that is needed; the interpolation of a table is neither (record 0156). So the polynomial is fitted
to the table by least squares, and a table that it does not follow is refused.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.machine.saturation import Flux, Saturation, SaturationTruth, flux_at, incremental
from benchtool.errors import ValueRefused

MOST_OFF: Final = 0.03
"""Of the largest flux linkage: what the polynomial may be off at a point of the table."""
_ALONG = range(1, 10)  # exponents S and T
_CROSS = range(4)  # exponents U and V
_FEW = 15  # values along an axis, of which the fits are made
_KEY: Final = "emulator.motor.flux_linkages"

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Fitted:
    """The machine of a table: what it is without current, how it saturates, and the largest deviation of a
    flux linkage from the table in Wb."""

    L_d_H: float
    L_q_H: float
    psi_r_Wb: float
    saturation: SaturationTruth
    off_Wb: float


@cache
def fit_flux_linkages(
    i_d_A: tuple[float, ...],
    i_q_A: tuple[float, ...],
    psi_d_Wb: tuple[tuple[float, ...], ...],
    psi_q_Wb: tuple[tuple[float, ...], ...],
) -> Fitted:
    """Return the polynomial of least squares that follows a table, rows of which are of i_d.

    Raises:
        ValueRefused: none of them does so within `MOST_OFF`.
    """
    grid = np.array([*np.meshgrid(i_d_A, i_q_A, indexing="ij"), psi_d_Wb, psi_q_Wb])
    i_d, i_q, psi_d, psi_q = grid.reshape(4, -1)
    few = grid[:, :: 1 + len(i_d_A) // _FEW, :: 1 + len(i_q_A) // _FEW].reshape(4, -1)
    found = [_fit(few, *each) for each in _exponents()]
    _, best = min(found, key=lambda each: each[0])
    if best is None:
        raise ValueRefused(
            f"{_KEY}: no machine follows this table: without current it would have no rotor flux, or no "
            f"inductance; check signs and rotor angle of the table"
        )
    at = [flux_at(best, float(d), float(q), None) for d, q in zip(i_d, i_q, strict=True)]
    off = np.hypot(psi_d - [each.psi_d for each in at], psi_q - [each.psi_q for each in at])
    worst, largest = int(np.argmax(off)), float(np.max(np.hypot(psi_d, psi_q)))
    if not off[worst] <= MOST_OFF * largest:
        raise ValueRefused(
            f"{_KEY}: the polynomial that follows this table best is off by {off[worst]:.3g} Wb at i_d = "
            f"{i_d[worst]:g} A, i_q = {i_q[worst]:g} A, {MOST_OFF:.0%} of {largest:.3g} Wb are allowed: "
            f"leave out currents that the drive never reaches"
        )
    return _machine(best, float(off[worst]))


def _exponents() -> itertools.product[tuple[int, ...]]:
    return itertools.product(_ALONG, _ALONG, _CROSS, _CROSS)


def _fit(points: Vector, S: int, T: int, U: int, V: int) -> tuple[float, Saturation | None]:
    """Return the sum of squares of the currents that these exponents leave, and the coefficients; without
    any where there is no such machine."""
    from scipy.optimize import nnls

    i_d, i_q, psi_d, psi_q = points
    d, q = np.abs(psi_d), np.abs(psi_q)
    none = np.zeros_like(d)
    cross = d**U * q**V
    columns: list[tuple[Any, Any]] = [
        (psi_d, none),
        (d**S * psi_d, none),
        (none, psi_q),
        (none, q**T * psi_q),
        (cross * q * q * psi_d / (V + 2), cross * d * d * psi_q / (U + 2)),
        (none - 1.0, none),
    ]
    A = np.array([np.concatenate(each) for each in columns]).T
    scale = np.abs(A).max(axis=0)
    scale[scale == 0.0] = 1.0
    solved, residual = nnls(A / scale, np.concatenate((i_d, i_q)))
    a_d0, a_dd, a_q0, a_qq, a_dq, i_f = (float(each) for each in solved / scale)
    if min(a_d0, a_q0, i_f) <= 0.0:
        return math.inf, None
    return float(residual), Saturation(a_d0, a_dd, a_q0, a_qq, a_dq, S, T, U, V, i_f)


def _machine(s: Saturation, off_Wb: float) -> Fitted:
    psi_r = flux_at(s, 0.0, 0.0, None).psi_d
    per_L = incremental(s, *Flux(psi_r, 0.0))
    truth = SaturationTruth(a_dd=s.a_dd, a_qq=s.a_qq, a_dq=s.a_dq, S=s.S, T=s.T, U=s.U, V=s.V)
    return Fitted(1.0 / per_L.dd, 1.0 / per_L.qq, psi_r, truth, off_Wb)
