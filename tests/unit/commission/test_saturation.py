"""Inductances over the current, of a machine whose flux is a known polynomial."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.commission.estimators.saturation import Pulse, saturation
from benchtool.errors import AnalysisError

T_S, R_S, PSI, L_0, DROP = 1e-4, 0.3, 6e-3, 2e-4, 0.8
DIRECTIONS = np.exp(2j * math.pi / 3.0 * np.arange(3))


def flux(i: float, lopsided: float) -> float:
    return L_0 * i * (1.0 - lopsided * 0.02 * i - 0.006 * i * i)


def pulse(sign: int, across: bool, rng: np.random.Generator, moved_rad: float = 0.05) -> Pulse:
    """A current that grows evenly, at a rotor of an odd angle that it draws away."""
    n, lopsided = 25, 0.0 if across else 1.0
    i = sign * np.linspace(0.0, 5.0, n)
    theta = 0.2 + sign * moved_rad * (np.linspace(0.0, 1.0, n) ** 3 if across else np.zeros(n))
    axis = 1j if across else 1.0
    psi = (PSI + axis * np.array([flux(each, lopsided) for each in i])) * np.exp(1j * theta)
    vectors = axis * i * np.exp(1j * theta)
    phases = (vectors[:, None] * DIRECTIONS.conj()).real
    drops = np.sign(phases) @ DIRECTIONS * (2.0 / 3.0)
    u = np.diff(psi) / T_S + R_S * 0.5 * (vectors[1:] + vectors[:-1]) + DROP * drops[1:]
    return Pulse(np.asarray(u, np.complex128), phases + rng.normal(0.0, 0.02, phases.shape), theta)


@pytest.mark.parametrize("across", [False, True])
def test_a_saturating_axis(across: bool) -> None:
    rng = np.random.default_rng(1)
    pulses = [pulse(sign, across, rng) for sign in (1, -1, 1, -1)]
    at = np.array([-4.0, -2.0, 2.0, 4.0])
    found = saturation(
        pulses, at, T_s=T_S, R_s_ohm=R_S, psi_r_Wb=PSI, drop_V=DROP, gains=np.ones(3), across=across
    )
    true = np.array([flux(each, 0.0 if across else 1.0) / each for each in at])
    assert pytest.approx(true, rel=0.01) == found.L_H
    assert np.all(np.abs(found.L_H - true) < 5.0 * found.standard_H)


def test_a_rotor_that_turns_within_a_pulse_is_refused() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(AnalysisError, match="hold the shaft"):
        saturation(
            [pulse(1, True, rng, moved_rad=0.8)],
            np.array([2.0]),
            T_s=T_S,
            R_s_ohm=R_S,
            psi_r_Wb=PSI,
            drop_V=DROP,
            gains=np.ones(3),
            across=True,
        )
