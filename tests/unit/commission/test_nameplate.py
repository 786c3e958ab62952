"""Estimates in the conventions of nameplates, and what a deviation probably is."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from benchtool.commission.nameplate import (
    WINDING_R,
    contained,
    conventions,
    deviation,
    probable_cause,
    stated,
)
from benchtool.profile import Amplitude, Voltage, flux_of_ke, flux_of_kt, flux_of_kv, load_profile

MOTOR = load_profile("zhu2011").motor
KRPM = 1000.0 * math.pi / 30.0


@given(psi_r=st.floats(1e-4, 1.0), p=st.integers(1, 40))
def test_every_convention_leads_back_to_the_flux(psi_r: float, p: int) -> None:
    """By the functions that read a nameplate."""
    rows = {name: value for name, value, _ in conventions({"psi_r": psi_r}, p)}
    words = {"ll": "line to line", "phase": "phase"}
    for voltage in Voltage:
        between, _, amplitude = voltage.value.partition("-")
        said = f"{words[between]}, {amplitude}"
        assert flux_of_ke(rows[f"Ke, {said}"] / KRPM, voltage, p) == pytest.approx(psi_r)
        assert flux_of_kv(rows[f"Kv, {said}"] * math.pi / 30.0, voltage, p) == pytest.approx(psi_r)
    for current in Amplitude:
        assert flux_of_kt(rows[f"Kt, per A {current.value}"], current, p) == pytest.approx(psi_r)
    assert rows["V/Hz, line to line, rms"] == pytest.approx(2.0 * math.pi * psi_r * math.sqrt(1.5))


@pytest.mark.parametrize(
    ("name", "stated_over_true", "words"),
    [
        ("R_s", 2.0, "R looks line to line"),
        ("L_q", 2.0, "L looks line to line"),
        ("R_s", 1.5, "one terminal against the other two"),
        ("psi_r", math.sqrt(3.0), "between lines"),
        ("psi_r", math.sqrt(2.0), "stated as rms"),
        ("psi_r", math.sqrt(6.0), "peak voltage between lines"),
        ("psi_r", 1.0 / math.sqrt(3.0), "the inverse"),
        ("psi_r", MOTOR.pole_pairs, "per mechanical rad/s"),
        ("pole_pairs", 2.0, "number of poles"),
    ],
)
def test_a_telling_deviation_is_named(name: str, stated_over_true: float, words: str) -> None:
    keys = {"R_s": MOTOR.R_s_ohm, "L_q": MOTOR.L_q_H, "psi_r": MOTOR.psi_r_Wb, "pole_pairs": MOTOR.pole_pairs}
    assert words in probable_cause(name, keys[name] / stated_over_true, MOTOR)


@given(factor=st.floats(0.9, 1.1))
def test_a_small_deviation_has_no_name(factor: float) -> None:
    for name, value in (("R_s", MOTOR.R_s_ohm), ("psi_r", MOTOR.psi_r_Wb), ("J", MOTOR.J_kgm2)):
        assert probable_cause(name, factor * value, MOTOR) == ""


def test_what_a_nameplate_does_not_state_has_no_cause() -> None:
    assert probable_cause("coulomb", 0.1, MOTOR) == ""
    assert probable_cause("R_s", math.nan, MOTOR) == ""


def test_a_resistance_is_compared_with_what_is_stated_of_the_winding_and_in_series() -> None:
    """That of an e-bike motor of 4 mohm was 54 % off, by the 2.2 mohm of its devices."""
    R_ohm = MOTOR.R_s_ohm
    assert stated("R_s", MOTOR, 0.5 * R_ohm) == pytest.approx(1.5 * R_ohm)
    assert deviation("R_s", 1.5 * R_ohm, MOTOR, 0.5 * R_ohm) == pytest.approx(0.0)
    assert deviation("R_s", 1.5 * R_ohm, MOTOR) == pytest.approx(0.5)
    assert deviation(WINDING_R, R_ohm, MOTOR, 0.5 * R_ohm) == pytest.approx(0.0)


def test_what_a_resistance_contains_is_told() -> None:
    assert "0.0025 ohm by the profile" in contained("R_s", 0.0025)
    assert "drive.on_resistance_ohm states none" in contained("R_a", None)
    assert contained("L_d", 0.0025) == contained(WINDING_R, 0.0025) == ""


def test_a_nameplate_states_the_winding_alone() -> None:
    with_series = {name: value for name, value, _ in conventions({"R_s": 0.0062}, 5)}
    assert with_series == {
        "R_s with what is in series, per phase": 0.0062,
        "R_s with what is in series, line to line": 0.0124,
    }
    alone = {name: value for name, value, _ in conventions({"R_s": 0.0062, WINDING_R: 0.004}, 5)}
    assert alone == {"R_winding, per phase": 0.004, "R_winding, line to line": 0.008}
