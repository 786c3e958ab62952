"""Heads of tables: units in brackets, two lines of names, and columns that are numbered."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError
from benchtool.tables.columns import TableQuestion, read_columns
from benchtool.tables.selection import Selection
from benchtool.tables.text import TextTable
from benchtool.tables.unit_in_name import unit_in_name
from benchtool.tables.units import is_description, unit_factor

ROWS = "".join(f"{row / 8:.4f},{math.sin(row):.4f},{math.cos(row):.4f}\n" for row in range(40))


def table(folder: Path, head: str) -> TextTable:
    path = folder / "table.csv"
    path.write_text(head + ROWS, encoding="utf-8")
    return TextTable.open(path)


def select(folder: Path, unit: str, si_unit: str, name: str = "x") -> Selection:
    return table(folder, f"t,{name} [{unit}],other\n").select("2", si_unit)


@pytest.mark.parametrize(
    ("unit", "si_unit", "factor"),
    [
        *(("cNm", "Nm", 0.01), ("dN·m", "Nm", 0.1), ("daNm", "Nm", 10.0), ("kp.cm", "Nm", 0.0980665)),
        *(("gf·cm", "Nm", 9.80665e-5), ("lbs-ft", "Nm", 1.3558179), ("kpm", "Nm", 9.80665)),
        *(("1/s", "rad/s", 2 * math.pi), ("s^-1", "rad/s", 2 * math.pi), ("rps", "rad/s", 2 * math.pi)),
        *(("krpm", "rad/s", 1000 * math.pi / 30), ("tr/min", "rad/s", math.pi / 30)),
        *(("°/min", "rad/s", math.pi / 10_800), ("Umdrehungen/min", "rad/s", math.pi / 30)),
        *(("d", "s", 86_400.0), ("msec", "s", 1e-3)),
    ],
)
def test_units_in_brackets_are_converted(tmp_path: Path, unit: str, si_unit: str, factor: float) -> None:
    found = select(tmp_path, unit, si_unit)
    assert (found.unit, found.unit_from) == (unit, "head")
    assert found.factor == pytest.approx(factor, rel=1e-6)


@pytest.mark.parametrize(
    ("unit", "si_unit"),
    [
        *(("mA rms", "A"), ("mArms", "A"), ("mA pk", "A"), ("10 mA", "A"), ("A~", "A"), ("mA/div", "A")),
        *(("mkg", "Nm"), ("mNm (rated)", "Nm"), ("Nm/V", "Nm"), ("RPM*1000", "rad/s"), ("Grad", "rad")),
        *(("°el", "rad"), ("kHz", "rad/s"), ("knots", "rad/s"), ("cts", "Nm")),
    ],
)
def test_units_in_brackets_that_are_not_known_are_refused(tmp_path: Path, unit: str, si_unit: str) -> None:
    with pytest.raises(AnalysisError, match=f"is no unit of column '2'.* state it .* '2:{si_unit}'"):
        select(tmp_path, unit, si_unit)


@pytest.mark.parametrize(
    "text",
    [
        *("0", "a", "phase a", "CH1", "L1", "motor 2", "d-axis", "filtered", "Ist", "sensor 2"),
        *("Bremse", "Messwelle 2", "before gearbox", "dérivée", "GLÄTTUNG"),
    ],
)
def test_an_index_and_words_are_no_units(tmp_path: Path, text: str) -> None:
    assert is_description(text)
    assert select(tmp_path, text, "A").unit_from == "assumed"


@pytest.mark.parametrize(
    "text",
    [
        *("Nmms", "mA rms", "mArms", "Npm", "Newtn", "Newtonmeeter", "ampers", "kNmn", "A peak", "miliamp"),
        *("secnds", "degres", "inch pounds", "poundfeet", "horsepower", "samples", "Inkremente", "impulses"),
        *("Prozent", "LP 1 kHz", "mAmps", "kelvins", "x10", "1:100", "100x"),
    ],
)
def test_what_may_be_a_misspelt_unit_or_a_count_is_no_description(text: str) -> None:
    assert not is_description(text)
    assert unit_factor(text, "Nm") is None


@pytest.mark.parametrize(
    ("name", "si_unit", "unit"),
    [
        *(("time_ms", "s", "ms"), ("torque mNm", "Nm", "mNm"), ("n_rpm", "rad/s", "rpm")),
        *(("omega_deg_per_s", "rad/s", "deg/s"), ("i_s", "A", ""), ("i_a", "A", ""), ("i_d", "s", "")),
        *(("u_h", "s", ""), ("ms", "s", "ms"), ("T_max", "Nm", ""), ("torquemNm", "Nm", "")),
        *(("ms_today", "s", "ms"), ("mA_i", "A", "mA"), ("min_t", "s", ""), ("A_i", "A", "")),
        *(("t:ms", "s", "ms"), ("i.mA", "A", "mA"), ("i@mA", "A", "mA"), ("T=mNm", "Nm", "mNm")),
        *(("speedRpm", "rad/s", "rpm"), ("timeMs", "s", "ms"), ("timeS", "s", ""), ("T.N", "Nm", "")),
    ],
)
def test_a_name_may_end_in_its_unit(name: str, si_unit: str, unit: str) -> None:
    assert unit_in_name(name, si_unit) == unit


def test_one_per_second_of_an_angular_velocity_is_open(tmp_path: Path) -> None:
    assert select(tmp_path, "1/s", "rad/s", "n").factor == pytest.approx(2 * math.pi)
    with pytest.raises(AnalysisError, match="may be rad/s, as its name says, or revolutions per second"):
        select(tmp_path, "1/s", "rad/s", "omega")
    assert unit_factor("1/s", "s") is None


def test_a_line_of_units_with_unknown_ones_is_no_line_of_names(tmp_path: Path) -> None:
    found = table(tmp_path, "t,T,I\ns,kp·in2,A1\n")
    assert found.select("t", "s").unit_from == "head"
    with pytest.raises(AnalysisError, match="'kp·in2' is no unit of column 'T'"):
        found.select("T", "Nm")


def test_either_of_two_lines_of_names_is_found(tmp_path: Path) -> None:
    found = table(tmp_path, "X,CH1,CH2\nSequence,Volt,Value\n")
    assert found.select("CH1:A", "A").number == 2
    assert found.select("Value", "A").number == 3
    with pytest.raises(AnalysisError, match="'Sequence' is no unit of column '1'"):
        found.select("1", "s")


@pytest.mark.parametrize("head", ["t,1,2\n", "0,1,2\n", "x-axis,1,2\nsecond,Ampere,Nm\n"])
def test_numbers_of_channels_are_a_head(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    rows = found.rows([found.select("#1", "s"), found.select("#2", "A")])
    assert (len(rows.data), rows.dropped) == (40, {})


def chosen(folder: Path, head: str, time: str, current: str) -> tuple[list[int], list[str]]:
    question = TableQuestion(table(folder, head).path, time, {"current": current})
    found = read_columns(question)
    texts = [text for _, text in found.called_by_numbers(question)]
    return [each.number for each in found.chosen.values()], texts


def test_a_column_called_by_a_number_is_told(tmp_path: Path) -> None:
    numbers, texts = chosen(tmp_path, "x,1,2\n", "x", "1")
    assert numbers == [1, 2]
    assert "current '1' was read as column 2: it is the name of column 2" in texts[0]
    assert chosen(tmp_path, "t,3,2\n", "1", "2")[0] == [1, 2]  # no column is called 1
    assert chosen(tmp_path, "x,1,2\n", "#1", "#2") == ([1, 2], [])
    with pytest.raises(AnalysisError, match=r"'1' is the name of column 2 of .* give '#1' for the number"):
        chosen(tmp_path, "x,1,2\n", "1", "2")


def test_rows_with_units_in_place_are_read(tmp_path: Path) -> None:
    found = table(tmp_path, "t [s],T [mNm; filtered],x\n")
    assert found.select("1", "s").unit == "s"
    rows = found.rows([found.select("2:Nm", "Nm")])
    np.testing.assert_allclose(rows.data[:, 0], np.round(np.sin(np.arange(40)), 4))


def test_a_bare_number_for_a_speed_is_told_its_unit(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match="or a constant speed with its unit, as '600rpm'"):
        table(tmp_path, "t,T,x\n").select("600", "rad/s")


@pytest.mark.parametrize("head", ["error,low,x\n", "t,error,max\n", "no,inf current,ol temperature\n"])
def test_words_that_name_columns_are_names(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    assert [column.name for column in found.layout.columns] == head.strip().split(",")


@pytest.mark.parametrize(
    "head",
    ["s,mA,mNm\nt,I,T\nai0,ai1,ai2\n", "t [s],I [mA]\n"],
)
def test_a_unit_of_no_column_keeps_si_from_being_assumed(tmp_path: Path, head: str) -> None:
    found = table(tmp_path, head)
    with pytest.raises(
        AnalysisError, match=r"has the unit 'mA', but not of which column; '2' has none: state"
    ):
        found.select("2", "A")
    assert found.select("2:mA", "A").factor == 1e-3


@pytest.mark.parametrize("brackets", ["[]", "()", "{}", "<>"])
def test_brackets_of_any_kind(tmp_path: Path, brackets: str) -> None:
    found = table(tmp_path, f"t,I {brackets[0]}mA{brackets[1]},x\n")
    assert found.select("I", "A").factor == 1e-3


def test_a_column_is_found_by_what_stands_before_a_joined_unit(tmp_path: Path) -> None:
    """Before any whose name differs in its capitals only: t is no torque."""
    found = table(tmp_path, "T,i=mA,t:ms\n")
    chosen = [found.select("t", "s"), found.select("i", "A"), found.select("T", "Nm")]
    assert [(each.number, each.unit) for each in chosen] == [(3, "ms"), (2, "mA"), (1, "Nm")]


@pytest.mark.parametrize(
    ("name", "unit", "si_unit"),
    [
        *(("speed_rad/s", "rad/s", "rad/s"), ("n 1/min", "1/min", "rad/s"), ("n_U/min", "U/min", "rad/s")),
        *(("n/rad/s", "rad/s", "rad/s"), ("n/1/min", "1/min", "rad/s"), ("angle_°", "°", "rad")),
    ],
)
def test_a_solidus_within_a_unit_is_none_before_it(
    tmp_path: Path, name: str, unit: str, si_unit: str
) -> None:
    assert table(tmp_path, f"t,{name},other\n").select("2", si_unit).unit == unit


def test_the_first_cell_of_units_may_be_empty_between_tabs(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_text("Time\tI\tT\n\tmA\tNcm\n" + ROWS.replace(",", "\t"), encoding="utf-8")
    found = TextTable.open(path)
    assert [found.select(*each).unit for each in (("I", "A"), ("T", "Nm"))] == ["mA", "Ncm"]
