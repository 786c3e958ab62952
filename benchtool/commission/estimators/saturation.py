"""Flux linkage over current, from voltage pulses along both axes of the rotor.

Of a rotor that stands, or hardly moves within a pulse, the flux linkage is the integral of the voltage,

    psi(i) - psi(0) = integral of u - R_s i - V_drop s(i),

turned back by the angle that the rotor has moved meanwhile. Over the currents it is the slope of one energy,
as the field's is,

    psi_d - psi_r = i_d (c_0 + c_1 i_d + c_2 i_d^2) + m/2 i_q^2,
    psi_q = i_q (c_0' + c_1' |i_q| + c_2' i_q^2) + m i_d i_q,

as the magnet makes the one axis lopsided and the other not. A voltage along one axis alone makes a current
along the other, too, where these share iron, and where the rotor lies beside the pulse: m takes that up, and
what the quotient of flux linkage and current is without the other current, is the inductance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.regression import Fit, least_squares
from benchtool.commission.estimators.vectors import drop_vector
from benchtool.errors import AnalysisError

_FEWEST = 6
_MOVED_RAD = math.pi / 6.0
_UNKNOWNS = 3  # of an axis
_LEAST_SCATTER, _ROUNDS = 1e-6, 4  # of the largest flux linkage; of weighting
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
    freedom; `moved_rad` is by how much the rotor has moved, electrically, when the current is there."""

    currents_A: NDArray[np.float64]
    L_H: NDArray[np.float64]
    standard_H: NDArray[np.float64]
    dof: float
    moved_rad: NDArray[np.float64]


@dataclass(frozen=True)
class Saturation:
    """Curves along the rotor flux and across it; `cross_H_A` is m above, with its standard uncertainty."""

    along: Curve
    across: Curve
    cross_H_A: float
    cross_standard_H_A: float


def saturation(
    along: Sequence[Pulse],
    across: Sequence[Pulse],
    currents_A: NDArray[np.float64],
    circuit: Circuit,
    psi_r_Wb: float,
) -> Saturation:
    """Return the inductances at some currents.

    Args:
        along, across: pulses of both signs along the rotor flux and across it.
        currents_A: at which the inductances are told.
        circuit: what is known of winding and inverter.
        psi_r_Wb: rotor flux.

    Raises:
        AnalysisError: too few rows, or no current along one of the axes.
    """
    groups = [
        _rows(pulses, circuit, psi_r_Wb, component) for pulses in (along, across) for component in ("d", "q")
    ]
    fit = _weighted(groups)
    curves = []
    for k, (pulses, lopsided) in enumerate(((along, True), (across, False))):
        at, own = _powers(currents_A, lopsided=lopsided), slice(k * _UNKNOWNS, (k + 1) * _UNKNOWNS)
        # the rows of one pulse share its errors: as if each pulse told each unknown of its axis once
        shared = len(groups[3 * k][1]) / (len(pulses) * _UNKNOWNS)
        spread = shared * np.einsum("ij,jk,ik->i", at, fit.covariance[own, own], at)
        moved = _moved(pulses, currents_A, circuit)
        curves.append(Curve(currents_A, at @ fit.x[own], np.sqrt(spread), max(1.0, len(pulses) - 1.0), moved))
    return Saturation(curves[0], curves[1], float(fit.x[-1]), fit.standard(-1) * math.sqrt(shared))


def _moved(pulses: Sequence[Pulse], currents_A: NDArray[np.float64], circuit: Circuit) -> NDArray[np.float64]:
    """Return the largest angle by which the rotor has moved when these currents are reached.

    A current that grows evenly moves it by the cube of the time.
    """
    moved = np.zeros(len(currents_A))
    for pulse in pulses:
        i = np.abs(circuit.currents(pulse.readings_A))
        last = int(np.argmax(i))
        by = abs(float(pulse.theta_e_rad[last] - pulse.theta_e_rad[0]))
        moved = np.maximum(moved, by * (np.abs(currents_A) / i[last]) ** 3)
    return moved


def _rows(
    pulses: Sequence[Pulse], circuit: Circuit, psi_r_Wb: float, component: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return one component of the equations above, regressors and flux linkage, of pulses along one axis."""
    rows, flux = [], []
    for pulse in pulses:
        i, psi = _linked(pulse, circuit, psi_r_Wb)
        clear = np.abs(i) > _CLEAR * np.max(np.abs(i))
        if np.count_nonzero(clear) < _FEWEST:
            raise AnalysisError(
                f"{np.count_nonzero(clear)} rows of a pulse with a current, {_FEWEST} at least are needed"
            )
        d, q = i[clear].real, i[clear].imag
        none = np.zeros((len(d), _UNKNOWNS))
        if component == "d":
            rows.append(np.column_stack([_powers(d, lopsided=True) * d[:, None], none, 0.5 * q * q]))
        else:
            rows.append(np.column_stack([none, _powers(q, lopsided=False) * q[:, None], d * q]))
        flux.append(psi[clear].real if component == "d" else psi[clear].imag)
    return np.concatenate(rows), np.concatenate(flux)


def _weighted(groups: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> Fit:
    """Return the fit to all groups of rows, each by its own scatter.

    The counts of the encoder turn the flux of the rotor across its axis, not along it, and dead time takes
    the less known a voltage, the nearer a phase is to no current.
    """
    A, y = (np.concatenate([group[k] for group in groups]) for k in range(2))
    sizes = [len(of) for _, of in groups]
    scatter = np.ones(len(y))
    for _ in range(_ROUNDS):
        left = (y - A @ least_squares(A / scatter[:, None], y / scatter).x) ** 2
        each = [math.sqrt(float(np.mean(of))) for of in np.split(left, np.cumsum(sizes)[:-1])]
        scatter = np.maximum(np.repeat(each, sizes), _LEAST_SCATTER * float(np.max(np.abs(y))))
    return least_squares(A / scatter[:, None], y / scatter)


def _powers(i: NDArray[np.float64], *, lopsided: bool) -> NDArray[np.float64]:
    return np.column_stack([np.ones(len(i)), i if lopsided else np.abs(i), i * i])


def _linked(
    pulse: Pulse, circuit: Circuit, psi_r_Wb: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return current and flux linkage in the rotor's axes at the end of each period, the latter less the
    rotor's."""
    i, phases = circuit.currents(pulse.readings_A), pulse.readings_A * circuit.gains
    mean, drops = 0.5 * (i[1:] + i[:-1]), drop_vector(phases[1:])  # the first begins without a sign
    theta = pulse.theta_e_rad
    if np.ptp(theta) > _MOVED_RAD:
        raise AnalysisError(
            f"the rotor moves by {math.degrees(float(np.ptp(theta))):.0f} degrees electrical within a pulse: "
            f"hold the shaft"
        )
    moved = circuit.T_s * np.cumsum(pulse.u_V - circuit.R_s_ohm * mean - circuit.drop_V * drops)
    psi = (moved + psi_r_Wb * np.exp(1j * theta[0])) * np.exp(-1j * theta[1:]) - psi_r_Wb
    return i[1:] * np.exp(-1j * theta[1:]), psi
