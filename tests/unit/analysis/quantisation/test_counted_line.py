"""Lines through whole counts, and what steps that beat with the rows do to a line by least squares."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.counted_line import (
    least_spread,
    line_through_counts,
    of_slow_beats,
)

_ROWS = np.arange(2000, dtype=np.float64)


def _counts(slope: float, offset: float = 0.3) -> np.ndarray:
    return np.floor(slope * _ROWS + offset)


@pytest.mark.parametrize("about", [0.5, 2.048, 1.0 / 3.0, 0.7390851])
def test_the_slope_of_counts_is_within_its_uncertainty_near_and_far_of_ratios(about: float) -> None:
    random = np.random.default_rng(7)
    errors = []
    for _ in range(100):
        # from a slope at which the counts repeat to one at which they run through all of a step
        slope = about + random.uniform(-1.0, 1.0) * 2.0 / len(_ROWS)
        line = line_through_counts(_counts(slope, random.uniform(0.0, 1.0)), _ROWS, 1.0)
        assert line is not None
        errors.append((line.slope - slope) / line.standard)
    assert 0.8 < np.sqrt(np.mean(np.square(errors))) < 1.2
    assert np.mean(np.abs(errors) <= 2.0) >= 0.9


def test_counts_that_repeat_allow_all_slopes_between_their_steps() -> None:
    # 0, 0, 1, 1, ...: from a rational slope to either side half a count is left over the record
    line = line_through_counts(_counts(0.5), _ROWS, 1.0)
    assert line is not None
    assert line.slope == pytest.approx(0.5, abs=1e-7)
    assert line.standard == pytest.approx(0.5 / len(_ROWS) / np.sqrt(6.0), rel=0.01)  # a triangle's


def test_of_steps_of_any_size_at_any_places_the_slope_is_scaled() -> None:
    plain = line_through_counts(_counts(0.739), _ROWS, 1.0)
    scaled = line_through_counts(0.02 * _counts(0.739) + 5.0, 1e-4 * (_ROWS - 1e3), 0.02)
    assert plain is not None
    assert scaled is not None
    assert scaled.slope == pytest.approx(200.0 * plain.slope, rel=1e-12)
    assert scaled.standard == pytest.approx(200.0 * plain.standard, rel=1e-5)


def test_counts_that_no_line_gives_have_no_slope() -> None:
    bent = np.floor(0.739 * _ROWS + 2e-6 * _ROWS**2)
    assert line_through_counts(bent, _ROWS, 1.0) is None
    assert least_spread(bent, _ROWS).spread > 1.0


def test_the_least_spread_is_that_of_the_best_slope() -> None:
    noisy = 0.3 * _ROWS + np.random.default_rng(1).uniform(-1.0, 1.0, len(_ROWS))
    best = least_spread(noisy, _ROWS)
    others = [np.ptp(noisy - slope * _ROWS) for slope in np.linspace(0.299, 0.301, 2001)]
    assert best.spread <= min(others)
    assert best.spread == pytest.approx(np.ptp(noisy - best.slope * _ROWS))


@pytest.mark.parametrize("sigma", [0.02, 0.1, 0.2])
@pytest.mark.parametrize("parts", [2, 3, 5])
def test_what_slow_beats_add_to_a_line_by_least_squares(sigma: float, parts: int) -> None:
    random = np.random.default_rng(parts)
    errors, stated = [], []
    about = _ROWS - np.mean(_ROWS)
    for _ in range(200):
        slope = 1.0 / parts + random.uniform(-1.0, 1.0) * 0.5 / (parts * len(_ROWS))
        counts = np.floor(
            slope * _ROWS + random.uniform(0.0, 1.0) + sigma * random.standard_normal(len(_ROWS))
        )
        fitted, offset = np.polyfit(about, counts, 1)
        left = float(np.std(counts - fitted * about - offset))
        errors.append((fitted - slope) * len(_ROWS))
        of_noise = np.sqrt(12.0) * left / np.sqrt(len(_ROWS))
        stated.append(np.hypot(of_slow_beats(1.0, fitted, len(_ROWS), left), of_noise))
    ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(stated)))
    assert ratio < 1.4


def test_steps_that_run_through_their_phases_beat_hardly() -> None:
    assert of_slow_beats(1.0, 0.7390851, 2000, np.sqrt(1.0 / 12.0)) < 0.1 * of_slow_beats(
        1.0, 0.5001, 2000, 0.25
    )


@pytest.mark.parametrize(
    ("cycles", "gained"), [(0.2, 2.6), (1.5, 6.0 / (np.pi * 1.5)), (3.9, 6.0 / (np.pi * 3.9)), (4.1, 0.0)]
)
def test_a_beat_adds_less_the_oftener_it_turns(cycles: float, gained: float) -> None:
    sigma = 0.4  # of a step: the first harmonic alone is left
    left = np.sqrt(1.0 / 12.0 + sigma**2)
    first = np.exp(-2.0 * (np.pi * sigma) ** 2) / np.pi
    found = of_slow_beats(0.5, 1.0 + cycles / len(_ROWS), len(_ROWS), 0.5 * left)
    assert found == pytest.approx(0.5 * first * gained / np.sqrt(2.0), rel=1e-3, abs=1e-7)


def test_counts_that_leave_no_room_have_one_slope() -> None:
    line = line_through_counts(np.array([0.0, 1.0, 0.0]) + 2.0 * np.arange(3.0), np.arange(3.0), 1.0)
    assert line is not None
    assert line.slope == pytest.approx(2.0)
    assert line.standard == 0.0
