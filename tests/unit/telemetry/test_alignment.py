"""Samples of another clock on the drive's ticks, against the times at which they were really taken."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Channel, Gap
from benchtool.errors import EnvironmentFailure
from benchtool.telemetry import ArrivalStatistics, ClockFit
from benchtool.telemetry.alignment import Sampling, align, frame_numbers

CHANNEL = Channel("torque_transducer", "Nm")
TICK_S = 1e-4


def _clock(offset_s: float = 100.0, drift_ppm: float = 0.0, jitter_s: float = 0.0, seed: int = 0) -> ClockFit:
    """The fit of a drive's records, 100 a second, whose ways vary by `jitter_s` rms."""
    random = np.random.default_rng(seed)
    arrivals = ArrivalStatistics(TICK_S)
    for tick in range(5000, 25000, 100):
        true_s = offset_s + (1.0 + drift_ppm * 1e-6) * tick * TICK_S
        arrivals.add(tick, true_s + jitter_s * random.standard_normal())
    fit = arrivals.fit()
    assert fit is not None
    return fit


def test_samples_stand_where_they_were_taken() -> None:
    """The torque is drive time itself, so that each sample says when it was taken."""
    sampling = Sampling(frame_rate_Hz=500.0, samples=4, delay_s=0.003)
    clock = _clock(offset_s=40.0, drift_ppm=80.0)
    taken_s = 0.7 + np.arange(800) / 2000.0  # on the drive's clock
    stamps_s = 40.0 + (1.0 + 80e-6) * taken_s[3::4] + 0.003
    numbers = frame_numbers(stamps_s, 500.0, None, 0)
    block, alignment = align(CHANNEL, stamps_s, taken_s.reshape(-1, 4), numbers, sampling, clock)
    times_s = block.ticks() * block.tick_s
    assert np.max(np.abs(times_s - block.data[:, 0])) < 1e-6  # 80 ppm of the delay, and the rounding
    assert block.alignment_s == alignment.standard_s < 1e-6
    assert block.sample_rate_Hz == pytest.approx(2000.0, rel=1e-9)
    assert (alignment.frames, alignment.missing_frames, block.gaps) == (200, 0, ())


@pytest.mark.parametrize("jitter_s", [1e-5, 1e-4])
def test_the_stated_uncertainty_is_no_less_than_the_errors(jitter_s: float) -> None:
    """Over many benches, with jitter on both ways and a delay that is known within its limits only."""
    errors, stated = [], []
    for seed in range(60):
        random = np.random.default_rng(1000 + seed)
        limit_s = 2.0 * jitter_s
        late_s = 0.001 + random.uniform(-limit_s, limit_s)
        taken_s = 0.7 + np.arange(400) / 1000.0
        stamps_s = 100.0 + taken_s + late_s + jitter_s * random.standard_normal(400)
        sampling = Sampling(1000.0, delay_s=0.001, delay_limit_s=limit_s)
        numbers = np.arange(400)
        block, alignment = align(
            CHANNEL, stamps_s, taken_s[:, None], numbers, sampling, _clock(jitter_s=jitter_s, seed=seed)
        )
        errors.append(float(np.mean(block.ticks() * block.tick_s - block.data[:, 0])))
        stated.append(alignment.standard_s)
    assert np.sqrt(np.mean(np.square(errors))) <= np.mean(stated)
    assert np.mean(np.abs(errors) <= 2.0 * np.array(stated)) >= 0.95
    assert np.mean(stated) < 4.0 * np.sqrt(np.mean(np.square(errors))), "and says something"


@given(
    lost=st.sets(st.integers(1, 198), max_size=20),
    wrap=st.sampled_from([16, 256, 65536]),
    first=st.integers(0, 65535),
)
def test_lost_frames_are_found_with_and_without_a_counter(lost: set[int], wrap: int, first: int) -> None:
    true = np.array([number for number in range(200) if number not in lost])
    stamps_s = true / 1000.0
    assert (frame_numbers(stamps_s, 1000.0, None, 0) == true).all()
    assert (frame_numbers(stamps_s, 1000.0, (true + first) % wrap, wrap) == true).all()


def test_a_loss_longer_than_the_counter_is_found_by_the_stamps() -> None:
    true = np.concatenate((np.arange(50), np.arange(50 + 40, 120)))  # 40 are two rounds of 16 and 8
    assert (frame_numbers(true / 1000.0, 1000.0, true % 16, 16) == true).all()


def test_a_frame_that_came_twice_has_one_number() -> None:
    stamps_s = np.array([0.0, 1.0, 1.0001, 2.0, 3.0]) / 1000.0
    assert frame_numbers(stamps_s, 1000.0, np.array([7, 0, 0, 1, 2]), 8).tolist() == [0, 1, 1, 2, 3]


def test_a_counter_that_restarts_is_refused() -> None:
    counts = np.concatenate((np.arange(200, 250), np.arange(50)))
    with pytest.raises(
        EnvironmentFailure, match="went from 249 to 0 of 65536 values while 1 frames were due"
    ):
        frame_numbers(np.arange(100) / 1000.0, 1000.0, counts, 65536)


@pytest.mark.parametrize("wrap", [0, 16, 256])
def test_frames_that_were_late_in_a_bunch_are_none_lost(wrap: int) -> None:
    true = np.arange(300)
    stamps_s = np.asarray(true / 1000.0, dtype=np.float64)
    stamps_s[100:110] = stamps_s[110]
    counts = true % wrap if wrap else None
    assert (frame_numbers(stamps_s, 1000.0, counts, wrap) == true).all()


def test_a_slow_clock_of_the_instrument_makes_no_loss() -> None:
    """200 ppm over 20000 frames are four periods."""
    stamps_s = np.linspace(0.0, 19.999 * (1.0 + 200e-6), 20000)
    assert (frame_numbers(stamps_s, 1000.0, None, 0) == np.arange(20000)).all()


def test_a_lost_frame_is_a_gap_of_all_its_samples() -> None:
    numbers = np.array([0, 1, 2, 4, 5, 8])
    stamps_s = 100.5 + numbers / 500.0
    block, alignment = align(CHANNEL, stamps_s, np.zeros((6, 2)), numbers, Sampling(500.0, 2), _clock())
    assert block.gaps == (Gap(6, 2), Gap(10, 4))
    assert alignment.missing_frames == 3


@pytest.mark.parametrize(("rate_Hz", "frames"), [(1000.0, 2), (980.0, 200), (2000.0, 200)])
def test_what_does_not_sample_as_stated_is_refused(rate_Hz: float, frames: int) -> None:
    numbers = np.arange(frames)
    with pytest.raises(EnvironmentFailure, match="torque_transducer"):
        align(
            CHANNEL,
            100.5 + numbers / 1000.0,
            np.zeros((frames, 1)),
            numbers,
            Sampling(rate_Hz),
            _clock(),
        )
