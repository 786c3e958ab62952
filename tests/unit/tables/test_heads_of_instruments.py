"""Heads as instruments and programs write them: each is read right, refused, or told."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError
from benchtool.tables.remarks import numbers_in_head
from benchtool.tables.text import TextTable

COUNT = 60
TIME = np.arange(COUNT) * 1e-4
CURRENT = np.array([round(5.0 * math.cos(0.7 * row + 0.3), 5) for row in range(COUNT)])
TORQUE = np.array([round(2.0 + 0.1 * math.cos(1.3 * row), 5) for row in range(COUNT)])

Row = Callable[[int], str]


def joined(delimiter: str = ",", *, before: str = "", end: str = "", decimal: str = ".") -> Row:
    def row(place: int) -> str:
        cells = (f"{TIME[place]:.5f}", f"{CURRENT[place]:.5f}", f"{TORQUE[place]:.5f}")
        return before + delimiter.join(cells).replace(".", decimal) + end

    return row


def table(folder: Path, head: str, row: Row, *, timed: bool = True) -> TextTable:
    path = folder / "table.csv"
    path.write_text(head + "".join(f"{row(place)}\n" for place in range(COUNT)), encoding="utf-8")
    return TextTable.open(path, timed=timed)


def read(found: TextTable, time: str, current: str, torque: str) -> None:
    chosen = [found.select(time, "s"), found.select(current, "A"), found.select(torque, "Nm")]
    rows = found.rows(chosen)
    assert rows.dropped == {}
    factors = [each.factor * each.gain for each in chosen]
    for column, values, factor in zip(rows.data.T, (TIME, CURRENT, TORQUE), factors, strict=True):
        np.testing.assert_allclose(column, values * factor, atol=1e-12)


def without_time(delimiter: str, before: str = "", end: str = "") -> Row:
    return lambda place: f"{before}{CURRENT[place]:.5f}{delimiter}{TORQUE[place]:.5f}{end}"


LVM = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2024/01/05\nTime\t12:12:12.123\n***End_of_Header***\t\n\t\n"
    "Channels\t2\t\t\nSamples\t60\t60\t\nDate\t2024/01/05\t2024/01/05\t\nTime\t12:12:12.12\t12:12:12.12\t\n"
    "Y_Unit_Label\tAmps\tNewton-Meters\t\nX_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\n"
    "Delta_X\t1.000000E-4\t1.000000E-4\t\n***End_of_Header***\t\t\t\n"
)
YOKOGAWA = (
    '"Header Size",16\n"Model Name","DL850E"\n"BlockNumber",1\n"TraceName","CH1","CH2"\n"BlockSize",60,60\n'
    '"VUnit","mA","Ncm"\n"SampleRate",1.0000000E+004,1.0000000E+004\n"HResolution",1.0E-004,1.0E-004\n'
    '"HOffset",-2.0E-001,-2.0E-001\n"HUnit","s","s"\n"DisplayPointNo.",1,1\n"PhaseShift",0,0\n'
    '"Date","2024/01/05","2024/01/05"\n"Time","12:00:00.00","12:00:00.00"\n\n'
)
RIGOL = "Time(s),CH1(mA),CH2(mNm),t0 =-2.000000e-01, tInc = 1.000000e-04"

HEADS: tuple[tuple[str, str, Row, tuple[str, str, str], tuple[float, float]], ...] = (
    ("bars", "t [s]|i [mA]|T [Nm]\n", joined("|"), ("t", "i", "T"), (1e-3, 1.0)),
    ("bars_decimal_comma", "t|i|T\ns|A|mNm\n", joined("|", decimal=","), ("t", "i", "T"), (1.0, 1e-3)),
    (
        "markdown",
        "| t [s] | i [mA] | T [Nm] |\n|------:|:------|-----|\n",
        joined(" | ", before="| ", end=" |"),
        ("t", "i", "T"),
        (1e-3, 1.0),
    ),
    (
        "markdown_by_number",
        "| t | i | T |\n",
        joined("|", before="|", end="|"),
        ("1", "2:mA", "3"),
        (1e-3, 1.0),
    ),
    (
        "names_units_sensors",
        "Time,Current,Torque\ns,mA,Ncm\nmeasured,LEM IT60,HBM T40\n",
        joined(),
        ("Time", "Current", "Torque"),
        (1e-3, 1e-2),
    ),
    (
        "names_units_sensors_by_sensor",
        "Time,Current,Torque\ns,mA,Ncm\nmeasured,LEM IT60,HBM T40\n",
        joined(),
        ("measured", "LEM IT60", "HBM T40"),
        (1e-3, 1e-2),
    ),
    (
        "names_units_channels",
        "Zeit;Strom;Moment\n[s];[mA];[Nm]\nai0;ai1;ai2\n",
        joined(";", decimal=","),
        ("Zeit", "Strom", "ai2"),
        (1e-3, 1.0),
    ),
    (
        "below_a_title",
        "Rig 4\n\nTime,Current,Torque\ns,mA,Nm\ncalc,raw 1,raw 2\n",
        joined(),
        ("Time", "Current", "Torque"),
        (1e-3, 1.0),
    ),
    ("lvm", LVM + "X_Value\ti\tT\tComment\n", joined("\t"), ("X_Value:s", "i:mA", "T:Nm"), (1e-3, 1.0)),
    ("lvm_names_in_time", LVM + "X_Value\ti\tT\n", joined("\t"), ("X_Value:s", "i:A", "T"), (1.0, 1.0)),
    ("remarks_at_the_end", "t,i,T,Remarks\n", joined(), ("t", "i", "T"), (1.0, 1.0)),
    ("remark_of_empty_cells", "t,i,T,Bemerkung\n", joined(end=","), ("t", "i", "T"), (1.0, 1.0)),
    ("rigol_ends_in_commas", RIGOL + ",\n", joined(end=",,"), ("Time", "CH1", "CH2"), (1e-3, 1e-3)),
    ("rigol_ends_in_one", RIGOL + ",\n", joined(end=","), ("Time", "CH1", "CH2"), (1e-3, 1e-3)),
    ("rigol_ends_in_none", RIGOL + "\n", joined(), ("Time", "CH1", "CH2"), (1e-3, 1e-3)),
    (
        "start_and_increment",
        "X,CH1,CH2,Start,Increment,\nSecond,Volt,Volt,-2.0e-01,1.0e-04\n",
        joined(end=","),
        ("X", "CH1:mA", "CH2:Nm"),
        (1e-3, 1.0),
    ),
    (
        "start_and_increment_above_cells",
        "X,CH1,CH2,Start,Increment,\nSecond,Volt,Volt,-2.0e-01,1.0e-04\n",
        joined(end=",,"),
        ("X", "CH1:A", "CH2:mNm"),
        (1.0, 1e-3),
    ),
    ("in_a_unit", "in s,C1 in mA,C2 in mNm\n", joined(), ("in s", "C1", "C2"), (1e-3, 1e-3)),
    (
        "in_a_unit_in_full",
        "Zeit in s;C1 in mA;M in Nm\n",
        joined(";"),
        ("Zeit", "C1 in mA", "m"),
        (1e-3, 1.0),
    ),
    ("letters_of_seconds", "Time(S),i(mA),T(Nm)\n", joined(), ("Time", "i", "T"), (1e-3, 1.0)),
    (
        "a_line_of_values",
        "Offset,0.5,1.0E-3\nTime,i,T\ns,mA,Nm\n",
        joined(),
        ("Time", "i", "T"),
        (1e-3, 1.0),
    ),
    (
        "labels",
        "path,Model/Time,Model/Iq,Model/Te\nraster,Host,Host,Host\ntype,Float64,Float64,Float64\nunit,s,mA,Nm\n"
        "trace_values,,,\n",
        joined(before=","),
        ("Model/Time", "Model/Iq", "Model/Te"),
        (1e-3, 1.0),
    ),
    (
        "labels_by_number",
        "name,t,i,T\nunit,s,mA,Nm\nhost,a,b,c\n",
        joined(before=","),
        ("2", "3", "4"),
        (1e-3, 1.0),
    ),
    ("tabs_and_a_rule", "t\ti\tT\ns\tmA\tNm\n-----\n", joined("\t"), ("t", "i", "T"), (1e-3, 1.0)),
    ("quoted", '"Time [s]","i [mA]","T [N.m]"\n', joined(), ("Time", "i", "T"), (1e-3, 1.0)),
    ("percent_comment", "% rig\n% t i T\n", joined(" "), ("t", "i", "T"), (1.0, 1.0)),
    ("separator_stated", "sep=;\nt;i;T\ns;mA;Nm\n", joined(";"), ("t", "i", "T"), (1e-3, 1.0)),
    (
        "numbered_channels",
        "x-axis,1,2\nsecond,Volt,Volt\n",
        joined(),
        ("x-axis", "1:mA", "2:Nm"),
        (1e-3, 1.0),
    ),
    ("columns_in_brackets", "Time[s], I(mA), M{Nm}\n", joined(), ("Time", "I", "M"), (1e-3, 1.0)),
    ("quotients", "t/s;I/mA;M/(Nm)\n", joined(";", decimal=","), ("t", "I", "M"), (1e-3, 1.0)),
)


@pytest.mark.parametrize(
    ("head", "row", "asked", "factors"), [each[1:] for each in HEADS], ids=[each[0] for each in HEADS]
)
def test_heads_are_read(
    tmp_path: Path, head: str, row: Row, asked: tuple[str, str, str], factors: tuple[float, float]
) -> None:
    found = table(tmp_path, head, row)
    read(found, *asked)
    assert found.select(asked[1], "A").factor == pytest.approx(factors[0])
    assert found.select(asked[2], "Nm").factor == pytest.approx(factors[1])
    assert found.layout.head_numbers == ""


@pytest.mark.parametrize(
    ("head", "row", "current", "torque", "factor"),
    [
        (YOKOGAWA, without_time(",", ",", ","), "CH1", "CH2", 1e-3),
        (YOKOGAWA, without_time(",", ","), "CH1", "CH2", 1e-3),
        (LVM.replace("Amps", "mA") + "X_Value\ti\tT\tComment\n", without_time("\t", "\t"), "i", "T", 1e-3),
        ("CH1V,CH2V,t0 =-2.0e-01, tInc = 1.0e-04,\n", without_time(",", end=",,"), "CH1V:A", "CH2V:Nm", 1.0),
        ("CH1V,CH2V,t0 =-2.0e-01, tInc = 1.0e-04,\n", without_time(","), "CH1V:A", "CH2V:Nm", 1.0),
        ("i,T\nmA,Nm\nLEM,HBM\n", without_time(","), "i", "T", 1e-3),
        ("| i [mA] | T |\n| --- | --- |\n", without_time(" | ", "| ", " |"), "i", "T", 1e-3),
    ],
)
def test_heads_without_a_time_are_read(
    tmp_path: Path, head: str, row: Row, current: str, torque: str, factor: float
) -> None:
    found = table(tmp_path, head, row, timed=False)
    chosen = [found.select(current, "A"), found.select(torque, "Nm")]
    assert chosen[0].factor == pytest.approx(factor)
    rows = found.rows(chosen)
    np.testing.assert_allclose(rows.data[:, 0], CURRENT * factor)
    np.testing.assert_allclose(rows.data[:, 1], TORQUE * chosen[1].factor)


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("Time,Current,Torque\ns,A,Nm\n1,2,3\n", joined()),
        ("Time,Current,Torque\n1,2,3\n", joined()),
        ("1,2,3\n", joined()),
        ("0,1,2\n", joined()),
        ("Time,Current,Torque\n4,17,8\n", joined()),
        ("Time,Current,Torque\n1.00000,10.00000,5.00000\n", joined()),
        ("Time,Current,Torque\n0,100,50\n", joined()),
        ("Time;Current;Torque\ns;A;Nm\n1;2;3\n", joined(";", decimal=",")),
        ("Time|Current|Torque\n1|2|3\n", joined("|")),
        ("Time,Current,Torque\n1,2,3\n16,16,16\n", joined()),
        ("Time,Current,Torque\ns,A,Nm\nScale,0.5,1.0E-3\n", joined()),
        ("Time,Current,Torque\n12:00:00.0,12:00:00.0,12:00:00.0\n", joined()),
        ("t,i,T\n1,2,3\n", lambda place: f"{9.0 + TIME[place]:.5f},{CURRENT[place]:.5f},{TORQUE[place]:.5f}"),
        (
            "t,i,T\n1,2,3\n",
            lambda place: f"12:00:{place / 1e4:07.4f},{CURRENT[place]:.5f},{TORQUE[place]:.5f}",
        ),
        ("t,i,T\n1,2,3\n", lambda place: f"{place},{CURRENT[place]:.5f},{TORQUE[place]:.5f}"),
    ],
)
def test_a_line_of_numbers_that_is_no_row_is_of_the_head_and_told(
    tmp_path: Path, head: str, row: Row
) -> None:
    found = table(tmp_path, head, row)
    rows = found.rows([found.select(f"#{number}", unit) for number, unit in ((1, "s"), (2, "A"), (3, "Nm"))])
    np.testing.assert_allclose(rows.data[:, 1], CURRENT)
    assert found.layout.head_numbers == head.splitlines()[-1]
    (remark,) = numbers_in_head(found.layout)
    assert "was taken for a line of the head" in remark.text
    if "Time" in head:
        assert found.layout.columns[0].name == "Time"


@pytest.mark.parametrize("head", ["i,T\n1,2\n", "i,T\nA,Nm\n3,7\n", "i,T\n1.0,10.0\n"])
def test_a_line_of_numbers_without_a_time_is_told_by_how_it_is_written(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head, without_time(","), timed=False)
    assert found.layout.head_numbers == head.splitlines()[-1]
    assert len(found.rows([found.select("i", "A")]).data) == COUNT


@pytest.mark.parametrize(
    ("first", "row"),
    [
        *(("0,0,0", 1), ("0,1,2", 1), ("0,1,0", 1), ("0.0,5.0,2.0", 1), ("0,5,2", 1)),
        # missing rows behind the first one, and a first cell without a number
        *(("0.00000,4.77668,2.10000", 7), ("0.00000,,2.10000", 1), ("0.00000,OVER,2.10000", 1)),
    ],
)
def test_a_first_row_that_the_others_continue_is_a_row(tmp_path: Path, first: str, row: int) -> None:
    path = tmp_path / "table.csv"
    path.write_text("t,i,T\n" + "\n".join([first, *map(joined(), range(row, COUNT))]) + "\n")
    found = TextTable.open(path)
    assert (found.layout.head_lines, found.layout.head_numbers) == (1, "")


def test_an_extremum_in_the_first_rows_is_no_head(tmp_path: Path) -> None:
    for peak in (1, 2, 3):
        values = [f"{math.cos((place - peak) / 80):.6g},0.5" for place in range(COUNT)]
        assert table(tmp_path, "i,T\n", values.__getitem__, timed=False).layout.head_lines == 1


@pytest.mark.parametrize(
    ("head", "asked", "complaint"),
    [
        # a name with the delimiter in it would shift all others
        ("t,Current, phase a,T\n", "T", r"its head 't,Current, phase a,T' is not of 3 cells"),
        ("Index,t,i,T\n", "T", "is not of 3 cells.* give a name or a number"),
        ("t,i\n", "i", "is not of 3 cells"),
        ("Measured torque, current, speed\nt,T,i\n", "current", "it has 1 't', 2 'T', 3 'i'"),
        ("Rig,4,2024-01-05\n12:00:00.5,1.5,2\n", "Rig", "no column 'Rig'"),
        ("C1 in A,C1 in V,C2 in A\n", "C1", "2 columns 'C1', with the numbers 1, 2: give one"),
        ("t,C1 in V,T\n", "C1", "'V' is no unit of column 'C1', which its head states.* state it"),
        ("t,torque Nm/s,T\n", "torque", "'Nm/s' is no unit of column 'torque'"),
        ("Time(MS),i,T\n", "Time", "'MS' is no unit of column 'Time'|no column"),
    ],
)
def test_what_stays_refused_says_what_to_do(tmp_path: Path, head: str, asked: str, complaint: str) -> None:
    found = table(tmp_path, head, joined())
    with pytest.raises(AnalysisError, match=complaint):
        found.select(asked, "s" if asked == "Time" else "A")


def test_settings_beside_the_first_rows_take_none_of_them(tmp_path: Path) -> None:
    labels = ("Record Length,60,,", "Sample Interval,1.0e-04,,", "Trigger Point,30,,")
    rows = [f"{labels[place] if place < 3 else ',,,'}{joined()(place)}" for place in range(COUNT)]
    read(table(tmp_path, "", rows.__getitem__), "4", "5", "6")


@pytest.mark.parametrize("head", [YOKOGAWA, YOKOGAWA.rstrip("\n") + "\n"])
def test_a_labelled_line_of_times_right_above_the_rows_is_of_the_head_by_its_label(
    tmp_path: Path, head: str
) -> None:
    found = table(tmp_path, head, without_time(",", ","))
    assert found.layout.head_numbers == ""
    assert found.rows([found.select("CH1", "A")]).data.shape[0] == COUNT


def test_units_of_two_labelled_lines_that_differ_are_open(tmp_path: Path) -> None:
    head = "name,t,i,T\nunit,s,mA,Nm\nstored,s,A,Nm\n"
    found = table(tmp_path, head, joined(before=","))
    with pytest.raises(AnalysisError, match="'A or mA' is no unit of column 'i'"):
        found.select("i", "A")
    assert found.select("T", "Nm").unit == "Nm"
