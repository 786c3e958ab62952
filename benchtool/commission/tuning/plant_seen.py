"""The shaft as a measured speed loop shows it: what the gains really work on, about the crossover.

Divided by its controller and by the loop of torque, the open loop leaves speed over torque, whose inverse is
linear in inertia and damping,

    C(z) M(z) / L(z) = J (z - 1) / T_s + B.

B holds all that brakes in proportion to the speed there: viscous friction, and the currents that harmonics of
the EMF drive through the current loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchtool.analysis import Bode
from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.tuning.loops import SpeedLoop
from benchtool.errors import AnalysisError

_BAND: Final = 2.0  # of the crossover, to either side
_FEWEST: Final = 4  # frequencies


@dataclass(frozen=True)
class SeenPlant:
    """Inertia in kgm2 and damping in Nms about the crossover of a loop, each with its standard uncertainty,
    and the degrees of freedom of both."""

    J_kgm2: float
    J_standard: float
    friction_Nms: float
    friction_standard: float
    dof: float


def seen_plant(bode: Bode, loop: SpeedLoop) -> SeenPlant:
    """Return inertia and damping by the closed loop's response, measured with the gains of `loop`.

    Least squares over the frequencies used within a factor of two about the crossover that was designed, each
    weighted by its error.

    Raises:
        AnalysisError: too few frequencies can be used there.
    """
    found = bode.response
    crossover_Hz = loop.margins.crossover_rad_s / (2.0 * math.pi)
    near = found.trusted & (found.frequency_Hz > crossover_Hz / _BAND)
    near &= found.frequency_Hz < crossover_Hz * _BAND
    if np.count_nonzero(near) < _FEWEST:
        raise AnalysisError(
            f"{np.count_nonzero(near)} frequencies within a factor of {_BAND:g} of {crossover_Hz:.4g} Hz "
            f"can be used, {_FEWEST} at least are needed: raise the stimulus"
        )
    closed = found.response[near]
    z = np.exp(2j * math.pi * found.frequency_Hz[near] * loop.T_s)
    # M / (z - 1) is the plant of a unit inertia without friction, so that this is C M / L
    free = replace(loop, J_kgm2=1.0, friction_Nms=0.0)
    difference = (z - 1.0) / loop.T_s
    inverse = free.open(z) * difference * (1.0 - closed) / closed
    error = np.abs(inverse) * found.error_of_many[near] / np.abs(1.0 - closed)
    A = np.column_stack([difference, np.ones(len(z))]) / error[:, None]
    b = inverse / error
    fit = least_squares(np.concatenate([A.real, A.imag]), np.concatenate([b.real, b.imag]))
    return SeenPlant(float(fit.x[0]), fit.standard(0), float(fit.x[1]), fit.standard(1), fit.dof)
