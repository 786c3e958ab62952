"""Loops by their margins, and gains for a crossover and a phase margin."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.commission.tuning.loops import (
    CurrentLoop,
    SpeedLoop,
    mean_square_of_sequence,
    tuned_current_loop,
    tuned_speed_loop,
)
from benchtool.commission.tuning.margins import margins
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


def test_the_current_loop_is_the_recursion_that_it_stands_for() -> None:
    loop = CurrentLoop(3000.0, T_s)
    steps = 4000
    reference = np.random.default_rng(1).choice((-1.0, 1.0), steps)
    i = np.zeros(steps + 2)
    for k in range(steps):
        i[k + 2] = i[k + 1] + loop.share * (reference[k] - i[k + 1])
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
