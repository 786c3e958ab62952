"""Harmonics of the rotor flux, an optional part of the machine.

The fifth and eleventh turn backwards, the seventh and thirteenth forwards, such as psi_5 exp(-j 5 theta) and
psi_7 exp(j 7 theta), so in d/q they turn at 6 and 12 theta_e. Phases that link the magnets differently add a
flux that turns backwards with the rotor, at 2 theta_e in d/q. The torque of all of them is the one that
conserves energy: the currents times the slope of the flux over the angle.
"""

from __future__ import annotations

from typing import NamedTuple

from benchtool.emulator.jit import called, njit


class Unbalance(NamedTuple):
    """Flux psi exp(-j theta) of phases that link the magnets differently: its vector at theta 0, in Wb."""

    psi_alpha: float
    psi_beta: float


class Harmonics(NamedTuple):
    """Flux linkage of phase a, as cosines of 5, 7, 11 and 13 theta_e, in Wb."""

    psi_5: float
    psi_7: float
    psi_11: float
    psi_13: float
    unbalance: Unbalance | None


@njit
def with_harmonic_emf(
    harmonics: Harmonics | None,
    dy_d: float,
    dy_q: float,
    omega_e: float,
    g_d: float,
    g_q: float,
    inv_L_d: float,
    inv_L_q: float,
) -> tuple[float, float]:
    """Return the rates of the currents, with the EMF of harmonics of this slope."""
    if harmonics is None:
        return dy_d, dy_q
    return dy_d - omega_e * g_d * inv_L_d, dy_q - omega_e * g_q * inv_L_q


@njit
def with_harmonic_torque(
    harmonics: Harmonics | None,
    torque: float,
    i_d: float,
    i_q: float,
    g_d: float,
    g_q: float,
    per_flux: float,
) -> float:
    """Return the torque, or what is proportional to it, with that of harmonics of this slope; `per_flux` is
    its gain, 3/2 p."""
    if harmonics is None:
        return torque
    return torque + per_flux * (g_d * i_d + g_q * i_q)


@njit
def flux_slope(harmonics: Harmonics | None, cos_theta: float, sin_theta: float) -> tuple[float, float]:
    """Return the change of the harmonics' flux with theta_e, in d/q, in Wb/rad."""
    return (0.0, 0.0) if harmonics is None else _slope(harmonics, cos_theta, sin_theta)


@njit
def _multiples(c: float, s: float) -> tuple[float, float, float, float, float, float]:
    """Return cosine and sine of twice, six and twelve times an angle."""
    c_2, s_2 = c * c - s * s, 2.0 * s * c
    c_4, s_4 = c_2 * c_2 - s_2 * s_2, 2.0 * s_2 * c_2
    c_6, s_6 = c_4 * c_2 - s_4 * s_2, s_4 * c_2 + c_4 * s_2
    return c_2, s_2, c_6, s_6, c_6 * c_6 - s_6 * s_6, 2.0 * s_6 * c_6


@called
def _slope(harmonics: Harmonics, c: float, s: float) -> tuple[float, float]:
    c_2, s_2, c_6, s_6, c_12, s_12 = _multiples(c, s)
    back_5, back_11 = 5.0 * harmonics.psi_5, 11.0 * harmonics.psi_11
    forth_7, forth_13 = 7.0 * harmonics.psi_7, 13.0 * harmonics.psi_13
    g_d = -(back_5 + forth_7) * s_6 - (back_11 + forth_13) * s_12
    g_q = (forth_7 - back_5) * c_6 + (forth_13 - back_11) * c_12
    return _with_unbalance(harmonics.unbalance, g_d, g_q, c_2, s_2)


@njit
def with_harmonic_slopes(
    harmonics: Harmonics | None, h_d: float, h_q: float, g_d: float, g_q: float, per_flux: float
) -> tuple[float, float]:
    """Return the changes of the torque, or of a number proportional to it, with i_d and i_q, with those of
    the torque of harmonics."""
    if harmonics is None:
        return h_d, h_q
    return h_d + per_flux * g_d, h_q + per_flux * g_q


@njit
def with_turning_torque(
    harmonics: Harmonics | None,
    torque: float,
    i_d: float,
    i_q: float,
    turn: float,
    cos_theta: float,
    sin_theta: float,
    per_flux: float,
) -> float:
    """Return the torque, or what is proportional to it, with what turning by a small angle `turn` adds to
    that of harmonics under these currents."""
    if harmonics is None:
        return torque
    k_d, k_q = _curvature(harmonics, cos_theta, sin_theta)
    return torque + per_flux * turn * (k_d * i_d + k_q * i_q)


@called
def _curvature(harmonics: Harmonics, c: float, s: float) -> tuple[float, float]:
    """Return the change of the slope with theta_e, in Wb/rad^2."""
    c_2, s_2, c_6, s_6, c_12, s_12 = _multiples(c, s)
    back_5, back_11 = 5.0 * harmonics.psi_5, 11.0 * harmonics.psi_11
    forth_7, forth_13 = 7.0 * harmonics.psi_7, 13.0 * harmonics.psi_13
    k_d = -6.0 * (back_5 + forth_7) * c_6 - 12.0 * (back_11 + forth_13) * c_12
    k_q = -6.0 * (forth_7 - back_5) * s_6 - 12.0 * (forth_13 - back_11) * s_12
    return _with_unbalance(harmonics.unbalance, k_d, k_q, -2.0 * s_2, 2.0 * c_2)


@njit
def _with_unbalance(
    unbalance: Unbalance | None, g_d: float, g_q: float, c_2: float, s_2: float
) -> tuple[float, float]:
    if unbalance is None:
        return g_d, g_q
    g_d += unbalance.psi_beta * c_2 - unbalance.psi_alpha * s_2
    g_q -= unbalance.psi_beta * s_2 + unbalance.psi_alpha * c_2
    return g_d, g_q


@njit
def weakened(harmonics: Harmonics | None, k: float) -> Harmonics | None:
    """Return the harmonics of magnets that have this part of their flux."""
    if harmonics is None:
        return harmonics
    h = harmonics
    unbalance = _weakened(h.unbalance, k)
    return Harmonics(k * h.psi_5, k * h.psi_7, k * h.psi_11, k * h.psi_13, unbalance)


@njit
def _weakened(unbalance: Unbalance | None, k: float) -> Unbalance | None:
    if unbalance is None:
        return unbalance
    return Unbalance(k * unbalance.psi_alpha, k * unbalance.psi_beta)


@njit
def linkage(harmonics: Harmonics | None) -> float:
    """Return the largest slope of the harmonics' flux over theta_e, in Wb."""
    if harmonics is None:
        return 0.0
    sixth = 5.0 * abs(harmonics.psi_5) + 7.0 * abs(harmonics.psi_7)
    twelfth = 11.0 * abs(harmonics.psi_11) + 13.0 * abs(harmonics.psi_13)
    return sixth + twelfth + _unbalanced_linkage(harmonics.unbalance)


@njit
def _unbalanced_linkage(unbalance: Unbalance | None) -> float:
    return 0.0 if unbalance is None else abs(unbalance.psi_alpha) + abs(unbalance.psi_beta)


@njit
def harmonic_turning(harmonics: Harmonics | None) -> float:
    """Return the periods of the fastest harmonic in an electrical one."""
    if harmonics is None:
        return 0.0
    return 12.0 if harmonics.psi_11 != 0.0 or harmonics.psi_13 != 0.0 else 6.0
