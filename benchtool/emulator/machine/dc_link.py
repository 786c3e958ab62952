"""The dc link as a capacitor: what feeds it, what is drawn from it, and a chopper that burns the surplus.

    C du/dt = max(u_s - u, 0) / R - i_legs - u / R_chopper (while the chopper is on)

The supply is a rectifier of voltage u_s behind R: it feeds and never takes back. Over a control period u_s
and the current of the legs are constant, for which the equation has a closed form on either side of u_s. That
current is the one that takes from the capacitor the energy which the legs took.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.energies import Accounts

_NEVER = math.inf
_SMALL = 0.01  # of a time in time constants, below which a series is the more exact
_SEVENTH = 31.0 / 2520.0  # of its coefficients
_SECANTS = 12
_CLOSE, _NEARLY = 1e-13, 1e-6
_HALVINGS = 60


class DcLink(NamedTuple):
    """Capacitor, ripple of the supply, and brake chopper; `G_chopper` is zero without one."""

    C: float
    ripple: float
    omega_ripple: float
    chopper_on: float
    chopper_off: float
    G_chopper: float


class Charged(NamedTuple):
    """What a time did to the capacitor: its voltage then, the integral of that in Vs, the charge that the
    supply fed in As, and what was lost in its resistance and burnt by the chopper in J."""

    u: float
    area: float
    fed: float
    lost: float
    burnt: float


@njit
def supplied(
    link: DcLink | None,
    accounts: Accounts | None,
    shaft: Any,
    u_s: float,
    R: float,
    charge: float,
    energy: float,
    time: float,
    T_s: float,
    record: Any,
) -> float:
    """Return the voltage of the dc link after a control period that began at `time`.

    The legs drew `charge` from it, or by the energy accounts, if they are kept, `energy`. Without a capacitor
    the voltage is what the mean current leaves of the supply's.
    """
    energy = _drawn(accounts, shaft.u_dc * charge, energy)
    if link is None:
        charge = _of_energy(accounts, energy, shaft.u_dc, charge)
        if R > 0.0:
            _book(accounts, record, u_s * charge, u_s * charge - energy, 0.0, 0.0)
        else:
            _book(accounts, record, energy, 0.0, 0.0, 0.0)
        return u_s - R * charge / T_s
    if link.ripple != 0.0:
        u_s += link.ripple * math.sin(link.omega_ripple * (time + 0.5 * T_s))
    if shaft.u_dc > link.chopper_on:
        shaft.chopper = 1
    elif shaft.u_dc < link.chopper_off:
        shaft.chopper = 0
    G = link.G_chopper if shaft.chopper != 0 else 0.0
    after = giving(link.C, shaft.u_dc, u_s, 1.0 / R, G, energy, T_s)
    stored = 0.5 * link.C * (after.u - shaft.u_dc) * (after.u + shaft.u_dc)
    _book(accounts, record, u_s * after.fed, after.lost, after.burnt, stored)
    return after.u


@njit
def _drawn(accounts: Accounts | None, by_charge: float, booked: float) -> float:
    return by_charge if accounts is None else booked


@njit
def _of_energy(accounts: Accounts | None, energy: float, u: float, charge: float) -> float:
    if accounts is None:
        return charge
    return energy / u if u > 0.0 else charge


@njit
def _book(
    accounts: Accounts | None, record: Any, drawn: float, lost: float, burnt: float, stored: float
) -> None:
    if accounts is None:
        return
    record.E_supply += drawn
    record.E_link_resistance += lost
    record.E_chopper += burnt
    record.E_capacitor += stored


@njit
def giving(
    C: float, u: float, u_s: float, G_supply: float, G: float, energy: float, duration: float
) -> Charged:
    """Return what happens to the capacitor while the legs take `energy` from it by a constant current.

    The legs took their charge at the voltage of the period's beginning, the capacitor gives it at the voltage
    that it has meanwhile. The current by which both are the same energy solves a quadratic equation where
    nothing but the current changes; where the voltage passes that of the supply secants find it.
    """
    if u == u_s:
        return _giving_across(C, u, u_s, G_supply, G, energy, duration)
    G_feeding = G_supply if u < u_s else 0.0
    integrals = _integrals((G + G_feeding) / C, duration)
    softness = -integrals[1] / C
    idle = u * duration + (G * u - G_feeding * (u_s - u)) * softness  # the area without a current
    square = idle * idle + 4.0 * softness * energy
    if idle > 0.0 and square >= 0.0:
        i = 2.0 * energy / (idle + math.sqrt(square))
        after = _between(C, u, u_s, G_feeding, G, i, duration, integrals)
        if after.u >= 0.0 and (after.u - u_s) * (u - u_s) >= 0.0:
            return after
    return _giving_across(C, u, u_s, G_supply, G, energy, duration)


@called
def _giving_across(
    C: float, u: float, u_s: float, G_supply: float, G: float, energy: float, duration: float
) -> Charged:
    """Return `giving` by secants, of a voltage that may pass the supply's; of more energy than the capacitor
    holds, and is fed, no current is that, and it is empty then."""
    i0 = 0.0 if u == 0.0 else energy / (u * duration)
    after = charged(C, u, u_s, G_supply, G, i0, duration)
    f0 = i0 * after.area - energy
    i = energy / after.area if after.area > 0.0 else i0
    for _ in range(_SECANTS):
        if abs(f0) <= _CLOSE * abs(energy) or i == i0:
            break
        after = charged(C, u, u_s, G_supply, G, i, duration)
        f = i * after.area - energy
        following = i - f * (i - i0) / (f - f0) if f != f0 else i
        i0, f0, i = i, f, following
    if abs(f0) <= _NEARLY * abs(energy):
        return after
    return _emptied(C, u, u_s, G_supply, G, duration)


@njit
def _emptied(C: float, u: float, u_s: float, G_supply: float, G: float, duration: float) -> Charged:
    """Return what the least current that empties the capacitor within `duration` does to it."""
    least, most = 0.0, (C * u + G_supply * u_s * duration) / duration  # its charge, and all that it is fed
    for _ in range(_HALVINGS):
        i = 0.5 * (least + most)
        if charged(C, u, u_s, G_supply, G, i, duration).u > 0.0:
            least = i
        else:
            most = i
    return charged(C, u, u_s, G_supply, G, most, duration)


@called
def charged(
    C: float, u: float, u_s: float, G_supply: float, G: float, current: float, duration: float
) -> Charged:
    """Return what `duration` does to the capacitor, from `u`, with conductances of supply and chopper."""
    left = duration
    area, fed, lost, burnt = 0.0, 0.0, 0.0, 0.0
    for _ in range(3):  # it passes u_s once at most, and comes to it without passing
        feeds = u < u_s or (u == u_s and G * u_s + current > 0.0)
        G_feeding = G_supply if feeds else 0.0
        G_now = G + G_feeding
        passes = _passes(C, u, u_s, G_now, G_feeding * u_s - current - G_now * u)
        time = min(passes, left)
        part = _between(C, u, u_s, G_feeding, G, current, time, _integrals(G_now / C, time))
        area, fed, lost, burnt = area + part.area, fed + part.fed, lost + part.lost, burnt + part.burnt
        if not passes < left:
            return Charged(max(part.u, 0.0), area, fed, lost, burnt)
        u = u_s
        left -= passes
    return Charged(u, area, fed, lost, burnt)


@njit
def _between(
    C: float,
    u: float,
    u_s: float,
    G_feeding: float,
    G: float,
    current: float,
    time: float,
    integrals: tuple[float, float, float],
) -> Charged:
    """Return what `time` does to the capacitor on one side of the supply's voltage, with `_integrals`."""
    by_slope, of_slope, squared = integrals
    rate = (G_feeding * (u_s - u) - G * u - current) / C
    # Of u(t) - u, its integral and the integral of its square.
    above = u_s - u
    return Charged(
        u + rate * by_slope,
        u * time + rate * of_slope,
        G_feeding * (above * time - rate * of_slope),
        G_feeding * (above * above * time - 2.0 * above * rate * of_slope + rate * rate * squared),
        G * (u * u * time + 2.0 * u * rate * of_slope + rate * rate * squared),
    )


@njit
def _integrals(a: float, time: float) -> tuple[float, float, float]:
    """Return m = (1 - exp(-a t)) / a at this time, its integral from 0 on, and the integral of its square."""
    z = a * time
    if z < _SMALL:
        t2 = time * time
        return (
            time * (1.0 - z * (1.0 / 2.0 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0))))),
            t2 * (1.0 / 2.0 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0))))),
            t2 * time * (1.0 / 3.0 - z * (1.0 / 4.0 - z * (7.0 / 60.0 - z * (1.0 / 24.0 - z * _SEVENTH)))),
        )
    m = -math.expm1(-z)
    m2 = m * (1.0 - 0.5 * m)  # (1 - exp(-2 z)) / 2
    return m / a, (z - m) / (a * a), (z - 2.0 * m + m2) / (a * a * a)


@njit
def _passes(C: float, u: float, level: float, G: float, slope: float) -> float:
    """Return when the voltage passes a level, of conductances G and with C du/dt = `slope` at first; never if
    it starts there or does not."""
    if u == level or slope * (level - u) <= 0.0:
        return _NEVER
    z = G * (level - u) / slope
    if not z < 1.0:
        return _NEVER
    if z == 0.0:
        return C * (level - u) / slope
    return -C / G * math.log1p(-z)
