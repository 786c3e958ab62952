"""Operating points against a search over the plane of the currents that knows nothing of their equations."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.control.field_weakening import Limits, reference
from benchtool.emulator.control.flux import flux_reference, least_current, most_torque, operating_point

PSI_R, L_D, P = 0.1, 4e-3, 4
SALIENCIES = [0.5, 0.7, 0.99, 1.0, 1.01, 1.5, 2.0, 2.5, 3.0, 4.0]  # L_q / L_d
TORQUES = [-12.0, -6.0, -0.65, 0.0, 1e-3, 0.65, 3.0, 6.0, 12.0]


class Drive(NamedTuple):
    """What the functions read of the drive's memory, in double precision."""

    psi_r: float = PSI_R
    L_d: float = L_D
    L_q: float = L_D
    R_s: float = 0.2
    pole_pairs: int = P
    psi_s_command: float = 0.0


def machine(saliency: float, **given: Any) -> Drive:
    return Drive(L_q=saliency * L_D, **given)


def torque_of(i_d: Any, i_q: Any, drive: Drive) -> Any:
    return 1.5 * P * i_q * (drive.psi_r + (drive.L_d - drive.L_q) * i_d)


def flux_of(i_d: Any, i_q: Any, drive: Drive) -> Any:
    return np.hypot(drive.psi_r + drive.L_d * i_d, drive.L_q * i_q)


def voltage_of(i_d: Any, i_q: Any, omega_e: float, drive: Drive) -> Any:
    u_d = drive.R_s * i_d - omega_e * drive.L_q * i_q
    u_q = drive.R_s * i_q + omega_e * (drive.psi_r + drive.L_d * i_d)
    return np.hypot(u_d, u_q)


def narrowed(cost: Any, centre: float, width: float) -> float:
    """Argument of the least cost: a search on ever finer grids."""
    for _ in range(60):
        grid: NDArray[np.float64] = centre + np.linspace(-width, width, 41)
        centre = float(grid[int(np.argmin(cost(grid)))])
        width *= 0.5
    return centre


def searched_least_current(torque: float, drive: Drive) -> float:
    """The least magnitude of the current: over i_d, with i_q from the torque."""

    def current(i_d: NDArray[np.float64]) -> Any:
        active = 1.5 * P * (drive.psi_r + (drive.L_d - drive.L_q) * i_d)
        return np.where(active > 0.0, np.hypot(i_d, torque / np.where(active > 0.0, active, 1.0)), np.inf)

    i_d = narrowed(current, 0.0, 100.0)
    return float(current(np.array([i_d]))[0])


@pytest.mark.parametrize("saliency", SALIENCIES)
@pytest.mark.parametrize("torque", TORQUES)
def test_no_current_is_less_that_makes_the_torque(torque: float, saliency: float) -> None:
    drive = machine(saliency)
    i_d, i_q = least_current(torque, drive)
    assert torque_of(i_d, i_q, drive) == pytest.approx(torque, rel=1e-9, abs=1e-12)
    assert math.hypot(i_d, i_q) == pytest.approx(searched_least_current(torque, drive), rel=1e-6, abs=1e-9)
    assert flux_reference(torque, drive) == pytest.approx(float(flux_of(i_d, i_q, drive)), rel=1e-12)


def test_the_flux_of_least_current_of_an_interior_magnet_machine() -> None:
    """6 N·m on 0.1 Wb, 4 and 10 mH; the least current there is 8.45 A."""
    drive = Drive(L_q=10e-3)
    assert flux_reference(6.0, drive) == pytest.approx(0.1197, abs=1e-4)
    assert operating_point(6.0, flux_reference(6.0, drive), drive)[2] is False


@pytest.mark.parametrize("saliency", [0.5, 2.5])
def test_a_machine_without_magnets_makes_its_torque_by_saliency(saliency: float) -> None:
    drive = machine(saliency, psi_r=0.0)
    i_d, i_q = least_current(6.0, drive)
    assert torque_of(i_d, i_q, drive) == pytest.approx(6.0)
    assert abs(i_d) == pytest.approx(abs(i_q))


@pytest.mark.parametrize("saliency", SALIENCIES)
def test_most_torque_of_a_current(saliency: float) -> None:
    drive = machine(saliency)
    angles = np.linspace(0.0, math.pi, 200_001)
    best = torque_of(12.0 * np.cos(angles), 12.0 * np.sin(angles), drive).max()
    i_d, i_q = most_torque(12.0, drive)
    assert math.hypot(i_d, i_q) == pytest.approx(12.0)
    assert torque_of(i_d, i_q, drive) == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("psi_s", [0.05, 0.08, 0.1, 0.12, 0.1997, 0.25])
@pytest.mark.parametrize("saliency", SALIENCIES)
def test_a_point_of_given_flux_is_the_one_of_least_current(saliency: float, psi_s: float) -> None:
    """Against every angle of the flux: the torque, the least current of those that make it, the pull-out."""
    drive = machine(saliency)
    delta = np.linspace(-math.pi, math.pi, 100_001)
    i_d, i_q = (psi_s * np.cos(delta) - PSI_R) / L_D, psi_s * np.sin(delta) / drive.L_q
    made = torque_of(i_d, i_q, drive)
    for torque in TORQUES:
        psi_d, psi_q, clipped = operating_point(torque, psi_s, drive)
        assert math.hypot(psi_d, psi_q) == pytest.approx(psi_s, rel=1e-9)
        point = (psi_d - PSI_R) / L_D, psi_q / drive.L_q
        nearest = math.copysign(min(abs(torque), float(made.max())), torque)
        assert torque_of(*point, drive) == pytest.approx(nearest, rel=1e-6, abs=1e-6)
        assert clipped == (abs(torque) > made.max() * (1.0 + 1e-9))
        before = np.flatnonzero(np.diff(np.sign(made - nearest)) != 0)
        after = before + 1
        part = (nearest - made[before]) / (made[after] - made[before])
        crossing = [i[before] + part * (i[after] - i[before]) for i in (i_d, i_q)]
        least = np.hypot(*crossing).min(initial=np.inf)
        assert math.hypot(*point) <= least + 1e-3


# ---- within the limits -----------------------------------------------------------------------------------

CURRENT = 12.0


def searched_torque(torque: float, omega_e: float, u: float, drive: Drive, current: float = CURRENT) -> float:
    """The torque nearest to `torque` within both limits: over i_d, the torques of all i_q, by bisection."""
    i_d = np.linspace(-current, current, 20_001)
    side = math.copysign(1.0, torque)
    ends = []
    a = drive.R_s**2 + (omega_e * drive.L_q) ** 2 + 1e-12
    psi_d = drive.psi_r + drive.L_d * i_d
    b = omega_e * drive.R_s * (psi_d - drive.L_q * i_d)
    c = (drive.R_s * i_d) ** 2 + (omega_e * psi_d) ** 2 - u * u
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    reachable = b * b - a * c >= 0.0
    circle = np.sqrt(current**2 - i_d * i_d)
    high, low = np.minimum((root - b) / a, circle), np.maximum((-root - b) / a, -circle)
    reachable &= high >= low
    for i_q in (high, low):
        ends.append(side * torque_of(i_d, i_q, drive)[reachable])
    most = max(float(end.max()) for end in ends)
    return side * min(abs(torque), most)


@pytest.mark.parametrize("saliency", [0.5, 1.0, 1.5, 2.5, 4.0])
@pytest.mark.parametrize("omega_e", [-900.0, -300.0, 0.0, 200.0, 450.0, 700.0, 1000.0])
@pytest.mark.parametrize("R_s", [0.0, 0.2, 1.5])
def test_the_torque_within_the_limits_is_the_nearest_there_is(
    R_s: float, omega_e: float, saliency: float
) -> None:
    the_nearest_is_made(machine(saliency, R_s=R_s), omega_e, CURRENT)


@pytest.mark.parametrize("saliency", [0.5, 1.0, 2.5, 4.0])
@pytest.mark.parametrize("omega_e", [-1500.0, 700.0, 1000.0])
@pytest.mark.parametrize("R_s", [0.0, 0.4])
def test_with_current_to_spare_the_torque_is_the_most_that_the_voltage_makes(
    R_s: float, omega_e: float, saliency: float
) -> None:
    """More than psi_r / L_d, 25 A: the most torque per volt lies within the circle of the current."""
    the_nearest_is_made(machine(saliency, R_s=R_s), omega_e, 40.0)


def the_nearest_is_made(drive: Drive, omega_e: float, current: float) -> None:
    u = 60.0
    for torque in TORQUES:
        made, psi_s, clipped = reference(torque, 0.0, omega_e, Limits(u, current), drive)
        nearest = searched_torque(torque, omega_e, u, drive, current)
        if torque != 0.0:
            assert made / torque <= 1.0
            assert made / torque >= nearest / torque - 1e-9  # no point of the search is better
        assert clipped == (made != pytest.approx(torque, rel=1e-9))
        psi_d, psi_q, beyond = operating_point(made * (1.0 - 1e-12), psi_s, drive)
        assert not beyond
        point = (psi_d - PSI_R) / drive.L_d, psi_q / drive.L_q
        assert math.hypot(*point) <= current * (1.0 + 1e-6)
        assert voltage_of(*point, omega_e, drive) <= u * (1.0 + 1e-6)
