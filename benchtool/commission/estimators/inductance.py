"""Inductances of both axes at standstill, from a voltage vector that turns fast.

Over a control period the flux linkage behind the resistance changes by what the voltage leaves,

    i[k+1] - i[k] = G T_s (u[k] - R_s i_mean - V_drop s(i)),

with G the inverse of the inductance in the stator frame,

    G = g_0 + g_1 C,   g_0 = (1/L_d + 1/L_q) / 2,   g_1 = (1/L_d - 1/L_q) / 2 exp(j 2 theta_e),

where C conjugates the vector. It is linear in g_0 and g_1, with the change of the current as the dependent
variable, so that its noise does not flatten the slope. s(i) holds where no phase is near zero or changes its
sign: other periods are left out. What R_s and V_drop take of an alternating voltage is a quarter of a period
away from what the inductance takes, so that errors of theirs enter in second order. With the mean of both
ends for i_mean the slope is that of L' = R_s T_s / (2 tanh(R_s T_s / 2 L)), which is solved for L.

The current across the rotor flux shakes the rotor, whose EMF is as a capacitor in series,

    u = K integral of i_q dt,   K = 3/2 p^2 psi_r^2 / J,

which one frequency cannot tell from a smaller L_q, and two can.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import Fit, least_squares
from benchtool.commission.estimators.vectors import drop_vector, phases_of, vector_of
from benchtool.errors import AnalysisError

_CLEAR = 0.15  # of the largest current, by what goes with the voltage: so clear of zero is every phase
_SEEN_CLEAR = 0.05  # by its readings: so far below that their noise does not choose
_FEWEST = 40
_SLOW = 6  # degree of the polynomial by which the rotor moves slowly


@dataclass(frozen=True)
class Turning:
    """One capture: voltages asked for, shape (n,), and phase currents, shape (n + 1, 3).

    u_V[k] acts from readings_A[k] to readings_A[k + 1]. `rotor_rad` is the electrical angle of the rotor by
    the encoder over each period, shape (n,), or 0 where it is not known: where the rotor moved it has to be.
    """

    u_V: NDArray[np.complex128]
    readings_A: NDArray[np.float64]
    rotor_rad: NDArray[np.float64] | float = 0.0


@dataclass(frozen=True)
class Inductance:
    """L_d and L_q in H with standard uncertainties and degrees of freedom.

    `axis_rad` is the electrical angle of the d-axis against phase a, or against the encoder's, modulo pi: the
    axis of the anisotropy nearest to where the rotor was aligned; nan where that is no clearer than its
    noise.
    """

    L_d_H: float
    L_d_standard_H: float
    L_q_H: float
    L_q_standard_H: float
    dof: float
    axis_rad: float


def inductance(
    captures: Sequence[Turning],
    *,
    T_s: float,
    R_s_ohm: float,
    drop_V: float,
    gains: NDArray[np.float64],
    aligned_rad: float,
    aligned_standard_rad: float = math.inf,
) -> Inductance:
    """Return the estimates.

    Args:
        captures: of two speeds at least.
        T_s: control period.
        R_s_ohm, drop_V: resistance, and voltage that dead time and devices take of a phase.
        gains: corrections of the current sensors, shape (3,).
        aligned_rad: electrical angle at which the rotor was aligned, against phase a, or what is left of it
            beyond `rotor_rad`.
        aligned_standard_rad: standard uncertainty of that, with which it stands against the axis of the
            anisotropy; infinite where a clear anisotropy alone is to tell.

    Raises:
        AnalysisError: too short, or of one speed only.
    """
    parts = [part for each in captures for part in _changes(each, T_s, R_s_ohm, drop_V, gains, aligned_rad)]
    fit = least_squares(
        np.concatenate([part.A for part in parts]),
        np.concatenate([part.y for part in parts]),
        lost_dof=(_SLOW + 1) * len(parts),
    )
    covariance = _of_differences(parts, fit)
    g_1 = complex(fit.x[1], fit.x[2])
    u_g_1 = math.sqrt(float(covariance[1, 1] + covariance[2, 2]))
    along = cmath.exp(-2j * aligned_rad)
    clear = abs(g_1) > 5.0 * u_g_1
    turned = cmath.phase(g_1 * along) if clear else 0.0
    if abs(turned) > 0.5 * math.pi:  # 1/L_q is the larger: the other axis of the anisotropy is near
        turned -= math.copysign(math.pi, turned)
    if math.isfinite(aligned_standard_rad) and clear:  # a weak anisotropy turned by noise looks stronger
        by_fit, by_encoder = (0.5 * u_g_1 / abs(g_1)) ** 2, aligned_standard_rad**2
        turned *= by_encoder / (by_encoder + by_fit)
    axis = aligned_rad + 0.5 * turned
    c, s = math.cos(2.0 * axis), math.sin(2.0 * axis)
    d, q = np.array([1.0, c, s, 0.0]), np.array([1.0, -c, -s, 0.0])
    L_d, L_q = (_exact(1.0 / float(axis @ fit.x), R_s_ohm * T_s) for axis in (d, q))
    u_d = L_d**2 * math.sqrt(float(d @ covariance @ d))
    u_q = L_q**2 * math.sqrt(float(q @ covariance @ q))
    if not (L_d > 0.0 and L_q > 0.0):
        raise AnalysisError("the currents do not follow the voltage: check that the motor is connected")
    return Inductance(L_d, u_d, L_q, u_q, fit.dof, axis % math.pi if clear else math.nan)


def _exact(L_H: float, RT: float) -> float:
    """Return the inductance whose exponential course has the slope of `L_H` for the mean of both ends."""
    share = 0.5 * RT / L_H
    return 0.5 * RT / math.atanh(share) if 0.0 < abs(share) < 1.0 else L_H


@dataclass(frozen=True)
class _Part:
    """Rows of one component of one capture, less what changes slowly; `k` is the control period of each."""

    A: NDArray[np.float64]
    y: NDArray[np.float64]
    k: NDArray[np.int64]


def _changes(
    of: Turning, T_s: float, R_s: float, drop_V: float, gains: NDArray[np.float64], aligned_rad: float
) -> Iterator[_Part]:
    """Yield the rows of a capture, those of both components."""
    phases = of.readings_A * gains
    i = vector_of(phases)
    mean = 0.5 * (i[1:] + i[:-1])
    clear = _clear(of.u_V, i) & _far(phases, _SEEN_CLEAR)
    (k,) = np.nonzero(clear)
    if len(k) < _FEWEST:
        raise AnalysisError(
            f"{len(k)} control periods in which no phase is near zero, {_FEWEST} at least are needed: let "
            f"a larger current turn more slowly"
        )
    across = cmath.exp(1j * (aligned_rad + 0.5 * math.pi))
    turned = np.exp(-1j * np.broadcast_to(of.rotor_rad, mean.shape))
    speed = np.cumsum(T_s * (mean * turned * across.conjugate()).real)
    x = T_s * turned * (of.u_V - R_s * mean - drop_V * drop_vector(phases[1:]))
    columns = (x, x.conj(), 1j * x.conj(), -T_s * speed * across, turned * np.diff(i))
    rows = np.column_stack([each[k] for each in columns])
    for component in (rows.real, rows.imag):
        left = _less_slow(component, k)
        yield _Part(left[:, :-1], left[:, -1], k)


def _less_slow(columns: NDArray[np.float64], k: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return columns less a polynomial over k each.

    What is left of an offset of the current sensors looks like a constant torque, that is an EMF which grows
    evenly, and cogging swings the rotor slowly about where it stands.
    """
    slow, _ = np.linalg.qr(np.polynomial.legendre.legvander((k - k[0]) / (k[-1] - k[0]) * 2.0 - 1.0, _SLOW))
    left: NDArray[np.float64] = columns - slow @ (slow.T @ columns)
    return left


def _clear(u_V: NDArray[np.complex128], i: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return in which control periods every phase keeps its sign and is clear of zero.

    By the current that goes with the voltage, an ellipse while that turns: were it by the readings, their
    noise would choose which changes are seen, and make them smaller.
    """
    both = np.column_stack((u_V, u_V.conj()))
    response = np.linalg.lstsq(both, i[:-1], rcond=None)[0]
    return np.append(_far(phases_of(both @ response), _CLEAR), False)


def _far(phases: NDArray[np.float64], share: float) -> NDArray[np.bool_]:
    """Return between which neighbours every phase keeps its sign and is beyond a share of the largest."""
    before, after = phases[:-1], phases[1:]
    far = np.minimum(np.abs(before), np.abs(after)) > share * np.max(np.abs(phases))
    kept: NDArray[np.bool_] = np.all(far & (before * after > 0.0), axis=1)
    return kept


def _of_differences(parts: Sequence[_Part], fit: Fit) -> NDArray[np.float64]:
    """Return the covariance of a fit to differences of samples with independent noise.

    A sample is in two of them, with opposite signs: neighbours are correlated by -1/2.
    """
    m = len(fit.x)
    middle = np.zeros((m, m))
    for part in parts:
        middle += part.A.T @ part.A
        (next_to,) = np.nonzero(np.diff(part.k) == 1)
        both = part.A[next_to].T @ part.A[next_to + 1]
        middle -= 0.5 * (both + both.T)
    bread = fit.covariance / fit.scatter**2
    found: NDArray[np.float64] = fit.scatter**2 * bread @ middle @ bread
    return found
