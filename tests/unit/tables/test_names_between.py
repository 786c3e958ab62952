"""Tables below each other in one file: told by a line of names between rows that no column times."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table, table_block
from benchtool.tables.answer import TableAnswer
from benchtool.tables.remarks import RemarkKind
from tests.at_length import at_length

COUNT = 256
FIRST, SECOND = (
    [f"{3.0 * math.cos(0.3 * row):.4f},{level + 0.1 * math.cos(0.7 * row):.4f}" for row in range(COUNT)]
    for level in (1, 2)
)
STAMPS = [str(row) for row in range(2 * COUNT)]


def question(folder: Path, lines: list[str], *, to_s: float = math.inf, timed: bool = False) -> TableQuestion:
    path = folder / "table.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    time, rate_Hz = ("t", None) if timed else (None, 1e3)
    return TableQuestion(path, time, {"current": "i", "torque": "T"}, to_s=to_s, rate_Hz=rate_Hz)


def told(found: TableAnswer) -> list[str]:
    return [each.text for each in found.remarks if each.kind == RemarkKind.SEVERAL_TABLES]


def timed(rows: list[str], stamps: list[str]) -> list[str]:
    return [f"{stamp},{row}" for stamp, row in zip(stamps, rows, strict=True)]


@pytest.mark.parametrize(
    "head", [["i [A],T [Nm]"], ["# i [A],T [Nm]"], ["i,T", "A,Nm"], ["i,T", "A,Nm", "shunt,flange"]]
)
def test_a_head_between_rows_without_a_time_is_told(tmp_path: Path, head: list[str]) -> None:
    asked = question(tmp_path, [*head, *FIRST, *head, *SECOND])
    found = analyze_table(asked)
    (text,) = told(found)
    assert text.startswith("1 line of names is between the rows, the first 'i")
    assert f"at line {2 * len(head) + COUNT - len(head) + 1} of the file: tables below each other" in text
    assert found.source["time"]["uniform"] is False
    (reason,) = [each.reason for each in found.measurements if each.name == "current_fundamental"]
    assert "lines" not in reason
    assert reason in text
    with pytest.raises(AnalysisError, match="tables below each other"):
        table_block(asked)


def test_other_names_are_told_as_well(tmp_path: Path) -> None:
    (text,) = told(analyze_table(question(tmp_path, ["i,T", *FIRST, "u,speed", *SECOND, "i,T", *FIRST])))
    assert text.startswith("2 lines of names are between the rows, the first 'u,speed' at line 258")


def test_a_span_of_one_table_is_that_of_one(tmp_path: Path) -> None:
    found = analyze_table(question(tmp_path, ["i,T", *FIRST, "i,T", *SECOND], to_s=0.25))
    assert told(found) == []
    assert found.source["time"]["uniform"] is True


@pytest.mark.parametrize("line", ["--,--", "overload,1.5", "# the brake is on", *at_length("error,error")])
def test_cells_without_a_number_and_comments_are_no_names(tmp_path: Path, line: str) -> None:
    assert told(analyze_table(question(tmp_path, ["i,T", *FIRST, line, *FIRST]))) == []


def test_names_below_the_last_row_begin_no_table(tmp_path: Path) -> None:
    assert told(analyze_table(question(tmp_path, ["i,T", *FIRST, "i,T"]))) == []


def test_a_time_that_starts_again_below_names_is_no_counter_that_rolls_over(tmp_path: Path) -> None:
    head, once = "t [ms],i,T", timed(FIRST, STAMPS[:COUNT])
    kinds = {
        each.kind for each in analyze_table(question(tmp_path, [head, *once, *once], timed=True)).remarks
    }
    assert RemarkKind.TIME_ROLLS_OVER in kinds
    found = analyze_table(question(tmp_path, [head, *once, head, *once], timed=True))
    kinds = {each.kind for each in found.remarks}
    assert RemarkKind.TIME_GOES_BACK in kinds
    assert RemarkKind.TIME_ROLLS_OVER not in kinds


def test_a_head_that_is_repeated_in_a_time_that_goes_on_is_nothing(tmp_path: Path) -> None:
    rows = timed([*FIRST, *FIRST], STAMPS)
    found = analyze_table(
        question(tmp_path, ["t [s],i,T", *rows[:COUNT], "t [s],i,T", *rows[COUNT:]], timed=True)
    )
    assert told(found) == []
    assert found.source["time"]["uniform"] is True


def test_a_head_of_one_column_that_has_another_number_of_cells_is_refused(tmp_path: Path) -> None:
    once = [row.partition(",")[0] for row in FIRST]
    path = tmp_path / "table.csv"
    path.write_text("\n".join(["T [Nm]", *once, "T [Nm]", *once]), encoding="utf-8")
    with pytest.raises(
        AnalysisError, match=r"1 row with a wrong number of cells, 'T \[Nm\]' at line 258 has names"
    ):
        analyze_table(TableQuestion(path, None, {"torque": "T"}, rate_Hz=1e3))
