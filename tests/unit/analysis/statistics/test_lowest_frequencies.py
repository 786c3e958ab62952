"""The error of a mean by densities that are continued to zero frequency."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks.coverage.noise import coloured, fractional, pink, resonant
from benchtool.analysis.statistics.lowest_frequencies import (
    _half_width,
    continued_power,
    slow_noise,
    walk_probability,
)


@pytest.mark.parametrize(("exponent", "within"), [(0.3, 0.3), (0.6, 0.1)])
def test_a_density_without_corner_that_rises_less_than_1_over_f_is_continued_to_zero(
    exponent: float, within: float
) -> None:
    """Its power below any lowest frequency is finite: the variance is the integral of 2 sinc^2(f) f^-a."""
    count = 4096
    number = np.arange(1, count // 2)
    bins = np.zeros(count // 2 + 1, dtype=complex)
    phases_rad = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(number))
    bins[1:-1] = number ** (-0.5 * exponent) * np.exp(1j * phases_rad)
    found = slow_noise(np.fft.irfft(bins * count, count))
    parts = (
        quad(lambda f: 2.0 * np.sinc(f) ** 2 * f**-exponent, each, each + 1.0, limit=200)[0]
        for each in range(30)
    )
    assert found is not None
    assert found.standard == pytest.approx(math.sqrt(sum(parts)), rel=within)


def test_other_samples_of_a_lag_s_noise_tell_that_it_does_not_rise_further() -> None:
    random, stated, errors = np.random.default_rng(9), [], []
    for _ in range(60):
        record = coloured(random.standard_normal(1400), 0.95)[200:]
        own, other = record[:200], record[200:]
        alone, beside = slow_noise(own), slow_noise(own, beside=[other])
        assert alone is not None
        assert beside is not None
        stated.append(beside.standard / alone.standard)
        errors.append(np.mean(own) / beside.standard)
    assert np.median(stated) < 0.7
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.2


def test_other_samples_of_1_over_f_noise_do_not_end_its_rise() -> None:
    random, errors = np.random.default_rng(10), []
    for _ in range(60):
        record = fractional(random, 8000)[:1200]
        found = slow_noise(record[:200], beside=[record[200:]])
        assert found is not None
        errors.append(np.mean(record[:200]) / found.standard)
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_samples_beside_that_are_too_few_or_without_noise_tell_nothing() -> None:
    random = np.random.default_rng(11)
    own = random.standard_normal(400)
    for other in (random.standard_normal(6), np.zeros(300)):
        assert slow_noise(own, beside=[other]) == slow_noise(own)


def test_what_samples_beside_have_of_a_resonance_does_not_count_below_it() -> None:
    """Up to the resonance the samples themselves are taken; of others it would seem noise that rises."""
    random, ratios = np.random.default_rng(12), []
    for _ in range(20):
        noise = resonant(random, 2400)
        alone, beside = slow_noise(noise[:1900]), slow_noise(noise[:1900], beside=[noise[1900:]])
        assert alone is not None
        assert beside is not None
        ratios.append(beside.standard / alone.standard)
    assert 0.8 < np.median(ratios) < 1.2


def test_a_walk_is_told_by_all_pieces_in_whatever_order_and_size() -> None:
    random = np.random.default_rng(13)
    walks = [np.cumsum(random.standard_normal(count)) for count in (400, 700)]
    found = walk_probability(walks)
    assert found is not None
    assert found > 0.8
    other = walk_probability([1e3 + 5.0 * walks[1], -walks[0]])
    assert other == pytest.approx(found, rel=1e-6)
    assert walk_probability([walks[0], walks[1][:6]]) is None
    for count in range(4):
        noise = np.random.default_rng(count).standard_normal((2, 600))
        assert walk_probability(list(noise)) == pytest.approx(0.0, abs=0.05)
        pink = fractional(np.random.default_rng(count), 3000)
        rises = walk_probability([pink[:800], pink[1500:2100]])
        assert rises is not None
        assert rises < 0.05


def test_noise_that_a_control_takes_away_at_zero_is_told_to_fall() -> None:
    """The mean of differences is that of the ends: sqrt(2) / n of the noise that is differenced."""
    random, count = np.random.default_rng(14), 2000
    falls, of_falling, errors = [], [], []
    for _ in range(20):
        record = np.diff(random.standard_normal(count + 1))
        found = slow_noise(record)
        assert found is not None
        falls.append(found.falls)
        of_falling.append(found.of_falling)
        errors.append(float(np.mean(record)))
    assert np.median(falls) > 0.97
    assert min(falls) > 0.2
    assert np.median(of_falling) == pytest.approx(np.sqrt(2.0) / count, rel=0.5)
    assert 0.5 < float(np.std(errors)) / np.median(of_falling) < 1.6
    white = [slow_noise(random.standard_normal(count)) for _ in range(20)]
    assert np.median([each.falls for each in white if each is not None]) < 0.3


def test_two_standard_deviations_of_white_noise_hold_its_mean_in_95_of_100_records() -> None:
    random = np.random.default_rng(15)
    records = random.standard_normal((200, 600))
    stated = np.array([getattr(slow_noise(each), "standard", np.nan) for each in records])
    assert 0.9 <= float(np.mean(np.abs(np.mean(records, axis=1)) < 2.0 * stated)) <= 0.99
    assert np.median(stated) == pytest.approx(1.0 / np.sqrt(600), rel=0.12)


def test_noise_without_power_leaves_nothing_uncertain() -> None:
    assert _half_width(np.array([0.7, 0.3]), np.zeros(2)) == 0.0
    assert _half_width(np.array([0.7, 0.3]), np.ones(2)) == pytest.approx(1.96, abs=1e-3)


def test_a_reference_tells_the_slow_noise_of_samples_that_follow_it() -> None:
    """Faster noise of their own, which falls towards zero frequency, hides it in the samples."""
    random, count = np.random.default_rng(16), 100
    errors: dict[bool, list[float]] = {False: [], True: []}
    for _ in range(60):
        reference = coloured(random.standard_normal(count + 200), 0.9)[200:]
        own = 2.0 * float(np.std(reference)) * np.diff(random.standard_normal(count + 1))
        samples = reference + own
        for is_known, found in errors.items():
            told = slow_noise(samples, reference=reference if is_known else None)
            assert told is not None
            square = told.falls * told.of_falling**2 + (1.0 - told.falls) * told.standard**2
            found.append(float(np.mean(samples)) / math.sqrt(square))
        assert slow_noise(samples, reference=np.zeros(count)) == slow_noise(samples)
    assert np.std(errors[False]) > 1.4
    assert 0.45 < np.std(errors[True]) < 1.1


def test_what_a_signal_shares_with_its_reference_tells_once() -> None:
    """Of white noise in both the probability of a density that falls is as far from even as by one."""
    random, count = np.random.default_rng(18), 200
    odds: tuple[list[float], list[float]] = [], []
    for _ in range(60):
        reference = random.standard_normal(count)
        samples = reference + 1e-2 * random.standard_normal(count)
        alone, known, same = (slow_noise(samples, reference=each) for each in (None, reference, samples))
        assert alone is not None
        assert known is not None
        assert same is not None
        for told, found in zip((alone, known), odds, strict=True):
            found.append(math.log(told.falls / (1.0 - told.falls)))
        assert same.standard == pytest.approx(known.standard, rel=0.1)
    of_one, of_both = odds
    assert np.std(of_both) < 1.3 * np.std(of_one)


def test_the_noise_of_a_control_is_level_below_its_bandwidth() -> None:
    """Of three cycles in the record: the mean is known to about its scatter, and with less chance."""
    random, count = np.random.default_rng(19), 300
    means, known = [], []
    for _ in range(60):
        reference = coloured(random.standard_normal(count + 400), math.exp(-6.0 * math.pi / count))[400:]
        samples = reference + 0.03 * random.standard_normal(count)
        told = slow_noise(samples, reference=reference)
        assert told is not None
        means.append(float(np.mean(samples)))
        known.append(told.standard)
    assert np.std(np.array(means) / np.array(known)) < 1.1
    assert np.median(known) < 2.2 * np.std(means)


def test_noise_with_a_crest_does_not_rise_towards_zero() -> None:
    """As where a speed goes from count to count: the mean is known better than by its few cycles."""
    random = np.random.default_rng(17)
    number = np.arange(1, 601)
    crest = number / 4.0
    density = crest**2 / ((28.0 - crest**2) ** 2 + (2.0 * 0.2 * 5.3 * crest) ** 2)
    falls, errors = [], []
    for _ in range(40):
        bins = np.zeros(601, dtype=complex)
        bins[1:] = np.sqrt(density[:600]) * (random.standard_normal(600) + 1j * random.standard_normal(600))
        record = np.fft.irfft(bins)[:300]
        found = slow_noise(record)
        assert found is not None
        assert not found.is_lost
        falls.append(found.falls)
        errors.append(float(np.mean(record)) / found.of_falling)
    assert np.median(falls) > 0.9
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.4


@pytest.mark.parametrize("is_pink", [True, False])
def test_bins_that_a_fit_has_emptied_are_continued_from_those_above(is_pink: bool) -> None:
    random, count, places = np.random.default_rng(21), 2048, np.array([1.0, 2.0, 3.0])
    found, power = [], []
    for _ in range(60):
        noise = pink(random, count) if is_pink else random.standard_normal(count)
        bins = np.fft.rfft(noise)
        power.append(np.abs(bins[1:4] / count) ** 2)
        bins[1:4] *= 0.3
        each = continued_power(np.fft.irfft(bins, count), 0, 4.0, places)
        assert each is not None
        found.append(each)
    assert np.median(found, axis=0) == pytest.approx(np.mean(power, axis=0), rel=0.4)


def test_the_crest_of_the_noise_of_a_lag_is_no_sign_that_its_density_falls() -> None:
    """Four to seven cycles of its corner in the record: few bins below tell that it is level there."""
    random, falls = np.random.default_rng(15), []
    for memory in (0.9, 0.95):
        for _ in range(40):
            found = slow_noise(coloured(random.standard_normal(600), memory)[200:])
            assert found is not None
            falls.append(found.falls)
    assert np.mean(falls) < 0.2
    assert np.mean(np.array(falls) > 0.5) < 0.15
