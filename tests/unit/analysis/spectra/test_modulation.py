"""What modulates all lines alike, and an amplitude that wanders more slowly than the bins beside it show."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, coherent_spectrum
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.spectra.harmonics import Reference, total_harmonic_distortion
from benchtool.analysis.spectra.line_errors import line_errors
from benchtool.analysis.spectra.modulation import is_modulated_alike, wander_of_mean

Array = NDArray[np.float64]
PERIODS, PER_PERIOD = 80, 200
LINEAR = Polynomial([0.0, 2.0 * np.pi / PER_PERIOD])


def memory(random: np.random.Generator, count: int, pole: float) -> Array:
    driven = random.standard_normal(count + 400)
    return np.asarray(signal.lfilter([1.0], [1.0, -pole], driven)[400:] * math.sqrt(1.0 - pole**2))


def spectrum_of(current: Array) -> CoherentSpectrum:
    return coherent_spectrum(current, 10_000.0, PhaseTrack(LINEAR, len(current), "as it was made"))


def currents(random: np.random.Generator, *, alike: bool) -> Array:
    """Return a current of 1 with harmonics of 0.03 and 0.02, the amplitudes of which vary by 1 %."""
    count = (PERIODS + 1) * PER_PERIOD
    theta = 2.0 * np.pi * np.arange(count) / PER_PERIOD
    parts = [0.01 * np.repeat(memory(random, PERIODS + 1, 0.5), PER_PERIOD) for _ in range(3)]
    if alike:
        parts[1:] = parts[:1] * 2
    current = sum(
        (
            size * (1.0 + part) * np.cos(order * theta + order)
            for size, order, part in zip((1.0, 0.03, 0.02), (1, 5, 7), parts, strict=True)
        ),
        start=1e-5 * random.standard_normal(count),
    )
    return np.asarray(current)


def test_lines_of_one_modulation_are_told_from_lines_that_vary_by_themselves() -> None:
    random = np.random.default_rng(3)
    weights = np.zeros((2, 8))
    weights[0, 4] = weights[1, 6] = 1.0
    for _ in range(6):
        assert np.all(is_modulated_alike(spectrum_of(currents(random, alike=True)), weights))
    alone = [is_modulated_alike(spectrum_of(currents(random, alike=False)), weights) for _ in range(20)]
    assert np.mean(alone) < 0.2


def test_what_modulates_all_harmonics_adds_up_in_a_ratio_to_a_stated_amplitude() -> None:
    random, errors, own = np.random.default_rng(4), [], []
    for _ in range(30):
        spectrum = spectrum_of(currents(random, alike=True))
        found = total_harmonic_distortion(spectrum, 10, Reference.STATED, 1.0)
        errors.append((found.ratio - math.hypot(0.03, 0.02)) / found.standard)
        own.append(found.standard)
    assert 0.6 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4
    assert np.median(own) > 0.8 * 0.01 * math.hypot(0.03, 0.02) * math.sqrt(3.0 / PERIODS)


def test_an_amplitude_that_wanders_slowly_is_less_certain_than_the_bins_beside_its_line_say() -> None:
    random = np.random.default_rng(5)
    by_pairs = 0.01 * math.sqrt(1.0 / 60.0)
    slow = [wander_of_mean(1.0 + 0.01 * memory(random, 60, 0.9), by_pairs) for _ in range(30)]
    white = [wander_of_mean(1.0 + 0.01 * random.standard_normal(60), by_pairs) for _ in range(30)]
    of_mean = 0.01 * math.sqrt(19.0 / 60.0)  # (1 + r) / (1 - r) values count as one
    assert 0.5 * of_mean < float(np.median(slow)) < 4.0 * of_mean
    assert np.mean(np.array(white) > 0.0) < 0.2


def test_only_a_line_that_is_modulated_alike_has_the_wander_of_the_fundamental() -> None:
    random = np.random.default_rng(6)
    count = (PERIODS + 1) * PER_PERIOD
    theta = 2.0 * np.pi * np.arange(count) / PER_PERIOD
    size = 1.0 + 0.01 * np.repeat(memory(random, PERIODS + 1, 0.95), PER_PERIOD)
    current = size * (np.cos(theta) + 0.03 * np.cos(5 * theta)) + 0.02 * np.cos(7 * theta)
    spectrum = spectrum_of(current + 1e-4 * random.standard_normal(count))
    errors = line_errors(spectrum, 8, amplitudes=size[::PER_PERIOD][:PERIODS])
    assert errors.wander[0] > 0.0
    assert errors.wander[4] == np.float64(errors.wander[0] / spectrum.fundamental * spectrum.amplitude[400])
    assert errors.wander[6] == 0.0
