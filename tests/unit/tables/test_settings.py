"""Settings of instruments in the head of a table: units of columns, and the distance of rows."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from benchtool.tables.settings import row_distance, settings_of
from benchtool.tables.text import TextTable

COUNT = 200


def table(
    folder: Path, head: str, *, beside: tuple[str, ...] = (), cells: str = "{t:.5f},{u:.4f},{i:.4f}"
) -> Path:
    """Write a table of a time, voltage and current, settings above them or beside the first rows."""
    rows = []
    for row in range(COUNT):
        t, angle = row * 1e-4, 2.0 * math.pi * row / 40
        before = f"{beside[row] if row < len(beside) else ','}," if beside else ""
        rows.append(
            before + cells.format(t=t, u=20.0 * math.cos(angle), i=5.0 * math.sin(angle + 0.1), row=row)
        )
    path = folder / "table.csv"
    path.write_text("\n".join((*head.splitlines(), *rows)) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "settings",
    [
        "Horizontal Units,s\nVertical Units,V,A",
        "Horizontal Units,s,s\nVertical Units,V,A,",
        "#Vertical Units,V,A",
        "Units,s,V,A",
        "Vertical Units,CH1:V,CH2:A",
    ],
)
def test_units_that_settings_state_are_those_of_the_columns(tmp_path: Path, settings: str) -> None:
    found = TextTable.open(table(tmp_path, f"Model,MSO54\n{settings}\nLabel,Udc,Ia\nTIME,CH1,CH2"))
    assert found.select("CH2", "A").unit_from == "head"
    with pytest.raises(AnalysisError, match="'V' is no unit of column 'CH1', which its head states"):
        found.select("CH1", "A")
    assert found.select("CH1:A*10", "A").gain == 10.0


def test_each_channel_with_a_time_of_its_own_has_its_own_unit(tmp_path: Path) -> None:
    cells = "{t:.5f},{u:.4f},{t:.5f},{i:.4f}"
    found = TextTable.open(table(tmp_path, "Vertical Units,V,,A\nTIME,CH1,TIME,CH2", cells=cells))
    assert found.select("CH2", "A").unit_from == "head"
    with pytest.raises(AnalysisError, match="'V' is no unit"):
        found.select("2", "A")


@pytest.mark.parametrize("unit", ["V", "A"])
def test_one_unit_is_that_of_all_but_the_time(tmp_path: Path, unit: str) -> None:
    beside = (
        "Record Length,200,",
        "Sample Interval,1e-4,",
        ",,",
        f"Vertical Units,{unit},",
        "Horizontal Units,s,",
    )
    for path in (
        table(tmp_path, f"Y-Unit: {unit}\nt,i", cells="{t:.5f},{i:.4f}"),
        table(tmp_path, "", beside=beside, cells="{t:.5f},{i:.4f}"),
    ):
        found = TextTable.open(path)
        current = str(len(found.layout.columns))
        if unit == "V":
            with pytest.raises(AnalysisError, match="'V' is no unit"):
                found.select(current, "A")
        else:
            assert found.select(current, "A").unit_from == "head"


@pytest.mark.parametrize("line", ["Vertical Units,V,mA", "Unit,V,mA"])
def test_a_label_right_above_the_names_is_no_unit_of_the_first_column(tmp_path: Path, line: str) -> None:
    found = TextTable.open(table(tmp_path, f"Horizontal Units,s\n{line}\nTIME,CH1,CH2"))
    time, current = found.select("TIME", "s"), found.select("CH2", "A")
    assert (time.factor, time.unit_from) == (1.0, "head")
    assert current.factor == 1e-3


def test_a_label_for_each_channel_is_no_unit(tmp_path: Path) -> None:
    head = "Vertical Units,V,Vertical Units,A\nMode,Detail,Mode,Detail\nTime,CH1,Time,CH2"
    found = TextTable.open(table(tmp_path, head, cells="{t:.5f},{u:.4f},{t:.5f},{i:.4f}"))
    assert found.select("CH2", "A").unit_from == "head"
    with pytest.raises(AnalysisError, match="'V' is no unit of column 'CH1'"):
        found.select("CH1", "A")


def test_a_unit_of_the_name_is_before_that_of_a_setting(tmp_path: Path) -> None:
    found = TextTable.open(table(tmp_path, "Vertical Units,V\nt,u,I_mA"))
    assert found.select("I_mA", "A").factor == 1e-3


@pytest.mark.parametrize(
    "line",
    [
        *(
            "Sample Interval,1.000000e-04",
            "Sampling Period,1.0e-4,",
            "XInc,1e-4",
            "#CLOCK=100uS",
            "dt = 0.1 ms",
        ),
        *(
            "SampleRate,1.0E+004,1.0E+004",
            "# Sample rate: 10000Hz",
            "Sampling Rate: 10 kSa/s",
            "Sample rate [kHz]: 10",
        ),
        *("t0 =-2.0e-01,tInc = 1.0e-04", "Sample Interval,Analog:0.000100"),
        "X,CH1,Start,Increment\nSequence,Volt,-2.0e-1,1.0e-4",
    ],
)
def test_the_distance_of_rows_is_read(line: str) -> None:
    lines = line.splitlines()
    found = row_distance(settings_of(lines, ","), lines, ",")
    assert found is not None
    assert found.seconds == pytest.approx(1e-4)


@pytest.mark.parametrize(
    "line",
    [
        "Period,0.02",
        "Interval,00:00:01",
        "Sample Interval,0",
        "Interval,1e-3\nSample Rate,10000",
        "Clock: internal",
    ],
)
def test_what_states_no_distance_or_several_is_none(line: str) -> None:
    lines = line.splitlines()
    assert row_distance(settings_of(lines, ","), lines, ",") is None


@pytest.mark.parametrize(
    ("time", "rate_Hz", "told"), [("t", None, 0), ("t:ms", None, 1), (None, 10e3, 0), (None, 2e4, 1)]
)
def test_rows_that_are_apart_otherwise_than_the_head_states_are_told(
    tmp_path: Path, time: str | None, rate_Hz: float | None, told: int
) -> None:
    path = table(tmp_path, "Sample Interval,1e-4\nt,u,i")
    found = analyze_table(TableQuestion(path, time, {"current": "i"}, rate_Hz=rate_Hz))
    texts = [each.text for each in found.remarks if each.kind is RemarkKind.OTHER_INTERVAL]
    assert len(texts) == told
    assert all("'Sample Interval,1e-4' in the head puts rows 0.0001 s apart" in each for each in texts)


def test_a_column_that_counts_rows_is_no_time_and_the_message_has_the_rate(tmp_path: Path) -> None:
    head = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Amp,-2.0e-1,1.0e-4"
    found = TextTable.open(table(tmp_path, head, cells="{row},{u:.4f},{i:.4f},,"))
    with pytest.raises(
        AnalysisError, match="of a column that counts rows state --rate instead, by the head --rate 10000"
    ):
        found.select("X", "s")


def test_columns_in_one_option_are_asked_for_one_by_one(tmp_path: Path) -> None:
    found = TextTable.open(table(tmp_path, "t,ia,ib"))
    with pytest.raises(AnalysisError, match="give a name or a number, and the option once for each column"):
        found.select("ia,ib", "A")
