"""Sinusoids between harmonics and a decaying dc: found as they were made, and out of the lines."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    coherent_samples,
    spectrum_of,
)
from benchtool.analysis.periods import PhaseTrack, track_tone
from benchtool.analysis.spectra.current import current_spectrum
from benchtool.analysis.spectra.groups import harmonic_groups, ratio_of
from benchtool.analysis.spectra.interharmonics import (
    interharmonics,
    noise_of_fit,
    scatter_of_phases,
    without,
)
from benchtool.analysis.spectra.moving_tones import Course
from benchtool.analysis.spectra.separation import separate
from benchtool.block import Block

Array = NDArray[np.float64]
PER_PERIOD, RATE_HZ = 211.3, 10e3


def samples_of(values: Array) -> CoherentSamples:
    track = PhaseTrack(Polynomial([0.3, 2.0 * np.pi / PER_PERIOD]), len(values), "as it was made")
    return coherent_samples(values, RATE_HZ, track)


def steady_course(coherent: CoherentSamples) -> Course:
    turned = np.arange(len(coherent.values)) / len(coherent.values)
    return Course(turned, turned)


def rows(periods: float) -> Array:
    return np.arange(round(periods * PER_PERIOD), dtype=np.float64)


def harmonic_current(row: Array, phase: float = 0.0) -> Array:
    theta = 2.0 * np.pi * row / PER_PERIOD + phase
    return np.asarray(np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta + 2.0))


@pytest.mark.parametrize("order", [0.37, 1.41, 4.87])
@pytest.mark.parametrize("periods", [7.8, 40.4])
def test_a_sinusoid_between_harmonics_leaves_their_amplitudes(order: float, periods: float) -> None:
    row = rows(periods)
    noise = 1e-5 * np.random.default_rng(1).standard_normal(len(row))
    signal = harmonic_current(row) + 0.02 * np.cos(2 * np.pi * order * row / PER_PERIOD + 0.7) + noise
    coherent = samples_of(signal)
    spectrum = spectrum_of(coherent)
    found = interharmonics(spectrum, len(coherent.values))
    assert found is not None
    nearest = abs(order - round(order)) * spectrum.periods
    if nearest < 0.4:  # nearer to a harmonic both are one
        assert not len(found.places)
        return
    assert found.places / spectrum.periods == pytest.approx([order], abs=1e-3)
    assert np.abs(found.phasors) == pytest.approx([0.02], rel=2e-3)
    clean = spectrum_of(without(coherent, found, steady_course(coherent)))
    leaked = max(abs(spectrum.amplitude[spectrum.periods * k] - a) for k, a in ((1, 1.0), (5, 0.03)))
    left = max(abs(clean.amplitude[spectrum.periods * k] - a) for k, a in ((1, 1.0), (5, 0.03)))
    assert left < 2e-5 < leaked


def test_a_decaying_dc_is_found_with_its_time_constant() -> None:
    row = rows(12.6)
    constant_rows = 0.2 * len(row)
    coherent = samples_of(harmonic_current(row) - 0.4 * np.exp(-row / constant_rows) + 0.1)
    spectrum = spectrum_of(coherent)
    found = interharmonics(spectrum, len(coherent.values))
    assert found is not None
    assert found.words == "a decaying dc"
    assert found.constant == pytest.approx(constant_rows / spectrum.samples, rel=1e-3)
    assert found.start == pytest.approx(-0.4 * math.exp(-FIRST_ROW / constant_rows), rel=1e-3)
    clean = spectrum_of(without(coherent, found, steady_course(coherent)))
    assert clean.fundamental == pytest.approx(1.0, abs=1e-6)
    assert abs(spectrum.fundamental - 1.0) > 1e-4


def test_two_sinusoids_less_than_two_bins_apart_are_two() -> None:
    row = rows(44.9)
    noise = 1e-4 * np.random.default_rng(4).standard_normal(len(row))
    two = (0.02 * np.cos(2 * np.pi * order * row / PER_PERIOD + order) for order in (6.21, 6.245))
    coherent = samples_of(harmonic_current(row) + sum(two) + noise)
    found = interharmonics(spectrum_of(coherent), len(coherent.values))
    assert found is not None
    assert np.sort(found.places) / coherent.periods == pytest.approx([6.21, 6.245], abs=1e-3)


def test_the_fit_of_a_sinusoid_beside_a_harmonic_adds_as_much_noise_to_it_as_stated() -> None:
    random, row, errors, stated = np.random.default_rng(6), rows(4.5), [], []
    for _ in range(60):
        line = 0.02 * np.cos(2 * np.pi * 4.825 * row / PER_PERIOD + random.uniform(0, 2 * np.pi))
        theta = 2 * np.pi * row / PER_PERIOD
        coherent = samples_of(np.cos(theta) + line + 1e-3 * random.standard_normal(len(row)))
        found = interharmonics(spectrum_of(coherent), len(coherent.values))
        assert found is not None
        clean = spectrum_of(without(coherent, found, steady_course(coherent)))
        errors.append(abs(clean.phasor[5 * clean.periods]) ** 2)
        stated.append(noise_of_fit(found, clean, 7, len(coherent.values)))
    noise2 = 4.0 * 1e-6 / clean.samples
    np.testing.assert_allclose(np.mean(errors), noise2 * (1.0 + np.mean(stated, axis=0)[4] ** 2), rtol=0.3)
    assert np.mean(stated, axis=0)[4] > 10.0 * np.mean(stated, axis=0)[6]


@pytest.mark.parametrize(("periods", "colour"), [(40.4, 0.0), (40.4, 0.95), (3.7, 0.995)])
def test_noise_alone_holds_no_sinusoid(periods: float, colour: float) -> None:
    """Of few periods noise that rises towards dc has most of its power in the lowest bin."""
    row = rows(periods)
    for each in np.random.default_rng(2).standard_normal((24 if periods < 10.0 else 8, len(row))):
        noise = signal.lfilter([1.0], [1.0, -colour], each)
        coherent = samples_of(harmonic_current(row) + 0.01 * noise)
        found = interharmonics(spectrum_of(coherent), len(coherent.values))
        assert found is None or not len(found.places)


def test_groups_scatter_over_phases_as_records_do() -> None:
    random, ratios = np.random.default_rng(3), []
    row = rows(30.5)
    for _ in range(40):
        line = 0.02 * np.cos(2 * np.pi * 3.37 * row / PER_PERIOD + random.uniform(0, 2 * np.pi))
        coherent = samples_of(harmonic_current(row, random.uniform(0, 2 * np.pi)) + line)
        groups = harmonic_groups(coherent, 20)
        assert groups is not None
        ratios.append((ratio_of(groups.group2), ratio_of(groups.subgroup2)))
    found = interharmonics(spectrum_of(coherent), len(coherent.values))
    assert found is not None
    assert groups is not None
    clean = spectrum_of(without(coherent, found, steady_course(coherent)))
    stated = scatter_of_phases(clean, found, groups, steady_course(coherent))
    np.testing.assert_allclose(stated, np.std(ratios, axis=0), rtol=0.45)


def test_the_frequency_of_few_periods_is_without_what_lies_between_harmonics() -> None:
    row = rows(7.8)
    signal = harmonic_current(row) + 0.02 * np.cos(2 * np.pi * 1.6 * row / PER_PERIOD + 0.5)
    signal += 1e-5 * np.random.default_rng(5).standard_normal(len(row))
    track = track_tone(signal)
    truth_Hz = RATE_HZ / PER_PERIOD
    of_track_Hz = track.periods * RATE_HZ / (len(row) - 1)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
    number = current_spectrum(block, "i_a", track).measurements[0]
    assert number.name == "fundamental_frequency"
    assert number.uncertainty is not None
    assert abs(of_track_Hz - truth_Hz) > 10.0 * number.uncertainty.standard
    assert abs(number.value - truth_Hz) < 4.0 * number.uncertainty.standard


@pytest.mark.parametrize(("seed", "swings"), [(11, False), (24, False), (3, True), (5, True)])
def test_what_a_speed_that_wanders_leaves_of_the_fit_of_a_line_is_no_other_line(
    seed: int, swings: bool
) -> None:
    random = np.random.default_rng(seed)
    periods = 40.0 + random.uniform()
    row = rows(periods)
    passed = row / len(row)
    of_line, of_tone = random.uniform(0.0, 2.0 * np.pi, 2)
    drift = 2.0 * np.pi * periods * 2.5e-4 * (passed - 1.0) * passed
    swing = 7.5e-3 * np.sin(2.0 * np.pi * 1.6 * passed + 1.3)
    turned = 2.0 * np.pi * periods * passed + of_tone + (swing if swings else drift)
    current = np.cos(turned) + 0.02 * np.cos(5.0 * turned) + 0.03 * np.cos(7.0 * turned + 1.0)
    current += 0.03 * np.cos(2.0 * np.pi * (periods + 1.47) * passed + of_line)
    current += 2e-3 * random.standard_normal(len(row))
    found = separate(current, RATE_HZ, track_tone(current), "i_a", 0.0)
    assert found.steady.trend is None  # an amplitude that swings is what the line alone would make of it
    assert found.taken is not None
    near = np.abs(found.taken.places - found.coherent.periods) < 3.0
    assert np.linalg.norm(found.taken.phasors[near]) == pytest.approx(0.03, rel=0.1)
    assert np.all(found.taken.places[near] > found.coherent.periods)
