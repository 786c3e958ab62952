"""Current sensors within the PWM period and the dc link's, against closed forms and scipy's filters."""

from __future__ import annotations

import cmath
import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import cont2discrete, lfilter

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.sampling import weights
from benchtool.emulator.machine.sensor_truth import CurrentTruth, SensorTruth, VoltageTruth
from benchtool.errors import ValueRefused
from tests.physics.paper_machine import MOTOR, make_core

T_S = 1e-4
OMEGA_M = 40.0
STEP_A = 30.0 / 2**24
NOT_SEEN = math.inf  # rad/s, of a sensor without a lag


@pytest.mark.parametrize("a", [0.0, 1e-9, 0.03, 0.24, 0.26, 1.0, 7.0, 300.0])
def test_weights_are_the_integrals_of_the_lag(a: float) -> None:
    for k, weight in enumerate(weights(a)):
        integral, _ = quad(lambda s, k=k: a * math.exp(-a * (1.0 - s)) * s**k, 0.0, 1.0, points=[0.99])
        assert weight == pytest.approx(integral, rel=1e-9, abs=1e-15)


def turning(sensors: dict[str, Any]) -> Core:
    """A drive on a held shaft that makes torque."""
    core = make_core(sensors={"adc_bits": 24, **sensors})
    core.load.held, core.load.omega_m_rad_s = 1, OMEGA_M
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = 3.0
    return core


class Stretch:
    """The current of the round machine at constant speed under one voltage: a sum of exponentials."""

    def __init__(self, i: complex, theta: float, u: complex) -> None:
        R, L, psi = MOTOR["R_s_ohm"], MOTOR["L_d_H"], MOTOR["psi_r_Wb"]
        omega = MOTOR["pole_pairs"] * OMEGA_M
        turned: complex = -1j * omega * psi * cmath.exp(1j * theta) / (R + 1j * omega * L)
        self.parts: list[tuple[complex, complex]] = [
            (turned, 1j * omega),
            (u / R, 0j),
            (i - turned - u / R, complex(-R / L)),
        ]

    def current(self, t: float) -> complex:
        return sum((c * cmath.exp(s * t) for c, s in self.parts), 0j)

    def lagged(self, t: float, phase: int, y: float, corner: float) -> float:
        """What a sensor of this corner reads after `t`, if it reads `y` at the start."""
        axis = cmath.exp(-2j * math.pi / 3.0 * phase)
        if corner == NOT_SEEN:
            return (axis * self.current(t)).real
        steady = [(axis * c / (1.0 + s / corner), s) for c, s in self.parts]
        at_start = sum((c for c, _ in steady), 0j).real
        at_end = sum((c * cmath.exp(s * t) for c, s in steady), 0j).real
        return at_end + (y - at_start) * math.exp(-corner * t)


def stretches(duties: tuple[float, float, float], u_dc: float) -> list[tuple[float, float, complex]]:
    """Start, end and voltage of each part of a period without an edge."""
    edges = [0.5 * (1.0 + sign * duty) * T_S for duty in duties for sign in (-1.0, 1.0)]
    times = sorted({0.0, T_S, *(at for at in edges if 0.0 < at < T_S)})
    found = []
    for start, end in itertools.pairwise(times):
        middle = 0.5 * (start + end) / T_S - 0.5
        legs = [u_dc * (abs(middle) < 0.5 * duty) for duty in duties]
        axes = (cmath.exp(2j * math.pi / 3.0 * k) for k in range(3))
        found.append((start, end, 2.0 / 3.0 * sum(v * axis for v, axis in zip(legs, axes, strict=True))))
    return found


def test_each_sensor_lags_is_late_drifts_and_is_read_at_its_moment_in_the_period() -> None:
    """The same from closed forms of the current, with the duties that the drive put out."""
    delays, corners = (3e-6, 80e-6, 0.0), (2 * math.pi * 20e3, 2 * math.pi * 1e3, NOT_SEEN)
    gains, offsets, drifts = (1.02, 0.97, 1.0), (0.1, -0.2, 0.0), (1e-3, -2e-3, 5e-3)
    core = turning(
        {
            "sampling_point": 0.6,
            "warm_up_K": 30.0,
            "warm_up_s": 2e-3,
            "i_a": CurrentTruth(
                gain=1.02, offset_A=0.1, offset_drift_A_K=1e-3, bandwidth_Hz=20e3, delay_s=3e-6
            ),
            "i_b": CurrentTruth(
                gain=0.97, offset_A=-0.2, offset_drift_A_K=-2e-3, bandwidth_Hz=1e3, delay_s=80e-6
            ),
            "i_c": CurrentTruth(offset_drift_A_K=5e-3, gain_drift_per_K=2e-3),
        }
    )
    y, late, errors = [0.0, 0.0, 0.0], 0.0, []
    for tick in range(1, 61):
        control, shaft = core._controls[0], core.shaft
        i, theta = complex(shaft.i_d, shaft.i_q) * cmath.exp(1j * shaft.theta_e), float(shaft.theta_e)
        duties = (float(control.duty_a), float(control.duty_b), float(control.duty_c))
        gated, u_dc = bool(control.gated), float(shaft.u_dc)
        assert core.run_with(run_ticks, 1) == 1
        read = [0.0, 0.0, 0.0]
        for start, end, u in stretches(duties, u_dc) if gated else []:
            part = Stretch(i, theta, u)
            for k in range(3):
                moment = (0.6 * T_S - delays[k]) % T_S
                if start < moment <= end:
                    read[k] = part.lagged(moment - start, k, y[k], corners[k])
                y[k] = part.lagged(end - start, k, y[k], corners[k])
            i, theta = part.current(end - start), theta + 4 * OMEGA_M * (end - start)
        read[1], late = late, read[1]  # 80 us before 0.6 of a period is in the period before
        warm = 30.0 * (1.0 - math.exp(-tick * T_S / 2e-3))
        gains_now = (gains[0], gains[1], gains[2] + 2e-3 * warm)
        measured = core._measurements[0]
        for k, reading in enumerate((measured.i_a, measured.i_b, measured.i_c)):
            errors.append(reading - (gains_now[k] * read[k] + offsets[k] + drifts[k] * warm))
    assert np.abs(errors).max() < 2.0 * STEP_A
    assert abs(core.shaft.i_q) > 2.0


def test_the_dc_links_sensor_is_the_discretised_lag() -> None:
    sensor = VoltageTruth(gain=1.01, offset_V=-2.0, bandwidth_Hz=500.0)
    core = turning({"u_dc": sensor})
    supplied, read = [], []
    for tick in range(30):
        if tick in (5, 12):
            core.set_dc_link(140.0 if tick == 5 else 110.0)
        core.run_with(run_ticks, 1)
        supplied.append(float(core.shaft.u_dc))
        read.append(float(core._measurements[0].u_dc))
    corner = 2 * math.pi * 500.0
    b, a, _ = cont2discrete((np.array([corner]), np.array([1.0, corner])), T_S, "zoh")
    # Delayed by a sample as a zero-order hold is; here the input of a period is known at its end.
    lagged = 122.5 + lfilter(b[0], a, np.append(np.array(supplied) - 122.5, 0.0))[1:]
    assert np.array(read) == pytest.approx(1.01 * lagged - 2.0, abs=500.0 / 2**24)
    assert np.ptp(supplied) == 30.0


def test_currents_a_lag_and_the_ends_of_the_period_agree_with_the_shaft_where_nothing_is_wrong() -> None:
    core = turning({"sampling_point": 1.0, "i_a": CurrentTruth(bandwidth_Hz=1e9)})
    for _ in range(20):
        core.run_with(run_ticks, 1)
        i = complex(core.shaft.i_d, core.shaft.i_q) * cmath.exp(1j * core.shaft.theta_e)
        measured = core._measurements[0]
        assert measured.i_a == pytest.approx(i.real, abs=2 * STEP_A)
        assert measured.i_b == pytest.approx((i * cmath.exp(-2j * math.pi / 3)).real, abs=2 * STEP_A)


def test_a_current_read_more_than_two_periods_late_is_refused_by_its_key() -> None:
    sensors = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0, i_b=CurrentTruth(delay_s=2e-4))
    with pytest.raises(ValueRefused, match=r"delay_s = 0\.0002 of phase b"):
        sensors.sampling(T_S)
    assert replace(sensors, i_b=CurrentTruth(delay_s=1.9e-4)).sampling(T_S) is not None
    with pytest.raises(ValueRefused, match="shunt_settling_s with bandwidth_Hz"):
        replace(sensors, shunt_settling_s=1e-6)
