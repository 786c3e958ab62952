"""Mean frequency by an angle in counts and by the signal at once."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import current_spectrum, track_angle, track_tone
from benchtool.analysis.phase.turned_angle import turned_by_angle
from benchtool.analysis.phase.turned_phase import Turned
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.spectra.separation import separate
from benchtool.analysis.uncertainty import Contribution
from benchtool.block import Block

RATE_HZ, COUNTS, POLE_PAIRS = 10_000.0, 1000, 4


def test_counts_that_repeat_all_over_the_record_leave_the_frequency_to_the_signal() -> None:
    # half a count a row but for a hundred thousandth: two places of a count are all that the rows see
    random, ratios = np.random.default_rng(81), []
    for _ in range(20):
        f_Hz = 20.0 * (1.0 + 1e-5 * random.standard_normal())
        theta = 2 * np.pi * (f_Hz * np.arange(10_000) / RATE_HZ + random.uniform())
        current = np.cos(theta) + 0.03 * np.cos(5 * theta) + 1e-3 * random.standard_normal(len(theta))
        count = 2 * np.pi / COUNTS
        angle = np.floor(np.mod(theta / POLE_PAIRS, 2 * np.pi) / count) * count
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_angle(angle, POLE_PAIRS)).measurements[0]
        assert found.uncertainty is not None
        assert found.uncertainty.standard < 1e-4  # Hz; the counts alone tell 1.5e-3
        ratios.append((found.value - f_Hz) / found.uncertainty.standard)
    assert 0.7 < math.sqrt(float(np.mean(np.square(ratios)))) < 1.4


@pytest.mark.parametrize("f_Hz", [111.1039, 111.1165])
@pytest.mark.parametrize("rows", [430, 860])
def test_two_counts_in_every_row_tell_the_speed_to_a_count(rows: int, f_Hz: float) -> None:
    """No row shows that they are not quite two; the angle is as even as a computed one."""
    theta = 2 * np.pi * f_Hz * np.arange(rows) / RATE_HZ + 1.0
    count = 2 * np.pi / 720
    angle = np.floor(np.mod(theta / POLE_PAIRS, 2 * np.pi) / count) * count
    current = np.cos(theta) + 1e-2 * np.random.default_rng(1).standard_normal(rows)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(angle, POLE_PAIRS)).measurements[0]
    assert found.uncertainty is not None
    assert abs(found.value - f_Hz) < 3.0 * found.uncertainty.standard < 0.5


def test_an_encoder_that_errs_once_a_revolution_does_not_hide_the_phase_of_the_signal() -> None:
    random, ratios = np.random.default_rng(82), []
    place = np.arange(12_000) / 12_000
    for _ in range(8):
        turns = 70.3 * (place + 0.01 * (place**2 - place)) + random.uniform()
        theta = 2 * np.pi * turns
        current = np.cos(theta) + 0.03 * np.cos(5 * theta) + 1e-3 * random.standard_normal(len(theta))
        read = theta / POLE_PAIRS + 1e-3 * np.sin(theta / POLE_PAIRS + random.uniform(0, 2 * np.pi))
        count = 2 * np.pi / 4096
        angle = np.floor(np.mod(read, 2 * np.pi) / count) * count
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_angle(angle, POLE_PAIRS)).measurements[0]
        true_Hz = float(turns[-1] - turns[0]) / (len(turns) - 1) * RATE_HZ
        assert found.uncertainty is not None
        assert found.uncertainty.standard < 1e-4  # Hz; half of what the encoder errs is some 3e-4
        ratios.append((found.value - true_Hz) / found.uncertainty.standard)
    assert 0.5 < math.sqrt(float(np.mean(np.square(ratios)))) < 1.5


def test_an_encoder_that_errs_over_a_part_of_a_revolution_is_no_swing_within_periods() -> None:
    """What it errs by in one period is nearly a straight line, whose bend is alike in many."""
    random, pole_pairs, place = np.random.default_rng(83), 18, np.arange(3000) / 3000
    for _ in range(4):
        theta = 2 * np.pi * 0.85 * pole_pairs * (place + 5e-3 * (place**2 - place) + random.uniform())
        current = np.cos(theta) + 0.03 * np.cos(5 * theta) + 2e-4 * random.standard_normal(len(theta))
        read = theta / pole_pairs + 5e-3 * np.sin(theta / pole_pairs + random.uniform(0, 2 * np.pi))
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_angle(np.mod(read, 2 * np.pi), pole_pairs)).measurements[
            0
        ]
        assert found.uncertainty is not None
        true_Hz = float(theta[-1] - theta[0]) / (2 * np.pi) / (len(theta) - 1) * RATE_HZ
        assert abs(found.value - true_Hz) < 4.0 * found.uncertainty.standard < 0.02


@pytest.mark.parametrize("periods", [2.2, 2.5])
def test_a_swing_within_few_periods_of_a_part_of_a_revolution_leaves_no_frequency(periods: float) -> None:
    theta = 2 * np.pi * periods * np.arange(2000) / 2000
    noise = 1e-4 * np.random.default_rng(84).standard_normal(len(theta))
    swinging = theta + 7e-3 * np.cos(3 * theta) + noise
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=np.cos(swinging) + 0.03 * np.cos(5 * swinging))
    angle = np.mod(swinging / 7, 2 * np.pi)
    found = current_spectrum(block, "i_a", track_angle(angle, 7)).measurements[0]
    assert math.isnan(found.value)
    assert "revolutions" in found.reason


@pytest.mark.parametrize(("apart", "value", "standard"), [(1.0, 0.9, math.sqrt(0.9)), (20.0, 0.0, 3.0)])
def test_phases_that_agree_are_weighted_by_their_variances(
    apart: float, value: float, standard: float
) -> None:
    one, other = (
        Turned(phase, (Contribution(name, "B", size),), name)
        for phase, name, size in ((0.0, "counts", 3.0), (apart, "signal", 1.0))
    )
    both = one.with_other(other)
    assert (both.phase_rad, both.standard) == pytest.approx((value, standard))


@pytest.mark.parametrize("lines", [1000, 4096, 16_384])
@pytest.mark.parametrize("swing", [0.0, 0.02])
def test_an_encoder_that_is_wrapped_by_a_computation_counts_in_its_steps(lines: int, swing: float) -> None:
    """Its levels differ from turn to turn by rounding, of which any difference is a whole multiple."""
    random, step = np.random.default_rng(83), 2 * np.pi / lines
    for _ in range(5):
        speed = random.uniform(8.0, 20.0) * (1.0 + swing * random.standard_normal(10_000))
        angle = random.uniform(0.0, 2 * np.pi) + np.cumsum(2 * np.pi * speed / RATE_HZ)
        read = np.floor(angle / step) * step % (2 * np.pi)
        assert track_angle(read, POLE_PAIRS).resolution_rad == pytest.approx(POLE_PAIRS * step, rel=1e-6)


def test_what_the_rotor_does_within_periods_is_in_a_frequency_that_both_angle_and_current_tell() -> None:
    """Three times a revolution of two periods, by 4 mrad, under a load that goes with it."""
    relative = []
    for seed in range(8):
        random = np.random.default_rng(seed)
        turns = (20.0 + random.uniform(0.5, 3.5)) * np.arange(3600) / 3599
        rotor = np.pi * turns + random.uniform(0.0, 2.0 * np.pi)
        rotor += 0.002 * np.sin(3.0 * rotor + random.uniform(0.0, 2.0 * np.pi))
        load = 5.0 + 0.2 * np.cos(3.0 * rotor)
        current = load * np.cos(2.0 * rotor) + 1e-3 * random.standard_normal(len(rotor))
        count = 2.0 * np.pi / 1024
        angle = count * np.floor(rotor / count) % (2.0 * np.pi)
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_angle(angle, 2)).measurements[0]
        assert found.uncertainty is not None
        true_Hz = 2.0 * (rotor[-1] - rotor[0]) / (2.0 * np.pi * 3599 / RATE_HZ)
        relative.append((found.value - true_Hz) / found.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(relative))) < 1.5


def test_a_wandering_speed_within_few_periods_has_the_frequency_of_its_angle() -> None:
    """The rotor is followed for the harmonics; how far it turned over a revolution its angle tells."""
    errors = []
    for seed in range(6):
        random, count = np.random.default_rng(seed), 4500
        course = np.arange(count) / count
        swings = random.uniform(1.5, 2.5)
        phase = 9.0 * np.pi * course + 0.02 * np.sin(2.0 * np.pi * (swings * course + random.random()))
        current = np.cos(phase) + 0.02 * np.cos(5.0 * phase + 1.0) + 1e-3 * random.standard_normal(count)
        block = Block.from_arrays(10_000.0, {"i_a": "A"}, i_a=current)
        found = current_spectrum(block, "i_a", track_angle(phase / 4.0, 4))
        assert found.track.departure is not None
        frequency = found.measurements[0]
        assert frequency.name == "fundamental_frequency"
        assert frequency.uncertainty is not None
        true_Hz = (phase[-1] - phase[0]) / (2.0 * np.pi) * 10_000.0 / (count - 1)
        errors.append((frequency.value - true_Hz) / frequency.uncertainty.standard)
    assert np.max(np.abs(errors)) < 2.5


@pytest.mark.parametrize(("swing_Hz", "is_seen"), [(27.7, False), (1.3, True)])
def test_the_phases_of_periods_do_not_tell_what_the_rotor_does_within(swing_Hz: float, is_seen: bool) -> None:
    """A swing faster than the fundamental is in the counts alone."""
    time_s = np.arange(20_000) / RATE_HZ
    theta = 2 * np.pi * 20.0 * time_s + 0.09 * np.sin(2 * np.pi * swing_Hz * time_s)
    count = 2 * np.pi / COUNTS
    track = track_angle(np.floor(np.mod(theta / POLE_PAIRS, 2 * np.pi) / count) * count, POLE_PAIRS)
    seen = Wander(np.zeros(40), np.ones(40), 0.0, 1e-3)
    by_angle = turned_by_angle(track, seen)
    of_tone = Contribution("noise", "A", 0.1 * by_angle.standard)
    both = turned_by_angle(
        track, seen, Turned(by_angle.phase_rad + by_angle.standard, (of_tone,), "the tone")
    )
    moved = (both.phase_rad - by_angle.phase_rad) / by_angle.standard
    assert (moved > 0.9) is is_seen
    assert (moved < 0.2) is not is_seen


@pytest.mark.parametrize("noise", [1e-3, 3e-3])
def test_a_line_two_bins_beside_does_not_pull_at_the_frequency(noise: float) -> None:
    """The hum of the mains, beside a fundamental near it: the noise of a fit under a Hann window is left."""
    random, rows, ratios = np.random.default_rng(5), 6000, []
    t = np.arange(rows) / RATE_HZ
    of_fit_Hz = 7.38 * noise * math.sqrt(2.0 / rows) / (2 * np.pi * rows / RATE_HZ)
    for _ in range(16):
        f_Hz = 50.0 + random.choice([-1.0, 1.0]) * random.uniform(2.7, 3.7)
        theta = 2 * np.pi * (f_Hz * t + random.uniform())
        hum = 0.01 * np.cos(2 * np.pi * (50.0 * t + random.uniform()))
        current = np.cos(theta) + 0.03 * np.cos(5 * theta) + hum + noise * random.standard_normal(rows)
        track = separate(current, RATE_HZ, track_tone(current, "i_a"), "i_a", 0.0).track
        ratios.append((track.periods * RATE_HZ / (rows - 1) - f_Hz) / of_fit_Hz)
    assert math.sqrt(float(np.mean(np.square(ratios)))) < 1.4
