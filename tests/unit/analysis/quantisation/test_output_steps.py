"""What steps of a converter make of a response alike at all frequencies: outputs that rest at few values."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from benchtool.analysis.quantisation.output_steps import errors_of_equal_readings, errors_of_output_steps

ROWS, REACH = 16_000, 16


@pytest.mark.parametrize(("tau_rows", "held_rows", "step"), [(12, 40, 0.09), (9, 32, 0.046), (14, 51, 0.093)])
def test_the_gain_of_steps_is_that_of_the_lag_s_output(tau_rows: int, held_rows: int, step: float) -> None:
    """A response is known from a lowest frequency on, below which a lag still turns."""
    random = np.random.default_rng(3)
    x = np.repeat(random.choice([-1.0, 1.0], ROWS // held_rows + 1), held_rows)[:ROWS]
    left = np.exp(-1.0 / tau_rows)
    y = np.asarray(signal.lfilter([0.0, 1.0 - left], [1.0, -left], x))
    at = np.arange(REACH, ROWS // 2 - REACH, REACH)
    later = np.exp(-2j * np.pi * (at + 1) / ROWS)
    response = (1.0 - left) * later / (1.0 - left * later)

    _, _, found = errors_of_output_steps(x, step * np.round(y / step), response, at)

    sizes = 1.0 + step * np.linspace(-0.5, 0.5, 101)
    errors = [step * np.round(size * y / step) - size * y for size in sizes]
    gains = [float(error @ y) / float(y @ y) for error in errors]
    assert found == pytest.approx(np.sqrt(np.mean(np.square(gains))), rel=0.2)


def test_an_output_without_steps_has_none() -> None:
    random = np.random.default_rng(4)
    x = random.standard_normal(ROWS)
    at = np.arange(REACH, ROWS // 2 - REACH, REACH)

    error, alike, gain = errors_of_output_steps(x, 0.5 * x, np.full(len(at), 0.5 + 0.0j), at)

    assert not np.any(error)
    assert np.all(alike == 1.0)
    assert gain == 0.0


def test_readings_that_an_output_rests_at_have_one_error_each() -> None:
    """A fast lag after the bits of a sequence rests at few values; a slow one moves through all levels."""
    bits, _ = signal.max_len_seq(10)
    random = np.random.default_rng(6)
    x = np.tile(np.repeat(2.0 * bits - 1.0, 2), 2)
    period = len(x) // 2
    at = np.arange(period // 2 - 16)
    found, actual = [], []
    for left, is_fast in ((0.47, True), (0.995, False)):
        y = np.asarray(signal.lfilter([1.0 - left], [1.0, -left], x))[period:]
        step = float(np.ptp(y)) / 230.0
        later = np.exp(-2j * np.pi * (at + 1) / period)
        response = (1.0 - left) / (1.0 - left * later)
        drawn = random.uniform([0.9, 0.0], [1.1, 1.0], (200, 2))
        read = [step * size * (np.round(y / (step * size) + part) - part) for size, part in drawn]
        errors = [float((each - y) @ (y - np.mean(y))) / float(np.var(y)) / len(y) for each in read]
        _, _, gain = errors_of_equal_readings(x[:period], read[7], 0.0, response, at)
        found.append(gain)
        actual.append(float(np.sqrt(np.mean(np.square(errors)))))
        assert is_fast == (gain > 3e-4)
    assert 0.7 < found[0] / actual[0] < 2.2


def test_readings_of_few_lines_have_nothing_in_common() -> None:
    period = 2000
    x = np.cos(2.0 * np.pi * 3.0 * np.arange(period) / period)
    y = np.round(x / 0.01) * 0.01
    response = np.ones(1, dtype=np.complex128)
    assert errors_of_equal_readings(x, y, 0.0, response, np.array([2]))[2] == 0.0
