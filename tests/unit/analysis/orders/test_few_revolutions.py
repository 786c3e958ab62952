"""Orders by angle in few revolutions, or of few rows: their uncertainty is the noise between them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.coverage.noise import coloured
from benchtool.analysis.orders.angle import TURN, angle_coverage
from benchtool.analysis.orders.angle_orders import fit_orders
from benchtool.analysis.orders.order_spectrum import orders_at_speed
from benchtool.analysis.orders.orders import describe_orders, order_analysis
from benchtool.block import Block
from tests.at_length import at_length
from tests.unit.analysis.orders.cogging_torque import fitted, torque_at, uneven_angle


def test_with_few_revolutions_the_uncertainty_is_that_of_white_noise() -> None:
    angle = uneven_angle(2.0, 5_000)
    values = torque_at(angle) + 0.1 * np.random.default_rng(6).normal(size=len(angle))

    fit = fit_orders(angle_coverage(angle), values, 100)

    assert "halfway" in fit.uncertainty_source
    assert float(np.median(fit.standard)) == pytest.approx(0.1 * math.sqrt(2 / 5_000), rel=0.2)


@pytest.mark.parametrize("revolutions", [2.6, *at_length(2.0, 3.4)])
def test_the_uncertainty_of_few_revolutions_covers_the_truth_in_coloured_noise(revolutions: float) -> None:
    errors = []
    for seed in range(40):
        angle = uneven_angle(revolutions, 900, seed)
        noise = coloured(np.random.default_rng(100 + seed).standard_normal(len(angle)), 0.95)
        spectrum = fitted(angle, np.cos(6 * angle) + 0.3 * np.cos(angle) + 0.05 * noise)
        for order, truth in ((6, 1.0), (1, 0.3)):
            errors.append((spectrum.amplitude[order - 1] - truth) / spectrum.standard[order - 1])
    assert 0.6 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


@pytest.mark.parametrize("revolutions", [6.3, *at_length(12.2)])
def test_orders_that_take_along_half_of_the_rows_leave_less_scatter(revolutions: float) -> None:
    errors = []
    for seed in range(60):
        random = np.random.default_rng(seed)
        angle = np.linspace(0.0, TURN * revolutions, int(60 * revolutions)) + random.uniform(0.0, TURN)
        values = np.cos(6 * angle) + 0.02 * random.standard_normal(len(angle))
        spectrum = fitted(angle, values)
        errors.append((spectrum.amplitude[5] - 1.0) / spectrum.standard[5])
    assert 0.7 < float(np.sqrt(np.mean(np.square(errors)))) < 1.25


@pytest.mark.parametrize("revolutions", [2.3, *at_length(3.3, 4.3)])
def test_few_pairs_of_bins_count_once_in_orders_by_time(revolutions: float) -> None:
    """Beside order 1 there are few pairs, beside order 6 as many as are asked for."""
    errors, rows = [], 3000
    for seed in range(60):
        random = np.random.default_rng(seed)
        turned = TURN * revolutions * np.arange(rows) / rows + random.uniform(0.0, TURN)
        torque = np.cos(6 * turned) + 0.3 * np.cos(turned) + 0.05 * random.standard_normal(rows)
        block = Block.from_arrays(1e3, {"torque": "Nm"}, torque=torque)
        spectrum = orders_at_speed(block, "torque", TURN * revolutions / (rows / 1e3))
        errors.append((spectrum.amplitude[[0, 5]] - [0.3, 1.0]) / spectrum.standard[[0, 5]])
    np.testing.assert_array_less(0.5, np.sqrt(np.mean(np.square(errors), axis=0)))
    np.testing.assert_array_less(np.sqrt(np.mean(np.square(errors), axis=0)), 1.3)


def test_of_hardly_more_than_one_revolution_no_order_has_an_uncertainty() -> None:
    angle = uneven_angle(1.4, 900)
    values = torque_at(angle) + 0.1 * np.random.default_rng(6).normal(size=len(angle))

    found = {
        each.name: each for each in describe_orders(fitted(angle, values), "torque", orders=[6]).measurements
    }

    assert found["torque_order_6"].uncertainty is None
    assert "revolutions" in found["torque_order_6"].uncertainty_reason
    assert "revolutions" in found["torque_order_largest"].reason


def test_orders_of_two_revolutions_end_where_rows_tell_them_from_their_images() -> None:
    """The rows of one are between those of the other: orders k and 250.5 - k share the noise of both."""
    relative = []
    for seed in range(12):
        angle = 2 * np.pi / 250.5 * np.arange(540.0)
        noise = np.random.default_rng(seed).standard_normal(len(angle))
        fit = fit_orders(angle_coverage(angle), 1.0 + 1e-3 * noise, 200)
        assert len(fit.coefficient) == 112
        relative.append(2.0 * np.abs(fit.coefficient[-12:]) / fit.standard[-12:])
    assert 0.8 < np.sqrt(0.5 * np.mean(np.square(relative))) < 1.5  # 5 at orders 120 to 133


@pytest.mark.parametrize("revolutions", [3.4, *at_length(2.1, 6.2)])
def test_a_size_that_remembers_has_no_uncertainty_in_few_revolutions(revolutions: float) -> None:
    """What the ripple is in eight periods of a memory of ten is neither its scatter nor its mean."""
    count, told = round(1500 * revolutions), {True: 0, False: 0}
    angle = TURN * np.arange(count) / 1500.0
    for seed in range(10):
        random = np.random.default_rng(seed)
        noise = 2e-3 * random.standard_normal(count)
        size = 0.1 * coloured(random.standard_normal(round(4 * revolutions) + 1), 0.9)
        wanders = 1.0 + size[(np.arange(count) * 4 // 1500)]
        for does, course in ((True, wanders), (False, np.ones(count))):
            torque = 1.5 + 0.1 * course * np.cos(24 * angle) + noise
            units = {"torque": "Nm", "theta_m": "rad"}
            block = Block.from_arrays(1e4, units, torque=torque, theta_m=np.mod(angle, TURN))
            (found,) = (
                each
                for each in order_analysis(block, "torque", orders=[24]).measurements
                if each.name == "torque_order_24"
            )
            told[does] += found.uncertainty is not None
            assert found.uncertainty is not None or "wanders" in found.uncertainty_reason
    assert told[True] <= 1
    assert told[False] == 10


def test_which_order_is_the_largest_is_not_told_where_an_uncertain_one_may_be() -> None:
    """A speed that falls puts much beside order 1, which reads less than it is."""
    place = np.linspace(0.0, 1.0, 6_000)
    turned = TURN * 12.3 * (place + 0.02 * place * (1.0 - place))
    even = np.gradient(turned)
    speed = 42.0 * even / np.mean(even) + 0.05 * np.cos(24.0 * turned) + 0.08 * np.cos(turned + 1.0)
    speed += 0.02 * np.random.default_rng(2).standard_normal(len(place))
    block = Block.from_arrays(3_000.0, {}, theta_m=np.mod(turned, TURN), omega_m=speed)
    number, amplitude, *_ = order_analysis(block, "omega_m", "speed").measurements
    assert math.isnan(number.value)
    assert "may be larger than order" in number.reason
    assert amplitude.reason == number.reason


@pytest.mark.parametrize("slip", [0.0, 1.2e-3, 2.8e-3])
def test_an_order_of_an_angle_that_slips_may_have_been_as_large_as_in_each_revolution(slip: float) -> None:
    """Of ten revolutions, in which order 24 turns by up to four radians against an angle that slips."""
    turned = 2 * np.pi * np.arange(24_000) / 2_400
    values = 0.1 * np.cos(24.0 * (1.0 + slip) * turned) + 1e-3 * np.random.default_rng(4).standard_normal(
        24_000
    )
    fit = fit_orders(angle_coverage(turned), values, 40, "T")
    amplitude, standard = 2.0 * abs(fit.coefficient[23]), float(fit.standard[23])
    expected = 0.1 * abs(np.sinc(24.0 * slip * 10.0))
    assert amplitude == pytest.approx(expected, abs=1e-3)
    assert standard == pytest.approx(0.1 - expected, rel=0.5, abs=2e-4)
    assert float(np.max(fit.standard[:6])) < 2e-4  # orders of noise alone lose nothing
