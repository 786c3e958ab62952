"""Signals of several rates in one table: a row has only those that were read at its time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.answer import TableAnswer
from benchtool.tables.long_form import signal_column

ROWS, EVERY = 8000, 10
TIME_S = np.arange(ROWS) * 1e-4
CURRENT_A = 3.0 * np.cos(2.0 * np.pi * 50.0 * TIME_S)
TORQUE_NM = 1.0 + 0.1 * np.cos(2.0 * np.pi * 60.0 * TIME_S)


def measured(
    folder: Path, lines: list[str], columns: dict[str, str], rate_Hz: float | None = None
) -> TableAnswer:
    path = folder / "table.csv"
    path.write_text("t [s];i [A];T [Nm]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return analyze_table(TableQuestion(path, None if rate_Hz else "t", columns, rate_Hz=rate_Hz))


def two_rates(empty: str) -> list[str]:
    return [
        f"{t:.4f};{i:.5f};{f'{x:.5f}' if row % EVERY == 0 else empty}"
        for row, (t, i, x) in enumerate(zip(TIME_S, CURRENT_A, TORQUE_NM, strict=True))
    ]


@pytest.mark.parametrize("empty", ["", "NaN"])
@pytest.mark.parametrize("rate_Hz", [None, 1e4])
def test_a_signal_of_a_lower_rate_is_measured_at_that(
    tmp_path: Path, empty: str, rate_Hz: float | None
) -> None:
    found = measured(tmp_path, two_rates(empty), {"torque": "T"}, rate_Hz)
    numbers = {each.name: each for each in found.measurements}
    assert found.source["time"]["rate_Hz"] == pytest.approx(1e3)
    assert numbers["torque_mean"].value == pytest.approx(1.0, abs=1e-4)
    assert numbers["torque_line_amplitude"].value == pytest.approx(0.1, rel=1e-3)
    assert numbers["torque_line_frequency"].value == pytest.approx(60.0, rel=1e-4)


def test_two_signals_of_different_rates_are_not_measured_together(tmp_path: Path) -> None:
    found = measured(tmp_path, two_rates(""), {"current": "i", "torque": "T"})
    fundamental = next(each for each in found.measurements if each.name == "current_fundamental")
    assert "of its values are in rows in which another column has none" in fundamental.reason
    assert "measure it without that column" in fundamental.reason


def test_signals_in_alternate_rows_are_to_be_measured_one_by_one(tmp_path: Path) -> None:
    lines = [
        f"{t + late:.5f};{cells}"
        for t, i, x in zip(TIME_S, CURRENT_A, TORQUE_NM, strict=True)
        for late, cells in ((0.0, f"{i:.5f};"), (2e-5, f";{x:.5f}"))
    ]
    with pytest.raises(AnalysisError, match="in other rows than the others: measure them one by one"):
        measured(tmp_path, lines, {"current": "i", "torque": "T"})
    found = measured(tmp_path, lines, {"torque": "T"})
    assert found.source["time"]["rate_Hz"] == pytest.approx(1e4)


def test_a_row_that_lacks_a_value_is_still_missing(tmp_path: Path) -> None:
    lines = two_rates("")
    lines[500] = lines[500].rpartition(";")[0] + ";"
    found = measured(tmp_path, lines, {"torque": "T"})
    mean = next(each for each in found.measurements if each.name == "torque_mean")
    assert not np.isfinite(mean.value)


def test_few_rows_that_are_left_say_why(tmp_path: Path) -> None:
    lines = [
        f"{1e4 * t:.0f}x;{i:.4f};1" if t else f"0;{i:.4f};1" for t, i in zip(TIME_S, CURRENT_A, strict=True)
    ]
    found = measured(tmp_path, lines, {"current": "i"})
    reason = next(each for each in found.measurements if each.name == "current_fundamental").reason
    left_out = (
        f"of {ROWS} rows {ROWS - 1} are left out, with a cell that is no number, the first '1x' in column 1"
    )
    assert left_out in reason


def test_milliseconds_beside_whole_seconds_name_no_signals() -> None:
    rows = [(f"10:00:{row // 20:02d}", str(50 * (row % 20)), f"{row * 0.37 % 1:.3f}") for row in range(400)]
    assert signal_column(rows, (True, True, True)) == 0
    channels = [(f"10:00:{row // 20:02d}", str(row % 20), f"{row * 0.37 % 1:.3f}") for row in range(400)]
    assert signal_column(channels, (True, True, True)) == 2
