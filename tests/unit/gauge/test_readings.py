"""Tables of readings: what is understood, and what is refused with its line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.errors import AnalysisError, RecordingError
from benchtool.gauge import read_readings

HEAD = "part,operator,mounting,torque_Nm\n"
WHOLE = HEAD + "".join(
    f"{part},{operator},{mounting},{10 * part + reading}\n"
    for part in (1, 2)
    for operator in ("ann", "bob")
    for mounting in (1, 2)
    for reading in (0.1, 0.2, 0.3)
)


def _table(folder: Path, text: str) -> Path:
    path = folder / "readings.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_factors_become_axes(tmp_path: Path) -> None:
    read = read_readings(_table(tmp_path, WHOLE))
    assert (read.name, read.parts, read.operators) == ("torque_Nm", ("1", "2"), ("ann", "bob"))
    assert read.values.shape == (2, 2, 2, 3)
    assert read.values[1, 0, 1].tolist() == [20.1, 20.2, 20.3]


def test_order_of_lines_and_labels_of_mountings_do_not_matter(tmp_path: Path) -> None:
    lines = WHOLE.splitlines()[1:]
    renamed = [line.replace(",1,", ",x,").replace(",2,", ",y,") if "bob" in line else line for line in lines]
    shuffled = np.random.default_rng(1).permutation(renamed).tolist()
    read = read_readings(_table(tmp_path, HEAD + "\n".join(shuffled)))
    order = [
        list(range(2)) if read.parts[0] == "1" else [1, 0],
        [read.operators.index(n) for n in ("ann", "bob")],
    ]
    values = read.values[order[0]][:, order[1]]
    assert np.sort(values.reshape(2, 2, 6)).tolist() == [
        [[10.1, 10.1, 10.2, 10.2, 10.3, 10.3]] * 2,
        [[20.1, 20.1, 20.2, 20.2, 20.3, 20.3]] * 2,
    ]


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("Part;Operator;Wert\n1;a;0,5\n1;a;0,6\n1;b;0,7\n1;b;0,8\n", (1, 2, 1, 2)),
        ("operator\trepetition\tvalue\na\t1\t1\na\t2\t2\n", (1, 1, 1, 2)),
        ("part,mounting,value\n1,1,1\n1,2,2\n1,3,3\n", (1, 1, 1, 3)),  # one reading of each mounting
        ("\ufeffpart,value\n1,1\n\n1,2\n", (1, 1, 1, 2)),
    ],
)
def test_other_layouts(tmp_path: Path, text: str, shape: tuple[int, ...]) -> None:
    assert read_readings(_table(tmp_path, text)).values.shape == shape


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("", RecordingError, "has 0 lines"),
        (HEAD, RecordingError, "has 1 line,"),
        ("a,b\n1,2\n", AnalysisError, "part, operator, mounting are expected"),
        ("part,x,y\n1,2,3\n", AnalysisError, "name it with --value"),
        (WHOLE + "1,ann,1\n", RecordingError, "line 26: 3 cells, the head has 4"),
        (WHOLE + "1,,1,3\n", AnalysisError, "line 26: no operator is named"),
        (WHOLE + "1,ann,1,nan\n", AnalysisError, "line 26, 'torque_Nm': 'nan' is no finite number"),
        (WHOLE + "1,ann,1,1e999\n", AnalysisError, "no finite number"),
        (WHOLE + "1,ann,1,\n", AnalysisError, "'' is no finite number"),
        (
            WHOLE + "1,ann,1,10.4\n",
            AnalysisError,
            "part '1' by operator 'ann' has 2 mountings with 4, 3 readings",
        ),
        (WHOLE + "3,ann,1,30\n", AnalysisError, "no readings of part '3' by operator 'bob'"),
        ("part,value\n1,1\n2,2\n", AnalysisError, "one reading of each part"),
    ],
)
def test_what_cannot_be_studied(tmp_path: Path, text: str, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        read_readings(_table(tmp_path, text))


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "readings.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RecordingError, match="not text in UTF-8"):
        read_readings(path)
    with pytest.raises(RecordingError, match="check the name"):
        read_readings(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("limit", "margin", "exit_code", "verdict"),
    [
        ("50", (), 0, "pass"),
        ("0.1", (), 1, "undecided"),
        ("0.1", ("--margin", "U"), 1, "undecided"),
        ("0.1", ("--margin", "0"), 1, "fail"),
        ("0.001", (), 1, "fail"),
        ("50", ("--margin", "0"), 0, "pass"),
        ("50", ("--margin", "50"), 0, "marginal"),
    ],
)
def test_the_command_judges_by_the_interval(
    tmp_path: Path, limit: str, margin: tuple[str, ...], exit_code: int, verdict: str
) -> None:
    """Two parts and operators failed a limit that the interval held on both sides of, or passed it."""
    table = str(_table(tmp_path, WHOLE))
    told = CliRunner().invoke(app, ["gauge", table, "--limit", limit, *margin, "--json"])
    assert told.exit_code == exit_code, told.output
    document = json.loads(told.stdout)
    assert document["verdict"] == verdict
    assert document["design"] == {"parts": 2, "operators": 2, "mountings": 2, "repetitions": 3}
    low, high = document["percent_of_total_interval"]
    assert low < document["percent_of_total"] < high
    assert 0.0 <= document["conformance"] <= 1.0
    if not margin:
        assert (high <= float(limit), low > float(limit)) == (verdict == "pass", verdict == "fail")


@pytest.mark.parametrize("margin", ["u", "-1", "nan", "inf"])
def test_a_margin_of_another_kind_is_refused(tmp_path: Path, margin: str) -> None:
    table = str(_table(tmp_path, WHOLE))
    told = CliRunner().invoke(app, ["gauge", table, "--limit", "30", f"--margin={margin}"])
    assert told.exit_code == 2
    assert "U or a number of percent from 0 on is expected" in told.stderr


def test_for_people_it_is_a_table(tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, ["gauge", str(_table(tmp_path, WHOLE)), "--tolerance", "2"])
    assert shown.exit_code == 0
    assert "2 parts, 2 operators, 2 mountings, 3 repetitions" in shown.stdout
    assert "%GRR of the tolerance" in shown.stdout
    assert CliRunner().invoke(app, ["gauge", str(tmp_path / "readings.csv"), "--value", "x"]).exit_code == 2
