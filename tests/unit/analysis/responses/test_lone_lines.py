"""Lines of an output that repeat with the stimulus."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.responses.lone_lines import with_lone_lines

COUNT, ERROR = 200, 2e-3


def _noisy(response: NDArray[np.complex128], seed: int) -> NDArray[np.complex128]:
    parts = np.random.default_rng(seed).standard_normal((2, len(response)))
    return np.asarray(response * (1.0 + ERROR * (parts[0] + 1j * parts[1])))


@pytest.mark.parametrize("size", [22.0 * ERROR, 0.1])
@pytest.mark.parametrize("seed", range(5))
def test_a_line_is_in_the_error_of_its_frequency_and_of_no_other(seed: int, size: float) -> None:
    places, error = np.arange(COUNT), np.full(COUNT, ERROR)
    s = 1j * places / 60.0
    seen = _noisy(np.asarray(1.0 / (1.0 + 0.3 * s + s**2), dtype=np.complex128), seed)
    at = 70 + seed
    seen[at] *= 1.0 + size
    found = with_lone_lines(places, seen, error)
    assert 0.5 * size < found[at] < 0.9 * size
    np.testing.assert_array_equal(np.delete(found, at), ERROR)


@pytest.mark.parametrize("damping", [0.005, 0.02, 0.1])
def test_a_resonance_and_a_notch_between_few_frequencies_are_none(damping: float) -> None:
    """Half a frequency wide and more."""
    places, error = np.arange(COUNT), np.full(COUNT, ERROR)
    for centre in np.linspace(100.0, 101.0, 9).tolist():
        s = 1j * places / centre
        resonance = 1.0 / (1.0 + 2.0 * damping * s + s**2)
        for response in (resonance, 1.0 / resonance):
            np.testing.assert_array_equal(with_lone_lines(places, _noisy(response, 1), error), ERROR)


def test_few_frequencies_tell_of_none() -> None:
    error = np.full(6, ERROR)
    assert with_lone_lines(np.arange(6), np.ones(6, dtype=np.complex128), error) is error
