"""The greatest value between samples."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.steps.tops import kink, parabola


@pytest.mark.parametrize("place", [0.1, 0.4, 0.7, 0.95])
@pytest.mark.parametrize("decay", [15.0, 60.0])
def test_two_courses_meet_between_samples(place: float, decay: float) -> None:
    at = np.arange(40.0) - 20.0 - place
    values = np.where(at < 0.0, 1.0 + 0.05 * at, 0.8 + 0.2 * np.exp(-np.maximum(at, 0.0) / decay))
    top = int(np.argmax(values))
    found = kink(values, top, 0.0)
    assert found is not None
    assert values[top] + found.above == pytest.approx(1.0, abs=3.0 * found.above_error + 1e-12)
    assert found.above_error < 0.2 / decay**2 * 2.0
    assert top + found.beside == pytest.approx(20.0 + place, abs=found.beside_within)


def test_few_samples_of_a_peak_leave_it_between_them() -> None:
    """At five samples a period the neighbours of the greatest may bend the other way."""
    error, standard = [], []
    for phase in np.linspace(-0.5, 0.5, 41):
        values = np.cos(2.0 * np.pi / 5.0 * (np.arange(11.0) - 5.0 + phase))
        found = kink(values, 5, 0.0) or parabola(values, 5)
        error.append(values[5] + found.above - 1.0)
        standard.append(found.above_error)
    assert np.max(np.abs(error) / np.maximum(standard, 0.02)) < 2.5


def test_an_edge_and_a_single_sample_are_no_kink_that_goes_on() -> None:
    for values in ([0, 0, 0, 0, 1, 0.95, 0.95, 0.95, 0.95], [1, 1, 1, 1, 1.07, 1, 1, 1, 1]):
        assert kink(np.array(values, dtype=np.float64), 4, 0.0) is None


def test_noise_is_no_kink() -> None:
    random = np.random.default_rng(0)
    for _ in range(50):
        values = random.standard_normal(41)
        top = 3 + int(np.argmax(values[3:-3]))
        assert kink(values, top, 1.0) is None
