"""Connections told by what each current sensor reads of a voltage that turns."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.commission.estimators.connections import Fault, diagnosis, response
from benchtool.errors import AnalysisError

R_OHM, L_H, OMEGA_E, T_S = 0.1, 1e-4, 4000.0, 1e-4


def readings(
    u_V: NDArray[np.complex128], phases_ohm: tuple[float, float, float], saliency: float, axis_rad: float
) -> NDArray[np.float64]:
    """The phase currents of a salient machine at standstill with resistance in series with its phases, by
    steps of a twentieth of a period."""
    directions = np.exp(2j * math.pi / 3.0 * np.arange(3))
    i, found, fine = 0.0j, [np.zeros(3)], 20
    mean = 0.5 * (1.0 + saliency) / saliency / L_H  # of 1/L_d and 1/L_q
    apart = 0.5 * (1.0 - 1.0 / saliency) / L_H
    for u in u_V:
        for _ in range(fine):
            x = (i * directions.conj()).real
            ohmic = complex(np.sum(np.array(phases_ohm) * x * directions) * 2.0 / 3.0)
            left = u - ohmic
            i += T_S / fine * (mean * left + apart * np.exp(2j * axis_rad) * left.conjugate())
        found.append((i * directions.conj()).real)
    return np.array(found)


def ramp(n: int = 240) -> NDArray[np.complex128]:
    k = np.arange(n)
    return np.asarray(5.0 * k / n * np.exp(1j * OMEGA_E * T_S * k), np.complex128)


def told(phases_A: NDArray[np.float64], rng: np.random.Generator) -> tuple[Fault, int]:
    noisy = phases_A + rng.normal(0.0, 0.03 * np.max(np.abs(phases_A)), phases_A.shape)
    return diagnosis(response(ramp(), noisy), R_OHM, L_H, OMEGA_E)


@pytest.mark.parametrize(("saliency", "axis_rad"), [(1.0, 0.0), (2.5, 0.0), (2.5, 1.1), (2.0, 2.2)])
def test_a_machine_however_salient_is_connected(saliency: float, axis_rad: float) -> None:
    healthy = readings(ramp(), (R_OHM,) * 3, saliency, axis_rad)
    rng = np.random.default_rng(3)
    assert told(healthy * [1.02, 0.98, 1.0], rng)[0] is Fault.NONE
    for k in range(3):
        reversed_one, dead = healthy.copy(), healthy.copy()
        reversed_one[:, k] *= -1.0
        dead[:, k] = 0.0
        assert told(reversed_one, rng) == (Fault.REVERSED, k)
        assert told(dead, rng) == (Fault.DEAD, k)
    assert told(-healthy, rng)[0] is Fault.ALL_REVERSED
    for order in ((1, 0, 2), (0, 2, 1), (2, 1, 0), (1, 2, 0), (2, 0, 1)):
        assert told(healthy[:, order], rng)[0] is Fault.ORDER
    assert told(healthy * [1.0, 0.5, 1.0], rng)[0] is Fault.GAIN


@pytest.mark.parametrize("k", [0, 1, 2])
def test_an_open_phase_carries_nothing(k: int) -> None:
    phases = tuple(20.0 if j == k else R_OHM for j in range(3))
    currents = readings(ramp(), (phases[0], phases[1], phases[2]), 1.4, 0.4)
    assert told(currents, np.random.default_rng(5)) == (Fault.OPEN, k)


def test_an_open_end_need_not_insulate() -> None:
    """A resistance of six times the impedance of the winding, as an open end with a filter across it."""
    currents = readings(ramp(), (6.0 * OMEGA_E * L_H, R_OHM, R_OHM), 1.0, 0.0)
    assert told(currents, np.random.default_rng(6)) == (Fault.OPEN, 0)


def test_too_few_periods_tell_nothing() -> None:
    with pytest.raises(AnalysisError, match="50 are needed"):
        response(ramp(40), np.zeros((41, 3)))
