"""Harmonics of the rotor flux, an optional part of the machine.

The fifth turns backwards and the seventh forwards, psi_5 exp(-j 5 theta) + psi_7 exp(j 7 theta), so in d/q
both turn at 6 theta_e; their torque is the one that conserves energy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit


class Harmonics(NamedTuple):
    """Flux linkage of phase a, as cosines of 5 and 7 theta_e, in Wb."""

    psi_5: float
    psi_7: float


@njit
def with_harmonic_emf(
    harmonics: Harmonics | None,
    di_d: float,
    di_q: float,
    omega_e: float,
    theta_e: float,
    inv_L_d: float,
    inv_L_q: float,
) -> tuple[float, float]:
    """Return the rates of the currents, with the harmonics' EMF."""
    if harmonics is None:
        return di_d, di_q
    g_d, g_q = flux_slope(harmonics, theta_e)
    return di_d - omega_e * g_d * inv_L_d, di_q - omega_e * g_q * inv_L_q


@njit
def with_harmonic_torque(
    harmonics: Harmonics | None, torque: float, i_d: float, i_q: float, theta_e: float, per_flux: float
) -> float:
    """Return the torque, or what is proportional to it, with that of the harmonics; `per_flux` is its gain,
    3/2 p."""
    if harmonics is None:
        return torque
    g_d, g_q = flux_slope(harmonics, theta_e)
    return torque + per_flux * (g_d * i_d + g_q * i_q)


@njit
def flux_slope(harmonics: Harmonics, theta_e: float) -> tuple[float, float]:
    """Return the change of the harmonics' flux with theta_e, in d/q, in Wb/rad."""
    g_d = -(5.0 * harmonics.psi_5 + 7.0 * harmonics.psi_7) * math.sin(6.0 * theta_e)
    g_q = (7.0 * harmonics.psi_7 - 5.0 * harmonics.psi_5) * math.cos(6.0 * theta_e)
    return g_d, g_q


@njit
def linkage(harmonics: Harmonics | None) -> float:
    """Return the largest slope of the harmonics' flux over theta_e, in Wb."""
    if harmonics is None:
        return 0.0
    return 5.0 * abs(harmonics.psi_5) + 7.0 * abs(harmonics.psi_7)


@njit
def harmonic_turning(harmonics: Harmonics | None) -> float:
    """Return the periods of the fastest harmonic in an electrical one."""
    return 0.0 if harmonics is None else 6.0
