"""Inductances of both axes at standstill, from a voltage vector that turns fast.

Over a control period the flux linkage behind the resistance changes by what the voltage leaves,

    i[k+1] - i[k] = G T_s (u[k] - R_s i_mean - taken by dead time and devices),

with G the inverse of the inductance in the stator frame,

    G = g_0 + g_1 C,   g_0 = (1/L_d + 1/L_q) / 2,   g_1 = (1/L_d - 1/L_q) / 2 exp(j 2 theta_e),

where C conjugates the vector. It is linear in g_0 and g_1, with the change of the current as the dependent
variable, so that its noise does not flatten the slope. What R_s and dead time take of an alternating voltage
is a quarter of a period away from what the inductance takes, so that errors of theirs enter in second order.
With the mean of both ends for i_mean the slope is that of L' = R_s T_s / (2 tanh(R_s T_s / 2 L)), which is
solved for L.

A sample of the current is in two changes, with opposite signs, and what dead time takes of a phase near zero
current is less known than what it takes else. The changes are weighted by the inverse of the covariance that
both make, which is tridiagonal: where noise is large beside that voltage, this is a fit to the flux linkage
itself, and where it is small, to the periods with every phase clear of zero.

Iron that saturates has a current take of the inductance. Along the flux of the magnets the sign matters,
across it does not: the slope of one energy of both currents has regressors by i_d and i_d^2, one by i_q that
both axes share, and by |i_q| and i_q^2. These leave the inductances of no current. The last two are hardly
told apart and come as their sum and their difference, which is taken to be 0 with a standard deviation of the
sum: iron bends by one of the powers, or between them.

The current shakes the rotor, whose EMF (`ShakenRotor`) is as a capacitor in series, and couples both axes by
its harmonics. One frequency cannot tell it from smaller inductances, and two can. It is linear in its factor
K, and about an estimate in the harmonics, which the rotor's way through their angles tells; where it does not
move, they stay what they were taken to be, with the uncertainty of that.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.shaken_rotor import SHARE_STANDARD, ShakenRotor
from benchtool.commission.estimators.vectors import drop_vector, phases_of
from benchtool.errors import AnalysisError

_CLEAR = 0.15  # of the largest current, by what goes with the voltage: so clear of zero is every phase
_SEEN_CLEAR = 0.05  # by its readings: so far below that their noise does not choose
_FEWEST = 40
_FROM = 0.5  # of a capture, from which on it is used: before, dead time takes too much of the voltage
_SLOW = 8  # degree of the polynomial by which the rotor moves slowly
_NEAR_ZERO = 1.5  # of V_drop: what is not known of the voltage where a phase is near zero
_KNOWN = 0.1  # of the noise of a current: what is not known of a change elsewhere, by the steps of the duties
_LEAST_NOISE = 1e-4  # of the largest current
_ROUNDS = 3  # with dead time and the shaken rotor by what the one before found
_SUMMED = 12  # stretches of a capture, whose scores are taken to be independent
_LINEAR = 6  # regressors of iron that does not saturate
_BENDS_Q, _POWER_Q = 9, 10  # sum and difference of what i_q takes, by its first and second power
_LEAST_BEND = 0.02  # of 1/L_q, by which that difference is unknown however little the sum is
_OF_SHAKEN = slice(3, _LINEAR)  # of them, K and the changes of its harmonics
_OF_SHARES = (4, 5)


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
class OfAxis:
    """An inductance in H without current, its standard uncertainty, and by how much it is larger than with
    the current of the captures."""

    L_H: float
    standard_H: float
    bent_H: float


@dataclass(frozen=True)
class _Round:
    """What a round rests on: inductances of both axes in H, by how much the largest i_q bends 1/L_q, the
    rotor, and the error of a row, were rows independent: their scatter about the fit, as much larger as that
    over stretches has it."""

    L_d_H: float
    L_q_H: float
    bend_per_H: float
    rotor: ShakenRotor
    error: float


@dataclass(frozen=True)
class Inductance:
    """Inductances along the rotor flux and across it, with degrees of freedom.

    `axis_rad` is the electrical angle of the d-axis against phase a, or against the encoder's, modulo pi: the
    axis of the anisotropy nearest to where the rotor was aligned; nan where that is no clearer than its
    noise.
    """

    d: OfAxis
    q: OfAxis
    dof: float
    axis_rad: float


def inductance(
    captures: Sequence[Turning],
    circuit: Circuit,
    *,
    aligned_rad: float,
    aligned_standard_rad: float = math.inf,
) -> Inductance:
    """Return the estimates.

    Args:
        captures: of two speeds at least.
        circuit: what is known of winding and inverter.
        aligned_rad: electrical angle at which the rotor was aligned, against phase a, or what is left of it
            beyond `rotor_rad`.
        aligned_standard_rad: standard uncertainty of that, with which it stands against the axis of the
            anisotropy; infinite where a clear anisotropy alone is to tell.

    Raises:
        AnalysisError: too short, or of one speed only.
    """
    before: _Round | None = None
    for _ in range(1 + _ROUNDS):
        parts = [_changes(each, circuit, aligned_rad, before) for each in captures]
        found, before = _of_parts(parts, circuit, aligned_rad, aligned_standard_rad, before)
    return found


def _of_parts(
    parts: Sequence[NDArray[np.float64]],
    circuit: Circuit,
    aligned_rad: float,
    aligned_standard_rad: float,
    before: _Round | None,
) -> tuple[Inductance, _Round]:
    """Return the estimates of white rows, shape (2, n, m) of each capture, and what the next round rests
    on."""
    flat = np.concatenate([part.reshape(-1, part.shape[2]) for part in parts])
    taken = _taken(flat.shape[1], before)
    rotor, error = (ShakenRotor(), 1.0) if before is None else (before.rotor, before.error)
    both = np.concatenate([flat, taken])
    A, y = both[:, :-1], both[:, -1]
    fit = least_squares(A, y, lost_dof=2 * (_SLOW + 1) * len(parts))
    alike = least_squares(A[:, :_LINEAR], y)
    bread = fit.covariance / fit.scatter**2
    covariance, dof = _by_stretches(parts, fit.x, bread)
    of_three = np.diag(covariance)[:3] / np.diag(bread)[:3]
    of_taken = bread @ taken[:, :-1].T * error
    covariance = covariance + of_taken @ of_taken.T
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
    RT, axes = circuit.R_s_ohm * circuit.T_s, []
    for of in (np.array([1.0, c, s]), np.array([1.0, -c, -s])):
        L, bent = (1.0 / float(of @ x[:3]) for x in (fit.x, alike.x))
        if not L > 0.0:
            raise AnalysisError("the currents do not follow the voltage: check that the motor is connected")
        u = L**2 * math.sqrt(float(of @ covariance[:3, :3] @ of))
        axes.append(OfAxis(_exact(L, RT), u, L - bent))
    found = Inductance(axes[0], axes[1], dof, axis % math.pi if clear else math.nan)
    K, by_fifth, by_seventh = fit.x[_OF_SHAKEN].tolist()
    if before is None:  # its column was the EMF as if all the inductance were 1 H
        K *= found.q.L_H
    rotor = rotor.moved(K, by_fifth, by_seventh)
    bend = float(fit.x[_BENDS_Q])
    return found, _Round(found.d.L_H, found.q.L_H, bend, rotor, math.sqrt(float(np.mean(of_three))))


def _taken(columns: int, before: _Round | None) -> NDArray[np.float64]:
    """Return rows beside those of the data, shape (2 or 3, columns): what unknowns are taken to be."""
    if before is None:
        rows = np.zeros((2, columns))
        rows[(0, 1), _OF_SHARES] = 1.0 / SHARE_STANDARD
        return rows
    rows = np.zeros((3, columns))
    rows[(0, 1), _OF_SHARES] = before.error / SHARE_STANDARD
    rows[:2, -1] = -before.error / SHARE_STANDARD * np.array([before.rotor.fifth, before.rotor.seventh])
    rows[2, _POWER_Q] = before.error / math.hypot(before.bend_per_H, _LEAST_BEND / before.L_q_H)
    return rows


def _exact(L_H: float, RT: float) -> float:
    """Return the inductance whose exponential course has the slope of `L_H` for the mean of both ends."""
    share = 0.5 * RT / L_H
    return 0.5 * RT / math.atanh(share) if 0.0 < abs(share) < 1.0 else L_H


def _changes(of: Turning, circuit: Circuit, aligned_rad: float, before: _Round | None) -> NDArray[np.float64]:
    """Return the rows of both components of a capture, made white and less what changes slowly, shape
    (2, n, m): the regressors, and last the change of the current.

    Without a round before, dead time is that of a current which keeps its sign, and the rotor has no
    harmonics.
    """
    T_s, phases, i = circuit.T_s, of.readings_A * circuit.gains, circuit.currents(of.readings_A)
    mean, rotor_rad = 0.5 * (i[1:] + i[:-1]), np.broadcast_to(of.rotor_rad, len(of.u_V))
    clear = _clear(of.u_V, i) & _far(phases, _SEEN_CLEAR)
    if np.count_nonzero(clear) < _FEWEST:
        raise AnalysisError(
            f"{np.count_nonzero(clear)} control periods in which no phase is near zero, {_FEWEST} at least "
            f"are needed: let a larger current turn more slowly"
        )
    largest_A = float(np.max(np.abs(i)))
    noise_A = max(math.sqrt(2.0 / 3.0) * circuit.noise_A, _LEAST_NOISE * largest_A)
    theta, axes, turned = rotor_rad + aligned_rad, cmath.exp(1j * aligned_rad), np.exp(-1j * rotor_rad)
    i_dq = mean * turned / axes
    if before is None:
        taken_V = circuit.drop_V * drop_vector(phases[1:])
        unknown_A = largest_A
        induced: list[NDArray[np.complex128]] = list(ShakenRotor().shaking(i_dq, theta, T_s))
    else:
        legs = circuit.legs(before.L_d_H, before.L_q_H)
        taken_V = legs.taken(of.u_V, i, theta, 0.5)
        unknown_A = _NEAR_ZERO * circuit.drop_V * T_s * 0.5 * (1.0 / before.L_d_H + 1.0 / before.L_q_H)
        induced = [
            emf.real / before.L_d_H + 1j * emf.imag / before.L_q_H
            for emf in before.rotor.shaking(i_dq, theta, T_s)
        ]
    x = T_s * turned * (of.u_V - circuit.R_s_ohm * mean - taken_V)
    x_dq, share = x / axes, i_dq / largest_A
    of_magnet = share.real * x_dq.real
    of_both = share.imag * x_dq.imag + 1j * (share.imag * x_dq.real + share.real * x_dq.imag)
    first = 1j * np.abs(share.imag) * x_dq.imag
    bends = of_magnet, of_both, share.real * of_magnet, first + np.abs(share.imag) * first
    shaken = [-T_s * axes * emf for emf in induced]
    columns = [x, x.conj(), 1j * x.conj(), *shaken, *(axes * bend for bend in bends)]
    if before is not None:
        columns.append(axes * (first - np.abs(share.imag) * first))
    columns.append(turned * np.diff(i))
    rows = slice(math.floor(_FROM * len(x)), None)
    unknown = np.where(clear[rows], _KNOWN * noise_A, max(unknown_A, _KNOWN * noise_A))
    return _white(np.column_stack(columns)[rows], noise_A, unknown)


def _white(
    columns: NDArray[np.complex128], noise_A: float, unknown_A: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return both components of changes of a current, shape (2, n, m), with independent errors of 1.

    What is left of an offset of the current sensors looks like a constant torque, that is an EMF which grows
    evenly, and cogging swings the rotor slowly about where it stands: a polynomial is taken off.

    Args:
        columns: shape (n, m).
        noise_A: of each sample of the current, which is in two changes.
        unknown_A: what else each change is off by, shape (n,).
    """
    from scipy.linalg import cholesky_banded, solve_banded

    n, m = columns.shape
    bands = np.empty((2, n))
    bands[0], bands[1] = 2.0 * noise_A**2 + unknown_A**2, -(noise_A**2)
    slow = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, n), _SLOW)
    both = np.column_stack([slow, columns.real, columns.imag])
    white = solve_banded((1, 0), cholesky_banded(bands, lower=True), both)
    basis, _ = np.linalg.qr(white[:, : _SLOW + 1])
    left = white[:, _SLOW + 1 :]
    left = left - basis @ (basis.T @ left)
    return np.stack([left[:, :m], left[:, m:]])


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


def _by_stretches(
    parts: Sequence[NDArray[np.float64]], x: NDArray[np.float64], bread: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return the covariance of a fit by scores summed over stretches, and its degrees of freedom: what dead
    time leaves comes again with every turn, and is not independent within a stretch."""
    scores = []
    for part in parts:
        A, left = part[:, :, :-1], part[:, :, -1] - part[:, :, :-1] @ x
        of_rows = np.sum(A * left[:, :, None], axis=0)
        scores += [np.sum(each, axis=0) for each in np.array_split(of_rows, _SUMMED)]
    summed = np.array(scores)
    dof = len(summed) - len(x)
    found: NDArray[np.float64] = bread @ (summed.T @ summed) @ bread * (len(summed) / dof)
    return found, float(dof)
