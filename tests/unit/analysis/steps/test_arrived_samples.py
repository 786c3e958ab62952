"""Mean, extremes and rms of samples that have arrived: uncertain by noise, resolution and their first row."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.steps.arrival import row_at_rest
from benchtool.analysis.steps.arrived_samples import ArrivedSamples
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.uncertainty import Uncertainty

ROWS, TAU, NOISE = 1000, 20.0, 1e-3
COURSE = 1.0 - np.exp(-np.arange(ROWS) / TAU)
ARRIVED = Instant(TAU * math.log(50.0), 0.1)


def _samples(
    values: NDArray[np.float64], step: float = 0.0, begin: Instant = ARRIVED, scatter: float = 0.0
) -> ArrivedSamples:
    curve = NoisyCurve(COURSE, np.empty((0, ROWS)), scatter)
    return ArrivedSamples.of(values, curve, begin, 0.02, Noise(np.zeros(1)), step)


def _standard(found: Uncertainty | None) -> float:
    assert found is not None
    return found.standard


def _noisy(seed: int, heavy: bool = False) -> NDArray[np.float64]:
    random = np.random.default_rng(seed)
    noise = random.standard_t(3, ROWS) if heavy else random.standard_normal(ROWS)
    return COURSE + NOISE * noise


def test_the_way_to_a_level_is_no_scatter_of_the_mean() -> None:
    found = [_standard(_samples(_noisy(seed)).of_mean()) for seed in range(5)]
    of_white = NOISE / math.sqrt(ROWS - ARRIVED.place)
    assert np.median(found) == pytest.approx(of_white, rel=0.5)


def test_the_least_on_the_way_is_known_as_one_sample_is() -> None:
    # it is the first, at 98 %, which no other can be
    found = [_standard(_samples(_noisy(seed)).of_least()) for seed in range(5)]
    assert np.median(found) == pytest.approx(NOISE, rel=0.7)


def test_a_level_of_a_converter_is_anywhere_within_its_step() -> None:
    step = 0.01
    random = np.random.default_rng(1)
    offsets = random.uniform(-0.5, 0.5, 40) * step
    numbers: list[tuple[float, float, float]] = []
    for offset in offsets.tolist():
        found = _samples(step * np.round((COURSE + offset) / step) - offset, step)
        error = float(np.mean(found.values - COURSE[-len(found.values) :]))
        numbers.append((error, _standard(found.of_mean()), _standard(found.of_greatest())))
    error, of_mean, of_greatest = np.array(numbers).T
    assert 0.7 < np.sqrt(np.mean((error / of_mean) ** 2)) < 1.4
    assert np.all(of_greatest >= step / math.sqrt(12.0) * (1.0 - 1e-9))


def test_the_row_of_the_first_sample_is_in_doubt_as_far_as_it_changes_the_least() -> None:
    sure, doubtful = (_samples(COURSE, begin=Instant(ARRIVED.place, rows)) for rows in (0.01, 5.0))
    slope = 0.02 / TAU
    assert _standard(doubtful.of_least()) - _standard(sure.of_least()) == pytest.approx(5.0 * slope, rel=0.2)
    assert _standard(doubtful.of_greatest()) == pytest.approx(_standard(sure.of_greatest()), abs=1e-6)


def test_a_value_on_the_way_is_uncertain_by_the_time_of_its_row() -> None:
    scatter = 0.3
    of_least = _standard(_samples(COURSE, begin=Instant(ARRIVED.place, 0.0), scatter=scatter).of_least())
    assert of_least == pytest.approx(scatter * 0.02 / TAU, rel=0.1)


def test_the_extreme_of_a_line_that_scatters_is_one_of_few_crests() -> None:
    random = np.random.default_rng(4)
    greatest, standard = [], []
    for _ in range(30):
        memory = 150
        white = random.standard_normal((2, ROWS + 5 * memory))
        shape = np.exp(-np.arange(5 * memory) / memory) * math.sqrt(2.0 / memory)
        slow = [np.convolve(each, shape, mode="valid")[:ROWS] for each in white]
        phase = 0.7 * np.arange(ROWS)
        found = _samples(COURSE + NOISE * (slow[0] * np.cos(phase) + slow[1] * np.sin(phase)))
        greatest.append(float(np.max(found.values)))
        standard.append(_standard(found.of_greatest()))
    assert 0.6 < np.std(greatest) / np.sqrt(np.mean(np.square(standard))) < 1.5


def test_a_first_row_that_is_one_of_twenty_by_chance_counts() -> None:
    """The least value is the first, unless one row earlier counts, as in four of eighty draws."""
    place = math.floor(ARRIVED.place) + 0.3
    drawn = (place - 0.6,) * 4 + (place + 0.1,) * 76
    samples = _samples(COURSE, begin=Instant(place, 0.2, drawn))
    row = math.ceil(place)
    apart = COURSE[row] - COURSE[row - 1]
    assert _standard(samples.of_least()) == pytest.approx(apart * math.sqrt(0.05), rel=0.35)


def test_the_greatest_of_normal_noise_scatters_as_such_extremes_do() -> None:
    random = np.random.default_rng(5)
    scatter = np.std([np.max(random.standard_normal(ROWS)) for _ in range(400)]) * NOISE
    found = [_standard(_samples(_noisy(seed)).of_greatest()) for seed in range(10)]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(scatter, rel=0.25)


def test_the_least_of_few_rows_on_the_way_scatters_as_the_noise_at_rest_does() -> None:
    """A ripple makes one of a few rows the least: those at rest tell by how much that differs."""
    random = np.random.default_rng(15)
    row = np.arange(3000)
    course = 1.0 - np.exp(-row / TAU) - 0.05 * np.exp(-((row - 150.0) ** 2) / 6000.0)
    curve = NoisyCurve(course, np.empty((0, len(row))))
    least, standard = [], []
    for _ in range(40):
        ripple = 0.02 * np.cos(0.46 * row + random.uniform(0.0, 2.0 * np.pi))
        values = course + ripple + 3.0 * NOISE * random.standard_normal(len(row))
        found = ArrivedSamples.of(values, curve, Instant(110.0, 0.0), 0.02, Noise(np.zeros(1)), 0.0)
        least.append(float(np.min(found.values)))
        standard.append(_standard(found.of_least()))
    assert 0.6 < np.std(least) / np.median(standard) < 1.4


def test_a_ripple_beyond_the_band_comes_to_rest() -> None:
    """All that has arrived, with its way, was taken to be at rest, and the way for noise."""
    ripple = 0.03 * np.cos(0.05 * np.arange(ROWS))
    assert row_at_rest(COURSE + ripple, 78, 0.02, 0.02, 0) > 100
    assert row_at_rest(COURSE + ripple, 78, 0.05, 0.02, 0) > 100
    assert row_at_rest(COURSE, 78, 0.02, 1e-4, 0) > 100


def test_noise_that_moves_the_first_row_moves_the_samples_there_as_much() -> None:
    """What the greatest magnitude is where it begins is the level that the instant is defined by."""
    random = np.random.default_rng(6)
    far = tuple((ARRIVED.place + 5.0 * random.standard_normal(80)).tolist())
    error = -0.02 * np.exp(-np.maximum(np.arange(ROWS) - ARRIVED.place, 0.0) / TAU)
    found = _samples(error, begin=Instant(ARRIVED.place, 5.0, far)).of_magnitude()
    assert _standard(found) < 2.0 * 0.02 / TAU


def test_the_largest_of_clicks_of_one_size_differs_as_they_do() -> None:
    found = []
    for seed in range(20):
        random = np.random.default_rng(seed)
        values = _noisy(seed)
        hit = random.random(ROWS) < 0.012
        values[hit] += 10.0 * NOISE * random.choice([-1.0, 1.0], int(np.sum(hit)))
        found.append(_standard(_samples(values).of_greatest()))
    assert 0.4 * NOISE < np.median(found) < 2.0 * NOISE


def test_heavy_noise_has_larger_values_than_the_record_also_where_none_is_at_rest() -> None:
    """A record of few samples after the answer has settled, of which no twenty are at rest."""
    random, greatest, standard = np.random.default_rng(12), [], []
    for _ in range(40):
        noise = NOISE * random.standard_t(3, ROWS)
        samples = COURSE + noise
        curve = NoisyCurve(COURSE, np.empty((0, ROWS)))
        begin = Instant(0.6 * ROWS, 0.1)
        found = ArrivedSamples.of(samples, curve, begin, 0.0, Noise.of(noise), 0.0)
        assert found.at_rest == 0
        greatest.append(float(np.max(found.values)))
        standard.append(_standard(found.of_greatest()))
    assert 0.4 < float(np.std(greatest)) / float(np.sqrt(np.mean(np.square(standard)))) < 1.6


def test_clicks_on_one_side_may_be_on_the_other_in_the_next_record() -> None:
    samples = _noisy(3)
    clicks = np.array([300, 420, 640, 860])
    samples[clicks] += NOISE * np.array([20.0, 35.0, 50.0, 25.0])
    least = _standard(_samples(samples).of_least())
    assert least > 5.0 * NOISE
    # exponential noise has a tail on one side only, and its largest values say so
    skewed = COURSE + NOISE * np.random.default_rng(5).standard_exponential(ROWS)
    found = _samples(skewed)
    assert _standard(found.of_least()) < 0.5 * _standard(found.of_greatest())


def test_a_ripple_that_is_left_in_the_course_makes_no_product_with_itself() -> None:
    """The course that is found has a third of the ripple; the error of the mean square is that of the course
    without."""
    random, row = np.random.default_rng(31), np.arange(ROWS)
    phases = random.uniform(0.0, 2.0 * np.pi, (12, 1))
    ripples = 0.02 * np.cos(0.46 * row + phases)
    course = 1.0 - COURSE  # as the error against a reference
    begin = Instant(ARRIVED.place, 0.1, tuple((ARRIVED.place + 0.1 * random.standard_normal(80)).tolist()))
    errors, stated = [], []
    for number, ripple in enumerate(ripples):
        others = np.roll(ripples, -number, axis=0)[1:] / 3.0
        noise = Noise.of(ripple + NOISE * random.standard_normal(ROWS))
        values = course + ripple + NOISE * random.standard_normal(ROWS)
        curve = NoisyCurve(course + ripple / 3.0, others)
        found = ArrivedSamples.of(values, curve, begin, 0.02, noise, 0.0)
        arrived = row >= ARRIVED.place
        truth = math.sqrt(float(np.mean(course[arrived] ** 2)) + 0.02**2 / 2.0 + NOISE**2)
        stated.append(_standard(found.of_rms()))
        errors.append((found.rms - truth) / stated[-1])
    assert np.median(stated) < 2e-4  # 4.7e-4 with what the ripple makes of itself
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_at_rest_the_course_of_a_drift_is_a_line_in_which_no_noise_is_left() -> None:
    curve = NoisyCurve(COURSE + 1e-5 * np.arange(ROWS), np.ones((3, ROWS)))
    values = _noisy(33) + 1e-5 * np.arange(ROWS)
    found = ArrivedSamples.of(values, curve, ARRIVED, 0.02, Noise(np.zeros(1)), 0.0)
    assert found.at_rest > 100
    rest = slice(-found.at_rest, None)
    assert np.diff(found.course[rest]) == pytest.approx(np.full(found.at_rest - 1, 1e-5), rel=0.1)
    assert np.ptp(np.diff(found.course[rest])) < 1e-12
    assert not np.any(found.course_errors[:, rest])
    assert np.all(found.course_errors[:, : -found.at_rest] == 1.0)
