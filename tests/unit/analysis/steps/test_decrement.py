"""Heights of lobes as those of one mode: closer than each by itself, and refused of two modes."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.steps.decrement import of_one_mode

NUMBER = np.arange(6.0)
DRAWS = 80


def test_the_last_lobes_follow_from_all() -> None:
    random = np.random.default_rng(40)
    true, noise = 0.5 * np.exp(-0.6 * NUMBER), 0.01
    left, spread = [], []
    for _ in range(200):
        heights = true + noise * random.standard_normal(len(true))
        found = of_one_mode(heights, noise * random.standard_normal((DRAWS, len(true))))
        if found is None:
            continue
        left.append(np.mean(found, axis=0) - true)
        spread.append(np.std(found, axis=0))
    assert len(left) > 180
    rms = np.sqrt(np.mean(np.square(left), axis=0))
    assert np.all(rms[3:] < 0.6 * noise)
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(spread), axis=0)), rms, rtol=0.25)


def test_noise_that_lobes_share_counts_once() -> None:
    """A level that is off raises the lobes on one side and lowers those on the other."""
    random = np.random.default_rng(41)
    true, sides = 0.5 * np.exp(-0.6 * NUMBER), (-1.0) ** NUMBER
    draws = 1e-4 * random.standard_normal((DRAWS, len(true))) + 0.02 * np.outer(
        random.standard_normal(DRAWS), sides
    )
    found = of_one_mode(true + 0.02 * sides, draws)
    assert found is not None
    np.testing.assert_allclose(np.mean(found, axis=0), true, atol=2e-3)


@pytest.mark.parametrize(
    "heights",
    [
        0.5 * np.exp(-0.6 * NUMBER) + 0.3 * np.exp(-2.0 * NUMBER),
        np.array([0.5, 0.3, 0.0, 0.1, 0.05, 0.02]),
        0.1 * np.exp(0.2 * NUMBER),
        np.array([0.5, 0.3]),
    ],
)
def test_lobes_of_no_mode_or_of_several_are_left(heights: np.ndarray) -> None:
    errors = 0.002 * np.random.default_rng(42).standard_normal((DRAWS, len(heights)))
    assert of_one_mode(heights, errors) is None
