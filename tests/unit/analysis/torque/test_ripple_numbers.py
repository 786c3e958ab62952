"""Ripple as measurements: closed forms, resolution, and uncertainties against repeated records."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray

from benchtool.analysis import (
    Measurement,
    PhaseTrack,
    analyze_steady_state,
    percentile_range,
    resolution,
    ripple_numbers,
    torque_ripple,
    track_angle,
)
from benchtool.analysis.measurement import measurements_from_json, measurements_to_json
from benchtool.analysis.statistics.between_samples import BETWEEN
from benchtool.analysis.torque.means_of_periods import Periods, mean_over_periods
from benchtool.analysis.torque.ripple_percentiles import percentile_scatter
from benchtool.analysis.torque.ripple_scatter import scatter_of_periods
from benchtool.analysis.torque.slow_ripple import SlowRipple
from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError

RATE_HZ = 10e3
PERIODS = 40
PER_PERIOD = 250
Array = NDArray[np.float64]


def block(samples: Array, unit: str = "Nm", gaps: tuple[Gap, ...] = ()) -> Block:
    return Block((Channel("torque", unit),), 0, 1, 1.0 / RATE_HZ, samples[:, np.newaxis], gaps)


def angle(samples: int) -> Array:
    """Electrical angle of the records below, rad."""
    theta_e: Array = 2 * np.pi * np.arange(samples) / PER_PERIOD
    return theta_e


def track(samples: int) -> PhaseTrack:
    return track_angle(angle(samples), 1)


def numbers(samples: Array, phase: PhaseTrack | None = None) -> dict[str, Measurement]:
    return {each.name: each for each in torque_ripple(block(samples), torque_rated_Nm=2.0, track=phase)}


@pytest.mark.parametrize("mean", [0.3, -0.3])
def test_a_mean_without_an_uncertainty_is_no_base_where_the_ripple_reaches_zero(mean: float) -> None:
    ripple = 0.5 * np.sin(angle(600))
    of_zero, of_more = numbers(mean + ripple), numbers(2.0 * mean + ripple)
    for name in ("torque_ripple_percent_of_mean", "torque_ripple_rms_percent_of_mean"):
        assert math.isnan(of_zero[name].value)
        assert "less than half of its ripple of 1 Nm peak to peak" in of_zero[name].reason
        assert "how much of that is in the mean is not known" in of_zero[name].reason
        assert of_more[name].value > 0.0
    assert numbers(mean + 0.5 * np.sin(angle(5000)), track(5000))["torque_ripple_percent_of_mean"].value > 0.0


def test_a_sampled_triangle_reads_its_closed_form() -> None:
    # 40 samples a period that hit both peaks: values -10 ... 10 in steps of one, each but the ends twice
    one = np.abs(np.arange(40) - 20.0) - 10.0
    measured = numbers(5.0 + 0.1 * np.tile(one, 250))

    assert measured["torque_mean"].value == pytest.approx(5.0)
    assert measured["torque_ripple_pp"].value == pytest.approx(2.0)
    # 2 sum of k^2 from 1 to 9, and the two ends, over 40
    assert measured["torque_ripple_rms"].value == pytest.approx(0.1 * math.sqrt((4 * 285 + 200) / 40))
    assert measured["torque_ripple_percentile_range"].value == pytest.approx(2.0)
    assert measured["torque_ripple_percent_of_mean"].value == pytest.approx(40.0)
    assert measured["torque_ripple_percent_of_rated"].value == pytest.approx(100.0)
    assert measured["torque_ripple_rms_percent_of_rated"].value == pytest.approx(
        50.0 * measured["torque_ripple_rms"].value
    )


def test_of_a_rating_of_zero_there_is_no_percentage() -> None:
    samples = np.sin(angle(400))
    measured = {each.name: each for each in torque_ripple(block(samples), torque_rated_Nm=0.0)}
    for name in ("torque_ripple_percent_of_rated", "torque_ripple_rms_percent_of_rated"):
        assert math.isnan(measured[name].value)
        assert "it is 0 Nm" in measured[name].reason
    assert measured["torque_ripple_pp"].value > 1.9


def test_a_triangle_between_the_samples_reads_low_by_at_most_a_step() -> None:
    # the peaks fall between samples: each is missed by at most half a sample's slope
    number = np.arange(10_000) / 40.37
    samples = 5.0 + 1.0 * (4 * np.abs(number - np.round(number)) - 1)

    pp = numbers(samples)["torque_ripple_pp"].value

    assert 2.0 - 4 / 40.37 <= pp <= 2.0


def test_a_ripple_beyond_half_the_rate_folds_and_the_basis_does_not_claim_to_know() -> None:
    time_s = np.arange(10_000) / RATE_HZ

    beyond = numbers(1.0 + 0.2 * np.cos(2 * np.pi * 9_700 * time_s))["torque_ripple_pp"]
    below = numbers(1.0 + 0.2 * np.cos(2 * np.pi * 300 * time_s))["torque_ripple_pp"]

    assert beyond.value == pytest.approx(below.value)
    assert beyond.basis.bandwidth_Hz == 0.5 * RATE_HZ < 9_700


def test_one_spike_moves_the_peak_to_peak_and_not_the_percentiles() -> None:
    samples = 1.0 + 0.1 * np.cos(6 * angle(10_000))
    spiked = samples.copy()
    spiked[5000] = 9.0

    assert numbers(spiked)["torque_ripple_pp"].value == pytest.approx(8.1, rel=1e-3)
    assert numbers(spiked)["torque_ripple_percentile_range"].value == pytest.approx(
        numbers(samples)["torque_ripple_percentile_range"].value, rel=1e-3
    )


@cache
def _repeated_records() -> tuple[dict[str, Measurement], ...]:
    """Numbers of 80 records in which every period has a mean and a ripple of its own, and noise."""
    generator = np.random.default_rng(5)
    theta_e, rows = angle(PERIODS * PER_PERIOD)[::2], PER_PERIOD // 2
    phase = track_angle(theta_e, 1)
    found = []
    for _ in range(80):
        level = np.repeat(generator.normal(0.65, 0.01, PERIODS), rows)
        size = np.repeat(generator.normal(0.03, 0.003, PERIODS), rows)
        noise = generator.normal(0.0, 0.004, len(theta_e))
        found.append(numbers(level + size * np.cos(6 * theta_e) + noise, phase))
    return tuple(found)


@pytest.mark.parametrize("name", ["torque_mean", "torque_ripple_rms", "torque_ripple_percentile_range"])
def test_the_uncertainty_is_what_repeated_records_scatter_by(name: str) -> None:
    measured = [each[name] for each in _repeated_records()]
    values = np.array([each.value for each in measured])
    claimed = np.array([each.uncertainty.standard for each in measured if each.uncertainty is not None])
    assert len(claimed) == len(values)
    # 80 records know their scatter to 8 %; the density at a percentile is a coarse estimate
    assert np.median(claimed) == pytest.approx(np.std(values, ddof=1), rel=0.35)
    errors = (values - np.mean(values)) / claimed
    assert 0.6 < float(np.sqrt(np.mean(errors**2))) < 1.3
    assert np.mean(np.abs(errors) < 2.0) >= 0.9


def test_the_incomplete_period_at_the_end_moves_neither_mean_nor_rms() -> None:
    cut = 40 * PER_PERIOD + PER_PERIOD // 2
    samples = 1.0 + 0.1 * np.sin(angle(cut)) + 0.03 * np.cos(2.0 * angle(cut))

    found = numbers(samples, track(cut))

    assert np.mean(samples) > 1.0007
    assert found["torque_mean"].value == pytest.approx(1.0, abs=1e-9)
    assert found["torque_ripple_rms"].value == pytest.approx(math.hypot(0.1, 0.03) / math.sqrt(2.0), rel=1e-5)


@pytest.mark.parametrize("periods", [5, 49, 50])
def test_a_period_behind_the_last_whole_one_moves_neither_mean_nor_rms(periods: int) -> None:
    # equal periods, whose growth is zero to the last digit
    rows = np.arange(0, (periods + 1) * 500, 500)
    samples = 2.0 + 0.1 * np.cos(2.0 * np.pi / 500.0 * np.arange((periods + 1) * 500) + 0.7)

    found = scatter_of_periods(samples, Periods(rows[:-1]))

    assert found is not None
    assert found.whole_mean == pytest.approx(2.0, abs=1e-6)
    assert found.whole_rms == pytest.approx(0.1 / math.sqrt(2.0), abs=1e-6)


def test_incomplete_periods_of_a_drift_are_no_ripple() -> None:
    count = 40 * PER_PERIOD + PER_PERIOD // 3
    samples = 1.0 + 0.1 * np.sin(angle(count)) + 0.3 * (np.arange(count) + 0.5) / count

    mean = numbers(samples, track(count))["torque_mean"]

    assert mean.value == pytest.approx(1.15, abs=1e-5)


def test_the_uncertainty_of_the_peak_to_peak_is_its_scatter_over_records() -> None:
    found = []
    for seed in range(20):
        count = PERIODS * PER_PERIOD + 1
        noise = 0.01 * np.random.default_rng(seed).standard_normal(count)
        found.append(numbers(1.0 + 0.1 * np.cos(angle(count)) + noise, track(count))["torque_ripple_pp"])

    stated = [each.uncertainty.standard for each in found if each.uncertainty is not None]
    assert len(stated) == 20
    scatter = float(np.std([each.value for each in found]))
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(1.25 * scatter, rel=0.4)  # no less
    assert found[0].uncertainty is not None
    assert "40 single electrical periods, whose mean peak-to-peak is 0.2" in found[0].uncertainty.source


def test_without_periods_a_resolution_is_not_stated_as_if_it_were_all() -> None:
    samples = np.round(1.0 + 0.1 * np.cos(6 * angle(5000)), 2)

    measured = numbers(samples)

    for name in ("torque_mean", "torque_ripple_pp", "torque_ripple_percent_of_mean"):
        assert measured[name].uncertainty is None
        assert "no angle, current or stated speed tells periods" in measured[name].uncertainty_reason


def test_of_three_periods_the_extremes_do_not_tell_how_much_they_scatter() -> None:
    count = 3 * PER_PERIOD + 1
    noise = 0.01 * np.random.default_rng(5).standard_normal(count)

    number = numbers(np.round(1.0 + 0.1 * np.cos(angle(count)) + noise, 3), track(count))["torque_ripple_pp"]

    assert number.uncertainty is None
    assert "fewer than four periods" in number.uncertainty_reason


def test_a_percentage_of_a_mean_without_an_uncertainty_has_none() -> None:
    count = PERIODS * PER_PERIOD + 1
    noise = 0.01 * np.random.default_rng(7).standard_normal(count)
    wandering = np.sin(np.pi * np.linspace(0.0, 1.0, count))

    measured = numbers(10.0 + 0.1 * np.cos(angle(count)) + wandering + noise, track(count))

    assert measured["torque_mean"].uncertainty is None
    assert measured["torque_ripple_pp"].uncertainty is not None
    assert measured["torque_ripple_percent_of_mean"].uncertainty is None
    assert measured["torque_ripple_percent_of_mean"].uncertainty_reason


def test_a_mean_at_one_level_is_no_better_known_than_a_tenth_of_the_step() -> None:
    samples = np.full(5000, 1.0)
    samples[::1000] = 1.01

    uncertainty = numbers(samples, track(5000))["torque_mean"].uncertainty

    assert uncertainty is not None
    assert 0.1 * 0.01 < uncertainty.standard < 1.1 * 0.01 / math.sqrt(12)  # at most it is anywhere in it
    assert "resolution" in uncertainty.source


@given(st.integers(2, 60), st.integers(0, 2**31), st.sampled_from([1.0, 0.25, 2.0**-12]))
def test_resolution_is_a_multiple_of_the_step_of_a_grid_and_the_step_where_neighbours_occur(
    count: int, seed: int, step: float
) -> None:
    values = np.random.default_rng(seed).integers(-20, 20, count)

    found = resolution((step * values).astype(np.float64))

    assert found / step == pytest.approx(np.round(found / step), abs=1e-9)
    distinct = np.unique(values)
    assert found == pytest.approx(step * (np.min(np.diff(distinct)) if len(distinct) > 1 else 0))


def test_an_rms_in_few_steps_that_meet_the_rows_slowly_says_so() -> None:
    """Without noise the rows of a period fall elsewhere in the steps than those of the next."""
    theta_m = 2.0 * np.pi * 22.6 * np.arange(8000) / 8000
    lines = ((12, 0.03, 1.0), (24, 0.015, 2.0), (3, 0.01, 0.5))
    torque = 1.0 + sum(size * np.cos(order * theta_m + at) for order, size, at in lines)
    rms = numbers(0.05 * np.round(torque / 0.05), track_angle(theta_m, 1))["torque_ripple_rms"]
    assert rms.uncertainty is None
    assert "where in its few steps the rows fall" in rms.uncertainty_reason


def test_resolution_of_a_long_record_is_found_in_part_of_it() -> None:
    samples = np.round(np.random.default_rng(3).normal(0, 10, 400_000))

    assert resolution(samples) == 1.0


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=40), st.floats(0.1, 10), st.floats(-10, 10))
def test_a_percentile_range_scales_and_does_not_shift(
    values: list[float], scale: float, shift: float
) -> None:
    samples = np.array(values)

    assert percentile_range(scale * samples + shift) == pytest.approx(
        scale * percentile_range(samples), abs=1e-9 * (1 + float(np.max(np.abs(samples))))
    )
    assert percentile_range(samples) <= np.max(samples) - np.min(samples) + 1e-12


def test_the_last_digit_of_a_computed_signal_is_no_resolution() -> None:
    clean, phase = 1.0 + 0.1 * np.cos(6 * angle(5000)), track(5000)

    for name in ("torque_ripple_pp", "torque_ripple_percent_of_mean", "torque_ripple_percent_of_rated"):
        of_digits, of_steps = (numbers(each, phase)[name].uncertainty for each in (clean, np.round(clean, 3)))
        assert of_steps is not None
        if of_digits is not None:  # but for the curve between samples that are at the same places
            others = [each.standard for each in of_digits.budget if each.name != BETWEEN]
            assert name != "torque_ripple_pp" or math.hypot(*others) < 1e-3 * of_steps.standard
            assert of_digits.standard < 0.1 * of_steps.standard


def test_another_channel_gives_its_name_and_unit() -> None:
    measured = ripple_numbers(block(np.arange(100.0), unit="A"), "torque", "current", what="i_q")

    assert [each.name for each in measured][:2] == ["current_mean", "current_ripple_pp"]
    assert {each.unit for each in measured} == {"A", "%"}
    assert measured[0].definition == "mean of i_q"
    assert not any("rated" in each.name for each in measured)


def test_a_gap_is_refused() -> None:
    with pytest.raises(AnalysisError, match="3 rows are missing"):
        torque_ripple(block(np.arange(100.0), gaps=(Gap(10, 3),)))


@pytest.mark.parametrize("periods", [2, 3])
def test_a_number_without_an_uncertainty_says_why(periods: int) -> None:
    random = np.random.default_rng(periods)
    count = periods * PER_PERIOD + 40
    samples = 1.0 + 0.1 * np.cos(angle(count)) + 1e-3 * random.standard_normal(count)
    found = [*numbers(samples, track(count)).values(), *numbers(samples).values()]
    assert any(each.uncertainty is None for each in found)
    for each in found:
        assert bool(each.uncertainty_reason) == (each.uncertainty is None)
        if each.uncertainty is None:
            assert "no uncertainty" in str(each)
            assert each.to_json()["uncertainty_reason"] == each.uncertainty_reason
    document = measurements_to_json(found)
    assert measurements_to_json(measurements_from_json(document)) == document


def test_percentiles_of_three_periods_have_no_uncertainty_but_a_reason() -> None:
    random = np.random.default_rng(4)
    for periods in (3, 4):
        samples = np.cos(6.0 * angle(periods * PER_PERIOD + 1))
        samples += 0.1 * random.standard_normal(len(samples))
        found = numbers(samples, track(len(samples)))["torque_ripple_percentile_range"]
        assert (found.uncertainty is None) == (periods == 3)
        assert ("fewer than four periods" in found.uncertainty_reason) == (periods == 3)


@pytest.mark.parametrize("held", [1, 10, 25, 125])
def test_percentiles_of_few_updates_in_a_period_have_no_uncertainty_but_a_reason(held: int) -> None:
    count = PERIODS * PER_PERIOD + 1
    samples = np.cos(6.0 * angle(count)) + 0.1 * np.random.default_rng(4).standard_normal(count)
    samples = np.repeat(samples[::held], held)[:count]
    found = numbers(samples, track(count))
    percentiles = found["torque_ripple_percentile_range"]
    assert (percentiles.uncertainty is None) == (held > 10)
    assert (f"held for {held} rows" in percentiles.uncertainty_reason) == (held > 10)
    assert found["torque_mean"].uncertainty is not None


def test_percentiles_between_heaps_are_known_to_the_next_heap() -> None:
    # a sample in two hundred is of the highest heap, and so in half of the records the percentile is too
    random, count = np.random.default_rng(5), 12 * PER_PERIOD + 1
    stated, read = [], []
    for _ in range(24):
        levels = np.searchsorted([0.005, 0.5, 0.9, 0.996], random.random(count))
        found = numbers(levels + 1e-4 * random.standard_normal(count), track(count))
        number = found["torque_ripple_percentile_range"]
        assert number.uncertainty is not None
        stated.append(number.uncertainty.standard)
        read.append(number.value)
    assert np.std(read) > 0.3
    assert 0.8 < np.median(stated) / np.std(read) < 1.8


def test_percentiles_of_few_periods_are_known_by_how_much_their_size_differs() -> None:
    random, count = np.random.default_rng(5), 6 * PER_PERIOD
    stated, read = [], []
    for _ in range(60):
        size = np.repeat(1.0 + 0.2 * random.standard_normal(6), PER_PERIOD)
        samples = size * np.cos(6.0 * angle(count)) + 0.02 * random.standard_normal(count)
        repeats = Periods(np.arange(0, count + 1, PER_PERIOD))
        mean = mean_over_periods(samples, repeats)
        slow = SlowRipple.of(samples, repeats, mean, mean_over_periods(samples**2, repeats))
        stated.append(percentile_scatter(samples, slow).standard)
        read.append(percentile_range(samples))
    errors = (np.array(read) - np.mean(read)) / np.array(stated)
    assert 0.6 < float(np.sqrt(np.mean(errors**2))) < 1.5


def test_where_periods_are_taken_to_begin_is_no_size_of_the_ripple() -> None:
    random, count = np.random.default_rng(5), 100 * PER_PERIOD
    samples = 0.1 * np.cos(6.0 * angle(count)) + 0.05 * np.cos(3.0 * angle(count))
    samples += 1e-4 * random.standard_normal(count)
    rows = np.arange(0, count + 1, PER_PERIOD)
    wander = np.round(8.0 * np.sin(np.pi * rows / count) * np.sin(8.0 * np.pi * rows / count))
    stated = []
    for each in (rows, rows + wander.astype(np.int64)):
        found = scatter_of_periods(samples, Periods(each))
        assert found is not None
        assert found.percentile_range is not None
        stated.append(found.percentile_range.standard)
    assert stated[1] == pytest.approx(stated[0], rel=0.4)


def test_percentiles_on_a_drift_are_known_as_well_as_without() -> None:
    random, count = np.random.default_rng(5), PERIODS * PER_PERIOD + 1
    drift = np.linspace(-0.5, 0.5, count)
    stated, read = [], []
    for _ in range(16):
        samples = 0.1 * np.cos(6.0 * angle(count)) + 0.02 * random.standard_normal(count) + drift
        found = numbers(samples, track(count))["torque_ripple_percentile_range"]
        assert found.uncertainty is not None
        stated.append(found.uncertainty.standard)
        read.append(found.value)
    assert np.std(read) < 1.4 * np.median(stated) < 6.0 * np.std(read)


def test_periods_that_end_between_rows_are_cut_there() -> None:
    """Of a quiet ripple a mean over whole rows is off by what the part of a row holds."""
    theta_e: Array = 2 * np.pi * np.arange(9_873, dtype=np.float64) / 250.37
    random = np.random.default_rng(11)
    truths = {"torque_mean": 2.0, "torque_ripple_rms": 0.1 / math.sqrt(2.0)}
    relative: dict[str, list[float]] = {name: [] for name in truths}
    for _ in range(20):
        noise: Array = 1e-6 * random.standard_normal(len(theta_e))
        begin = float(random.uniform(0.0, 2.0 * np.pi))
        samples: Array = np.asarray(2.0 + 0.1 * np.cos(6.0 * theta_e + begin) + noise)
        found = numbers(samples, track_angle(theta_e, 1))
        for name, truth in truths.items():
            each = found[name]
            assert each.uncertainty is not None
            assert each.uncertainty.standard < 1e-6
            relative[name].append((each.value - truth) / each.uncertainty.standard)
    for errors in relative.values():
        assert np.mean(np.abs(errors) < 2.0) >= 0.9


def test_what_rows_miss_of_a_crest_in_each_period_is_no_scatter_of_the_peak_to_peak() -> None:
    """Four rows in a period of the ripple, at other places of each: single periods differ by half of it."""
    random, values, stated = np.random.default_rng(6), [], []
    for _ in range(30):
        turns = (np.arange(410.0) + random.uniform()) / 24.2313
        torque = 2.0 + 0.1 * np.cos(12.0 * np.pi * turns) + 0.05 * np.cos(6.0 * np.pi * turns + 0.4)
        torque += 1e-3 * random.standard_normal(len(torque))
        block = Block.from_arrays(1e4, {"torque": "Nm"}, torque=torque)
        found = torque_ripple(block, track=track_angle(2.0 * np.pi * turns, 1))
        number = next(each for each in found if each.name == "torque_ripple_pp")
        assert number.uncertainty is not None
        values.append(number.value)
        stated.append(number.uncertainty.standard)
    assert 0.7 < np.std(values) / np.median(stated) < 1.4


def test_periods_begin_where_the_rotor_is_while_its_speed_swings() -> None:
    """A swing of 1 % at a tenth of the frequency: parts of the ripple would else move between periods."""
    random, relative, standard = np.random.default_rng(7), [], []
    for _ in range(22):
        time_s, at = np.arange(25_075) / 5e3, random.uniform(0.0, 2.0 * np.pi, 2)
        theta_e = 2.0 * np.pi * 20.0 * time_s + 0.1 * np.sin(2.0 * np.pi * 2.0 * time_s + at[0])
        torque = 2.0 + 0.1 * np.cos(6.0 * theta_e + at[1]) + 2e-4 * random.normal(size=len(time_s))
        mean = numbers(torque, track_angle(theta_e, 1))["torque_mean"]
        assert mean.uncertainty is not None
        relative.append((mean.value - 2.0) / mean.uncertainty.standard)
        standard.append(mean.uncertainty.standard)
    assert 0.6 < float(np.sqrt(np.mean(np.square(relative)))) < 1.4
    assert float(np.median(standard)) < 2.5e-6


@pytest.mark.parametrize("drift", [0.0, 0.03])
def test_periods_begin_where_the_current_is_without_an_angle(drift: float) -> None:
    """Along a track of constant frequency a drift smears what is read in steps: they were not in its rms."""
    random, count = np.random.default_rng(7), 25_075
    place = np.arange(count) / count
    theta_e = 2.0 * np.pi * 91.7 * (place + 0.5 * drift * (place**2 - place)) + 0.4
    ripple = 0.15 * np.cos(6.0 * theta_e) + 0.05 * np.cos(3.0 * theta_e + 1.0)
    torque = 0.01 * np.round((2.003 + ripple + 1e-3 * random.normal(size=count)) / 0.01)
    current = np.cos(theta_e) + 1e-3 * random.normal(size=count)
    units = {"torque": "Nm", "i_a": "A"}
    block = Block.from_arrays(5e3, units, torque=torque, i_a=current)
    steady = analyze_steady_state(block, pole_pairs=1, torque_rated_Nm=2.0).measurements
    by_current = [each for each in steady if each.name.startswith("torque") and "line" not in each.name]
    by_angle = torque_ripple(block, torque_rated_Nm=2.0, track=track_angle(theta_e, 1))
    for one, other in zip(by_current, by_angle, strict=True):
        assert one.uncertainty is not None
        assert other.uncertainty is not None
        assert one.value == pytest.approx(other.value, rel=1e-4)
        assert one.uncertainty.standard == pytest.approx(other.uncertainty.standard, rel=0.15)
    of_rms = next(each.uncertainty for each in by_current if each.name == "torque_ripple_rms")
    assert of_rms is not None
    assert any("resolution" in each.name for each in of_rms.budget)
