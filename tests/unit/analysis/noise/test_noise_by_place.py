"""Noise of some places of the period, whose spectrum repeats itself from order to order."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.noise.noise_by_place import repetition_of_bins
from tests.unit.analysis.noise.lines_in_noise import floor_of, spectrum_of_bins

PERIODS, SIZE, RECORDS = 40, 100, 16


def _repetition(places: np.ndarray[tuple[int], np.dtype[np.float64]], periods: int = PERIODS) -> float:
    """Return the mean over records of that of noise whose rms at each place of a period is given."""
    noise = np.random.default_rng(0).standard_normal((RECORDS, periods, SIZE)) * places
    phasors = np.fft.rfft(noise.reshape(RECORDS, -1))
    bins = np.arange(1, phasors.shape[1])
    return float(np.mean([repetition_of_bins(each, periods, bins) for each in phasors]))


def test_noise_of_all_places_has_bins_of_its_own() -> None:
    assert _repetition(np.ones(SIZE)) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("periods", [10, PERIODS])
@pytest.mark.parametrize("share", [0.5, 0.25, 0.1])
def test_noise_of_a_part_of_the_places_repeats_itself_as_often(periods: int, share: float) -> None:
    """Var of the sum of squares over that of all places: the mean of sigma^4 over the square of the mean."""
    found = _repetition(np.asarray(np.arange(SIZE) < share * SIZE, dtype=np.float64), periods)
    assert found == pytest.approx(1.0 / share, rel=0.25)


def test_at_one_place_all_orders_are_the_same() -> None:
    at_one = np.zeros(SIZE)
    at_one[7] = 1.0
    assert _repetition(at_one) == pytest.approx(SIZE // 2, rel=0.05)


def test_a_resonance_has_bins_of_its_own() -> None:
    """Most of its power is in two orders, of which some are alike by chance."""
    rng = np.random.default_rng(2)
    bins = np.arange(1, 1 + PERIODS * SIZE // 2)
    shape = 1.0 / (1.0 + ((bins - 300.0) / PERIODS) ** 2)
    for _ in range(RECORDS):
        noise = rng.standard_normal(len(bins)) + 1j * rng.standard_normal(len(bins))
        assert repetition_of_bins(np.append(0.0, shape * noise), PERIODS, bins) < 1.5


def test_too_few_periods_tell_nothing_of_it() -> None:
    assert _repetition(np.ones(SIZE), 6) == 1.0


def test_the_floor_of_a_flicker_is_known_as_well_as_its_few_bins_tell() -> None:
    """Half of the scatter of a median of 39 exponential powers, and no less for their repetition."""
    flicker = np.zeros(PERIODS * SIZE)
    flicker[7::SIZE] = np.random.default_rng(1).standard_normal(PERIODS)
    found = floor_of(spectrum_of_bins(np.fft.rfft(flicker), PERIODS))
    assert found.of_bins == pytest.approx(0.5 / np.log(2.0) / np.sqrt(PERIODS), rel=0.3)
