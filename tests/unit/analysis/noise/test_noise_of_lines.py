"""Noise of lines and of numbers made of them: its scatter against what their uncertainties claim."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.noise import coloured
from benchtool.analysis import (
    CoherentSpectrum,
    Measurement,
    coherent_spectrum,
    current_spectrum,
    total_harmonic_distortion,
    track_angle,
    track_tone,
)
from benchtool.analysis.noise.converter_lines import aliased_quantisation
from benchtool.analysis.noise.noise_of_lines import hann_quadrature, line_noise, noise_at_lines
from benchtool.analysis.spectra.line_errors import line_errors
from benchtool.analysis.spectra.modulation import noise_of_sum
from benchtool.analysis.uncertainty import combined
from benchtool.block import Block, Channel
from tests.at_length import at_length
from tests.unit.analysis.noise.lines_in_noise import (
    RATE_HZ,
    SAMPLES,
    SIGMA,
    spectrum_of,
    spectrum_of_bins,
)

Array = NDArray[np.float64]


@pytest.mark.parametrize(("samples", "frequency_Hz"), [(1_000, 97.3), *at_length((4_000, 411.0))])
def test_no_frequency_from_a_noisy_tone_is_surer_than_the_cramer_rao_bound(
    samples: int, frequency_Hz: float
) -> None:
    """Of amplitude 1 in white noise of rms 0.05: no unbiased estimate has less than 24 sigma^2 / n^3."""
    omega, claimed = 2 * np.pi * frequency_Hz / RATE_HZ, []
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 0.05, samples)
        current = np.cos(omega * np.arange(samples)) + noise
        block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, current[:, np.newaxis])
        spectrum = current_spectrum(block, "i_a", track_tone(current, "i_a"))
        (frequency,) = (each for each in spectrum.measurements if each.name == "fundamental_frequency")
        assert frequency.uncertainty is not None
        claimed.append(frequency.uncertainty.standard)

    bound = math.sqrt(24.0 * 0.05**2 / samples**3) * RATE_HZ / (2 * np.pi)
    assert np.mean(claimed) > 0.95 * bound


def test_two_lengths_of_one_record_agree_within_their_uncertainty() -> None:
    def thd(samples: int) -> dict[str, Measurement]:
        theta_e = 2 * np.pi * 50.0 * np.arange(samples, dtype=np.float64) / RATE_HZ
        noise = np.random.default_rng(samples).normal(0.0, 0.36, samples)
        block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, (np.cos(theta_e) + noise)[:, np.newaxis])
        spectrum = current_spectrum(block, "i_a", track_angle(theta_e, 1), current_rated_A_rms=1.0)
        return {each.name: each for each in spectrum.measurements}

    short, long = thd(4_065), thd(100_065)

    for name in ("current_thd_f", "current_thd_r", "current_tdd"):
        one, two = short[name].uncertainty, long[name].uncertainty
        assert one is not None
        assert two is not None
        assert abs(short[name].value - long[name].value) < 2.0 * math.hypot(one.standard, two.standard)
        assert "with which it is" in one.source


@pytest.mark.parametrize("frequency_Hz", [43.7, 97.3, *at_length(411.0)])
def test_a_clean_tone_is_as_far_off_as_its_uncertainty_says(frequency_Hz: float) -> None:
    theta_e = 2 * np.pi * frequency_Hz * np.arange(20_000, dtype=np.float64) / RATE_HZ
    block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, 4.0 * np.cos(theta_e)[:, np.newaxis])

    found = {each.name: each for each in current_spectrum(block, "i_a", track_angle(theta_e, 1)).measurements}

    expected = {"current_fundamental": 4.0, "current_max_low_harmonic": 0.0, "current_thd_f": 0.0}
    for name, value in expected.items():
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        assert abs(found[name].value - value) < 2.0 * uncertainty.standard
        assert uncertainty.standard < 1e-3


def _swinging(seed: int, together: bool) -> CoherentSpectrum:
    """Harmonics 5 and 7 and a fundamental whose amplitudes wander, with one another or each by itself."""
    samples, random = 8_065, np.random.default_rng(seed)
    theta_e = 2 * np.pi * 50.0 * np.arange(samples, dtype=np.float64) / RATE_HZ
    own = [0.02 * coloured(random.standard_normal(samples), 0.999) for _ in range(3)]
    lines = zip((1, 5, 7), (1.0, 0.05, 0.03), own[:1] * 3 if together else own, strict=True)
    clean = sum(size * (1.0 + wander) * np.cos(order * theta_e) for order, size, wander in lines)
    noise = random.normal(0.0, 1e-4, samples)
    return coherent_spectrum(np.asarray(clean) + noise, RATE_HZ, track_angle(theta_e, 1))


@pytest.mark.parametrize("together", [True, False])
def test_what_modulates_all_lines_alike_is_not_in_their_ratio(together: bool) -> None:
    found = [total_harmonic_distortion(_swinging(seed, together), 7) for seed in range(24)]

    error = np.array([each.ratio for each in found]) - math.hypot(0.05, 0.03)
    relative = error / np.array([each.standard for each in found])
    assert 0.5 < np.sqrt(np.mean(relative**2)) < 1.6
    assert np.sqrt(np.mean(error**2)) < (2e-4 if together else 1.0)


def test_noise_that_rises_towards_a_line_goes_on_to_rise() -> None:
    """Powers of eight pairs of bins, exponentially distributed about a Lorentz curve, and the line's own."""
    distance = np.arange(1.0, 9.0)
    for corner, least, most in ((math.inf, 0.85, 1.05), (3.35, 0.95, 1.25), (1.5, 1.1, 1.5)):
        random = np.random.default_rng(7)
        powers = random.exponential(1.0, (1500, 8)) / (1.0 + (distance / corner) ** 2)
        standard = np.sqrt(noise_at_lines(powers))
        relative = random.standard_normal(1500) / standard
        assert least < np.sqrt(np.mean(relative**2)) < most


def test_a_frequency_is_as_certain_as_its_window_makes_it() -> None:
    """A dc that decays leaks into the bins of a rectangular window, and hardly moves a fit under Hann's."""
    time_s = np.arange(12_000) / RATE_HZ
    noise = np.random.default_rng(3).normal(0.0, 1e-3, len(time_s))
    tone = np.cos(2 * np.pi * 20.0 * time_s + 1.0) + noise
    stated = []
    for dc in (0.0, 0.3):
        values = tone + dc * np.exp(-time_s / 0.1)
        block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, values[:, np.newaxis])
        found = current_spectrum(block, "i_a", track_tone(values)).measurements[0]
        assert found.uncertainty is not None
        assert abs(found.value - 20.0) < 4.0 * found.uncertainty.standard
        stated.append(found.uncertainty.standard)
    assert stated[1] < 3.0 * stated[0]


def test_steps_that_fold_beside_the_fundamental_are_in_its_frequency() -> None:
    """A period of 578.03 samples: orders 577 and 579 of the steps are 0.8 bins from the fundamental."""
    relative = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        time_s = np.arange(13_988) / RATE_HZ
        values = np.cos(2 * np.pi * 17.3 * time_s + random.uniform(0, 6.28))
        values += random.normal(0.0, 3e-4, len(time_s))
        step = 2.04 / 256
        values = np.round(values / step + random.uniform()) * step
        block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, values[:, np.newaxis])
        found = current_spectrum(block, "i_a", track_tone(values)).measurements[0]
        assert found.uncertainty is not None
        relative.append((found.value - 17.3) / found.uncertainty.standard)
    assert 0.4 < np.sqrt(np.mean(np.square(relative))) < 1.3


@pytest.mark.parametrize("phase_rad", [0.3, 1.0, 2.2])
def test_sidebands_act_on_amplitude_or_phase_whatever_the_phase_of_the_line(phase_rad: float) -> None:
    theta_e = 2 * np.pi * 50.0 * np.arange(SAMPLES, dtype=np.float64) / RATE_HZ
    bins = np.zeros(SAMPLES // 2 + 1, dtype=np.complex128)
    bins[1:25] = np.exp(2j * np.pi * np.random.default_rng(4).random(24))
    slow = np.fft.irfft(bins, SAMPLES)
    slow *= SIGMA / np.std(slow)
    quadratures = []
    for amplitude, moved_rad, acts, rests in ((slow, 0.0, 0, 1), (0.0, slow, 1, 0)):
        signal = (1.0 + amplitude) * np.cos(theta_e + phase_rad + moved_rad)
        spectrum = coherent_spectrum(signal, RATE_HZ, track_angle(theta_e, 1))
        noise = line_noise(spectrum, np.array([spectrum.periods]))
        found = float(noise.in_phase[0]), float(noise.quadrature[0])
        # of 24 sinusoids each is in two bins, of half its amplitude each
        assert found[acts] == pytest.approx(SIGMA / math.sqrt(24.0), rel=0.35)
        assert found[rests] < 0.1 * found[acts]
        quadratures.append(hann_quadrature(spectrum).standard)
    assert quadratures[0] < 0.1 * quadratures[1]


@pytest.mark.parametrize("periods", [2, *at_length(3, 5)])
def test_the_interval_of_an_amplitude_of_few_periods_holds_it_as_often_as_stated(periods: int) -> None:
    """Few pairs of bins count in the standard uncertainty, and not once more in the factor k."""
    random, bins, held = np.random.default_rng(3), np.arange(12 * periods + 1), 0
    for _ in range(600):
        noise = 1e-3 * random.standard_normal((2, len(bins)))
        phasor = noise[0] + 1j * noise[1] + (bins == periods)
        spectrum = CoherentSpectrum(bins * 50.0 / periods, np.abs(phasor), periods, 1e4, phasor)
        uncertain = combined(line_errors(spectrum, 3).budget(0), "")
        assert uncertain is not None
        assert json.loads(json.dumps([each.to_json() for each in uncertain.budget]))
        held += abs(float(np.abs(phasor[periods])) - 1.0) < uncertain.expanded
    assert held / 600 == pytest.approx(0.96, abs=0.022)


def test_three_periods_have_no_pairs_under_a_hann_window() -> None:
    assert math.isnan(hann_quadrature(spectrum_of({1: 1.0}, 1, 700)).standard)


def test_steps_fold_the_nearer_to_a_line_the_less_they_move_it() -> None:
    """A period of nearly 578 samples: orders 577 and 579 fold to 0.12 and 0.48 bins beside."""

    def aliased(per_period: float) -> Array:
        theta_e = 2 * np.pi * np.arange(round(24.3 * per_period), dtype=np.float64) / per_period
        spectrum = coherent_spectrum(np.cos(theta_e + 0.3), RATE_HZ, track_angle(theta_e, 1))
        return aliased_quantisation(spectrum, 2.04 / 256, 2)

    near, far = aliased(578.005), aliased(578.02)
    assert np.all(near > 0.0)
    assert np.all(near < 0.7 * far)
    assert aliased(577.995) == pytest.approx(near, rel=0.2)
    assert np.all(aliased(578.0) == 0.0)


def _stated(shape: Array, periods: int = 40) -> Array:
    """Return the standard uncertainty of harmonic 5 in bins of noise of these mean squares, 300 times."""
    random, line = np.random.default_rng(21), np.array([5 * periods])
    found = []
    for _ in range(300):
        parts = random.standard_normal((2, len(shape))) * np.sqrt(shape)
        phasor = parts[0] + 1j * parts[1]
        phasor[line] = 100.0
        found.append(float(line_noise(spectrum_of_bins(phasor, periods), line).in_phase[0]))
    return np.array(found)


def test_white_noise_beside_a_line_is_known_by_all_bins_between_the_harmonics() -> None:
    """Eight pairs alone are off by a quarter in four records of ten."""
    stated = _stated(np.full(500, 1e-4)) / 1e-2
    assert np.mean(np.abs(stated - 1.0) < 0.25) > 0.8
    assert np.sqrt(np.mean(1.0 / stated**2)) == pytest.approx(1.0, abs=0.15)


def test_noise_that_is_not_that_around_a_line_is_its_own() -> None:
    place = np.abs(np.arange(500) - 200.0)
    for of_line, least, most in ((25.0, 4.0, 9.0), (0.04, 0.15, 0.3)):
        stated = _stated(np.where(place < 10, of_line, 1.0))
        assert least < np.median(stated) < most


def test_the_noise_of_a_sum_is_known_by_all_bins_around_its_lines() -> None:
    random, periods, weights = np.random.default_rng(22), 40, np.array([0.3, 0.0, 0.0, 0.0, -0.6, 0.0, 1.0])
    expected, found = math.sqrt(float(weights @ weights)), []
    for _ in range(200):
        parts = random.standard_normal((2, 500))
        phasor = parts[0] + 1j * parts[1]
        phasor[periods * np.arange(1, 8)] = 100.0
        found.append(noise_of_sum(spectrum_of_bins(phasor, periods), weights).standard / expected)
    assert np.mean(np.abs(np.array(found) - 1.0) < 0.25) > 0.75


def test_the_noise_of_a_sum_does_not_hang_on_the_harmonic_at_the_edge_of_the_band() -> None:
    random, periods, weights = np.random.default_rng(23), 4, np.zeros(25)
    weights[2] = 1.0
    weights[24] = 0.01
    found, dof = [], []
    for _ in range(200):
        parts = random.standard_normal((2, 102))  # one bin above the last harmonic
        phasor = parts[0] + 1j * parts[1]
        phasor[periods * np.arange(1, 26)] = 100.0
        each = noise_of_sum(spectrum_of_bins(phasor, periods), weights)
        found.append(each.standard)
        dof.append(each.dof)
    assert np.median(dof) > 12.0
    assert np.quantile(found, 0.1) > 0.6
    assert np.quantile(found, 0.9) < 2.0


@pytest.mark.parametrize("periods", [2, 3, 5])
@pytest.mark.parametrize("steepness", [0.0, 1.0, 2.0])
def test_noise_of_few_periods_is_told_by_many_bins(periods: int, steepness: float) -> None:
    """Two periods have one pair of bins about all harmonics, which may be small by chance: error / u of an
    error as large as the noise was 14 once in 300 records, and 0.4 in most."""
    random, weights = np.random.default_rng(24), np.array([-0.3, 0.0, 0.0, 0.0, 0.8, 0.0, 0.6])
    bins = np.arange(1.0, 50 * periods + 1)
    level = np.concatenate([[0.0], (bins / periods) ** (-0.5 * steepness)])
    lines = periods * np.arange(1, 8)
    true2 = float(weights**2 @ level[lines] ** 2)
    relative = []
    for _ in range(300):
        parts = random.standard_normal((2, len(level)))
        phasor = level * (parts[0] + 1j * parts[1])
        phasor[lines] = 100.0
        relative.append(math.sqrt(true2) / noise_of_sum(spectrum_of_bins(phasor, periods), weights).standard)
    assert 0.7 < math.sqrt(float(np.mean(np.square(relative)))) < 1.2
    assert np.max(relative) < 2.5


@pytest.mark.parametrize(
    ("upper", "lower", "lost", "wanders"), [(1j, 1j, 0.08, False), (1.0, 1.0, 0.0, True)]
)
def test_pairs_in_quadrature_are_lost_by_the_line_and_pairs_in_phase_are_its_wander(
    upper: complex, lower: complex, lost: float, wanders: bool
) -> None:
    """Eight pairs of 1 beside a line of 100: of a phase of variance 0.04^2 rad^2, or of the amplitude."""
    phasor, offsets = np.full(500, 1e-6 + 0j), np.arange(1, 9)
    phasor[200], phasor[200 + offsets], phasor[200 - offsets] = 100.0, upper, lower
    found = line_noise(spectrum_of_bins(phasor, 40), np.array([200]))
    assert found.lost[0] == pytest.approx(lost, rel=1e-3)
    assert bool(found.wanders[0]) is wanders


@pytest.mark.parametrize(("pairs", "factor2"), [(1, 9.0), (2, 2.0), (3, 1.5 * 1.2), (4, 4.0 / 3.0 * 1.2)])
def test_the_noise_of_few_pairs_has_what_their_number_adds(pairs: int, factor2: float) -> None:
    """Of dof 2 n Student's variance n / (n - 1), and the median of n exponential values below their mean."""
    assert noise_at_lines(np.full((1, pairs), 0.01))[0] == pytest.approx(0.01 * factor2)
