"""Flux linkage over current, from voltage pulses along both axes of the rotor.

Of a rotor that stands, or hardly moves within a pulse, the flux linkage is the integral of the voltage,

    psi(i) - psi(0) = integral of u - R_s i - V_drop s(i),

turned back by the angle that the rotor has moved meanwhile. Over the current of one axis it is

    psi_d - psi_r = i_d (c_0 + c_1 i_d + c_2 i_d^2),     psi_q = i_q (c_0 + c_2 i_q^2),

as the magnet makes the one axis lopsided and the other not. Its quotient by the current is the inductance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.vectors import drop_vector, vector_of
from benchtool.errors import AnalysisError

_FEWEST = 6
_MOVED_RAD = math.pi / 6.0
_CLEAR = 0.05  # of the largest current: below it the quotient by the current tells nothing


@dataclass(frozen=True)
class Pulse:
    """One capture: voltages asked for, shape (n,), which act from one to the next of the phase currents,
    shape (n + 1, 3), and the electrical angle of the rotor, shape (n + 1,). It begins without current."""

    u_V: NDArray[np.complex128]
    readings_A: NDArray[np.float64]
    theta_e_rad: NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """Inductances in H at currents in A along one axis, with standard uncertainties and their degrees of
    freedom."""

    currents_A: NDArray[np.float64]
    L_H: NDArray[np.float64]
    standard_H: NDArray[np.float64]
    dof: float


def saturation(
    pulses: Sequence[Pulse],
    currents_A: NDArray[np.float64],
    *,
    T_s: float,
    R_s_ohm: float,
    psi_r_Wb: float,
    drop_V: float,
    gains: NDArray[np.float64],
    across: bool,
) -> Curve:
    """Return the inductance at some currents.

    Args:
        pulses: of both signs along one axis.
        currents_A: at which the inductance is told.
        T_s: control period.
        R_s_ohm, psi_r_Wb, drop_V, gains: resistance, rotor flux, voltage that dead time and devices take of a
            phase, corrections of the current sensors.
        across: across the rotor flux; else along it.

    Raises:
        AnalysisError: too few rows, or no current.
    """
    rows, flux = [], []
    for pulse in pulses:
        i, psi = _of_axis(pulse, T_s, R_s_ohm, psi_r_Wb, drop_V, gains, across)
        clear = np.abs(i) > _CLEAR * np.max(np.abs(i))
        if np.count_nonzero(clear) < _FEWEST:
            raise AnalysisError(
                f"{np.count_nonzero(clear)} rows of a pulse with a current, {_FEWEST} at least are needed"
            )
        rows.append(i[clear])
        flux.append(psi[clear])
    i, psi = np.concatenate(rows), np.concatenate(flux)
    powers = (0, 2) if across else (0, 1, 2)
    fit = least_squares(np.column_stack([i ** (1 + n) for n in powers]), psi)
    at = np.column_stack([currents_A**n for n in powers])
    # the rows of one pulse share its errors: as if each pulse told each unknown once
    spread = np.einsum("ij,jk,ik->i", at, fit.covariance, at) * len(i) / (len(pulses) * len(powers))
    return Curve(currents_A, at @ fit.x, np.sqrt(spread), max(1.0, len(pulses) - 1.0))


def _of_axis(
    pulse: Pulse,
    T_s: float,
    R_s_ohm: float,
    psi_r_Wb: float,
    drop_V: float,
    gains: NDArray[np.float64],
    across: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return current and flux linkage of an axis at the end of each period, the latter less the rotor's."""
    phases = pulse.readings_A * gains
    i = vector_of(phases)
    mean, drops = 0.5 * (i[1:] + i[:-1]), drop_vector(phases[1:])  # the first begins without a sign
    theta = pulse.theta_e_rad
    if np.ptp(theta) > _MOVED_RAD:
        raise AnalysisError(
            f"the rotor moves by {math.degrees(float(np.ptp(theta))):.0f} degrees electrical within a pulse: "
            f"hold the shaft"
        )
    moved = T_s * np.cumsum(pulse.u_V - R_s_ohm * mean - drop_V * drops)
    psi = (moved + psi_r_Wb * np.exp(1j * theta[0])) * np.exp(-1j * theta[1:]) - psi_r_Wb
    i_dq = i[1:] * np.exp(-1j * theta[1:])
    return (i_dq.imag, psi.imag) if across else (i_dq.real, psi.real)
