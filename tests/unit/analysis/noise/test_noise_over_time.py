"""The uncertainty of a noise floor whose level changes with time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import CoherentSamples, NoiseFloor, noise_floor
from benchtool.analysis.coherent.spectrum import CoherentSpectrum, spectrum_of
from benchtool.analysis.noise.noise_of_periods import without_changes
from benchtool.analysis.noise.noise_over_time import ONE_LEVEL, noise_over_time

_PER_PERIOD, _NOISE = 100, 1e-3
Floats = NDArray[np.float64]


def two_levels(random: np.random.Generator, rows: int, changes: float) -> Floats:
    """Return noise of unit rms that goes from one level to three times as much and back, at random."""
    at_upper = (np.cumsum(random.random(rows) < changes / rows) + random.integers(2)) % 2
    return np.asarray(np.where(at_upper, 3.0, 1.0) / math.sqrt(5.0) * random.standard_normal(rows))


def recorded(noise: Floats) -> tuple[CoherentSamples, CoherentSpectrum]:
    at = 2 * np.pi * np.arange(len(noise)) / _PER_PERIOD
    samples = CoherentSamples(np.cos(at) + _NOISE * noise, len(noise) // _PER_PERIOD, float(len(noise)), 10e3)
    return samples, spectrum_of(samples)


@pytest.mark.parametrize(("periods", "changes"), [(15, 25.0), (40, 40.0)])
def test_noise_of_two_levels_is_as_uncertain_as_its_time_at_either_makes_it(
    periods: int, changes: float
) -> None:
    random, errors = np.random.default_rng(periods), []
    for _ in range(60):
        noise = two_levels(random, periods * _PER_PERIOD, changes)
        floor = noise_floor(recorded(noise)[1])
        assert floor is not None
        truth = 2.0 * _NOISE / math.sqrt(len(noise))
        u = math.hypot(floor.relative_error, floor.by_time.standard)
        errors.append(((floor.amplitude / truth - 1.0), (floor.amplitude - truth) / (u * floor.amplitude)))
    of_level, in_u = np.transpose(errors)
    own = noise_floor(recorded(noise)[1])
    assert own is not None
    assert np.std(of_level) > 2.0 * own.relative_error  # the scatter of bins alone does not tell it
    assert 0.6 < float(np.sqrt(np.nanmean(in_u**2))) < 1.4


def test_noise_of_one_level_hardly_gains_an_uncertainty() -> None:
    random = np.random.default_rng(3)
    shares, evenness = [], []
    for _ in range(40):
        floor = noise_floor(recorded(random.standard_normal(20 * _PER_PERIOD))[1])
        assert floor is not None
        shares.append(floor.by_time.standard / floor.relative_error)
        evenness.append(floor.over_time.evenness)
    assert np.sqrt(np.mean(np.square(shares))) < 0.6
    assert min(evenness) > 0.75
    assert max(evenness) <= 1.0


def test_a_level_that_changes_once_has_no_uncertainty() -> None:
    rows = 40 * _PER_PERIOD
    noise = np.random.default_rng(5).standard_normal(rows) * np.where(np.arange(rows) < rows // 2, 1.0, 4.0)
    floor = noise_floor(recorded(noise)[1])
    assert floor is not None
    assert math.isnan(floor.by_time.standard)


def test_one_burst_does_not_tell_how_much_power_others_would_have() -> None:
    """Of 64 parts of which one holds all power the mean is off by as much as it is."""
    rows, random = 40 * _PER_PERIOD, np.random.default_rng(8)
    level = np.full(rows, 0.05)
    level[rows // 5 :][: rows // 64] = 10.0
    few = noise_floor(recorded(level * random.standard_normal(rows))[1])
    level[np.arange(rows) // (rows // 64) % 4 == 0] = 10.0
    more = noise_floor(recorded(level * random.standard_normal(rows))[1])
    assert few is not None
    assert more is not None
    assert math.isnan(few.by_time.standard)
    assert math.isfinite(more.by_time.standard)


def test_bins_of_nothing_are_of_one_level() -> None:
    assert noise_over_time(np.zeros(500, dtype=np.complex128), np.arange(100, 400)) is ONE_LEVEL


def test_a_few_bins_have_no_course() -> None:
    noise = np.random.default_rng(6).standard_normal(3 * 16)
    at = 2 * np.pi * np.arange(len(noise)) / 16
    spectrum = spectrum_of(CoherentSamples(np.cos(at) + _NOISE * noise, 3, float(len(noise)), 10e3))
    floor = noise_floor(spectrum)
    assert floor is not None
    assert floor.by_time.standard == 0.0


def test_bursts_are_no_change_of_the_amplitude() -> None:
    """Bursts are in few differences of periods, as steps are, and the floor is not what is left of these."""
    random, ratios = np.random.default_rng(7), []
    for _ in range(60):
        rows = 25 * _PER_PERIOD
        level = np.full(rows, 0.1)
        for begin in random.integers(0, rows, 10):
            level[begin : begin + rows // 50] += 4.5
        samples, spectrum = recorded(np.sqrt(level) * random.standard_normal(rows))
        plain = noise_floor(spectrum)
        found = without_changes(plain, spectrum, samples, has_stepped=False)
        assert plain is not None
        if isinstance(found, NoiseFloor):
            ratios.append(found.amplitude / plain.amplitude)
    assert len(ratios) > 50
    assert min(ratios) > 0.9
