"""What saturation by a current along the rotor flux does to that, as the curve tells it or leaves it open."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.known import Known
from benchtool.commission.steps.flux_linkage import _amplitude_A, _lopsided
from benchtool.commission.steps.saturation import CURVE_PERCENT
from benchtool.profile import load_profile

KNOWN = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
L_D, AMPLITUDE_A = KNOWN.identified.L_d_H, _amplitude_A(KNOWN)
AT_A = CURVE_PERCENT[-1] / 100.0 * KNOWN.I_N_A


def with_curve(slope_per_A: float, standard_H: float) -> Known:
    """L_d = L_D (1 + slope i) at both ends of the curve."""
    u = Uncertainty(standard_H, "scatter", 3.0)
    ends = {f"L_d_at_{'' if sign > 0 else 'minus_'}{CURVE_PERCENT[-1]}": sign * AT_A for sign in (1, -1)}
    return KNOWN.with_estimates(
        {
            name: Measurement(name, L_D * (1.0 + slope_per_A * i_A), "H", "", uncertainty=u)
            for name, i_A in ends.items()
        }
    )


def test_what_the_curve_tells_is_the_mean_flux_of_a_current_forth_and_back() -> None:
    slope = 0.1 / AT_A
    mean_Wb = 0.5 * sum(L_D * (1.0 + slope * i_A) * i_A for i_A in (AMPLITUDE_A, -AMPLITUDE_A))
    value_Wb, contribution = _lopsided(with_curve(slope, 1e-3 * L_D))
    assert value_Wb == pytest.approx(mean_Wb)
    assert 0.0 < contribution.standard < 0.02 * mean_Wb


def test_a_difference_that_the_curve_does_not_tell_is_in_the_uncertainty() -> None:
    slope = 0.01 / AT_A
    value_Wb, contribution = _lopsided(with_curve(slope, 0.01 * L_D))
    assert value_Wb == 0.0
    assert contribution.standard == pytest.approx(math.sqrt(0.5) * 0.01 * L_D * AMPLITUDE_A**2 / AT_A)


def test_without_a_curve_any_saturation_is_in_the_uncertainty() -> None:
    value_Wb, contribution = _lopsided(KNOWN)
    told_Wb, certain = _lopsided(with_curve(0.1 / AT_A, 1e-3 * L_D))
    assert value_Wb == 0.0
    assert contribution.evaluation == "B"
    assert certain.standard < told_Wb < 2.0 * contribution.standard
