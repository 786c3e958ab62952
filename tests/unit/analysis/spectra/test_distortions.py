"""Distortions of lines in noise of known size, against the uncertainties that they claim."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import (
    CoherentSpectrum,
    Measurement,
    Reference,
    current_spectrum,
    total_harmonic_distortion,
    track_tone,
)
from benchtool.analysis.coherent.spectrum import FIRST_ROW
from benchtool.block import Block
from tests.at_length import at_length
from tests.unit.analysis.noise.lines_in_noise import spectrum_of

RATE_HZ = 10e3


@pytest.mark.slow
@pytest.mark.parametrize("reference", list(Reference))
def test_a_distortion_scatters_by_its_uncertainty(reference: Reference) -> None:
    # a fundamental not much above its harmonics, so that its own uncertainty counts
    found = [
        total_harmonic_distortion(spectrum_of({1: 0.3, 3: 0.2, 5: 0.2}, seed, 4065), 7, reference, 2.0)
        for seed in range(300)
    ]

    assert_holds([each.ratio for each in found], [each.standard for each in found])


def test_noise_alone_reads_the_distortion_that_is_foretold() -> None:
    found = [total_harmonic_distortion(spectrum_of({1: 1.0}, seed, 4065)) for seed in range(50)]

    ratios = np.array([each.with_noise for each in found])
    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(np.mean([each.noise for each in found]), rel=0.1)


@pytest.mark.parametrize("third", [0.002, *at_length(0.0, 0.001, 0.005, 0.05)])
def test_what_noise_adds_is_taken_out(third: float) -> None:
    # 49 harmonics of noise read 0.0022, so that the lines are from nothing to far above it
    spectra = [spectrum_of({1: 1.0, 3: third}, seed, 4065) for seed in range(60)]
    found = [
        total_harmonic_distortion(spectrum, 50, reference)
        for spectrum in spectra
        for reference in (Reference.FUNDAMENTAL, Reference.TOTAL)
    ]

    assert np.mean([abs(each.ratio - third) < 2.0 * each.standard for each in found]) > 0.9
    assert np.mean([each.with_noise for each in found]) > third
    # the squares are right on average, the roots cannot be below zero
    squares = np.array([each.with_noise**2 - each.noise**2 for each in found])
    assert np.mean(squares) == pytest.approx(third**2, abs=5 * np.std(squares) / math.sqrt(len(spectra)))


@pytest.mark.slow
def test_a_distortion_not_much_above_its_noise_scatters_by_its_uncertainty() -> None:
    found = [
        total_harmonic_distortion(spectrum_of({1: 1.0, 3: 0.006, 5: 0.006}, seed, 4065))
        for seed in range(300)
    ]

    assert_holds([each.ratio for each in found], [each.standard for each in found])


@pytest.mark.parametrize("third", [0.0, *at_length(0.001)])
def test_the_mean_of_many_records_keeps_what_is_cut_off_at_zero(third: float) -> None:
    spectra = [spectrum_of({1: 1.0, 3: third}, seed, 4065) for seed in range(40)]
    found = [total_harmonic_distortion(spectrum, 50) for spectrum in spectra]

    mean, scatter = np.mean([each.ratio for each in found]), np.std([each.ratio for each in found])
    cut_off = [line.standard for each in found for line in each.budget if "cut off" in line.name]
    u = math.hypot(scatter / math.sqrt(len(found)), sum(cut_off) / len(found))
    assert abs(mean - third) < 2.0 * u
    if third == 0.0:
        assert mean > 3.0 * scatter / math.sqrt(len(found))


def assert_holds(values: list[float], claimed: list[float]) -> None:
    """The rms of deviation over uncertainty is about 1; one record in twenty shows noise that rises towards a
    line by chance, and claims twice as much as it should."""
    z = (np.array(values) - np.mean(values)) / np.array(claimed)
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.2)
    assert 0.92 <= np.mean(np.abs(z) <= 2.0) <= 0.985
    assert np.median(claimed) == pytest.approx(np.std(values), rel=0.25)


def test_without_lines_a_distortion_is_uncertain_by_the_noise_alone() -> None:
    """Harmonics of just the noise's mean square n^2: nothing is left, and each square deviates by n^2."""
    n, periods, orders = 1e-3, 400, 50
    amplitude = np.full(periods * (orders + 1), n * math.sqrt(math.log(2.0)))  # the median of such noise
    amplitude[periods::periods] = n
    amplitude[periods] = 1.0
    phasor = np.asarray(amplitude, dtype=np.complex128)
    spectrum = CoherentSpectrum(0.1 * np.arange(float(len(amplitude))), amplitude, periods, 1e5, phasor)

    found = total_harmonic_distortion(spectrum)

    assert found.ratio == pytest.approx(0.0, abs=1e-4)
    of_squares = n**2 * math.sqrt(orders - 1)
    # these bins are all in phase, as noise is not, and the noise about each line is read off few of them
    assert found.standard == pytest.approx(0.5 * math.sqrt(2.0 * of_squares), rel=0.4)


def with_noise(samples: NDArray[np.float64]) -> Measurement:
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=samples)
    found = current_spectrum(block, "i_a", track_tone(samples))
    return next(each for each in found.measurements if each.name == "current_thd_f_plus_noise")


@pytest.mark.parametrize("periods", [12.3, *at_length(40.3)])
def test_thd_with_noise_scatters_by_its_uncertainty(periods: float) -> None:
    """Of the noise nine tenths are in the band, and an amplitude is sqrt(2) of an rms."""
    turned = np.arange(round(200 * periods)) / 200.0
    truth, errors = math.hypot(3.0, 100.0 * math.sqrt(2.0 * 0.9) * 0.01), []
    for seed in range(10):
        random = np.random.default_rng(seed)
        signal = np.cos(2 * np.pi * turned) + 0.03 * np.cos(10 * np.pi * turned + random.uniform(0, 6.28))
        found = with_noise(signal + 0.01 * random.standard_normal(len(signal)))
        assert found.uncertainty is not None
        errors.append((found.value - truth) / found.uncertainty.standard)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_the_steps_of_a_converter_are_noise_in_thd_with_noise() -> None:
    turned, step = np.arange(8050) / 200.7, 2.1 / 2**7
    found = with_noise(np.round(np.cos(2 * np.pi * turned) / step) * step)
    assert found.uncertainty is not None
    assert found.value == pytest.approx(100.0 * step / math.sqrt(6.0), rel=0.2)
    assert found.uncertainty.expanded < 0.1 * found.value


@pytest.mark.parametrize("lines", [(6.21, 6.24), *at_length(((6.21,),))])
def test_what_is_between_harmonics_is_in_thd_with_noise_but_is_no_scatter(lines: tuple[float, ...]) -> None:
    turned = np.arange(round(200 * 37.6)) / 200.0
    truth, errors, claimed = 100.0 * math.hypot(0.05, *(0.02 for _ in lines)), [], []
    for seed in range(12):
        random = np.random.default_rng(seed)
        parts = ((1.0, 1.0), (5.0, 0.05), *((each, 0.02) for each in lines))
        turns = random.uniform(0, 2 * np.pi, len(parts))
        signal = sum(a * np.cos(2 * np.pi * k * turned + b) for (k, a), b in zip(parts, turns, strict=True))
        found = with_noise(np.asarray(signal) + 1e-4 * random.standard_normal(len(turned)))
        assert found.uncertainty is not None
        errors.append((found.value - truth) / found.uncertainty.standard)
        claimed.append(found.uncertainty.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.5
    assert max(claimed) < 0.01 * truth


@pytest.mark.parametrize("line", [0.0, 0.02])
def test_a_decaying_dc_is_no_scatter_of_thd_with_noise(line: float) -> None:
    turned = np.arange(8000) / 200.0
    found = []
    for seed in range(10):
        random = np.random.default_rng(seed)
        signal = np.cos(2 * np.pi * (turned + random.uniform())) + 0.5 * np.exp(-turned / 4.0)
        signal += line * np.cos(2 * np.pi * (2.46 * turned + random.uniform()))
        found.append(with_noise(signal + 1e-3 * random.standard_normal(len(signal))))
    values = [each.value for each in found]
    decay = 0.5 * np.exp(-turned[FIRST_ROW : FIRST_ROW + 39 * 200] / 4.0)  # in the whole periods
    truth = 100.0 * math.hypot(math.sqrt(2.0) * float(np.std(decay)), line)
    assert np.mean(values) == pytest.approx(truth, rel=1e-3 if not line else 2e-2)
    claimed = [each.uncertainty.standard for each in found if each.uncertainty is not None]
    assert len(claimed) == len(found)
    assert 0.7 < np.std(values, ddof=1) / np.mean(claimed) < 1.5


@pytest.mark.parametrize("step", [0.0, 2.1 / 2**7])
def test_thd_with_noise_and_its_uncertainty_are_the_same_in_any_unit(step: float) -> None:
    turned = np.arange(8050) / 200.7
    samples = np.cos(2 * np.pi * turned)
    if step:
        samples = np.round(samples / step) * step
    else:
        samples += 0.05 * np.cos(4 * np.pi * turned) + 0.03 * np.cos(12.1 * np.pi * turned)
        samples += 1e-3 * np.random.default_rng(5).standard_normal(len(samples))
    one, other = with_noise(samples), with_noise(4.0 * samples)
    assert one.uncertainty is not None
    assert other.uncertainty is not None
    assert other.value == pytest.approx(one.value, rel=1e-6)
    for own, same in zip(one.uncertainty.budget, other.uncertainty.budget, strict=True):
        assert same.name == own.name
        assert same.standard == pytest.approx(own.standard, rel=1e-4)


@pytest.mark.parametrize("deviation_rad", [2.5e-3, *at_length(0.5e-3, 1e-3)])
def test_a_phase_that_wanders_too_little_to_be_followed_is_no_noise(deviation_rad: float) -> None:
    """Its sidebands have up to half of the power of all harmonics."""
    turned, errors = np.arange(round(200 * 60.3)) / 200.0, []
    truth = math.hypot(0.3, 100.0 * math.sqrt(2.0 * 0.9) * 1e-3)
    for seed in range(8):
        random = np.random.default_rng(seed)
        phase = 2 * np.pi * turned + deviation_rad * np.sin(
            2 * np.pi * turned / 23.0 + random.uniform(0, 6.28)
        )
        signal = np.cos(phase) + 0.003 * np.cos(5.0 * phase + random.uniform(0, 6.28))
        found = with_noise(signal + 1e-3 * random.standard_normal(len(turned)))
        assert found.uncertainty is not None
        assert found.uncertainty.standard < 0.02 * truth
        errors.append((found.value - truth) / found.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.5


def test_a_line_that_a_record_has_few_cycles_of_is_uncertain_by_where_in_them_it_begins() -> None:
    """Its mean square over the record is another with each phase, and part of it is in the bin of dc."""
    turned, errors = np.arange(round(200 * 20.3)) / 200.0, []
    truth = math.hypot(3.0, 2.0, 4.0, 100.0 * math.sqrt(2.0 * 0.9) * 2e-3)
    for seed in range(9):
        random = np.random.default_rng(seed)
        slow = 0.04 * np.cos(2 * np.pi * turned * random.uniform(0.14, 0.18) + random.uniform(0, 6.28))
        signal = np.cos(2 * np.pi * turned) + 0.02 * np.cos(14 * np.pi * turned)
        signal += 0.03 * np.cos(10 * np.pi * turned + random.uniform(0, 6.28))
        found = with_noise(signal + slow + 2e-3 * random.standard_normal(len(turned)))
        assert found.uncertainty is not None
        errors.append((found.value - truth) / found.uncertainty.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.5


def test_a_line_beside_a_fundamental_of_steady_frequency_moves_no_other_harmonic() -> None:
    """It pulls at the first fit of the frequency, and by that moves the phase of all harmonics."""
    turned, errors = np.arange(round(200 * 30.0)) / 200.0, []
    for bins in (1.2, 1.45, 1.6):
        for seed in range(2):
            random = np.random.default_rng(seed)
            beside = np.cos(2 * np.pi * turned * (1.0 + bins / 30.0) + random.uniform(0.0, 6.28))
            signal = np.cos(2 * np.pi * turned) + 0.02 * np.cos(10 * np.pi * turned) + 0.03 * beside
            signal += 0.03 * np.cos(14 * np.pi * turned) + 2e-3 * random.standard_normal(len(turned))
            found = with_noise(signal)
            truth = 100.0 * math.hypot(0.02, 0.03, 0.03, math.sqrt(2.0) * 2e-3)
            assert found.uncertainty is not None
            assert found.uncertainty.standard < 0.02 * truth
            errors.append((found.value - truth) / found.uncertainty.standard)
    assert np.max(np.abs(errors)) < 4.0


def test_what_is_beyond_the_band_is_no_scatter_of_the_power_within() -> None:
    """A ripple near half of the sample rate, which the resampling folds: it beats against the periods."""
    rows = np.arange(round(5.4 * 100.13))
    turned, found = rows / 100.13, []
    for seed in range(8):
        random = np.random.default_rng(seed)
        signal = np.cos(2 * np.pi * turned) + 0.02 * np.cos(10 * np.pi * turned)
        signal += 0.01 * random.standard_normal(len(rows))
        signal += 0.3 * np.cos(2 * np.pi * 0.4975 * rows + random.uniform(0.0, 6.28))
        found.append(with_noise(signal))
    stated = [each.uncertainty.standard for each in found if each.uncertainty is not None]
    assert len(stated) == 8
    assert np.max(stated) < 6.0 * np.std([each.value for each in found])


def test_thd_with_noise_of_few_periods_is_told_by_the_noise_of_harmonics_too() -> None:
    """Four periods scatter with three degrees of freedom, and the bins beside the harmonics have more."""
    turned, truth = np.arange(round(400 * 4.2)) / 400.0, 100.0 * math.hypot(0.03, 0.02)
    errors, stated = [], []
    for seed in range(16):
        random = np.random.default_rng(seed)
        begin = random.uniform(0.0, 2.0 * np.pi, 3)
        lines = ((1, 1.0), (5, 0.03), (7, 0.02))
        signal = sum(a * np.cos(2 * np.pi * k * turned + b) for (k, a), b in zip(lines, begin, strict=True))
        found = with_noise(np.asarray(signal + 1e-3 * random.standard_normal(len(turned))))
        assert found.uncertainty is not None
        errors.append((found.value - truth) / found.uncertainty.standard)
        stated.append(found.uncertainty.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.4
    assert np.median(stated) < 4.6e-3  # 5.5e-3 by the scatter of four periods alone
    assert max(stated) < 9e-3  # 11.5e-3
