"""Signals that a converter of few steps would read alike, against the one that it has read."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.repeated_steps import repeated_steps, rms_before_steps, steps_of_periods
from tests.at_length import at_length

SAMPLES, TURNS, RECORDS = 8_000, 37, 6
THETA = 2.0 * np.pi * TURNS * np.arange(SAMPLES) / SAMPLES
WAVES = np.exp(1j * np.outer(np.arange(1, 41), THETA))
MOST = 1.4 * (1.0 + 1.0 / np.sqrt(RECORDS))  # as `benchmarks.coverage` has it


def _errors(random: np.random.Generator, amplitude: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much mean, rms, order 6 and order 4 of a record in steps of 1 are off, and by how much
    they are said to be; order 4 is a tenth of order 6."""
    mean, turn = random.uniform(0.0, 1.0), random.uniform(0.0, 2.0 * np.pi, 2)
    clean = mean + amplitude * (np.cos(6.0 * THETA + turn[0]) + 0.1 * np.cos(4.0 * THETA + turn[1]))
    read = np.round(clean + noise * random.standard_normal(SAMPLES))
    phasors = 2.0 * np.conj(WAVES) @ read / SAMPLES
    repeated = np.mean(read) + np.real(phasors @ WAVES)
    beside = float(np.mean((read - repeated) ** 2))
    found = repeated_steps(float(np.mean(read)), phasors, 1.0, beside, SAMPLES, TURNS, level=0.0)
    assert found is not None
    rms = np.sqrt(0.505 * amplitude**2 + noise**2)
    size = np.abs(phasors)
    rms_read = rms_before_steps(float(np.std(read)), 1.0, found)
    off = [np.mean(read) - mean, rms_read - rms, size[5] - amplitude, size[3] - 0.1 * amplitude]
    lines = found.of_lines(phasors)[0]
    of_noise = np.sqrt(beside / SAMPLES)
    said = [found.of_mean(), found.of_rms, lines[5], lines[3]]
    return np.array(off), np.hypot(said, np.array([1.0, 0.7, 1.4, 1.4]) * of_noise)


@pytest.mark.parametrize(("amplitude", "noise"), [(0.6, 0.1), *at_length((1.1, 0.05), (2.5, 0.1))])
def test_errors_of_few_steps_are_as_large_as_said(amplitude: float, noise: float) -> None:
    random = np.random.default_rng(11)
    found = [_errors(random, amplitude * random.uniform(0.8, 1.2), noise) for _ in range(RECORDS)]
    relative = np.array([off / said for off, said in found])
    assert np.all(np.sqrt(np.mean(relative**2, axis=0)) < MOST)
    # of the order itself, neither much wider than it is
    assert np.sqrt(np.mean(relative[:, 2] ** 2)) > 0.5


def test_noise_of_half_a_step_makes_a_coarse_mean_and_order_sure() -> None:
    """The same order, 0.4 steps: with little noise it is uncertain by a tenth of itself at least."""
    said = [_errors(np.random.default_rng(5), 0.4, noise)[1] for noise in (0.1, 0.5)]
    assert said[0][2] > max(0.04, 2.0 * said[1][2])
    assert said[1][0] < 0.01
    assert said[1][2] < 0.03


def test_a_record_that_repeats_to_the_last_digit_and_one_of_a_high_order_are_answered() -> None:
    quiet = repeated_steps(0.4, np.array([0.5 + 0.0j]), 1.0, -1e-30, 6.0, 2, level=0.0)
    phasors = np.zeros(3000, dtype=np.complex128)
    phasors[2999] = 0.7
    high = repeated_steps(0.3, phasors, 1.0, 0.01, 2e5, 20, level=0.0)

    assert quiet is not None
    assert high is not None
    assert high.errors.shape[1] <= 1 << 17
    assert float(high.of_lines(phasors)[0][2999]) > 0.01


@pytest.mark.slow
def test_orders_of_few_steps_without_noise_may_have_any_size_that_passes_the_edges_alike() -> None:
    """Of three orders, the weaker of which readings show no better than those that steps make."""
    random, relative = np.random.default_rng(3), []
    theta = 2.0 * np.pi * 37.3 * np.arange(SAMPLES) / SAMPLES
    for _ in range(RECORDS):
        turn, scale = random.uniform(0.0, 2.0 * np.pi, 3), random.uniform(0.8, 1.2)
        of_orders = [(12, 0.5 * scale), (24, 0.25 * scale), (3, 0.2 * scale)]
        clean = random.uniform() + sum(
            size * np.cos(order * theta + at) for (order, size), at in zip(of_orders, turn, strict=True)
        )
        read = np.round(clean)
        begins = np.ceil(SAMPLES / 37.3 * np.arange(38)).astype(np.int64)
        found = steps_of_periods(read[: begins[-1]], begins, 1, 1.0, theta[: begins[-1]] / (2.0 * np.pi))
        assert found is not None
        read_rms = rms_before_steps(float(np.std(read)), 1.0, found)
        off = np.array([np.mean(read) - np.mean(clean), read_rms - np.std(clean)])
        relative.append(off / np.array([found.of_mean(), found.of_rms]))
    assert np.all(np.sqrt(np.mean(np.square(relative), axis=0)) < MOST)
