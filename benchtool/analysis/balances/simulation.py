"""A recorded run simulated again: currents by its voltages and angle, speed by its torque.

The machine of `flux_model` is integrated from the first measured state on, without looking at the measured
currents or speed again, so that what parameters miss adds up as it would in the machine. Where the drop of
dead time and devices would turn a phase current round within a tick, it holds it at zero instead.

With parameters that no machine has, such as a negative resistance, it may diverge: from a hundred times the
greatest measured value on it is undefined.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from benchtool.analysis.balances.flux_model import Electrical, Ticks, flux_of
from benchtool.analysis.balances.space_vectors import Complex, Floats, phase_values, space_vector

Shaped = TypeVar("Shaped", Complex, Floats)

_DIVERGED = 100.0  # times the greatest measured value
_HALF_ROOT_3 = 0.5 * math.sqrt(3.0)


def simulated_currents(ticks: Ticks, p: Electrical) -> Complex:
    """Return the current in the encoder's frame at the ticks, d real and q imaginary, as the sensors would
    read it, shape (n + 1,); nan from where it diverges on."""
    direction = ticks.direction(p)
    i_s = complex(ticks.currents(p)[0])
    psi_s = complex((direction[:1] * flux_of(np.array([i_s]) * np.conj(direction[:1]), p))[0])
    offset = p.u_alpha_offset + 1j * p.u_beta_offset
    given_Vs = (ticks.T_s * (ticks.u_s - offset)).tolist()
    L, resistance = 0.5 * (p.L_d + p.L_q), p.R_s * ticks.T_s
    drop_Vs = p.dead_time_voltage * ticks.T_s
    found, most_A = [i_s], _DIVERGED * float(np.max(np.abs(ticks.currents(p))))
    for given, rotor in zip(given_Vs, direction[1:].tolist(), strict=True):
        free = _current(psi_s + given - resistance * i_s, rotor, p)
        driven = given - drop_Vs * _signs(0.5 * (i_s + free), abs(drop_Vs) / L) if drop_Vs else given
        after = _current(psi_s + driven - resistance * i_s, rotor, p)
        psi_s += driven - 0.5 * resistance * (i_s + after)
        i_s = _current(psi_s, rotor, p)
        if not abs(i_s) <= most_A:
            break
        found.append(i_s)
    read = _as_read(_to_length(np.array(found), len(ticks.u_s) + 1), p)
    return np.asarray(read * np.conj(ticks.rotor))


def simulated_speed(
    torque_Nm: Floats, measured: Floats, T_s: float, J: float, friction: float, coulomb: float, load: float
) -> Floats:
    """Return the mechanical speed at the ticks by the torque at them, shape (n,), from the first `measured`
    one on; nan from where it diverges on."""
    omega_m, most = float(measured[0]), _DIVERGED * float(np.max(np.abs(measured)))
    found, held = [omega_m], coulomb * T_s / J
    for first, second in zip(torque_Nm[:-1].tolist(), torque_Nm[1:].tolist(), strict=True):
        free = omega_m + T_s / J * (0.5 * (first + second) - friction * omega_m - load)
        # dry friction takes what it can, and does not turn the shaft round
        omega_m = math.copysign(max(0.0, abs(free) - held), free)
        if not abs(omega_m) <= most:
            break
        found.append(omega_m)
    return _to_length(np.array(found), len(torque_Nm))


def _to_length(found: Shaped, count: int) -> Shaped:
    """Return values of a simulation with nan in place of those that it did not reach, shape (count,)."""
    return np.pad(found, (0, count - len(found)), constant_values=math.nan)


def _current(psi_s: complex, rotor: complex, p: Electrical) -> complex:
    psi = psi_s * rotor.conjugate()
    return complex((psi.real - p.psi_r) / p.L_d, psi.imag / p.L_q) * rotor


def _signs(i_s: complex, width: float) -> complex:
    """Return the vector of the signs of the phase currents, less where one is within `width` of zero."""
    across = _HALF_ROOT_3 * i_s.imag
    a, b, c = (
        max(-1.0, min(1.0, i / width)) for i in (i_s.real, across - 0.5 * i_s.real, -across - 0.5 * i_s.real)
    )
    return complex((2.0 * a - b - c) / 3.0, (b - c) / (2.0 * _HALF_ROOT_3))


def _as_read(i_s: Complex, p: Electrical) -> Complex:
    """Return the current that sensors with these gains read."""
    return space_vector(phase_values(i_s) * p.gains)
