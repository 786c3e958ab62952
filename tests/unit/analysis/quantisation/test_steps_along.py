"""Steps of a converter over which a slow line, or a ripple of no period, takes a signal."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j0, j1

from benchtool.analysis.quantisation.steps_along import are_read_alike, steps_along

Floats = NDArray[np.float64]

COUNT = 20_000
STEP = 0.05


def sinusoid(steps: float, cycles: float) -> Floats:
    return np.asarray(steps * STEP * np.cos(2.0 * np.pi * cycles * np.arange(COUNT) / COUNT + 0.4))


def read(signal: Floats, level: float = 0.013) -> Floats:
    return np.asarray(STEP * np.round((signal - level) / STEP) + level)


@pytest.mark.parametrize("steps", [1.6, 3.3, 7.2])
def test_of_a_sinusoid_they_are_those_of_bessel_functions(steps: float) -> None:
    found = steps_along(read(2.0 + sinusoid(steps, 17.3)), STEP)
    assert found is not None
    sizes = steps + 0.1 * np.sqrt(2.0) * np.random.default_rng(1).standard_normal(4_000)
    order = np.arange(1, 9)[:, np.newaxis]
    of_mean = j0(2.0 * np.pi * order * sizes) / (np.pi * order)
    assert found.of_mean() == pytest.approx(
        STEP * np.sqrt(0.5 * np.sum(np.mean(of_mean**2, axis=1))), rel=0.35
    )
    of_rms = np.sqrt(2.0) * j1(2.0 * np.pi * order * sizes) / (np.pi * order)
    assert found.of_rms == pytest.approx(STEP * np.sqrt(0.5 * np.sum(np.mean(of_rms**2, axis=1))), rel=0.5)


def test_noise_of_half_a_step_hides_them() -> None:
    noise = 0.7 * STEP * np.random.default_rng(2).standard_normal(COUNT)
    assert steps_along(read(2.0 + sinusoid(3.3, 17.3) + noise), STEP) is None
    assert steps_along(read(2.0 + noise), STEP) is None


@pytest.mark.parametrize("swing", [0.0, 0.3])
@pytest.mark.parametrize("periods", [40.0, 37.3])
@pytest.mark.parametrize("steps", [1.4, 300.0])
def test_periods_of_one_waveform_are_read_alike(periods: float, swing: float, steps: float) -> None:
    place = np.arange(COUNT) / COUNT
    turns = periods * place + swing * np.sin(2.0 * np.pi * 1.7 * place)
    waveform = steps * STEP * (np.cos(2.0 * np.pi * turns) + 0.1 * np.cos(10.0 * np.pi * turns))
    assert are_read_alike(read(2.0 + waveform), turns, STEP)


@pytest.mark.parametrize("count", [3, 4, 7])
def test_few_samples_are_read_alike(count: int) -> None:
    assert are_read_alike(np.arange(float(count)), np.arange(float(count)), 1.0)


@pytest.mark.parametrize("cycles", [3.3, 1.5 * 37.3])
def test_periods_on_a_slow_line_or_two_of_which_are_one_are_not(cycles: float) -> None:
    turns = 37.3 * np.arange(COUNT) / COUNT
    waveform = 3.0 * STEP * np.cos(2.0 * np.pi * turns)
    assert are_read_alike(read(2.0 + waveform), turns, STEP)
    assert not are_read_alike(read(2.0 + waveform + sinusoid(2.0, cycles)), turns, STEP)
