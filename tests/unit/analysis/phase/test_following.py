"""A phase that leaves its track, and what smooth curves take from their samples: closed forms."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    CoherentSpectrum,
    coherent_samples,
    coherent_spectrum,
    spectrum_of as spectrum_of_samples,
)
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.phase.mean_frequency import frequency
from benchtool.analysis.phase.phase_following import follow
from benchtool.analysis.phase.turned_angle import turned_by_angle
from benchtool.analysis.phase.wander import Wander, wander
from benchtool.analysis.responses.response_curve import ResponseCurve
from benchtool.analysis.spectra.soundness import soundness, turned_around
from benchtool.analysis.statistics.regimes import change_of_regime
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.smoothing import Noise
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ, FREQUENCY_HZ, SAMPLES = 10_000.0, 50.0, 20_000
T = np.arange(SAMPLES) / RATE_HZ
LINEAR = Polynomial([0.0, 2.0 * np.pi * FREQUENCY_HZ / RATE_HZ])
BASIS = Basis(SAMPLES, RATE_HZ, SAMPLES / RATE_HZ, 0.5 * RATE_HZ, "rectangular", gaps=0)


def spectrum_of(samples: Array) -> CoherentSpectrum:
    return coherent_spectrum(samples, RATE_HZ, PhaseTrack(LINEAR, SAMPLES, "as it was made"))


def frequency_of(track: PhaseTrack, seen: Wander) -> Measurement:
    return frequency(spectrum_of(np.cos(2.0 * np.pi * FREQUENCY_HZ * T)), track, seen, BASIS, None, "")


def still(noise_rad: float = 0.0) -> Wander:
    return Wander(np.zeros(99), np.ones(99), 0.0, noise_rad)


def none(at: Array) -> Array:
    return np.zeros_like(at)


def standard(measured: Measurement) -> float:
    assert measured.uncertainty is not None
    return measured.uncertainty.standard


def test_what_slips_against_an_angle_that_swings_is_followed_in_both() -> None:
    # faster than the phase of a period shows, so that only the angle has it
    angle = 2.0 * np.pi * FREQUENCY_HZ * T + 0.05 * np.sin(2.0 * np.pi * 31.0 * T)
    phase = angle + 0.15 * np.sin(2.0 * np.pi * 0.7 * T)
    samples = np.cos(phase) + 0.1 * np.cos(5.0 * phase)
    _, track, seen = follow(samples, RATE_HZ, track_angle(angle, 1))
    assert "measured angle" in track.source
    assert track.follows_signal
    assert float(np.std(seen.phase_rad)) < 2e-3
    left = (track.at(np.arange(SAMPLES, dtype=np.float64)) - phase)[500:-500]
    assert float(np.std(left)) < 2e-3


@pytest.mark.parametrize("counts", [1000, 1024, 360])
def test_the_steps_of_an_encoder_are_not_in_the_harmonics_of_a_speed_that_swings(counts: int) -> None:
    phase = 2.0 * np.pi * 20.3 * T + 0.07 * np.sin(2.0 * np.pi * 1.7 * T)
    samples = np.cos(phase) + 0.03 * np.cos(5.0 * phase)
    step_rad = 4 * 2.0 * np.pi / counts  # of four pole pairs
    coherent, _, seen = follow(samples, RATE_HZ, track_angle(np.floor(phase / step_rad) * step_rad, 1))
    spectrum = spectrum_of_samples(coherent)
    assert np.std(seen.phase_rad) < 2e-3
    assert spectrum.amplitude[5 * spectrum.periods] == pytest.approx(0.03, abs=3e-5)
    for order in (2, 3, 4, 6, 7, 8, 11, 13):
        assert spectrum.amplitude[order * spectrum.periods] < 3e-5, order


def test_an_encoder_that_is_wrong_twice_a_revolution_is_not_followed_within_a_swing() -> None:
    phase = 2.0 * np.pi * 20.0 * T + 0.05 * np.sin(2.0 * np.pi * 1.1 * T)
    angle = phase + 0.02 * np.sin(0.5 * phase)  # electrical, of four pole pairs
    samples = (
        np.cos(phase) + 0.03 * np.cos(5.0 * phase) + 1e-3 * np.random.default_rng(1).standard_normal(len(T))
    )
    _, track, seen = follow(samples, RATE_HZ, track_angle(angle, 1))
    left = (track.at(np.arange(SAMPLES, dtype=np.float64)) - phase)[500:-500]
    assert float(np.std(left)) < 2e-3
    assert seen.excess_rad < 2e-3


def test_the_frequency_of_the_angle_stands_beside_that_of_a_signal_that_leaves_it() -> None:
    track = PhaseTrack(
        LINEAR,
        SAMPLES,
        "angle, followed by the phase of it itself",
        0.0,
        np.asarray(LINEAR(T * RATE_HZ)),
        none,
        follows_signal=True,
    )
    told = re.search(r"the angle alone gives ([\d.]+) Hz", frequency_of(track, still()).definition)
    assert told is not None
    assert float(told[1]) == pytest.approx(FREQUENCY_HZ)


def test_a_followed_phase_that_is_straight_is_certain() -> None:
    straight = PhaseTrack(LINEAR, SAMPLES, "it itself", None, None, none, follows_signal=True)
    assert standard(frequency_of(straight, still())) < 1e-9


@pytest.mark.parametrize("periods", [9.9, *at_length(12.9)])
def test_a_steady_bend_is_followed_to_both_ends_and_only_noise_is_left(periods: float) -> None:
    random, relative = np.random.default_rng(7), []
    time = np.arange(round(periods * 100)) / round(periods * 100)
    for _ in range(16):
        phase = 2.0 * np.pi * (periods * (time + 0.03 * (time**2 - time)) + random.uniform())
        samples = np.cos(phase) + 0.03 * np.cos(5.0 * phase) + 3e-3 * random.standard_normal(len(time))
        coherent, track, seen = follow(samples, RATE_HZ, track_tone(samples))
        assert track.follows_signal
        found = frequency(spectrum_of_samples(coherent), track, seen, BASIS, None, "")
        error_Hz = found.value - (phase[-1] - phase[0]) * RATE_HZ / (2.0 * np.pi * (len(time) - 1))
        relative.append(error_Hz / standard(found))
    assert 0.7 < np.sqrt(np.mean(np.square(relative))) < 1.4


@pytest.mark.parametrize(("swing_Hz", "largest_rad"), [(3.1, 4e-3), *at_length((0.7, 5e-5), (2.0, 1e-3))])
def test_a_followed_swing_bends_on_to_both_ends_of_the_record(swing_Hz: float, largest_rad: float) -> None:
    """A natural spline is straight there, and 1.1, 6.5 and 15 mrad off."""
    errors, stated = [], []
    for begin in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False):
        phase = 2.0 * np.pi * FREQUENCY_HZ * T + 0.1 * np.sin(2.0 * np.pi * swing_Hz * T + begin)
        samples = np.cos(phase)
        coherent, track, seen = follow(samples, RATE_HZ, track_tone(samples))
        found = frequency(spectrum_of_samples(coherent), track, seen, BASIS, None, "")
        errors.append(found.value - (phase[-1] - phase[0]) * RATE_HZ / (2.0 * np.pi * (SAMPLES - 1)))
        stated.append(standard(found))
    to_rad = 2.0 * np.pi * SAMPLES / RATE_HZ
    assert to_rad * float(np.std(errors)) < largest_rad
    assert to_rad * float(np.median(stated)) < largest_rad
    relative = np.array(errors) / np.array(stated)
    assert np.sqrt(np.mean(relative**2)) < 1.4
    assert np.max(np.abs(relative)) < 2.5


def test_four_phases_that_leave_the_track_are_too_few_to_be_followed() -> None:
    time = np.arange(round(6.9 * 25)) / (6.9 * 25)
    phase = 2.0 * np.pi * 6.9 * (time + 0.05 * (time**3 - time))
    _, track, seen = follow(np.cos(phase), RATE_HZ, track_angle(2.0 * np.pi * 6.9 * time, 1))
    assert len(seen.phase_rad) == 4
    assert seen.excess_rad > 0.0
    assert track.departure is None


@pytest.mark.parametrize("with_angle", [True, False])
def test_sidebands_of_the_fundamental_alone_are_no_wander_of_the_phase(with_angle: bool) -> None:
    phase = 2.0 * np.pi * FREQUENCY_HZ * T
    samples = np.cos(phase) + 0.03 * np.cos(5.0 * phase + 0.4) + 0.02 * np.cos(7.0 * phase + 1.1)
    # more phase than amplitude modulation
    samples += 0.03 * np.sin(0.94 * phase) - 0.012 * np.sin(1.06 * phase)
    samples += 1e-4 * np.random.default_rng(3).standard_normal(len(T))
    coherent, track, _ = follow(
        samples, RATE_HZ, track_angle(phase, 1) if with_angle else track_tone(samples)
    )
    assert track.departure is None
    spectrum = spectrum_of_samples(coherent)
    for order, amplitude in ((1, 1.0), (5, 0.03), (7, 0.02)):
        assert spectrum.amplitude[order * spectrum.periods] == pytest.approx(amplitude, abs=6e-5)


def test_a_drift_beyond_a_hundred_periods_is_followed_to_the_end_of_the_record() -> None:
    """119 periods are cut to 112 for the transform, after they were followed."""
    t = np.arange(23_960) / RATE_HZ
    phase = 2.0 * np.pi * FREQUENCY_HZ * (t + 0.006 * t**2 / (2.0 * t[-1]))
    samples = np.cos(phase) + 0.03 * np.cos(5.0 * phase)
    coherent, track, seen = follow(samples, RATE_HZ, track_tone(samples))
    assert len(seen.phase_rad) == 119
    assert coherent.periods == 112
    found = frequency(spectrum_of_samples(coherent), track, seen, BASIS, None, "")
    expected = (phase[-1] - phase[0]) * RATE_HZ / (2.0 * np.pi * (len(t) - 1))
    assert abs(found.value - expected) < 1e-6


def test_along_an_angle_the_frequency_is_that_of_its_ends() -> None:
    swing = 0.05 * np.sin(2.0 * np.pi * 1.3 * FREQUENCY_HZ * T + 0.4)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(SAMPLES)
    measured = np.asarray(LINEAR(T * RATE_HZ)) + swing + noise
    track = PhaseTrack(LINEAR, SAMPLES, "angle", 0.01, measured, none)
    found = frequency_of(track, still())
    turned = float(LINEAR(SAMPLES - 1.0) - LINEAR(0.0) + swing[-1] - swing[0])
    assert found.uncertainty is not None
    assert abs(found.value - turned * RATE_HZ / (2.0 * np.pi * (SAMPLES - 1))) < found.uncertainty.expanded


def test_a_swing_slower_than_the_record_is_the_rotors_or_its_sensors() -> None:
    """It is the rotor's, unless the record has fewer than two revolutions: then it is as likely the
    sensor's, and a quadratic fit leaves it out."""
    swing = 0.08 * np.sin(2.0 * np.pi * 0.1 * T + 0.4)
    angle = np.asarray(LINEAR(T * RATE_HZ)) + swing
    per_rad_Hz = RATE_HZ / (2.0 * np.pi * (SAMPLES - 1))
    of_rotor = FREQUENCY_HZ + per_rad_Hz * (swing[-1] - swing[0])
    by_fit = Polynomial.fit(T, swing, 2)
    of_fit = FREQUENCY_HZ + per_rad_Hz * float(np.ptp(by_fit(T[[0, -1]])))
    middles = FIRST_ROW / RATE_HZ + (np.arange(99) + 0.5) / FREQUENCY_HZ
    turned = replace(still(), phase_rad=np.interp(middles, T, swing - by_fit(T)))
    found = frequency_of(track_angle(angle, 1), turned)
    assert abs(found.value - of_rotor) < 2.0 * standard(found)
    assert standard(found) < 0.1 * abs(of_fit - of_rotor)
    pole_pairs = math.ceil(FREQUENCY_HZ * T[-1])
    found = frequency_of(track_angle(angle / pole_pairs, pole_pairs), still())
    assert 0.4 < abs(found.value - of_rotor) / standard(found) < 1.0
    assert 0.4 < abs(found.value - of_fit) / standard(found) < 1.0


@pytest.mark.parametrize("kind", ["each revolution", *at_length("slowly")])
def test_an_angle_that_errs_without_noise_is_held_against_the_phase_of_the_signal(kind: str) -> None:
    """Each sample of it is exact, and so are both ends: what it does from revolution to revolution, or over
    the record, is no course of the rotor where the signal does not have it."""
    errors, pole_pairs = [], 4
    for seed in range(12):
        random = np.random.default_rng(seed)
        frequency_Hz = FREQUENCY_HZ * random.uniform(0.98, 1.02)
        theta_m = 2.0 * np.pi * frequency_Hz * T / pole_pairs
        if kind == "each revolution":
            errs = random.normal(0.0, 2e-3, 40)[np.floor(theta_m / (2.0 * np.pi)).astype(int)]
        else:
            errs = 6e-4 * np.sin(2.0 * np.pi * 0.7 * T + random.uniform(0.0, 2.0 * np.pi))
        samples = np.cos(pole_pairs * theta_m) + 1e-3 * random.standard_normal(SAMPLES)
        coherent, track, seen = follow(samples, RATE_HZ, track_angle(theta_m + errs, pole_pairs))
        found = frequency(spectrum_of_samples(coherent), track, seen, BASIS, None, "")
        errors.append((found.value - frequency_Hz) / standard(found))
    assert np.sqrt(np.mean(np.square(errors))) < 1.5
    assert np.max(np.abs(errors)) < 3.0


def test_the_resolution_of_an_angle_does_not_average_out_of_its_ends() -> None:
    measured = np.asarray(LINEAR(T * RATE_HZ))
    track = PhaseTrack(LINEAR, SAMPLES, "angle", 0.01, measured, none, resolution_rad=0.03)
    assert turned_by_angle(track, still()).standard == pytest.approx(0.03 / math.sqrt(6.0), rel=1e-3)


def test_noise_without_a_current_moves_no_phase() -> None:
    found = [wander(coherent(np.random.default_rng(seed).standard_normal(SAMPLES))) for seed in range(40)]
    assert sum(each.excess_rad == each.jump_rad == 0.0 for each in found) >= 38


@pytest.mark.parametrize("size", [0.0, 0.9])
def test_a_current_that_swings_and_turns_is_no_noise(size: float) -> None:
    turned = np.cos(2.0 * np.pi * FREQUENCY_HZ * T + 2.0 * np.sin(2.0 * np.pi * 1.3 * T))
    seen = wander(coherent((1.0 + size * np.cos(2.0 * np.pi * 0.7 * T)) * turned))
    assert seen.excess_rad > 1.0


def coherent(samples: Array) -> CoherentSamples:
    return coherent_samples(samples, RATE_HZ, PhaseTrack(LINEAR, SAMPLES, "as it was made"))


def test_a_phase_that_jumps_is_told_from_one_that_swings() -> None:
    period = np.arange(40)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(40)
    for phase, jumps in ((np.where(period < 25, 0.0, 0.8), True), (0.8 * np.sin(0.3 * period), False)):
        turn = np.repeat(phase + noise, 100)
        samples = CoherentSamples(np.cos(2.0 * np.pi * np.arange(4000) / 100 + turn), 40, 4000.0, RATE_HZ)
        seen = wander(samples)
        assert (seen.jump_rad > 0.0) == jumps
        reason = soundness(spectrum_of_samples(samples), seen, "", "i_a").of_ratios
        assert reason.startswith("the phase of i_a jumps by 0.8 rad") == jumps


@pytest.mark.parametrize(
    ("phase", "gain", "alone"),
    [
        (lambda n: 0.2 * (n >= 12) + 0.2 * (n >= 27), lambda _: 1.0, True),
        (lambda n: -0.3 * (n >= 20), lambda _: 1.0, True),
        (lambda n: 0.3 * (n >= 20), lambda n: np.where(n >= 20, 1.05, 1.0), False),  # another load
        (lambda n: np.where(n >= 20, 0.4 + 0.01 * (n - 20), 0.0), lambda _: 1.0, False),  # another speed
        (lambda n: 0.3 * (n >= 20), lambda n: np.where(n == 19, 0.6, 1.0), False),  # stood still
    ],
)
def test_a_jump_alone_names_an_encoder_that_slipped(
    phase: Callable[[Array], Array], gain: Callable[[Array], Array], alone: bool
) -> None:
    period = np.arange(40.0)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(40)
    turn = np.repeat(phase(period) + noise, 100)
    values = np.repeat(gain(period) * np.ones(40), 100) * np.cos(2.0 * np.pi * np.arange(4000) / 100 + turn)
    samples = CoherentSamples(values, 40, 4000.0, RATE_HZ)
    seen = replace(wander(samples), by_angle=True)
    assert seen.jumps_alone == alone
    reason = soundness(spectrum_of_samples(samples), seen, "", "i_a").of_ratios
    assert ("the encoder, its coupling or belt slipped" in reason) == alone


def test_a_current_that_reverses_at_its_greatest_is_told_by_its_harmonics() -> None:
    theta = 2.0 * np.pi * np.arange(4000) / 100
    for back in (theta, 2.0 * theta[2800] - theta):
        phase = np.where(np.arange(4000) < 2800, theta, back)
        values = np.cos(phase) + 0.03 * np.cos(5.0 * phase + 1.0)
        samples = CoherentSamples(values, 40, 4000.0, RATE_HZ)
        seen = wander(samples)
        assert seen.jump_rad == 0.0
        assert turned_around(samples, seen, "i_a").startswith("harmonic 5 of i_a turns") == (
            back is not theta
        )


def test_a_change_within_one_part_of_a_few_periods_is_no_noise() -> None:
    amplitude = np.array([1.0, 1.0, 1.0, 1.5, 1.5, 1.5])
    assert change_of_regime(amplitude, "the amplitude").startswith("the amplitude changes from 1 to 1.5")


@pytest.mark.parametrize(
    ("step", "noise", "flagged"),
    [(0.0, 0.2, False), (0.05, 0.01, False), (0.15, 0.01, True), (0.5, 0.2, True)],
)
def test_an_amplitude_that_changes_by_more_than_a_tenth_and_its_noise_is_no_one_regime(
    step: float, noise: float, flagged: bool
) -> None:
    amplitude = np.repeat([1.0, 1.0 + step], 50) + noise * np.random.default_rng(2).standard_normal(100)
    seen = Wander(np.zeros(100), amplitude, 0.0, noise)
    sound = soundness(spectrum_of(np.cos(2.0 * np.pi * FREQUENCY_HZ * T)), seen, "", "i_a")
    assert sound.of_amplitudes.startswith("the amplitude of i_a changes from") == flagged


@pytest.mark.parametrize("place", [-0.4, -0.1, 0.0, 0.3])
def test_the_greatest_value_of_a_parabola_may_be_between_its_samples(place: float) -> None:
    curve = NoisyCurve(3.0 - 0.2 * (np.arange(-5.0, 6.0) - place) ** 2, np.empty((0, 11)))
    greatest, missed = curve.greatest()
    assert greatest == pytest.approx(3.0)
    assert missed == pytest.approx(0.0, abs=1e-9)


def test_a_trend_is_no_noise() -> None:
    piece = np.random.default_rng(3).standard_normal(400)
    trend = 5.0 - 0.03 * np.arange(400)
    np.testing.assert_allclose(
        Noise.of(piece + trend).autocovariance, Noise.of(piece).autocovariance, atol=1e-12
    )
    assert Noise.of(piece + trend).rms == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("more", [1.0, 4.0])
def test_a_value_of_a_response_is_as_uncertain_as_its_points_scatter(more: float) -> None:
    """Also where they scatter by more than was stated of them, and few points lie near a cubic by chance."""
    random, frequency_Hz = np.random.default_rng(4), np.geomspace(10.0, 100.0, 60)
    misses, stated = [], []
    for _ in range(100):
        values = 1.0 + 0.01 * more * random.standard_normal(60)
        value, uncertain = ResponseCurve(frequency_Hz, values, np.full(60, 0.01), 0.1).at(30.0)
        misses.append((value - 1.0) / uncertain)
        stated.append(uncertain)
    assert 0.6 < float(np.sqrt(np.mean(np.square(misses)))) < 1.1
    # a level that many points share is told better than each of them
    assert more > 1.0 or float(np.median(stated)) < 0.005


@pytest.mark.parametrize("apart_Hz", [1.0, 5.0, 8.0])
def test_a_sharp_peak_between_two_frequencies_is_told_by_those_beside_it(apart_Hz: float) -> None:
    frequency_Hz = np.arange(20.0, 120.0, apart_Hz)
    for peak_Hz in 60.0 + apart_Hz * np.array([0.1, 0.4, 0.7]):
        x = frequency_Hz / peak_Hz
        response = 1.0 / (1.0 + 0.2j * x - x**2)
        truth_dB = -10.0 * math.log10(0.2**2 * (1.0 - 0.1**2))
        value, uncertain = ResponseCurve.of_gain(
            frequency_Hz, response, np.full(len(x), 1e-4), 3.0
        ).resonance()
        assert abs(value - truth_dB) < 2.0 * uncertain
        assert uncertain < 2e-3


def test_a_subharmonic_moves_the_phase_up_and_down_and_is_not_followed() -> None:
    phase = 2.0 * np.pi * FREQUENCY_HZ * T
    # in quadrature at both sides: all of it moves the phase, up in one period and down in the next
    lines = 0.02 * (np.sin(0.5 * phase) + np.sin(1.5 * phase))
    _, track, seen = follow(np.cos(phase) + lines, RATE_HZ, PhaseTrack(LINEAR, SAMPLES, "as it was made"))
    assert float(np.std(seen.phase_rad)) > 5e-3
    assert track.departure is None


def test_the_peak_of_a_resonance_is_read_off_all_frequencies_around_it() -> None:
    frequency_Hz = np.arange(5.0, 400.0, 5.0)
    square = (frequency_Hz / 123.4) ** 2
    gain_dB = -10.0 * np.log10((1.0 - square) ** 2 + 4.0 * 0.3**2 * square)
    true_dB = -10.0 * math.log10(4.0 * 0.3**2 * (1.0 - 0.3**2))
    error_dB = np.full(len(gain_dB), 0.02)
    exact = ResponseCurve(frequency_Hz, gain_dB, error_dB, 3.0)
    # less what the stated errors add to a peak that they place
    assert exact.resonance()[0] == pytest.approx(true_dB, abs=1e-4)
    noise_dB = np.random.default_rng(1).normal(0.0, 0.02, (20, len(gain_dB)))
    noisy = [ResponseCurve(frequency_Hz, gain_dB + each, error_dB, 3.0) for each in noise_dB]
    found = np.array([each.resonance() for each in noisy])
    assert float(np.sqrt(np.mean(((found[:, 0] - true_dB) / found[:, 1]) ** 2))) < 1.4
    assert float(np.max(found[:, 1])) < 0.02  # less than that of any one
    falling = ResponseCurve(frequency_Hz, -10.0 * np.log10(1.0 + square), error_dB, 3.0)
    assert falling.resonance() == falling.greatest()  # no peak


@pytest.mark.parametrize(("bend", "left"), [(0.0, 0.7), (0.003, 0.3)])
def test_noise_is_taken_off_the_greatest_value_of_a_peak_and_of_a_plateau(bend: float, left: float) -> None:
    """Noise of unit rms over five samples raises the greatest of 300 by 2.6 on a plateau."""
    random, kernel = np.random.default_rng(7), np.full(5, 1.0 / np.sqrt(5.0))

    def noise(records: int) -> NDArray[np.float64]:
        white = random.standard_normal((records, 304))
        return np.array([np.convolve(each, kernel, mode="valid") for each in white])

    shape = -bend * (np.arange(300.0) - 149.5) ** 2
    found = np.array([NoisyCurve(shape + each, noise(80)).greatest() for each in noise(60)])
    assert abs(np.mean(found[:, 0])) < left
    assert 0.7 < np.sqrt(np.mean((found[:, 0] / found[:, 1]) ** 2)) < 1.4


def test_a_track_that_a_tone_stays_on_is_kept_where_the_angle_about_it_errs() -> None:
    """A resolver that errs once a revolution: of the speed's wander the tone departs by less than 2 mrad."""
    rows, periods = np.arange(30_000, dtype=np.float64), 61.3
    place = rows / len(rows)
    for seed in range(6):
        random = np.random.default_rng(seed)
        begin = random.uniform(0, 2 * np.pi, 3)
        theta = 2 * np.pi * periods * place + begin[0] + 1.5e-3 * np.sin(2 * np.pi * 4.3 * place + begin[1])
        angle = theta / 4 + 1.4e-3 * np.sin(theta / 4 + begin[2])
        signal = np.cos(theta) + 0.03 * np.cos(5 * theta) + 1e-3 * random.standard_normal(len(rows))
        track = track_angle(angle, 4)
        coherent, followed, seen = follow(signal, 10e3, track)
        assert followed is track
        found = frequency(spectrum_of_samples(coherent), followed, seen, BASIS, None, "")
        truth = float(theta[-1] - theta[0]) / (2 * np.pi) * 10e3 / (len(rows) - 1)
        assert found.uncertainty is not None
        assert abs(found.value - truth) < 2.5 * found.uncertainty.standard
