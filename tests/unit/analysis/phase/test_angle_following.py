"""What an angle does in every electrical period: of the rotor, or of its sensor."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import spectrum_of
from benchtool.analysis.periods import track_angle
from benchtool.analysis.phase.angle_following import along_angle, within_periods
from benchtool.analysis.phase.phase_following import follow
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ, SAMPLES = 10_000.0, 20_000
T = np.arange(SAMPLES) / RATE_HZ
STEADY = 2.0 * np.pi * 38.3 * T + 0.7


def current_of(phase: Array, fifth: float = 0.04) -> Array:
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(phase))
    return np.asarray(np.cos(phase) + fifth * np.cos(5.0 * phase + 1.0) + noise)


def amplitudes(samples: Array, angle: Array) -> tuple[Array, Array]:
    coherent, _, seen = follow(samples, RATE_HZ, track_angle(angle, 1))
    spectrum = spectrum_of(coherent)
    return spectrum.amplitude[:: spectrum.periods], seen.of_angle


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize(("is_of_rotor", "within"), [(False, 1e-4), (True, 6e-4)])
def test_a_rotor_that_swings_in_every_period_is_followed_and_the_error_of_a_resolver_is_not(
    order: int, *, is_of_rotor: bool, within: float
) -> None:
    angle = STEADY + 0.01 * np.sin(order * STEADY + 0.3)
    found, doubt = amplitudes(current_of(angle if is_of_rotor else STEADY), angle)
    assert found[[1, 2, 3, 5, 6]] == pytest.approx([1.0, 0.0, 0.0, 0.04, 0.0], abs=within)
    assert len(doubt) == 0


def test_the_share_is_one_or_none_beyond_the_harmonics_of_the_current() -> None:
    change = np.array([0.0, 0.01, 0.02j, 0.005], dtype=np.complex128)
    own = np.array([1.0, 1e-4, 1e-4j, 0.1], dtype=np.complex128)
    assert within_periods(own + change, own).are_of_rotor
    assert not within_periods(own, own - change).are_of_rotor
    assert len(within_periods(own, own).standard) == 0
    hidden = np.array([1.0, 0.1, 0.1j, 0.1], dtype=np.complex128)
    found = within_periods(hidden + 0.02, hidden)
    assert found.standard == pytest.approx(np.abs(np.abs(hidden + 0.02) - np.abs(hidden)) / np.sqrt(2.0))


def test_the_frequency_does_not_take_the_part_of_a_period_that_is_left_over_for_speed() -> None:
    phase = 2.0 * np.pi * 38.3 * (T + 0.01 * T**2)
    track = track_angle(phase + 0.01 * np.sin(phase + 0.4), 1)
    assert 2.0 * np.pi * track.periods == pytest.approx(phase[-1] - phase[0], abs=5e-6)
    assert track.residual_rad == pytest.approx(0.01 / np.sqrt(2.0), rel=0.02)


def test_a_slip_does_not_hide_that_a_wobble_is_the_encoders() -> None:
    # once in four periods, which no harmonic tells, and far less than what the slip does to the phase
    angle = 1.0004 * STEADY + 0.016 * np.sin(0.25 * STEADY + 0.3)
    found, doubt = amplitudes(current_of(STEADY), angle)
    assert found[[1, 5]] == pytest.approx([1.0, 0.04], abs=1e-4)
    assert len(doubt) == 0 or float(np.max(doubt)) < 1e-5


@pytest.mark.parametrize("seed", range(4))
def test_a_dc_that_decays_does_not_hide_that_a_wobble_is_the_encoders(seed: int) -> None:
    """Thrice in a revolution of four periods."""
    random = np.random.default_rng(seed)
    angle = STEADY + 0.0153 * np.sin(0.75 * STEADY + random.uniform(0.0, 2.0 * np.pi))
    noise = 1e-3 * random.standard_normal(SAMPLES) * (random.random(SAMPLES) < 0.2)
    samples = current_of(STEADY) + 0.08 * np.exp(-T / 0.8) + noise
    assert follow(samples, RATE_HZ, track_angle(angle, 1))[1].departure is None


@pytest.mark.parametrize("begin", [0.1, 2.6, *at_length(1.3, 4.1)])
def test_the_error_of_a_resolver_is_not_followed_where_the_rotor_swings_slowly_as_well(begin: float) -> None:
    """What a track by sixteenths of a period follows better is that swing, and not what it adds within."""
    phase = STEADY + 0.36 * np.sin(2.0 * np.pi * 0.7 * T + begin)
    found, _ = amplitudes(current_of(phase), phase + 7e-3 * np.sin(phase + 0.3))
    assert found[[1, 2, 3, 5]] == pytest.approx([1.0, 0.0, 0.0, 0.04], abs=2e-4)


@pytest.mark.parametrize("is_of_rotor", [True, False])
def test_high_orders_tell_whose_course_an_angle_has_where_the_lowest_are_noise(*, is_of_rotor: bool) -> None:
    """Four periods of a current that is switched at the same angles, under noise, and an angle that wanders
    otherwise in each."""
    orders = [each for each in range(5, 400) if each % 2 and each % 3]
    for seed in range(4):
        random, count = np.random.default_rng(seed), 4500
        walk = np.cumsum(np.convolve(random.standard_normal(count), np.ones(300) / 300, mode="same"))
        course = np.arange(count) / count
        walk -= np.polynomial.Polynomial.fit(course, walk, 2)(course)
        wandering = 0.01 * walk / np.std(walk)
        steady = 9.0 * np.pi * course
        phase = steady + wandering if is_of_rotor else steady
        current = np.cos(phase) + 0.2 * random.standard_normal(count)
        for order in orders:
            current += 0.03 * np.cos(order * phase + random.uniform(0.0, 2.0 * np.pi))
        _, track, _ = follow(current, 10_000.0, track_angle((steady + wandering) / 4.0, 4))
        assert (track.departure is not None) is is_of_rotor


@pytest.mark.parametrize("swing_rad", [0.007, 0.0007])
def test_cogging_six_times_in_a_period_is_followed_to_its_size(swing_rad: float) -> None:
    """Means over a sixteenth of a period have a fifth less of it, and sidebands are left on harmonics 5 and
    7; below two milliradians it was not followed at all."""
    steady = 2.0 * np.pi * 4.1 * T + 0.7
    angle = steady + swing_rad * np.sin(6.0 * steady + 0.3)
    counted = np.floor(angle / (2.0 * np.pi / 4096)) * (2.0 * np.pi / 4096)
    found, _ = amplitudes(current_of(angle), counted)
    assert found[[1, 5, 7]] == pytest.approx([1.0, 0.04, 0.0], abs=1e-4)


@pytest.mark.parametrize("swing_rad", [0.0, 0.02])
def test_the_noise_of_an_angle_is_not_followed_and_its_swing_is_to_the_end(swing_rad: float) -> None:
    """Of 12.4 periods, means over sixteenths had 4 mrad of noise, and the rest behind the last whole part was
    up to 0.07 rad off."""
    ends_rad: list[float] = []
    inner_rad: list[float] = []
    for seed in range(12):
        random, place = np.random.default_rng(seed), np.linspace(0.0, 1.0, 3853)
        theta_e = 2.0 * np.pi * (12.4 * place + random.uniform())
        theta_e += swing_rad * np.sin(2.0 * np.pi * (4.6 * place + random.uniform()))
        track = track_angle(theta_e / 4 + 5e-3 * random.standard_normal(len(place)), 4)
        tracks = along_angle(track, track.samples / track.periods)
        followed = tracks.within or tracks.of_periods or track
        off_rad = followed.at(np.arange(float(len(place)))) - theta_e
        inner_rad.append(float(np.std(off_rad[300:-300])))
        ends_rad.extend((off_rad - np.mean(off_rad))[[0, -1]])
    assert np.mean(inner_rad) < 3e-3
    assert np.max(np.abs(ends_rad)) < 0.03
