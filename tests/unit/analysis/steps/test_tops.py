"""The greatest value between samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.steps.tops import kink, of_three, parabola, quartic


@pytest.mark.parametrize("place", [0.1, 0.4, 0.7, 0.95])
@pytest.mark.parametrize("decay", [15.0, 60.0])
def test_two_courses_meet_between_samples(place: float, decay: float) -> None:
    at = np.arange(40.0) - 20.0 - place
    values = np.where(at < 0.0, 1.0 + 0.05 * at, 0.8 + 0.2 * np.exp(-np.maximum(at, 0.0) / decay))
    top = int(np.argmax(values))
    found = kink(values, top, 0.0)
    assert found is not None
    assert values[top] + found.above == pytest.approx(1.0, abs=3.0 * found.above_error + 1e-12)
    assert found.above_error < 0.2 / decay**2 * 2.0
    assert top + found.beside == pytest.approx(20.0 + place, abs=found.beside_within)


def test_few_samples_of_a_peak_leave_it_between_them() -> None:
    """At five samples a period the neighbours of the greatest may bend the other way."""
    error, standard = [], []
    for phase in np.linspace(-0.5, 0.5, 41):
        values = np.cos(2.0 * np.pi / 5.0 * (np.arange(11.0) - 5.0 + phase))
        found = kink(values, 5, 0.0) or parabola(values, 5)
        error.append(values[5] + found.above - 1.0)
        standard.append(found.above_error)
    assert np.max(np.abs(error) / np.maximum(standard, 0.02)) < 2.5


def test_an_edge_and_a_single_sample_are_no_kink_that_goes_on() -> None:
    for values in ([0, 0, 0, 0, 1, 0.95, 0.95, 0.95, 0.95], [1, 1, 1, 1, 1.07, 1, 1, 1, 1]):
        assert kink(np.array(values, dtype=np.float64), 4, 0.0) is None


def test_noise_is_no_kink() -> None:
    random = np.random.default_rng(0)
    for _ in range(50):
        values = random.standard_normal(41)
        top = 3 + int(np.argmax(values[3:-3]))
        assert kink(values, top, 1.0) is None


def test_a_smooth_top_whose_flanks_bend_neither_way_is_no_kink() -> None:
    """Of a decaying oscillation in few rows one bend on either side may be next to nothing."""
    rows = np.arange(40, dtype=np.float64)
    for delay in np.arange(6.0, 7.0, 0.02).tolist():
        late = np.maximum(rows - delay, 0.0)
        values = 1.0 - np.exp(-late / 4.1) * np.cos(2.0 * np.pi * late / 6.7)
        fine = np.linspace(0.0, 6.7, 67_001)
        peak = delay + fine[np.argmax(1.0 - np.exp(-fine / 4.1) * np.cos(2.0 * np.pi * fine / 6.7))]
        top = int(np.argmax(values))
        found = kink(values, top, 0.0) or parabola(values, top)
        assert abs(top + found.beside - peak) <= found.beside_within


@pytest.mark.parametrize("period", [9.0, 14.0, 30.0])
@pytest.mark.parametrize("decay", [0.4, 0.8, 2.0])
def test_a_top_between_few_rows_of_a_mode_is_as_uncertain_as_stated(period: float, decay: float) -> None:
    omega, rate = 2.0 * math.pi / period, 1.0 / (decay * period)
    at_top = (math.pi - math.atan(rate / omega)) / omega
    greatest = 1.0 - math.exp(-rate * at_top) * math.cos(omega * at_top)
    height, place, by_parabola = [], [], []
    for phase in np.linspace(0.02, 0.98, 25):
        since = np.arange(math.ceil(period)) + phase
        values = 1.0 - np.exp(-rate * since) * np.cos(omega * since)
        top = int(np.argmax(values))
        found = quartic(values, top)
        if found is None:
            continue
        error = values[top] + found.above - greatest
        height.append(error / found.above_error)
        place.append((since[top] + found.beside - at_top) / found.beside_within * math.sqrt(3.0))
        by_parabola.append(abs(error) / parabola(values, top).above_error)
    assert len(height) > 15
    assert 0.4 < np.sqrt(np.mean(np.square(height))) < 1.4
    assert 0.3 < np.sqrt(np.mean(np.square(place))) < 1.4
    assert np.median(by_parabola) < 0.15


def test_too_few_rows_or_a_kink_have_no_top_on_a_quartic() -> None:
    five_a_period = np.cos(2.0 * np.pi / 5.0 * (np.arange(11.0) - 5.1))
    corner = 1.0 - 0.1 * np.abs(np.arange(11.0) - 5.2) - 0.001 * (np.arange(11.0) - 5.0) ** 2
    for values in (five_a_period, corner):
        assert quartic(values, 5) is None


def test_a_peak_in_the_first_rows_is_between_them_too() -> None:
    """It has risen within three rows of a step."""
    for damping in np.linspace(0.4, 0.7, 7).tolist():
        omega = math.sqrt(1.0 - damping**2)
        for phase in np.linspace(0.05, 0.95, 10).tolist():
            late = np.arange(30.0) + phase
            values = 1.0 - np.exp(-damping * late) * (
                np.cos(omega * late) + damping / omega * np.sin(omega * late)
            )
            top = int(np.argmax(values))
            found = kink(values, top, 0.0) or quartic(values, top) or parabola(values, top)
            truth = 1.0 + math.exp(-math.pi * damping / omega)
            assert abs(values[top] + found.above - truth) < 3.0 * found.above_error


def test_a_top_beside_its_row_is_higher_by_its_bend() -> None:
    """Of a quartic through five rows the place is uncertain, and where it is a row the height with it."""
    late = np.arange(30.0) + 0.22
    values = 1.0 - np.exp(-late / 4.5) * np.cos(2.0 * math.pi * late / 13.0)
    fine = np.arange(0.0, 12.0, 1e-4)
    truth = float(np.max(1.0 - np.exp(-fine / 4.5) * np.cos(2.0 * math.pi * fine / 13.0)))
    found = quartic(values, int(np.argmax(values)))
    assert found is not None
    assert abs(np.max(values) + found.above - truth) < 3.0 * found.above_error


@pytest.mark.parametrize("decay", [0.2, 0.4])
@pytest.mark.parametrize("rate", [1.4, 1.55, 1.7])
def test_a_top_of_three_rows_is_as_uncertain_as_stated(rate: float, decay: float) -> None:
    """The answer of two poles that rings with 3.7 to 4.5 rows a period, and steps anywhere within a row."""
    late, relative = np.linspace(0.02, 0.98, 49), []
    highest = 1.0 + math.exp(-decay * math.pi / rate)
    for each in late:
        since = np.arange(12.0) + each
        values = 1.0 - np.exp(-decay * since) * (np.cos(rate * since) + decay / rate * np.sin(rate * since))
        top = int(np.argmax(values))
        found = kink(values, top, 0.0) or quartic(values, top) or of_three(values, top, 0.0)
        found = found or parabola(values, top)
        relative.append((values[top] + found.above - highest) / math.hypot(found.above_error, 2e-3))
    assert float(np.sqrt(np.mean(np.square(relative)))) < 1.4


def test_the_first_row_of_a_plateau_is_no_top_of_three() -> None:
    for later in ([1.0, 1.0, 1.0, 1.0], [0.99, 0.99, 0.99, 0.99], [0.9, 0.85, 0.82, 0.81]):
        assert of_three(np.array([0.0, 1.0, *later, *later]), 1, 0.0) is None
    ringing = np.array([0.0, 1.0, 0.97, 0.96, 0.97, 0.98, 0.97])
    assert of_three(ringing, 1, 0.01) is None
    assert of_three(ringing, 1, 0.0) is not None
