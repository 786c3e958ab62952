"""Which captures make a second opinion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.balances import FluxBalance
from benchtool.block import Block, Channel
from benchtool.commission import second_opinion
from benchtool.commission.known import Known
from benchtool.commission.second_opinion import balanced
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
