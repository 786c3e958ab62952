"""What harmonics of the EMF brake, against a current loop that is run tick by tick."""

from __future__ import annotations

import cmath
import math

import pytest

from benchtool.commission.tuning.harmonic_brake import HarmonicBrake
from benchtool.commission.tuning.loops import CurrentLoop

T_s, L_H = 1e-4, 1e-3


@pytest.mark.parametrize("decay", [0.0, 0.05, 0.2])
def test_the_admittance_is_that_of_the_recursion(decay: float) -> None:
    """The loop of `test_tuning` with an EMF that turns and acts at once, while voltages wait for a period."""
    loop, omega, steps = CurrentLoop(3000.0, T_s, decay), 1700.0, 1500
    gain = (-math.expm1(-decay) / decay if decay else 1.0) * T_s / L_H
    i, u, integral, through = 0j, 0j, 0j, 0j
    for k in range(steps):
        e = cmath.exp(1j * omega * k * T_s)
        error = -(i - decay * i + u)
        after = math.exp(-decay) * i + gain * (L_H / T_s * u + e)
        through = 0.5 * (i + after) / e
        u = loop.share * error + integral
        integral += decay * loop.share * error
        i = after
    assert through == pytest.approx(loop.admittance(omega, L_H), rel=1e-6)


def test_a_slow_rotor_is_braked_by_what_the_loop_lets_through() -> None:
    """Far below its bandwidth and without resistance the loop is one of omega_c L across the EMF."""
    p, psi_Wb, speed = 4, 1e-3, 2.0
    loop = CurrentLoop(300.0, T_s)
    brake = HarmonicBrake(p, {-5: 0.6j * psi_Wb, 7: psi_Wb + 0j}, [(loop, L_H), (loop, L_H)])
    amplitudes = p * psi_Wb * math.hypot(5 * 0.6, 7)  # V s
    damping = 1.5 * amplitudes**2 / (300.0 * L_H)
    assert brake.torque_Nm(speed) == pytest.approx(damping * speed, rel=0.05)
    assert brake.damping_Nms(speed) == pytest.approx(damping, rel=0.1)
    assert brake.torque_Nm(0.0) == 0.0
    current_A = amplitudes * speed / (300.0 * L_H)
    assert brake.current_squared_A2(speed) == pytest.approx(current_A**2, rel=0.1)


def test_a_winding_without_harmonics_brakes_nothing() -> None:
    brake = HarmonicBrake(4, {}, ())
    assert brake.torque_Nm(50.0) == 0.0
    assert brake.damping_Nms(50.0) == 0.0
