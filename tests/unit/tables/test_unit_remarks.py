"""Units that an option states against the head or against another option, and that a response gives away."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind

PERIOD_S, STEP_ROW, LAG_ROWS = 1e-3, 100, 40.0


def table(folder: Path, head: str, gain: float = 1.0) -> Path:
    """Write the response of a lag, its cells times `gain`, and its reference."""
    rows = np.arange(600)
    answer = 50.0 * (1.0 - np.exp(-np.maximum(rows - STEP_ROW, 0.0) / LAG_ROWS))
    path = folder / "step.csv"
    columns = np.column_stack([rows * PERIOD_S, gain * answer, np.where(rows >= STEP_ROW, 50.0, 0.0)])
    np.savetxt(path, columns, "%.6f", ",", header=head, comments="")
    return path


def remarks(question: TableQuestion) -> dict[RemarkKind, str]:
    return {each.kind: each.text for each in analyze_table(question).remarks}


@pytest.mark.parametrize(
    ("name", "option", "is_told"),
    [
        *(("T [Nm]", "2:mNm", True), ("T_mNm", "2:Nm", True), ("T [Nm]", "2", False)),
        *(("T [Nm]", "2:Nm", False), ("T", "2:mNm", False)),
        # a transducer's gain lies between the unit of the head and that of the option
        *(("T [V]", "2:Nm*5", False), ("T [mNm]", "2:Nm*0.001", False)),
    ],
)
def test_an_option_against_the_head_is_told(tmp_path: Path, name: str, option: str, is_told: bool) -> None:
    found = remarks(TableQuestion(table(tmp_path, f"t [s],{name},x"), "t", {"torque": option}))
    assert (RemarkKind.UNIT_CONTRADICTED in found) == is_told
    if name == "T [Nm]" and is_told:
        assert found[RemarkKind.UNIT_CONTRADICTED].startswith(
            "the head has 'Nm' for column 'T [Nm]', and the option 'mNm', which was taken: its numbers are "
            "0.001 times"
        )


def test_one_that_says_which_of_two_units_the_head_means_is_not(tmp_path: Path) -> None:
    question = TableQuestion(table(tmp_path, "t [s],omega [1/s],x"), "t", {"speed": "2:rad/s"})
    assert RemarkKind.UNIT_CONTRADICTED not in remarks(question)


@pytest.mark.parametrize("unit", ["A", "mNm", "Nm*2"])
def test_two_units_for_one_column_are_refused(tmp_path: Path, unit: str) -> None:
    asked = {"frequency_response": {"input": "3:Nm", "output": f"2:{unit}"}}
    question = TableQuestion(table(tmp_path, "t [s],T,x"), "t", {"torque": "2"}, analyses=asked)
    with pytest.raises(AnalysisError, match=r"in Nm as torque, and in .* as frequency_response output"):
        analyze_table(question)


def test_the_time_is_no_signal(tmp_path: Path) -> None:
    asked = {"step": {"signal": "t", "reference": "3:Nm"}}
    question = TableQuestion(table(tmp_path, "t [s],T,x"), "t", {"torque": "2"}, analyses=asked)
    with pytest.raises(AnalysisError, match=r"'t \[s\]' is the time, and asked for as step signal"):
        analyze_table(question)


@pytest.mark.parametrize(
    ("gain", "pair"),
    [
        (30.0 / math.pi, "'n' may be in rpm and 'ref' in rad/s"),
        (math.pi / 30.0, "'ref' may be in rpm and 'n' in rad/s"),
        *(
            (60.0, "'n' may be in rpm and 'ref' in rev/s"),
            (1000.0, "'n' may be in mrad/s and 'ref' in rad/s"),
        ),
        (180.0 / math.pi, "'n' may be in deg/s and 'ref' in rad/s"),
        (17.0, "'n' ends at 17 times its reference 'ref'"),
    ],
)
def test_a_response_of_several_times_its_reference_is_told(tmp_path: Path, gain: float, pair: str) -> None:
    asked = {"step": {"signal": "n", "reference": "ref"}}
    path = table(tmp_path, "t [s],n,ref", gain)
    found = remarks(TableQuestion(path, "t", {"speed": "n"}, analyses=asked))
    assert pair in found[RemarkKind.OTHER_UNITS]


@pytest.mark.parametrize(("head", "gain"), [("n,ref", 2.0), ("n [rad/s],ref [rad/s]", 17.0)])
def test_one_near_it_or_of_stated_units_is_not(tmp_path: Path, head: str, gain: float) -> None:
    asked = {"step": {"signal": "n", "reference": "ref"}}
    path = table(tmp_path, f"t [s],{head}", gain)
    assert RemarkKind.OTHER_UNITS not in remarks(TableQuestion(path, "t", {"speed": "n"}, analyses=asked))
