"""The truths that coverage compares with, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.true_response import true_numbers_of_response
from benchmarks.coverage.true_step import KnownStep
from benchtool.analysis import Measurement
from benchtool.analysis.measurement import Basis

Floats = NDArray[np.float64]


def test_an_integrator_with_a_dead_time_has_the_margins_of_the_textbook() -> None:
    crossover_Hz, late_s = 20.0, 4e-3

    def closed(frequency_Hz: Floats) -> NDArray[np.complex128]:
        s = 2j * np.pi * frequency_Hz
        opened = 2.0 * np.pi * crossover_Hz * np.exp(-s * late_s)
        return np.asarray(opened / (s + opened))

    truths = true_numbers_of_response(closed, 400.0, ())
    assert truths["response_gain"] == pytest.approx(1.0)
    assert truths["crossover"] == pytest.approx(crossover_Hz, rel=1e-6)
    assert truths["phase_margin"] == pytest.approx(90.0 - 360.0 * crossover_Hz * late_s, rel=1e-5)
    assert truths["gain_margin"] == pytest.approx(-20.0 * math.log10(4.0 * late_s * crossover_Hz), rel=1e-5)


@pytest.mark.parametrize(
    ("ends", "between_Hz"),
    [
        ("up to bandwidth_3dB from a tenth of that, here from 3 Hz to 31 Hz", (5.0, 50.0)),
        ("up to bandwidth_3dB from the lowest frequency used, here from 8 Hz to 31 Hz", (8.0, 50.0)),
        ("up to the highest frequency used from a tenth of that, here from 3 Hz to 30 Hz", (3.0, 30.0)),
    ],
)
def test_the_delay_of_a_lag_is_that_of_the_line_of_its_phase(
    ends: str, between_Hz: tuple[float, float]
) -> None:
    corner_Hz = 50.0
    found = Measurement("response_delay", 0.0, "s", ends, Basis())
    truths = true_numbers_of_response(lambda f: np.asarray(1.0 / (1.0 + 1j * f / corner_Hz)), 900.0, [found])
    assert truths["bandwidth_3dB"] == pytest.approx(corner_Hz, rel=1e-6)
    assert truths["resonance_peak"] == 0.0
    assert truths["bandwidth_90deg"] == math.inf
    fine_Hz = np.linspace(*between_Hz, 20_001)
    slope = np.polyfit(fine_Hz, -np.arctan(fine_Hz / corner_Hz), 1)[0]
    assert truths["response_delay"] == pytest.approx(-slope / (2.0 * math.pi), rel=1e-3)


def test_two_poles_overshoot_as_their_damping_says() -> None:
    damping, omega = 0.4, 300.0
    turn = omega * math.sqrt(1.0 - damping**2)

    def answer(time_s: Floats) -> Floats:
        late_s = np.maximum(time_s, 0.0)
        swing = np.cos(turn * late_s) + damping * omega / turn * np.sin(turn * late_s)
        return np.asarray(1.0 - np.exp(-damping * omega * late_s) * swing)

    time_s = np.arange(-100, 2_000) / 1e4
    reference = np.where(time_s >= 0.0, 1.0, 0.0)
    step = KnownStep(answer, time_s, reference, lambda: answer(time_s), height=-3.0)
    settling = Measurement("settling_time", 0.0, "s", "", Basis(band=0.06))
    truths = step.true_numbers([settling])
    over = math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    assert truths["overshoot_percent"] == pytest.approx(100.0 * over, rel=1e-6)
    assert truths["overshoot"] == pytest.approx(3.0 * over, rel=1e-6)
    assert truths["peak_time"] == pytest.approx(math.pi / turn, rel=1e-4)
    assert truths["undershoot"] == pytest.approx(3.0 * over**2, rel=1e-3)
    samples = -3.0 * answer(time_s)
    assert truths["plateau_min"] == pytest.approx(np.min(samples), rel=1e-9)  # the greatest, downwards
    error = (samples + 3.0)[time_s >= truths["settling_time"]]
    assert truths["tracking_error_mean"] == pytest.approx(np.mean(error), rel=1e-9)
    assert truths["tracking_error_max"] == pytest.approx(np.max(np.abs(error)), rel=1e-9)
    assert 0.018 < truths["tracking_error_max"] / 3.0 <= 0.02


def test_a_plateau_ends_where_the_reference_falls() -> None:
    time_s = np.arange(-100, 3_000) / 1e4
    reference = np.where((time_s >= 0.0) & (time_s < 0.1), 1.0, 0.0)

    def answer(at_s: Floats) -> Floats:
        up, down = (np.where(at_s >= each, 1.0 - np.exp(-(at_s - each) / 4e-3), 0.0) for each in (0.0, 0.1))
        return np.asarray(up - down)

    step = KnownStep(answer, time_s, reference, lambda: answer(time_s), kinks_s=(0.1,))
    truths = step.true_numbers([Measurement("settling_time", 0.0, "s", "", Basis(band=0.02))])
    assert truths["reach_time"] == pytest.approx(4e-3 * math.log(50.0), rel=1e-4)
    assert truths["settling_time"] == pytest.approx(0.1 + 4e-3 * math.log(50.0), rel=1e-4)
    assert truths["plateau_min"] >= 0.98
    assert truths["plateau_max"] == pytest.approx(1.0, abs=1e-9)
    drifting = replace(step, drift=10.0).true_numbers(
        [Measurement("settling_time", 0.0, "s", "", Basis(band=0.02))]
    )
    assert drifting["tracking_error_mean"] == math.inf  # it does not settle
