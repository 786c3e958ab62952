"""Whether the last lobe leaves the band: what noise decides is as uncertain as both places are apart."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchtool.analysis.steps.lobes import rms_beyond_lobes
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.passages import last_passage

BAND = 0.02
ROWS = np.arange(240.0)
LOBE = 60.0  # rows between two lobes, each a quarter as high as that before
DRAWS = 60


def beyond_lobes(away: np.ndarray, errors: np.ndarray, band: float, place: float) -> float:
    """Return what other lobes add, by draws of these errors."""
    found = [last_passage(away + each, 0.0, band) for each in errors]
    drawn = np.array([np.nan if each is None else each.place for each in found])
    return rms_beyond_lobes(away, errors, np.std(errors, axis=0), band, place, drawn)


def ringing(third: float) -> np.ndarray:
    """Return what rings about zero, its third lobe so many times the band high."""
    turn = np.pi * ROWS / LOBE
    decay = 0.25 ** (ROWS / LOBE)
    ring = decay * np.cos(turn)
    return np.asarray(third * BAND * ring / float(np.max(ring[100:])))


def noise(random: np.random.Generator, count: int, rows: float = 6.0) -> np.ndarray:
    """Return noise of 0.15 times the band, rms, smooth over some rows."""
    drawn = gaussian_filter1d(random.standard_normal((count, len(ROWS) + 100)), rows, axis=1)[:, 50:-50]
    return np.asarray(0.15 * BAND * drawn / np.std(drawn))


@pytest.mark.parametrize("third", [0.85, 1.1])
def test_a_lobe_as_high_as_the_band_is_in_the_uncertainty(third: float) -> None:
    random = np.random.default_rng(20)
    true = last_passage(ringing(third), 0.0, BAND)
    assert true is not None
    errors = []
    for _ in range(100):
        curve = NoisyCurve(ringing(third) + noise(random, 1)[0], noise(random, DRAWS))
        found = curve.last_outside(0.0, BAND)
        assert found is not None
        errors.append((found.place - true.place) / found.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.4
    assert np.mean(np.abs(errors) < 2.0) >= 0.9
    assert np.max(np.abs(errors)) > 1.0  # noise decides wrongly at times


@pytest.mark.parametrize("third", [0.15, 1.9])
def test_a_lobe_that_noise_does_not_decide_adds_nothing(third: float) -> None:
    random = np.random.default_rng(21)
    away = ringing(third)
    found = last_passage(away, 0.0, BAND)
    assert found is not None
    assert beyond_lobes(away, 0.3 * noise(random, DRAWS), BAND, found.place) == 0.0


def test_a_course_without_lobes_has_no_other() -> None:
    random = np.random.default_rng(22)
    away = np.exp(-ROWS / 40.0)
    found = last_passage(away, 0.0, BAND)
    assert found is not None
    assert beyond_lobes(away, 0.3 * noise(random, DRAWS), BAND, found.place) == 0.0


@pytest.mark.parametrize("draws", [(-0.16, 0.0), (-0.1, 0.3)])
def test_entries_in_another_lobe_count_by_their_distance(draws: tuple[float, float]) -> None:
    """The noise of both is sqrt(2) times that of a draw, and the band is wider by what it lifts the lobe."""
    rows = np.arange(41.0)
    away = np.interp(rows, (0.0, 10.0, 15.0, 20.0, 40.0), (-3.0, 0.0, 1.2, 0.0, 0.0))
    lobe = np.where(rows > 10.0, away, 0.0) / 1.2
    found = last_passage(away, 0.0, 1.0)
    assert found is not None
    lift = max(0.0, float(np.mean(draws)))
    wider = last_passage(away + np.sqrt(2.0) * draws[0] * lobe, 0.0, 1.0 + (1.0 + np.sqrt(2.0)) * lift)
    assert wider is not None
    assert wider.place < 10.0 < found.place
    told = beyond_lobes(away, np.outer(draws, lobe), 1.0, found.place)
    assert told == pytest.approx((found.place - wider.place) / np.sqrt(2.0), rel=1e-9)


@pytest.mark.parametrize(
    ("draws", "entries"),
    [
        ((-0.08, 0.0), 1),
        ((-0.05, 0.15), 1),
        ((0.088, 0.112), 1),  # the lift is as high as the lobe is at most
        ((-0.12, -0.08, 0.2), 2),  # of which the first is another lobe's without the noise of the curve, too
    ],
)
def test_a_lobe_begins_behind_zero(draws: tuple[float, ...], entries: int) -> None:
    """What is far beyond it before, in the row next to it, is of another lobe."""
    rows = np.arange(41.0)
    away = np.interp(rows, (0.0, 10.0, 11.0, 15.0, 27.0), (-3.0, -3.0, 1e-3, 1.1, 0.0))
    lobe = np.where(rows > 10.0, away, 0.0) / 1.1
    found = last_passage(away, 0.0, 1.0)
    assert found is not None

    def far(times: float, band: float) -> np.ndarray:
        """Return the squared distances of draws that enter before the lobe."""
        places = [last_passage(away + times * each * lobe, 0.0, band) for each in draws]
        return np.array([(each.place - found.place) ** 2 for each in places if each and each.place < 11.0])

    of_both = far(np.sqrt(2.0), 1.0 + (1.0 + np.sqrt(2.0)) * max(0.0, float(np.mean(draws))))
    assert len(of_both) == entries
    expected = np.sqrt((np.sum(of_both) - np.sum(far(1.0, 1.0))) / len(draws))
    for sign in (1.0, -1.0):
        told = beyond_lobes(sign * away, sign * np.outer(draws, lobe), 1.0, found.place)
        assert told == pytest.approx(expected, rel=1e-9)


def test_a_trough_within_what_noise_does_parts_no_lobes() -> None:
    """Down to 0.8 of the band, by noise of a tenth or a fifth of it."""
    rows = np.arange(41.0)
    away = np.interp(rows, (0.0, 10.0, 15.0, 20.0, 40.0), (3.0, 0.8, 1.05, 0.0, 0.0))
    found = last_passage(away, 0.0, 1.0)
    assert found is not None
    for rms, parts in ((0.09, True), (0.15, False)):
        drawn = np.outer((-rms, rms), np.ones(41))
        assert (beyond_lobes(away, drawn, 1.0, found.place) > 0.0) is parts


def waves(crest: float) -> np.ndarray:
    """Return a way up past zero with a crest of this height, a trough behind it, and beyond zero at last."""
    way = np.interp(ROWS, (0.0, 60.0, 80.0, 105.0, 160.0, 239.0), (-1.0, -0.06, 0.0, -0.06, 0.2, 0.3))
    smooth = gaussian_filter1d(way, 5.0)
    return np.asarray(smooth - np.max(smooth[:105]) + crest)


@pytest.mark.parametrize("crest", [-0.003, -0.002])
def test_a_crest_as_high_as_a_level_is_in_the_uncertainty_of_its_passage(crest: float) -> None:
    random = np.random.default_rng(23)
    true = NoisyCurve(waves(crest), np.empty((0, len(ROWS)))).passage(0.0)
    assert true is not None
    errors, at_crest = [], 0
    for _ in range(100):
        curve = NoisyCurve(waves(crest) + noise(random, 1, 2.0)[0], noise(random, DRAWS, 2.0))
        found = curve.first_above(0.0)
        assert found is not None
        errors.append((found.place - true.place) / found.standard)
        at_crest += found.place < 100.0
    assert np.sqrt(np.mean(np.square(errors))) < 1.4
    assert np.mean(np.abs(errors) < 2.0) >= 0.9
    assert at_crest >= 10  # which noise lifts over the level


def test_a_crest_that_noise_does_not_decide_adds_nothing_to_a_passage() -> None:
    random = np.random.default_rng(24)
    for crest in (0.03, -0.03):
        found = NoisyCurve(waves(crest), 0.3 * noise(random, DRAWS)).passage(0.0)
        assert found is not None
        assert found.of_crests == 0.0
