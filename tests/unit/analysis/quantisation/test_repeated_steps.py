"""What a converter's steps repeat, against readings of the same waveform with levels in many places."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.repeated_steps import (
    RepeatedSteps,
    error_of_steps,
    noise_beside,
    periods_to_same_places,
    repeated_steps,
    share_left,
    steps_of_periods,
)
from benchtool.analysis.quantisation.resolution import level_of

PER_PERIOD, PERIODS, STEP = 461.3, 33, 0.04
OWN = STEP**2 / 12.0  # mean square of what steps without noise leave beside what repeats


@pytest.mark.parametrize(("noise", "per_period"), [(0.0, PER_PERIOD), (0.0, 500.0), (0.25 * STEP, 500.0)])
def test_the_stated_errors_are_those_of_readings_with_levels_anywhere(
    noise: float, per_period: float
) -> None:
    random = np.random.default_rng(3)
    phasors = np.zeros(40, dtype=np.complex128)
    phasors[0], phasors[4] = 1.3 * np.exp(0.3j), 0.05 * np.exp(1j)
    stated = repeated_steps(0.1, phasors, STEP, noise**2 + OWN, per_period * PERIODS, PERIODS)
    assert stated is not None
    theta = 2.0 * np.pi / per_period * np.arange(round(per_period * PERIODS))
    clean = 0.1 + 1.3 * np.cos(theta + 0.3) + 0.05 * np.cos(5.0 * theta + 1.0)
    of_means, of_rms, of_fifth, of_power = [], [], [], []
    towards = np.exp(-1j * (5.0 * theta + 1.0))
    orders = np.arange(2, 10)
    turned = np.exp(-1j * np.outer(orders, theta)) * (2.0 / len(theta))
    for _ in range(150):
        offset = STEP * random.uniform(-0.5, 0.5)
        signal = clean + noise * random.standard_normal(len(clean))
        read = STEP * np.round((signal - offset) / STEP) + offset
        of_means.append(np.mean(read - signal))
        of_rms.append(np.std(read) - np.std(signal))
        of_fifth.append(2.0 * np.mean((read - signal) * towards).real)
        of_power.append(np.sum(np.abs(turned @ (read - signal)) ** 2))
    scatter = float(np.std(of_power) / np.mean(of_power))
    if not noise:  # whose power is in that of the readings
        assert stated.scatter_of_power(orders) == pytest.approx(scatter, rel=0.3)
    lines, _ = stated.of_lines(phasors)
    # beside what repeats readings err by noise of a twelfth of the step's square
    rest = STEP / np.sqrt(12.0 * len(clean))
    for measured, expected, of_rest in (
        (of_means, stated.of_mean(), rest),
        (of_rms, stated.of_rms, rest),
        (of_fifth, lines[4], np.sqrt(2.0) * rest),
    ):
        found = float(np.sqrt(np.mean(np.square(measured))))
        assert 0.75 * float(expected) < found < 1.25 * float(np.hypot(expected, of_rest))


@pytest.mark.parametrize("swing_turns", [0.0, 0.03])
def test_places_of_a_speed_that_swings_count_as_often_as_they_are_sampled(swing_turns: float) -> None:
    """Aliased errors fall on lines of the swing; 250 samples a period without it are on 250 places."""
    random = np.random.default_rng(5)
    phasors = np.zeros(40, dtype=np.complex128)
    phasors[0], phasors[4] = 1.3 * np.exp(0.3j), 0.05 * np.exp(1j)
    rows = np.arange(80 * 250)
    turns = rows / 250.0 + swing_turns * np.sin(2.0 * np.pi * 4.0 * rows / len(rows))
    stated = repeated_steps(0.1, phasors, STEP, OWN, float(len(rows)), 80, turns)
    assert stated is not None
    theta = 2.0 * np.pi * turns
    clean = 0.1 + 1.3 * np.cos(theta + 0.3) + 0.05 * np.cos(5.0 * theta + 1.0)
    of_fifth = []
    for _ in range(200):
        offset = STEP * random.uniform(-0.5, 0.5)
        read = STEP * np.round((clean - offset) / STEP) + offset
        of_fifth.append(2.0 * np.mean((read - clean) * np.exp(-1j * (5.0 * theta + 1.0))).real)
    found = float(np.sqrt(np.mean(np.square(of_fifth))))
    assert found == pytest.approx(float(stated.of_lines(phasors)[0][4]), rel=0.2)


@pytest.mark.parametrize("offset", [0.0, 0.5 * STEP, 0.2 * STEP])
def test_levels_that_lie_evenly_about_a_waveform_are_no_chance(offset: float) -> None:
    """Errors of odd harmonics are all in odd ones where a level is at zero or half a step off."""
    random = np.random.default_rng(7)
    theta = 2.0 * np.pi / 128.0 * np.arange(20 * 128)
    relative = []
    for _ in range(80):
        phasors = np.zeros(40, dtype=np.complex128)
        phasors[0] = random.uniform(1.0, 1.6) * np.exp(1j * random.uniform(0.0, 6.3))
        clean = np.real(phasors[0] * np.exp(1j * theta))
        read = STEP * np.round((clean - offset) / STEP) + offset
        assert np.isclose(np.mod((level_of(read, STEP) - offset) / STEP + 0.5, 1.0), 0.5)
        stated = repeated_steps(0.0, phasors, STEP, OWN, float(len(theta)), 20, level=offset)
        assert stated is not None
        error = 2.0 * np.mean((read - clean) * np.exp(-1j * (theta + np.angle(phasors[0])))).real
        relative.append(error / stated.of_lines(phasors)[0][0])
        if offset != 0.2 * STEP:
            assert np.max(stated.of_lines(phasors)[1][1::2]) < 1e-20
    assert 0.75 < np.sqrt(np.mean(np.square(relative))) < 1.3  # 1.8 with levels anywhere


def test_noise_hides_the_steps() -> None:
    phasors = np.array([1.0 + 0j])
    assert repeated_steps(0.0, phasors, STEP, STEP**2 + OWN, 10_000.0, 20) is None
    assert noise_beside(STEP**2 / 12.0, STEP) == 0.0
    assert noise_beside(STEP**2 / 12.0 + 9.0, STEP) == pytest.approx(3.0)


@pytest.mark.parametrize("noise_rms", [0.0, 0.1, 0.25, 0.4])
def test_steps_under_noise_leave_what_the_distribution_of_readings_says(noise_rms: float) -> None:
    """The mean reading at each place of a level, by Laplace's distribution function between thresholds."""
    places = (np.arange(400) + 0.5) / 400.0 - 0.5
    edges = np.arange(-8, 8) + 0.5 - places[:, np.newaxis]
    scale = max(noise_rms / np.sqrt(2.0), 1e-9)
    above = np.where(edges < 0.0, 1.0 - 0.5 * np.exp(np.minimum(edges, 0.0) / scale),
                     0.5 * np.exp(-np.maximum(edges, 0.0) / scale))  # fmt: skip
    errors = np.sum(above, axis=1) - 8.0 - places
    of_steps = STEP * float(np.sqrt(np.mean(errors**2)))
    assert share_left(noise_rms * STEP, STEP) * STEP / np.sqrt(12.0) == pytest.approx(of_steps, rel=0.03)


def test_a_waveform_of_periods_that_begin_early_and_late_keeps_its_size() -> None:
    random, per_period, periods, order = np.random.default_rng(1), 500, 60, 6
    late = 0.1 * np.sin(0.7 * np.arange(periods))[:, np.newaxis]
    theta = 2.0 * np.pi * np.arange(per_period) / per_period - late
    clean = np.ravel(0.1 * np.cos(order * theta))
    read = STEP / 4 * np.round((clean - random.uniform()) / (STEP / 4))
    begins, turns = per_period * np.arange(periods + 1), np.arange(len(read)) / per_period
    found = steps_of_periods(read, begins, 1, STEP / 4, turns)
    assert found is not None
    assert np.max(np.abs(found.waveform - np.mean(found.waveform))) == pytest.approx(0.1, rel=0.01)


def test_errors_of_high_orders_do_not_fold_to_low_ones() -> None:
    """A ripple of orders 12 and 24 passes a step far more often than one of order 1 of equal size."""
    random = np.random.default_rng(9)
    theta = 2.0 * np.pi * 10.0 / 20_650.3 * np.arange(20_650)
    relative = []
    for _ in range(32):
        phasors = np.zeros(1000, dtype=np.complex128)
        phasors[[11, 23]] = np.array([50.0, 100.0]) * STEP * np.exp(2j * np.pi * random.uniform(size=2))
        clean = sum(np.real(phasors[k - 1] * np.exp(1j * k * theta)) for k in (12, 24))
        level = STEP * random.uniform()
        error = STEP * np.round((clean - level) / STEP) + level - clean
        stated = repeated_steps(0.0, phasors, STEP, STEP**2 / 12.0, 20_650.3, 10, level=level)
        assert stated is not None
        towards = np.exp(-1j * (12.0 * theta + np.angle(phasors[11])))
        relative.append(2.0 * np.mean(error * towards).real / stated.of_lines(phasors)[0][11])
        assert stated.of_lines(phasors)[1][0] == 0.0  # the waveform repeats twelve times
    assert 0.75 < np.sqrt(np.mean(np.square(relative))) < 1.4


def test_the_largest_of_lines_is_a_quantile_over_the_ensemble() -> None:
    phasors = np.zeros(50, dtype=np.complex128)
    phasors[0] = 30.0
    found = repeated_steps(0.0, phasors, 1.0, 0.0, 200.3 * 20, 20)
    assert found is not None
    orders = np.arange(2, 10)
    assert found.largest_at(orders[:0], 0.95) == 0.0
    each = [float(np.max(np.abs(np.fft.fft(errors)[orders])) * 2.0 / len(errors)) for errors in found.errors]
    assert found.largest_at(orders, 0.95) == pytest.approx(np.quantile(each, 0.95))
    assert found.highest_order == (found.errors.shape[1] - 1) // 2


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_the_error_of_a_signal_is_that_of_its_readings_on_average_over_noise(noise: float) -> None:
    signal, level = np.linspace(-0.1, 0.1, 41) + 0.0013, 0.007
    draws = noise * STEP * np.random.default_rng(2).standard_normal((4000, 1))
    read = level + STEP * np.round((signal + draws - level) / STEP)
    found = error_of_steps(signal, STEP, noise * STEP, level)
    assert found is not None
    assert found == pytest.approx(np.mean(read, axis=0) - signal, abs=0.02 * STEP)
    assert error_of_steps(signal, STEP, STEP, level) is None


def test_steps_that_make_nothing_have_no_scatter_of_it() -> None:
    assert RepeatedSteps(np.ones(8), np.zeros((3, 8)), 1).scatter_of_power(np.arange(1, 4)) == 0.0


@pytest.mark.parametrize(
    ("per_period", "rows", "together"),
    [(500.5, 0.1, 2), (500.0, 0.1, 1), (10.1, 0.01, 10), (10.0 + 1.0 / 11.0, 0.01, None), (10.1, 1.1, 1)],
)
def test_samples_come_to_the_same_places_after_some_periods(
    per_period: float, rows: float, together: int | None
) -> None:
    assert periods_to_same_places(per_period, 10, rows) == together


@pytest.mark.parametrize(("amplitude", "is_few"), [(2.3, True), (20.0, False)])
def test_a_waveform_of_few_steps_has_the_errors_of_all_that_read_alike(
    amplitude: float, is_few: bool
) -> None:
    theta = 2.0 * np.pi * np.arange(40 * 200) / 200.0
    samples = STEP * np.round(amplitude * np.cos(theta + 0.3) + 0.2)
    found = steps_of_periods(samples, np.arange(0, 8001, 200), 1, STEP, np.arange(8000) / 200.0)
    assert found is not None
    assert found.are_few == is_few


def test_readings_of_the_same_places_lie_at_levels_and_say_nothing_of_their_errors() -> None:
    """Of a waveform that fills its band: its errors are as of white noise, and all in what repeats."""
    period, step = 511, 0.02
    waveform = np.random.default_rng(2).standard_normal(period)
    read = step * np.round(waveform / step)
    phasors = np.fft.rfft(read)[1:] * (2.0 / period)
    found = repeated_steps(float(np.mean(read)), phasors, step, 0.0, period * 40.0, 40)
    assert found is not None
    stated = float(np.mean(found.power_at(np.arange(1, 256))))
    assert stated == pytest.approx(4.0 * step**2 / 12.0 / period, rel=0.1)


def test_a_waveform_that_rests_is_read_wrong_by_the_same_at_all_its_places() -> None:
    period, step = 512, 0.02
    rests = np.repeat([0.4, -0.4], period // 2)
    phasors = np.fft.rfft(rests)[1:] * (2.0 / period)
    found = repeated_steps(0.0, phasors, step, 0.0, period * 40.0, 40)
    assert found is not None
    assert found.of_mean(np.r_[np.full(256, 2.0), np.zeros(256)]) > 0.5 * step / np.sqrt(12.0)


def test_lines_that_steps_make_are_none_of_the_waveform() -> None:
    """The power that steps add to one waveform is more than usual, or less."""
    random = np.random.default_rng(5)
    theta = 2.0 * np.pi * np.arange(500) / 500
    for _ in range(40):
        turn, size, level = random.uniform(0.0, 2.0 * np.pi, 2), random.uniform(0.93, 1.07), random.uniform()
        read = np.round(
            level + size * (6.4 * np.cos(6.0 * theta + turn[0]) + 3.2 * np.cos(3.0 * theta + turn[1]))
        )
        phasors = np.fft.rfft(read)[1:] * (2.0 / 500)
        phasors[-1] *= 0.5
        found = repeated_steps(float(np.mean(read)), phasors, 1.0, 0.0, 500.0 * 40.0, 40)
        assert found is not None
        lines = np.abs(np.fft.rfft(found.waveform))[1:] / 250.0
        assert set(np.flatnonzero(lines > 1e-6) + 1) == {3, 6}
