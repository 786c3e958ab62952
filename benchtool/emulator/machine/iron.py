"""Iron loss, an optional part of the machine: a torque that brakes the rotor.

A resistance R_fe across the EMF takes P = 3/2 |omega_e psi_s|^2 / R_fe. In steady state its current is one
that makes no torque, so that for the current at the terminals it is the torque P / omega_m against the
rotation: which is also what a machine with open terminals is braked by. Eddy currents lose power in this
proportion; hysteresis, and what the ripple of the current loses, are not in it.
"""

from __future__ import annotations

from typing import NamedTuple

from benchtool.emulator.jit import njit


class Iron(NamedTuple):
    """Conductance across the EMF, 1 / R_fe."""

    G: float


@njit
def iron_torque(iron: Iron | None, psi_d: float, psi_q: float, omega_e: float, p: float) -> float:
    """Return the braking torque of iron loss, in Nm."""
    if iron is None:
        return 0.0
    return 1.5 * p * omega_e * (psi_d * psi_d + psi_q * psi_q) * iron.G


@njit
def less_iron(
    iron: Iron | None, domega: float, psi_d: float, psi_q: float, omega_e: float, p: float, gamma: float
) -> float:
    """Return the rate of the speed, less that of iron loss; `gamma` is the gain of a torque, p / J."""
    if iron is None:
        return domega
    return domega - gamma * iron_torque(iron, psi_d, psi_q, omega_e, p)


@njit
def iron_slope(iron: Iron | None, psi: float, p: float) -> float:
    """Return the slope of the torque over omega_e, in Nms/rad, with a flux linkage of `psi`."""
    return 0.0 if iron is None else 1.5 * p * psi * psi * iron.G
