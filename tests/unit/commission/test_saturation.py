"""Inductances over the current, of a machine whose flux linkages are the slopes of a known energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.saturation import Pulse, Saturation, saturation
from benchtool.errors import AnalysisError

T_S, R_S, PSI, L_0, DROP = 1e-4, 0.3, 6e-3, 2e-4, 0.8
DIRECTIONS = np.exp(2j * math.pi / 3.0 * np.arange(3))
AT_A = np.array([-4.0, -2.0, 2.0, 4.0])
CROSS = -0.06 * L_0


def own(i: NDArray[np.floating], *, across: bool) -> NDArray[np.floating]:
    """The inductance along an axis without current along the other."""
    share: NDArray[np.floating] = 1.0 - 0.03 * np.abs(i) if across else 1.0 - 0.02 * i - 0.006 * i * i
    return L_0 * share


def pulse(
    sign: int,
    across: bool,
    rng: np.random.Generator,
    moved_rad: float = 0.05,
    aside: complex = 1.0,
    cross: float = 0.0,
) -> Pulse:
    """A current that grows evenly, at a rotor of an odd angle that it draws away; a share of it, by `aside`,
    goes along the other axis."""
    n = 25
    i = (1j if across else 1.0) * aside * sign * np.linspace(0.0, 5.0, n)
    theta = 0.3 + sign * moved_rad * (np.linspace(0.0, 1.0, n) ** 3 if across else np.zeros(n))
    psi_d = own(i.real, across=False) * i.real + 0.5 * cross * i.imag**2
    psi_q = own(i.imag, across=True) * i.imag + cross * i.real * i.imag
    psi = (PSI + psi_d + 1j * psi_q) * np.exp(1j * theta)
    vectors = i * np.exp(1j * theta)
    phases = (vectors[:, None] * DIRECTIONS.conj()).real
    drops = np.sign(phases) @ DIRECTIONS * (2.0 / 3.0)
    u = np.diff(psi) / T_S + R_S * 0.5 * (vectors[1:] + vectors[:-1]) + DROP * drops[1:]
    return Pulse(np.asarray(u, np.complex128), phases + rng.normal(0.0, 0.002, phases.shape), theta)


def found(aside: complex = 1.0, cross: float = 0.0, moved_rad: float = 0.05) -> Saturation:
    rng = np.random.default_rng(1)
    along, across = (
        [pulse(sign, axis, rng, moved_rad, aside, cross) for sign in (1, -1, 1, -1)] for axis in (False, True)
    )
    return saturation(along, across, AT_A, Circuit(T_S, R_S, DROP, 48.0), PSI)


@pytest.mark.parametrize(
    ("aside", "cross"), [(1.0, 0.0), (np.exp(0.15j), 0.0), (np.exp(0.15j), CROSS), (np.exp(-0.15j), CROSS)]
)
def test_an_inductance_is_that_without_current_along_the_other_axis(aside: complex, cross: float) -> None:
    """A seventh of the current goes there: psi_q over i_q alone is 4 % off."""
    curves = found(aside, cross)
    for curve, across in ((curves.along, False), (curves.across, True)):
        true = own(AT_A, across=across)
        assert pytest.approx(true, rel=0.012) == curve.L_H
        assert np.all(np.abs(curve.L_H - true) < 5.0 * curve.standard_H)
    if cross or abs(aside.imag) > 0.0:
        assert abs(curves.cross_H_A - cross) < 5.0 * curves.cross_standard_H_A < 0.5 * abs(CROSS)


def test_a_rotor_that_turns_within_a_pulse_is_refused() -> None:
    with pytest.raises(AnalysisError, match="hold the shaft"):
        found(moved_rad=0.8)
