"""Tables that end within a number, with words in the first cell of a row, or with few time stamps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.answer import TableAnswer
from benchtool.tables.time_base import time_base

ROWS = 800


def text(delimiter: str = ",") -> str:
    time_s = np.arange(ROWS) / 2000.0
    torque_mNm = 1500.0 + 50.0 * np.cos(600.0 * time_s)
    return "".join(f"{t:.4f}{delimiter}{x:.2f}\n" for t, x in zip(time_s, torque_mNm, strict=True))


def measured(folder: Path, content: str, rate_Hz: float | None = None) -> TableAnswer:
    path = folder / "table.csv"
    path.write_text("t [s],M [mNm]\n" + content, encoding="utf-8")
    return analyze_table(TableQuestion(path, None if rate_Hz else "1", {"torque": "2"}, rate_Hz=rate_Hz))


def rows_used(found: TableAnswer) -> int:
    return int(found.source["rows_used"])


@pytest.mark.parametrize("rate_Hz", [None, 2000.0])
@pytest.mark.parametrize("delimiter", [",", " ", "\t"])
@pytest.mark.parametrize("cut", [2, 3, 5, 7])
def test_a_number_cut_off_at_the_end_is_left_out(
    tmp_path: Path, cut: int, delimiter: str, rate_Hz: float | None
) -> None:
    found = measured(tmp_path, text(delimiter)[:-cut], rate_Hz)
    assert rows_used(found) == ROWS - 1
    assert found.source["rows_dropped"] == {"wrong number of cells": 1}
    mean = next(each for each in found.measurements if each.name == "torque_mean")
    assert mean.value == pytest.approx(1.5, abs=0.02)


def test_a_last_line_without_an_end_is_whole(tmp_path: Path) -> None:
    assert rows_used(measured(tmp_path, text()[:-1])) == ROWS


@pytest.mark.parametrize("rate_Hz", [None, 2000.0])
def test_rows_that_begin_with_a_word_are_no_rows(tmp_path: Path, rate_Hz: float | None) -> None:
    found = measured(tmp_path, text() + "Mean,1500\nMin,1450\nMax,1550\nSum,1200000\n", rate_Hz)
    assert rows_used(found) == ROWS
    assert found.source["rows_dropped"] == {"a word in the first cell": 4}


def test_the_least_beside_the_greatest_is_no_minute(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("t,M\n" + text() + "Min,1450\nMax,1550\n", encoding="utf-8")
    found = analyze_table(TableQuestion(path, "t", {"torque": "M"}))
    assert rows_used(found) == ROWS


@pytest.mark.parametrize("count", [2, 4, 7])
def test_few_stamps_tell_no_rate(count: int) -> None:
    base = time_base(np.floor(np.arange(4000) * count / 4000.0))
    assert f"the time has {count} different values in 4000 rows, 1 s apart" in base.refusal


@pytest.mark.parametrize("rate_Hz", [None, 2000.0])
def test_stray_quotation_marks_join_no_rows(tmp_path: Path, rate_Hz: float | None) -> None:
    lines = [f"{line};" for line in text(";").splitlines()]
    lines[100] += '5" shaft'
    lines[700] += '"stop'
    path = tmp_path / "table.csv"
    path.write_text("t [s];M [mNm];note\n" + "\n".join(lines) + "\n", encoding="utf-8")
    found = analyze_table(TableQuestion(path, None if rate_Hz else "1", {"torque": "2"}, rate_Hz=rate_Hz))
    assert rows_used(found) == ROWS
