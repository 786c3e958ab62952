"""Mean of a measured speed, which the rotor's angle tells too: what both have in common is no error of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import unwrapped_angle
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.statistics.scatter import MeanError, error_of_record
from benchtool.analysis.uncertainty import Contribution
from benchtool.errors import AnalysisError

_FEWEST = 20  # samples
_WANDERS = "wander of the speed, by that of the angle within the record"


@dataclass(frozen=True)
class SpeedBesideAngle:
    """Error of the mean of a measured speed as the mean speed in its record, by what it reads beside the
    course of the angle there; `between_records` is how much the mean speed of another record differs."""

    error: MeanError
    between_records: Contribution | None


def speed_beside_angle(
    omega_m: NDArray[np.float64], theta_m: NDArray[np.float64], sample_rate_Hz: float
) -> SpeedBesideAngle | None:
    """Return the error of the mean of a speed, rad/s, beside an angle, rad, both of shape (n,); None where
    the angle tells it no better than the speed's own scatter.

    The angle at both ends tells the mean speed, whatever it does in between. What the speed reads beside the
    differences of the angle has the errors of both: those of the angle are taken back by the next, and leave
    the mean those at the ends.
    """
    if len(omega_m) < _FEWEST:
        return None
    try:
        turned = unwrapped_angle(theta_m)
    except AnalysisError:
        return None
    error = error_of_record(0.5 * (omega_m[1:] + omega_m[:-1]) - sample_rate_Hz * np.diff(turned))
    own = error_of_record(omega_m)
    if not error.standard < (own.standard if math.isfinite(own.standard) else math.inf):
        return None
    wander, duration_s = wander_of_difference(turned), (len(turned) - 1) / sample_rate_Hz
    between = None
    if math.isfinite(wander.standard):
        between = Contribution(_WANDERS, "A", wander.standard / duration_s, wander.dof)
    return SpeedBesideAngle(error, between)
