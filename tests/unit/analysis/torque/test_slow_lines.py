"""What a torque repeats more slowly than a period is no noise of its mean, rms and extremes."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, ripple_numbers, torque_ripple, track_angle
from benchtool.analysis.torque.slow_lines import SlowLines, slow_lines
from benchtool.block import Block
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ, PER_PERIOD, POLE_PAIRS = 10e3, 211.7, 5


def measured(torque: Array) -> dict[str, Measurement]:
    theta_m = np.arange(len(torque), dtype=np.float64) * (2 * np.pi / (PER_PERIOD * POLE_PAIRS))
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    track = track_angle(theta_m, POLE_PAIRS)
    return {each.name: each for each in torque_ripple(block, track=track, pole_pairs=POLE_PAIRS)}


def record(periods: float, seed: int, *slow: tuple[float, float]) -> Array:
    """Ripple of a period, noise, and sinusoids of (cycles in a period, Nm)."""
    random = np.random.default_rng(seed)
    turned = 2 * np.pi * np.arange(round(periods * PER_PERIOD)) / PER_PERIOD
    torque = 1.5 + 0.05 * np.cos(6 * turned) + 3e-3 * random.standard_normal(len(turned))
    for cycles, size in slow:
        torque += size * np.cos(cycles * turned + random.uniform(0, 2 * np.pi))
    return np.asarray(torque)


@pytest.mark.parametrize("periods", [9.4, *at_length(30.3, 90.7)])
def test_a_part_of_a_revolution_moves_the_mean_by_what_is_stated(periods: float) -> None:
    relative, widest = [], 0.0
    for seed in range(16):
        found = measured(record(periods, seed, (1 / POLE_PAIRS, 0.03), (2 / POLE_PAIRS, 0.01)))["torque_mean"]
        assert found.uncertainty is not None, found
        relative.append((found.value - 1.5) / found.uncertainty.standard)
        widest = max(widest, found.uncertainty.standard)
    assert 0.6 < np.sqrt(np.mean(np.square(relative))) < 1.4
    assert widest < 0.03 / (2 * periods / POLE_PAIRS)  # of a cycle that is not whole, over the record


def test_lines_in_step_with_nothing_are_no_noise_of_the_rms() -> None:
    truth = np.sqrt(0.5 * (0.05**2 + 0.04**2 + 0.02**2) + 3e-3**2)
    relative = []
    for seed in range(10):
        found = measured(record(120.0, seed, (0.137, 0.04), (0.311, 0.02)))["torque_ripple_rms"]
        assert found.uncertainty is not None
        relative.append((found.value - truth) / found.uncertainty.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(relative))) < 1.4


@pytest.mark.parametrize(("per_period", "periods"), [(61.7, 20), (93.1, 50)])
def test_lines_are_as_large_as_in_the_samples(per_period: float, periods: int) -> None:
    """Blocks of 1.1 rows, and lines between rows, make one of 74 and 112 rows smaller by some 6e-4."""
    turned = np.arange(int(per_period * periods)) / per_period
    line = 0.3 * np.cos(2 * np.pi * 0.83 * turned + 0.4)
    line += 1e-3 * np.random.default_rng(1).standard_normal(len(turned))
    found = slow_lines(line, turned / periods, periods)
    assert found is not None
    assert found.cycles == pytest.approx([0.83 * periods], rel=1e-3)
    assert np.hypot(found.cosine, found.sine) == pytest.approx([0.3], rel=3e-4)


def test_the_peak_to_peak_scatters_by_the_noise_alone() -> None:
    found = [measured(record(120.0, seed, (1 / POLE_PAIRS, 0.04)))["torque_ripple_pp"] for seed in range(16)]
    stated = [each.uncertainty.standard for each in found if each.uncertainty is not None]
    scatter = float(np.std([each.value for each in found]))
    assert len(stated) == len(found)
    assert 0.45 < scatter / np.sqrt(np.mean(np.square(stated))) < 1.5


def test_a_drift_is_no_random_walk_of_the_mean() -> None:
    torque = record(60.0, 3)
    torque += 0.05 * np.linspace(-1.0, 1.0, len(torque))
    found = measured(torque)
    assert found["torque_mean"].uncertainty is not None
    assert found["torque_mean"].uncertainty.standard < 1e-3


@pytest.mark.parametrize("drift", [0.0, 0.05])
def test_what_few_rows_of_a_ripple_miss_is_no_slow_line(drift: float) -> None:
    """Sixty rows of a period beat with it; where the speed drifts, so do parts of equal time."""
    for phase in np.linspace(0.0, 6.0, 7):
        row = np.arange(109 * 60)
        turned = 2 * np.pi * (row / 64.7 * (1.0 + drift * (row / len(row) - 1.0))) + phase
        periods = int((turned[-1] - turned[0]) / (2 * np.pi))
        within = turned < turned[0] + 2 * np.pi * periods
        torque = 2.0 + 0.1 * np.cos(6 * turned + 0.3) + 0.05 * np.cos(3 * turned + 1.1)
        torque += 2e-4 * np.random.default_rng(1).standard_normal(len(row))
        place = (turned - turned[0]) / (2 * np.pi * periods)
        assert slow_lines(torque[within], place[within], periods, 4) is None


@pytest.mark.parametrize("memory", [0.0, 0.99, 0.9999])
def test_noise_has_no_slow_lines(memory: float) -> None:
    from scipy.signal import lfilter

    place = (np.arange(20_000) + 0.5) / 20_000
    found = 0
    for seed in range(30):
        noise = lfilter([1.0], [1.0, -memory], np.random.default_rng(seed).standard_normal(20_000))
        found += slow_lines(noise, place, 80, POLE_PAIRS) is not None
    assert found <= 1


@pytest.mark.parametrize("periods", [2000, 3000, 5000, 20_000])
def test_many_periods_have_slow_lines_or_none_are_sought(periods: int) -> None:
    """Five thousand periods are more than the blocks in which a record is looked at otherwise."""
    place = (np.arange(7 * periods) + 0.5) / (7 * periods)
    slow = 0.1 * np.cos(2 * np.pi * periods / POLE_PAIRS * place)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(place))
    found = slow_lines(2.0 + slow + noise, place, periods, POLE_PAIRS)
    if periods > 1 << 14:
        assert found is None
        return
    assert found is not None
    assert found.cycles == pytest.approx([periods / POLE_PAIRS])
    assert np.std(found.at(place) - slow) < 3e-3


def test_lines_too_close_to_be_told_apart_are_no_power_of_their_own() -> None:
    # a drift is explained by two large sinusoids that cancel
    torque = record(42.4, 3)
    drifting = torque + 0.1 * np.linspace(-0.5, 0.5, len(torque))

    rms = measured(drifting)["torque_ripple_rms"].value

    assert rms == pytest.approx(np.std(drifting), rel=1e-3)


def test_a_percentile_knows_the_share_of_a_slow_cycle() -> None:
    found = [
        measured(record(60.3, seed, (0.137, 0.05)))["torque_ripple_percentile_range"] for seed in range(16)
    ]

    scatter = np.std([each.value for each in found], ddof=1)
    stated = np.sqrt(np.mean([each.uncertainty.standard**2 for each in found if each.uncertainty]))

    assert 0.8 * scatter < stated < 4.0 * scatter


def test_a_percentile_that_few_crests_make_is_not_known_from_their_agreement() -> None:
    """One crest in each of three revolutions has at times as many rows beyond it as the others."""
    least = np.inf
    for per_period in np.linspace(60.1, 63.3, 40)[::2]:
        turned = 2 * np.pi * np.arange(int(18.3 * per_period)) / per_period + 40.0 * per_period
        torque = 2.0 + 0.06 * np.cos(turned / 6.0) + 0.03 * np.cos(turned / 3.0 + 1.0) + 0.04 * np.cos(turned)
        torque += 1e-3 * np.random.default_rng(1).standard_normal(len(turned))
        block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
        numbers = torque_ripple(block, track=track_angle(turned / 6.0, 6), pole_pairs=6)
        found = next(each for each in numbers if each.name == "torque_ripple_percentile_range")
        assert found.uncertainty is not None
        least = min(least, found.uncertainty.standard)
    assert least > 2e-4  # of 0.22 Nm; 3e-5 by their scatter


@cache
def _of_beats(beside: float) -> tuple[dict[str, Measurement], ...]:
    """Numbers of twelve records in which a line beats with that of the ripple."""
    turned = 2 * np.pi * np.arange(round(40.3 * PER_PERIOD)) / PER_PERIOD
    found = []
    for seed in range(12):
        begin = np.random.default_rng([seed, 9]).uniform(0.0, 2 * np.pi)
        found.append(measured(record(40.3, seed) + 0.03 * np.cos(beside * turned + begin)))
    return tuple(found)


@pytest.mark.parametrize("beside", [6.083, *at_length(6.23)])
@pytest.mark.parametrize("number", ["torque_ripple_percentile_range", "torque_ripple_pp"])
def test_numbers_of_a_beat_are_known_as_well_as_its_crests(beside: float, number: str) -> None:
    found = [each[number] for each in _of_beats(beside)]

    scatter = np.std([each.value for each in found], ddof=1)
    stated = [each.uncertainty.standard for each in found if each.uncertainty]

    assert len(stated) == len(found)
    assert 0.3 < scatter / np.sqrt(np.mean(np.square(stated))) < 1.6


def test_a_beat_of_half_the_record_has_no_peak_to_peak() -> None:
    turned = 2 * np.pi * np.arange(round(50.2 * PER_PERIOD)) / PER_PERIOD
    torque = record(50.2, 5) + 0.05 * np.cos(6.009 * turned)

    found = measured(torque)["torque_ripple_pp"]

    assert found.uncertainty is None
    assert "grows or falls over the whole record" in found.uncertainty_reason
    assert measured(record(50.2, 5))["torque_ripple_pp"].uncertainty is not None


def test_extremes_on_a_drift_scatter_as_those_of_its_ends() -> None:
    drift = [
        record(40.3, seed) + 0.3 * np.linspace(-0.5, 0.5, round(40.3 * PER_PERIOD)) for seed in range(24)
    ]
    found = [measured(each)["torque_ripple_pp"] for each in drift]

    scatter = np.std([each.value for each in found], ddof=1)
    stated = np.sqrt(np.mean([each.uncertainty.standard**2 for each in found if each.uncertainty]))

    assert 0.7 * scatter < stated < 1.8 * scatter


def test_a_wander_that_leaves_the_mean_unknown_leaves_the_rms_unknown() -> None:
    unknown = 0
    for seed in range(8):
        torque = record(60.0, seed)
        walk = np.cumsum(np.random.default_rng(seed + 100).standard_normal(len(torque)))
        found = measured(torque + 0.05 * walk / np.sqrt(len(walk)))
        if found["torque_mean"].uncertainty is None:
            unknown += 1
            assert found["torque_ripple_rms"].uncertainty is None
            assert "wanders" in found["torque_ripple_rms"].uncertainty_reason
    assert unknown >= 2


def test_a_speed_that_swings_along_its_own_angle_has_the_mean_over_time() -> None:
    """Over angle it would be larger by the square of the swing, as more of a fast turn is in a second."""
    time_s, swing, mean, random = np.arange(30_000) / RATE_HZ, 0.02, 40.0, np.random.default_rng(8)
    for cycles in (5.6, 6.3, 8.5, 11.0):
        turned = 2 * np.pi * cycles * time_s / time_s[-1] + random.uniform(0, 6.0)
        speed = mean * (1.0 + swing * np.sin(turned)) + 0.05 * random.standard_normal(len(turned))
        theta_m = mean * (time_s - swing * time_s[-1] / (2 * np.pi * cycles) * np.cos(turned))
        block = Block.from_arrays(RATE_HZ, {"omega_m": "rad/s"}, omega_m=speed)
        track = track_angle(theta_m - theta_m[0], POLE_PAIRS)
        found = ripple_numbers(block, "omega_m", "speed", track=track, pole_pairs=POLE_PAIRS)[0]
        assert found.uncertainty is not None
        assert abs(found.value - mean) < 3.0 * found.uncertainty.standard < 0.25 * swing**2 * mean


@pytest.mark.parametrize("steps", [1.0, *at_length(3.5)])
def test_the_mean_of_a_slow_line_in_few_steps_is_known_as_well_as_these_let_it(steps: float) -> None:
    step, random, errors = 0.05, np.random.default_rng(3), []
    for _ in range(8):
        turned = 2 * np.pi * np.arange(80 * PER_PERIOD) / PER_PERIOD
        slow = steps * step * random.uniform(0.7, 1.3) * np.cos(0.071 * turned + random.uniform(0, 6.0))
        mean = random.uniform(1.0, 1.0 + step)
        torque = mean + slow + random.uniform(0.2, 0.6) * step * np.cos(6 * turned)
        found = measured(np.asarray(step * np.round(torque / step)))["torque_mean"]
        assert found.uncertainty is not None
        errors.append((found.value - mean) / found.uncertainty.standard)
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 1.6


@pytest.mark.parametrize("cycles", [0.3, *at_length(0.1)])
def test_lines_within_part_of_a_cycle_do_not_tell_the_rms(cycles: float) -> None:
    """Of their beat the record shows that part: the mean square may be any between those at its nodes."""
    two = [
        measured(record(120.0, seed, (0.137, 0.04), (0.137 + cycles / 120.0, 0.03)))["torque_ripple_rms"]
        for seed in range(6)
    ]
    assert all(each.uncertainty is None and "apart" in each.uncertainty_reason for each in two)
    one = measured(record(120.0, 1, (0.137, 0.04)))["torque_ripple_rms"]
    assert one.uncertainty is not None


def test_lines_that_are_not_told_from_each_other_move_a_mean_as_one() -> None:
    """Three within a part of a cycle stand for one beside them, where the pace of the record swings."""
    rows = np.linspace(0.0, 1.0, 4000)
    place = rows + 0.0035 * (np.sin(2 * np.pi * 2.2 * rows) - np.sin(2 * np.pi * 2.2) * rows) / 2.2
    cycles = np.array([18.86, 18.91, 19.0])
    turned = 2 * np.pi * np.outer(place, cycles)
    basis = np.concatenate([np.cos(turned), np.sin(turned)], axis=1)
    sizes = np.linalg.lstsq(basis, 0.06 * np.cos(2 * np.pi * 19.06 * place + 1.0), rcond=None)[0]
    lines = SlowLines(0.0, cycles, sizes[:3], sizes[3:])
    assert float(np.max(np.hypot(sizes[:3], sizes[3:]))) > 0.1
    alone = SlowLines(0.0, np.array([19.06]), np.array([0.06 * np.cos(1.0)]), np.array([-0.06 * np.sin(1.0)]))
    assert lines.mean_at(place) == pytest.approx(alone.mean_at(place), abs=2e-5)
