"""Torque and flux references within the limits of voltage and current, for every law.

In the plane of the currents the voltage allows an ellipse and the trip level a circle. A torque whose point
of least current lies within both stays as it is. Otherwise i_d is lowered at the same torque until the
voltage suffices (field weakening), and where no i_d does, the torque itself is: to the largest within both.

Where the torque is negative the machine is mirrored, so that below i_q >= 0 and braking has omega_e < 0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.control.flux import least_current, magnitude, most_torque, operating_point
from benchtool.emulator.jit import njit

_ROUNDS = 20  # of Newton's method at most
_HALVINGS = 30  # of an interval of currents: the current to 1e-9 of the limit
_EXACT = 1e-12  # square of the relative step that ends it; the next would be of its square


class Limits(NamedTuple):
    """Limits of a law: the mean voltage available, and the magnitude of the current, peak."""

    u: float
    i: float


class Reference(NamedTuple):
    """Torque and stator flux asked of a law, and whether a setpoint had to give way to a limit."""

    torque: float
    psi_s: float
    clipped: bool


@njit
def reference(torque: float, i_d_added: float, omega_e: float, limits: Limits, drive: Any) -> Reference:
    """Return the nearest torque within the limits, and the flux with which it needs the least current there.

    A setpoint of the flux is kept as far as the limits let it; `i_d_added` moves the flux to where i_d is so
    much more at the same torque.
    """
    psi_r, saliency = float(drive.psi_r), float(drive.L_q) - float(drive.L_d)
    clipped = False
    if drive.psi_s_command > 0.0:
        psi_d, psi_q, clipped = operating_point(torque, float(drive.psi_s_command), drive)
        i_d, i_q = (psi_d - psi_r) / float(drive.L_d), psi_q / float(drive.L_q)
    else:
        i_d, i_q = least_current(torque, drive)
    if i_d_added != 0.0:
        moved = i_d + i_d_added
        i_d, i_q = moved, i_q * (psi_r - saliency * i_d) / (psi_r - saliency * moved)
    exceeded = (
        i_d * i_d + i_q * i_q > limits.i * limits.i or _excess(i_d, i_q, omega_e, limits.u, drive) > 0.0
    )
    if exceeded:
        side = -1.0 if torque < 0.0 else 1.0
        i_d, i_q, given_way = _within(i_d, side * i_q, side * omega_e, limits, drive)
        i_q *= side
        clipped = clipped or given_way or drive.psi_s_command > 0.0
    if clipped:
        torque = 1.5 * drive.pole_pairs * i_q * (psi_r - saliency * i_d)
    return Reference(torque, magnitude(i_d, i_q, drive), clipped)


@njit
def _excess(i_d: float, i_q: float, omega_e: float, u: float, drive: Any) -> float:
    """|u_s|^2 in the steady state of these currents, less that of the limit; (1) in the rotor's frame."""
    R = float(drive.R_s)
    u_d = R * i_d - omega_e * float(drive.L_q) * i_q
    u_q = R * i_q + omega_e * (float(drive.psi_r) + float(drive.L_d) * i_d)
    return u_d * u_d + u_q * u_q - u * u


@njit
def _within(i_d: float, i_q: float, omega_e: float, limits: Limits, drive: Any) -> tuple[float, float, bool]:
    """Return the currents within the limits in place of (i_d, i_q >= 0), and whether torque or flux had to
    give way."""
    given_way = False
    if i_d * i_d + i_q * i_q > limits.i * limits.i:
        i_d, i_q = _within_current(i_d, i_q, limits.i, drive)
        given_way = True
    if _excess(i_d, i_q, omega_e, limits.u, drive) <= 0.0:
        return i_d, i_q, given_way
    weak_d, weak_q, found = _weakened(i_d, i_q, omega_e, limits.u, drive)
    if found and weak_d * weak_d + weak_q * weak_q <= limits.i * limits.i:
        return weak_d, weak_q, given_way
    i_d, i_q = _most_torque(omega_e, limits, drive)
    return i_d, i_q, True


@njit
def _within_current(i_d: float, i_q: float, i: float, drive: Any) -> tuple[float, float]:
    """Return the currents of magnitude `i` towards those of least current at the same torque, or the most
    torque."""
    psi_r, saliency = float(drive.psi_r), float(drive.L_q) - float(drive.L_d)
    a = i_q * (psi_r - saliency * i_d)
    inside, _ = least_current(1.5 * drive.pole_pairs * a, drive)
    i_q = a / (psi_r - saliency * inside)
    if inside * inside + i_q * i_q > i * i:
        return most_torque(i, drive)
    outside = i_d
    for _ in range(_HALVINGS):
        i_d = 0.5 * (inside + outside)
        i_q = a / (psi_r - saliency * i_d)
        if i_d * i_d + i_q * i_q > i * i:
            outside = i_d
        else:
            inside = i_d
    return inside, a / (psi_r - saliency * inside)


@njit
def _weakened(i_d: float, i_q: float, omega_e: float, u: float, drive: Any) -> tuple[float, float, bool]:
    """Return the currents of the same torque at which the voltage just suffices, and whether there are any.

    At a torque |u_s|^2 is convex in i_d: from the right, Newton's method does not overshoot the larger root.
    """
    R, L_d, L_q, psi_r = float(drive.R_s), float(drive.L_d), float(drive.L_q), float(drive.psi_r)
    a = i_q * (psi_r - (L_q - L_d) * i_d)
    square = omega_e * omega_e
    for _ in range(_ROUNDS):
        active = psi_r - (L_q - L_d) * i_d  # T = 3/2 p i_q times this
        if active <= 0.0:
            return i_d, i_q, False
        i_q = a / active
        growth = i_q * i_q * (L_q - L_d) / active  # i_q di_q/di_d
        slope = 2.0 * (R * R * (i_d + growth) + square * (L_d * (psi_r + L_d * i_d) + L_q * L_q * growth))
        if slope <= 0.0:
            return i_d, i_q, False
        step = _excess(i_d, i_q, omega_e, u, drive) / slope
        i_d -= step
        if step * step <= _EXACT * (i_d * i_d):
            return i_d, a / (psi_r - (L_q - L_d) * i_d), True
    return i_d, i_q, False


@njit
def _most_torque(omega_e: float, limits: Limits, drive: Any) -> tuple[float, float]:
    """Return the currents of the most torque on the edge of the voltage, at most `limits.i` in magnitude.

    From where the edge begins to the left the torque rises, up to where the current is at its limit or the
    torque at its largest (maximum torque per volt). Where even the edge's beginning needs too much current
    the flux is as low as the current makes it.
    """
    R, L_d, L_q, psi_r = float(drive.R_s), float(drive.L_d), float(drive.L_q), float(drive.psi_r)
    saliency = L_q - L_d
    square = omega_e * omega_e
    # |u_s|^2 = u^2 as a i_q^2 + 2 b i_q + c = 0 with b linear and c quadratic in i_d; the edge begins where
    # its two i_q become one.
    a = R * R + square * L_q * L_q
    det = R * R + square * L_d * L_q
    middle = -omega_e * omega_e * psi_r * (a * L_d + R * R * saliency) / (det * det)
    rest = (a * limits.u * limits.u - square * psi_r * psi_r * square * L_q * L_q) / (det * det)
    reach = middle * middle + rest
    unlimited, _ = most_torque(limits.i, drive)
    right = min(middle + math.sqrt(max(reach, 0.0)), unlimited)
    left = -limits.i
    if reach <= 0.0 or right <= left:
        return left, 0.0
    best_d, best_q = left, -1.0
    for _ in range(_HALVINGS):
        i_d = 0.5 * (left + right)
        psi_d = psi_r + L_d * i_d
        b = omega_e * R * (psi_d - L_q * i_d)
        c = R * R * i_d * i_d + square * psi_d * psi_d - limits.u * limits.u
        root = math.sqrt(max(b * b - a * c, 0.0))
        i_q = (root - b) / a
        # dT/di_d along the edge, times what is positive there
        across = i_d * R * R + square * L_d * psi_d - omega_e * R * saliency * i_q
        rises = (psi_r - saliency * i_d) * across + saliency * i_q * root
        if i_d * i_d + i_q * i_q <= limits.i * limits.i and rises > 0.0:
            right, best_d, best_q = i_d, i_d, i_q
        else:
            left = i_d
    if best_q < 0.0:
        return _along_circle(omega_e, limits, unlimited, drive)
    return best_d, best_q


@njit
def _along_circle(omega_e: float, limits: Limits, right: float, drive: Any) -> tuple[float, float]:
    """Return the currents of the limit's magnitude: from i_d alone towards the most torque, up to the edge.

    If not even i_d alone is within the voltage, i_d alone is returned: the lowest flux that the current
    allows.
    """
    left = -limits.i
    for _ in range(_HALVINGS):
        i_d = 0.5 * (left + right)
        i_q = math.sqrt(limits.i * limits.i - i_d * i_d)
        if _excess(i_d, i_q, omega_e, limits.u, drive) > 0.0:
            right = i_d
        else:
            left = i_d
    return left, math.sqrt(max(limits.i * limits.i - left * left, 0.0))
