"""The rotor's flux linkage of a turning motor, without its angle: the radius of a circle.

The flux linkage of the stator is the integral of the voltage, less what dead time and devices take,

    psi_s(k+1) = psi_s(k) + T_s (u_s - R_s i_s),

and without what the currents make of it, L_q i_s, it is the active flux (Boldea, Paicu and Andreescu, IEEE
Trans. Power Electron. 23 (2008) no. 6), which lies along the rotor and is psi_r + (L_d - L_q) i_d long. The
beginning of the integral and a constant voltage that is left of offsets are unknowns: a centre that moves
evenly. Neither the angle nor the speed of the encoder enters.

With a current along the rotor flux, forth and then back, L_d is an unknown of its own, and an error of R_s or
of V_drop turns the flux instead of changing its length. Where that current goes through zero it does not: the
stretches before and after are integrated each by itself, with a centre of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import Fit, least_squares
from benchtool.errors import AnalysisError

HARMONICS: Final = (-5, 7)
"""Of the rotor flux in stator coordinates, over the speed of the rotor."""

_FEWEST, _FEWEST_TURNS = 300, 2.0
_ITERATIONS = 12
_CONVERGED = 1e-9
_ROUND = 0.25  # largest rms deviation from the circle over its radius


@dataclass(frozen=True)
class TurningFlux:
    """What one capture of a turning motor tells.

    `rows` are the rows of `i_A` that were used, shape (n,). `omega_e_rad_s` is the mean electrical
    speed by the flux, `angle_rad` the electrical angle of the rotor flux there, and `active_Wb` the active
    flux itself. `second_Wb` is the
    complex amplitude of what turns against the rotor, of phases that differ. `ripple` is the rms deviation
    from the circle over its radius.
    """

    psi_r_Wb: float
    psi_r_standard_Wb: float
    L_d_H: float
    omega_e_rad_s: float
    rows: NDArray[np.int64]
    angle_rad: NDArray[np.float64]
    active_Wb: NDArray[np.complex128]
    second_Wb: complex
    ripple: float
    dof: float


def turning_flux(
    u_V: NDArray[np.complex128],
    i_A: NDArray[np.complex128],
    *,
    T_s: float,
    R_s_ohm: float,
    L_d_H: float,
    L_q_H: float,
    stretches: Sequence[tuple[int, int]] = ((0, -1),),
) -> TurningFlux:
    """Return the rotor flux of one capture.

    Args:
        u_V: voltage over each period, less what dead time and devices take (`Legs.taken`), shape (n - 1,).
        i_A: current at both ends of the periods, shape (n,).
        T_s: control period.
        R_s_ohm, L_d_H, L_q_H: resistance and inductances; the one along the rotor flux is where the search
            for it begins.
        stretches: first row and the one after the last of each stretch that is used, -1 for the end.

    Raises:
        AnalysisError: too short, or no flux that turns.
    """
    n, i = len(i_A), i_A
    parts = [np.arange(first, n if end < 0 else end) for first, end in stretches]
    used = np.concatenate(parts)
    if len(used) < _FEWEST:
        raise AnalysisError(f"{len(used)} ticks of a turning motor, {_FEWEST} at least are needed")
    moved = T_s * (u_V - R_s_ohm * 0.5 * (i[1:] + i[:-1]))
    whole = np.concatenate(([0.0], np.cumsum(moved))) - L_q_H * i
    flux = np.concatenate([whole[part] - np.mean(whole[part]) for part in parts])
    i = i[used]
    slow = np.zeros((len(used), 2 * len(parts)))  # of each stretch a constant and a line
    of = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    for k, part in enumerate(parts):
        slow[of == k, 2 * k : 2 * k + 2] = np.column_stack(
            [np.ones(len(part)), np.linspace(-1.0, 1.0, len(part))]
        )
    radius, centres, saliency = float(np.std(flux)), np.zeros(slow.shape[1], np.complex128), L_d_H - L_q_H
    for _ in range(_ITERATIONS):
        vector = flux - slow @ centres
        along = vector / np.abs(vector)
        i_d = (i * np.conj(along)).real
        error = np.abs(vector) - radius - saliency * i_d
        rows = np.column_stack(
            [np.ones(len(used)), i_d, slow * along.real[:, None], slow * along.imag[:, None]]
        )
        x = np.linalg.lstsq(rows.T @ rows, rows.T @ error, rcond=None)[0]
        radius, saliency = radius + float(x[0]), saliency + float(x[1])
        moves = x[2:].reshape(2, -1)
        centres += moves[0] + 1j * moves[1]
        if max(abs(x[0]), np.max(np.abs(moves))) < _CONVERGED * abs(radius):
            break
    fit = least_squares(rows, error)
    vector = flux - slow @ centres
    angles = [np.unwrap(np.angle(vector[of == k])) for k in range(len(parts))]
    turns = sum(abs(each[-1] - each[0]) for each in angles) / (2.0 * np.pi)
    ripple = fit.scatter / radius if radius > 0.0 else np.inf
    if not (turns > _FEWEST_TURNS and ripple < _ROUND):
        raise AnalysisError(
            f"the flux turned {turns:.2g} times, {100.0 * ripple:.2g} % off a circle: the motor does "
            f"not turn, "
            f"or another machine than the one believed"
        )
    slopes = [float(np.polyfit(np.arange(len(each)) * T_s, each, 1)[0]) for each in angles]
    slope = float(np.average(slopes, weights=[len(each) for each in angles]))
    angle = np.concatenate(angles)
    against = complex(np.mean(vector * np.exp(1j * angle)))
    standard = _of_turns(rows, fit, angle, of)
    return TurningFlux(
        radius,
        standard,
        L_q_H + saliency,
        slope,
        used,
        angle,
        np.asarray(vector, np.complex128),
        against,
        ripple,
        max(1.0, turns - 2.0),
    )


def rotor_flux(
    active_Wb: NDArray[np.complex128],
    i_A: NDArray[np.complex128],
    theta_e_rad: NDArray[np.float64],
    saliency_H: float,
) -> NDArray[np.complex128]:
    """Return the rotor flux of an active flux, less what a salient rotor adds along its electrical angle.

    That is the encoder's: harmonics turn the flux to and fro, and with a current along the rotor its own
    angle would make others of them.
    """
    along = np.exp(1j * theta_e_rad)
    return np.asarray(active_Wb - saliency_H * (i_A * np.conj(along)).real * along, np.complex128)


def harmonics(flux_Wb: NDArray[np.complex128], theta_e_rad: NDArray[np.float64]) -> dict[int, complex]:
    """Return the complex amplitudes of the rotor flux that turn minus five and seven times as fast as the
    rotor, by the electrical angle of the encoder: of the fifth and the seventh harmonic of a phase's.
    """
    orders = (1, *HARMONICS)
    waves = np.exp(1j * np.outer(theta_e_rad, orders))
    found = np.linalg.lstsq(waves, flux_Wb, rcond=None)[0]
    return {order: complex(each) for order, each in zip(orders, found, strict=True) if order != 1}


def _of_turns(
    rows: NDArray[np.float64], fit: Fit, angle: NDArray[np.float64], of: NDArray[np.int64]
) -> float:
    """Return the standard uncertainty of the radius by scores summed over half revolutions of the flux: what
    deviates comes again with these."""
    bread = fit.covariance / fit.scatter**2
    half = np.abs(angle - angle[np.searchsorted(of, of)]) // np.pi
    (starts,) = np.nonzero((np.diff(half, prepend=-1.0) != 0.0) | (np.diff(of, prepend=-1) != 0))
    scores = np.add.reduceat(rows * fit.residuals[:, None], starts, axis=0)
    spread = bread @ (scores.T @ scores) @ bread
    return float(np.sqrt(max(spread[0, 0], fit.covariance[0, 0])))
