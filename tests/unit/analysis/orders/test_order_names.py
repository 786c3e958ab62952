"""Which orders are listed, which is the largest, and what they are called."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis.lines import spectral_lines
from benchtool.analysis.orders.angle import TURN
from benchtool.analysis.orders.order_spectrum import resampled_orders
from benchtool.analysis.orders.orders import describe_orders, order_analysis
from benchtool.analysis.orders.orders_of_machine import MACHINE_ORDERS, order_meaning
from benchtool.block import Block
from tests.at_length import at_length
from tests.unit.analysis.orders.cogging_torque import Array, block_of, fitted, steady, torque_at, uneven_angle


@pytest.mark.parametrize(
    ("order", "pole_pairs", "slots", "meaning"),
    [
        (4, 4, None, "electrical fundamental, p"),
        (24, 4, None, "6p, phase harmonics 5 and 7"),
        (28, 4, None, "7p, electrical harmonic"),
        (48, 4, 12, "12p, phase harmonics 11 and 13; 2 x cogging, lcm of 12 slots and 8 poles"),
        (12, 4, 12, "3p, electrical harmonic; slots"),
        (12, 4, None, "3p, electrical harmonic"),
        (36, None, 12, "3 x slots"),
        (1, 4, 12, "once per revolution"),
        (7, 4, 12, ""),
    ],
)
def test_what_an_order_is(order: int, pole_pairs: int | None, slots: int | None, meaning: str) -> None:
    assert order_meaning(order, pole_pairs, slots) == meaning


def test_definitions_say_what_the_largest_orders_are() -> None:
    spectrum = fitted(angle := uneven_angle(5.0, 5_000), torque_at(angle))
    orders = describe_orders(spectrum, "torque", pole_pairs=12, slots=18)
    by_name = {each.name: each for each in orders.measurements}
    for name in ("torque_order_72", "torque_order_6p", "torque_order_cogging"):
        definition = by_name[name].definition
        assert definition.startswith(
            "peak amplitude of order 72 (6p, phase harmonics 5 and 7; cogging, lcm of 18"
        )
        assert by_name[name].value == by_name["torque_order_largest_amplitude"].value
        assert by_name[name].basis.harmonics == 200


def test_the_names_of_named_orders_do_not_depend_on_the_data() -> None:
    angle = uneven_angle(5.0, 5_000)
    noise = np.random.default_rng(5).normal(size=len(angle))
    found = [
        [each.name for each in describe_orders(fitted(angle, torque), "torque", 12, 18, (1, 72)).measurements]
        for torque in (torque_at(angle), noise)
    ]
    assert found[0] == found[1]
    assert found[0] == [
        *("torque_order_largest", "torque_order_largest_amplitude"),
        *(f"torque_order_{key}" for key in MACHINE_ORDERS),
        *("torque_order_1", "torque_order_72"),
    ]


def test_an_order_beyond_the_data_is_undefined() -> None:
    spectrum = fitted(angle := uneven_angle(5.0, 5_000), torque_at(angle))
    found = describe_orders(spectrum, "torque", pole_pairs=20).measurements
    (beyond,) = (each for each in found if each.name == "torque_order_12p")
    assert math.isnan(beyond.value)
    assert "orders end at 200" in beyond.reason


def test_an_amplitude_that_noise_alone_reads_is_within_its_uncertainty_of_zero() -> None:
    angle: Array = np.arange(4_000.0) * (20 * TURN / 4_000)
    random, orders = np.random.default_rng(7), tuple(range(1, 90))
    inside = total = 0
    for _ in range(8):
        spectrum = fitted(angle, random.normal(size=len(angle)))
        for each in describe_orders(spectrum, "torque", orders=orders).measurements[2:]:
            assert each.uncertainty is not None
            inside, total = inside + (each.value <= each.uncertainty.expanded), total + 1
    assert inside / total > 0.93


def test_only_orders_that_stand_out_of_the_noise_are_listed() -> None:
    angle: Array = np.arange(40_000.0) * (40 * TURN / 40_000)
    noise = np.random.default_rng(5).normal(size=len(angle))

    found = describe_orders(fitted(angle, 0.2 * np.cos(72 * angle) + 0.5 * noise), "torque")
    assert [each.name for each in found.measurements] == [
        *("torque_order_largest", "torque_order_largest_amplitude", "torque_order_72")
    ]
    assert len(found.tables[0].rows) == 200

    for none in describe_orders(fitted(angle, noise), "torque").measurements:
        assert math.isnan(none.value)
        assert none.reason == "no order stands out of the noise"


def test_where_no_order_is_told_as_the_largest_its_amplitude_has_a_bound() -> None:
    angle: Array = np.arange(40_000.0) * (40 * TURN / 40_000)
    noise = 1e-3 * np.random.default_rng(5).normal(size=len(angle))
    spectrum = fitted(angle, noise)
    number, amplitude = describe_orders(spectrum, "speed").measurements
    assert number.upper_bound is None
    assert amplitude.upper_bound == pytest.approx(np.max(spectrum.amplitude + 2.0 * spectrum.standard))
    assert np.max(spectrum.amplitude) < 2e-4
    untold = replace(spectrum, untold=frozenset({24}))
    assert describe_orders(untold, "speed").measurements[1].upper_bound is None


def test_which_order_is_the_largest_is_not_told_beside_a_larger_one_that_may_be_noise() -> None:
    """A belt at order 2.6 is the noise of orders 2 and 3, which of few revolutions do not stand out."""
    turned = steady(3.1, 6_000)
    values = 0.1 * np.cos(2.0 * turned) + 0.05 * np.cos(6.0 * turned) + 0.1 * np.cos(2.6 * turned + 1.0)
    values += 1e-3 * np.random.default_rng(6).normal(size=len(turned))
    number, amplitude, *_ = describe_orders(
        resampled_orders(block_of(turned, values), "torque"), "t"
    ).measurements
    assert math.isnan(number.value)
    assert number.reason.startswith("order 2 reads 0.")
    assert "more than order 6" in number.reason
    assert amplitude.reason == number.reason


@pytest.mark.parametrize("by_time", [True, False])
@pytest.mark.parametrize("revolutions", [3, *at_length(7, 20)])
def test_of_noise_alone_an_order_stands_out_in_one_of_a_hundred_records(
    revolutions: int, by_time: bool
) -> None:
    """The noise is estimated of few bins or revolutions: three in eighty records are less likely than 1 in
    20."""
    random, found = np.random.default_rng(11), 0
    turned = steady(revolutions + 0.1, 400 * revolutions)
    for _ in range(80):
        noise = random.normal(size=len(turned))
        spectrum = resampled_orders(block_of(turned, noise), "torque") if by_time else fitted(turned, noise)
        found += not math.isnan(describe_orders(spectrum, "torque").measurements[0].value)
    assert found <= 3


@pytest.mark.parametrize("revolutions", [3.1, 7.1, 20.1])
def test_an_order_well_above_the_noise_stands_out_of_few_revolutions(revolutions: float) -> None:
    turned = steady(revolutions, round(1_000 * revolutions))
    u = math.sqrt(2.0 / len(turned))
    values = 25.0 * u * np.cos(24 * turned) + np.random.default_rng(12).normal(size=len(turned))
    for spectrum in (resampled_orders(block_of(turned, values), "torque"), fitted(turned, values)):
        largest = describe_orders(spectrum, "torque").measurements[0]
        assert (largest.value, largest.basis.order) == (24.0, 24)


@pytest.mark.parametrize(("channel", "name"), [("torque", "torque"), ("omega_m", "speed"), ("i_a", "i_a")])
def test_orders_and_lines_are_named_after_what_was_analysed(channel: str, name: str) -> None:
    theta_m = 40.0 * np.arange(4000) / 2000.0
    units = {"theta_m": "rad", channel: "1"}
    block = Block.from_arrays(
        2000.0, units, **{"theta_m": np.mod(theta_m, TURN), channel: np.cos(6.0 * theta_m)}
    )
    found = order_analysis(block, channel)
    lines = spectral_lines(block, channel)
    names = [each.name for of in (found, lines) for each in of.measurements]
    names += [each.name for of in (found, lines) for each in of.tables]
    assert f"{name}_order_largest" in names
    assert f"{name}_line_frequency" in names
    assert all(each.startswith(f"{name}_") for each in names)
    assert order_analysis(block, channel, "shaft").measurements[0].name == "shaft_order_largest"
