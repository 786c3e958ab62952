"""A curve at rest: what noise makes of it there does not put off when it settled."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.settled_course import SettledCourse

ROWS = np.arange(1200.0)
SIGMA = 2.0  # of the noise
BAND = 5.0 * SIGMA
DRAWS = 80


def noise(random: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Return smooth noise of standard deviation SIGMA, shape (count, rows)."""
    drawn = gaussian_filter1d(random.standard_normal((count, len(ROWS) + 200)), 15.0, axis=1)[:, 100:-100]
    return np.asarray(SIGMA * drawn / np.std(drawn))


def settled(away: NDArray[np.float64], seed: int = 0) -> SettledCourse:
    errors = noise(np.random.default_rng(seed), DRAWS)
    return SettledCourse.of(away, errors, np.std(errors, axis=0), BAND, 0)


def test_a_settling_time_is_as_uncertain_as_its_errors_where_noise_at_rest_nears_the_band() -> None:
    random = np.random.default_rng(5)
    lag = -200.0 * np.exp(-ROWS / 40.0)
    true = 40.0 * np.log(200.0 / BAND)
    errors, stated = [], []
    for _ in range(30):
        found = NoisyCurve(lag + noise(random, 1)[0], noise(random, DRAWS)).last_outside(0.0, BAND)
        assert found is not None
        errors.append(found.place - true)
        stated.append(found.standard)
    relative = np.divide(errors, stated)
    assert 0.7 < np.sqrt(np.mean(relative**2)) < 1.4
    assert np.mean(np.abs(relative) < 2.0) >= 0.9
    # noise of 2 over the slope of 10 / 40 a row is 8 rows; draws that have noise at rest twice made it 77
    assert 6.0 < np.median(stated) < 11.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_may_ring_for_as_long_again_as_it_took(sign: float) -> None:
    errors = noise(np.random.default_rng(3), DRAWS)
    standard, since = np.std(errors, axis=0), 50
    away = sign * np.where(ROWS <= 130, 200.0, 0.0)
    found = SettledCourse.of(away, errors, standard, BAND, since)
    assert (found.last, found.soon, found.sign) == (130, 131 + 80, sign)
    for most, rows in ((found.most_soon, slice(130, 211)), (found.most_late, slice(211, None))):
        greatest = np.max(np.abs(errors[:, rows]) / standard[rows], axis=1)
        assert most == pytest.approx(max(2.0, float(np.quantile(greatest, 0.95))))
    assert found.most_late > found.most_soon
    # what lies between both is noise late, and none where it may ring
    between = 0.25 * found.most_soon + 0.75 * found.most_late
    for at, stays in ((180, True), (900, False)):
        bump = between * standard[at] * np.exp(-0.5 * ((ROWS - at) / 1.5) ** 2)
        course = sign * found.without_noise(away + sign * bump)
        assert (float(np.max(course[150:])) > standard[at]) == stays


def test_a_course_that_settles_late_may_ring_to_its_end() -> None:
    away = np.where(ROWS <= 900, 200.0, 0.0)
    found = settled(away)
    assert found.soon == len(ROWS)
    assert np.all(found.without_noise(away + 0.5 * SIGMA)[901:] < BAND)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_noise_at_rest_is_left_out_and_a_fall_that_is_slow_is_not(sign: float) -> None:
    lag = sign * 200.0 * np.exp(-ROWS / 40.0)
    of_noise = noise(np.random.default_rng(1), 1)[0]
    course = settled(lag).without_noise(lag + of_noise)
    assert np.std(course[400:]) < 0.5 * SIGMA
    slow = lag + sign * 16.0 * np.exp(-ROWS / 500.0)
    course = settled(slow).without_noise(slow)
    assert np.allclose(course, slow)


def test_what_noise_does_not_make_stays() -> None:
    lag = 200.0 * np.exp(-ROWS / 40.0)
    bump = 12.0 * np.exp(-0.5 * ((ROWS - 900.0) / 20.0) ** 2)
    for of_one_side in (bump, -bump):
        away = lag + of_one_side
        found = NoisyCurve(away, noise(np.random.default_rng(2), DRAWS)).last_outside(0.0, BAND)
        assert found is not None
        assert found.place > 880.0


def test_a_lobe_that_may_ring_stays_where_noise_may_hide_how_far_it_goes() -> None:
    """On the way windows are short, and noise is louder than where the band is taken from."""
    louder = np.where(ROWS < 300, 1.6, 1.0)
    errors = louder * noise(np.random.default_rng(0), DRAWS)
    lag = np.where(ROWS < 160, 200.0 * np.exp(-ROWS / 40.0), 0.0)
    found = SettledCourse.of(lag, errors, np.std(errors, axis=0), BAND, 0)
    hides = BAND - 2.0 * 1.6 * SIGMA  # two standard deviations within the band
    assert hides < 0.5 * found.most_soon * 1.6 * SIGMA
    for depth, at, stays in (
        (1.4 * hides, 200.0, True),
        (0.6 * hides, 200.0, False),
        (1.4 * hides, 900.0, False),
    ):
        away = lag - depth * np.exp(-0.5 * ((ROWS - at) / 8.0) ** 2)
        assert (np.min(found.without_noise(away)[120:]) < -0.9 * depth) == stays


def test_an_answer_that_creeps_and_rings_may_leave_the_band_once_more() -> None:
    random = np.random.default_rng(7)
    turn = 2.0 * np.pi * ROWS / 168.0
    rings = 15.0 * np.exp(-ROWS / 221.0) * (np.cos(turn) + 0.12 * np.sin(turn))
    answer = -BAND * (5.0 * np.exp(-ROWS / 600.0) + rings)
    true = float(np.flatnonzero(np.abs(answer) > BAND)[-1])
    relative = []
    for _ in range(40):
        read = NoisyCurve(answer + 0.4 * noise(random, 1)[0], 0.4 * noise(random, DRAWS))
        found = read.last_outside(0.0, BAND)
        assert found is not None
        relative.append((found.place - true) / found.standard)
    assert np.sqrt(np.mean(np.square(relative))) < 1.4
    assert np.mean(np.abs(relative) < 2.0) >= 0.9


def test_a_row_that_noise_takes_beyond_the_band_among_many_at_rest_is_not_still_ringing() -> None:
    random, band, rms = np.random.default_rng(4), 0.01, 0.008
    rows = np.arange(5000)
    away = np.exp(-rows / 12.0)
    away[4000] = band + 2.2 * rms
    errors = rms * random.standard_normal((80, len(rows)))
    found = SettledCourse.of(away, errors, np.full(len(rows), rms), band, 0)
    assert found.last < 60
    assert found.soon < 200
    assert np.max(np.abs(found.without_noise(away)[200:])) < band


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_whether_a_curve_at_rest_or_a_burst_of_its_noise_leaves_the_band_is_undecided(sign: float) -> None:
    random = np.random.default_rng(11)
    lag, errors = -200.0 * np.exp(-ROWS / 40.0), noise(random, DRAWS)
    errors[:, 250:300] += 3.0 * SIGMA  # as much as bursts make at other times
    late = np.exp(-(((ROWS - 900.0) / 8.0) ** 2))
    undecided = []
    for height_in_sigma in (4.0, 9.0, 40.0):
        found = NoisyCurve(lag + sign * height_in_sigma * SIGMA * late, errors).last_outside(0.0, BAND)
        assert found is not None
        undecided.append(not np.isfinite(found.standard))
    assert undecided == [False, True, False]
