"""What dead time and devices take, against legs that are switched in short steps of a period."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.dead_share import Spun, dead_share
from benchtool.commission.estimators.legs import Legs
from benchtool.commission.estimators.vectors import PHASES, phases_of, vector_of

T_S, U_DC, L_D, L_Q, ROTOR_RAD = 25e-6, 24.0, 3e-6, 5e-6, 0.4
EMF_V = 4.5
DEAD_V, DEVICE_V = 0.5, 0.4
STEPS, SOFT_A = 400, 0.1


def switched(
    u_V: complex,
    emf_V: complex,
    i_A: complex,
    *,
    half: int | None,
    rotor_rad: float = ROTOR_RAD,
    dead_V: float = DEAD_V,
    device_V: float = DEVICE_V,
    steps: int = STEPS,
) -> tuple[complex, complex]:
    """Return the mean voltage at the winding and the current at the end of a control period.

    Without `half` it is a whole PWM period, else the first or second half of one. A leg that waits, or whose
    device has a forward voltage, takes its potential from the sign of its current, smooth within `SOFT_A`.
    """
    phases = phases_of(np.array([u_V]))[0]
    duty = 0.5 + (phases - 0.5 * (np.max(phases) + np.min(phases))) / U_DC
    rise, fall = 0.5 * (1.0 - duty), 0.5 * (1.0 + duty)
    if half is not None:
        rise, fall = (1.0 - duty, np.full(3, 9.0)) if half == 0 else (np.full(3, -9.0), duty)
    dead = dead_V / U_DC if half is None else 2.0 * dead_V / U_DC
    step_s, i, total = T_S / steps, i_A, 0.0 + 0.0j
    for k in range(steps):
        at = (k + 0.5) / steps
        signs = np.clip(phases_of(np.array([i]))[0] / SOFT_A, -1.0, 1.0)
        waits = ((rise <= at) & (at < rise + dead)) | ((fall <= at) & (at < fall + dead))
        told = (rise <= at) & (at < fall)
        potentials = np.where(waits, 0.5 * U_DC * (1.0 - signs), U_DC * told) - device_V * signs
        u = vector_of(potentials[None, :])[0]
        total += u / steps
        left = (u - emf_V) * np.exp(-1j * rotor_rad)
        i += step_s * complex(left.real / L_D, left.imag / L_Q) * np.exp(1j * rotor_rad)
    return total, i


@pytest.mark.parametrize("double_update", [False, True])
@pytest.mark.parametrize("small_A", [-6.0, -2.0, 0.5, 3.5, 12.0])
def test_a_phase_near_zero_loses_what_its_edges_and_its_signs_make(
    double_update: bool, small_A: float
) -> None:
    """Phase b has a small current, and the EMF along it; of two halves their mean counts."""
    emf = EMF_V * PHASES[1]
    i = small_A * PHASES[1] + 30j * PHASES[1]
    asked = emf + (DEAD_V + DEVICE_V) * vector_of(np.sign(phases_of(np.array([i]))))[0]
    legs = Legs(T_S, U_DC, L_D, L_Q, DEAD_V + DEVICE_V, double_update=double_update)
    wrong = []
    for half in (0, 1) if double_update else (None,):
        mean, end = switched(asked, emf, i, half=half)
        share = DEAD_V / (DEAD_V + DEVICE_V)
        taken = legs.taken(np.array([asked]), np.array([i, end]), np.array([ROTOR_RAD]), share, emf)[0]
        wrong.append(taken - (asked - mean))
    assert abs(np.mean(wrong)) < 0.1 * (DEAD_V + DEVICE_V)


def test_with_clear_currents_it_is_the_sign_of_each() -> None:
    rng = np.random.default_rng(3)
    i = 50.0 * np.exp(1j * np.pi / 3.0 * np.arange(7))  # each phase at 25 A at least
    u = np.asarray(rng.normal(0.0, 2.0, 6) + 0j, np.complex128)
    for double in (False, True):
        legs = Legs(T_S, U_DC, 1e-3, 1e-3, 0.9, double_update=double)
        for k in range(6):
            taken = legs.taken(u[k : k + 1], np.array([i[k], i[k]]), np.zeros(1), 0.4)
            expected: NDArray[np.complex128] = 0.9 * vector_of(np.sign(phases_of(i[k : k + 1])))
            assert taken == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("share", [0.2, 0.7])
def test_a_turning_motor_tells_which_part_is_the_dead_time(share: float) -> None:
    """A current along the flux and its ripple, of a machine that turns once and a third."""
    drop, n, turns_rad = DEAD_V + DEVICE_V, 60, 0.14
    rotor: NDArray[np.float64] = turns_rad * np.arange(0.5, n)
    emf = 1j * EMF_V * np.exp(1j * rotor)
    asked, currents = [], [8.0 + 1.0j]
    for k in range(n):
        i, along = currents[-1], (8.0 + 1.0j) * np.exp(1j * turns_rad * (k + 1))
        signs = vector_of(np.sign(phases_of(np.array([along]))))[0]
        asked.append(emf[k] + drop * signs + 0.5 * (along - i) * L_D / T_S)
        step = {"rotor_rad": float(rotor[k]), "dead_V": share * drop, "device_V": (1.0 - share) * drop}
        currents.append(switched(asked[-1], complex(emf[k]), i, half=None, steps=160, **step)[1])
    spun = Spun(np.array(asked), np.array(currents), rotor, emf, np.arange(n))
    found = dead_share([spun], Circuit(T_S, 0.0, drop, U_DC), L_D, L_Q)
    assert found.value == pytest.approx(share, abs=3.0 * found.standard)
    assert found.standard < 0.15


def test_where_nothing_tells_the_share_it_may_be_any() -> None:
    u, i = np.full(20, 1.0 + 0j), np.full(21, 50.0 + 20j)
    spun = Spun(u, i, 0.1 * np.arange(20.0), np.zeros(20, np.complex128), np.arange(20))
    found = dead_share([spun], Circuit(T_S, 0.0, 0.0, U_DC), 1e-3, 1e-3)
    assert (found.value, found.standard) == pytest.approx((0.5, 12.0**-0.5))
