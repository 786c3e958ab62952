"""Clicks in a transient: those on its way are found, and its edges, corners and peaks are none."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.steps.clicks import without_clicks

NOISE = 1e-3


@pytest.mark.parametrize("length", [1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_click_on_the_way_of_an_answer_is_found(length: int, sign: float) -> None:
    """The course differs by 0.02 per sample, so that a click of 0.03 is within the levels around it."""
    since = np.maximum(0.0, np.arange(2000.0) - 200.0)
    clear = 1.0 - np.exp(-since / 50.0) * np.cos(since / 40.0)
    clear += NOISE * np.random.default_rng(3).standard_normal(len(clear))
    for row in (208, 220, 260, 1000):
        samples = clear.copy()
        samples[row : row + length] += 0.03 * sign
        mended, hits = without_clicks(samples)
        assert length <= hits <= length + 2  # two samples beside may go with them
        assert np.all(mended[row : row + length] != samples[row : row + length])
        assert mended == pytest.approx(clear, abs=6.0 * NOISE)


@pytest.mark.parametrize("length", [1, 5, 40])
def test_edges_corners_and_peaks_are_no_clicks(length: int) -> None:
    since = np.arange(2000.0) - 200.0
    up = np.clip(since / length, 0.0, 1.0)
    peak = np.maximum(0.0, 1.0 - np.square(since / (length + 3.0)))
    random = np.random.default_rng(4)
    for clear in (up, peak):
        samples = clear + NOISE * random.standard_normal(len(clear))
        assert without_clicks(samples)[1] == 0
