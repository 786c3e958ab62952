"""Steps of a converter over which a slow line, or a ripple of no period, takes a signal."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j0, j1

from benchtool.analysis.quantisation.steps_along import (
    are_alike,
    are_read_alike,
    lines_of,
    steps_along,
    steps_of_lines,
)

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


def test_every_other_period_is_told_where_places_lie_evenly() -> None:
    """The nearest in place are an even number of periods away, where order 3 / 2 is at the same place."""
    turns = np.linspace(0.0, 241.3, 12_007, endpoint=False)
    assert not are_read_alike(read(2.0 + STEP * np.cos(3.0 * np.pi * turns + 0.3)), turns, STEP)


def test_lines_between_harmonics_take_periods_to_other_parts_of_the_steps() -> None:
    repeats = 2.0 + sinusoid(3.0, 20.0) + sinusoid(2.0, 100.0)
    assert are_alike(lines_of(read(repeats)), STEP, 20)
    assert not are_alike(lines_of(read(repeats)), STEP)
    assert not are_alike(lines_of(read(repeats + sinusoid(0.8, 33.3))), STEP, 20)


def test_errors_of_lines_are_those_of_readings_with_levels_anywhere() -> None:
    beside, errors = sinusoid(2.3, 33.3), []
    for level in STEP * np.arange(0.0, 1.0, 1.0 / 32.0):
        for steps in (2.9, 3.0, 3.1):
            line = lines_of(read(2.0 + sinusoid(steps, 20.0) + beside, level))[20]
            errors.append(abs(line) - steps * STEP)
    clean = lines_of(read(2.0 + sinusoid(3.0, 20.0) + beside))
    found = steps_of_lines(clean, STEP, 20)
    assert found is not None
    assert found.of_lines(clean[20:400:20])[0][0] == pytest.approx(np.std(errors), rel=0.4)
    assert found.highest_order == COUNT // 2 // 20
