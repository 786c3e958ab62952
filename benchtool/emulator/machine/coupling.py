"""An elastic coupling between rotor and load, with play: an optional part of the drive train.

    T = c twist + d slip        twist = theta_m - theta_load, slip = its rate

With play the coupling has faces that push and never pull. They meet where the twist comes to half of the play
to either side; from there on they are a spring and a damper, until what these push with is zero. Which faces
touch is fixed within a step of the integration, and a step ends where that changes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit

_BEYOND = 1e-6  # part of a step by which it goes on after faces part, so that they have parted


class Play(NamedTuple):
    """Half of the angle by which the coupling turns freely, in rad."""

    half: float


class Coupling(NamedTuple):
    """Stiffness in Nm/rad, damping in Nms/rad, and 1 / J of the load, which is zero while that is held."""

    stiffness: float
    damping: float
    inv_J: float
    play: Play | None


@njit
def coupling_torque(coupling: Coupling | None, twist: float, slip: float, contact: float) -> float:
    """Return the torque that the rotor passes on to the load; faces touch on the side `contact`."""
    if coupling is None:
        return 0.0
    return _torque(coupling.play, coupling, twist, slip, contact)


@njit
def _torque(play: Play | None, coupling: Coupling, twist: float, slip: float, contact: float) -> float:
    if play is None:
        return coupling.stiffness * twist + coupling.damping * slip
    if contact == 0.0:
        return 0.0
    return coupling.stiffness * (twist - contact * play.half) + coupling.damping * slip


@njit
def damped_power(coupling: Coupling, slip: float, contact: float) -> float:
    """Return the power that the damping takes; faces touch on the side `contact`."""
    return _damped(coupling.play, coupling, slip, contact)


@njit
def _damped(play: Play | None, coupling: Coupling, slip: float, contact: float) -> float:
    if play is None:
        return coupling.damping * slip * slip
    return coupling.damping * slip * slip if contact != 0.0 else 0.0


@njit
def twist_energy(play: Play | None, coupling: Coupling, twist: float, contact: float) -> float:
    """Return the energy of the spring in J; faces touch on the side `contact`."""
    if play is None:
        return 0.5 * coupling.stiffness * twist * twist
    if contact == 0.0:
        return 0.0
    bent = twist - contact * play.half
    return 0.5 * coupling.stiffness * bent * bent


@njit
def contact_side(coupling: Coupling | None, twist: float, slip: float) -> float:
    """Return the side on which faces touch, 1 or -1, and 0 where none do, or where there is no play."""
    if coupling is None:
        return 0.0
    return _contact(coupling.play, coupling, twist, slip)


@njit
def _contact(play: Play | None, coupling: Coupling, twist: float, slip: float) -> float:
    if play is None:
        return 0.0
    side = math.copysign(1.0, twist)
    depth, pushes = _met(play, coupling, twist, slip, side)
    if depth < 0.0 or pushes < 0.0 or (pushes == 0.0 and side * slip <= 0.0):
        return 0.0
    return side


@njit
def _met(play: Play, coupling: Coupling, twist: float, slip: float, side: float) -> tuple[float, float]:
    """Return how far the faces of a side are into each other, and what they push with if they touch."""
    depth = side * twist - play.half
    return depth, coupling.stiffness * depth + coupling.damping * side * slip


class Meeting(NamedTuple):
    """What is zero where faces meet or part: of a side, their depth, or what they push with."""

    side: float
    by_depth: bool
    happens: bool


@njit
def meeting(
    play: Play,
    coupling: Coupling,
    twist0: float,
    slip0: float,
    twist1: float,
    slip1: float,
    contact: float,
) -> Meeting:
    """Return what happens first to the faces in a step from one twist and slip to the other."""
    if contact != 0.0:
        _, pushes = _met(play, coupling, twist1, slip1, contact)
        return Meeting(contact, False, pushes < 0.0)
    side = math.copysign(1.0, twist1)
    depth0, _ = _met(play, coupling, twist0, slip0, side)
    depth1, pushes1 = _met(play, coupling, twist1, slip1, side)
    return Meeting(side, depth0 < 0.0, depth1 > 0.0 and (pushes1 > 0.0 or depth0 < 0.0))


@njit
def distance(play: Play, coupling: Coupling, what: Meeting, twist: float, slip: float) -> float:
    """Return what is zero where `what` happens."""
    depth, pushes = _met(play, coupling, twist, slip, what.side)
    return depth if what.by_depth else pushes


@njit
def landed(play: Play, what: Meeting, twist: float) -> float:
    """Return the twist at the end of a step that `what` ends: faces that meet do so exactly."""
    return what.side * play.half if what.by_depth else twist


@njit
def part_until(what: Meeting, part: float) -> float:
    """Return the part of a step after which to end it; faces that part have done so by then."""
    if not what.by_depth:
        part += _BEYOND
    return min(max(part, _BEYOND), 1.0)


@njit
def coupling_rate(coupling: Coupling | None, inv_J: float) -> float:
    """Return a bound of the rate of the coupling in 1/s, with 1 / J of the rotor."""
    if coupling is None:
        return 0.0
    both = inv_J + coupling.inv_J
    return math.sqrt(coupling.stiffness * both) + coupling.damping * both
