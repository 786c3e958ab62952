"""Noise that a plateau has and a rest has not: of every number that of the part that it is read from."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import analyze_step
from benchtool.analysis.steps.bursts import noise_and_levels
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.plateau_noise import noise_of_plateau
from benchtool.analysis.steps.smoothing import Noise, UnevenNoise
from benchtool.block import Block
from tests.at_length import at_length

Floats = NDArray[np.float64]

_RATE_HZ = 10_000.0
_TIMES = (np.arange(-200.0, 1600.0) + 0.5) / _RATE_HZ
_UP, _FALLS_S = 1.0 / (2.0 * np.pi * 100.0), 0.08


def _lag(time_s: Floats) -> Floats:
    return np.asarray(1.0 - np.exp(-np.maximum(time_s, 0.0) / _UP))


def _pulse(level: Callable[[Floats], Floats], random: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Return value and standard uncertainty of every number of a pulse whose noise has a level."""
    answer = _lag(_TIMES) - _lag(_TIMES - _FALLS_S)
    reference = np.where((_TIMES >= 0.0) & (_TIMES < _FALLS_S), 1.0, 0.0)
    measured = answer + 5e-3 * level(answer) * random.standard_normal(len(answer))
    block = Block.from_arrays(_RATE_HZ, {"y": "Nm", "r": "Nm"}, y=measured, r=reference)
    return {
        each.name: (each.value, each.uncertainty.standard)
        for each in analyze_step(block, "y", "r").measurements
        if each.uncertainty is not None
    }


@pytest.mark.parametrize("level", [np.abs, *at_length(lambda answer: 1.0 * (np.abs(answer) > 0.01))])
def test_a_pulse_from_a_silent_rest_is_as_uncertain_as_its_plateau(level: Callable[[Floats], Floats]) -> None:
    random = np.random.default_rng(3)
    found = [_pulse(level, random) for _ in range(10)]
    reach_s, settle_s = _UP * math.log(50.0), _FALLS_S + _UP * math.log(50.0)
    for name, truth in (("reach_time", reach_s), ("settling_time", settle_s), ("undershoot", 0.0)):
        relative = [(value - truth) / standard for value, standard in (each[name] for each in found)]
        assert math.sqrt(np.mean(np.square(relative))) < 1.5, name
    for name in ("plateau_min", "plateau_max", "tracking_error_rms", "tracking_error_max"):
        value, standard = np.array([each[name] for each in found]).T
        assert np.std(value, ddof=1) < 1.5 * math.sqrt(np.mean(standard**2)), name
        assert np.std(value, ddof=1) > 0.3 * math.sqrt(np.mean(standard**2)), name


def test_the_level_of_a_silent_rest_is_certain() -> None:
    noise = np.random.default_rng(4).standard_normal(800)
    silent = NoisyCurve.through(100.0 + noise, Noise(np.zeros(1)), 200, Noise.of(noise))
    assert silent.before is not None
    assert not np.any(silent.before)
    assert np.all(silent.standard > 0.0)


def test_a_plateau_with_the_noise_of_its_rest_has_no_other() -> None:
    random = np.random.default_rng(5)
    for _ in range(50):
        noise = random.standard_normal(700)
        assert noise_of_plateau(noise[:400], [noise[400:500], noise[500:]], 100.0, 0.0) is None


@pytest.mark.parametrize("of_rest", [0.0, 0.1, 10.0])
def test_a_plateau_with_another_noise_is_told(of_rest: float) -> None:
    random = np.random.default_rng(6)
    rest = of_rest * random.standard_normal((2, 100))
    found = noise_of_plateau(random.standard_normal(400), rest, 100.0, 0.0)
    assert found is not None
    assert found.rms == pytest.approx(1.0, rel=0.2)


def test_an_answer_without_noise_is_none() -> None:
    rows = np.arange(400.0)
    late = np.exp(-rows / 90.0) * (1.0 + rows / 90.0 + np.cos(rows / 15.0))  # of fourth order
    assert noise_of_plateau(late, [np.zeros(100)], 1.0, 0.0) is None


def test_a_level_that_is_read_now_and_then_is_no_other_noise() -> None:
    """Noise below a step of a converter shows only where it is near the edge of a level."""
    read = np.round(0.5 + 0.05 * np.random.default_rng(7).standard_normal(400))
    assert noise_of_plateau(read, [np.zeros(100)], 100.0, 1.0) is None


@pytest.mark.parametrize(("samples", "tells"), [(47, False), (48, True)])
def test_too_few_samples_tell_of_no_noise(samples: int, tells: bool) -> None:
    """Three windows of sixteen."""
    noise = np.random.default_rng(8).standard_normal(samples)
    assert (noise_of_plateau(noise, [np.zeros(100)], 1.0, 0.0) is not None) is tells
    assert (noise_of_plateau(np.tile(noise, 4), [np.zeros(samples)], 1.0, 0.0) is not None) is tells


@pytest.mark.parametrize(("rms", "tells"), [(0.8, False), (1.7, True)])
def test_noise_of_a_millionth_of_the_step_is_rounding(rms: float, tells: bool) -> None:
    """Of 14 errors of a prediction three are fitted: they have 0.89 of the noise."""
    noise = rms * np.random.default_rng(11).standard_normal(800)
    assert (noise_of_plateau(noise, [np.zeros(100)], 1e6, 0.0) is not None) is tells
    assert (noise_of_plateau(noise, [np.zeros(100)], 1.0, 1.0) is not None) is tells


@pytest.mark.parametrize("periods", [(7.3, 9.1), (14.3, 18.1)])
def test_what_swings_within_some_samples_is_no_noise(periods: tuple[float, float]) -> None:
    """A prediction from two samples leaves something of two sinusoids: at most an error in four is on the
    other side of that before, and of noise one in two."""
    rows = np.arange(400.0)
    swing = sum(np.cos(2.0 * np.pi * rows / each + each) for each in periods)
    assert isinstance(swing, np.ndarray)
    assert noise_of_plateau(swing, [np.zeros(100)], 1.0, 0.0) is None


def test_levels_are_those_of_the_noise_on_either_side_of_its_end() -> None:
    random = np.random.default_rng(9)
    noise = np.where(np.arange(1000) < 500, 1.0, 0.05) * random.standard_normal(1000)
    found, levels = noise_and_levels(noise, Noise(np.zeros(1)), Noise.of(noise[:500]))
    assert found.rms == pytest.approx(1.0, rel=0.2)
    assert np.all(levels[:500] == 1.0)
    assert np.all(levels[520:] < 0.15)
    assert np.median(levels[520:]) == pytest.approx(0.05, rel=0.5)


def test_sums_of_uneven_noise_scatter_as_is_told() -> None:
    levels = np.linspace(0.0, 2.0, 200)
    uneven = UnevenNoise(Noise(np.array([1.0, 0.6, 0.2])), levels)
    drawn = uneven.draw(np.random.default_rng(10), 4000)
    assert np.std(np.sum(drawn, axis=1)) == pytest.approx(uneven.of_sum(np.ones(200)), rel=0.05)
    assert np.std(np.sum(drawn**2, axis=1)) == pytest.approx(uneven.of_sum_of_squares(), rel=0.05)
