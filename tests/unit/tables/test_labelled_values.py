"""Lines of labelled values, as a sketch writes them for the serial plotter of the Arduino IDE."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchtool.analysis import Measurement
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.labelled_values import as_columns
from benchtool.tables.text import TextTable

COUNT = 400
VALUES = [
    (f"{row}", f"{3.0 * math.cos(0.3 * row):.3f}", f"{0.5 + 0.1 * math.cos(1.8 * row):.4f}")
    for row in range(COUNT)
]


def lines(between: str = "\t", behind: str = "", labels: tuple[str, ...] = ("t", "i", "T")) -> list[str]:
    return [
        between.join(f"{label}:{behind}{value}" for label, value in zip(labels, values, strict=True))
        for values in VALUES
    ]


def written(folder: Path, rows: list[str], ends: str = "\n") -> Path:
    path = folder / "serial.log"
    path.write_bytes((ends.join(rows) + ends).encode())
    return path


def measured(path: Path) -> dict[str, Measurement]:
    found = analyze_table(TableQuestion(path, "t:ms", {"current": "i", "torque": "T"}))
    return {each.name: each for each in found.measurements}


@pytest.mark.parametrize("behind", ["", " "])
@pytest.mark.parametrize("between", ["\t", " ", ",", ", "])
def test_labels_name_the_columns(tmp_path: Path, between: str, behind: str) -> None:
    table = TextTable.open(written(tmp_path, lines(between, behind), "\r\n"))
    assert [column.name for column in table.layout.columns] == ["t", "i", "T"]
    assert table.layout.head_lines == 0
    rows = table.rows([table.select("i", "A"), table.select("T", "Nm")])
    assert rows.data.tolist() == [[float(i), float(torque)] for _, i, torque in VALUES]


def test_they_are_measured_as_any_table(tmp_path: Path) -> None:
    numbers = measured(written(tmp_path, lines()))
    uncertainty = numbers["current_fundamental"].uncertainty
    assert uncertainty is not None
    assert abs(numbers["current_fundamental"].value - 3.0) <= max(uncertainty.expanded, 1e-3)
    assert numbers["fundamental_frequency"].value == pytest.approx(0.3 / (2e-3 * math.pi), rel=1e-4)
    assert numbers["torque_mean"].value == pytest.approx(0.5, abs=1e-3)


def test_units_behind_the_labels_are_those_of_the_columns(tmp_path: Path) -> None:
    table = TextTable.open(written(tmp_path, lines(",", labels=("t [ms]", "phase a [mA]", "T_mNm"))))
    assert table.select("t", "s").factor == 1e-3
    assert table.select("phase a", "A").factor == 1e-3
    assert table.select("T_mNm", "Nm").unit == "mNm"


def test_lines_cut_short_and_other_text_lose_their_rows_alone(tmp_path: Path) -> None:
    rows = lines()
    rows[0] = rows[0][3:]
    rows[100], rows[200], rows[300] = rows[100][:5], "brake on", "i:nan\tT:0.5\tt:300"
    table = TextTable.open(written(tmp_path, ["sensor found", *rows]))
    assert table.layout.head_lines == 2
    found = table.rows([table.select("t", "s"), table.select("i", "A")])
    assert found.dropped == {"a cell is no number": 3}
    assert (found.read, len(found.data)) == (COUNT - 1, COUNT - 4)


def test_the_order_of_labels_may_change(tmp_path: Path) -> None:
    turned = [
        "\t".join(reversed(line.split("\t"))) if row % 3 == 0 else line for row, line in enumerate(lines())
    ]
    table = TextTable.open(written(tmp_path, turned))
    rows = table.rows([table.select("T", "Nm")])
    assert rows.data[:, 0].tolist() == [float(torque) for _, _, torque in VALUES]


def test_one_label_is_a_column_at_a_stated_rate(tmp_path: Path) -> None:
    path = written(tmp_path, [f"torque:{torque}" for _, _, torque in VALUES])
    found = analyze_table(TableQuestion(path, None, {"torque": "torque"}, rate_Hz=1e3))
    assert len(found.record.data) == COUNT


@pytest.mark.parametrize(
    "text",
    [
        "t,i\n12:00:01,1.5\n12:00:02,1.6\n12:00:03,1.7\n",
        "Model:1000\nRate:50000\nPoints:3\nt,i\n0,1\n1,2\n2,3\n",
        "a:1 a:2\na:3 a:4\na:5 a:6\n",
        "a:1\n",
        ":::\n:::\n",
    ],
)
def test_any_other_text_is_left_as_it_is(text: str) -> None:
    assert as_columns(text.encode()) == (text.encode(), 0)
