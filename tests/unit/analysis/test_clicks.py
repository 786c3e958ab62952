"""Clicks are told from edges, peaks and noise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.dynamics.clicks import without_clicks
from benchtool.analysis.dynamics.step import analyze_step
from benchtool.block import Block

Array = NDArray[np.float64]
T = np.arange(-200.0, 2000.0) / 10_000.0


def lag(damping: float, corner_Hz: float) -> Array:
    x = 2.0 * np.pi * corner_Hz * np.maximum(T, 0.0)
    root = np.sqrt(1.0 - damping**2)
    return np.asarray(1.0 - np.exp(-damping * x) * (np.cos(root * x) + damping / root * np.sin(root * x)))


def noise(seed: int, rms: float = 2e-3) -> Array:
    return rms * np.random.default_rng(seed).standard_normal(len(T))


@pytest.mark.parametrize("length", [1, 2])
@pytest.mark.parametrize("height", [-0.1, 0.05, 0.4])
def test_clicks_are_replaced_by_what_is_beside_them(length: int, height: float) -> None:
    clean = lag(0.3, 60.0) + noise(1)
    disturbed = clean.copy()
    for at in (40, 460, 700, 704 + length, 2150):
        disturbed[at : at + length] += height
    mended, count = without_clicks(disturbed)
    assert count == 5 * length
    assert np.max(np.abs(mended - clean)) < 0.02  # a few standard deviations, and what the answer bends


@pytest.mark.parametrize("corner_Hz", [20.0, 300.0, 900.0, 2000.0])
@pytest.mark.parametrize("damping", [0.05, 0.2, 0.7])
def test_an_answer_that_overshoots_has_none(corner_Hz: float, damping: float) -> None:
    for seed in range(5):
        samples = lag(damping, corner_Hz) + noise(seed, 3e-4)
        mended, count = without_clicks(samples)
        assert count == 0
        assert mended is samples


def test_neither_an_edge_nor_what_oscillates_from_sample_to_sample_is_one() -> None:
    edge = np.where(T < 0.0, 0.0, 1.0) + noise(3)
    ringing = noise(4) + 0.3 * np.where(T < 0.0, 0.0, (-1.0) ** np.arange(len(T)) * np.exp(-T / 0.02))
    steps = np.round(64.0 * lag(0.4, 50.0)) / 64.0
    for samples in (edge, ringing, steps, np.zeros(500), edge[:40]):
        assert without_clicks(samples)[1] == 0


def test_a_click_is_no_overshoot_and_the_definition_says_that_it_was_left_out() -> None:
    y = lag(0.9, 80.0) + noise(5)
    y[1500] += 0.3
    y[900] -= 0.3
    reference = np.where(T >= 0.0, 1.0, 0.0)
    block = Block.from_arrays(10_000.0, {"y": "Nm", "r": "Nm"}, y=y, r=reference)
    found = {each.name: each for each in analyze_step(block, "y", "r").measurements}
    for name, truth in (("overshoot", 0.0015), ("undershoot", 0.0)):
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        assert abs(found[name].value - truth) < 3.0 * uncertainty.standard < 0.02
    assert "without 2 samples" in found["overshoot"].definition
    assert "without" not in found["plateau_max"].definition
    assert found["plateau_max"].value > 1.2  # the samples as they are
