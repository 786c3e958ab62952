"""Tables and sentences that fit a terminal of 80 columns."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from benchtool.cli.fitting import broken, hanging


def test_a_name_is_broken_after_underscores() -> None:
    assert broken("torque_ripple_percent_of_mean", 14).split("\n") == [
        "torque_ripple_",
        "percent_of_",
        "mean",
    ]


def test_the_name_of_a_case_is_broken_between_its_coordinates() -> None:
    """It was broken within one: `tpc_stator,omega_m_` and `rad_s=15.71`."""
    assert broken("tpc_stator,omega_m_rad_s=15.71", 24).split("\n") == ["tpc_stator,", "omega_m_rad_s=15.71"]
    assert broken("foc,emulator_inverter_dead_time_s=1e-06", 24).split("\n") == [
        "foc,emulator_inverter_",
        "dead_time_s=1e-06",
    ]


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("≥ 14.9245, ≤ 16.4955", 10, ["≥ 14.9245,", "≤ 16.4955"]),
        ("pass, P > 0.999", 9, ["pass,", "P > 0.999"]),
        ("XNOVA 4530 helicopter motor, 24 V", 14, ["XNOVA 4530", "helicopter", "motor, 24 V"]),
        ("(1.9989 ± 0.0016) × 10⁻⁴ at 0.65 Nm", 14, ["(1.9989 ± 0.0016) × 10⁻⁴", "at 0.65 Nm"]),
        ("published.tpc.torque_ripple_pp", 16, ["published.tpc.", "torque_ripple_pp"]),
        ("A/sqrt(Hz)", 8, ["A/sqrt(Hz)"]),
    ],
)
def test_a_number_stays_with_its_sign_and_its_unit(text: str, width: int, lines: list[str]) -> None:
    assert broken(text, width).split("\n") == lines


@given(st.from_regex(r"[a-z]{1,12}(_[a-z]{1,12}){0,6}", fullmatch=True), st.integers(12, 40))
def test_a_broken_name_loses_nothing_and_fits(name: str, width: int) -> None:
    lines = broken(name, width).split("\n")
    assert "".join(lines) == name
    assert all(len(line) <= width + 1 for line in lines)


@given(st.text("ab ", min_size=1).map(lambda text: " ".join(text.split())), st.integers(30, 90))
def test_a_sentence_keeps_its_words(text: str, width: int) -> None:
    assert hanging("  name  ", text, width).split() == ["name", *text.split()]
