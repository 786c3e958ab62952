"""Clicks in a transient: those on its way are found, and its edges, corners and peaks are none."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.outlying_samples import converter_step, without_clicks
from benchtool.analysis.steps.step_shape import Step, find_step
from benchtool.block import Block

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


@pytest.mark.parametrize("damping", [0.1, 0.15, 0.2, 0.25, 0.3, 0.35])
@pytest.mark.parametrize("corner", [1.0, 1.1, 1.2])
def test_a_peak_of_few_samples_beside_an_edge_is_no_click(corner: float, damping: float) -> None:
    random = np.random.default_rng(6)
    for late in (0.1, 0.3, 0.5, 0.7, 0.9):
        samples = ringing(corner, damping, late) + NOISE * random.standard_normal(2000)
        assert without_clicks(samples)[1] == 0


def test_clicks_elsewhere_make_no_click_of_the_first_peak_of_an_answer() -> None:
    """It is as short as a click is; a click in the same row of a slow answer is one."""
    noise = NOISE * np.random.default_rng(7).standard_normal(2000)
    for corner, damping, at_once in ((1.3, 0.2, 0), (1.5, 0.25, 0), (0.05, 0.8, 1)):
        clear = ringing(corner, damping, 0.1) + noise
        samples = clear.copy()
        samples[[700, 1100]] -= 0.1
        samples[203] += 0.1 * at_once
        found = stepped(samples)
        assert found.clicks == 2 + at_once
        assert found.y_clear == pytest.approx(clear[200:], abs=8.0 * NOISE)


def ringing(corner: float, damping: float, late: float) -> np.ndarray:
    """Return the answer of two poles, the corner in radians per row, to a step in row 200 less `late`."""
    since, own = np.maximum(0.0, np.arange(2000.0) - 200.0 + late), corner * np.sqrt(1.0 - damping**2)
    turned = np.cos(own * since) + damping * corner / own * np.sin(own * since)
    return np.asarray(1.0 - np.exp(-damping * corner * since) * turned)


def stepped(samples: np.ndarray) -> Step:
    reference = np.where(np.arange(2000.0) >= 200.0, 1.0, 0.0)
    return find_step(Block.from_arrays(1e4, {"y": "Nm", "r": "Nm"}, y=samples, r=reference), "y", "r")


def test_the_first_sample_of_a_slope_is_no_click_and_one_that_is_far_off_it_is() -> None:
    random = np.random.default_rng(8)
    for begins in random.uniform(0.0, 2.0 * np.pi, 40):
        clear = 5.0 * np.cos(0.0314 * np.arange(2000.0) + begins) + 0.01 * random.standard_normal(2000)
        assert without_clicks(clear)[1] == 0
        for row in (0, 1, len(clear) - 1):
            samples = clear.copy()
            samples[row] += 1.0
            assert without_clicks(samples)[0][row] == pytest.approx(clear[row], abs=0.4)


def test_counts_are_no_clicks_where_the_first_row_has_none() -> None:
    """A speed counted from row to row begins with a value of another kind, a third of a count off."""
    random, step = np.random.default_rng(8), 0.375
    speed = 30.0 + 40.0 / (1.0 + np.exp(-(np.arange(4000.0) - 1200.0) / 100.0))
    counts = np.floor(np.cumsum(speed) / step + random.random())
    samples = step * np.diff(counts, prepend=0.0)
    samples[0] = samples[1] + step / 3.0
    assert converter_step(samples) == pytest.approx(step)
    assert without_clicks(samples)[1] == 0


def test_a_converter_shows_its_step_where_the_way_of_an_answer_is_short() -> None:
    """Nearly all samples are on few levels, and most of those in between are read once."""
    step = 1.0 / 60.3
    for late in (0.0, 0.2, 0.4):
        answer = 1.0 - np.exp(-(np.arange(2000.0) + late) / 15.0)
        assert converter_step(step * np.round(answer / step)) == pytest.approx(step)
        assert converter_step(answer) == 0.0
