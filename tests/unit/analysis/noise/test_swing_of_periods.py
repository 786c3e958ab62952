"""Differences of periods without what goes with a swing of the fundamental."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.noise.swing_of_periods import without_swing


def test_what_goes_with_the_fundamental_is_taken_and_noise_stays() -> None:
    random = np.random.default_rng(0)
    white = random.standard_normal((100, 20, 2)) @ np.array([1.0, 1j])
    noise = np.diff(white, 2, axis=0)
    swing = 300.0 * np.exp(2j * np.pi * 0.3 * np.arange(len(noise)))
    shares = np.append(1.0, 0.1 * random.standard_normal(19))  # of the fundamental, and what it leaves
    differences = noise + np.outer(swing + 0.5 * np.conj(swing), shares)
    left = without_swing(differences)
    assert left is not None
    assert np.mean(np.abs(left) ** 2) == pytest.approx(np.mean(np.abs(noise) ** 2), rel=0.08)
    assert np.mean(np.abs(differences[:, 1:]) ** 2) > 20.0 * np.mean(np.abs(noise) ** 2)


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_differences_that_are_all_alike_tell_no_swing(size: float) -> None:
    assert without_swing(np.full((30, 5), size, dtype=np.complex128)) is None


def test_few_differences_tell_no_swing() -> None:
    assert without_swing(np.ones((20, 5), dtype=np.complex128)) is None
