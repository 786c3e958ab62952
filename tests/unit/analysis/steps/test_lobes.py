"""Which lobe leaves the band as the last: what noise decides is as uncertain as both places are apart."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchtool.analysis.steps.lobes import Entries, Lobe, Lobes
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.passages import last_passage, last_passages, places_of

BAND = 0.02
ROWS = np.arange(240.0)
LOBE = 60.0  # rows between two lobes, each a quarter as high as that before
DRAWS = 60


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


def entries(away: np.ndarray, errors: np.ndarray, band: float) -> Entries:
    """Return where the curve enters the band by its lobes, and where draws of these errors do."""
    found = last_passage(away, 0.0, band)
    assert found is not None
    drawn = places_of(last_passages(away + errors, 0.0, band))
    return Lobes.of(away, np.std(errors, axis=0), 2.0).entries(found.place, drawn, errors, band)


@pytest.mark.parametrize("third", [0.85, 1.1])
@pytest.mark.parametrize("rows", [2.0, 6.0])
def test_a_lobe_as_high_as_the_band_is_in_the_uncertainty(third: float, rows: float) -> None:
    random = np.random.default_rng(20)
    true = last_passage(ringing(third), 0.0, BAND)
    assert true is not None
    errors, standard = [], []
    for _ in range(100):
        curve = NoisyCurve(ringing(third) + noise(random, 1, rows)[0], noise(random, DRAWS, rows))
        found = curve.last_outside(0.0, BAND)
        assert found is not None
        errors.append(found.place - true.place)
        standard.append(found.standard)
    relative = np.divide(errors, standard)
    assert np.sqrt(np.mean(relative**2)) < 1.4
    assert np.mean(np.abs(relative) < 2.0) >= 0.9
    # errors of a lobe are rare, and as frequent as they are drawn
    assert 0.5 < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(standard))) < 1.4


@pytest.mark.parametrize("third", [0.15, 0.6, 1.6])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_lobe_that_noise_does_not_decide_adds_nothing(third: float, sign: float) -> None:
    random = np.random.default_rng(21)
    away = sign * ringing(third)
    found = entries(away, 0.3 * noise(random, DRAWS), BAND)
    assert found.expected == found.likeliest == places_of([last_passage(away, 0.0, BAND)])[0]
    assert float(np.std(found.drawn)) < 2.0


def test_a_course_without_lobes_keeps_its_draws() -> None:
    random = np.random.default_rng(22)
    away, errors = np.exp(-ROWS / 40.0), 0.3 * noise(random, DRAWS)
    found = entries(away, errors, BAND)
    assert found.expected == found.likeliest == places_of([last_passage(away, 0.0, BAND)])[0]
    np.testing.assert_array_equal(found.drawn, places_of(last_passages(away + errors, 0.0, BAND)))


@pytest.mark.parametrize("third", [0.995, 1.005])
def test_a_lobe_in_little_noise_is_no_parabola(third: float) -> None:
    """The parabola through the upper half is lower by more than such noise, and was sure of a wrong lobe."""
    random = np.random.default_rng(99)
    true = last_passage(ringing(third), 0.0, BAND)
    assert true is not None
    relative = []
    for _ in range(40):
        curve = NoisyCurve(ringing(third) + noise(random, 1)[0] / 30.0, noise(random, DRAWS) / 30.0)
        found = curve.last_outside(0.0, BAND)
        assert found is not None
        relative.append((found.place - true.place) / found.standard)
    assert np.sqrt(np.mean(np.square(relative))) < 1.4


def test_an_instant_is_expected_between_two_lobes_and_one_is_the_likelier() -> None:
    """Noise of single rows has lifted the third lobe over the band, and its parabola is within."""
    away = ringing(0.9)
    top = int(np.argmax(away[100:])) + 100
    away[top] = 1.05 * BAND
    found = entries(away, 0.4 * noise(np.random.default_rng(23), 400), BAND)
    before = last_passage(away[:100], 0.0, BAND)
    assert before is not None
    assert found.likeliest == before.place
    share = float(np.mean(found.drawn > 100.0))
    assert 0.0 < share < 0.2
    apart = float(np.mean(found.drawn[found.drawn > 100.0])) - before.place
    assert found.expected == pytest.approx(before.place + share * apart, abs=1.0)


@pytest.mark.parametrize("share", [0.1, 0.15])
def test_a_lobe_at_the_band_is_judged_by_all_lobes_of_its_mode(share: float) -> None:
    """Its own crest leaves it open in this noise, of that share of the band, which is between two lobes."""
    away = np.exp(-0.5 * ROWS / 24.0) * np.cos(np.pi * ROWS / 24.0)
    heights = [float(np.max(np.abs(away[begin : begin + 24]))) for begin in (84, 108)]
    band = float(np.mean(heights))
    random = np.random.default_rng(31)
    true = last_passage(away, 0.0, band)
    assert true is not None
    scale = share / 0.15 * band / BAND
    errors, standard = [], []
    for _ in range(60):
        found = NoisyCurve(away + scale * noise(random, 1)[0], scale * noise(random, DRAWS)).last_outside(
            0.0, band
        )
        assert found is not None
        errors.append(found.place - true.place)
        standard.append(found.standard)
    mean_square = np.mean(np.square(errors))
    # by its crest alone, 9 rows in the greater noise, and in the lesser 1, with an uncertainty of 11
    assert np.sqrt(mean_square) < 5.0
    assert 0.3 < np.sqrt(mean_square / np.mean(np.square(standard))) < 1.4


def test_lobes_lie_between_troughs_that_noise_does_not_make() -> None:
    size = np.array([9.0, 1.0, 3.0, 2.0, 3.5, 0.5, 2.0, 0.0])

    def lobes(standard: float) -> tuple[Lobe, ...]:
        return Lobes.of(size * np.array([1, 1, -1, -1, -1, 1, 1, 1]), np.full(8, standard), 2.0).lobes

    assert lobes(0.3) == (Lobe(0, 0, 1), Lobe(1, 2, 3), Lobe(3, 4, 5), Lobe(5, 6, 8))
    assert lobes(0.5) == (Lobe(0, 0, 1), Lobe(1, 4, 5), Lobe(5, 6, 8))
    assert lobes(0.7) == (Lobe(0, 0, 1), Lobe(1, 4, 8))
    assert Lobes.of(size, np.full(8, 0.5), 5.0).lobes == (Lobe(0, 0, 1), Lobe(1, 4, 5))  # 2.5 is noise
    assert lobes(3.0) == (Lobe(0, 0, 8),)


def test_draws_that_do_not_enter_stay_without_a_place() -> None:
    away = ringing(1.0)
    found = Lobes.of(away, np.full(len(ROWS), 1e-3), 2.0).entries(
        130.0, np.array([np.nan, 131.0]), np.zeros((2, len(ROWS))), BAND
    )
    assert np.isnan(found.drawn[0])
    assert np.isfinite(found.drawn[1])


def test_noise_that_grows_hides_no_lobe_that_is_higher_than_the_one_before() -> None:
    away, standard = np.array([2.0, 1.0, 2.1, 3.0, 3.0, 0.0]), np.array([0.1, 0.1, 0.1, 2.0, 2.0, 2.0])
    lobes = Lobes.of(away, standard, 0.5)
    assert lobes.lobes == (Lobe(0, 0, 1), Lobe(1, 3, 6))
    found = lobes.entries(4.5, np.full(3, 4.5), np.zeros((3, 6)), 1.5)
    assert found.expected == found.likeliest == 4.5
    np.testing.assert_array_equal(found.drawn, 4.5)


def test_a_lobe_without_noise_that_just_leaves_the_band_is_as_high_as_it_is() -> None:
    """A parabola through it is lower."""
    away = ringing(1.001)
    true = last_passage(away, 0.0, BAND)
    assert true is not None
    found = entries(away, 1e-9 * noise(np.random.default_rng(24), DRAWS), BAND)
    assert found.expected == pytest.approx(true.place, abs=1e-3)
    assert np.std(found.drawn) < 1e-2
