"""Spectra against signals of known content and against least squares, a second way to the same numbers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import (
    CoherentSpectrum,
    amplitude_spectrum,
    coherent_spectrum,
    harmonics,
    largest_low_component,
    total_harmonic_distortion,
    track_angle,
    track_tone,
)
from benchtool.analysis.coherent.resampling import HALF_WIDTH, interpolate
from benchtool.errors import AnalysisError

RATE_HZ = 10e3
POLE_PAIRS = 4
Array = NDArray[np.float64]


def rotation(frequency_Hz: float, samples: int, drift_Hz_s: float = 0.0) -> Array:
    """Electrical angle, rad, unwrapped."""
    time_s = np.arange(samples) / RATE_HZ
    angle: Array = 2 * np.pi * (0.1 + frequency_Hz * time_s + drift_Hz_s / 2 * time_s**2)
    return angle


def encoder(theta_e: Array, counts: int = 10000) -> Array:
    """Mechanical angle in 0 to 2 pi, as an encoder of that many counts gives it."""
    step = 2 * np.pi / counts
    angle: Array = np.floor(np.mod(theta_e / POLE_PAIRS, 2 * np.pi) / step) * step
    return angle


def coherent(samples: Array, theta_e: Array) -> CoherentSpectrum:
    return coherent_spectrum(samples, RATE_HZ, track_angle(encoder(theta_e), POLE_PAIRS))


def least_squares(samples: Array, theta_e: Array, count: int) -> Array:
    """Amplitudes of harmonics 1 to `count` by a fit of sines and cosines of the true angle, and dc."""
    orders = np.arange(1, count + 1)
    basis = np.hstack(
        [np.ones((len(samples), 1)), np.cos(np.outer(theta_e, orders)), np.sin(np.outer(theta_e, orders))]
    )
    solution = np.linalg.lstsq(basis, samples, rcond=None)[0]
    amplitude: Array = np.hypot(solution[1 : count + 1], solution[count + 1 :])
    return amplitude


@pytest.mark.parametrize(
    ("frequency_Hz", "samples", "drift_Hz_s"),
    [(10.0, 5000, 0.0), (10.037, 5200, 0.0), (10.0, 5200, 0.5), (49.83, 3000, 2.0), (99.7, 20000, -1.0)],
)
def test_known_harmonics_are_read_to_a_thousandth(
    frequency_Hz: float, samples: int, drift_Hz_s: float
) -> None:
    theta_e = rotation(frequency_Hz, samples, drift_Hz_s)
    signal = 0.05 + 0.64 * np.cos(theta_e - 0.4) + 0.02 * np.cos(5 * theta_e) + 0.007 * np.sin(7 * theta_e)

    spectrum = coherent(signal, theta_e)
    amplitude = harmonics(spectrum)

    assert amplitude[0] == pytest.approx(0.64, rel=2e-4)
    assert amplitude[4] == pytest.approx(0.02, rel=2e-3)
    assert amplitude[6] == pytest.approx(0.007, rel=5e-3)
    assert spectrum.amplitude[0] == pytest.approx(0.05, rel=1e-3)
    assert total_harmonic_distortion(spectrum).ratio == pytest.approx(np.hypot(0.02, 0.007) / 0.64, rel=2e-3)


def test_coherent_dft_agrees_with_least_squares_on_every_harmonic() -> None:
    generator = np.random.default_rng(11)
    theta_e = rotation(20.3, 6000, 0.7)
    signal = np.asarray(
        sum(0.7 / order**2 * np.cos(order * theta_e + generator.uniform(0, 6)) for order in range(1, 51))
    )

    amplitude = harmonics(coherent(signal, theta_e))[:50]

    np.testing.assert_allclose(amplitude, least_squares(signal, theta_e, 50), atol=1e-4 * 0.7)


def test_noise_floor_of_a_pure_sine_is_below_minus_80_dB() -> None:
    theta_e = rotation(10.013, 5200, 0.3)

    spectrum = coherent(0.64 * np.cos(theta_e), theta_e)

    # what remains is the quantization of the encoder
    assert largest_low_component(spectrum).amplitude < 1e-4 * 0.64


def test_with_an_exact_angle_the_floor_is_below_minus_115_dB() -> None:
    theta_e = rotation(10.013, 5200, 0.3)
    track = track_angle(theta_e / POLE_PAIRS, POLE_PAIRS)

    spectrum = coherent_spectrum(np.cos(theta_e), RATE_HZ, track)

    others = np.delete(spectrum.amplitude, spectrum.periods)
    assert np.max(others) < 1.8e-6
    assert spectrum.amplitude[spectrum.periods] == pytest.approx(1.0, abs=1e-5)


def test_an_interharmonic_below_ten_times_the_fundamental_is_caught() -> None:
    theta_e = rotation(10.0, 5200)
    signal = np.cos(theta_e) + 0.01 * np.cos(5 * theta_e) + 0.03 * np.cos(2.4 * theta_e)

    largest = largest_low_component(coherent(signal, theta_e))

    assert largest.frequency_Hz == pytest.approx(24.0, rel=1e-4)
    assert largest.amplitude == pytest.approx(0.03, rel=1e-2)


def test_a_sideband_of_a_speed_oscillation_is_not_hidden() -> None:
    theta_e = rotation(10.0, 5200)
    modulated = theta_e + 0.02 * np.sin(2 * theta_e)

    largest = largest_low_component(coherent(np.cos(modulated), modulated))

    # cos(x + b sin 2x) has components b/2 at 1x - 2x and at 3x; the one at 3x is alone
    assert largest.amplitude == pytest.approx(0.01, rel=0.05)


def test_dc_and_what_lies_at_ten_times_the_fundamental_do_not_count_as_low() -> None:
    theta_e = rotation(10.0, 5200)
    signal = 5.0 + np.cos(theta_e) + 0.2 * np.cos(10 * theta_e) + 0.004 * np.cos(3 * theta_e)

    largest = largest_low_component(coherent(signal, theta_e))

    assert largest.frequency_Hz == pytest.approx(30.0, rel=1e-4)
    assert largest.amplitude == pytest.approx(0.004, rel=1e-2)


@pytest.mark.parametrize("disturbance_Hz", [3000.0, 4100.0, 4700.0, 4999.0])
def test_components_near_the_nyquist_frequency_do_not_fold_into_the_low_band(disturbance_Hz: float) -> None:
    theta_e = rotation(10.02, 5200, 0.4)
    time_s = np.arange(5200) / RATE_HZ
    signal = 0.64 * np.cos(theta_e) + 0.3 * np.cos(2 * np.pi * disturbance_Hz * time_s)

    spectrum = coherent(signal, theta_e)

    assert largest_low_component(spectrum).amplitude < 1e-3 * 0.3
    assert harmonics(spectrum)[0] == pytest.approx(0.64, rel=1e-3)


def test_harmonics_end_where_the_band_ends_and_thd_says_how_many_there_were() -> None:
    theta_e = rotation(200.0, 5000)
    # harmonic 30 is at 6 kHz: sampled, it is an alias at 4 kHz, in the place of harmonic 20
    signal = np.cos(theta_e) + 0.1 * np.cos(3 * theta_e)

    distortion = total_harmonic_distortion(coherent(signal, theta_e))

    assert distortion.highest_harmonic == 22
    assert distortion.ratio == pytest.approx(0.1, rel=1e-3)


def test_thd_of_a_square_wave_to_harmonic_50() -> None:
    theta_e = rotation(10.0, 6000)
    odd = np.arange(1, 51, 2)
    signal = np.sum(np.sin(np.outer(theta_e, odd)) / odd, axis=1)

    distortion = total_harmonic_distortion(coherent(signal, theta_e))

    assert distortion.highest_harmonic == 50
    assert distortion.ratio == pytest.approx(np.sqrt(np.sum(1.0 / odd[1:] ** 2)), rel=1e-3)


def test_backward_rotation_reads_the_same() -> None:
    theta_e = rotation(10.0, 5200)
    signal = 0.64 * np.cos(theta_e) + 0.01 * np.cos(5 * theta_e)

    backward = coherent(signal, -theta_e)

    np.testing.assert_allclose(harmonics(backward)[:50], harmonics(coherent(signal, theta_e))[:50], atol=1e-4)
    assert backward.fundamental_Hz > 0


def test_frequency_found_from_the_signal_itself() -> None:
    theta_e = rotation(12.345, 6000)
    signal = 3.0 + 0.64 * np.cos(theta_e) + 0.05 * np.cos(5 * theta_e)

    spectrum = coherent_spectrum(signal, RATE_HZ, track_tone(signal))

    assert spectrum.fundamental_Hz == pytest.approx(12.345, rel=1e-6)
    assert harmonics(spectrum)[0] == pytest.approx(0.64, rel=1e-4)
    assert harmonics(spectrum)[4] == pytest.approx(0.05, rel=1e-3)


@pytest.mark.parametrize("window", ["hann", "flattop"])
def test_windowed_spectrum_reads_amplitude_dc_and_the_nyquist_bin(window: str) -> None:
    number = np.arange(1000)
    signal = 2.0 + 0.5 * np.cos(2 * np.pi * 50 * number / 1000) + 0.25 * np.cos(np.pi * number)

    spectrum = amplitude_spectrum(signal, 1000.0, "hann" if window == "hann" else "flattop")

    assert spectrum.frequency_Hz[50] == 50.0
    assert spectrum.amplitude[[0, 50, 500]] == pytest.approx([2.0, 0.5, 0.25])


def test_windowed_spectrum_of_an_odd_number_of_samples_ends_in_a_full_bin() -> None:
    signal = np.cos(2 * np.pi * 400 * np.arange(1001) / 1001)

    spectrum = amplitude_spectrum(signal, 1001.0)

    assert len(spectrum.amplitude) == 501
    assert spectrum.amplitude[400] == pytest.approx(1.0)


def test_between_bins_a_flat_top_window_reads_right_and_a_hann_window_low() -> None:
    signal = np.cos(2 * np.pi * 50.5 * np.arange(1000) / 1000)

    assert np.max(amplitude_spectrum(signal, 1000.0, "flattop").amplitude) == pytest.approx(1.0, rel=2e-3)
    assert np.max(amplitude_spectrum(signal, 1000.0, "hann").amplitude) == pytest.approx(0.849, rel=2e-3)


def test_interpolation_is_exact_to_1e_4_below_its_band_edge() -> None:
    positions = np.linspace(40.0, 900.0, 1777)
    for share in (0.01, 0.1, 0.25, 0.4, 0.45):
        omega = 2 * np.pi * share
        values = interpolate(np.cos(omega * np.arange(1000)), positions)
        np.testing.assert_allclose(values, np.cos(omega * positions), atol=1e-4)


@pytest.mark.parametrize("position", [HALF_WIDTH - 1.5, 100.0 - HALF_WIDTH, np.nan])
def test_interpolation_refuses_positions_near_the_ends(position: float) -> None:
    with pytest.raises(ValueError, match="samples on either side"):
        interpolate(np.arange(100.0), np.array([position]))


def test_a_record_shorter_than_two_periods_is_refused() -> None:
    theta_e = rotation(10.0, 1900)

    with pytest.raises(AnalysisError, match=r"1\.90 electrical periods, at least 2"):
        coherent(np.cos(theta_e), theta_e)
    with pytest.raises(AnalysisError, match="electrical periods"):
        track_tone(np.cos(theta_e[:1500]))


def test_two_periods_that_the_margins_of_interpolation_break_are_refused() -> None:
    theta_e = rotation(10.0, 2010)

    with pytest.raises(AnalysisError, match="2 and 64 samples are needed"):
        coherent(np.cos(theta_e), theta_e)


def test_standstill_is_refused() -> None:
    with pytest.raises(AnalysisError, match="'theta_m' is constant"):
        track_angle(np.full(5000, 1.0), POLE_PAIRS)
    with pytest.raises(AnalysisError, match="electrical periods"):
        track_angle(1.0 + 1e-3 * np.sin(np.arange(5000.0)), POLE_PAIRS)


def test_a_speed_that_is_not_steady_is_refused() -> None:
    with pytest.raises(AnalysisError, match=r"changes by 2\d % within the window, at most 10 %"):
        track_angle(encoder(rotation(10.0, 5200, 5.0)), POLE_PAIRS)


def test_a_fundamental_beyond_the_band_is_refused() -> None:
    theta_e = rotation(4700.0, 5000)
    track = track_angle(theta_e / 4, 4)

    with pytest.raises(AnalysisError, match="record at a higher rate"):
        coherent_spectrum(np.cos(theta_e), RATE_HZ, track)


def test_a_constant_current_is_refused() -> None:
    track = track_angle(encoder(rotation(10.0, 5200)), POLE_PAIRS)

    with pytest.raises(AnalysisError, match="'i_a' is constant at 0"):
        coherent_spectrum(np.zeros(5200), RATE_HZ, track, "i_a")
