"""Orders on an angle that wobbles, of few revolutions and of a signal that is clipped or stood still."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.orders.angle import TURN, angle_coverage
from benchtool.analysis.orders.order_spectrum import fitted_orders, resampled_orders
from benchtool.analysis.orders.orders import order_analysis
from benchtool.analysis.orders.wobble import repeated_wobble_rad
from benchtool.errors import AnalysisError
from tests.at_length import at_length
from tests.unit.analysis.orders.cogging_torque import COGGING, block_of, steady, torque_at


def test_sidebands_of_a_wobble_are_in_the_uncertainty_of_the_orders_beside() -> None:
    """A rotor that moves a little, read along its smooth track."""
    theta_m, size = steady(8.3), 1e-3
    moved = theta_m + size * np.sin(theta_m)
    torque = torque_at(moved) + np.random.default_rng(3).normal(0.0, 1e-4, len(theta_m))
    block = block_of(np.mod(moved, TURN), torque)

    spectrum = resampled_orders(block, "torque")

    sideband = 72 * 0.2 * size / 2
    for order in (71, 73):
        assert spectrum.amplitude[order - 1] == pytest.approx(sideband, rel=0.3)
        assert 0.7 < spectrum.standard[order - 1] / sideband < 2.5
        assert spectrum.amplitude[order - 1] < spectrum.stands_out_above[order - 1]
    assert spectrum.standard[35] < 0.03 * sideband
    told = order_analysis(block, "torque").spectrum  # along the angle there are none
    assert np.all(told.amplitude[[70, 72]] < 0.03 * sideband)


@pytest.mark.parametrize("revolutions", [4.6, *at_length(3.4, 7.6)])
def test_few_revolutions_count_by_the_deviation_of_students_distribution(revolutions: float) -> None:
    relative = []
    for seed in range(30):
        random = np.random.default_rng(seed)
        steps = np.cumsum(random.uniform(0.2, 1.8, 4_000))
        angle = steps / steps[-1] * TURN * revolutions
        values = torque_at(angle) + random.normal(0.0, 0.1, len(angle))
        spectrum = fitted_orders(angle_coverage(angle), values, "torque", "Nm")
        expected = {order: amplitude for order, (amplitude, _) in COGGING.items() if order != 1}
        relative += [
            (spectrum.amplitude[order - 1] - amplitude) / spectrum.uncertainty(order).standard
            for order, amplitude in expected.items()
        ]
    # the share, as squares of few degrees of freedom have tails that 90 of them do not tell
    assert np.mean(np.abs(relative) < 2.0) > 0.9
    assert 0.6 < np.mean(np.abs(relative) < 1.0) < 0.85


def test_orders_of_a_clipped_signal_are_refused() -> None:
    theta_m = steady(8.0)
    noise = np.random.default_rng(4).normal(0.0, 0.01, len(theta_m))

    with pytest.raises(AnalysisError, match="clipped"):
        order_analysis(block_of(theta_m, np.minimum(torque_at(theta_m) + noise, 0.75)), "torque")


def test_orders_of_a_signal_that_stood_still_are_refused() -> None:
    """The mean and the ripple of that torque were, and its orders were small and certain."""
    theta_m = steady(8.0)
    torque = torque_at(theta_m) + np.random.default_rng(4).normal(0.0, 0.01, len(theta_m))
    torque[len(torque) // 3 :] = torque[len(torque) // 3]
    with pytest.raises(AnalysisError, match=r"^'torque': \d+ samples in a row .* stood still"):
        order_analysis(block_of(theta_m, torque), "torque")


@pytest.mark.parametrize("wobble_rad", [1e-3, 3e-3])
@pytest.mark.parametrize("of_rotor", [False, True])
def test_orders_tell_whose_wobble_it_is(wobble_rad: float, of_rotor: bool) -> None:
    """Along the wrong angle order 72 would read low by 0.3 % and 2.3 %."""
    random, even = np.random.default_rng(3), steady(20.3)
    wobbles = even + math.sqrt(2.0) * wobble_rad * np.sin(2.0 * even + 1.0)
    torque = torque_at(wobbles if of_rotor else even) + 1e-3 * random.standard_normal(len(even))
    spectrum = order_analysis(block_of(np.mod(wobbles, TURN), torque), "torque").spectrum
    assert abs(spectrum.amplitude[71] - 0.2) < 3.0 * spectrum.standard[71]
    assert spectrum.standard[71] < 1e-4
    assert ("least squares" in spectrum.method) is of_rotor


def test_an_order_that_loses_a_fifth_tells_all_of_a_wobble() -> None:
    """By its mean square the wobble would take 5 % less off, which was left as doubt."""
    even = steady(25.2)
    theta_m = even + 0.05 * np.sin(even + 1.0)
    torque = 2.0 + 0.8 * np.cos(theta_m) + 0.05 * np.cos(18.0 * theta_m)
    torque += 1e-3 * np.random.default_rng(6).standard_normal(len(even))
    spectrum = order_analysis(block_of(np.mod(theta_m, TURN), torque), "torque").spectrum
    assert abs(spectrum.amplitude[0] - 0.8) < 3.0 * spectrum.standard[0]
    assert spectrum.standard[0] < 4.5e-5  # 6.9e-5 with that


def test_a_course_that_no_revolution_repeats_is_no_wobble_of_a_sensor() -> None:
    even = steady(25.2)
    settles = even - 0.3 * np.exp(-np.arange(len(even)) / (0.15 * len(even)))
    spectrum = order_analysis(block_of(np.mod(settles, TURN), torque_at(settles)), "torque").spectrum
    assert spectrum.amplitude[71] == pytest.approx(0.2, rel=1e-6)
    assert spectrum.standard[71] < 2e-5  # 2e-3 by deviations of each revolution alike


def test_of_a_rotor_that_reversed_the_sensor_errs_as_on_the_longer_way() -> None:
    """Its order 72 reads low by a quarter of (72 e)^2 where the encoder errs by e once in a revolution."""
    there = steady(14.0)
    true = np.concatenate([there, there[-1] - (there[1:6000] - there[0])])
    read = np.mod(true + 4e-3 * np.sin(true + 0.7), TURN)
    found = order_analysis(block_of(read, torque_at(true)), "torque", orders=[72]).measurements
    number = next(each for each in found if each.name == "torque_order_72")
    assert number.uncertainty is not None
    off = abs(number.value - COGGING[72][0])
    assert off == pytest.approx(0.2 * (72 * 4e-3) ** 2 / 4.0, rel=0.1)
    assert 0.5 < off / number.uncertainty.standard < 1.5


def test_a_wobble_that_is_partly_the_rotor_s_leaves_its_sidebands_in_the_uncertainty() -> None:
    """The rotor moves by a fifth of what the encoder's disc errs; its sidebands of order 20 are no orders."""
    random, even, relative = np.random.default_rng(9), steady(12.3), []
    for begin in np.arange(8) * TURN / 8:
        true = even + 1e-3 * np.sin(even)
        read = true + 5e-3 * np.sin(even + begin)
        values = np.cos(20.0 * true) + 0.3 * np.cos(50.0 * true) + 1e-3 * random.standard_normal(len(even))
        spectrum = order_analysis(block_of(np.mod(read, TURN), values), "torque").spectrum
        relative += [spectrum.amplitude[k - 1] / spectrum.uncertainty(k).standard for k in (19, 21, 49, 51)]
    assert np.median(relative) < 3.0


@pytest.mark.parametrize("counts", [60, 100, 4096])
def test_a_wobble_shows_in_an_angle_of_few_counts(counts: int) -> None:
    track = TURN * 25.3 * np.arange(10_000) / 10_000
    moved = track + 0.01 * np.sin(track) + 0.004 * np.sin(3.0 * track)
    angle = np.floor(moved * counts / TURN) * TURN / counts
    found = repeated_wobble_rad(angle, angle - track)
    assert found[[0, 2]] == pytest.approx([0.01, 0.004], rel=0.15)
    assert found[1] < 1e-3


def test_a_rotor_that_wobbles_within_the_counts_of_its_angle_has_that_in_the_uncertainty() -> None:
    errors = []
    for seed in range(6):
        random = np.random.default_rng(seed)
        track = TURN * 12.65 * np.arange(10_000) / 5_000.0 + random.uniform(0.0, TURN)
        theta_m = track + 0.01 * np.sin(track + 0.2) + 0.001 * np.sin(2.0 * track + 1.0)
        torque = 3.0 + 0.15 * np.cos(theta_m) + 0.1 * np.cos(2.0 * theta_m + 1.0)
        torque += random.normal(0.0, 0.02, len(torque))
        counted = np.floor(theta_m * 60 / TURN) * TURN / 60
        found = order_analysis(block_of(np.mod(counted, TURN), torque), "torque", orders=[1, 2])
        for each in found.measurements:
            truth = {"torque_order_1": 0.15, "torque_order_2": 0.1}.get(each.name)
            if truth is not None:
                assert each.uncertainty is not None
                errors.append((each.value - truth) / each.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.2
