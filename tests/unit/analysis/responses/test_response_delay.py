"""The delay of a response is that of the response, whatever frequencies of it are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.responses.response_curve import Point
from benchtool.analysis.responses.response_delay import response_delay

Floats = NDArray[np.float64]

_BASIS = Basis(samples=1000, sample_rate_Hz=1000.0, duration_s=1.0)
_ERROR = 1e-3


def _delay(frequency_Hz: Floats, response: NDArray[np.complex128], bandwidth: Point | None) -> Measurement:
    phase, error = np.unwrap(np.angle(response)), np.full(len(response), _ERROR)
    return response_delay(frequency_Hz, np.abs(response), phase, error, bandwidth, _BASIS)


def _standard(found: Measurement) -> float:
    assert found.uncertainty is not None
    return found.uncertainty.standard


def _two_poles(frequency_Hz: Floats, damping: float) -> NDArray[np.complex128]:
    s = 1j * frequency_Hz / 50.0
    return np.asarray(1.0 / (1.0 + 2.0 * damping * s + s**2) * np.exp(-2j * math.pi * frequency_Hz * 1e-3))


@pytest.mark.parametrize(("damping", "bandwidth_Hz"), [(0.7, 50.0), (0.05, 77.5)])
def test_few_lines_and_many_give_one_delay(damping: float, bandwidth_Hz: float) -> None:
    many, few = np.arange(0.5, 200.0, 0.25), np.geomspace(1.0, 200.0, 34)
    bandwidth = Point(bandwidth_Hz, 0.0)
    dense, sparse = (_delay(each, _two_poles(each, damping), bandwidth) for each in (many, few))
    assert abs(sparse.value - dense.value) < 2.0 * _standard(sparse)
    assert _standard(dense) < 0.01 * dense.value


@pytest.mark.parametrize("bandwidth_Hz", [66.0, 68.0, 70.0, 72.0, 76.0])
def test_the_line_ends_between_lines_as_it_does_on_one(bandwidth_Hz: float) -> None:
    lines = np.unique(np.geomspace(1.0, 400.0, 13).round())
    response = _two_poles(lines, 0.35)
    phase, error = np.unwrap(np.angle(response)), np.full(len(lines), 1e-5)
    found = response_delay(lines, np.abs(response), phase, error, Point(bandwidth_Hz, 0.0), _BASIS)
    assert abs(found.value - _of_all_frequencies(bandwidth_Hz)) < 2.0 * _standard(found)


def test_many_lines_give_the_delay_to_a_part_in_a_million() -> None:
    frequency_Hz = np.arange(1.0, 200.0, 1.0)
    found = _delay(frequency_Hz, _two_poles(frequency_Hz, 0.35), Point(70.4, 0.0))
    assert found.value == pytest.approx(_of_all_frequencies(70.4), rel=5e-7)


def _of_all_frequencies(bandwidth_Hz: float) -> float:
    fine_Hz = bandwidth_Hz * (0.1 + 0.9 * (np.arange(50_000) + 0.5) / 50_000)
    slope = np.polyfit(fine_Hz, np.unwrap(np.angle(_two_poles(fine_Hz, 0.35))), 1)[0]
    return -float(slope) / (2.0 * math.pi)


def test_a_lowest_frequency_less_changes_nothing() -> None:
    frequency_Hz = np.arange(0.5, 200.0, 0.5)
    response = _two_poles(frequency_Hz, 0.5)
    one, other = (_delay(frequency_Hz[n:], response[n:], Point(60.0, 0.1)) for n in (0, 7))
    assert one.definition == other.definition
    assert one.value == pytest.approx(other.value, rel=1e-6)


def test_the_upper_end_is_as_uncertain_as_the_bandwidth() -> None:
    frequency_Hz = np.arange(0.5, 200.0, 0.5)
    response = _two_poles(frequency_Hz, 0.4)
    at, beyond = (_delay(frequency_Hz, response, Point(each, 0.0)).value for each in (60.0, 62.0))
    standard = _standard(_delay(frequency_Hz, response, Point(60.0, 2.0)))
    assert standard == pytest.approx(abs(beyond - at), rel=0.2)


def test_a_dead_time_is_its_slope_and_three_frequencies_are_needed() -> None:
    frequency_Hz = np.arange(1.0, 100.0)
    response = np.exp(-2j * math.pi * frequency_Hz * 3e-3)
    found = _delay(frequency_Hz, response, None)
    assert found.value == pytest.approx(3e-3, abs=1e-12)
    assert "from 9.9 Hz to 99 Hz" in found.definition
    assert math.isnan(_delay(frequency_Hz, response, Point(2.0, 0.0)).value)


@pytest.mark.parametrize("lines", [8, 60])
def test_errors_of_the_phases_are_in_the_slope(lines: int) -> None:
    random, missed = np.random.default_rng(1), []
    frequency_Hz = np.geomspace(2.0, 80.0, lines)
    for _ in range(80):
        response = np.exp(-2j * math.pi * frequency_Hz * 1e-3 + 1j * _ERROR * random.standard_normal(lines))
        found = _delay(frequency_Hz, response, Point(60.0, 0.0))
        missed.append((found.value - 1e-3) / _standard(found))
    assert 0.7 < math.sqrt(float(np.mean(np.square(missed)))) < 1.3


def test_the_definition_says_where_the_line_begins_and_ends() -> None:
    frequency_Hz = np.arange(10.0, 100.0)
    response = _two_poles(frequency_Hz, 0.5)
    ended = _delay(frequency_Hz, response, Point(60.0, 0.0)).definition
    assert "up to bandwidth_3dB from the lowest frequency used, here from 10 Hz to 60 Hz" in ended
    without = _delay(np.arange(1.0, 100.0), _two_poles(np.arange(1.0, 100.0), 0.5), None).definition
    assert "up to the highest frequency used from a tenth of that, here from 9.9 Hz to 99 Hz" in without


@pytest.mark.parametrize("lines", [8, 1000])
def test_even_errors_have_the_uncertainty_of_a_least_squares_slope(lines: int) -> None:
    frequency_Hz = np.linspace(10.0, 100.0, lines)
    response = np.exp(-2j * math.pi * frequency_Hz * 1e-3)
    across = frequency_Hz - np.mean(frequency_Hz)
    expected = _ERROR / float(np.linalg.norm(across)) / (2.0 * math.pi)
    found = _standard(_delay(frequency_Hz, response, None))
    assert found == pytest.approx(expected, rel=0.02 if lines > 100 else 0.3)


def test_the_lowest_frequency_counts_where_the_line_begins_there() -> None:
    """Of three alike, along straight lines between them, each end counts -/+ 1/2 over their distance."""
    frequency_Hz, error = np.array([20.0, 30.0, 40.0]), np.array([_ERROR, 0.0, 0.0])
    response = np.exp(-2j * math.pi * frequency_Hz * 1e-3)
    phase = np.unwrap(np.angle(response))
    found = response_delay(frequency_Hz, np.abs(response), phase, error, None, _BASIS)
    assert _standard(found) == pytest.approx(0.5 * _ERROR / 10.0 / (2.0 * math.pi), rel=1e-3)
