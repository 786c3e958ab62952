"""Spectra of lines in white noise of known size, and of bins that are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import CoherentSpectrum, coherent_spectrum, noise_floor, track_angle
from benchtool.analysis.noise.noise import NoiseFloor

RATE_HZ = 10e3
SAMPLES = 20_065  # 100 periods and the margins of the interpolation
SIGMA = 0.01


def spectrum_of(content: dict[float, float], seed: int, samples: int = SAMPLES) -> CoherentSpectrum:
    """Harmonics by order and amplitude at 50 Hz, in white Gaussian noise of rms SIGMA."""
    theta_e = 2 * np.pi * 50.0 * np.arange(samples, dtype=np.float64) / RATE_HZ
    clean = np.sum([amplitude * np.cos(order * theta_e) for order, amplitude in content.items()], axis=0)
    noise = np.random.default_rng(seed).normal(0.0, SIGMA, samples)
    return coherent_spectrum(clean + noise, RATE_HZ, track_angle(theta_e, 1))


def spectrum_of_bins(phasor: NDArray[np.complex128], periods: int, samples: float = 1e4) -> CoherentSpectrum:
    """Bins, 10 Hz wide, over so many periods."""
    return CoherentSpectrum(10.0 * np.arange(float(len(phasor))), np.abs(phasor), periods, samples, phasor)


def of_bins(square: NDArray[np.float64], periods: int, seed: int = 0) -> CoherentSpectrum:
    """Bins with these squares, and phases at random, over so many periods."""
    phasor = np.sqrt(square) * np.exp(2j * np.pi * np.random.default_rng(seed).random(len(square)))
    return spectrum_of_bins(phasor, periods)


def floor_of(spectrum: CoherentSpectrum, *orders: float, has_moved: bool = False) -> NoiseFloor:
    """The noise floor, which there is."""
    found = noise_floor(spectrum, *orders, has_moved=has_moved)
    assert found is not None
    return found
