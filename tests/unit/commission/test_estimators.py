"""The estimators on data with a known truth, and whether their stated uncertainties hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.inductance import Turning, inductance
from benchtool.commission.estimators.phase_gains import phase_gains
from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.resistance import resistance
from benchtool.commission.estimators.zero_current import zero_current
from benchtool.errors import AnalysisError

REPETITIONS = 200
DIRECTIONS = np.deg2rad([-12.0, 53.0, 118.0, 184.0, 249.0, 311.0])


def phases_of(vectors: NDArray[np.complex128]) -> NDArray[np.float64]:
    """The three phases of vectors, by their projections."""
    return np.column_stack([(vectors * np.exp(-2j * np.pi * k / 3.0)).real for k in range(3)])


def holds(z: list[float]) -> None:
    """Deviations over stated standard uncertainties: their rms is 1 within its scatter, 5 sigma."""
    rms = math.sqrt(float(np.mean(np.square(z))))
    assert rms == pytest.approx(1.0, abs=5.0 / math.sqrt(2.0 * len(z)))
    assert abs(np.mean(z)) < 5.0 / math.sqrt(len(z))


def test_offset_and_noise_of_quantised_readings() -> None:
    rng = np.random.default_rng(3)
    z = []
    for _ in range(REPETITIONS):
        step, offset = 0.02, float(rng.uniform(-0.5, 0.5))
        readings = step * np.round((offset + rng.normal(0.0, 1.2 * step, 500)) / step)
        found = zero_current(readings)
        z.append((found.offset_A - offset) / found.standard_A)
        assert found.noise_A_rms == pytest.approx(1.2 * step, rel=0.25)
    holds(z)


def test_gains_of_the_phases_against_each_other() -> None:
    rng = np.random.default_rng(4)
    gains = np.array([1.02, 0.985, 0.995])
    z: list[float] = []
    currents = phases_of(np.exp(1j * np.repeat(DIRECTIONS, 5)) * np.tile(np.arange(2.0, 7.0), 6))
    for _ in range(REPETITIONS):
        found = phase_gains((currents + 0.3) * gains + rng.normal(0.0, 0.01, currents.shape))
        true = 3.0 / gains / np.sum(1.0 / gains)
        z += list((found.corrections - true) / found.standard)
    holds(z)


def standing(
    rng: np.random.Generator,
    noise_A: float,
    gains: NDArray[np.float64],
    directions: NDArray[np.float64] = DIRECTIONS,
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Voltages and readings of 0.2 ohm and 0.7 V a phase, summed phase by phase, and a constant voltage."""
    i = np.exp(1j * np.repeat(directions, 5)) * np.tile(np.arange(2.0, 7.0), 6)
    phases = phases_of(i)
    legs = 0.2 * phases + 0.7 * np.where(phases > 0.0, 1.0, -1.0)
    a, b, c = legs.T
    u = (2.0 * a - b - c) / 3.0 + 1j * (b - c) / math.sqrt(3.0) + (0.02 - 0.01j)
    return u, phases * gains + rng.normal(0.0, noise_A, phases.shape)


def test_resistance_and_the_voltage_of_the_dead_time() -> None:
    rng = np.random.default_rng(5)
    R, drop = [], []
    for _ in range(REPETITIONS):
        found = resistance(*standing(rng, 0.01, np.ones(3)))
        R.append((found.R_s_ohm - 0.2) / found.R_s_standard_ohm)
        drop.append((found.drop_V - 0.7) / found.drop_standard_V)
    holds(R)
    holds(drop)


def test_gains_that_differ_do_not_spoil_the_resistance_and_the_common_one_cannot_be_seen() -> None:
    gains = np.array([1.02, 0.98, 1.015])
    u, readings = standing(np.random.default_rng(6), 0.0, gains)
    common = 3.0 / np.sum(1.0 / gains)
    assert resistance(u, readings).R_s_ohm == pytest.approx(0.2 / common, rel=1e-9)


def test_phases_that_differ_are_told_apart() -> None:
    u, readings = standing(np.random.default_rng(6), 0.005, np.ones(3))
    poor = u + 0.1 * readings[:, 1] * np.exp(2j * math.pi / 3.0) * (2.0 / 3.0)
    found = resistance(poor, readings)
    assert found.of_phases_ohm == pytest.approx([0.2, 0.3, 0.2], abs=0.01)
    assert np.all(np.abs(found.of_phases_ohm - [0.2, 0.3, 0.2]) < 5.0 * found.of_phases_standard_ohm)


def test_one_level_cannot_tell_resistance_from_dead_time() -> None:
    quiet, alike = np.random.default_rng(7), np.ones(3)
    u, readings = standing(quiet, 0.0, alike, np.deg2rad(np.arange(0.0, 360.0, 60.0)))
    with pytest.raises(AnalysisError, match="cannot be told apart"):
        resistance(u[4::5], readings[4::5])
    with pytest.raises(AnalysisError, match="0 standing currents with every phase clear of zero"):
        resistance(*standing(quiet, 0.0, alike, np.deg2rad(np.arange(30.0, 390.0, 60.0))))


T_S = 1e-4
R_S, L_D, L_Q, PSI_R, POLE_PAIRS, J = 0.8, 0.9e-3, 1.5e-3, 6e-3, 4, 4e-6


def shaken(
    rng: np.random.Generator,
    periods: float,
    u_V: float,
    noise_A: float,
    drop_V: float = 0.0,
    *,
    shares: tuple[float, float] = (0.0, 0.0),
    pull_Nm: float = 0.0,
) -> Turning:
    """A machine whose rotor is free, in steps of a hundredth of a control period, in the rotor's frame.

    `shares` are the fifth and the seventh harmonic of the rotor flux, `pull_Nm` a torque from outside.
    """
    n, fine = 900, 100
    angle = 2.0 * math.pi * np.arange(n) / periods
    u = u_V * np.arange(n) / n * np.exp(1j * angle)
    i_d = i_q = omega = 0.0
    theta = 0.1
    fifth, seventh = shares
    h = T_S / fine
    currents, rotor = [0j], []
    for voltage in u:
        rotor.append(theta)
        for _ in range(fine):
            turned = complex(math.cos(theta), math.sin(theta))
            i = complex(i_d, i_q) * turned
            legs = (
                [1.0 if (i * np.exp(-2j * np.pi * k / 3.0)).real > 0.0 else -1.0 for k in range(3)]
                if drop_V
                else []
            )
            lost = drop_V * 2.0 / 3.0 * sum(s * np.exp(2j * np.pi * k / 3.0) for k, s in enumerate(legs))
            v = (voltage - lost) * turned.conjugate()
            k_d, k_q = 0.0, PSI_R
            if fifth or seventh:
                sixth = complex(math.cos(6.0 * theta), math.sin(6.0 * theta))
                k = PSI_R * 1j * (1.0 - 5.0 * fifth / sixth + 7.0 * seventh * sixth)
                k_d, k_q = k.real, k.imag
            torque = 1.5 * POLE_PAIRS * (k_d * i_d + k_q * i_q + (L_D - L_Q) * i_d * i_q)
            d_d = (v.real - R_S * i_d + omega * (L_Q * i_q - k_d)) / L_D
            d_q = (v.imag - R_S * i_q - omega * (L_D * i_d + k_q)) / L_Q
            i_d, i_q = i_d + h * d_d, i_q + h * d_q
            theta += h * omega
            omega += h * POLE_PAIRS * (torque + pull_Nm) / J
        currents.append(complex(i_d, i_q) * complex(math.cos(theta), math.sin(theta)))
    readings = phases_of(np.array(currents))
    at = np.array(rotor) if fifth or seventh else 0.0
    return Turning(u, readings + rng.normal(0.0, noise_A, readings.shape), at)


@pytest.fixture(scope="module")
def captures() -> list[Turning]:
    """Two speeds without noise."""
    quiet = np.random.default_rng(0)
    return [shaken(quiet, 14.0, 3.0, 0.0), shaken(quiet, 31.0, 2.0, 0.0)]


def estimated(captures: list[Turning], aligned_rad: float = 0.0) -> tuple[float, float, float, float]:
    found = inductance(captures, Circuit(T_S, R_S, 0.0, 48.0, noise_A=0.01), aligned_rad=aligned_rad)
    return found.d.L_H, found.d.standard_H, found.q.L_H, found.q.standard_H


def test_inductances_of_a_rotor_that_is_shaken(captures: list[Turning]) -> None:
    """The EMF of the shaking makes L_q look 10 % and more too small at one speed; the axis is found."""
    for aligned_rad in (0.0, 0.25):
        L_d, _, L_q, _ = estimated(captures, aligned_rad)
        assert L_d == pytest.approx(L_D, rel=0.005)
        assert L_q == pytest.approx(L_Q, rel=0.01)


def test_harmonics_of_the_rotor_flux_of_a_shaken_rotor_that_moves() -> None:
    """They couple the axes: taken for none, L_d is 0.5 % too small here, and L_q 0.2 %."""
    quiet, shares = np.random.default_rng(5), (0.03, 0.03)
    captures = [
        shaken(quiet, 14.0, 3.0, 0.001, shares=shares, pull_Nm=1e-3),
        shaken(quiet, 31.0, 2.0, 0.001, shares=shares, pull_Nm=1e-3),
    ]
    L_d, _, L_q, _ = estimated(captures)
    assert L_d == pytest.approx(L_D, rel=0.002)
    assert L_q == pytest.approx(L_Q, rel=0.0015)


def saturating(periods: float, u_V: float, power: int) -> Turning:
    """A machine that stands under a voltage with a constant part. Its magnets already saturate the iron along
    the flux; across it, this power of the flux linkage bends the current, and either flux the other current
    as well, by one energy."""
    n, fine = 900, 20
    u = u_V * np.arange(n) / n * np.exp(2j * math.pi * np.arange(n) / periods) + 0.15
    psi_d = psi_q = 0.0
    currents = [0j]
    for voltage in u:
        for _ in range(fine):
            at_d, at_q = psi_d / 1.5e-3, psi_q / 2e-3
            i_d = psi_d / L_D * (1.0 + 0.2 * at_d) + 0.1 * at_q**2
            i_q = psi_q / L_Q * (1.0 + 0.2 * abs(at_q) ** power) + 0.2 * at_d * at_q * 2e-3 / 1.5e-3
            psi_d += T_S / fine * (voltage.real - R_S * i_d)
            psi_q += T_S / fine * (voltage.imag - R_S * i_q)
        at_d, at_q = psi_d / 1.5e-3, psi_q / 2e-3
        i_d = psi_d / L_D * (1.0 + 0.2 * at_d) + 0.1 * at_q**2
        i_q = psi_q / L_Q * (1.0 + 0.2 * abs(at_q) ** power) + 0.2 * at_d * at_q * 2e-3 / 1.5e-3
        currents.append(complex(i_d, i_q))
    noise = np.random.default_rng(7).normal(0.0, 0.002, (n + 1, 3))
    return Turning(u, phases_of(np.array(currents)) + noise)


@pytest.mark.parametrize("power", [1, 2])
def test_inductances_without_current_of_iron_that_saturates(power: int) -> None:
    L_d, _, L_q, u_q = estimated([saturating(14.0, 3.0, power), saturating(31.0, 1.5, power)])
    assert L_d == pytest.approx(L_D, rel=0.004)
    assert L_q == pytest.approx(L_Q, rel=0.01)
    assert u_q < 0.005 * L_Q


def test_the_uncertainty_of_the_inductances_holds(captures: list[Turning]) -> None:
    rng = np.random.default_rng(8)
    L_d0, _, L_q0, _ = estimated(captures)
    d, q = [], []
    for _ in range(REPETITIONS // 2):
        noisy = [
            Turning(each.u_V, each.readings_A + rng.normal(0.0, 0.01, each.readings_A.shape))
            for each in captures
        ]
        L_d, u_d, L_q, u_q = estimated(noisy)
        d.append((L_d - L_d0) / u_d)
        q.append((L_q - L_q0) / u_q)
    holds(d)
    holds(q)


def test_too_little_is_said() -> None:
    with pytest.raises(AnalysisError, match="50 at least"):
        zero_current(np.zeros(10))
    with pytest.raises(AnalysisError, match="leave no scatter"):
        least_squares(np.ones((2, 2)), np.ones(2))
    along_b = phases_of(np.full(81, 1j))
    with pytest.raises(AnalysisError, match="no phase is near zero"):
        estimated([Turning(np.full(80, 1j), along_b)])
