"""Loops by their margins, and gains for a crossover and a phase margin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.analysis import Bode, FrequencyResponse
from benchtool.commission.tuning.loops import (
    CurrentLoop,
    SpeedLoop,
    mean_square_of_sequence,
    tuned_current_loop,
    tuned_speed_loop,
)
from benchtool.commission.tuning.margins import margins
from benchtool.commission.tuning.plant_seen import seen_plant
from benchtool.errors import AnalysisError, ValueRefused

T_s = 1e-4


def test_margins_of_an_integrator_with_a_delay() -> None:
    """K T/(z - 1) z^-n: |L| = 1 at 2 asin(K T / 2) / T, phase -90 - (n + 1/2) omega T degrees."""
    K, n = 1000.0, 2
    found = margins(lambda z: K * T_s / (z - 1.0) * z**-n, T_s)
    omega = 2.0 * math.asin(0.5 * K * T_s) / T_s
    turned = math.pi / (2.0 * n + 1.0)  # omega T where the phase is -180 degrees
    assert found.crossover_rad_s == pytest.approx(omega, rel=1e-5)
    assert found.phase_rad == pytest.approx(0.5 * math.pi - (n + 0.5) * omega * T_s, abs=1e-5)
    assert found.gain == pytest.approx(2.0 * math.sin(0.5 * turned) / (K * T_s), rel=1e-4)


def test_a_loop_without_a_crossover_is_refused() -> None:
    with pytest.raises(AnalysisError, match="does not fall through 1"):
        margins(lambda z: 0.1 + 0.0 * z, T_s)


@pytest.mark.parametrize("decay", [0.0, 0.03, 0.22])
def test_the_current_loop_is_the_recursion_that_it_stands_for(decay: float) -> None:
    """A PI with its zero on the winding's pole, which predicts by the voltage less that of the resistance."""
    loop = CurrentLoop(3000.0, T_s, decay)
    steps = 4000
    reference = np.random.default_rng(1).choice((-1.0, 1.0), steps)
    i, u, integral = np.zeros(steps + 2), np.zeros(steps + 1), 0.0  # u times T_s / L
    gain = -math.expm1(-decay) / decay if decay else 1.0
    for k in range(steps):
        i[k + 1] = math.exp(-decay) * i[k] + gain * u[k]
        error = reference[k] - (i[k] - decay * i[k] + u[k])
        u[k + 1] = loop.share * error + integral
        integral += decay * loop.share * error
    x, y = (
        np.fft.rfft(reference[-2048:] * np.hanning(2048)),
        np.fft.rfft(i[:steps][-2048:] * np.hanning(2048)),
    )
    z = np.exp(2j * np.pi * np.arange(len(x)) / 2048)
    strong = np.abs(x) > 10.0
    assert np.median(np.abs(y[strong] / x[strong] - loop.closed(z)[strong])) < 0.02
    opened = loop.open(z[1:])
    np.testing.assert_allclose(opened / (1.0 + opened), loop.closed(z[1:]), rtol=1e-9)


@settings(max_examples=30)
@given(
    omega=st.floats(10.0, 600.0),
    J=st.floats(1e-6, 1.0),
    friction=st.floats(0.0, 0.1),
    phase_deg=st.floats(40.0, 75.0),
    has_inner=st.booleans(),
)
def test_a_tuned_speed_loop_has_its_crossover_and_phase_margin(
    omega: float, J: float, friction: float, phase_deg: float, has_inner: bool
) -> None:
    inner = tuned_current_loop(0.05 * 2.0 * math.pi / T_s, T_s) if has_inner else None
    viscous = friction * J * omega
    loop = tuned_speed_loop(omega, J, viscous, inner, T_s, math.radians(phase_deg))
    found = loop.margins
    assert found.crossover_rad_s == pytest.approx(omega, rel=1e-3)
    assert math.degrees(found.phase_rad) == pytest.approx(phase_deg, abs=0.05)


@settings(max_examples=20)
@given(J=st.floats(0.8, 1.25), damping=st.floats(0.0, 0.3), seed=st.integers(0, 1000))
def test_a_plant_is_seen_as_it_is_and_tuned_for_that(J: float, damping: float, seed: int) -> None:
    """The loop was tuned for an inertia of 1e-4 without friction; its response has an error of 1 %."""
    inner = tuned_current_loop(0.05 * 2.0 * math.pi / T_s, T_s, 0.1)
    tuned = tuned_speed_loop(100.0, 1e-4, 0.0, inner, T_s)
    true = replace(tuned, J_kgm2=1e-4 * J, friction_Nms=1e-4 * 100.0 * damping)
    f_Hz = np.arange(1.0, 60.0) * 1.3
    opened = true.open(np.exp(2j * math.pi * f_Hz * T_s))
    noise = 0.01 * (np.random.default_rng(seed).standard_normal((2, len(f_Hz))))
    closed = opened / (1.0 + opened) * (1.0 + noise[0] + 1j * noise[1])
    seen = seen_plant(bode_of(f_Hz, closed, 0.01), tuned)
    assert abs(seen.J_kgm2 - true.J_kgm2) < 5.0 * seen.J_standard
    assert abs(seen.friction_Nms - true.friction_Nms) < 5.0 * seen.friction_standard
    assert seen.friction_standard < 0.02 * 1e-4 * 100.0
    again = tuned_speed_loop(100.0, seen.J_kgm2, max(0.0, seen.friction_Nms), inner, T_s)
    found = replace(again, J_kgm2=true.J_kgm2, friction_Nms=true.friction_Nms).margins
    assert found.crossover_rad_s == pytest.approx(100.0, rel=0.03)
    assert math.degrees(found.phase_rad) == pytest.approx(60.0, abs=3.0)


def test_a_plant_of_which_no_frequency_near_the_crossover_is_told_is_not_seen() -> None:
    tuned = tuned_speed_loop(100.0, 1e-4, 0.0, None, T_s)
    f_Hz = np.arange(60.0, 100.0)
    opened = tuned.open(np.exp(2j * math.pi * f_Hz * T_s))
    with pytest.raises(AnalysisError, match="raise the stimulus"):
        seen_plant(bode_of(f_Hz, opened / (1.0 + opened), 0.01), tuned)


def bode_of(f_Hz: np.ndarray, closed: np.ndarray, error: float) -> Bode:
    """A response of which every frequency can be used."""
    sure, one = np.ones(len(f_Hz)), np.full(len(f_Hz), True)
    response = FrequencyResponse(f_Hz, closed, sure, error * sure, sure, one, one, 5.0, 1000, "")
    return Bode("stimulus", "omega_m", "", response, (), ())


def test_margins_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueRefused, match="lower the bandwidth"):
        tuned_speed_loop(9000.0, 1e-3, 0.0, None, T_s)


def test_the_torque_of_a_binary_sequence_by_its_lines() -> None:
    """Against the loop as a recursion, with the torque within the delay."""
    loop = tuned_speed_loop(200.0, 1e-3, 0.0, None, T_s)
    bits, hold = 6, 10
    sequence, register = [], 1
    for _ in range(2**bits - 1):
        sequence.append(1.0 if register & 1 else -1.0)
        register = register >> 1 | ((register ^ register >> 1) & 1) << (bits - 1)
    reference = 2.0 * np.tile(np.repeat(sequence, hold), 8)
    torque, omega, integral = np.zeros(len(reference) + 2), 0.0, 0.0
    asked = np.zeros(len(reference))
    for k, wanted in enumerate(reference):
        integral += loop.K_i_Nm_rad * T_s * (wanted - omega)
        asked[k] = loop.K_p_Nms_rad * (wanted - omega) + integral
        torque[k + 2] = asked[k]
        omega += T_s / loop.J_kgm2 * torque[k]
    last = asked[-len(sequence) * hold :]
    expected = float(np.var(last))
    assert mean_square_of_sequence(loop, 2.0, hold * T_s, bits) == pytest.approx(expected, rel=0.03)


def test_a_loop_of_torque_is_fast_beside_that_of_speed() -> None:
    slow = SpeedLoop(1e-2, 1e-2, 1e-3, 0.0, None, T_s)
    assert slow.margins.gain > 100.0
    assert slow.margins.sensitivity == pytest.approx(1.0, abs=0.1)
