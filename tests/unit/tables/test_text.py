"""Tables as other tools write them: encodings, delimiters, heads, units, and rows that are none."""

from __future__ import annotations

import codecs
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.errors import AnalysisError, BenchError, RecordingError
from benchtool.tables.text import Rows, TextTable
from benchtool.tables.units import is_unit, unit_factor

TIME = np.arange(30) * 1e-3
CURRENT = np.round(np.sin(np.arange(30) * 0.7), 4)


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "table.txt"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def lines(delimiter: str = ",", decimal: str = ".", end: str = "") -> str:
    rows = (f"{t:.3f}{delimiter}{i}{end}" for t, i in zip(TIME, CURRENT, strict=True))
    return "\n".join(rows).replace(".", decimal) + "\n"


def read(path: Path, time: str = "1", current: str = "2") -> Rows:
    table = TextTable.open(path)
    return table.rows([table.select(time, "s"), table.select(current, "A")])


def require_all(rows: Rows) -> None:
    np.testing.assert_allclose(rows.data, np.stack([TIME, CURRENT], axis=1))
    assert rows.read == 30
    assert rows.dropped == {}


@pytest.mark.parametrize(
    ("delimiter", "decimal", "end"),
    [
        *((",", ".", ""), (",", ".", ","), (", ", ".", ""), (";", ".", ""), (";", ",", ""), (";", ",", ";")),
        *(
            ("\t", ".", ""),
            ("\t", ",", ""),
            ("\t", ".", "\t"),
            (" ", ".", ""),
            ("   ", ",", " "),
            (" \t", ".", ""),
        ),
    ],
)
def test_delimiters_and_decimal_signs(tmp_path: Path, delimiter: str, decimal: str, end: str) -> None:
    head = f"t{delimiter}I{end}\n"
    require_all(read(write(tmp_path, head + lines(delimiter, decimal, end)), "t", "I"))


@pytest.mark.parametrize(
    ("encoding", "mark", "named"),
    [
        ("utf-8", b"", "utf-8"),
        ("utf-8", codecs.BOM_UTF8, "utf-8-sig"),
        ("utf-16-le", codecs.BOM_UTF16_LE, "utf-16"),
        ("utf-16-be", codecs.BOM_UTF16_BE, "utf-16"),
        ("utf-16-le", b"", "utf-16-le"),
        ("utf-16-be", b"", "utf-16-be"),
        ("cp1252", b"", "cp1252"),
    ],
)
@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends(
    tmp_path: Path, encoding: str, mark: bytes, named: str, line_end: str
) -> None:
    text = ("Zeit (µs),Strom [mA],Lage [°]\n" + lines(end=",1")).replace("\n", line_end)
    table = TextTable.open(write(tmp_path, mark + text.encode(encoding)))

    assert table.encoding == named
    assert table.select("Zeit (µs)", "s").factor == 1e-6
    assert table.select("lage", "rad").factor == pytest.approx(math.pi / 180)
    rows = table.rows([table.select("Zeit", "s"), table.select("Strom", "A")])
    np.testing.assert_allclose(rows.data, np.stack([TIME * 1e-6, CURRENT * 1e-3], axis=1))


@pytest.mark.parametrize(
    ("head", "time", "current", "skipped"),
    [
        ("", "1", "2", 0),
        ("x-axis,4\nsecond,Ampere\n", "x-axis", "4", 2),
        ("x-axis,4\nsecond,Ampere\n", "1", "2", 2),
        (" Time, Iq\n", "Time", "Iq", 1),
        ("# Time, Iq\n", "Time", "Iq", 1),
        ("% made by a logger\n%\n% Time, Iq\n", "Time", "Iq", 3),
        ("sep=,\nTime,Iq\n", "Time", "Iq", 2),
        ('Model,X1\nDate,2026-11-21\n\n"Time","Iq"\n', "Time", "Iq", 4),
        ("Time,Iq,\n", "Time", "Iq", 1),
        ("Time;Iq\n", "Time", "Iq", 1),
        ("Time (s),CH1: Iq [A]\n", "Time", "CH1: Iq", 1),
    ],
)
def test_heads(tmp_path: Path, head: str, time: str, current: str, skipped: int) -> None:
    path = write(tmp_path, head + lines())
    require_all(read(path, time, current))
    assert TextTable.open(path).layout.head_lines == skipped


def test_units_of_a_second_head_line_count(tmp_path: Path) -> None:
    table = TextTable.open(write(tmp_path, "t;I\nms;mA\n" + lines(";")))
    selection = table.select("I", "A")
    assert (selection.factor, selection.unit_from) == (1e-3, "head")
    assert table.select("t", "s").factor == 1e-3


def test_an_option_overrides_the_unit_of_the_head(tmp_path: Path) -> None:
    table = TextTable.open(write(tmp_path, "t:1,Iq [mA],raw (counts)\n" + lines(end=",7")))

    assert table.select("Iq", "A").factor == 1e-3
    assert table.select("Iq:A", "A").factor == 1.0
    assert table.select("Iq [mA]:uA", "A").factor == 1e-6
    assert table.select("2:kA", "A").unit_from == "option"
    assert table.select("t:1", "s").number == 1
    assert table.select("t:1:ms", "s").factor == 1e-3
    raw = table.select("raw:mNm", "Nm")
    assert (raw.unit, raw.unit_from, raw.factor) == ("mNm", "option", 1e-3)


@pytest.mark.parametrize(
    ("head", "unit", "si_unit"),
    [
        *(
            ("T (%)", "%", "Nm"),
            ("CH1 (V)", "V", "A"),
            ("raw [counts]", "counts", "rad"),
            ("t [-]", "-", "s"),
        ),
        *(("I\nV", "V", "A"), ("T\n%", "%", "Nm")),
    ],
)
def test_a_unit_in_the_head_of_another_kind_is_never_taken_as_si(
    tmp_path: Path, head: str, unit: str, si_unit: str
) -> None:
    name, _, below = head.partition("\n")
    second = f"s,{below},A\n" if below else ""
    table = TextTable.open(write(tmp_path, f"t,{name},I2\n{second}" + lines(end=",7")))
    with pytest.raises(AnalysisError, match=f"state it in the option, as '2:{si_unit}'") as refused:
        table.select("2", si_unit)
    assert f"'{unit}' is no unit of column '2', which its head states" in str(refused.value)
    assert table.select(f"2:{si_unit}", si_unit).factor == 1.0


def test_a_decimal_comma_that_a_long_record_shows_late_is_found(tmp_path: Path) -> None:
    rows = 50_000
    values = np.where(np.arange(rows) < 40_000, 3.0, 0.5)
    body = "\n".join(f"{row};{value:g}".replace(".", ",") for row, value in enumerate(values))
    found = read(write(tmp_path, f"t;I\n{body}\n"), "t", "I")
    assert found.dropped == {}
    np.testing.assert_array_equal(found.data[:, 1], values)


def test_what_stands_apart_from_the_line_of_units_names_no_column(tmp_path: Path) -> None:
    table = TextTable.open(write(tmp_path, f"Operator,Smith\nno names here\ns,A\n{lines()}"))
    assert not {"Operator", "Smith"} & {column.name for column in table.layout.columns}


@pytest.mark.parametrize("units", ["min,mA,Ncm", "min,mA,foo", "[min],[mA],[foo]"])
def test_a_line_of_units_is_never_one_of_names(tmp_path: Path, units: str) -> None:
    table = TextTable.open(write(tmp_path, f"t,I,T\n{units}\n" + lines(end=",7")))
    assert (table.select("t", "s").factor, table.select("I", "A").factor) == (60.0, 1e-3)
    if "Ncm" in units:
        assert table.select("T", "Nm").factor == 1e-2
    else:
        with pytest.raises(AnalysisError, match="'foo' is no unit of column 'T'"):
            table.select("T", "Nm")


@pytest.mark.parametrize(
    ("wanted", "complaint"),
    [
        ("Iq", "2 columns 'Iq', with the numbers 2, 3: give one"),
        ("Torque", "no column 'Torque', it has 1 't', 2 'Iq', 3 'Iq': give a name or a number"),
        ("4", "no column '4'"),
        ("0", "no column '0'"),
        ("2:Nm", "'Nm' is no unit of column '2', as given; expected is one of A, mA, uA"),
        ("", "no column ''"),
    ],
)
def test_a_column_that_is_not_there_or_there_twice(tmp_path: Path, wanted: str, complaint: str) -> None:
    table = TextTable.open(write(tmp_path, "t,Iq,Iq\n" + lines(end=",7")))
    assert table.select("3", "A").number == 3
    with pytest.raises(AnalysisError) as refused:
        table.select(wanted, "A")
    assert complaint in str(refused.value)


def test_without_a_head_names_are_refused_by_number(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match="it has no names, and columns 1 to 2"):
        TextTable.open(write(tmp_path, lines())).select("t", "s")


def test_rows_that_are_none_are_left_out_and_counted(tmp_path: Path) -> None:
    good = lines().splitlines()
    text = "\n".join(
        [
            *("t,I", *good[:10], "", "   ", "# a remark", "0.5,1,2", "0.5", "0.5,n/a", "0.5,", "nan,1"),
            *(
                "0.5,inf",
                *good[10:20],
                "%0.5,0.5",
                "0.5,1.5.5",
                "0x5,1",
                "1e400,1",
                "0.5,9.91E+37",
                *good[20:],
                "0.0",
            ),
        ]
    )
    rows = read(write(tmp_path, text), "t", "I")

    np.testing.assert_allclose(rows.data, np.stack([TIME, CURRENT], axis=1))
    assert rows.dropped == {"wrong number of cells": 3, "a cell is no number": 8}
    assert rows.read == 41


@pytest.mark.parametrize("cell", ["21.11.2026", "1:30", "1.2.3", "ungültig"])
def test_the_first_cell_that_is_no_number_is_named(tmp_path: Path, cell: str) -> None:
    table = TextTable.open(write(tmp_path, "t,I,T\n" + lines(end=f",{cell}")))
    chosen = [table.select("t", "s"), table.select("T", "Nm")]
    assert table.unreadable_cell(chosen) == f"'{cell}' in column 3"
    assert table.unreadable_cell(chosen[:1]) == ""


@pytest.mark.parametrize("first", ["0.000,,", "0.000,nan,", "0.000,,0.0\n0.001,n/a,"])
def test_first_rows_with_empty_cells_are_left_out_and_never_taken_for_the_head(
    tmp_path: Path, first: str
) -> None:
    rows = lines(end=",1").splitlines(keepends=True)[first.count("\n") + 1 :]
    found = read(write(tmp_path, f"time,Iq,T\n{first}\n{''.join(rows)}"), "time", "Iq")
    np.testing.assert_allclose(found.data, np.stack([TIME, CURRENT], axis=1)[-len(rows) :])
    assert (found.read, found.dropped) == (30, {"a cell is no number": 30 - len(rows)})


def test_only_the_columns_asked_for_must_be_numbers(tmp_path: Path) -> None:
    text = lines(end=",ok").replace("ok", "ERROR", 1)
    require_all(read(write(tmp_path, "t,I,state\n" + text), "t", "I"))


def test_zero_bytes_never_join_what_stands_beside_them(tmp_path: Path) -> None:
    text = ("t,I\n" + lines()).encode() + b"0.1\0\0005,1\n" + b"\0" * 512
    rows = read(write(tmp_path, text), "t", "I")
    np.testing.assert_allclose(rows.data, np.stack([TIME, CURRENT], axis=1))
    assert rows.dropped == {"a cell is no number": 1}


def test_quoted_numbers_with_decimal_commas(tmp_path: Path) -> None:
    text = "".join(f'"{t:.3f}","{i}"\n'.replace(".", ",") for t, i in zip(TIME, CURRENT, strict=True))
    require_all(read(write(tmp_path, '"t","I"\n' + text), "t", "I"))


def test_signs_and_exponents(tmp_path: Path) -> None:
    text = "".join(f"{t:+.9E},{i:+.13E}\n" for t, i in zip(TIME, CURRENT, strict=True))
    require_all(read(write(tmp_path, text)))
    spoilt = read(write(tmp_path, text + "x,1\n"))
    np.testing.assert_allclose(spoilt.data, np.stack([TIME, CURRENT], axis=1))


def test_a_later_decimal_comma_shows_the_layout(tmp_path: Path) -> None:
    """Whole numbers at the beginning do not tell; the end of the file does."""
    text = "t;I\n" + "".join(f"{n};{n}\n" for n in range(2_000)) + "2000;0,5\n2001;0,25\n"
    table = TextTable.open(write(tmp_path, text))
    assert table.layout.decimal == ","
    assert table.rows([table.select("I", "A")]).data[-1, 0] == 0.25


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "is empty"),
        (b" \r\n\n", "is empty"),
        (b"hello\nworld\n", "no table of numbers"),
        (b"1\n2\n3\n", "no table of numbers"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "no table of numbers"),
        (bytes(range(256)) * 4, "is binary and no text"),
        (b"t,I\n11/21/2026 12h,0.5\n", "'11/21/2026 12h' is none; .* times in seconds"),
        (b"t;I\n1:30;0.5\n1:31;0.5\n", "'1:30' is none"),
        (b"PAR1\x15\x04", "is a Parquet file and no text"),
        (np.arange(900, dtype=np.int16).tobytes() + bytes(300), "is binary and no text"),
    ],
)
def test_what_is_no_table_is_one_line(tmp_path: Path, content: bytes, complaint: str) -> None:
    with pytest.raises(RecordingError, match=complaint) as refused:
        TextTable.open(write(tmp_path, content))
    assert "\n" not in str(refused.value)


def test_a_file_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot read .*nowhere\.csv: No such file"):
        TextTable.open(tmp_path / "nowhere.csv")
    with pytest.raises(RecordingError, match="cannot read"):
        TextTable.open(tmp_path)


CELLS = st.one_of(
    st.floats().map(str),
    st.integers().map(str),
    st.sampled_from(
        ["", " ", "nan", "1,5", '"', '""', '"1"', "#", "%", "+1e3", "\0", "µ", "1.2.3", "-", "1e999"]
    ),
    st.text(max_size=5),
)
TABLES = st.builds(
    lambda rows, delimiter, end, encoding: end.join(map(delimiter.join, rows)).encode(encoding, "replace"),
    st.lists(st.lists(CELLS, min_size=1, max_size=5), min_size=1, max_size=12),
    st.sampled_from([",", ";", "\t", " ", ", "]),
    st.sampled_from(["\n", "\r\n", "\r"]),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
)


@given(content=st.one_of(st.binary(max_size=400), TABLES))
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_give_finite_rows_or_an_error_of_the_tree(tmp_path: Path, content: bytes) -> None:
    path = write(tmp_path, content)
    try:
        table = TextTable.open(path)
        selections = [table.select(str(number + 1), "s") for number in range(len(table.layout.columns))]
        for chosen in (selections, selections[:1], selections[-1:]):
            rows = table.rows(chosen)
            assert np.all(np.isfinite(rows.data))
            assert len(rows.data) + sum(rows.dropped.values()) == rows.read
    except BenchError:
        pass


@given(
    values=st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=3, max_size=30),
    layout=st.sampled_from(
        [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")]
    ),
)
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_numbers_survive_to_the_bit(
    tmp_path: Path, values: list[tuple[float, float]], layout: tuple[str, str]
) -> None:
    delimiter, decimal = layout
    text = "".join(
        delimiter.join(repr(value).replace(".", decimal) for value in row) + "\n" for row in values
    )
    rows = read(write(tmp_path, "a" + delimiter + "b\n" + text), "a", "b")
    np.testing.assert_array_equal(rows.data, np.array(values))


@pytest.mark.parametrize(
    ("text", "unit", "factor"),
    [
        *(("mA", "A", 1e-3), ("milliamps", "A", 1e-3), ("Ampere", "A", 1.0), ("amps", "A", 1.0)),
        *(("µs", "s", 1e-6), ("second", "s", 1.0), ("Seconds", "s", 1.0), ("ms", "s", 1e-3)),
        *(("N·m", "Nm", 1.0), ("N.m", "Nm", 1.0), ("mN·m", "Nm", 1e-3), ("N m", "Nm", 1.0)),
        *(("°", "rad", math.pi / 180), ("degrees", "rad", math.pi / 180), ("rev", "rad", 2 * math.pi)),
        *(("Ncm", "Nm", 1e-2), ("N·cm", "Nm", 1e-2), ("N-cm", "Nm", 1e-2), ("Nmm", "Nm", 1e-3)),
        *(("lbf·ft", "Nm", 1.3558179), ("lb-ft", "Nm", 1.3558179), ("ft.lbs", "Nm", 1.3558179)),
        *(("ozf·in", "Nm", 7.0615518e-3), ("oz-in", "Nm", 7.0615518e-3), ("lb-in", "Nm", 0.11298483)),
        *(("min", "s", 60.0), ("h", "s", 3600.0), ("hours", "s", 3600.0), ("U/min", "rad/s", math.pi / 30)),
        *(
            ("RPM", "rad/s", math.pi / 30),
            ("min⁻¹", "rad/s", math.pi / 30),
            ("1/min", "rad/s", math.pi / 30),
            ("°/s", "rad/s", math.pi / 180),
        ),
    ],
)
def test_units_as_people_write_them(text: str, unit: str, factor: float) -> None:
    assert unit_factor(text, unit) == pytest.approx(factor)
    assert is_unit(text)


@pytest.mark.parametrize(
    ("text", "unit"), [("", "A"), ("V", "A"), ("counts", "rad"), ("MS", "s"), ("Iq", "A")]
)
def test_what_is_no_unit_of_the_kind(text: str, unit: str) -> None:
    assert unit_factor(text, unit) is None


@pytest.mark.parametrize(
    "head",
    [
        "10000,2\nTime,Iq\n",
        "1,2\n3,4\nTime [s],Iq [A]\n",
        "10000,2\nTime,Iq\ns,A\n",
        "".join(f"parameter {number},{number}\n" for number in range(12)) + "Time,Iq\n",
    ],
)
def test_numbers_in_the_head_are_no_rows(tmp_path: Path, head: str) -> None:
    path = write(tmp_path, head + lines())
    require_all(read(path, "Time", "Iq"))
    assert TextTable.open(path).layout.head_lines == head.count("\n")


@pytest.mark.parametrize(
    ("head", "name", "factor", "si_unit"),
    [
        *(("I/mA", "I", 1e-3, "A"), ("Iq / mA", "Iq", 1e-3, "A"), ("n/(1/min)", "n", math.pi / 30, "rad/s")),
        *(("n/min-1", "n", math.pi / 30, "rad/s"), ("omega/rad/s", "omega", 1.0, "rad/s")),
        ("rad/s", "rad/s", 1.0, "A"),
    ],
)
def test_a_quotient_of_quantity_and_unit(
    tmp_path: Path, head: str, name: str, factor: float, si_unit: str
) -> None:
    table = TextTable.open(write(tmp_path, f"t/ms,{head}\n{lines()}"))
    assert table.select("t", "s").factor == 1e-3
    assert table.select(name, si_unit).factor == pytest.approx(factor)
    assert table.select(name, si_unit).unit_from == ("head" if name != head else "assumed")


@pytest.mark.parametrize("name", ["Iq[0]", "I (phase a)", "Current [Phase A]", "Iq (filtered)"])
def test_brackets_that_hold_no_unit_are_part_of_the_name(tmp_path: Path, name: str) -> None:
    table = TextTable.open(write(tmp_path, f"t,{name}\n{lines()}"))
    assert table.select(name, "A").unit_from == "assumed"
    both = TextTable.open(write(tmp_path, f"t,{name} [mA] (raw value)\n{lines()}"))
    assert both.select("2", "A").factor == 1e-3


@pytest.mark.parametrize(
    ("stated", "gain", "offset", "factor"),
    [
        ("2:A*10-0.2", 10.0, -0.2, 1.0),
        ("2:mA*0.5+0.1", 0.5, 0.1, 1e-3),
        ("2:*-1", -1.0, 0.0, 1e-3),
        ("2:A+1e-3", 1.0, 1e-3, 1.0),
        ("2:A*1e-3", 1e-3, 0.0, 1.0),
    ],
)
def test_gain_and_offset(tmp_path: Path, stated: str, gain: float, offset: float, factor: float) -> None:
    table = TextTable.open(write(tmp_path, "t,CH1 (mA)\n0,1\n1,2\n2,5\n"))
    selection = table.select(stated, "A")
    assert (selection.gain, selection.offset, selection.factor) == (gain, offset, factor)
    expected = (np.array([1.0, 2.0, 5.0]) * gain + offset) * factor
    np.testing.assert_allclose(table.rows([selection]).data[:, 0], expected, rtol=1e-12)


def test_a_unit_that_ends_like_an_offset_is_a_unit(tmp_path: Path) -> None:
    table = TextTable.open(write(tmp_path, "t,n\n" + lines()))
    assert table.select("n:min-1", "rad/s").offset == 0.0
    assert table.select("n:min-1*2-3", "rad/s").offset == -3.0
    with pytest.raises(AnalysisError, match="a gain other than zero"):
        table.select("n:rpm*0", "rad/s")


def test_percent_is_of_the_rated_value(tmp_path: Path) -> None:
    table = TextTable.open(write(tmp_path, "t,T [%]\n" + lines()))
    assert table.select("T", "Nm", rated=2.0).factor == 0.02
    with pytest.raises(AnalysisError, match="'%' is no unit"):
        table.select("T", "Nm")


@pytest.mark.parametrize(
    ("encoding", "head", "name"),
    [
        ("gb2312", "时间(s),A相电流(A),转矩(N.m)", "转矩"),
        ("cp1252", "Zeit (s),Strom (A),Drehmoment für Prüfling (N·m)", "Drehmoment für Prüfling"),
        ("cp1252", "t [µs],i [A],T [°]", "T"),
    ],
)
def test_words_of_another_alphabet_are_read_in_its_encoding(
    tmp_path: Path, encoding: str, head: str, name: str
) -> None:
    """Chinese names were read as Western letters, by which no column was found."""
    rows = "".join(f"{row / 8},{row % 5},{row % 7}\n" for row in range(40))
    path = tmp_path / "table.csv"
    path.write_bytes(f"{head}\n{rows}".encode(encoding))
    found = TextTable.open(path)
    assert found.encoding == {"gb2312": "gb18030"}.get(encoding, encoding)
    assert found.select(f"{name}:Nm", "Nm").number == 3
