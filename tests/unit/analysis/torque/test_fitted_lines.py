"""What a torque repeats more slowly than a period is no noise of its mean, rms and extremes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, ripple_numbers, torque_ripple, track_angle
from benchtool.analysis.torque.fitted_lines import FittedLines, _aligned, slow_lines
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


@pytest.mark.parametrize("periods", [2000, 3000, 16_000, 20_000])
def test_many_periods_have_slow_lines_or_none_are_sought(periods: int) -> None:
    """Sixteen thousand periods are more than the blocks in which a record is looked at otherwise."""
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


@pytest.mark.slow
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
    lines = FittedLines(0.0, cycles, sizes[:3], sizes[3:])
    assert float(np.max(np.hypot(sizes[:3], sizes[3:]))) > 0.1
    alone = FittedLines(
        0.0, np.array([19.06]), np.array([0.06 * np.cos(1.0)]), np.array([-0.06 * np.sin(1.0)])
    )
    assert lines.mean_at(place) == pytest.approx(alone.mean_at(place), abs=2e-5)


def _evenly(count: int) -> Array:
    return (np.arange(count) + 0.5) / count


def test_sums_of_sinusoids_have_the_means_of_their_integrals() -> None:
    """Over 2.3 cycles a cosine has the mean sin(2 pi 2.3) / (2 pi 2.3), over whole cycles none."""
    lines = FittedLines(0.7, np.array([2.3, 5.0]), np.array([0.4, 0.1]), np.array([-0.2, 0.3]))
    place, turned = _evenly(20_000), 2.0 * np.pi * 2.3
    of_first = 0.4 * np.cos(turned * place) - 0.2 * np.sin(turned * place)
    of_second = 0.1 * np.cos(10.0 * np.pi * place) + 0.3 * np.sin(10.0 * np.pi * place)
    assert lines.at(place) == pytest.approx(of_first + of_second, abs=1e-12)
    assert lines.mean_square == pytest.approx(0.5 * (0.4**2 + 0.1**2 + 0.2**2 + 0.3**2))
    expected = (0.4 * np.sin(turned) - 0.2 * (1.0 - np.cos(turned))) / turned
    assert lines.mean_at(place) == pytest.approx(expected, rel=1e-5)
    assert (lines.of_mean, lines.untold) == (1.0, 0.0)
    few = FittedLines(0.0, np.array([2.0, 7.0]), np.ones(2), np.ones(2))
    assert few.mean_at(_evenly(40)) == pytest.approx(0.0, abs=1e-9)  # as many as there are rows


@pytest.mark.parametrize("cycles", [4.0, 1.2])
def test_incomplete_cycles_move_a_mean_by_half_a_cycle_at_most(cycles: float) -> None:
    """By 1 / (pi c) of an amplitude."""
    line = FittedLines(0.0, np.array([cycles]), np.array([0.4]), np.zeros(1))
    for sign in (1.0, -1.0):
        one = replace(line, cosine=sign * line.cosine)
        assert one.mean_at(np.linspace(0.0, 0.02, 1000)) == pytest.approx(
            sign * 0.4 / (np.pi * cycles), rel=1e-3
        )


@pytest.mark.parametrize(
    ("cycles", "apart"), [([0.9], False), ([1.1], True), ([2.1, 1.2], False), ([1.2, 2.3], True)]
)
def test_lines_are_apart_by_more_than_a_cycle(cycles: list[float], apart: bool) -> None:
    assert FittedLines(0.0, np.array(cycles), np.zeros(2), np.zeros(2)).are_apart is apart


@pytest.mark.parametrize("phase_rad", [0.0, 0.8])
@pytest.mark.parametrize("cycles", [4.0, 17.0])
def test_a_pace_that_swings_along_moves_no_whole_cycles(cycles: float, phase_rad: float) -> None:
    """The mean over time of cos(x), where x runs ahead by s sin(x), is -s / 2: none of it is by a cycle that
    is not whole."""
    time, swing = _evenly(12_000), 0.05
    turned = 2.0 * np.pi * cycles * time
    place = time + swing * np.sin(turned + phase_rad) / (2.0 * np.pi * cycles)
    line = FittedLines(0.0, np.array([cycles]), np.cos([phase_rad]), -np.sin([phase_rad]))
    assert np.mean(line.at(place)) == pytest.approx(-0.5 * swing, rel=0.01)
    assert abs(line.mean_at(place)) < 0.03 * swing


def test_orders_of_a_revolution_and_other_lines_are_found_as_they_are() -> None:
    """Of 40 periods, five to a revolution: its first order, and two lines in step with nothing."""
    place = _evenly(6_000)
    given = {8.0: 0.2 - 0.1j, 12.7: 0.02j, 21.3: 0.016 - 0.012j}
    signal = 1.7 + 0.5 * np.cos(2.0 * np.pi * 40.0 * place + 1.0)
    for cycles, phasor in given.items():
        signal += np.real(phasor * np.exp(-2j * np.pi * cycles * place))
    found = slow_lines(signal + 1e-4 * np.random.default_rng(1).standard_normal(6_000), place, 40, 5)
    assert found is not None
    order = np.argsort(found.cycles)
    assert found.cycles[0] == 8.0
    assert found.cycles[order] == pytest.approx(list(given), abs=2e-4)
    assert found.cosine[order] == pytest.approx([each.real for each in given.values()], abs=1e-5)
    assert found.sine[order] == pytest.approx([each.imag for each in given.values()], abs=1e-5)
    assert found.mean == pytest.approx(1.7, abs=1e-5)
    assert found.untold == 0.0


@pytest.mark.parametrize("periods", [13, 20])
def test_noise_moves_a_mean_by_more_beside_a_line_of_part_of_a_cycle(periods: int) -> None:
    """By least squares: over the root of the part of a constant that the line does not explain."""
    cycles, place = periods / 10.0, _evenly(3_000)
    turned = 2.0 * np.pi * cycles * place
    noise = 1e-3 * np.random.default_rng(2).standard_normal(3_000)
    found = slow_lines(np.cos(turned) + noise, place, periods, 10)
    assert found is not None
    assert list(found.cycles) == [cycles]
    basis = np.stack([np.cos(turned), np.sin(turned)])
    explained = np.linalg.solve(basis @ basis.T, basis.sum(axis=1)) @ basis.sum(axis=1) / 3_000
    assert found.of_mean == pytest.approx(1.0 / np.sqrt(1.0 - explained), rel=1e-3)


@pytest.mark.parametrize(("ratio", "is_found"), [(4.0, False), (9.0, True)])
def test_a_line_stands_out_of_noise_by_six_times(ratio: float, is_found: bool) -> None:
    """A bin under a Hann window has the rms amplitude 2 sqrt(1.5 / n) of noise of 1."""
    place = _evenly(4_000)
    noise = np.random.default_rng(3).standard_normal(4_000)
    line = ratio * 2.0 * np.sqrt(1.5 / 4_000) * np.cos(2.0 * np.pi * 20.0 * place)
    found = slow_lines(line + noise, place, 50)
    assert (found is not None) is is_found


@pytest.mark.parametrize(("cycles", "is_found"), [(2.2, False), (3.3, True), (48.4, True), (48.8, False)])
def test_lines_are_sought_between_three_cycles_and_a_period(cycles: float, is_found: bool) -> None:
    place = _evenly(4_000)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(4_000)
    found = slow_lines(np.cos(2.0 * np.pi * cycles * place + 0.5) + noise, place, 50)
    assert (found is not None) is is_found


def test_of_many_lines_the_nine_largest_are_taken() -> None:
    place = _evenly(4_000)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(4_000)
    for index in range(12):
        noise += (1.0 + 0.1 * index) * np.cos(2.0 * np.pi * (9.2 + 6.0 * index) * place + index)
    found = slow_lines(noise, place, 100)
    assert found is not None
    assert np.sort(found.cycles) == pytest.approx(9.2 + 6.0 * np.arange(3, 12), abs=0.1)


@pytest.mark.parametrize(("rows", "is_found"), [(63, False), (64, True)])
def test_a_record_has_sixty_four_rows_and_two_in_a_period(rows: int, is_found: bool) -> None:
    place = _evenly(rows)
    noise = 1e-4 * np.random.default_rng(3).standard_normal(rows)
    assert (slow_lines(np.cos(2.0 * np.pi * 5.0 * place) + noise, place, 10, 2) is not None) is is_found
    assert slow_lines(np.cos(2.0 * np.pi * 5.0 * place) + noise, place, rows // 2 + 1, 2) is None


def test_two_lines_within_a_cycle_are_told_but_for_their_product_and_what_they_leave() -> None:
    place = _evenly(6_000)
    both = 0.3 * np.cos(2.0 * np.pi * 30.0 * place) + 0.2 * np.cos(2.0 * np.pi * 30.6 * place)
    found = slow_lines(both + 1e-3 * np.random.default_rng(3).standard_normal(6_000), place, 60)
    assert found is not None
    first, second = np.hypot(found.cosine, found.sine)
    assert found.untold == pytest.approx(first * second + found.mean_square)
    assert abs(found.mean_square - 0.5 * (0.3**2 + 0.2**2)) < found.untold


@pytest.mark.parametrize(("order", "periods", "is_found"), [(1, 13, True), (2, 12, False)])
def test_orders_of_a_revolution_need_three_bins_between_them(
    order: int, periods: int, is_found: bool
) -> None:
    """A revolution of ten periods has nine orders, here of at least 1.2 cycles, and a record has one bin less
    than periods below them."""
    place = _evenly(3_000)
    line = np.cos(2.0 * np.pi * order * periods / 10.0 * place)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(3_000)
    assert (slow_lines(line + noise, place, periods, 10) is not None) is is_found


def test_a_line_beside_a_large_one_shows_once_that_is_away() -> None:
    """Within its main lobe under the window; and no order of a revolution is known, of one period each."""
    place = _evenly(4_000)
    noise = 1e-4 * np.random.default_rng(2).standard_normal(4_000)
    both = 0.3 * np.cos(2.0 * np.pi * 20.0 * place) + 0.01 * np.cos(2.0 * np.pi * 22.3 * place + 1.0)
    found = slow_lines(both + noise, place, 40)
    assert found is not None
    assert found.cycles == pytest.approx([20.0, 22.3], abs=0.02)
    assert found.cycles[0] != 20.0


@pytest.mark.parametrize("cycles", [3.4, 6.7])
def test_a_line_of_few_cycles_is_at_the_place_of_least_squares(cycles: float) -> None:
    """As certain as noise lets it: sqrt(6) / (pi a) of it over the root of rows."""
    place, scatter = _evenly(3_000), 1e-3 * np.sqrt(6.0 / 3_000) / np.pi
    noise = 1e-3 * np.random.default_rng(2).standard_normal(3_000)
    for phase_rad in (0.0, 0.8, 1.6):
        found = slow_lines(np.cos(2.0 * np.pi * cycles * place + phase_rad) + noise, place, 30)
        assert found is not None
        assert found.cycles == pytest.approx([cycles], abs=4.0 * scatter)


def test_rows_at_one_place_are_a_part_of_no_length() -> None:
    """As those of an angle that stands still: their part of the distance has the value there."""
    place = np.concatenate([np.linspace(0.0, 0.5, 2_000), np.full(1_000, 0.5), np.linspace(0.5, 1.0, 1_000)])
    samples = np.cos(2.0 * np.pi * 6.3 * place)
    samples[2_000:3_000] = 0.0
    values, at, _ = _aligned(samples, place, 10)
    assert np.max(np.abs(values - np.cos(2.0 * np.pi * 6.3 * at))) < 0.6
    assert np.all(np.isfinite(_aligned(samples, np.append(np.zeros(3_999), 1.0), 10)[0]))
