"""Orders per mechanical revolution: by time, by angle, and two ways that share no code."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.analysis.orders.angle import (
    TURN,
    angle_coverage,
    between_updates,
    least_step_rad,
    unwrapped_angle,
)
from benchtool.analysis.orders.angle_orders import fit_orders, sector_means
from benchtool.analysis.orders.order_spectrum import OrderSpectrum, resampled_orders
from benchtool.analysis.orders.orders import describe_orders, order_analysis
from benchtool.block import Block, Gap
from benchtool.errors import AnalysisError
from tests.unit.analysis.orders.cogging_torque import (
    COGGING,
    Array,
    block_of,
    fitted,
    steady,
    torque_at,
    uneven_angle,
)


def _experimental(spectrum: OrderSpectrum) -> list[float]:
    return [spectrum.uncertainty(int(order)).experimental for order in spectrum.order]


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("wrapped", [False, True])
def test_samples_at_any_times_give_the_true_amplitudes(backwards: bool, wrapped: bool) -> None:
    angle = uneven_angle(7.3, 9_000) * (-1 if backwards else 1)

    spectrum = fitted(np.mod(angle, TURN) if wrapped else angle, torque_at(angle))

    assert len(spectrum.order) == 200
    truth = np.zeros(200)
    for order, (amplitude, _) in COGGING.items():
        truth[order - 1] = amplitude
    np.testing.assert_allclose(spectrum.amplitude, truth, atol=1e-9)
    assert spectrum.mean == pytest.approx(0.65)
    assert list(spectrum.largest[:4]) == [72, 18, 12, 1]


def test_least_squares_and_the_transform_of_sector_means_agree() -> None:
    angle = uneven_angle(40.0, 80_000)
    values = torque_at(angle) + 0.02 * np.random.default_rng(3).normal(size=len(angle))
    sectors = 1440

    mean, revolutions = sector_means(angle_coverage(angle), values, sectors)
    transformed = 2 / sectors * np.abs(np.fft.rfft(mean))[1:101]
    transformed /= np.sinc(np.arange(1, 101) / sectors)  # a sector averages over its width
    spectrum = fitted(angle, values)

    assert revolutions.min() > 20
    np.testing.assert_allclose(transformed, spectrum.amplitude[:100], atol=6 * 1e-4)
    for order, (amplitude, _) in COGGING.items():
        assert transformed[order - 1] == pytest.approx(amplitude, abs=1e-3)


def test_resampling_by_time_and_fitting_by_angle_agree_in_steady_state() -> None:
    theta_m = steady(12.4)
    values = torque_at(theta_m) + 0.05 * np.random.default_rng(4).normal(size=len(theta_m))

    by_time = resampled_orders(block_of(np.mod(theta_m, TURN), values), "torque")
    by_angle = fitted(theta_m, values)

    assert by_time.revolutions == 12
    assert by_time.basis.sample_rate_Hz == pytest.approx(10e3)
    largest = list(COGGING)
    np.testing.assert_array_equal(by_time.largest[:4], largest)
    difference = np.abs(by_time.amplitude - by_angle.amplitude)
    assert np.all(difference < 6 * np.hypot(by_time.standard, by_angle.standard))
    # white noise of 0.05 over 20 000 samples: sqrt(2 / n) x 0.05 = 0.5 mNm in an amplitude
    # the larger of two estimates counts, which for white noise is a tenth too wide
    assert np.median(_experimental(by_time)) == pytest.approx(5e-4, rel=0.2)
    assert np.median(_experimental(by_angle)) == pytest.approx(5e-4, rel=0.1)


def test_the_uncertainty_is_the_scatter_over_revolutions() -> None:
    """With even coverage it is the standard error of each revolution's own Fourier coefficient."""
    revolutions, per_revolution = 24, 900
    angle = TURN * (np.arange(revolutions * per_revolution) + 0.5) / per_revolution
    gain = 1.0 + 0.2 * np.random.default_rng(5).normal(size=revolutions)
    values = np.repeat(gain, per_revolution) * np.cos(6 * angle)

    fit = fit_orders(angle_coverage(angle), values, 100)

    standard = float(np.std(gain, ddof=1) / math.sqrt(revolutions))
    assert fit.standard[5] == pytest.approx(standard, rel=0.02)
    assert "24 revolutions" in fit.uncertainty_source
    assert 2 * abs(fit.coefficient[5]) == pytest.approx(np.mean(gain), rel=1e-3)


def test_the_stated_uncertainty_covers_the_truth() -> None:
    errors = []
    for seed in range(60):
        angle = uneven_angle(12.0, 1_200, seed)
        values = np.cos(6 * angle) + 0.1 * np.random.default_rng(100 + seed).normal(size=len(angle))
        fit = fit_orders(angle_coverage(angle), values, 12)
        errors.append((2 * abs(fit.coefficient[5]) - 1.0) / fit.standard[5])
    assert 0.7 < float(np.sqrt(np.mean(np.square(errors)))) < 1.5


def test_a_rotor_that_stands_still_counts_once() -> None:
    """Thousands of samples at one angle, with another torque, must not pull at the fit."""
    angle = uneven_angle(10.0, 10_000)
    waiting = np.full(20_000, angle[0])
    values = np.concatenate([np.full(20_000, 5.0), torque_at(angle)])

    spectrum = fitted(np.concatenate([waiting, angle]), values)

    assert spectrum.amplitude[71] == pytest.approx(0.2, abs=0.005)
    assert spectrum.mean == pytest.approx(0.65, abs=0.005)


def test_each_degree_of_each_revolution_counts_the_same() -> None:
    """Against a dense least-squares solution with weights counted one by one: what no order explains (a
    jump) shows how samples are weighted."""
    source = np.random.default_rng(12)
    angle = 0.3 + np.sort(TURN * 5.5 * source.uniform(size=6_000) ** 1.5)
    values = np.where(np.mod(angle, TURN) < 1.0, 2.0, 0.5) + 0.1 * source.normal(size=len(angle))
    coverage = angle_coverage(angle)
    cells = [
        (math.floor((each - angle.min()) / TURN), math.floor(math.degrees(each) % 360.0)) for each in angle
    ]
    visits = Counter(cells)
    weight = np.sqrt([1.0 / visits[cell] for cell in cells])
    orders = np.arange(1, 9)[:, np.newaxis]
    columns = np.vstack([np.ones(len(angle)), np.cos(orders * angle), np.sin(orders * angle)])

    expected = np.linalg.lstsq((columns * weight).T, values * weight)[0]
    fit = fit_orders(coverage, values, 8)

    assert fit.mean == pytest.approx(expected[0], abs=1e-9)
    np.testing.assert_allclose(2.0 * fit.coefficient, expected[1:9] - 1j * expected[9:], atol=1e-9)


def test_an_angle_that_trembles_and_turns_back_gives_the_same() -> None:
    angle = uneven_angle(9.6, 20_000) + 0.05 * np.random.default_rng(8).normal(size=20_000)
    assert np.any(np.diff(angle) < 0)

    spectrum = fitted(np.mod(angle, TURN), torque_at(angle))

    for order, (amplitude, _) in COGGING.items():
        assert spectrum.amplitude[order - 1] == pytest.approx(amplitude, abs=1e-9)


def test_a_coarse_angle_limits_the_order_and_keeps_the_amplitude() -> None:
    steps = 1024
    angle = uneven_angle(20.0, 40_000)
    counted = np.floor(angle / TURN * steps) * TURN / steps

    spectrum = fitted(counted, torque_at(angle))

    assert len(spectrum.order) == steps // 10
    assert spectrum.amplitude[71] == pytest.approx(0.2, rel=5e-3)
    assert "angle in steps of 0.352 degrees" in spectrum.method


@pytest.mark.parametrize(("per_revolution", "highest"), [(50, 22), (160, 72), (101, 45)])
def test_samples_per_revolution_limit_the_order(per_revolution: int, highest: int) -> None:
    """At equal places in each revolution, order N - k reads as order k: such orders are not given."""
    angle = TURN * np.arange(30 * per_revolution) / per_revolution + 1e-4
    hidden = per_revolution - 7

    spectrum = fitted(angle, 0.1 * np.cos(hidden * angle))

    assert len(spectrum.order) == highest
    assert spectrum.amplitude[6] == pytest.approx(0.1, rel=1e-6)  # the alias that the definition warns of
    assert "are not excluded" in describe_orders(spectrum, "torque").tables[0].definition


def test_other_places_in_each_revolution_tell_aliases_apart() -> None:
    angle = TURN / 50.37 * np.arange(4_000, dtype=np.float64)
    spectrum = fitted(angle, 0.1 * np.cos(43 * angle))
    assert spectrum.largest[0] == 43
    assert spectrum.amplitude[6] < 1e-6


def test_an_arc_without_samples_lowers_the_order_or_is_refused() -> None:
    angle = uneven_angle(20.0, 40_000)
    place = np.mod(angle, TURN)

    narrow = place > math.radians(5.0)
    spectrum = fitted(angle[narrow], torque_at(angle[narrow]))
    assert len(spectrum.order) <= 32
    assert "largest arc without a sample 5" in spectrum.method

    wide = place > math.radians(200.0)
    with pytest.raises(AnalysisError, match=r"leave out an arc of 200 degrees"):
        fitted(angle[wide], torque_at(angle[wide]))


def test_sectors_without_a_sample_have_no_mean() -> None:
    angle = uneven_angle(20.0, 40_000)
    kept = np.mod(angle, TURN) > TURN / 4

    mean, revolutions = sector_means(angle_coverage(angle[kept]), torque_at(angle[kept]), 8)

    assert np.isnan(mean[:2]).all()
    assert np.isfinite(mean[2:]).all()
    assert list(revolutions[:2]) == [0, 0]


@given(
    gain=st.floats(0.01, 100.0),
    offset=st.floats(-10.0, 10.0),
    shift=st.floats(-100.0, 100.0),
    backwards=st.booleans(),
)
@settings(max_examples=25, deadline=None)
def test_amplitudes_scale_and_know_no_offset_and_no_direction(
    gain: float, offset: float, shift: float, backwards: bool
) -> None:
    angle = uneven_angle(3.2, 800)
    values = np.cos(angle) + 0.3 * np.sin(12 * angle)

    moved = angle_coverage((-angle if backwards else angle) + shift)
    fit = fit_orders(moved, gain * values + offset, 20)

    assert len(fit.coefficient) == 20
    truth = np.zeros(20)
    truth[[0, 11]] = gain, 0.3 * gain
    np.testing.assert_allclose(2 * np.abs(fit.coefficient), truth, atol=1e-9 * (gain + abs(offset)))


def test_rows_that_are_missing_where_the_angle_starts_over_are_no_other_unit() -> None:
    """Of two turns, and an arc of 60 degrees elsewhere, where rows are missing as well."""
    angle = np.mod(np.linspace(0.0, 2.3 * 2.0 * np.pi, 160), 2.0 * np.pi)
    kept = angle[(angle < 5.3) & ((angle < 2.0) | (angle > 3.05))]
    turned = unwrapped_angle(kept)
    assert np.all(np.diff(turned) > 0.0)
    assert np.ptp(turned) == pytest.approx(2.3 * 2.0 * np.pi, abs=0.1)


@pytest.mark.parametrize(
    ("angle", "complaint"),
    [
        (np.linspace(0.0, 6.0, 500), "covers 0.955 mechanical revolutions, at least one"),
        (np.mod(np.linspace(0.0, 3600.0, 5000), 360.0), "starts over at about 36"),
        (np.mod(np.linspace(0.0, 3600.0, 1200), 360.0), "starts over at about 36"),
        (np.mod(np.linspace(0.0, 10.0, 5000), 1.0), "starts over at about 1"),
        (np.mod(np.linspace(0.0, 40960.0, 5000), 4096.0), "starts over at about 4.1"),
        (np.full(100, 3.0), "constant"),
        (np.array([0.0, math.nan, 7.0]), "not finite"),
    ],
)
def test_an_angle_that_answers_nothing_is_refused(angle: Array, complaint: str) -> None:
    with pytest.raises(AnalysisError, match=complaint):
        angle_coverage(angle)


def test_an_angle_that_starts_over_at_several_turns_is_unwrapped_there() -> None:
    angle = uneven_angle(20.0, 10_000)
    coverage = angle_coverage(np.mod(angle, 2 * TURN))
    assert coverage.revolutions == pytest.approx(20.0, abs=0.01)


def test_few_samples_per_revolution_of_a_counting_angle_are_not_unwrapped() -> None:
    angle = 5.2 * np.arange(300, dtype=np.float64)  # nearly a revolution from sample to sample
    assert angle_coverage(angle).revolutions == pytest.approx(299 * 5.2 / TURN)


def test_a_capture_in_steady_state_is_resampled_by_time() -> None:
    theta_m = steady(6.2)

    orders = order_analysis(block_of(np.mod(theta_m, TURN), torque_at(theta_m)), "torque")

    names = [each.name for each in orders.measurements]
    assert names[:2] == ["torque_order_largest", "torque_order_largest_amplitude"]
    assert names[2:5] == ["torque_order_72", "torque_order_18", "torque_order_12"]
    for each in orders.measurements[1:]:
        assert each.uncertainty is not None
        assert each.value > 4.5 * each.uncertainty.standard
    assert orders.measurements[0].value == 72
    for each in orders.measurements[1:3]:
        assert each.value == pytest.approx(0.2, rel=1e-4)
        assert "DFT over 6 whole revolutions" in each.definition
    (table,) = orders.tables
    assert table.name == "torque_orders"
    row = table.rows[71]
    assert row[:4] == pytest.approx((72, 0.2, 100 * 0.2 / 0.65, 100.0), rel=1e-4)


@pytest.mark.parametrize("what", ["gap", "speed", "wobble"])
def test_what_is_not_steady_is_fitted_by_angle(what: str) -> None:
    theta_m = steady(8.0)
    gaps: tuple[Gap, ...] = ()
    if what == "gap":
        theta_m, gaps = np.delete(theta_m, np.s_[5000:5300]), (Gap(5000, 300),)
    elif what == "speed":
        theta_m = TURN * 8.0 * np.linspace(0.0, 1.0, 20_000) ** 2
    else:
        theta_m = theta_m + 0.02 * np.sin(theta_m)

    orders = order_analysis(block_of(np.mod(theta_m, TURN), torque_at(theta_m), gaps=gaps), "torque")

    assert "least squares" in orders.spectrum.method
    assert orders.spectrum.amplitude[71] == pytest.approx(0.2, rel=1e-6)
    assert orders.spectrum.basis.gaps == len(gaps)
    # 8 revolutions in 2 s
    assert orders.spectrum.basis.frequency_Hz == pytest.approx(4.0, rel=1e-3)  # 8 revolutions in 2 s


def test_less_than_two_revolutions_of_a_capture_are_refused() -> None:
    theta_m = steady(1.9)
    with pytest.raises(AnalysisError, match=r"covers 1\.90 mechanical revolutions, at least 2"):
        order_analysis(block_of(theta_m, torque_at(theta_m)), "torque")


def test_a_mean_of_zero_has_no_percent() -> None:
    theta_m = steady(6.2)
    orders = order_analysis(block_of(theta_m, torque_at(theta_m, mean=0.0)), "torque")
    assert math.isnan(orders.tables[0].rows[71][2])
    assert orders.tables[0].rows[17][3] == pytest.approx(20.0, rel=1e-3)


@pytest.mark.parametrize("rows", [2, 10, 13])
@pytest.mark.parametrize("counts", [None, 1024])
def test_an_angle_that_a_slow_bus_updates_is_followed_between_updates(rows: int, counts: int | None) -> None:
    angle = steady(20.3)
    read = angle if counts is None else np.round(angle * counts / TURN) * TURN / counts
    held = np.repeat(read[::rows], rows)[: len(angle)]
    held = np.append(held, np.full(len(angle) - len(held), held[-1]))
    torque = torque_at(angle) + 1e-3 * np.random.default_rng(rows).standard_normal(len(angle))
    found = order_analysis(block_of(np.mod(held, TURN), torque), "torque", orders=[12, 18, 72]).measurements
    for order in (12, 18, 72):
        (own,) = (each for each in found if each.name == f"torque_order_{order}")
        assert own.uncertainty is not None
        # sinc(72 x 13 rows / turn) would take off 2 mNm
        assert own.value == pytest.approx(COGGING[order][0], abs=3.0 * own.uncertainty.standard)
        assert own.uncertainty.standard < 1e-4


@pytest.mark.parametrize("rows", [1, 3])
def test_an_angle_that_counts_in_steps_is_left_as_it_is(rows: int) -> None:
    counted = np.floor(steady(20.3, 6_000 * rows) * 512 / TURN) * TURN / 512
    times = np.arange(len(counted), dtype=np.float64)
    assert between_updates(counted, times) is counted
    assert least_step_rad(np.mod(counted, TURN)) == pytest.approx(TURN / 512)


@pytest.mark.parametrize("seed", range(3))
def test_counts_that_keep_step_with_the_rows_fold_no_order_of_a_recording_with_gaps(seed: int) -> None:
    """Of 1024 counts in 1000 rows the steps are an error of order 24, which folds order 48 onto 24: it was
    three to ten uncertainties off."""
    rng = np.random.default_rng(seed)
    rows, counts = np.arange(15_600), 1024
    turned = rows / 1000.0 + rng.random()
    torque = 1.0 + 0.05 * np.cos(2.0 * np.pi * 24.0 * turned + 6.0 * rng.random())
    torque += 5e-4 * rng.standard_normal(len(rows))
    angle = np.mod(np.floor(turned * counts) * 2.0 * np.pi / counts, 2.0 * np.pi)
    whole = Block.from_arrays(8000.0, {"torque": "Nm", "theta_m": "rad"}, torque=torque, theta_m=angle)
    lost = np.zeros(len(rows), dtype=np.bool_)
    for begin in rng.integers(500, 15_000, 6):
        lost[begin : begin + 30] = True
    found = order_analysis(whole.without(lost), "torque", orders=(24,))
    (order,) = (each for each in found.measurements if each.name == "torque_order_24")
    assert order.uncertainty is not None
    assert abs(order.value - 0.05) < 3.0 * order.uncertainty.standard < 2e-4


def test_counts_of_a_speed_that_keep_step_with_the_rows_are_in_the_uncertainty() -> None:
    """A host made the speed of the angle, 500 rows to a revolution: order 6 was seven uncertainties off."""
    rate_Hz, turn_rate_rad_s, count_rad, relative = 5000.0, 20.0 * math.pi, TURN / 65_536, []
    time_s = np.arange(5000) / rate_Hz
    for seed in range(12):
        theta = turn_rate_rad_s * time_s + np.random.default_rng(seed).uniform(0.0, TURN)
        theta += 0.02 / 6.0 * np.sin(6.0 * turn_rate_rad_s * time_s)
        read = np.floor(theta / count_rad) * count_rad
        omega = np.gradient(read) * rate_Hz
        units = {"theta_m": "rad", "omega_m": "rad/s"}
        block = Block.from_arrays(rate_Hz, units, theta_m=np.mod(read, TURN), omega_m=omega)
        found = order_analysis(block, "omega_m", "speed", pole_pairs=4, orders=(6,)).measurements
        order = next(each for each in found if each.name == "speed_order_6")
        truth = 0.02 * turn_rate_rad_s * np.sinc(6.0 * 2.0 / 500.0)
        assert order.uncertainty is not None
        relative.append((order.value - truth) / order.uncertainty.standard)
    assert 0.5 < math.sqrt(float(np.mean(np.square(relative)))) < 1.4
