"""Tables and sentences that fit a terminal of 80 columns."""

from __future__ import annotations

from hypothesis import given, strategies as st

from benchtool.cli.fitting import broken, hanging, widest_name

LONG = "transducer_torque_ripple_percent_of_rated"


def test_words_give_way_before_names() -> None:
    columns, row = ("measurement", "unit", "definition"), (LONG, "Nm", "word " * 20)
    assert widest_name(columns, [row], 80) is None


def test_numbers_keep_their_width_and_names_give_way() -> None:
    columns = ("measurement", ">A", ">B", ">B−A", ">%", "unit")
    row = (LONG, "0.64997 ± 0.00026", "0.1 × 10⁻⁴", "(0.0 ± 3.0) × 10⁻⁴", "0~", "Nm")
    width = widest_name(columns, [row], 80)
    assert width is not None
    assert width + sum(map(len, row[1:])) + len("unit") - len("Nm") + 3 * 5 <= 80


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


@given(st.from_regex(r"[a-z]{1,12}(_[a-z]{1,12}){0,6}", fullmatch=True), st.integers(12, 40))
def test_a_broken_name_loses_nothing_and_fits(name: str, width: int) -> None:
    lines = broken(name, width).split("\n")
    assert "".join(lines) == name
    assert all(len(line) <= width + 1 for line in lines)


@given(st.text("ab ", min_size=1).map(lambda text: " ".join(text.split())), st.integers(30, 90))
def test_a_sentence_keeps_its_words(text: str, width: int) -> None:
    assert hanging("  name  ", text, width).split() == ["name", *text.split()]
