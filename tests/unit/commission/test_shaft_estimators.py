"""Estimators of encoder, rotor flux and mechanics on data with a known truth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.commission.estimators.alignment import Spin, alignment, continued, motion
from benchtool.commission.estimators.cogging import cogging
from benchtool.commission.estimators.flux_linkage import harmonics, rotor_flux, turning_flux
from benchtool.commission.estimators.mechanics import Course, mechanics
from benchtool.errors import AnalysisError

P, SWINGS = 7, 12.3


def spins(
    offset_rad: float,
    direction: int,
    lag_rad: float = 0.1,
    eccentric_rad: float = 0.01,
    *,
    turns: float = 2.0,
    swing_rad: float = 0.0,
    swings: float = SWINGS,
    phases_rad: tuple[float, float] = (0.0, 0.0),
    slip: float = 0.0,
) -> list[Spin]:
    """A rotor that is dragged round each way, read by 10 000 counts with an eccentric disc.

    It swings about the current `swings` times with an electrical amplitude that dies down to a third, and is
    shown ahead by a share `slip` of its way.
    """
    found = []
    for sense, phase in zip((1, -1), phases_rad, strict=True):
        along = np.linspace(0.0, 1.0, 3000)
        current = sense * 2.0 * math.pi * P * turns * along + 0.3
        swing = swing_rad * 3.0**-along * np.sin(2.0 * math.pi * swings * along + phase)
        shaft = (current - sense * lag_rad + swing) / P * (1.0 + slip)
        shown = shaft + offset_rad
        shown = shown + eccentric_rad * np.cos(shaft - 0.4)
        count = np.floor(direction * shown * 10_000 / (2.0 * math.pi)) + 0.5
        theta = count % 10_000 * 2.0 * math.pi / 10_000
        found.append(Spin(theta, np.angle(np.exp(1j * current)), np.ones(3000), sense))
    return found


@pytest.mark.parametrize(("offset_rad", "direction"), [(0.2, 1), (-2.9, -1), (1.234, -1)])
def test_offset_is_free_of_friction_and_of_an_eccentric_disc(offset_rad: float, direction: int) -> None:
    both = spins(offset_rad, direction)
    moved = motion(both, SWINGS)
    assert math.copysign(1.0, moved.per_rad) == direction
    assert 1.0 / abs(moved.per_rad) == pytest.approx(P, rel=0.002)
    assert moved.jump_rad == 0.0
    found = alignment(both, P, direction)
    period = 2.0 * math.pi / P
    error = found.offset_rad - offset_rad
    assert abs(error - period * round(error / period)) < math.radians(0.1) / P
    assert found.lag_rad == pytest.approx(0.1, abs=0.005)
    assert found.errors_rad is not None
    ahead = 0.4 + offset_rad - found.offset_rad  # theta_m is in whole electrical revolutions off the shaft
    assert abs(found.errors_rad[0] - 0.01 * complex(math.cos(ahead), math.sin(ahead))) < 3e-4


def test_a_swing_of_the_rotor_differs_both_ways_as_an_eccentric_disc_does_not() -> None:
    """A rotor that swung nearly twice in a revolution looked like a disc of 9 mrad, told to 0.5 mrad."""
    calm = alignment(spins(0.2, 1), P, 1)
    assert calm.apart_rad is not None
    assert max(calm.apart_rad) < 3e-4
    shares = []
    for phases in np.random.default_rng(3).uniform(-math.pi, math.pi, (20, 2)):
        swinging = spins(0.2, 1, swing_rad=0.5, phases_rad=(phases[0], phases[1]), swings=3.8)
        found = alignment(swinging, P, 1)
        assert found.errors_rad is not None
        assert found.apart_rad is not None
        assert abs(found.errors_rad[1]) > 10.0 * found.error_standard_rad / 2.0
        shares.append(abs(found.errors_rad[1]) / found.apart_rad[1])
    assert float(np.median(shares)) < 1.0


def test_a_rotor_that_swings_about_the_current_has_the_pole_pairs_that_it_has() -> None:
    """From end to end they were 4.3 stated standard uncertainties off: the swings at the ends."""
    phases = np.random.default_rng(5).uniform(-math.pi, math.pi, (15, 2))
    z = []
    for on, back in phases:
        swinging = spins(0.2, 1, swing_rad=1.0, eccentric_rad=0.02, phases_rad=(on, back))
        moved = motion(swinging, SWINGS)
        z.append((moved.per_rad - 1.0 / P) / moved.per_rad_standard)
        assert 1.0 / moved.per_rad == pytest.approx(P, rel=0.01)
    assert 0.4 < float(np.sqrt(np.mean(np.square(z)))) < 1.3
    assert float(np.max(np.abs(z))) < 3.5


@pytest.mark.parametrize("turns", [1.02, 2.0, 5.0])
def test_a_slip_of_three_percent_is_no_whole_number(turns: float) -> None:
    moved = motion(spins(0.2, 1, swing_rad=0.2, turns=turns, slip=0.03), SWINGS)
    assert moved.error_left == (turns < 1.5)
    off = abs(moved.per_rad - 1.0 / P)
    assert off > 4.0 * moved.per_rad_standard if turns > 1.5 else off > 1.5 * moved.per_rad_standard


def test_of_a_part_of_a_revolution_an_eccentric_disc_is_in_the_slope_and_said_to_be() -> None:
    moved = motion(spins(0.2, 1, turns=0.7, eccentric_rad=0.02, swing_rad=0.05), SWINGS)
    assert moved.error_left
    off = abs(moved.per_rad * P - 1.0)
    chord = 2.0 * 0.02 * abs(math.sin(0.5 * moved.moved_rad)) / moved.moved_rad
    assert 0.001 < off < chord + 4.0 * moved.per_rad_standard * P


def test_the_offset_is_that_of_the_calm_revolutions() -> None:
    """A rotor that is dragged off swings by a hundred degrees, and its mean meanwhile is no rest."""
    on, back = spins(0.2, 1, turns=6.0)
    kicked = np.exp(-8.0 * np.linspace(0.0, 1.0, 3000)) * (0.3 + 1.7 * np.sin(np.linspace(0.0, 200.0, 3000)))
    found = alignment([replace(on, theta_m_rad=(on.theta_m_rad + kicked / P) % (2.0 * math.pi)), back], P, 1)
    assert abs(found.offset_rad - 0.2) < math.radians(0.15) / P
    assert found.ripple_rad > 0.2
    assert found.lag_rad == pytest.approx(0.1, abs=0.005)


def test_a_counter_that_wraps_elsewhere_leaps() -> None:
    """1024 lines where 2500 are believed: the angle goes to 2.57 rad and back to zero."""
    count = np.arange(0.0, 9000.0, 7.0)
    theta = count % 4096 * 2.0 * math.pi / 10_000
    straight, leap = continued(theta)
    assert abs(leap) == pytest.approx(4096 * 2.0 * math.pi / 10_000, abs=0.02)
    assert np.ptp(np.diff(straight)) == pytest.approx(0.0, abs=1e-9)


def test_one_way_alone_does_not_tell_friction_from_the_offset() -> None:
    with pytest.raises(AnalysisError, match="both ways"):
        alignment(spins(0.1, 1)[:1], P, 1)


R_S, L_D, L_Q, PSI, T_S = 0.2, 1e-4, 1.7e-4, 5e-3, 5e-5


def turning(
    omega_e: float, standing_A: float = 0.0
) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.float64]]:
    """Voltages and currents of a salient machine with a fifth harmonic and a constant voltage error."""
    n = 4000
    t = T_S * np.arange(n)
    theta = omega_e * t + 0.7
    i_dq = standing_A + 8.0 * np.sin(2.0 * math.pi * 11.0 * t) + 1.5j
    rotor = np.exp(1j * theta)
    flux = (PSI + L_D * i_dq.real + 1j * L_Q * i_dq.imag) * rotor + 0.02 * PSI * np.exp(-5j * theta)
    i = i_dq * rotor
    u = np.diff(flux) / T_S + R_S * 0.5 * (i[1:] + i[:-1]) + (0.05 - 0.02j)
    return np.asarray(u, np.complex128), np.asarray(i, np.complex128), np.asarray(theta, np.float64)


@pytest.mark.parametrize("omega_e", [900.0, -400.0])
def test_the_rotor_flux_needs_no_angle_and_no_exact_inductance(omega_e: float) -> None:
    u, i, theta = turning(omega_e)
    found = turning_flux(u, i, T_s=T_S, R_s_ohm=R_S, L_d_H=1.3 * L_D, L_q_H=L_Q)
    assert found.psi_r_Wb == pytest.approx(PSI, rel=2e-3)
    assert abs(found.psi_r_Wb - PSI) < 4.0 * found.psi_r_standard_Wb
    assert found.L_d_H == pytest.approx(L_D, rel=0.03)
    assert found.omega_e_rad_s == pytest.approx(omega_e, rel=1e-3)
    away = np.angle(np.mean(np.exp(1j * (found.angle_rad - theta))))
    assert abs(away) < math.radians(0.3)
    flux_Wb = rotor_flux(found.active_Wb, i, theta, L_D - L_Q)
    assert harmonics(flux_Wb, theta)[-5] == pytest.approx(0.02 * PSI, abs=2e-3 * PSI)


@pytest.mark.parametrize("omega_e", [900.0, -400.0])
def test_a_salient_rotor_makes_no_harmonics_of_others_by_a_standing_current(omega_e: float) -> None:
    """By the angle of the flux, which the fifth turns to and fro, a seventh of 5 % of it was seen."""
    u, i, theta = turning(omega_e, standing_A=10.0)
    found = turning_flux(u, i, T_s=T_S, R_s_ohm=R_S, L_d_H=L_D, L_q_H=L_Q)
    flux_Wb = rotor_flux(found.active_Wb, i[found.rows], theta[found.rows], L_D - L_Q)
    of_orders = harmonics(flux_Wb, theta[found.rows])
    assert abs(of_orders[-5] - 0.02 * PSI) < 0.01 * 0.02 * PSI
    assert abs(of_orders[7]) < 0.01 * 0.02 * PSI


def test_a_motor_that_stands_has_no_circle() -> None:
    rng = np.random.default_rng(2)
    i = np.asarray(rng.normal(0.0, 0.1, 1000) + 1j * rng.normal(0.0, 0.1, 1000), np.complex128)
    u = np.asarray(rng.normal(0.0, 0.1, 999) + 0.1j, np.complex128)
    with pytest.raises(AnalysisError, match="does not turn"):
        turning_flux(u, i, T_s=T_S, R_s_ohm=R_S, L_d_H=L_D, L_q_H=L_Q)


J, COULOMB, FRICTION, LOAD = 3e-4, 0.02, 1e-4, 0.003


def reversal(omega: float, noise_Nm: float, rng: np.random.Generator) -> Course:
    """On, back and on: a first-order lag towards each setpoint, with the torque that this takes."""
    step_s, level = 1e-4, 15_000  # the torque leaps at a setpoint: a tenth of a millisecond is 0.2 % of J
    t = step_s * np.arange(level)
    speeds, accelerations, start = [], [], 0.0
    for target in (omega, -omega, omega):
        decay = np.exp(-t / 0.03)
        speeds.append(target + (start - target) * decay)
        accelerations.append(-(start - target) / 0.03 * decay)
        start = target
    speed, acceleration = np.concatenate(speeds), np.concatenate(accelerations)
    theta = step_s * np.cumsum(speed)
    torque = J * acceleration + COULOMB * np.sign(speed) + FRICTION * speed + LOAD
    torque += rng.normal(0.0, noise_Nm, len(torque)) + 0.01 * np.sin(12.0 * theta)
    return Course(theta, torque, step_s, (level, 2 * level, 3 * level), 12_000)


def test_inertia_and_friction_of_a_shaft_that_is_reversed() -> None:
    rng = np.random.default_rng(4)
    found = mechanics([reversal(omega, 0.01, rng) for omega in (20.0, 50.0, 80.0, 110.0)])
    for value, standard, true, tolerance in (
        (found.J_kgm2, found.J_standard, J, 0.02),
        (found.coulomb_Nm, found.coulomb_standard, COULOMB, 0.05),
        (found.friction_Nms, found.friction_standard, FRICTION, 0.1),
        (found.load_Nm, found.load_standard, LOAD, 0.2),
    ):
        assert value == pytest.approx(true, rel=tolerance)
        assert abs(value - true) < 5.0 * standard


def test_a_speed_that_is_not_held_is_refused() -> None:
    t = 1e-3 * np.arange(3000)
    theta = 5.0 * t * t
    course = Course(theta, np.zeros(3000), 1e-3, (1500, 3000), 1200)
    with pytest.raises(AnalysisError, match="larger inertia"):
        mechanics([course])


COGGING = 0.03


def held_loosely(omega: float) -> Course:
    """On, back and on under a soft speed controller, with a cogging that shakes the shaft."""
    step_s, level, fine = 1e-3, 1500, 20
    theta = speed = integral = 0.0
    angles, torques = [], []
    for k in range(3 * level):
        target = omega * (1.0, -1.0, 1.0)[k // level]
        torque = 0.02 * (target - speed) + integral
        angles.append(theta)
        torques.append(torque)
        for _ in range(fine):
            torque = 0.02 * (target - speed) + integral
            integral += 0.3 * (target - speed) * step_s / fine
            takes = COULOMB * math.copysign(1.0, speed) + FRICTION * speed + COGGING * math.sin(12.0 * theta)
            speed += (torque - takes) / J * step_s / fine
            theta += speed * step_s / fine
    return Course(np.array(angles), np.array(torques), step_s, (level, 2 * level, 3 * level), 1000)


@pytest.fixture(scope="module")
def shaken() -> list[Course]:
    return [held_loosely(omega) for omega in (13.0, 20.0, 31.0)]


def test_a_shaft_that_is_slower_before_each_tooth_tells_its_friction(shaken: list[Course]) -> None:
    over_time = np.mean([course.torque_Nm[500:1500].mean() for course in shaken[:1]])
    assert over_time > 1.01 * (COULOMB + FRICTION * 13.0)  # what an average over time takes for friction
    found = mechanics(shaken)
    assert found.coulomb_Nm == pytest.approx(COULOMB, rel=0.004)
    assert found.J_kgm2 == pytest.approx(J, rel=0.06)


def test_cogging_is_told_by_its_order(shaken: list[Course]) -> None:
    found = cogging(shaken, J, 1e-3)
    assert found[0].order == 12
    assert found[0].amplitude_Nm == pytest.approx(COGGING, rel=0.05)
    assert all(each.amplitude_Nm < 0.1 * COGGING for each in found[1:])
    rng = np.random.default_rng(4)
    smooth = [replace(course, torque_Nm=rng.normal(0.0, 0.01, 4500)) for course in shaken]
    still = [replace(c, theta_m_rad=np.linspace(0.0, 60.0, 4500)) for c in smooth]
    assert not cogging(still, J, 1e-4)
