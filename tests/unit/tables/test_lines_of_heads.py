"""Lines of a head: units above names, modules and types, further names, factors, and a sign as a name."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from benchtool.tables.text import TextTable

ROWS = "".join(f"{row / 8:.4f};{math.sin(row):.4f};{math.cos(row):.4f}\n" for row in range(64))
UNITS = ["ms", "mA", "mNm"]


def table(folder: Path, head: str) -> TextTable:
    path = folder / "table.csv"
    path.write_text(head + ROWS, encoding="utf-8")
    return TextTable.open(path)


@pytest.mark.parametrize(
    "head",
    [
        "ms;mA;mNm\nt;I;T\n",
        "t [ms];I [mA];T [mNm]\nSR 8 Hz;SR 8 Hz;SR 8 Hz\nMX840;MX840;MX840\n",
        "t;I;T\nf8;f8;f8\nms;mA;mNm\n",
        "t;I;T\ndouble;float;single\nms;mA;mNm\n",
        "t;I;T\nms;mA;mNm\ndouble;float;float\n",
        "t;I;T\nTime;Phase current;Shaft torque\nms;mA;mNm\n",
    ],
)
def test_names_and_units_among_other_lines(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    chosen = [found.select(*each) for each in (("t", "s"), ("I", "A"), ("T", "Nm"))]
    assert [each.unit for each in chosen] == UNITS
    assert [each.number for each in chosen] == [1, 2, 3]


def test_a_title_with_delimiters_names_no_columns(tmp_path: Path) -> None:
    found = table(tmp_path, "Measured torque; current; speed\nt;T;i\ns;Nm;A\n")
    with pytest.raises(AnalysisError, match="no column 'current'"):
        found.select("current", "A")


def test_the_sign_of_a_comment_may_be_a_name(tmp_path: Path) -> None:
    assert table(tmp_path, "#;I;T\n").select("#", "s").number == 1
    assert table(tmp_path, "# t;I;T\n").select("t", "s").number == 1
    assert [each.name for each in table(tmp_path, "#t;I;T\n").layout.columns] == ["t", "I", "T"]


@pytest.mark.parametrize("line", ["Factor;0.01;0.1", "Faktor;1;0,5", "Scale factor;1;10", "Gain;0.1;0.1"])
def test_factors_in_the_head_are_told(tmp_path: Path, line: str) -> None:
    table(tmp_path, f"t;I;T\ns;A;Nm\n{line}\n")
    found = analyze_table(TableQuestion(tmp_path / "table.csv", "t", {"current": "I"}))
    texts = [each.text for each in found.remarks if each.kind == RemarkKind.NUMBERS_IN_HEAD]
    assert texts
    assert "state the gain" in texts[-1]


def test_factors_of_one_and_settings_are_not(tmp_path: Path) -> None:
    table(tmp_path, "Vertical Scale;2;1\nProbe Attenuation;10;10\nFactor;1;1\nt;I;T\ns;A;Nm\n")
    found = analyze_table(TableQuestion(tmp_path / "table.csv", "t", {"current": "I"}))
    assert RemarkKind.NUMBERS_IN_HEAD not in {each.kind for each in found.remarks}


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize(("between", "head"), [(";", "t;I;T\n"), (" ", '"t" "I" "T"\n'), ("\t", "t\tI\tT\n")])
def test_a_head_without_a_name_for_the_numbers_of_rows(
    tmp_path: Path, between: str, head: str, start: int
) -> None:
    rows = [f'"{number}";{line}' for number, line in enumerate(ROWS.splitlines(), start)]
    path = tmp_path / "table.csv"
    path.write_text(head + "\n".join(rows).replace(";", between), encoding="utf-8")
    found = TextTable.open(path)
    chosen = [found.select(*each) for each in (("t", "s"), ("I", "A"), ("T", "Nm"))]
    assert [each.number for each in chosen] == [2, 3, 4]
    assert len(found.rows(chosen).data) == 64


def test_a_head_that_lacks_a_name_above_rows_without_numbers_names_nothing(tmp_path: Path) -> None:
    with pytest.raises(
        AnalysisError, match=r"has no column 't', it has no names \(its head 't;I' is not of 3"
    ):
        table(tmp_path, "t;I\n").select("t", "s")


@pytest.mark.parametrize("order", [("offset;0.5;0", "scale;2;1"), ("scale;2;1", "offset;0.5;0")])
@pytest.mark.parametrize("names", ["t;I;T\n", "t;I;T\ns;A;Nm\n"])
def test_settings_beneath_the_names_are_none_and_are_told(
    tmp_path: Path, order: tuple[str, str], names: str
) -> None:
    """`scale` was the name of the time, and 2 that of the current."""
    found = table(tmp_path, names + "".join(f"{line}\n" for line in order))
    assert [each.name for each in found.layout.columns] == ["t", "I", "T"]
    answer = analyze_table(TableQuestion(tmp_path / "table.csv", "t:s", {"current": "I:A"}))
    assert answer.source["rows_read"] == 64
    texts = [each.text for each in answer.remarks if each.kind == RemarkKind.NUMBERS_IN_HEAD]
    assert all(any(f"'{line}'" in text and "state the gain" in text for text in texts) for line in order)


@pytest.mark.parametrize("head", ["t;1;2\n", "Module;A1;A2\nTime;1;2\n", "Time;1;2\ns;A;Nm\n"])
def test_numbers_behind_the_name_of_a_time_are_names(tmp_path: Path, head: str) -> None:
    names = [each.name for each in table(tmp_path, head).layout.columns]
    assert names[1:] == ["1", "2"]
    assert names[0] in ("t", "Time")


@pytest.mark.parametrize("head", ["X;CH1;CH2\nSequence;Volt;Volt\n", "Sequence;Volt;Volt\nX;CH1;CH2\n"])
def test_a_word_among_units_is_another_name(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    assert [found.select(name, "s").number for name in ("Sequence", "X:s")] == [1, 1]
    assert found.select("CH2", "V").unit == "Volt"


def test_names_in_quotation_marks_between_blanks(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_text('"time s" "phase current" T\n' + ROWS.replace(";", " "), encoding="utf-8")
    assert TextTable.open(path).select("phase current", "A").number == 2


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("Labels;Ia;torque\nTIME;CH1;CH2\n", {"TIME": 1, "CH1": 2, "Ia": 2, "CH2": 3, "torque": 3}),
        ("Labels;Ia;\nTIME;CH1;TIME\n", {"CH1": 2, "Ia": 2}),
        ("Ia;T;n\nCH1;CH2;CH3\nA;Nm;rpm\n", {"Ia": 1, "CH1": 1, "CH3": 3, "n": 3}),
    ],
)
def test_a_column_has_the_names_of_every_line(tmp_path: Path, head: str, columns: dict[str, int]) -> None:
    """The labels of an oscilloscope's channels were no names of theirs, or the only ones."""
    found = table(tmp_path, head)
    for name, number in columns.items():
        kind = "s" if name == "TIME" else "rad/s" if number == 3 and name in ("CH3", "n") else "Nm"
        wanted = f"{name}:{kind}"
        assert found.select(wanted, kind).number == number
        assert found.select(wanted, kind).name == name


def test_names_that_repeat_are_asked_for(tmp_path: Path) -> None:
    found = table(tmp_path, "Labels;Ia;\nTIME;CH1;TIME\n")
    with pytest.raises(AnalysisError, match=r"2 columns 'TIME', with the numbers 1, 3"):
        found.select("TIME", "s")
    with pytest.raises(AnalysisError, match=r"2 'Ia' \('CH1'\)"):
        found.select("foo", "s")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_names_over_several_lines_are_whole(tmp_path: Path, end: str) -> None:
    """A spreadsheet writes line ends within quotes: the head had no names."""
    head = '"Time\n[ms]";"Phase\ncurrent\n[mA]";Torque [mNm]\n'
    (tmp_path / "table.csv").write_bytes((head + ROWS).replace("\n", end).encode())
    found = TextTable.open(tmp_path / "table.csv")
    assert found.select("Phase current", "A").unit == "mA"
    assert [each.unit for each in found.layout.columns] == UNITS
    assert found.layout.head_lines == 4


def test_quotes_about_cells_of_rows_join_no_lines(tmp_path: Path) -> None:
    rows = "".join(f'"{row / 8:.3f}";"{math.sin(row):.3f}"\n' for row in range(64))
    (tmp_path / "table.csv").write_text(f'"t";"I, phase ""a"""\n{rows}', encoding="utf-8")
    found = TextTable.open(tmp_path / "table.csv")
    selected = [found.select("t:s", "s"), found.select("#2:A", "A")]
    assert len(found.rows(selected).data) == 64


@pytest.mark.parametrize(
    "head",
    [
        "Model:;DL850\nInterval:;0.001\nChannel:;t;I;T\nUnit:;ms;mA;mNm\n",
        "Model;DL850\nTraceName;t;I;T\nVUnit;ms;mA;mNm\n",
        "Signal;t;I;T\nSensor;clock;LEM;HBM\nUnits;ms;mA;mNm\n",
        "Units;ms;mA;mNm\nSignal;t;I;T\n",
        "Channel:;t [ms];I [mA];T [mNm]\n",
    ],
)
def test_labels_before_the_lines_of_a_head_alone_are_no_names(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    chosen = [found.select(*each) for each in (("t", "s"), ("I", "A"), ("T", "Nm"))]
    assert [each.unit for each in chosen] == UNITS
    assert [each.number for each in chosen] == [1, 2, 3]


@pytest.mark.parametrize(
    "head",
    [
        "t;Position; mech.;T\n",
        "t;Position; mech.;T\ns;deg;;Nm\n",
        "No.;Position; mech.;T\n-;deg;;Nm\n",
        "Channel:;DL850\n",
    ],
)
def test_a_cell_too_many_is_no_label_without_a_sign_of_one(tmp_path: Path, head: str) -> None:
    """A separator within a name would shift those behind it."""
    found = table(tmp_path, head)
    assert not any(column.name for column in found.layout.columns)
