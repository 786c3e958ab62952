"""Phases that differ: resistance and inductance in series with each, an optional part of the machine.

A quantity that differs between the phases is a symmetric matrix in alpha/beta. It stands still, so in d/q it
is the mean of the phases and a part that turns at -2 theta_e:

    E = mean 1 + [[n_c, n_s], [n_s, -n_c]]    n_c + j n_s = n exp(-j 2 theta)    n = (a + b w^2 + c w) / 3

with w = exp(j 2 pi / 3). The phases' inductance is that of a leak: it does not depend on the angle, so that
it has no torque.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import called, njit


class Symmetric(NamedTuple):
    """A symmetric matrix in d/q."""

    dd: float
    dq: float
    qq: float


class Asymmetry(NamedTuple):
    """Resistance and inductance in series with the phases: mean, and vector at theta 0, in ohm and H."""

    R: float
    R_alpha: float
    R_beta: float
    L: float
    L_alpha: float
    L_beta: float


def sequences(a: float, b: float, c: float) -> tuple[float, float, float]:
    """Return the mean of three phase quantities, and real and imaginary part of n as above."""
    return (a + b + c) / 3.0, (2.0 * a - b - c) / 6.0, (c - b) * math.sqrt(3.0) / 6.0


@njit
def with_asymmetry(
    asymmetry: Asymmetry | None,
    di_d: float,
    di_q: float,
    i_d: float,
    i_q: float,
    omega_e: float,
    cos_theta: float,
    sin_theta: float,
    G: Symmetric,
) -> tuple[float, float]:
    """Return the rates of the currents with what is in series with the phases.

    The voltage that is left for a machine of inverse inductance `G`, u - E_R i - E_L (di/dt + omega x i),
    makes these rates: a linear equation for di/dt. With open terminals `G` is zero, and nothing flows.
    """
    if asymmetry is None:
        return di_d, di_q
    return _with_series(asymmetry, di_d, di_q, i_d, i_q, omega_e, cos_theta, sin_theta, G)


@called
def _with_series(
    asymmetry: Asymmetry,
    di_d: float,
    di_q: float,
    i_d: float,
    i_q: float,
    omega_e: float,
    cos_theta: float,
    sin_theta: float,
    G: Symmetric,
) -> tuple[float, float]:
    R, L = _in_rotor_frame(asymmetry, cos_theta, sin_theta)
    u_d = R.dd * i_d + R.dq * i_q + omega_e * (L.dq * i_d - L.dd * i_q)
    u_q = R.dq * i_d + R.qq * i_q + omega_e * (L.qq * i_d - L.dq * i_q)
    return _solved(G, L, di_d - G.dd * u_d - G.dq * u_q, di_q - G.dq * u_d - G.qq * u_q)


@called
def through_asymmetry(
    asymmetry: Asymmetry | None, cos_theta: float, sin_theta: float, G: Symmetric
) -> Symmetric:
    """Return the inverse inductance between the terminals and a machine of inverse inductance `G`."""
    if asymmetry is None:
        return G
    _, L = _in_rotor_frame(asymmetry, cos_theta, sin_theta)
    dd, dq = _solved(G, L, G.dd, G.dq)
    _, qq = _solved(G, L, G.dq, G.qq)
    return Symmetric(dd, dq, qq)


@njit
def _in_rotor_frame(asymmetry: Asymmetry, cos_theta: float, sin_theta: float) -> tuple[Symmetric, Symmetric]:
    """Return E_R and E_L in d/q."""
    c, s = cos_theta * cos_theta - sin_theta * sin_theta, 2.0 * sin_theta * cos_theta
    R_c, R_s = asymmetry.R_alpha * c + asymmetry.R_beta * s, asymmetry.R_beta * c - asymmetry.R_alpha * s
    L_c, L_s = asymmetry.L_alpha * c + asymmetry.L_beta * s, asymmetry.L_beta * c - asymmetry.L_alpha * s
    return (
        Symmetric(asymmetry.R + R_c, R_s, asymmetry.R - R_c),
        Symmetric(asymmetry.L + L_c, L_s, asymmetry.L - L_c),
    )


@njit
def _solved(G: Symmetric, L: Symmetric, d: float, q: float) -> tuple[float, float]:
    """Return the solution of (1 + G L) x = (d, q)."""
    m_dd, m_dq = 1.0 + G.dd * L.dd + G.dq * L.dq, G.dd * L.dq + G.dq * L.qq
    m_qd, m_qq = G.dq * L.dd + G.qq * L.dq, 1.0 + G.dq * L.dq + G.qq * L.qq
    per = 1.0 / (m_dd * m_qq - m_dq * m_qd)
    return (m_qq * d - m_dq * q) * per, (m_dd * q - m_qd * d) * per


@njit
def series_resistance(asymmetry: Asymmetry | None) -> float:
    """Return the largest resistance that a current meets in series with the phases."""
    if asymmetry is None:
        return 0.0
    return asymmetry.R + math.sqrt(asymmetry.R_alpha**2 + asymmetry.R_beta**2)


@njit
def asymmetric_turning(asymmetry: Asymmetry | None) -> float:
    """Return the periods of the asymmetry in an electrical one."""
    return 0.0 if asymmetry is None else 2.0


@njit
def loss_in_series(
    asymmetry: Asymmetry | None, i_d: float, i_q: float, cos_theta: float, sin_theta: float
) -> float:
    """Return the power that is lost in series with the phases, in W."""
    if asymmetry is None:
        return 0.0
    R, _ = _in_rotor_frame(asymmetry, cos_theta, sin_theta)
    return 1.5 * (R.dd * i_d * i_d + 2.0 * R.dq * i_d * i_q + R.qq * i_q * i_q)


@njit
def leakage_energy(
    asymmetry: Asymmetry | None, i_d: float, i_q: float, cos_theta: float, sin_theta: float
) -> float:
    """Return the energy that is stored in series with the phases, in J."""
    if asymmetry is None:
        return 0.0
    _, L = _in_rotor_frame(asymmetry, cos_theta, sin_theta)
    return 0.75 * (L.dd * i_d * i_d + 2.0 * L.dq * i_d * i_q + L.qq * i_q * i_q)
