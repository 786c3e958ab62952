"""Whether a crest on the way up passes a level: what noise decides is as uncertain as both are apart."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchtool.analysis.steps.noisy_curve import NoisyCurve

LEVEL_NOISE = 0.003
ROWS = np.arange(240.0)
DRAWS = 60


def noise(random: np.random.Generator, count: int, rows: float = 6.0) -> np.ndarray:
    """Return noise of this rms, smooth over some rows."""
    drawn = gaussian_filter1d(random.standard_normal((count, len(ROWS) + 100)), rows, axis=1)[:, 50:-50]
    return np.asarray(LEVEL_NOISE * drawn / np.std(drawn))


def waves(crest: float) -> np.ndarray:
    """Return a way up past zero with a crest of this height, a trough behind it, and beyond zero at last."""
    way = np.interp(ROWS, (0.0, 60.0, 80.0, 105.0, 160.0, 239.0), (-1.0, -0.06, 0.0, -0.06, 0.2, 0.3))
    smooth = gaussian_filter1d(way, 5.0)
    return np.asarray(smooth - np.max(smooth[:105]) + crest)


@pytest.mark.parametrize("crest", [-0.003, -0.002])
def test_a_crest_as_high_as_a_level_is_in_the_uncertainty_of_its_passage(crest: float) -> None:
    random = np.random.default_rng(23)
    true = NoisyCurve(waves(crest), np.empty((0, len(ROWS)))).passage(0.0)
    assert true is not None
    errors, at_crest = [], 0
    for _ in range(100):
        curve = NoisyCurve(waves(crest) + noise(random, 1, 2.0)[0], noise(random, DRAWS, 2.0))
        found = curve.first_above(0.0)
        assert found is not None
        errors.append((found.place - true.place) / found.standard)
        at_crest += found.place < 100.0
    assert np.sqrt(np.mean(np.square(errors))) < 1.4
    assert np.mean(np.abs(errors) < 2.0) >= 0.9
    assert at_crest >= 10  # which noise lifts over the level


def test_a_crest_that_noise_does_not_decide_adds_nothing_to_a_passage() -> None:
    random = np.random.default_rng(24)
    for crest in (0.03, -0.03):
        found = NoisyCurve(waves(crest), 0.3 * noise(random, DRAWS)).passage(0.0)
        assert found is not None
        assert found.of_crests == 0.0
