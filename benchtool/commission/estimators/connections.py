"""How the three current readings follow a voltage vector that turns.

A voltage u that turns makes the current of a motor, healthy and possibly salient, at a rotor that stands,

    i = Y u + N conj(u),   |N| < |Y|,   Y the inverse of R_s + j omega_e L behind its angle,

of which sensor x reads i_x = Re(i exp(-j theta_x)) = Re(w_x u) with

    w_x = Y exp(-j theta_x) + conj(N) exp(j theta_x).

The w are what each sensor tells without knowing of the others. An open phase, a sensor that is dead, mounted
the other way round or at another output, each changes them in its own way.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.vectors import PHASES
from benchtool.errors import AnalysisError

_DEAD = 0.15  # of the largest: a saliency of 2.5 leaves 0.4
_SUM = 0.12  # of the largest: gains that differ by 2 % make 0.02, one of a half makes 0.17
_UNEQUAL = 0.5  # of N over Y: a saliency of 2.5 makes 0.43, an open phase 1
_DEAD_TIME_RAD = math.radians(25.0)  # by which what is left of dead time, 0 to 50 degrees, is on the average
_ORDER_RAD, _SIGN_RAD = math.radians(60.0), math.radians(150.0)
_FEWEST = 50


class Fault(StrEnum):
    """What is wrong with the connections."""

    NONE = "none"
    NO_CURRENT = "no current"
    OPEN = "open phase"
    SHORTED = "shorted phase"
    DEAD = "dead sensor"
    REVERSED = "reversed sensor"
    ALL_REVERSED = "all sensors reversed"
    GAIN = "gains that differ"
    ORDER = "order of sensors"


@dataclass(frozen=True)
class Response:
    """What each sensor reads for a volt of the vector that turns: `w_S`, shape (3,), complex.

    `slope_S` is Y by how the current grows with the voltage, free of the constant voltage that dead time
    takes along the current. `largest_A` is the largest reading of the capture.
    """

    w_S: NDArray[np.complex128]
    slope_S: complex
    largest_A: float

    @property
    def with_S(self) -> complex:
        """Y, what turns with the voltage."""
        return complex(np.mean(self.w_S * PHASES))

    @property
    def against_S(self) -> complex:
        """N, what turns against it."""
        return complex(np.mean(self.w_S * PHASES.conj()).conjugate())


def response(u_V: NDArray[np.complex128], readings_A: NDArray[np.float64]) -> Response:
    """Return the response of each sensor.

    Args:
        u_V: voltages asked for, shape (n,); u_V[k] acts from readings_A[k] to readings_A[k + 1].
        readings_A: phase currents, shape (n + 1, 3).

    Raises:
        AnalysisError: too short, or a voltage that does not turn.
    """
    if len(u_V) < _FEWEST:
        raise AnalysisError(f"{len(u_V)} control periods of a turning voltage, {_FEWEST} are needed")
    half = len(u_V) // 2  # of a ramp: what dead time takes weighs less in its second half
    u, i = u_V[half:], 0.5 * (readings_A[half + 1 :] + readings_A[half:-1])
    one, along = np.ones(len(u)), u / np.abs(u)
    whole = [least_squares(np.column_stack([u.real, -u.imag, one]), i[:, k]).x for k in range(3)]
    columns = np.column_stack([u.real, -u.imag, along.real, -along.imag, one])
    grown = [least_squares(columns, i[:, k]).x for k in range(3)]
    w, slopes = (np.array([complex(x[0], x[1]) for x in fits]) for fits in (whole, grown))
    largest = float(np.max(np.abs(i - np.array([x[2] for x in whole]))))
    return Response(w, complex(np.mean(slopes * PHASES)), largest)


def diagnosis(found: Response, R_s_ohm: float, L_H: float, omega_e_rad_s: float) -> tuple[Fault, int]:
    """Return what is wrong with the connections, and with which output, 0 to 2.

    Args:
        found: with currents that are clear of noise and of what dead time takes.
        R_s_ohm, L_H, omega_e_rad_s: by the nameplate, which tell the phase of the current about.
    """
    sizes = np.abs(found.w_S)
    largest = float(sizes.max())
    dead = np.flatnonzero(sizes < _DEAD * largest)
    if abs(complex(found.w_S.sum())) > _SUM * largest:
        if len(dead) > 0:
            return Fault.DEAD, int(dead[0])
        for k in range(3):
            turned = np.array(found.w_S)
            turned[k] *= -1.0
            if abs(complex(turned.sum())) < _SUM * largest:
                return Fault.REVERSED, k
        return Fault.GAIN, int(np.argmin(sizes))
    if len(dead) > 0:
        return Fault.OPEN, int(dead[0])
    if abs(found.against_S) > abs(found.with_S):
        return Fault.ORDER, 0
    if abs(found.against_S) > _UNEQUAL * abs(found.with_S):
        least, middle, most = (int(k) for k in np.argsort(sizes))
        odd = sizes[middle] - sizes[least] > sizes[most] - sizes[middle]
        return (Fault.OPEN, least) if odd else (Fault.SHORTED, most)
    expected = _DEAD_TIME_RAD - math.atan2(omega_e_rad_s * L_H, R_s_ohm)
    off = abs(cmath.phase(found.slope_S * cmath.exp(-1j * expected)))
    if off > _SIGN_RAD:
        return Fault.ALL_REVERSED, 0
    return (Fault.ORDER, 0) if off > _ORDER_RAD else (Fault.NONE, 0)
