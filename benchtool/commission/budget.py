"""Uncertainty of an estimate: the scatter about the fit, and the converter of the dc link."""

from __future__ import annotations

import math

from benchtool.analysis import Contribution, Uncertainty
from benchtool.commission.known import Known

_CODES = 2.0**10  # of a converter of the dc link, at the least


def of_fit(value: float, standard: float, dof: float, scatter: str, known: Known) -> Uncertainty:
    """Return the uncertainty of a value that is in proportion to the voltage of the dc link.

    The drive makes its voltages with the dc link as its converter reads it: within half a step of the true
    one, a rectangular distribution (JCGM 100:2008, 4.3.7). Of a converter of unknown steps ten bits are
    assumed. Its gain, like that common to the current sensors, is not contained: no current tells of it.

    Args:
        value: the estimate; 0 for one to which the dc link does not matter.
        standard: by the fit, with `dof`.
        scatter: what that was estimated from.
    """
    relative = (
        known.u_dc_full_scale_V / _CODES / math.sqrt(12.0) / known.u_dc_V if known.u_dc_V > 0.0 else 0.0
    )
    fitted = Contribution(scatter, "A", standard, dof)
    if value == 0.0 or relative == 0.0:
        return Uncertainty(standard, scatter, dof, (fitted,))
    converter = Contribution("step of the converter of the dc link", "B", abs(value) * relative)
    squares = standard**2 + converter.standard**2
    effective = squares**2 / (standard**4 / dof) if standard > 0.0 else math.inf
    return Uncertainty(math.sqrt(squares), scatter, effective, (fitted, converter))
