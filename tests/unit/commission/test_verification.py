"""What the balance of the verification run contradicts."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.known import Known
from benchtool.commission.steps.verification import Verification
from benchtool.profile import load_profile

KNOWN = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
R_S = KNOWN.identified.R_s_ohm
SWING = Verification().plan(KNOWN)[0]
SWING_A = math.sqrt(SWING.squares_A2s / (SWING.request.rows * KNOWN.control_period_s))


def told(R_s_ohm: float) -> dict[str, Measurement]:
    certain = Uncertainty(0.001 * R_S, "scatter", 10.0)
    assert SWING.stimulus is not None
    return {
        "flux_balance_R_s": Measurement("flux_balance_R_s", R_s_ohm, "ohm", "", uncertainty=certain),
        "speed_reached": Measurement("speed_reached", SWING.stimulus.amplitude, "rad/s", ""),
    }


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_resistance_is_contradicted_beyond_what_dead_time_makes_at_the_current_of_the_swing(
    sign: float,
) -> None:
    known = KNOWN.with_drop(0.4 * R_S * SWING_A)
    lost_ohm = 0.5 * abs(known.drop_fundamental_V) / SWING_A
    assert not Verification().findings(told(R_S + sign * 0.9 * lost_ohm), known)
    (finding,) = Verification().findings(told(R_S + sign * 1.1 * lost_ohm), known)
    assert "R_s" in finding.what


def test_without_dead_time_a_resistance_that_is_a_fifth_off_is_contradicted() -> None:
    assert Verification().findings(told(1.2 * R_S), KNOWN)
