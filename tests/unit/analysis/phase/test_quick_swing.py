"""Swings of load and speed within few periods: the phase within these, and the frequency of the record."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import current_spectrum, track_angle
from benchtool.analysis.coherent.spectrum import coherent_samples
from benchtool.analysis.periods import track_tone
from benchtool.analysis.phase.quick_swing import quick_swing
from benchtool.block import Block

Floats = NDArray[np.float64]
RATE_HZ, COUNT = 10_000.0, 10_000
ALONE = np.array([1.0])


def compressor(random: np.random.Generator, harmonics: float = 0.04) -> tuple[Floats, Floats, Floats]:
    """Return a current, the rotor angle and the phase of the current, that of a load once in a revolution of
    three periods."""
    even = 2.0 * np.pi * random.uniform(17.0, 25.0) * np.arange(COUNT) / RATE_HZ + random.uniform(0.0, 6.0)
    theta = np.asarray(even + 0.01 * np.sin(even + random.uniform(0.0, 6.0)), dtype=np.float64)
    phase_rad = np.asarray(3.0 * theta + 0.08 * np.cos(theta + random.uniform(0.0, 6.0)), dtype=np.float64)
    size = 1.0 + 0.3 * np.cos(theta + random.uniform(0.0, 6.0))
    current = size * (np.cos(phase_rad) + harmonics * np.cos(5.0 * phase_rad + 1.0))
    return current + 2e-3 * random.standard_normal(COUNT), theta, phase_rad


def test_an_amplitude_that_swings_makes_no_phase_and_takes_none_away() -> None:
    current, _, phase_rad = compressor(np.random.default_rng(1), harmonics=0.0)
    track = track_tone(current)
    swing = quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, ALONE)
    assert swing is not None
    sought_rad = np.interp(swing.rows, np.arange(COUNT), phase_rad) - track.at(swing.rows)
    off_rad, off_means_rad = (
        np.std(np.unwrap(np.angle(each)) - sought_rad) for each in (swing.phasor, swing.mean)
    )
    assert off_rad < 1.5e-3
    assert off_means_rad > 10.0 * off_rad


def test_what_noise_does_is_no_swing() -> None:
    random = np.random.default_rng(2)
    current = np.cos(2.0 * np.pi * 61.3 / RATE_HZ * np.arange(COUNT)) + 0.05 * random.standard_normal(COUNT)
    track = track_tone(current)
    swing = quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, ALONE)
    assert swing is not None
    assert swing.turned(track, 0.0, 0.0) is None


def test_few_periods_tell_no_swing() -> None:
    current = np.cos(2.0 * np.pi * 61.3 / RATE_HZ * np.arange(1300))
    track = track_tone(current)
    assert quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, ALONE) is None


@pytest.mark.parametrize("has_angle", [True, False])
def test_the_frequency_is_that_of_the_phase_at_both_ends(*, has_angle: bool) -> None:
    """By means over periods it was off by up to 60 mrad, or the phase was said to jump."""
    random, errors, stated_rad = np.random.default_rng(3), [], []
    for _ in range(3):
        current, theta, phase_rad = compressor(random)
        step_rad = 2.0 * np.pi / 4096
        angle = np.mod(np.floor(theta / step_rad) * step_rad, 2.0 * np.pi)
        track = track_angle(angle, 3) if has_angle else track_tone(current)
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track).measurements[0]
        assert found.uncertainty is not None
        to_rad = 2.0 * math.pi * (COUNT - 1) / RATE_HZ
        truth_rad = float(phase_rad[-1] - phase_rad[0])
        errors.append((to_rad * found.value - truth_rad) / (to_rad * found.uncertainty.standard))
        stated_rad.append(to_rad * found.uncertainty.standard)
    assert math.sqrt(float(np.mean(np.square(errors)))) < 1.6
    assert np.median(stated_rad) < 8e-3


def of_load(
    seed: int, pole_pairs: int, seconds: float, *, swing: float = 0.02, load_rad: float = 0.04, times: int = 1
) -> tuple[Floats, Floats, Floats]:
    """Return a current, the rotor angle and the phase of the current, of a load that pulses so often in a
    revolution of so many periods."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE_HZ)
    even = 2.0 * np.pi * random.uniform(17.0, 25.0) * np.arange(count) / RATE_HZ + random.uniform(0.0, 6.0)
    theta = np.asarray(even + swing / times * np.sin(times * even + random.uniform(0.0, 6.0)))
    phase_rad = np.asarray(pole_pairs * theta + load_rad * np.cos(times * theta + random.uniform(0.0, 6.0)))
    size = 1.0 + 0.3 * np.cos(times * theta + random.uniform(0.0, 6.0))
    current = size * (np.cos(phase_rad) + 0.04 * np.cos(5.0 * phase_rad + 1.0))
    return current + 2e-3 * random.standard_normal(count), theta, phase_rad


@pytest.mark.parametrize(
    ("pole_pairs", "times", "seconds", "seeds"),
    [(3, 2, 1.0, (0, 3)), (2, 1, 0.5, (1, 3, 6)), (3, 1, 0.35, (1, 6))],
)
def test_sidebands_of_any_swing_are_in_the_frequency(
    pole_pairs: int, times: int, seconds: float, seeds: tuple[int, ...]
) -> None:
    """Sidebands that no harmonic repeats on both sides were none, and of few periods none were: the frequency
    was up to four hundred standard uncertainties off."""
    for seed in seeds:
        current, _, phase_rad = of_load(seed, pole_pairs, seconds, times=times)
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_tone(current)).measurements[0]
        assert found.uncertainty is not None
        truth_Hz = float(phase_rad[-1] - phase_rad[0]) / (2.0 * math.pi * (len(current) - 1) / RATE_HZ)
        assert abs(found.value - truth_Hz) < 2.6 * found.uncertainty.standard


@pytest.mark.parametrize(
    ("seed", "pole_pairs", "times", "seconds", "load_rad"), [(4, 3, 3, 2.0, 0.02), (9, 2, 1, 1.0, 0.08)]
)
def test_distortion_beside_a_fast_swing_is_along_the_rotor(
    seed: int, pole_pairs: int, times: int, seconds: float, load_rad: float
) -> None:
    """An angle's own noise was taken for an error of it, and sidebands that lie by chance nearer to a steady
    rise as well: 680 and 6 standard uncertainties."""
    current, theta, _ = of_load(seed, pole_pairs, seconds, swing=0.05, load_rad=load_rad, times=times)
    step_rad = 2.0 * np.pi / 4096
    track = track_angle(np.mod(np.floor(theta / step_rad) * step_rad, 2.0 * np.pi), pole_pairs)
    found = current_spectrum(Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current), "i_a", track)
    measured = next(each for each in found.measurements if each.name == "current_thd_f")
    # of whole revolutions at equal steps of the angle
    turned = theta / (2.0 * np.pi)
    whole = np.floor(turned[-1] - turned[0])
    steps = turned[0] + whole * np.arange(1 << 16) / (1 << 16)
    lines = np.abs(np.fft.rfft(np.interp(steps, turned, current)))[:: round(whole) * pole_pairs][1:51]
    truth = 100.0 * float(np.linalg.norm(lines[1:]) / lines[0])
    assert measured.uncertainty is not None
    assert abs(measured.value - truth) < 2.0 * measured.uncertainty.standard


def test_the_phase_within_periods_counts_where_it_is_surer() -> None:
    """A line that is no sideband puts it off, by which it was taken for surer."""
    current, _, _ = compressor(np.random.default_rng(1))
    track = track_tone(current)
    swing = quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, ALONE)
    assert swing is not None
    assert swing.turned(track, 1e-3, 0.0) is not None  # means are off it
    assert swing.turned(track, 0.5, 0.0) is not None
    assert swing.turned(track, 1e-3, 0.5) is None
    assert swing.turned(track, 0.5, 0.6) is None


def drifting(start_rad: float, harmonic: int, amplitude: float) -> tuple[Floats, Floats]:
    """Return a current of 100.3 periods whose speed drifts by 0.5 %, with a harmonic, and its phase."""
    turned = np.linspace(0.0, 1.0, COUNT)
    phase_rad = np.asarray(2.0 * np.pi * 100.3 * (turned + 0.0025 * (turned**2 - turned)) + start_rad)
    return np.cos(phase_rad) + amplitude * np.cos(harmonic * phase_rad + 1.3), phase_rad


def test_a_slow_drift_leaves_no_image_at_the_ends() -> None:
    """Weights that were as wrong at no swing as at the fastest left 0.5 mrad of it."""
    for start_rad in (0.3, 0.9, 1.7):
        current, phase_rad = drifting(start_rad, 5, 0.0)
        track = track_tone(current)
        swing = quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, ALONE)
        assert swing is not None
        off_rad = np.unwrap(np.angle(swing.phasor)) + track.at(swing.rows)
        off_rad -= np.interp(swing.rows, np.arange(COUNT), phase_rad)
        assert np.ptp(off_rad) < 1e-4


@pytest.mark.parametrize(("harmonic", "least"), [(2, 0.25), (5, 0.7)])
def test_what_harmonics_leave_of_a_drift_is_in_the_uncertainty(harmonic: int, least: float) -> None:
    """It was stated as of a swing within a period: four times too large."""
    relative = []
    for start_rad in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False):
        current, phase_rad = drifting(start_rad, harmonic, 0.03)
        track = track_tone(current)
        harmonics = np.array([1.0, *np.zeros(harmonic - 2), 0.03])
        swing = quick_swing(coherent_samples(current, RATE_HZ, track, every=True), track, harmonics)
        assert swing is not None
        turned = swing.turned(track, 1.0, 0.0)
        assert turned is not None
        relative.append((turned.phase_rad - float(phase_rad[-1] - phase_rad[0])) / turned.standard)
    assert least < math.sqrt(float(np.mean(np.square(relative)))) < 1.4


@pytest.mark.parametrize("periods", [24.3, 30.3])
def test_a_drift_over_few_periods_is_no_swing(periods: float) -> None:
    """Of 6 % the frequency leaves that of the track most at both ends, where the phase within periods would
    be foreseen: it had twenty times the uncertainty, and three times that for an error."""
    rate_Hz, f_Hz = 8000.0, 60.0
    rows = round(periods / f_Hz * rate_Hz)
    t = (np.arange(rows) - 0.5 * (rows - 1)) / rate_Hz
    phase_rad = 2.0 * np.pi * f_Hz * t * (1.0 + 0.03 * t * f_Hz / periods) + 1.0
    wave = np.cos(phase_rad) + 0.03 * np.cos(5.0 * phase_rad + 2.0)
    wave += 4e-4 * np.random.default_rng(0).standard_normal(rows)
    frequency, *_ = current_spectrum(
        Block.from_arrays(rate_Hz, {"i_a": "A"}, i_a=wave), "i_a", track_tone(wave)
    ).measurements
    assert frequency.uncertainty is not None
    assert abs(frequency.value - f_Hz) < 3.0 * frequency.uncertainty.standard < 3e-4


@pytest.mark.parametrize("seed", range(3))
def test_a_dc_that_decays_within_few_periods_is_no_swing(seed: int) -> None:
    """A mean over a period keeps what it falls by in that over 2 pi: the frequency was up to seven
    uncertainties off."""
    random = np.random.default_rng(seed)
    f_Hz, periods = 17.63, 41.1
    t = (np.arange(round(periods / f_Hz * RATE_HZ)) / RATE_HZ) * f_Hz / periods  # of the record
    phase_rad = 2.0 * np.pi * periods * (t - 0.01 * t * (t - 1.0)) + random.uniform(0.0, 6.0)
    wave = np.cos(phase_rad) + 0.03 * np.cos(5.0 * phase_rad + 2.0) + 0.56 * np.exp(-t / 0.26)
    wave += 8e-4 * random.standard_normal(len(t))
    found = current_spectrum(Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=wave), "i_a", track_tone(wave))
    frequency = found.measurements[0]
    truth_Hz = (phase_rad[-1] - phase_rad[0]) / (2.0 * np.pi) * RATE_HZ / (len(t) - 1)
    assert frequency.uncertainty is not None
    assert abs(frequency.value - truth_Hz) < 2.5 * frequency.uncertainty.standard < 1e-3
