"""Inductances of both axes at standstill, from an alternating voltage in several directions.

Over a control period the flux linkage behind the resistance changes by what the voltage leaves,

    i[k+1] - i[k] = G T_s (u[k] - R_s i_mean - V_drop s(i)),

with G the inverse of the inductance in the stator frame,

    G = g_0 + g_1 C,   g_0 = (1/L_d + 1/L_q) / 2,   g_1 = (1/L_d - 1/L_q) / 2 exp(j 2 theta_e),

where C conjugates the vector. Summed over the periods of a stretch it is linear in g_0 and g_1, with the
current as the dependent variable, so that its noise does not flatten the slope. What the resistance and
V_drop take of an alternating voltage is a quarter of a period away from what the inductance takes: R_s enters
in second order, and V_drop is fitted besides. The current across the rotor flux shakes the rotor, whose EMF
is as a capacitor in series,

    u = K integral of i_q dt,   K = 3/2 p^2 psi_r^2 / J,

which one frequency cannot tell from a smaller L_q, and two can.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.vectors import drop_vector, vector_of
from benchtool.errors import AnalysisError

_CLEAR = 0.1  # of the largest current: below it the sign of a phase may change within a period


@dataclass(frozen=True)
class Alternation:
    """One direction: voltages asked for, shape (n,), and phase currents, shape (n + 1, 3).

    u_V[k] acts from readings_A[k] to readings_A[k + 1]. `stretch` control periods are taken by themselves,
    with a straight line of their own: some periods of the alternation.
    """

    u_V: NDArray[np.complex128]
    readings_A: NDArray[np.float64]
    stretch: int


@dataclass(frozen=True)
class Inductance:
    """L_d and L_q in H with standard uncertainties and degrees of freedom.

    `axis_rad` is the electrical angle of the d-axis against phase a, modulo pi: the axis of the anisotropy
    nearest to where the rotor was aligned; nan where that is no clearer than its noise.
    """

    L_d_H: float
    L_d_standard_H: float
    L_q_H: float
    L_q_standard_H: float
    dof: float
    axis_rad: float


def inductance(
    directions: Sequence[Alternation],
    *,
    T_s: float,
    R_s_ohm: float,
    gains: NDArray[np.float64],
    aligned_rad: float,
) -> Inductance:
    """Return the estimates.

    Args:
        directions: of two axes at least, and of two frequencies.
        T_s: control period.
        R_s_ohm: resistance; it enters in second order.
        gains: corrections of the current sensors, shape (3,).
        aligned_rad: electrical angle at which the rotor was aligned, against phase a.

    Raises:
        AnalysisError: too short, or one direction or frequency only.
    """
    rows, seen = [], []
    for each in directions:
        for A, y in _stretches(each, T_s, R_s_ohm, gains, aligned_rad):
            rows.append(A)
            seen.append(y)
    if not rows:
        raise AnalysisError("no whole stretch of the alternation: record longer")
    fit = least_squares(np.concatenate(rows), np.concatenate(seen), lost_dof=2 * len(rows))
    g_0, g_1 = float(fit.x[0]), complex(fit.x[1], fit.x[2])
    u_g_1 = math.hypot(fit.standard(1), fit.standard(2))
    along = cmath.exp(-2j * aligned_rad)
    clear = abs(g_1) > 5.0 * u_g_1
    turned = cmath.phase(g_1 * along) if clear else 0.0
    if abs(turned) > 0.5 * math.pi:  # 1/L_q is the larger: the other axis of the anisotropy is near
        turned -= math.copysign(math.pi, turned)
    axis = aligned_rad + 0.5 * turned
    c, s = math.cos(2.0 * axis), math.sin(2.0 * axis)
    d, q = np.array([1.0, c, s, 0.0, 0.0]), np.array([1.0, -c, -s, 0.0, 0.0])
    L_d, L_q = 1.0 / float(d @ fit.x), 1.0 / float(q @ fit.x)
    u_d = L_d**2 * math.sqrt(float(d @ fit.covariance @ d))
    u_q = L_q**2 * math.sqrt(float(q @ fit.covariance @ q))
    if not (L_d > 0.0 and L_q > 0.0 and g_0 > 0.0):
        raise AnalysisError("the currents do not follow the voltage: check that the motor is connected")
    return Inductance(L_d, u_d, L_q, u_q, fit.dof, axis % math.pi if clear else math.nan)


def _stretches(
    of: Alternation, T_s: float, R_s: float, gains: NDArray[np.float64], aligned_rad: float
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield regressors and currents of every stretch, one component after the other, less their trends."""
    phases = of.readings_A * gains
    i = vector_of(phases)
    middle = 0.5 * (phases[1:] + phases[:-1])
    mean = vector_of(middle)
    flux = _summed(T_s * (of.u_V - R_s * mean))
    drop = _summed(T_s * drop_vector(middle))
    across = cmath.exp(1j * (aligned_rad + 0.5 * math.pi))
    speed = _summed(T_s * (mean * across.conjugate()).real)
    motion = _summed(T_s * 0.5 * (speed[1:] + speed[:-1])) * across
    columns = (flux, flux.conj(), 1j * flux.conj(), -drop, -motion, i)
    for start in range(0, len(i) - of.stretch + 1, of.stretch):
        part = np.column_stack([each[start : start + of.stretch] for each in columns])
        for component in (part.real, part.imag):
            left = _less_trend(component)
            yield left[:, :-1], left[:, -1]


def _summed(steps: NDArray[Any]) -> NDArray[Any]:
    """Return the sum of all steps before each moment."""
    return np.concatenate((np.zeros(1, steps.dtype), np.cumsum(steps)))


def _less_trend(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return columns less their straight lines of least squares."""
    n = len(columns)
    line, _ = np.linalg.qr(np.column_stack((np.ones(n), np.arange(n) - 0.5 * (n - 1))))
    left: NDArray[np.float64] = columns - line @ (line.T @ columns)
    return left
