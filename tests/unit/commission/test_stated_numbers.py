"""What steps state beside the parameters that they are for has the uncertainty of what it hangs on."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.block import Block
from benchtool.commission.estimators.alignment import Alignment
from benchtool.commission.estimators.mechanics import Mechanics
from benchtool.commission.known import Known
from benchtool.commission.steps import encoder, mechanics
from benchtool.commission.steps.mechanics import Reversals
from benchtool.profile import load_profile

MOTOR = load_profile("zhu2011").motor
KNOWN = Known(MOTOR, 1e-4, 122.6)


@pytest.mark.parametrize("apart_rad", [0.0, 5e-4])
def test_an_eccentric_disc_is_as_uncertain_as_equal_swings_are_alike_by_chance(apart_rad: float) -> None:
    """Of two swings of one size with any phases the mean is beyond U of 5 %: over their difference it is half
    of the cotangent of half their angle."""
    found = Alignment(0.1, 1e-4, 0.02, 2e-4, (0.01 + 0j, 0j), 1e-4, (apart_rad, 0.0), 0.01, 1e6)
    told = {each.name: each for each in encoder._measurements(found, MOTOR.pole_pairs, 1, KNOWN)}
    once = told["eccentricity_1_cos"].uncertainty
    assert once is not None
    share = 0.5 / math.tan(0.5 * 0.05 * math.pi)
    assert once.expanded == pytest.approx(math.hypot(1.96e-4, share * apart_rad), rel=1e-3)
    lag = told["friction_lag"].uncertainty
    assert lag is not None
    assert lag.standard == pytest.approx(math.hypot(2e-4, 0.003 / math.sqrt(3.0)))


@pytest.mark.parametrize(
    ("standard_kgm2", "dof", "is_told"), [(0.02, 9.0, True), (0.3, 100.0, True), (0.3, 3.0, False)]
)
def test_an_inertia_ratio_has_the_uncertainty_of_the_inertia(
    standard_kgm2: float, dof: float, is_told: bool
) -> None:
    J = 3.0 * MOTOR.J_kgm2
    of_shaft = Mechanics(J, standard_kgm2 * MOTOR.J_kgm2, dof, 0.0, 1e-3, 0.0, 1e-3, 0.0, 1e-3, 9.0)
    block = Block.from_arrays(1e4, {"i_a": "A"}, i_a=[0.0] * 10)
    psi_r = Measurement(
        "psi_r", MOTOR.psi_r_Wb, "Wb", "", uncertainty=Uncertainty(0.01 * MOTOR.psi_r_Wb, "fit")
    )
    known = KNOWN.with_estimates({"psi_r": psi_r})
    found = {each.name: each for each in mechanics._measurements(of_shaft, [block], known)}
    ratio = found["inertia_ratio"].uncertainty
    assert ratio is not None
    expected = math.hypot(standard_kgm2, 3.0 * 0.01, 3.0 * 0.005 / math.sqrt(3.0))
    assert ratio.standard == pytest.approx(expected)
    findings = [each.what for each in Reversals().findings(found, known)]
    assert any("the inertia is" in each for each in findings) is is_told
