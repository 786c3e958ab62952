"""The rotor's flux linkage of a turning motor, without its angle: the radius of a circle.

The flux linkage of the stator is the integral of the voltage,

    psi_s(k+1) = psi_s(k) + T_s (u_s - R_s i_s - V_drop s(i)),

and without what the currents make of it, L_q i_s, it is the active flux (Boldea, Paicu and Andreescu, IEEE
Trans. Power Electron. 23 (2008) no. 6), which lies along the rotor and is psi_r + (L_d - L_q) i_d long. The
beginning of the integral and a constant voltage that is left of offsets are unknowns: a centre that moves
evenly. Neither the angle nor the speed of the encoder enters.

With a current along the rotor flux, forth and back, L_d is an unknown of its own, and an error of R_s or of
V_drop turns the flux instead of changing its length.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import Fit, least_squares
from benchtool.commission.estimators.vectors import drop_vector, vector_of
from benchtool.errors import AnalysisError

HARMONICS: Final = (-5, 7)
"""Of the rotor flux in stator coordinates, over the speed of the rotor."""

_FEWEST, _FEWEST_TURNS = 300, 2.0
_ITERATIONS = 12
_CONVERGED = 1e-9
_SOFT = (0.03, 0.06, 0.1, 0.15, 0.22)  # of the largest current, tried
_ROUND = 0.25  # largest rms deviation from the circle over its radius


@dataclass(frozen=True)
class TurningFlux:
    """What one capture of a turning motor tells.

    `omega_e_rad_s` is the mean electrical speed by the flux, `angle_rad` the electrical angle of the rotor
    flux at the ticks of `readings_A`, shape (n,), and `flux_Wb` the rotor flux itself. `second_Wb` is the
    complex amplitude of what turns against the rotor, of phases that differ. `ripple` is the rms deviation
    from the circle over its radius.
    """

    psi_r_Wb: float
    psi_r_standard_Wb: float
    L_d_H: float
    omega_e_rad_s: float
    angle_rad: NDArray[np.float64]
    flux_Wb: NDArray[np.complex128]
    second_Wb: complex
    ripple: float
    dof: float


def turning_flux(
    u_V: NDArray[np.complex128],
    readings_A: NDArray[np.float64],
    *,
    T_s: float,
    R_s_ohm: float,
    L_d_H: float,
    L_q_H: float,
    drop_V: float,
    gains: NDArray[np.float64],
    soft_A: float = 0.0,
) -> TurningFlux:
    """Return the rotor flux of one capture.

    Args:
        u_V: voltage over each period, shape (n - 1,).
        readings_A: phase currents at both ends of the periods, shape (n, 3).
        T_s: control period.
        R_s_ohm, L_d_H, L_q_H, drop_V: resistance, inductances, and what dead time and devices take of a
            phase; the inductance along the rotor flux is where the search for it begins.
        gains: corrections of the current sensors, shape (3,).
        soft_A: size of a phase current below which dead time takes less than its whole voltage.

    Raises:
        AnalysisError: too short, or no flux that turns.
    """
    if len(readings_A) < _FEWEST:
        raise AnalysisError(f"{len(readings_A)} ticks of a turning motor, {_FEWEST} at least are needed")
    i = vector_of(readings_A * gains)
    mean = 0.5 * (i[1:] + i[:-1])
    drops = 0.5 * (drop_vector(readings_A[1:], soft_A) + drop_vector(readings_A[:-1], soft_A))
    moved = T_s * (u_V - R_s_ohm * mean - drop_V * drops)
    flux = np.concatenate(([0.0], np.cumsum(moved))) - L_q_H * i
    t = np.linspace(-1.0, 1.0, len(flux))
    flux = flux - np.mean(flux)
    radius, centre, drift, saliency = float(np.std(flux)), 0.0j, 0.0j, L_d_H - L_q_H
    for _ in range(_ITERATIONS):
        vector = flux - centre - drift * t
        along = vector / np.abs(vector)
        i_d = (i * np.conj(along)).real
        error = np.abs(vector) - radius - saliency * i_d
        rows = np.column_stack([np.ones(len(t)), i_d, along.real, along.imag, t * along.real, t * along.imag])
        x = np.linalg.lstsq(rows.T @ rows, rows.T @ error, rcond=None)[0]
        radius, saliency = radius + float(x[0]), saliency + float(x[1])
        centre += complex(x[2], x[3])
        drift += complex(x[4], x[5])
        if np.max(np.abs(x[[0, 2, 3, 4, 5]])) < _CONVERGED * abs(radius):
            break
    fit = least_squares(rows, error)
    vector = flux - centre - drift * t
    angle = np.unwrap(np.angle(vector))
    turns = abs(angle[-1] - angle[0]) / (2.0 * np.pi)
    ripple = fit.scatter / radius if radius > 0.0 else np.inf
    if not (turns > _FEWEST_TURNS and ripple < _ROUND):
        raise AnalysisError(
            f"the flux turned {turns:.2g} times, {100.0 * ripple:.2g} % off a circle: the motor does "
            f"not turn, "
            f"or another machine than the one believed"
        )
    slope = float(np.polyfit(np.arange(len(angle)) * T_s, angle, 1)[0])
    against = complex(np.mean(vector * np.exp(1j * angle)))
    standard = _of_turns(rows, fit, angle)
    return TurningFlux(
        radius,
        standard,
        L_q_H + saliency,
        slope,
        angle,
        np.asarray(vector - saliency * i_d * along, np.complex128),
        against,
        ripple,
        max(1.0, turns - 2.0),
    )


def softest_circle(readings_A: NDArray[np.float64], flux: Callable[[float], TurningFlux]) -> TurningFlux:
    """Return the flux that lies nearest to a circle, of those by several sizes of the phase current below
    which dead time takes less than its whole voltage.

    That size is the ripple of the current in a period, which grows with the speed. With none the voltage
    that a current across the flux takes came out twice too large on motors of small inductance, and the flux
    up to 1.5 % too small.

    Args:
        readings_A: phase currents, shape (n, 3).
        flux: returns the flux by such a size.

    Raises:
        AnalysisError: there is no flux that turns.
    """
    largest = float(np.max(np.abs(readings_A)))
    tried = {0.0: flux(0.0)}

    def attempt(share: float) -> None:
        with suppress(AnalysisError):  # too soft a sign leaves no circle
            tried[share] = flux(share * largest)

    for share in _SOFT:
        attempt(share)
    for _ in range(2):
        best = min(tried, key=lambda share: tried[share].ripple)
        ordered = sorted(tried)
        place = ordered.index(best)
        for other in ordered[max(0, place - 1) : place] + ordered[place + 1 : place + 2]:
            attempt(0.5 * (best + other))
    return min(tried.values(), key=lambda each: each.ripple)


def harmonics(flux_Wb: NDArray[np.complex128], theta_e_rad: NDArray[np.float64]) -> dict[int, complex]:
    """Return the complex amplitudes of the rotor flux that turn minus five and seven times as fast as the
    rotor, by the electrical angle of the encoder: of the fifth and the seventh harmonic of a phase's.
    """
    orders = (1, *HARMONICS)
    waves = np.exp(1j * np.outer(theta_e_rad, orders))
    found = np.linalg.lstsq(waves, flux_Wb, rcond=None)[0]
    return {order: complex(each) for order, each in zip(orders, found, strict=True) if order != 1}


def _of_turns(rows: NDArray[np.float64], fit: Fit, angle: NDArray[np.float64]) -> float:
    """Return the standard uncertainty of the radius by scores summed over half revolutions of the flux: what
    deviates comes again with these."""
    bread = fit.covariance / fit.scatter**2
    half = np.abs(angle - angle[0]) // np.pi
    (starts,) = np.nonzero(np.diff(half, prepend=-1.0))
    scores = np.add.reduceat(rows * fit.residuals[:, None], starts, axis=0)
    spread = bread @ (scores.T @ scores) @ bread
    return float(np.sqrt(max(spread[0, 0], fit.covariance[0, 0])))
