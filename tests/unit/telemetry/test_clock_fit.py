"""The fit of the clocks finds the line that was put in."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from benchtool.telemetry.clock_fit import ArrivalStatistics

TICK_S = 1e-4


def test_offset_drift_and_residual_of_a_noisy_line() -> None:
    rng = np.random.default_rng(1)
    statistics = ArrivalStatistics(TICK_S)
    ticks = 1_000_000 + 100 * np.arange(20_000)
    delay = rng.uniform(0.0, 1e-3, len(ticks))
    for tick, late in zip(ticks, delay, strict=True):
        statistics.add(int(tick), 5000.0 + (1.0 + 80e-6) * tick * TICK_S + late)
    fit = statistics.fit()
    assert fit is not None
    assert fit.records == 20_000
    assert fit.drift_ppm == pytest.approx(80.0, abs=0.2)
    assert fit.offset_s == pytest.approx(5000.0005, abs=5e-5)
    # A uniform delay of 1 ms has 1/sqrt(12) ms rms about its mean, and half of it at most.
    assert fit.residual_rms_s == pytest.approx(1e-3 / np.sqrt(12), rel=0.02)
    assert fit.residual_max_s == pytest.approx(5e-4, rel=0.05)
    steps = np.diff(delay) + 80e-6 * 100 * TICK_S
    assert statistics.jitter_rms_s == pytest.approx(float(np.sqrt(np.mean(steps**2))), rel=1e-3)
    assert statistics.jitter_max_s == pytest.approx(float(np.max(np.abs(steps))), rel=1e-3)


def test_a_long_recording_keeps_a_bounded_number_of_pairs_and_the_same_line() -> None:
    statistics = ArrivalStatistics(TICK_S)
    for number in range(150_000):
        statistics.add(10 * number, 1.0 + number * 1e-3 * (1.0 - 30e-6))
    assert len(statistics._ticks) <= 1 << 15
    fit = statistics.fit()
    assert fit is not None
    assert fit.records == 150_000
    assert fit.drift_ppm == pytest.approx(-30.0, abs=1e-3)


@pytest.mark.parametrize("count", [40_000, 70_000, 150_000])
def test_a_long_recording_is_thinned_evenly(count: int) -> None:
    """A clock that changes its rate: the line through a part of the record, or through more of its end, is
    another one than that through all records."""
    statistics = ArrivalStatistics(TICK_S)
    ticks = 10 * np.arange(count)
    bend = np.maximum(0.0, ticks - 0.6 * ticks[-1]) * TICK_S * 1e-3
    arrivals = ticks * TICK_S + bend
    for tick, arrival_s in zip(ticks.tolist(), arrivals.tolist(), strict=True):
        statistics.add(tick, arrival_s)
    fit = statistics.fit()
    assert fit is not None
    slope = np.polyfit(ticks * TICK_S, bend, 1)[0]
    assert fit.drift_ppm == pytest.approx(slope * 1e6, rel=1e-3)
    assert fit.residual_max_s == pytest.approx(
        np.max(np.abs(bend - np.polyval(np.polyfit(ticks * TICK_S, bend, 1), ticks * TICK_S))), rel=1e-2
    )


def test_it_can_be_asked_while_records_come() -> None:
    statistics = ArrivalStatistics(TICK_S)
    failures: list[Exception] = []

    def record() -> None:
        try:
            for number in range(200_000):
                statistics.add(number, number * TICK_S)
        except Exception as failure:  # noqa: BLE001  of whichever kind
            failures.append(failure)

    thread = threading.Thread(target=record)
    thread.start()
    while thread.is_alive():
        fit = statistics.fit()
        assert fit is None or fit.drift_ppm == pytest.approx(0.0, abs=1e-3)
    thread.join()
    assert failures == []


def test_two_records_are_no_fit() -> None:
    statistics = ArrivalStatistics(TICK_S)
    statistics.add(0, 0.0)
    statistics.add(10, 1.0)
    assert statistics.fit() is None


def test_what_rounding_leaves_of_two_equal_clocks_is_no_jitter() -> None:
    """An emulated drive has one clock: a jitter of 8.5e-18 s and a drift of -5e-11 ppm were stated."""
    statistics = ArrivalStatistics(TICK_S)
    for tick in range(0, 200_000, 100):
        statistics.add(tick, 3.1 + tick * TICK_S)
    fit = statistics.fit()
    assert fit is not None
    assert (statistics.jitter_rms_s, statistics.jitter_max_s) == (0.0, 0.0)
    assert (fit.drift_ppm, fit.residual_rms_s, fit.residual_max_s) == (0.0, 0.0, 0.0)
