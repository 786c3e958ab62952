"""Tables whose rows are one value of several signals, and units that stand beside the numbers."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from benchtool.tables.text import TextTable

COUNT = 100
TIMES = [f"{1e-3 * row:.4f}" for row in range(COUNT)]
VALUES = [f"{5000 * math.cos(0.7 * row):.3f}" for row in range(COUNT)]


def write(folder: Path, *lines: str) -> Path:
    path = folder / "table.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("names", [("i", "T"), ("1", "2"), ("a", "b", "c")])
def test_rows_of_one_signal_after_the_other_are_refused(tmp_path: Path, names: tuple[str, ...]) -> None:
    rows = [f"{time},{name},{value}" for time, value in zip(TIMES, VALUES, strict=True) for name in names]
    path = write(tmp_path, "time [s],channel,value", *rows)
    with pytest.raises(AnalysisError, match=r"column 2 'channel' .* says of each row which signal it has"):
        analyze_table(TableQuestion(path, "time", {"torque": "value"}))


def test_a_column_that_counts_beside_a_time_that_goes_on_is_no_name_of_signals(tmp_path: Path) -> None:
    rows = [f"{time},{row % 6},{value}" for row, (time, value) in enumerate(zip(TIMES, VALUES, strict=True))]
    path = write(tmp_path, "time [s],sector,value [mNm]", *rows)
    assert TextTable.open(path).layout.signals == 0
    assert analyze_table(TableQuestion(path, "time", {"torque": "value"})).measurements


@pytest.mark.parametrize("words", [("True", "False"), ("on", "off")])
def test_a_flag_that_changes_with_every_row_is_no_name_of_signals(
    tmp_path: Path, words: tuple[str, str]
) -> None:
    rows = [f"{t},{words[row % 2]},{value}" for row, (t, value) in enumerate(zip(TIMES, VALUES, strict=True))]
    path = write(tmp_path, "time [s],sync,value [mNm]", *rows)
    assert TextTable.open(path).layout.signals == 0


@pytest.mark.parametrize("where", ["beside", "settings", "below"])
def test_a_unit_beside_or_below_the_numbers_keeps_si_from_being_assumed(tmp_path: Path, where: str) -> None:
    settings = {3: "Vertical Units,mA,", 5: "Horizontal Units,s,"}
    before = [settings.get(row, ",,") if where == "settings" else "" for row in range(COUNT)]
    behind = ",mA" if where == "beside" else ""
    rows = [f"{key}{time},{value}{behind}" for key, time, value in zip(before, TIMES, VALUES, strict=True)]
    head = {"settings": (), "beside": ("t,i,unit",), "below": ("t,i",)}[where]
    path = write(tmp_path, *head, *rows, *(("s,mA",) if where == "below" else ()))
    wanted = "5" if where == "settings" else "2"
    wanted = "4" if where == "settings" and len(TextTable.open(path).layout.columns) == 4 else wanted
    table = TextTable.open(path)
    with pytest.raises(AnalysisError, match="has the unit 'mA', but not of which column"):
        table.select(wanted, "A")
    assert table.select(f"{wanted}:mA", "A").factor == 1e-3


def test_records_behind_each_other_are_told(tmp_path: Path) -> None:
    rows = [f"{time},{value}" for time, value in zip(TIMES, VALUES, strict=True)]
    path = write(tmp_path, "t [s],i [mA]", *rows, *rows)
    found = analyze_table(TableQuestion(path, "t", {"current": "i"})).remarks
    assert RemarkKind.TIME_GOES_BACK in {each.kind for each in found}
