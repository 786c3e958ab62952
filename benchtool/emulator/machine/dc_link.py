"""The dc link as a capacitor: what feeds it, what is drawn from it, and a chopper that burns the surplus.

    C du/dt = max(u_s - u, 0) / R - i_legs - u / R_chopper (while the chopper is on)

The supply is a rectifier of voltage u_s behind R: it feeds and never takes back. Over a control period u_s
and the mean current of the legs are constant, for which the equation has a closed form on either side of u_s.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import njit

_NEVER = math.inf


class DcLink(NamedTuple):
    """Capacitor, ripple of the supply, and brake chopper; `G_chopper` is zero without one."""

    C: float
    ripple: float
    omega_ripple: float
    chopper_on: float
    chopper_off: float
    G_chopper: float


@njit
def supplied(
    link: DcLink | None, shaft: Any, u_s: float, R: float, charge: float, time: float, T_s: float
) -> float:
    """Return the voltage of the dc link after a control period that began at `time` and drew this charge.

    Without a capacitor it is what the mean current leaves of the supply's.
    """
    if link is None:
        return u_s - R * charge / T_s
    u_s += link.ripple * math.sin(link.omega_ripple * (time + 0.5 * T_s))
    if shaft.u_dc > link.chopper_on:
        shaft.chopper = 1
    elif shaft.u_dc < link.chopper_off:
        shaft.chopper = 0
    G = link.G_chopper if shaft.chopper != 0 else 0.0
    return charged(link.C, shaft.u_dc, u_s, 1.0 / R, G, charge / T_s, T_s)


@njit
def charged(
    C: float, u: float, u_s: float, G_supply: float, G: float, current: float, duration: float
) -> float:
    """Return voltage of the capacitor after `duration`, from `u`, with conductances of supply and chopper."""
    left = duration
    for _ in range(3):  # it passes u_s once at most, and comes to it without passing
        feeds = u < u_s or (u == u_s and G * u_s + current > 0.0)
        G_now = G + G_supply if feeds else G
        drive = (G_supply * u_s if feeds else 0.0) - current
        passes = _passes(C, u, u_s, G_now, drive)
        if not passes < left:
            return max(_after(C, u, G_now, drive, left), 0.0)
        u = u_s
        left -= passes
    return u


@njit
def _after(C: float, u: float, G: float, drive: float, time: float) -> float:
    """Return the solution of C du/dt = drive - G u."""
    if G * time < 1e-9 * C:
        return u + (drive - G * u) * time / C
    final = drive / G
    return final + (u - final) * math.exp(-G * time / C)


@njit
def _passes(C: float, u: float, level: float, G: float, drive: float) -> float:
    """Return when that solution passes a level; never if it starts there or does not."""
    slope = drive - G * u
    if u == level or slope * (level - u) <= 0.0:
        return _NEVER
    if abs(G * (level - u)) < 1e-9 * abs(slope):
        return C * (level - u) / slope
    if (drive - G * level) * slope <= 0.0:
        return _NEVER
    return -C / G * math.log((drive - G * level) / slope)
