"""Which captures make a second opinion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement
from benchtool.analysis.balances import FluxBalance
from benchtool.block import Block, Channel
from benchtool.commission import second_opinion
from benchtool.commission.known import Known
from benchtool.commission.second_opinion import balanced, without_harmonics
from benchtool.errors import AnalysisError
from benchtool.profile import Motor, load_profile

KNOWN = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
THETA_M: NDArray[np.float64] = np.linspace(0.0, 6.0, 600)


def capture() -> Block:
    return Block((Channel("theta_m", "rad"),), 0, 1, 1e-4, THETA_M[:, np.newaxis])


class Told:
    """A balance that tells psi_r, and of R_s only why not."""

    unexplained_V, current_A, omega_e_rad_s = 0.6, 2.0, 100.0

    @property
    def solution(self) -> Told:
        return self

    def why_not(self, name: str) -> str:
        return "" if name == "psi_r" else "this capture has one level of current"

    def value(self, name: str) -> float:
        return 0.17

    def standard(self, name: str) -> float:
        return 0.001


@pytest.mark.parametrize(("refused", "told"), [(0, True), (3, True), (4, False), (5, False), (6, False)])
def test_what_fewer_than_half_of_the_captures_tell_is_no_second_opinion(
    refused: int, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = [True] * refused + [False] * (6 - refused)

    def balance(block: Block, motor: Motor) -> FluxBalance | Told:
        if answers.pop():
            raise AnalysisError("7 % of the voltage are not explained")
        return Told()

    monkeypatch.setattr(second_opinion, "flux_balance", balance)
    R_s, psi_r = balanced([capture()] * 6, KNOWN)
    assert R_s.name == "balance_R_s"
    assert np.isnan(R_s.value)
    assert np.isfinite(psi_r.value) == told
    if told:
        assert psi_r.uncertainty is not None
        assert psi_r.uncertainty.standard == pytest.approx(np.hypot(0.001, 0.006))
    else:
        assert f"{6 - refused} of 6 captures" in (psi_r.reason or "")
        assert "7 % of the voltage" in (psi_r.reason or "")


def test_voltages_without_the_harmonics_of_the_emf_are_those_of_the_fundamental() -> None:
    """The EMF of a tick is what the flux of the rotor changes by, over the tick."""
    p, T_s, psi_5, psi_7 = KNOWN.motor.pole_pairs, 1e-4, 3e-3 + 1e-3j, -2e-3j
    omega_m = np.linspace(20.0, 60.0, 2001)
    theta_m = np.concatenate([[0.3], 0.3 + np.cumsum(0.5 * (omega_m[1:] + omega_m[:-1])) * T_s])
    first, fifth, seventh = (
        np.diff(psi * np.exp(1j * order * p * theta_m)) / T_s
        for order, psi in ((1, 0.17), (-5, psi_5), (7, psi_7))
    )
    u = first + fifth + seventh
    columns = np.column_stack([theta_m[:-1] % (2.0 * np.pi), omega_m[:-1], u.real, u.imag])
    channels = (("theta_m", "rad"), ("omega_m", "rad/s"), ("u_alpha", "V"), ("u_beta", "V"))
    block = Block(tuple(Channel(*each) for each in channels), 0, 1, T_s, columns)
    parts = {
        "psi_5_cos": psi_5.real,
        "psi_5_sin": psi_5.imag,
        "psi_7_cos": psi_7.real,
        "psi_7_sin": psi_7.imag,
    }
    known = KNOWN.with_estimates({name: Measurement(name, value, "Wb", "") for name, value in parts.items()})
    left = without_harmonics(block, known)
    error = left.column("u_alpha") + 1j * left.column("u_beta") - first
    assert float(np.max(np.abs(error))) < 0.01 * float(np.max(np.abs(u - first)))
    np.testing.assert_array_equal(without_harmonics(block, KNOWN).data, block.data)
