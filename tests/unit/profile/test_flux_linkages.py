"""Tables of flux linkages: of a field, or refused with the key, and followed by the machine's polynomial."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from benchtool.emulator.bench import _truth
from benchtool.emulator.flux_table import MOST_OFF, fit_flux_linkages
from benchtool.emulator.machine.saturation import SaturationTruth, flux_at
from benchtool.errors import ValueRefused
from benchtool.profile import load_profile
from benchtool.profile.emulator import TrueMotor
from benchtool.profile.flux_linkages import FluxLinkages

I_D, I_Q = tuple(range(-30, 11, 5)), tuple(range(-40, 41, 8))
PSI_R, L_D, L_Q, I_S, K = 0.1, 1.5e-3, 3e-3, 60.0, 6e-6
Map = Callable[[float, float], tuple[float, float]]


def saturating(i_d: float, i_q: float) -> tuple[float, float]:
    """A machine by the slopes of a co-energy that is no polynomial of the flux linkages."""
    return PSI_R + L_D * i_d - 0.5 * K * i_q**2, L_Q * I_S * np.tanh(i_q / I_S) - K * i_q * i_d


def table(of: Map, i_d: tuple[float, ...] = I_D, i_q: tuple[float, ...] = I_Q) -> dict[str, Any]:
    found = [[of(d, q) for q in i_q] for d in i_d]
    psi = [tuple(tuple(float(each[k]) for each in row) for row in found) for k in (0, 1)]
    return {
        "i_d_A": tuple(map(float, i_d)),
        "i_q_A": tuple(map(float, i_q)),
        "psi_d_Wb": psi[0],
        "psi_q_Wb": psi[1],
    }


def refusal(content: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as refused:
        FluxLinkages.model_validate(content)
    return str(refused.value)


@pytest.mark.parametrize(
    ("truth", "psi_r"),
    [
        (SaturationTruth(a_dd=4e6, a_qq=3e3, a_dq=8e3), 0.1),
        (SaturationTruth(a_qq=2e5, a_dq=5e5, S=2, T=3, U=0, V=1), 0.2),
    ],
)
def test_a_table_of_a_polynomial_gives_that_machine_back(truth: SaturationTruth, psi_r: float) -> None:
    exact = truth.coefficients(2e-3, 4e-3, psi_r)
    content = table(lambda d, q: flux_at(exact, d, q, None))
    FluxLinkages.model_validate(content)
    found = fit_flux_linkages(**content)
    assert (found.L_d_H, found.L_q_H, found.psi_r_Wb) == pytest.approx((2e-3, 4e-3, psi_r), rel=1e-6)
    again = found.saturation.coefficients(found.L_d_H, found.L_q_H, found.psi_r_Wb)
    for i_d, i_q in ((-12.0, 7.0), (3.0, -33.0)):
        assert flux_at(again, i_d, i_q, None) == pytest.approx(flux_at(exact, i_d, i_q, None), rel=1e-6)


def test_a_table_of_another_machine_is_followed_as_far_as_is_said() -> None:
    content = table(saturating)
    FluxLinkages.model_validate(content)
    found = fit_flux_linkages(**content)
    machine = found.saturation.coefficients(found.L_d_H, found.L_q_H, found.psi_r_Wb)
    largest = max(np.hypot(*saturating(d, q)) for d in I_D for q in I_Q)
    off = [np.subtract(flux_at(machine, d, q, None), saturating(d, q)) for d in I_D for q in I_Q]
    worst = max(np.hypot(*each) for each in off)
    assert worst == pytest.approx(found.off_Wb, rel=1e-9)
    assert 0.0 < worst <= MOST_OFF * largest
    assert found.psi_r_Wb == pytest.approx(PSI_R, abs=MOST_OFF * largest)


def test_a_table_that_no_polynomial_follows_is_refused_with_the_key() -> None:
    def abrupt(i_d: float, i_q: float) -> tuple[float, float]:
        return PSI_R + L_D * i_d, float(np.interp(i_q, (-40, -8, 8, 40), (-0.28, -0.15, 0.15, 0.28)))

    content = table(abrupt)
    FluxLinkages.model_validate(content)
    with pytest.raises(ValueRefused, match=r"^emulator.motor.flux_linkages: .* is off by"):
        fit_flux_linkages(**content)


def test_magnets_against_the_axis_are_refused_with_the_key() -> None:
    with pytest.raises(ValueRefused, match=r"^emulator.motor.flux_linkages: no machine follows"):
        fit_flux_linkages(**table(lambda d, q: (L_D * d - PSI_R, L_Q * q)))


def test_what_is_of_no_field_is_refused() -> None:
    """The sign of the cross-coupling is wrong in one of the two."""

    def wrong(i_d: float, i_q: float) -> tuple[float, float]:
        return saturating(i_d, i_q)[0], saturating(-i_d, i_q)[1]

    assert "psi_d_Wb and psi_q_Wb are of no field" in refusal(table(wrong))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"i_d_A": (-5.0, -10.0, 0.0)}, "i_d_A does not rise"),
        ({"i_q_A": (1.0, 2.0, 3.0)}, "i_q_A is from 1 to 3 A: zero is expected within"),
        ({"psi_d_Wb": ((0.1, 0.2),)}, "psi_d_Wb has 1 rows of up to 2 values: 9 rows"),
        ({"psi_d_Wb": tuple(zip(*table(saturating)["psi_d_Wb"], strict=True))}, "psi_d_Wb has 11 rows"),
    ],
)
def test_a_table_of_another_shape_is_refused(changes: dict[str, Any], said: str) -> None:
    assert said in refusal({**table(saturating), **changes})


def test_a_transposed_table_is_suspected() -> None:
    content = table(saturating, I_Q, I_Q)
    for key in ("psi_d_Wb", "psi_q_Wb"):
        content[key] = tuple(zip(*content[key], strict=True))
    assert "is the table transposed?" in refusal(content)


def test_a_bench_has_the_machine_of_its_table() -> None:
    profile = load_profile("zhu2011")
    emulator = profile.emulator
    assert emulator is not None
    stated = TrueMotor.model_validate({"flux_linkages": table(saturating), "J_kgm2": 1e-3})
    motor, _, _ = _truth(profile, emulator.model_copy(update={"motor": stated}))
    found = fit_flux_linkages(**table(saturating))
    assert (motor.psi_r_Wb, motor.L_q_H, motor.J_kgm2) == (found.psi_r_Wb, found.L_q_H, 1e-3)
    assert motor.saturation == found.saturation
    with pytest.raises(ValidationError, match="flux_linkages tells L_d_H: leave one of the two out"):
        TrueMotor.model_validate({"flux_linkages": table(saturating), "L_d_H": 1e-3})
