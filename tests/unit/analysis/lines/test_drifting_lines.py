"""Lines that drift over so many bins that they stand out of none."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy import fft
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchtool.analysis.lines import spectral_lines
from benchtool.analysis.lines.drifting_lines import drifting_line
from benchtool.analysis.measurement import Measurement
from benchtool.analysis.spectral_window import spectral_window
from benchtool.block import Block

Array = NDArray[np.float64]

RATE_HZ, COUNT = 10e3, 10_000
ROWS = np.arange(COUNT)


def line(amplitude: float, frequency_Hz: float, drift: float) -> Array:
    """A line whose frequency rises by a share of its mean over the record."""
    time_s = ROWS / RATE_HZ
    turns = frequency_Hz * time_s * (1.0 + 0.5 * drift * (time_s - 1.0))
    return np.asarray(amplitude * np.cos(2.0 * np.pi * turns + 0.7))


def noise(rms: float, seed: int = 1) -> Array:
    return rms * np.random.default_rng(seed).standard_normal(COUNT)


def windowed(samples: Array) -> NDArray[np.complex128]:
    weights = spectral_window("hann", len(samples))
    return np.asarray(fft.rfft((samples - np.mean(samples)) * weights) * (2.0 / np.sum(weights)))


def lines_of(samples: Array) -> tuple[Measurement, ...]:
    return spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=samples), "torque").measurements


@pytest.mark.parametrize("drift", [-0.02, 0.02, 0.08, 0.3])
def test_its_power_tells_its_amplitude(drift: float) -> None:
    found = drifting_line(windowed(line(0.05, 960.0, drift) + noise(2e-3)), 3)
    assert found is not None
    assert found.amplitude == pytest.approx(0.05, rel=5e-3)
    assert found.place == pytest.approx(960.0, abs=1.0)
    assert found.reach >= 0.2 * 960.0 * abs(drift)


@pytest.mark.parametrize("drift", [0.02, 0.08])
def test_a_smaller_line_that_stands_out_is_not_called_the_largest(drift: float) -> None:
    """Order 24 over 19 to 77 bins, beside order 6 over a quarter of them."""
    for each in lines_of(line(0.02, 240.0, drift) + line(0.05, 960.0, drift) + noise(2e-3)):
        assert np.isnan(each.value)
        assert re.match(r"a line of about 0\.050?\d? Nm drifts around 9[56]\d", each.reason)


def test_a_larger_line_that_stands_out_is_the_largest_beside_it() -> None:
    frequency, amplitude = lines_of(line(0.05, 240.0, 0.0) + line(0.04, 960.0, 0.05) + noise(2e-3))
    assert frequency.value == pytest.approx(240.0, abs=0.01)
    assert amplitude.value == pytest.approx(0.05, rel=2e-3)


def test_a_line_of_its_own_mean_is_what_it_was() -> None:
    frequency, _ = lines_of(line(0.05, 240.0, 0.02) + noise(2e-3))
    assert frequency.value == pytest.approx(240.0, abs=0.05)


def _clicks() -> Array:
    samples = noise(1e-3)
    samples[[2000, 2100, 7000]] += 5.0
    return samples


def _resonance(seed: int) -> Array:
    random = np.random.default_rng(seed)
    place, damped = random.uniform(0.1, 2.0), float(random.choice([0.99, 0.995, 0.998]))
    return np.asarray(lfilter([1.0], [1.0, -2.0 * damped * np.cos(place), damped**2], noise(1.0, seed)))


@pytest.mark.parametrize(
    "samples",
    [
        noise(1.0),
        _clicks(),
        np.exp(-ROWS / 300.0) + noise(1e-3),
        np.exp(-ROWS / 300.0) * np.cos(0.3 * ROWS) + noise(1e-3),
        line(1.0, 960.3, 0.0) + noise(1e-3),
        np.zeros(COUNT),
        line(1.0, 960.3, 0.0)[:40],
    ],
    ids=["noise", "clicks", "decay", "ring", "steady", "silence", "short"],
)
def test_nothing_else_is_one(samples: Array) -> None:
    assert drifting_line(windowed(samples), 3) is None


def test_noise_about_a_resonance_is_none() -> None:
    assert sum(drifting_line(windowed(_resonance(seed)), 3) is not None for seed in range(60)) <= 1
