"""Means of a series over what repeats in it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from benchmarks.coverage.noise import coloured
from benchtool.analysis import analyze_steady_state
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase import PeriodMarks
from benchtool.analysis.torque.means_of_periods import Periods, mean_over_periods
from benchtool.analysis.torque.ripple_scatter import scatter_of_periods
from benchtool.block import Block

RATE_HZ = 10e3


@pytest.mark.parametrize("offset", [-10.0, 10.0])
def test_a_course_is_one_of_a_mean_of_either_sign(offset: float) -> None:
    random, number = np.random.default_rng(1), np.arange(4000.0)
    series = offset + np.exp(-number / 1500.0) + 1e-3 * random.standard_normal(len(number))
    found = mean_over_periods(series, Periods(np.arange(0, 4001, 100)))
    assert found.course is not None
    assert found.mean == pytest.approx(float(np.mean(series)))


@pytest.mark.parametrize("growth", [-0.1, 0.1])
def test_the_mean_is_over_the_angle_where_the_speed_drifts(growth: float) -> None:
    """Of a sine, 0 over whole periods of the angle; over the time of 40 whole ones it is 4e-4."""
    number = np.arange(6000.0)
    share = number / len(number)
    turns = 40.3 * (share + 0.5 * growth * share**2) / (1.0 + 0.5 * growth)
    marks = np.interp(np.arange(41), turns, number)
    rows = np.ceil(marks - 1e-6).astype(np.int64)
    series = -np.sin(2 * np.pi * turns)
    whole = float(np.mean(series[: rows[-1]]))
    assert abs(whole) > 3e-4
    assert abs(mean_over_periods(series, Periods(rows, marks=PeriodMarks(marks))).mean) < 0.2 * abs(whole)


def test_the_incomplete_period_ends_where_the_rotor_is_while_its_speed_swings() -> None:
    """By the pace of the last period the end of the record is up to a thirtieth of a period elsewhere."""
    by_angle: list[float] = []
    by_pace: list[float] = []
    for phase in np.linspace(0.0, 6.0, 9):
        rows = np.arange(5973.0)
        turned = 2 * np.pi * rows / 551.0
        phase_rad = Polynomial([0.0, 2 * np.pi / 551.0])
        swing_rad = 0.046 * np.sin(0.43 * turned + phase)
        track = PhaseTrack(phase_rad, len(rows), "made", departure=CubicSpline(rows, swing_rad))
        series = 0.1 * np.cos(6.0 * track.at(rows))
        marks = PeriodMarks.of(track)
        begins = np.ceil(marks.numbers - 1e-6).astype(np.int64)
        for found, each in ((by_angle, marks), (by_pace, PeriodMarks(marks.numbers))):
            found.append(mean_over_periods(series, Periods(begins, marks=each)).mean)
    assert float(np.max(np.abs(by_pace))) > 1e-4
    assert float(np.max(np.abs(by_angle))) < 1e-5


@pytest.mark.parametrize("speeds_rad_s", [(90.0, 110.0), (40.0, 160.0), (160.0, 40.0)])
def test_a_course_is_one_over_time_while_the_speed_rises_or_falls(speeds_rad_s: tuple[float, float]) -> None:
    """Over the revolutions neither a line nor a parabola in time is one."""
    time_s = np.arange(20_000) / RATE_HZ
    begin, end = speeds_rad_s
    errors, standards = [], []
    for seed in range(8):
        random = np.random.default_rng(seed)
        angle_rad = begin * time_s + 0.25 * (end - begin) * time_s**2 + random.uniform(0.0, 6.28)
        course = 0.5 * (0.5 * time_s) ** (1 + seed % 2)
        series = 2.0 + course + 0.1 * np.cos(6.0 * angle_rad) + 0.01 * random.standard_normal(len(time_s))
        marks = PeriodMarks.of_angle(angle_rad, 2.0 * np.pi)
        assert marks is not None
        rows = np.ceil(marks.numbers - 1e-6).astype(np.int64)
        repeats = Periods(rows, "revolutions", marks=marks)
        found = mean_over_periods(repeats.told(series), repeats)
        truth = 2.0 + float(np.mean(course[: len(repeats.told(series))]))
        errors.append((found.mean - truth) / found.error.standard)
        standards.append(found.error.standard)
    white = 0.01 / np.sqrt(len(time_s))
    assert np.all(np.array(standards) < 3.0 * white)
    assert 0.5 < float(np.sqrt(np.mean(np.square(errors)))) < 1.7


def test_a_course_over_time_goes_on_behind_the_last_period() -> None:
    time_s = np.arange(20_000) / RATE_HZ
    angle_rad = 160.0 * time_s - 30.0 * time_s**2
    marks = PeriodMarks.of_angle(angle_rad, 2.0 * np.pi)
    assert marks is not None
    repeats = Periods(np.ceil(marks.numbers - 1e-6).astype(np.int64), "revolutions", marks=marks)
    drift = 0.5 * time_s
    found = mean_over_periods(repeats.told(2.0 + drift + 0.1 * np.cos(6.0 * angle_rad)), repeats)
    assert found.course is not None
    behind = slice(repeats.rows[-1], len(repeats.told(drift)))
    assert behind.stop - behind.start > 500
    course = found.course.at(repeats.places(behind.stop))
    apart = course - drift[: behind.stop]
    assert np.max(np.abs(apart[behind] - apart[0])) < 3e-3


@pytest.mark.parametrize("rows", [4150, 4210, 4390])
def test_an_incomplete_period_on_a_drift_of_few_periods(rows: int) -> None:
    """Of fewer than 16 periods a drift is no course, and all of the record counts of it."""
    number = np.arange(float(rows))
    drift, ripple = 1e-4 * number, 0.3 * np.sin(2 * np.pi * number / 400.0)
    found = mean_over_periods(drift + ripple, Periods(np.arange(0, rows, 400)))
    assert found.course is None
    assert found.mean == pytest.approx(float(np.mean(drift)), abs=2e-5)


def test_turns_begin_where_an_angle_of_any_speed_says() -> None:
    rows = np.arange(400.0)
    angle_rad = 0.3 - 2.0 * np.pi * (rows / 100.0 + (rows / 400.0) ** 2)
    marks = PeriodMarks.of_angle(angle_rad, 2.0 * np.pi)
    assert marks is not None
    assert marks.as_far is not None
    # turns x = r / 100 + (r / 400)^2
    begins = 200.0 * (np.sqrt(16.0 + 4.0 * np.arange(5.0)) - 4.0)
    assert marks.numbers == pytest.approx(begins, abs=1e-2)
    behind = float(np.interp(400.0, rows, -(angle_rad - 0.3) / (2.0 * np.pi), right=5.0)) - 4.0
    expected = 200.0 * (np.sqrt(16.0 + 4.0 * (np.arange(5.0) + behind)) - 4.0) - begins
    assert marks.as_far == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("angle_rad", [np.floor(np.arange(400.0) / 7.0), np.abs(np.arange(-90.0, 310.0))])
def test_an_angle_that_counts_or_turns_back_marks_rows_alone(angle_rad: NDArray[np.float64]) -> None:
    assert PeriodMarks.of_angle(angle_rad, 2.0 * np.pi) is None


def test_places_go_on_behind_the_last_period_at_its_pace() -> None:
    repeats = Periods(np.array([0, 4, 10, 14]))
    expected = [0.125, 0.375, 0.625, 0.875, *(1.0 + (np.arange(6) + 0.5) / 6), 2.125, 2.375, 2.625, 2.875]
    assert repeats.places(14) == pytest.approx(np.array(expected) / 3.0)
    assert repeats.places(5) == pytest.approx(np.array(expected[:5]) / 3.0)
    assert repeats.places(17)[14:] == pytest.approx(np.array([3.125, 3.375, 3.625]) / 3.0)


def test_incomplete_revolutions_move_no_mean_by_where_rows_round() -> None:
    """Orders 1 and 2 of 3.07 revolutions of four periods each, whose beginnings are between rows."""
    errors = []
    for per_period in np.linspace(59.3, 63.1, 12):
        turned = 2 * np.pi * np.arange(int(12.3 * per_period)) / per_period
        series = 0.06 * np.cos(turned / 4.0) + 0.03 * np.cos(0.5 * turned + 1.0) + 0.04 * np.cos(6.0 * turned)
        marks = per_period * np.arange(13.0)
        rows = np.ceil(marks - 1e-6).astype(np.int64)
        errors.append(
            mean_over_periods(series, Periods(rows, per_revolution=4, marks=PeriodMarks(marks))).mean
        )
    assert float(np.max(np.abs(errors))) < 3e-5  # 4e-4 by places of rounded rows


def test_rows_are_in_their_periods_where_the_marks_are() -> None:
    marks = np.array([0.0, 3.5, 8.0])
    repeats = Periods(np.array([0, 4, 8]), marks=PeriodMarks(marks))
    expected = [0.0, 1.0, 2.0, 3.0, 3.5 + 0.5 * 3.5 / 4.5]
    assert repeats.places(5) == pytest.approx(np.array(expected) / 7.0)
    assert repeats.places(10)[8:] == pytest.approx(1.0 + np.array([0.0, 1.0]) / 9.0)


def test_a_period_that_ends_between_the_last_two_rows_leaves_no_part_of_one() -> None:
    """Of 22.01 periods 22 are behind each other, and nine tenths of a row."""
    for phase in np.linspace(0.0, 6.0, 9):
        series = 0.1 * np.cos(2 * np.pi * 3 * np.arange(2042) / 92.777 + phase)
        marks = 92.777 * np.arange(22.0)  # the 22nd ends behind the last row
        rows = np.ceil(marks - 1e-6).astype(np.int64)
        found = mean_over_periods(series, Periods(rows, marks=PeriodMarks(marks)))
        assert abs(found.mean) < 2e-6  # 4e-5 with the part


def test_what_is_more_than_a_period_behind_the_last_mark_is_not_told() -> None:
    repeats = Periods(np.array([0, 10, 20]))
    for count, told in ((20, 20), (29, 29), (31, 31), (32, 20), (39, 20)):
        assert len(repeats.told(np.zeros(count))) == told


def test_means_without_an_angle_are_over_periods_whose_phase_is_told() -> None:
    """Where a speed swings within six periods, what its phase is behind the last whole one is a guess."""
    found = []
    for seed in range(3):
        random = np.random.default_rng(seed)
        time_s = np.arange(4 * 22_890) / (4.0 * RATE_HZ)
        swing = 0.08 * np.sin(2 * np.pi * 2.2 * time_s + random.uniform(0, 2 * np.pi))
        theta = 2 * np.pi * 14.0 * time_s + swing + random.uniform(0, 2 * np.pi)
        torque = 2.0 + 0.1 * np.cos(6 * theta) + 0.05 * np.cos(3 * theta)
        torque += 1e-3 * random.standard_normal(len(theta))
        current = 5.0 * np.cos(theta[::4]) + 5e-3 * random.standard_normal(len(theta[::4]))
        block = Block.from_arrays(RATE_HZ, {"i_a": "A", "torque": "Nm"}, i_a=current, torque=torque[::4])
        shaft = Block.from_arrays(4.0 * RATE_HZ, {"torque_transducer": "Nm"}, torque_transducer=torque)
        numbers = analyze_steady_state(block, pole_pairs=4, torque_rated_Nm=2.0, transducer=shaft)
        found.append([each for each in numbers.measurements if each.name.endswith("torque_mean")])
    for means in zip(*found, strict=True):
        standard = np.array([each.uncertainty.standard for each in means if each.uncertainty])
        error = np.array([each.value - 2.0 for each in means])
        assert np.sqrt(np.mean(np.square(error / standard))) < 1.6, means[0].name
        assert np.median(standard) < 1.5e-5


def test_rows_behind_periods_that_are_told_count_by_the_course() -> None:
    """The phase ends 1.6 of 25.6 periods before a drift does, which goes on."""
    random, number = np.random.default_rng(4), np.arange(2560.0)
    marks = PeriodMarks(100.0 * np.arange(25.0))
    repeats = Periods(np.arange(0, 2401, 100), marks=marks)
    drift = 3.0 * (number / len(number) - 0.5)
    series = 150.0 + drift + 0.3 * np.cos(2 * np.pi * number / 50.0) + 0.1 * random.standard_normal(2560)
    found = scatter_of_periods(series, repeats)
    assert found is not None
    assert found.mean.standard < 5e-3
    assert found.whole_mean == pytest.approx(150.0 + float(np.mean(drift)), abs=3.0 * found.mean.standard)
    rms = math.sqrt(float(np.var(drift)) + 0.5 * 0.3**2 + 0.1**2)
    assert found.whole_rms == pytest.approx(rms, abs=3.0 * found.rms.standard)
    assert found.rms.standard < 0.02 * rms


def test_the_mean_of_a_torque_moves_with_the_slow_noise_of_its_reference() -> None:
    """What the torque does beside it is quick, and tells another density; a signal that follows nothing is as
    without a reference."""
    random, rows, periods = np.random.default_rng(5), 36 * 20, 36
    repeats = Periods(np.arange(0, rows + 1, 20))
    alone, known = [], []
    for _ in range(20):
        reference = coloured(random.standard_normal(rows + 4000), 0.98)[4000:]
        quick = 40.0 * np.diff(random.standard_normal(rows + 1)) * float(np.std(reference))
        torque = 100.0 + reference + quick
        without = mean_over_periods(torque, repeats, may_fall=True)
        alone.append(without.error.standard)
        known.append(mean_over_periods(torque, repeats, may_fall=True, reference=reference).error.standard)
        other = float(np.std(torque)) * coloured(random.standard_normal(rows + 4000), 0.98)[4000:]
        untold = mean_over_periods(torque, repeats, may_fall=True, reference=other).error
        assert untold == without.error
    assert len(repeats) == periods
    assert np.median(np.array(known) / np.array(alone)) > 1.5


def test_whole_revolutions_have_the_time_of_what_the_speed_does_in_them() -> None:
    """The speed swings with the load, so that a sinusoid over the angle has a mean over time."""
    random, ratios = np.random.default_rng(21), []
    for _ in range(8):
        steady = 2.0 * np.pi * (random.uniform(17.0, 25.0) * np.arange(10_000) / RATE_HZ + random.uniform())
        late, theta = random.uniform(0.0, 2.0 * np.pi), np.asarray(steady, dtype=np.float64)
        for _ in range(30):
            theta = np.asarray(steady - 0.05 * np.sin(theta + late), dtype=np.float64)
        series = 2.0 + 0.8 * np.cos(theta) + 0.01 * random.standard_normal(len(theta))
        marks = PeriodMarks.of_angle(theta, 2.0 * np.pi / 3.0)
        assert marks is not None
        repeats = Periods(np.ceil(marks.numbers - 1e-6).astype(np.int64), "periods", 3, marks)
        found = mean_over_periods(series, repeats, by_revolutions=True)
        # of time a revolution has 1 + 0.05 cos(theta + late) at theta
        ratios.append((found.mean - 2.0 - 0.8 * 0.5 * 0.05 * math.cos(late)) / found.error.standard)
    assert math.sqrt(float(np.mean(np.square(ratios)))) < 1.4


def test_a_drift_that_few_revolutions_do_not_tell_is_told_by_their_periods() -> None:
    """Of fourteen revolutions, as slow noise, it would make the mean 200 times as uncertain."""
    random, rows = np.random.default_rng(22), 21_300
    place = np.arange(rows) / rows
    theta = 2.0 * np.pi * 14.2 * place
    series = 1.8 + 0.1 * (place - 0.5) + 0.03 * np.cos(theta) + 0.004 * random.standard_normal(rows)
    marks = PeriodMarks.of_angle(theta, 2.0 * np.pi / 3.0)
    assert marks is not None
    repeats = Periods(np.ceil(marks.numbers - 1e-6).astype(np.int64), "periods", 3, marks)
    found = mean_over_periods(series, repeats, by_revolutions=True)
    assert found.error.standard < 1e-3
    assert abs(found.mean - 1.8) < 3.0 * found.error.standard


@pytest.mark.parametrize("per_revolution", [2, 3])
def test_a_period_that_ends_behind_the_last_row_is_part_of_a_revolution(per_revolution: int) -> None:
    """Without it, the mean is off by half a wave in 43 periods, 4e-4."""
    count, periods = 16_000, 43.0016
    turns = periods * np.arange(count) / count
    track = PhaseTrack(Polynomial([0.4, 2 * np.pi * periods / count]), count, "made")
    series = 0.03 * np.cos(2 * np.pi * turns / per_revolution + 0.5 * np.pi)
    repeats = Periods.of(PeriodMarks.of(track), per_revolution)
    assert len(repeats) == 42
    assert abs(float(np.mean(series))) > 3e-4
    found = mean_over_periods(series, repeats, by_revolutions=True)
    assert abs(found.mean) < 1e-6


@pytest.mark.parametrize("is_told", [True, False])
@pytest.mark.parametrize("cycles_per_period", [4.5, 2.25, 4.0 / 3.0, 2.347])
def test_lines_between_harmonics_of_the_period_are_no_noise(cycles_per_period: float, is_told: bool) -> None:
    """Their mean over each period is another, and so is that of as much as the incomplete one has: cogging of
    some times in a revolution, which may be told, or hum."""
    count, periods = 20_000, 30.3
    turns = periods * np.arange(count) / count
    noise = 1e-4 * np.random.default_rng(3).standard_normal(count)
    line = 0.03 * np.cos(2 * np.pi * cycles_per_period * turns + 0.7)
    marks = PeriodMarks(np.arange(31) * count / periods)
    rows = np.ceil(marks.numbers - 1e-9).astype(np.int64)
    repeats = Periods(rows, per_revolution=12 if is_told else 1, marks=marks)
    found, alone = (mean_over_periods(1.0 + each, repeats) for each in (line + noise, noise))
    assert found.mean == pytest.approx(alone.mean, abs=3e-7)
    assert found.error.standard == pytest.approx(alone.error.standard, rel=0.2)


def test_the_rms_of_a_record_with_little_slow_noise_by_chance_is_as_uncertain() -> None:
    """Noise that remembers four of thirty periods; by the scatter of its square alone, error / u was 2.2."""
    repeats = Periods(np.arange(0, 1921, 64))
    ripple = 0.1 * np.cos(2 * np.pi * 6 * np.arange(1920) / 64)
    relative = []
    for seed in range(80):
        random = np.random.default_rng(seed)
        slowly = 0.02 * coloured(random.standard_normal(1920), math.exp(-1 / 256))
        noise = 1e-3 * random.standard_normal(1920)
        found = scatter_of_periods(ripple + slowly + noise, repeats, percentiles=False)
        assert found is not None
        if math.isfinite(found.mean.standard) and math.isfinite(found.rms.standard):
            standard = math.hypot(found.rms.standard, found.mean.standard**2 / (2 * found.whole_rms))
            relative.append((found.whole_rms - math.sqrt(0.005 + 0.02**2)) / standard)
    assert len(relative) > 60
    assert math.sqrt(np.mean(np.square(relative))) < 1.4
