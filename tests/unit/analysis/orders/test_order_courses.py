"""An amplitude of an order that a load moves steadily from revolution to revolution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from benchtool.analysis.orders.angle import TURN, angle_coverage
from benchtool.analysis.orders.order_spectrum import OrderSpectrum, fitted_orders
from benchtool.analysis.orders.orders import order_analysis
from tests.at_length import at_length
from tests.unit.analysis.orders.cogging_torque import Array, block_of

_ROWS, _REVOLUTIONS, _NOISE = 8_000, 40.3, 2e-3
_AMPLITUDES = {1: 0.5, 6: 0.1}
_PASSED = np.arange(_ROWS) / _ROWS
_ANGLE = 0.4 + TURN * _REVOLUTIONS * _PASSED
_COURSES = {
    "falls": 1.0 - 0.05 * (_PASSED - 0.5),
    "swings": 1.0 + 0.05 * np.sin(TURN * 2.3 * _PASSED + 0.7),
}
_WHITE = _NOISE * np.sqrt(2.0 / _ROWS)  # standard deviation of an amplitude by white noise


def _torque(course: Array, rng: np.random.Generator, drift: float = 0.0) -> Array:
    lines = sum(size * np.cos(order * _ANGLE + order) for order, size in _AMPLITUDES.items())
    return np.asarray(2.0 + drift * _PASSED + course * lines + _NOISE * rng.standard_normal(_ROWS))


def _by_time(torque: Array) -> OrderSpectrum:
    return order_analysis(block_of(_ANGLE, torque), "torque").spectrum


def _by_angle(torque: Array, *left_out: slice) -> OrderSpectrum:
    kept = np.ones(_ROWS, dtype=np.bool_)
    for rows in left_out or (slice(2800, 2950),):
        kept[rows] = False
    return fitted_orders(angle_coverage(_ANGLE[kept]), torque[kept], "torque", "Nm")


def _errors(spectrum: OrderSpectrum, orders: list[int]) -> Array:
    truth = np.array([_AMPLITUDES.get(each, 0.0) for each in orders])
    at = np.array(orders) - 1
    return np.asarray((spectrum.amplitude[at] - truth) / spectrum.standard[at])


@pytest.mark.parametrize("way", [_by_time, _by_angle])
@pytest.mark.parametrize("course", _COURSES)
def test_a_course_of_the_amplitude_is_no_scatter(course: str, way: Callable[[Array], OrderSpectrum]) -> None:
    rng = np.random.default_rng(4)
    found = [way(_torque(_COURSES[course], rng)) for _ in range(6)]
    errors = np.array([_errors(each, [1, 6]) for each in found])
    assert 0.6 < np.sqrt(np.mean(errors**2)) < 1.5
    # of the two sizes about the constant of a swing the noise tells a little less
    standard = np.array([each.standard[[0, 5]] for each in found])
    assert np.all(standard < 6.0 * _WHITE)
    assert np.median(standard) > 0.7 * _WHITE


@pytest.mark.parametrize("way", [_by_time, _by_angle])
@pytest.mark.parametrize("drift", [0.0, -4.0, *at_length(0.3)])
def test_a_course_is_not_in_the_orders_beside_it(way: Callable[[Array], OrderSpectrum], drift: float) -> None:
    rng = np.random.default_rng(5)
    found = [way(_torque(_COURSES["falls"], rng, drift)) for _ in range(5)]
    assert np.all(np.abs([_errors(each, [1, 6]) for each in found]) < 4.0)
    assert np.median([each.standard[0] for each in found]) < 2.0 * _WHITE
    errors = np.array([_errors(each, [2, 3]) for each in found])
    assert 0.7 < np.sqrt(np.mean(errors**2)) < 2.2  # sqrt(2) of noise alone (Rayleigh)
    assert np.median([each.standard[1] for each in found]) < 2.0 * _WHITE


@pytest.mark.parametrize("way", [_by_time, _by_angle])
def test_an_amplitude_that_wanders_at_random_has_no_course(way: Callable[[Array], OrderSpectrum]) -> None:
    rng = np.random.default_rng(6)
    walk = np.cumsum(rng.standard_normal(_ROWS)) / np.sqrt(_ROWS)
    assert way(_torque(1.0 + 0.05 * walk, rng)).standard[0] > 20.0 * _WHITE


def test_a_course_by_angle_is_bridged_where_turns_are_left_out() -> None:
    """Most of the first turn, one and a half in the middle, and most of the last."""
    rng = np.random.default_rng(7)
    left_out = slice(20, 180), slice(4000, 4300), slice(7700, 7980)
    found = [_by_angle(_torque(_COURSES["falls"], rng), *left_out) for _ in range(3)]
    assert np.all(np.abs([_errors(each, [1, 6]) for each in found]) < 4.0)
    assert np.all(np.array([each.standard[0] for each in found]) < 3.0 * _WHITE)


def test_there_is_no_course_where_most_turns_are_left_out() -> None:
    rng = np.random.default_rng(8)
    per_turn = _ROWS / _REVOLUTIONS
    left_out = [slice(round(each * per_turn), round((each + 0.8) * per_turn)) for each in range(1, 40, 2)]
    found = _by_angle(_torque(_COURSES["falls"], rng), *left_out)
    assert found.standard[0] > 10.0 * _WHITE
    assert np.all(np.abs(_errors(found, [1, 6])) < 4.0)
