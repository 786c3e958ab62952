"""The benchmark of the balances: what it tells of machines that are not as believed."""

from __future__ import annotations

import pytest

from benchmarks.balances import NINE, error_figures, errors


@pytest.mark.slow
def test_every_estimate_has_an_uncertainty_by_the_sensors_of_the_profile() -> None:
    """A dc link without noise reads the same in every sample, and its converter's step is the profile's."""
    (found,) = errors(1, seed=1)
    assert set(found) >= set(NINE)
    assert max(map(abs, found.values())) < 4.0


def test_what_no_capture_has_told_is_counted() -> None:
    figures = error_figures([{"R_s": 1.0}, {}])
    assert figures["z of J"] == "told 0"
    assert str(figures["z of R_s"]).startswith("told 1, rms 1.00")
    assert "z_rms" not in error_figures([{}])
