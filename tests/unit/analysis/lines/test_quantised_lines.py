"""Lines of a spectrum that are read in the steps of a converter."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j1

from benchtool.analysis.lines.lines import sinusoids_of
from benchtool.analysis.lines.steadiness import Line
from tests.at_length import at_length

Floats = NDArray[np.float64]

COUNT, STEP = 3_000, 0.05


def read(steps: float, cycles: float, mean: float, noise: float = 0.0, seed: int = 0) -> Floats:
    random = np.random.default_rng(seed)
    turns = cycles * np.arange(COUNT) / COUNT + random.random()
    signal = mean + steps * np.cos(2.0 * np.pi * turns) + noise * random.standard_normal(COUNT)
    return np.asarray(STEP * np.round(signal))


def largest(samples: Floats) -> Line:
    return sinusoids_of(samples)[0]


def of_bessel_functions(steps: float, mean: float) -> float:
    order = np.arange(1, 200)
    size = 2.0 * (-1.0) ** order / (np.pi * order) * j1(2.0 * np.pi * order * steps)
    return float(STEP * size @ np.cos(2.0 * np.pi * order * mean))


@pytest.mark.parametrize("cycles", [70.7, *at_length(7.3, 13.7)])
def test_an_amplitude_is_as_uncertain_as_steps_make_it(cycles: float) -> None:
    errors, ratios = [], []
    for number, steps in enumerate(np.linspace(2.0, 5.75, 16)):
        mean = 40.0 + (number * 5 % 16) / 16.0
        line = largest(read(steps, cycles, mean, seed=number))
        errors.append(line.amplitude - steps * STEP)
        ratios.append(errors[-1] / line.of_amplitude)
        if cycles > 50.0:  # at random places of the period
            assert errors[-1] == pytest.approx(of_bessel_functions(steps, mean), abs=0.02 * STEP)
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.4
    assert np.sqrt(np.mean(np.square(errors))) > 0.02 * STEP


def test_levels_at_the_mean_err_more_than_levels_beside_it() -> None:
    """A quarter of a step from a level the first term is nothing."""
    at, beside = (largest(read(4.375, 31.3, mean)).of_amplitude for mean in (40.0, 40.25))
    assert at > 1.3 * beside


def test_noise_of_a_step_hides_steps_and_noise_of_a_tenth_does_not() -> None:
    little, much = (largest(read(3.3, 9.7, 40.1, noise)) for noise in (0.1, 1.0))
    assert little.of_amplitude > 10.0 * 0.1 * STEP * np.sqrt(2.0 / COUNT)
    assert much.of_amplitude == pytest.approx(STEP * np.sqrt(2.0 * 1.5 / COUNT), rel=0.5)


def test_a_weak_line_on_a_large_one_is_not_as_uncertain_as_a_step() -> None:
    random, turns = np.random.default_rng(3), np.arange(COUNT) / COUNT
    ratios, standard = [], []
    for _ in range(12):
        begin = random.random(3)
        signal = 40.0 + begin[0] + 5.0 * np.cos(2.0 * np.pi * (12.3 * turns + begin[1]))
        signal += 0.6 * np.cos(2.0 * np.pi * (231.7 * turns + begin[2]))
        weak = min(sinusoids_of(STEP * np.round(signal)), key=lambda each: abs(each.place - 231.7))
        ratios.append((weak.amplitude - 0.6 * STEP) / weak.of_amplitude)
        standard.append(weak.of_amplitude)
    assert np.median(standard) < 0.1 * STEP
    assert np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_a_long_record_is_looked_up_at_some_of_its_rows() -> None:
    turns = np.arange(100_000) / 100_000
    line = largest(STEP * np.round(40.1 + 3.3 * np.cos(2.0 * np.pi * (9.7 * turns + 0.2))))
    assert line.of_amplitude == pytest.approx(largest(read(3.3, 9.7, 40.1)).of_amplitude, rel=0.4)
