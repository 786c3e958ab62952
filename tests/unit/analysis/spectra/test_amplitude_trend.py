"""A ramp, a step and a swing of an amplitude are told from one that wanders at random."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import FIRST_ROW, coherent_samples, spectrum_of
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.wander import wander
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend
from benchtool.analysis.spectra.line_errors import line_errors
from benchtool.analysis.spectra.modulation import phase_noise_rad, with_steady_amplitude

Array = NDArray[np.float64]
PERIODS, PER_PERIOD = 40, 200
PLACE = (np.arange(PERIODS) + 0.5) / PERIODS
CURVES: dict[str, Callable[[Array], Array]] = {
    "ramp": lambda place: 0.05 * (place - 0.5),
    "parabola": lambda place: 0.05 * (place - 0.4) ** 2,
    "warming up": lambda place: 0.03 * (np.exp(-3.0 * place) - 0.3167),
    "step": lambda place: np.asarray(0.01 * (place > 0.55)),
    "swing": lambda place: np.asarray(0.02 * np.cos(2 * np.pi * 6.6 * place + 1.0)),
    "swing about a ramp": lambda place: np.asarray(
        0.02 * np.cos(2 * np.pi * 6.6 * place + 1.0) - 0.05 * (place - 0.5)
    ),
}


@pytest.mark.parametrize("name", CURVES)
def test_a_course_is_found_as_it_was_made(name: str) -> None:
    curve = CURVES[name]
    noise = 1e-5 * np.random.default_rng(1).standard_normal(PERIODS)
    found = amplitude_trend(3.0 * (1.0 + curve(PLACE) + noise))
    assert found is not None
    course, mean = curve(PLACE), float(np.mean(1.0 + curve(PLACE)))
    off = np.abs(1.0 + found.curve(PLACE) - (1.0 + course) / mean)
    assert float(np.max(off)) < 1e-4  # of 0.02 to 0.05
    assert float(np.max(np.abs(found.rest))) < 1.2e-4


def test_a_walk_is_no_trend() -> None:
    random = np.random.default_rng(2)
    walks = 1.0 + 1e-3 * np.cumsum(random.standard_normal((60, PERIODS)), axis=1)
    assert sum(amplitude_trend(walk) is not None for walk in walks) <= 1  # by chance one in two hundred


def test_the_level_of_a_swing_about_a_ramp_is_that_of_the_ramp_over_the_record() -> None:
    """Of a record that goes on for a twentieth behind the periods, and of a swing of 2.3 cycles."""
    course = 0.02 * np.cos(2 * np.pi * 2.3 * PLACE + 1.0) + 0.05 * PLACE
    found = amplitude_trend(1.0 + course, after=0.05)
    assert found is not None
    mean = float(np.mean(1.0 + course))
    assert found.level == pytest.approx((1.0 + 0.05 * 0.5 * 1.05) / mean - 1.0, abs=1e-7)
    assert found.cycles == 0.0


def test_the_mean_of_a_ramp_is_known_as_well_as_that_of_a_constant() -> None:
    random, relative = np.random.default_rng(3), []
    count = (PERIODS + 1) * PER_PERIOD
    theta = 2 * np.pi * np.arange(count) / PER_PERIOD
    track = PhaseTrack(Polynomial([0.0, 2 * np.pi / PER_PERIOD]), count, "as it was made")
    for _ in range(12):
        ramp = 1.0 + 0.05 * (np.arange(count) / (count - 1) - 0.5)
        signal = ramp * np.cos(theta + random.uniform(0, 6)) + 1e-3 * random.standard_normal(count)
        coherent = coherent_samples(signal, 10e3, track)
        turns = (np.arange(count, dtype=np.float64) - FIRST_ROW) * (coherent.periods / coherent.samples)
        steady = with_steady_amplitude(coherent, wander(coherent).amplitude, turns, FIRST_ROW)
        assert steady.trend is not None
        spectrum, before = spectrum_of(steady.samples), spectrum_of(coherent)
        errors = line_errors(spectrum, 8, with_trend=(before, steady.trend.of_level))
        assert errors.standard[0] < 5e-5  # of 4e-3 as noise
        relative.append((spectrum.fundamental - 1.0) / errors.standard[0])
    assert 0.5 < np.sqrt(np.mean(np.square(relative))) < 1.3


def test_jitter_is_seen_where_the_signal_is_steep() -> None:
    random = np.random.default_rng(4)
    row = np.arange((PERIODS + 1) * PER_PERIOD, dtype=np.float64)
    track = PhaseTrack(Polynomial([0.0, 2 * np.pi / PER_PERIOD]), len(row), "as it was made")
    jitter = 0.1 * random.standard_normal(len(row))
    noise = 1e-3 * random.standard_normal(len(row))
    for times, expected in ((row, 0.0), (row + jitter, 0.1 * 2 * np.pi / PER_PERIOD)):
        signal = np.cos(2 * np.pi * times / PER_PERIOD) + noise
        found = phase_noise_rad(coherent_samples(signal, 10e3, track))
        assert found == pytest.approx(expected, rel=0.1)


def test_what_scatters_where_a_signal_is_steep_and_is_not_beside_its_fundamental_is_no_jitter() -> None:
    row = np.arange(121 * 200, dtype=np.float64)
    theta = 2.0 * np.pi * row / 200.0
    track = PhaseTrack(Polynomial([0.0, 2.0 * np.pi / 200.0]), len(row), "as it was made")
    # the ripple of the flux of a machine whose torque is held tightly
    ripple = 0.01 * np.diff(np.random.default_rng(4).standard_normal(len(row) + 3), n=3)
    coherent = coherent_samples(np.cos(theta) - ripple * np.sin(theta), 10e3, track)
    assert phase_noise_rad(coherent) < 5e-4
    # had the phase been followed, what is slow of jitter would not be there either: a row is the most
    assert phase_noise_rad(coherent, is_followed=True) == pytest.approx(0.3 * 2.0 * np.pi / 200.0, rel=0.01)


def test_the_memory_that_a_trend_takes_is_proportional_to_the_periods() -> None:
    periods = 8_000
    amplitudes = 1.0 + 1e-3 * np.random.default_rng(5).standard_normal(periods)
    tracemalloc.start()
    amplitude_trend(amplitudes)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 5_000 * periods  # bytes


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9])
def test_a_step_within_a_period_is_where_that_has_what_is_in_between(share: float) -> None:
    amplitudes = np.where(np.arange(PERIODS) < 17, 1.0, 1.04)
    amplitudes[17] = 1.0 + 0.04 * (1.0 - share)
    amplitudes += 1e-6 * np.random.default_rng(1).standard_normal(PERIODS)
    found = amplitude_trend(amplitudes)
    assert found is not None
    assert found.is_step
    mean = float(np.mean(amplitudes))
    assert float(np.max(np.abs(found.rest))) < 1e-5
    assert found.level == pytest.approx(0.0, abs=1e-6)
    near = (17.0 + share + np.array([-0.02, 0.02])) / PERIODS
    assert found.curve(near) == pytest.approx(np.array([1.0, 1.04]) / mean - 1.0, abs=1e-5)


def test_the_mean_of_a_step_is_known_as_well_as_the_phase_at_which_it_is_made() -> None:
    random, relative = np.random.default_rng(5), []
    count = (PERIODS + 1) * PER_PERIOD
    theta = 2 * np.pi * np.arange(count) / PER_PERIOD
    track = PhaseTrack(Polynomial([0.0, 2 * np.pi / PER_PERIOD]), count, "as it was made")
    for _ in range(24):
        edge = random.integers(count // 4, 3 * count // 4)
        course = np.where(np.arange(count) < edge, 1.0, 1.05)
        signal = course * np.cos(theta + random.uniform(0, 6)) + 1e-5 * random.standard_normal(count)
        coherent = coherent_samples(signal, 10e3, track)
        turns = (np.arange(count, dtype=np.float64) - FIRST_ROW) * (coherent.periods / coherent.samples)
        steady = with_steady_amplitude(coherent, wander(coherent).amplitude, turns, FIRST_ROW)
        assert steady.trend is not None
        value = spectrum_of(steady.samples).amplitude[coherent.periods]
        relative.append((value - float(np.mean(course))) / steady.trend.of_level)
    assert 0.3 < float(np.sqrt(np.mean(np.square(relative)))) < 1.4


@pytest.mark.parametrize("rate", [3.0, 16.0, 25.0])
@pytest.mark.parametrize("size", [0.1, -0.05])
def test_the_level_of_a_current_that_settles_is_that_over_the_record(rate: float, size: float) -> None:
    """Of periods whose amplitudes are means over them, and a record that goes on before and behind them."""
    before, after = 0.0064, 0.028
    edges = np.arange(PERIODS + 1.0) / PERIODS

    def mean(begin: Array | float, end: Array | float) -> Array:
        decay = np.exp(-rate * np.asarray(begin)) - np.exp(-rate * np.asarray(end))
        return np.asarray(1.0 + size * decay / (rate * (np.asarray(end) - begin)))

    amplitudes = mean(edges[:-1], edges[1:])
    found = amplitude_trend(5.0 * amplitudes, before, after)
    assert found is not None
    expected = float(mean(-before, 1.0 + after)) / float(np.mean(amplitudes)) - 1.0
    # of a rate that is the nearest of a fine grid
    assert found.level == pytest.approx(expected, abs=2e-4 * abs(size))
    assert float(np.max(np.abs(found.rest))) < 2e-3 * abs(size)
