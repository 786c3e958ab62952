"""Stability margins from a closed response."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.measurement import Basis
from benchtool.analysis.responses.margins import margins


@pytest.mark.parametrize("turned_deg", [-6.0, 0.0, 6.0])
def test_a_loop_of_two_integrators_has_the_margin_of_the_phase_that_falls_to_half_a_turn(
    turned_deg: float,
) -> None:
    """At the lowest frequencies the phase of the open loop is near -180 degrees, and an error turns it."""
    frequency_Hz = np.geomspace(2.0, 1_500.0, 400)
    s = 2j * math.pi * frequency_Hz
    omega = 2.0 * math.pi * 100.0
    opened = omega / s * (1.0 + omega / 5.0 / s) * np.exp(-1e-3 * s)
    seen = opened * np.exp(1j * math.radians(turned_deg) * (frequency_Hz < 5.0))
    basis = Basis(samples=1000, sample_rate_Hz=1e4, duration_s=0.1)
    found = {
        each.name: each for each in margins(frequency_Hz, seen / (1.0 + seen), np.full(400, 1e-5), basis)
    }
    above = frequency_Hz > 50.0
    at_Hz = float(np.interp(math.pi, -np.unwrap(np.angle(opened))[above], frequency_Hz[above]))
    truth = -20.0 * math.log10(float(np.interp(at_Hz, frequency_Hz, np.abs(opened))))
    assert found["gain_margin"].value == pytest.approx(truth, abs=0.02)
    assert 40.0 < found["phase_margin"].value < 60.0


@pytest.mark.parametrize(("last_Hz", "is_known"), [(21.0, True), (150.0, False)])
def test_nothing_is_read_where_frequencies_are_missing(last_Hz: float, is_known: bool) -> None:
    """Noise hides the response from 20 Hz to `last_Hz`, about the crossover and the greatest sensitivity."""
    frequency_Hz = np.arange(10.0, 400.0, 10.0, dtype=np.float64)
    frequency_Hz = frequency_Hz[(frequency_Hz <= 20.0) | (frequency_Hz >= last_Hz)]
    s = 2j * math.pi * frequency_Hz
    omega, damping = 2.0 * math.pi * 30.0, 0.26
    opened = omega**2 / (s * (s + 2.0 * damping * omega))
    basis = Basis(samples=1000, sample_rate_Hz=1e4, duration_s=0.1)
    closed = np.asarray(opened / (1.0 + opened), dtype=np.complex128)
    error = np.full(len(frequency_Hz), 0.01)
    found = {each.name: each for each in margins(frequency_Hz, closed, error, basis)}
    for name in ("crossover", "phase_margin", "sensitivity_peak"):
        assert math.isfinite(found[name].value) == is_known, name


@pytest.mark.parametrize(("damping", "is_known"), [(0.4, True), (0.01, False)])
def test_a_resonance_above_the_crossover_leaves_no_one_phase_margin(damping: float, is_known: bool) -> None:
    """Two masses: beyond the crossover at 20 Hz the gain may be above 1 again at 80 Hz."""
    frequency_Hz = np.geomspace(2.0, 500.0, 300)
    s = 2j * math.pi * frequency_Hz
    omega, twisting = 2.0 * math.pi * 20.0, 2.0 * math.pi * 80.0
    opened = omega / s * twisting**2 / (s**2 + 2.0 * damping * twisting * s + twisting**2)
    basis = Basis(samples=1000, sample_rate_Hz=1e4, duration_s=0.1)
    closed = np.asarray(opened / (1.0 + opened), dtype=np.complex128)
    found = {each.name: each for each in margins(frequency_Hz, closed, np.full(300, 1e-3), basis)}
    assert found["crossover"].value == pytest.approx(20.0, rel=0.1)
    assert math.isfinite(found["phase_margin"].value) == is_known
    if not is_known:
        assert "above 1 again at 68" in found["phase_margin"].reason
