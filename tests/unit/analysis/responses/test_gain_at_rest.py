"""The gain at rest where the lowest frequencies tell little: which fit counts, and how far off it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis import Basis, analyze_response
from benchtool.analysis.responses.gain_at_rest import gain_at_rest
from benchtool.analysis.responses.margins import margins
from benchtool.block import Block
from tests.at_length import at_length

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


def _rms(values: list[float]) -> float:
    return math.sqrt(float(np.mean(np.square(values))))


def _with_errors(truth: Complex | Floats, error: Floats, random: np.random.Generator) -> Complex:
    """Return responses whose gain and phase have relative errors, shape (n,)."""
    both = random.standard_normal((2, len(truth)))
    return np.asarray(truth * (1.0 + error * (both[0] + 1j * both[1])))


@pytest.mark.slow
def test_a_gain_that_is_level_by_chance_is_not_that_at_rest() -> None:
    """On the way to a resonance gains of large errors look constant: more terms say that they are not."""
    frequency_Hz = np.arange(23.5, 140.0)
    s = 1j * frequency_Hz / 55.0
    truth = 1.0 / (1.0 + 0.9 * s + s**2)
    error = 2e-4 * (frequency_Hz / 50.0) ** 2 + 0.02 * np.exp((23.5 - frequency_Hz) / 6.0)
    random = np.random.default_rng(3)
    missed = []
    for _ in range(40):
        found = gain_at_rest(frequency_Hz, _with_errors(truth, error, random), error)
        missed.append((found.gain - 1.0) / found.relative_error)
    assert 0.6 < _rms(missed) < 1.2
    assert float(np.mean(np.abs(missed) < 2.0)) > 0.9


@pytest.mark.slow
def test_a_loop_with_an_integral_part_rises_just_above_rest() -> None:
    """The zero of its controller is where polynomials of f^2 end; errors hide that they are off."""
    frequency_Hz = np.arange(1.0, 120.0, 0.5)
    random = np.random.default_rng(5)
    missed = []
    for _ in range(28):
        zero_Hz = random.uniform(3.0, 8.0)
        s = 1j * frequency_Hz / 30.0
        opened = (s + zero_Hz / 30.0) / s**2 * np.exp(-0.15 * s)
        error = np.full(len(frequency_Hz), 0.02)
        found = gain_at_rest(frequency_Hz, _with_errors(opened / (1.0 + opened), error, random), error)
        missed.append((found.gain - 1.0) / found.relative_error)
    assert 0.4 < _rms(missed) < 1.4
    assert float(np.mean(np.abs(missed) < 2.0)) > 0.85


def test_the_phase_tells_of_a_zero_below_the_lowest_frequency() -> None:
    """There the gain of a loop with an integral part is at the top of its hump, and level."""
    frequency_Hz, zero_Hz, crossover_Hz = np.arange(8.0, 120.0, 2.0), 4.0, 30.0
    s = 1j * frequency_Hz / crossover_Hz
    opened = (s + zero_Hz / crossover_Hz) / s**2 / (1.0 + 0.3 * s)
    truth, error = opened / (1.0 + opened), np.full(len(frequency_Hz), 1e-3)
    assert abs(truth[0]) > 1.08
    random = np.random.default_rng(6)
    found = [gain_at_rest(frequency_Hz, _with_errors(truth, error, random), error) for _ in range(24)]
    assert float(np.median([each.relative_error for each in found])) < 0.01
    assert 0.6 < _rms([(each.gain - 1.0) / each.relative_error for each in found]) < 1.4


@pytest.mark.parametrize("alike", [4, *at_length(1)])
def test_neighbours_with_one_error_count_once(alike: int) -> None:
    frequency_Hz = np.arange(1.0, 161.0)
    truth = 1.0 / (1.0 + 1j * frequency_Hz / 60.0)
    error = np.full(len(truth), 0.01)
    random = np.random.default_rng(4)
    missed = []
    for _ in range(18):
        alone = np.ones(len(truth) // alike, dtype=np.complex128)
        own = np.repeat(_with_errors(alone, error[::alike], random), alike)
        shared = np.full(len(truth), float(alike))
        found = gain_at_rest(frequency_Hz, truth * own, error * np.sqrt(shared), shared)
        missed.append((found.gain - 1.0) / found.relative_error)
    assert 0.6 < _rms(missed) < 1.3


def test_a_sweep_that_passes_the_lowest_frequencies_in_less_than_a_period_has_its_gain() -> None:
    """There what its ends leave in looks like the response, and is alike for neighbouring frequencies."""
    rate_Hz, missed = 4000.0, []
    for seed in range(6):
        random = np.random.default_rng(seed)
        time_s = np.arange(8000) / rate_Hz
        x = signal.chirp(time_s, 2.0, 2.0, 400.0, phi=-90.0) * signal.windows.tukey(len(time_s), 0.02)
        corner_Hz = random.uniform(40.0, 62.0)
        omega = 2.0 * math.pi * corner_Hz
        system = np.array([1.0]), np.array([1.0 / omega**2, 1.2 / omega, 1.0])
        numerator, denominator, _ = signal.cont2discrete(system, 1.0 / rate_Hz, "zoh")
        y = signal.lfilter(np.ravel(numerator), denominator, x) + 2e-3 * random.standard_normal(len(x))
        block = Block.from_arrays(rate_Hz, {"x": "Nm", "y": "Nm"}, x=x, y=np.asarray(y))
        (gain,) = (
            each for each in analyze_response(block, "x", "y").measurements if each.name == "response_gain"
        )
        assert gain.uncertainty is not None
        missed.append((gain.value - 1.0) / gain.uncertainty.standard)
    assert _rms(missed) < 1.4


def test_a_gain_that_goes_on_to_change_below_the_lowest_frequency_is_undefined() -> None:
    """A machine with a slow pole looks like any other from its resonance on, and so does its phase."""
    rate_Hz = 1000.0
    slow, sharp = 2.0 * math.pi * 0.3, 2.0 * math.pi * 30.0
    below = np.polymul([1.0 / slow, 1.0], [1.0 / sharp**2, 0.1 / sharp, 1.0])
    numerator, denominator, _ = signal.cont2discrete((np.array([1.0]), below), 1.0 / rate_Hz, "zoh")
    period, turn = 100, 2.0 * np.pi * np.arange(100) / 100
    one = np.sum([np.cos(line * turn + 0.3 * line**2) for line in range(1, 20)], axis=0)
    x = np.tile(one, 40)
    y = signal.lfilter(np.ravel(numerator), denominator, x)
    noisy = np.asarray(y) + 1e-3 * float(np.std(y)) * np.random.default_rng(1).standard_normal(len(x))
    block = Block.from_arrays(rate_Hz, {"x": "Nm", "y": "rad/s"}, x=x, y=noisy)
    measurements = analyze_response(block, "x", "y", begin_row=20 * period, period_rows=period).measurements
    found = {each.name: each for each in measurements}
    for name in ("response_gain", "bandwidth_3dB", "bandwidth_90deg", "resonance_peak"):
        assert math.isnan(found[name].value), name
        assert "goes on to change below" in found[name].reason, name


def test_a_gain_that_says_little_is_undefined() -> None:
    frequency_Hz = np.arange(8.0, 40.0, 4.0)
    error = np.full(len(frequency_Hz), 0.5)
    response = _with_errors(np.ones(len(frequency_Hz)), error, np.random.default_rng(8))
    assert "uncertain by" in gain_at_rest(frequency_Hz, response, error).undefined_because


def test_a_sensitivity_that_falls_from_the_lowest_frequency_on_has_no_peak() -> None:
    """Its peak is below the lines that are played."""
    frequency_Hz = np.arange(60.0, 1000.0, 10.0)
    s = 1j * frequency_Hz / 20.0
    closed = np.asarray(1.0 / (s**2 + 0.8 * s + 1.0), dtype=np.complex128)
    error = np.full(len(frequency_Hz), 1e-4)
    (peak,) = (
        each for each in margins(frequency_Hz, closed, error, Basis()) if each.name == "sensitivity_peak"
    )
    assert "the lowest frequency used" in peak.reason


@pytest.mark.parametrize("seed", range(6))
def test_where_no_ratio_describes_the_points_the_lowest_gain_is_as_far_off_as_the_nearest(seed: int) -> None:
    """Of a speed loop with a delay, from above the zero of its controller on, where the gain is 13 % higher,
    and with errors that neighbours share and that are larger than stated."""
    random = np.random.default_rng(seed)
    frequency_Hz = np.arange(2.25, 102.0, 0.5)
    s, omega = 2j * np.pi * frequency_Hz, 2 * np.pi * 7.5
    opened = omega * (s + 0.16 * omega) / s**2 / (1.0 + s / (4.0 * omega))
    response = 4.0 * opened / (1.0 + opened) * np.exp(-4e-3 * s)
    error: Floats = 3e-3 * np.exp(1.5 * np.log(2.25 / frequency_Hz)) + 2e-4
    noise = random.standard_normal((2, len(frequency_Hz) + 7))
    shared = np.convolve(noise[0] + 1j * noise[1], np.ones(8) / math.sqrt(8.0), "valid")
    found = gain_at_rest(frequency_Hz, response * (1.0 + error * shared), error, np.full(len(s), 8.0))
    assert abs(found.gain / 4.0 - 1.0) < 2.5 * found.relative_error
    assert found.relative_error < 0.15


def test_a_slow_pole_beside_a_zero_is_not_missed_by_many_points_above_them() -> None:
    """Linear least squares of all points find the fast poles twice, and the gain above the slow ones."""
    frequency_Hz = np.arange(0.4, 90.0, 0.4)
    s = 1j * frequency_Hz / 20.0
    opened = (s + 0.07) / s**2 / (1.0 + s / 3.0)
    error = 0.02 * np.sqrt(1.0 + (frequency_Hz / 40.0) ** 2)
    random, missed = np.random.default_rng(0), []
    for _ in range(14):
        found = gain_at_rest(frequency_Hz, _with_errors(opened / (1.0 + opened), error, random), error)
        missed.append((found.gain - 1.0) / found.relative_error)
    assert _rms(missed) < 1.5
    assert np.max(np.abs(missed)) < 4.0
