"""Samples that were lost, continued from the others."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.lost_samples import continued

ROWS = 6_000


def lost(share: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    return np.random.default_rng(3).random(ROWS) < share


@pytest.mark.parametrize("share", [0.02, 0.2])
@pytest.mark.parametrize("frequency", [0.003, 0.05, 0.3])
def test_sinusoids_go_on(share: float, frequency: float) -> None:
    samples = np.cos(2 * np.pi * frequency * np.arange(ROWS) + 1.0)
    read = np.where(lost(share), 7.0, samples)
    np.testing.assert_allclose(continued(read, lost(share)), samples, atol=1e-3)


@pytest.mark.parametrize("share", [0.02, 0.2])
def test_noise_keeps_its_density_and_lines_their_size(share: float) -> None:
    noise = 0.1 * np.random.default_rng(1).standard_normal(ROWS)
    line = np.cos(2 * np.pi * 0.05 * np.arange(ROWS))
    found = continued(np.where(lost(share), 0.0, line + noise), lost(share))
    assert np.std((found - line)[lost(share)]) == pytest.approx(0.1, rel=0.2)
    assert 2 * np.mean(found * line) == pytest.approx(1.0, abs=3 * 0.1 * np.sqrt(2 / ROWS))


def test_samples_stay_whole_steps_and_others_what_they_are() -> None:
    samples = np.round(50 * np.cos(2 * np.pi * 0.01 * np.arange(ROWS)))
    found = continued(samples, lost(0.1))
    np.testing.assert_array_equal(found[~lost(0.1)], samples[~lost(0.1)])
    np.testing.assert_allclose(found, np.round(found), atol=1e-9)


def test_few_samples_are_straight_lines() -> None:
    samples, without = np.arange(9.0), np.arange(9) % 3 == 1
    np.testing.assert_array_equal(continued(np.where(without, 50.0, samples), without), samples)
