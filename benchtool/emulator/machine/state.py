"""The machine's state, and its electrical states: currents, or flux linkages where it saturates."""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.drive_train import Far
from benchtool.emulator.machine.saturation import Flux, Saturation, currents_of, flux_at

NO_FLUX = Flux(0.0, 0.0)  # of a machine that does not saturate


class State(NamedTuple):
    """Currents, electrical speed and angle; `theta_e` never wraps, `theta_rest` is its rounding.

    `far` is the load side and `flux` the flux linkages of a machine that saturates, from which its currents
    follow; both are carried along untouched where they are no states.
    """

    i_d: float
    i_q: float
    omega_e: float
    theta_e: float
    theta_rest: float
    cos_theta: float
    sin_theta: float
    far: Far
    flux: Flux


@njit
def place(i_d: float, i_q: float, omega_e: float, theta_e: float, flux: Flux = NO_FLUX) -> State:
    """Return the state with its direction derived from the angle, and the load side at rest."""
    far = Far(0.0, 0.0, 0.0)
    return State(i_d, i_q, omega_e, theta_e, 0.0, math.cos(theta_e), math.sin(theta_e), far, flux)


@njit
def facing(x: State, far: Far) -> State:
    """Return the state with another load side."""
    return State(x.i_d, x.i_q, x.omega_e, x.theta_e, x.theta_rest, x.cos_theta, x.sin_theta, far, x.flux)


@njit
def stationary_currents(x: State) -> tuple[float, float]:
    """Return i_alpha and i_beta."""
    return x.i_d * x.cos_theta - x.i_q * x.sin_theta, x.i_d * x.sin_theta + x.i_q * x.cos_theta


@njit
def electrical(saturation: Saturation | None, x: State) -> tuple[float, float]:
    """Return the electrical states of `x`."""
    if saturation is None:
        return x.i_d, x.i_q
    return x.flux.psi_d, x.flux.psi_q


@njit
def state_at(
    saturation: Saturation | None,
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    theta_rest: float,
    cos_theta: float,
    sin_theta: float,
    far: Far,
) -> State:
    """Return the state with these electrical states."""
    i_d, i_q = currents_of(saturation, y_d, y_q)
    flux = _flux_linkages(saturation, y_d, y_q)
    return State(i_d, i_q, omega_e, theta_e, theta_rest, cos_theta, sin_theta, far, flux)


@njit
def _flux_linkages(saturation: Saturation | None, psi_d: float, psi_q: float) -> Flux:
    if saturation is None:
        return Flux(0.0, 0.0)
    return Flux(psi_d, psi_q)


@njit
def with_currents(saturation: Saturation | None, x: State, i_d: float, i_q: float) -> State:
    """Return the state with these currents instead of its own."""
    flux = flux_of(saturation, i_d, i_q, x.flux)
    return State(i_d, i_q, x.omega_e, x.theta_e, x.theta_rest, x.cos_theta, x.sin_theta, x.far, flux)


@njit
def flux_of(saturation: Saturation | None, i_d: float, i_q: float, guess: Flux) -> Flux:
    """Return the flux linkages of these currents, where the machine saturates; else `guess`."""
    if saturation is None:
        return guess
    return flux_at(saturation, i_d, i_q, guess)
