"""The error of a mean by densities that are continued to zero frequency."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks.coverage.noise import coloured, fractional, resonant
from benchtool.analysis.statistics.lowest_frequencies import slow_noise


def test_a_density_without_corner_that_rises_less_than_1_over_f_is_continued_to_zero() -> None:
    """Its power below any lowest frequency is finite: the variance is the integral of 2 sinc^2(f) f^-a."""
    count, exponent = 4096, 0.6
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
    assert found.standard == pytest.approx(math.sqrt(sum(parts)), rel=0.1)


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
