"""Which captures make a second opinion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.balances import FluxBalance
from benchtool.block import Block, Channel
from benchtool.commission import second_opinion
from benchtool.commission.known import Known
from benchtool.commission.second_opinion import balanced, contradictions, of_a_sine
from benchtool.errors import AnalysisError
from benchtool.profile import Motor, load_profile

KNOWN = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
T_S = 1e-4
THETA_M: NDArray[np.float64] = np.linspace(0.0, 6.0, 600)


def capture(theta_m: NDArray[np.float64] = THETA_M, u_V: NDArray[np.complex128] | None = None) -> Block:
    u = np.zeros(len(theta_m), np.complex128) if u_V is None else u_V
    channels = (Channel("theta_m", "rad"), Channel("u_alpha", "V"), Channel("u_beta", "V"))
    return Block(channels, 0, 1, T_S, np.column_stack([theta_m, u.real, u.imag]))


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


@pytest.mark.parametrize(("dof", "contradicts"), [(100.0, True), (2.0, False)])
def test_two_methods_disagree_by_more_than_few_degrees_of_freedom_make_likely(
    dof: float, contradicts: bool
) -> None:
    own = Measurement("R_s", 1.0, "ohm", "", uncertainty=Uncertainty(0.001, "fit"))
    other = Measurement("balance_R_s", 1.1, "ohm", "", uncertainty=Uncertainty(0.02, "scatter", dof))
    found = contradictions({each.name: each for each in (own, other)}, KNOWN)
    assert bool(found) is contradicts


def test_a_second_opinion_that_is_less_certain_than_large_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Told, "unexplained_V", 20.0)  # 0.2 Wb at 100 rad/s, beside 0.17 Wb
    monkeypatch.setattr(second_opinion, "flux_balance", lambda *_: Told())
    _, psi_r = balanced([capture()] * 6, KNOWN)
    assert np.isnan(psi_r.value)
    assert "with an expanded uncertainty of" in (psi_r.reason or "")


def test_harmonics_of_the_emf_are_no_voltage_that_nothing_explains() -> None:
    """By the flux linkage of a rotor that speeds up: what a row asks for acts from the next one on."""
    p, psi, psi_5, psi_7 = KNOWN.pole_pairs, 0.17, 0.004 - 0.002j, -0.003 + 0.001j
    t = T_S * np.arange(803)
    theta_m = 20.0 * t + 60.0 * t * t
    theta_e = p * theta_m

    def volts(flux: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.asarray(np.diff(flux)[1:] / T_S, np.complex128)

    sine = volts(psi * np.exp(1j * theta_e))
    others = volts(psi_5 * np.exp(-5j * theta_e) + psi_7 * np.exp(7j * theta_e))
    parts = {
        "psi_5_cos": psi_5.real,
        "psi_5_sin": psi_5.imag,
        "psi_7_cos": psi_7.real,
        "psi_7_sin": psi_7.imag,
    }
    told = KNOWN.with_estimates({name: Measurement(name, value, "Wb", "") for name, value in parts.items()})
    counts = np.floor(theta_m[:-2] * 10_000 / (2.0 * np.pi)) * 2.0 * np.pi / 10_000
    found = of_a_sine(capture(counts, sine + others), told)
    left = found.column("u_alpha") + 1j * found.column("u_beta") - sine
    assert np.sqrt(np.mean(np.abs(left[20:-20]) ** 2)) < 0.02 * np.sqrt(np.mean(np.abs(others) ** 2))
    assert found.column("theta_m") == pytest.approx(counts % (2.0 * np.pi))
