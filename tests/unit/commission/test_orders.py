"""Speeds without what the angle of their shaft repeats."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.commission.estimators.orders import without_orders

ROW_S, ROWS, PERIODS = 1e-3, 400, 6
RNG = np.random.default_rng(5)


def answer() -> np.ndarray:
    """What a stimulus that repeats itself makes of the speed: mean 60 rad/s, 5 rad/s rms."""
    kernel = np.exp(-np.arange(ROWS) / 40.0)
    played = RNG.choice((-1.0, 1.0), ROWS // 20).repeat(20)
    one = np.fft.irfft(np.fft.rfft(played) * np.fft.rfft(kernel), ROWS)
    return np.tile(60.0 + 5.0 * (one - one.mean()) / one.std(), PERIODS)


def cogging(speed: np.ndarray, order: int, amplitude: float) -> np.ndarray:
    """What an order of the revolution adds; the amplitude falls with the speed, as inertia has it."""
    theta = np.cumsum(speed) * ROW_S
    return amplitude * 60.0 / speed * np.cos(order * theta + 0.7)


def test_what_an_order_adds_is_taken_out_and_the_answer_stays() -> None:
    clean = answer()
    noise = 0.05 * RNG.standard_normal(len(clean))
    seen = clean + cogging(clean, 8, 9.0) + noise
    assert float(np.std(seen - clean)) > 6.0
    left = without_orders(seen, ROWS, ROW_S, (1, 8)) - clean
    assert float(np.std(left)) < 0.6


def test_a_speed_without_orders_keeps_its_answer() -> None:
    clean = answer()
    seen = clean + 0.2 * RNG.standard_normal(len(clean))
    mean = without_orders(seen, ROWS, ROW_S, (1, 2, 4, 8, 24)).reshape(PERIODS, ROWS).mean(axis=0)
    assert mean == pytest.approx(clean[:ROWS], abs=4.0 * 0.2 / math.sqrt(PERIODS))


def test_rows_beyond_whole_periods_and_few_periods_stay_as_they_are() -> None:
    seen = answer() + RNG.standard_normal(ROWS * PERIODS)
    found = without_orders(seen[: 3 * ROWS + 7], ROWS, ROW_S, (8,))
    assert np.array_equal(found[3 * ROWS :], seen[3 * ROWS : 3 * ROWS + 7])
    assert np.array_equal(without_orders(seen[: 2 * ROWS], ROWS, ROW_S, (8,)), seen[: 2 * ROWS])
