"""Harmonics of the rotor flux, and what is in their uncertainty."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.block import Block
from benchtool.commission.estimators.flux_linkage import TurningFlux
from benchtool.commission.known import Known
from benchtool.commission.steps.flux_harmonics import flux_harmonics
from benchtool.profile import load_profile

MOTOR = load_profile("zhu2011").motor
KNOWN = Known(MOTOR, 1e-4, 122.6)
PSI_WB, PSI_5_WB, ROUNDED_WB = MOTOR.psi_r_Wb, 0.01 * MOTOR.psi_r_Wb, 1e-4
CURRENTS = dict.fromkeys(("i_a", "i_b", "i_c"), "A")


def captures(
    share: float = 1.0, noise: float = 0.0, harmonic_A: float = 0.0
) -> tuple[list[Block], list[TurningFlux]]:
    """Both directions of a motor with a fifth harmonic, of which a share is seen, at 1 A along its flux."""
    rng, blocks, turning = np.random.default_rng(4), [], []
    for omega in (30.0, -30.0):
        theta_m = omega * 1e-4 * np.arange(6001)
        theta_e = MOTOR.pole_pairs * theta_m
        along = np.exp(1j * theta_e) + harmonic_A * np.exp(-5j * theta_e)
        phases = [(along * np.exp(-2j * math.pi * k / 3.0)).real for k in range(3)]
        named = dict(zip(CURRENTS, phases, strict=True))
        blocks.append(Block.from_arrays(1e4, CURRENTS | {"theta_m": "rad"}, **named, theta_m=theta_m))
        at = np.asarray(theta_e[1:], np.float64)
        flux = PSI_WB * np.exp(1j * at) + share * PSI_5_WB * np.exp(-5j * at)
        flux += noise * (rng.normal(size=6000) + 1j * rng.normal(size=6000))
        rows = np.arange(6000)
        found = TurningFlux(PSI_WB, 0.0, MOTOR.L_d_H, omega * MOTOR.pole_pairs, rows, at, flux, 0j, 0.0, 9.0)
        turning.append(found)
    return blocks, turning


def lines_of(found: Measurement) -> dict[str, float]:
    assert found.uncertainty is not None
    return {each.name: each.standard for each in found.uncertainty.budget}


def test_what_dead_time_does_near_zero_current_is_in_the_cosine_of_each_harmonic() -> None:
    blocks, turning = captures(noise=1e-6)
    found = {each.name: each for each in flux_harmonics(blocks, turning, turning, KNOWN, ROUNDED_WB, 0.0)}
    assert found["psi_5_cos"].value == pytest.approx(PSI_5_WB, rel=1e-3)
    assert found["psi_7_cos"].value == pytest.approx(0.0, abs=1e-6)
    for order in (5, 7):
        near_zero = [
            lines_of(found[f"psi_{order}_{part}"])["dead time near zero current"] for part in ("cos", "sin")
        ]
        assert near_zero == [pytest.approx(ROUNDED_WB / order), 0.0]
        cosine = found[f"psi_{order}_cos"].uncertainty
        assert cosine is not None
        assert cosine.standard >= ROUNDED_WB / order


def test_what_hangs_on_the_share_of_dead_time_and_on_the_angle_is_in_the_uncertainty() -> None:
    blocks, turning = captures()
    _, moved = captures(share=0.9)
    offset = Measurement("encoder_offset", 0.3, "rad", "", uncertainty=Uncertainty(0.01, "fit"))
    known = KNOWN.with_estimates({"encoder_offset": offset})
    found = {each.name: each for each in flux_harmonics(blocks, turning, moved, known, 0.0, 0.0)}
    by_share = lines_of(found["psi_5_cos"])["dead time and devices, their shares"]
    assert by_share == pytest.approx(0.1 * PSI_5_WB, rel=1e-3)
    turned = lines_of(found["psi_5_sin"])["offset of the encoder"]
    assert turned == pytest.approx(5.0 * MOTOR.pole_pairs * 0.01 * PSI_5_WB, rel=1e-3)


def test_an_eccentric_encoder_that_is_not_told_lowers_a_harmonic_by_its_bessel_function() -> None:
    a = 0.02
    parts = {"eccentricity_1_cos": a, "eccentricity_1_sin": 0.0}
    u = Uncertainty(1.0, "scatter")
    known = KNOWN.with_estimates(
        {name: Measurement(name, x, "rad", "", uncertainty=u) for name, x in parts.items()}
    )
    blocks, turning = captures()
    found = {each.name: each for each in flux_harmonics(blocks, turning, turning, known, 0.0, 0.0)}
    phase = 5.0 * MOTOR.pole_pairs * a * np.cos(np.linspace(0.0, 2.0 * math.pi, 10_001)[:-1])
    lost = 1.0 - float(np.mean(np.cos(phase)))
    line = lines_of(found["psi_5_cos"])["eccentric encoder"]
    assert line == pytest.approx(lost * PSI_5_WB / math.sqrt(3.0), rel=0.05)
    told = replace(u, standard=1e-4, budget=())
    sure = KNOWN.with_estimates({n: Measurement(n, x, "rad", "", uncertainty=told) for n, x in parts.items()})
    found = {each.name: each for each in flux_harmonics(blocks, turning, turning, sure, 0.0, 0.0)}
    assert lines_of(found["psi_5_cos"])["eccentric encoder"] == 0.0


def test_what_dead_time_takes_of_the_harmonics_currents_is_in_the_uncertainty() -> None:
    blocks, turning = captures(harmonic_A=0.3)
    found = {each.name: each for each in flux_harmonics(blocks, turning, turning, KNOWN, 0.0, 1e-3)}
    share = 0.3 / math.hypot(1.0, 0.3)
    for order in (5, 7):
        line = lines_of(found[f"psi_{order}_cos"])["dead time of the harmonics' currents"]
        assert line == pytest.approx(1e-3 * share / order, rel=1e-3)
