"""Cases beside each other in the terminal."""

from __future__ import annotations

import pytest

from benchtool.cli.output import Output
from benchtool.cli.side_by_side import Column, show_beside

NAMES = Column("measurement", ("torque_mean", "transducer_torque_ripple_rms_percent_of_rated"))
UNITS = Column("unit", ("Nm", "%"))


def _case(number: int) -> list[Column]:
    return [Column(f">case.{number}", (f"0.650{number} ± 0.0012", f"(1.{number} ± 1.7) × 10⁻⁵"))]


@pytest.mark.parametrize("columns", [80, 100, 140, 400])
@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_no_value_is_broken_and_no_line_is_wider_than_the_terminal(
    columns: int, count: int, capsys: pytest.CaptureFixture[str]
) -> None:
    output = Output(as_json=False)
    output._people.width = columns
    show_beside(output, "title", [NAMES], [_case(each) for each in range(count)], [UNITS])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= columns
    for each in range(count):
        for value in _case(each)[0].cells:
            assert sum(str(value) in line for line in lines) == 1
    tables = sum(line.startswith("title") for line in lines)
    assert sum("Nm" in line for line in lines) == tables, "units stand in every table"
    if columns == 400:
        assert tables == 1


def test_tables_are_as_wide_as_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    output = Output(as_json=False)
    output._people.width = 100
    show_beside(output, "title", [NAMES], [_case(each) for each in range(4)], [UNITS])
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("measurement")]
    assert [line.count("case.") for line in told] == [2, 2]


def test_a_heading_is_broken_before_it_widens_its_column() -> None:
    column = Column(">transducer_torque_ripple_pp (Nm)", ("0.1919 ± 0.0037",))
    assert column.width == len("0.1919 ± 0.0037")
    assert column.fitted == ">transducer_\ntorque_ripple_\npp (Nm)"


@pytest.mark.parametrize(
    ("stated", "width"), [("80", 80), ("400", 400), ("", 140), ("0", 140), ("wide", 140)]
)
def test_a_pipe_is_as_wide_as_the_environment_says(
    stated: str, width: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Piped tables had 140 columns, whatever COLUMNS said."""
    monkeypatch.setenv("COLUMNS", stated)
    output = Output(as_json=False)
    assert output.width == width
    show_beside(output, "title", [NAMES], [_case(each) for each in range(7)], [UNITS])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= width
