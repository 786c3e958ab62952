"""What a test of a suite measures, as its record keeps it."""

from __future__ import annotations

import pytest

from benchtool.acceptance.measuring import held
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.plan import Limit


@pytest.mark.parametrize("dof", [1.0, 3.0, 8.0])
def test_few_observations_count_once_in_what_a_test_measures(dof: float) -> None:
    """The record had k times the standard uncertainty of Student's distribution: up to twice the U."""
    noise = Contribution("noise", "A", 0.1, dof, of_student=True)
    uncertainty = combined([noise, Contribution("gain", "B", 0.05)], "test")
    assert uncertainty is not None
    limit = Limit(max=1.2, margin="U")
    judged = held("torque_mean", 1.0, "Nm", limit, uncertainty)
    assert judged.uncertainty is not None
    assert judged.uncertainty.expanded == pytest.approx(uncertainty.expanded)
    assert judged.conformance == pytest.approx(limit.conformance(1.0, uncertainty))
    document = judged.held.to_json()  # it said of each that it was not measured
    assert document["conformance"] == judged.conformance
    assert document["verdict"] == judged.verdict
    assert held("x", 1.0, "", limit, Uncertainty(0.1, "", dof)).half_width is None


def test_what_was_not_measured_says_so_in_json() -> None:
    for judged, reason in (
        (held("x", None, "", Limit(max=1.0), None), "it is undefined (no finite value)"),
        (held("x", 0.5, "", Limit(max=1.0), None), "its uncertainty is not known"),
    ):
        assert judged.held.to_json()["conformance_reason"] == reason
