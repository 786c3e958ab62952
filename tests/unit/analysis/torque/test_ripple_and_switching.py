"""Ripple, switching frequency and the checks before them, on signals whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.analysis import mean_switching_frequency_Hz, ripple
from benchtool.errors import AnalysisError


def test_ripple_of_a_sine_is_twice_its_amplitude_and_its_rms_is_over_root_two() -> None:
    samples = 5.0 + 0.3 * np.sin(2 * np.pi * np.arange(4000) / 400)

    result = ripple(samples, "Nm")

    assert result.mean == pytest.approx(5.0)
    assert result.peak_to_peak == pytest.approx(0.6)
    assert result.rms == pytest.approx(0.3 / np.sqrt(2))
    assert result.unit == "Nm"


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=50).filter(lambda values: len(set(values)) > 1))
def test_rms_ripple_is_never_more_than_half_the_peak_to_peak(values: list[float]) -> None:
    result = ripple(np.array(values), "A")

    # Popoviciu's inequality on variances
    assert result.rms <= result.peak_to_peak / 2 * (1 + 1e-9)
    assert min(values) <= result.mean + 1e-9 * abs(result.mean)


@pytest.mark.parametrize(
    ("samples", "seen"),
    [
        ([1.0], "has 1 samples"),
        ([2.0, 2.0, 2.0], "constant at 2"),
        ([1.0, np.nan, 2.0], "1 samples that are not finite"),
        ([1.0, np.inf, -np.inf], "2 samples that are not finite"),
    ],
)
def test_a_signal_without_information_is_refused(samples: list[float], seen: str) -> None:
    with pytest.raises(AnalysisError, match=seen) as refused:
        ripple(np.array(samples), "Nm", "torque")

    assert "'torque'" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_switching_frequency_is_turn_ons_over_three_times_the_duration() -> None:
    # each of three switches turns on once per 100 us tick: 10 kHz
    assert mean_switching_frequency_Hz(7.0 + 3.0 * np.arange(1001, dtype=np.float64), 1e-4) == pytest.approx(
        10e3
    )


def test_switching_counter_may_wrap_around_as_a_u32() -> None:
    straight = 3.0 * np.arange(1001, dtype=np.float64)
    wrapped = np.mod(straight + 2.0**32 - 1500.0, 2.0**32)

    assert np.any(np.diff(wrapped) < 0)
    assert mean_switching_frequency_Hz(wrapped, 1e-4) == mean_switching_frequency_Hz(straight, 1e-4)


def test_a_power_stage_that_never_switched_reads_zero() -> None:
    assert mean_switching_frequency_Hz(np.full(10, 5.0), 1e-4) == 0.0


def test_a_switching_counter_that_restarts_is_refused() -> None:
    with pytest.raises(AnalysisError, match="went backwards"):
        mean_switching_frequency_Hz(np.array([100.0, 103.0, 0.0, 3.0]), 1e-4)


def test_one_sample_has_no_switching_frequency() -> None:
    with pytest.raises(AnalysisError, match="at least 2"):
        mean_switching_frequency_Hz(np.array([100.0]), 1e-4)
