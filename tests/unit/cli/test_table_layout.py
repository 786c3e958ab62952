"""Tables on terminals of any width: no name ends within a word, and no number is broken."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st
from rich.cells import cell_len
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.cli.output import Output
from benchtool.cli.table_layout import SEPARATOR, tables

LONG = "transducer_torque_ripple_percent_of_rated"
NUMBERS = ("0.64997 ± 0.00026", "(0.0 ± 3.0) × 10⁻⁴", "10000.00 ± 0.89", "–")
NAMES = st.from_regex(r"[a-z]{1,11}(_[a-z]{1,11}){0,5}", fullmatch=True)
SENTENCES = st.lists(st.from_regex(r"[a-z]{1,12}", fullmatch=True), max_size=12).map(" ".join)


def test_words_give_way_before_names() -> None:
    columns, row = ("measurement", "unit", "definition"), (LONG, "Nm", "word " * 20)
    (shown,) = tables(columns, [row], 80)
    assert shown.widths[:2] == (len(LONG), 4)


def test_numbers_keep_their_width_and_names_give_way() -> None:
    columns = ("measurement", ">A", ">B", ">%", "unit")
    row = (LONG, "0.64997 ± 0.00026", "(0.0 ± 3.0) × 10⁻⁴", "0~", "Nm")
    (shown,) = tables(columns, [row], 80)
    assert shown.widths[0] < len(LONG)
    assert shown.widths[1:] == tuple(max(2, len(each)) for each in (*row[1:4], "unit"))


def test_columns_without_room_stand_in_a_table_below() -> None:
    columns = ("profile", *(f">{each}" for each in "abcdef"))
    row = ("motors/ebm_papst_eci63", *["1234.5 ± 6.7 rpm"] * 6)
    shown = list(tables(columns, [row], 80))
    assert [each.places for each in shown] == [(0, 1, 2, 3), (0, 4, 5, 6)]


def test_no_table_of_its_own_is_made_where_names_may_give_way() -> None:
    columns = ("measurement", ">A", ">B", ">B−A ± U", ">%", "unit")
    row = (f"{LONG}_rms", "0.0325238", "−0.9 × 10⁻⁴", "(−1.9 ± 2.7) × 10⁻⁴", "−0.0003~", "A/sqrt(Hz)")
    shown = list(tables(columns, [row], 80))
    assert [each.places for each in shown] == [(0, 1, 2), (0, 3, 4, 5)]


@given(
    rows=st.lists(st.tuples(NAMES, SENTENCES, *[st.sampled_from(NUMBERS)] * 3), min_size=1, max_size=5),
    width=st.sampled_from([60, 80, 100, 140]),
)
@settings(max_examples=60, deadline=None)
def test_every_word_and_every_number_is_whole(rows: list[tuple[str, ...]], width: int) -> None:
    columns = ("measurement", "definition", ">value ± U (95 %)", ">B", ">difference")
    seen: list[int] = []
    for shown in tables(columns, rows, width):
        assert sum(shown.widths) + SEPARATOR * (len(shown.widths) - 1) <= width
        seen += shown.places[1:]
        for place, wide in zip(shown.places, shown.widths, strict=True):
            parts = [part for row in rows for part in row[place].replace("_", "_ ").split()]
            if columns[place].startswith(">"):
                parts = [row[place] for row in rows]
            assert all(cell_len(part) <= wide for part in parts)
    assert seen == [1, 2, 3, 4]


@pytest.mark.parametrize("width", ["80", "100", "140"])
def test_profiles_are_whole_words_at_any_width(width: str) -> None:
    """At 80 columns `motors/qs138_ebike` stood in three lines, and `control` in two."""
    shown = CliRunner().invoke(app, ["profiles"], env={"COLUMNS": width})
    lines = shown.stdout.splitlines()
    table = [line for line in lines if "│" in line or "┃" in line]
    assert max(map(cell_len, table)) <= int(width)
    for whole in ("motors/ebm_papst_eci63", "0.0134 Nm", "10848 rpm", "omega_m_N", "control", "skateboard"):
        assert any(whole in line for line in table), whole


def test_a_value_that_no_terminal_holds_is_whole_all_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    output = Output(as_json=False)
    output._people.width = 24
    output.table("title", ("name", ">value"), [("torque_mean", "(1.9989 ± 0.0016) × 10⁻⁴")])
    assert "(1.9989 ± 0.0016) × 10⁻⁴" in capsys.readouterr().out
