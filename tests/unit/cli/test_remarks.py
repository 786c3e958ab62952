"""What a run says of the numbers that it does not state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.analysis.measurement import Basis
from benchtool.block import Block
from benchtool.cli.output import Output
from benchtool.cli.results import show_remarks
from benchtool.results import Assessment

BLOCK = Block.from_arrays(1000.0, {"torque": "Nm"}, torque=np.zeros(4))


def case(name: str, reason: str) -> Assessment:
    basis = Basis(1000.0, 4, 4e-3)
    lines = tuple(
        Measurement.undefined(f"torque_line_{each}", "Nm", "the largest line", reason, basis)
        for each in ("frequency", "amplitude")
    )
    return Assessment(name, Path("bundle"), lines, (), {}, {}, BLOCK, None, None)


def test_reasons_that_differ_from_case_to_case_are_told_once_and_counted(
    capsys: pytest.CaptureFixture[str],
) -> None:
    cases = [
        case(f"case {each}", f"two lines, of {each} and 0.5 Nm, are equally large") for each in (1, 2, 3)
    ]
    show_remarks(Output(as_json=False), cases)
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("undefined")]
    names = "torque_line_frequency, torque_line_amplitude"
    assert told == [
        f"undefined: {names}: two lines, of 1 and 0.5 Nm, are equally large "
        f"(one of 3 such reasons in these cases: the report has all)"
    ]
    show_remarks(Output(as_json=False), cases[:1])
    assert capsys.readouterr().out.splitlines()[0].endswith("0.5 Nm, are equally large")


def test_what_is_not_known_of_sensors_is_told_once_for_all_cases(capsys: pytest.CaptureFixture[str]) -> None:
    """It was a line for each of twelve cases, as one of them had a number more."""
    unstated, clock = "the sensors' own uncertainty is not stated", "the tolerance of the clock is not stated"

    def mean(name: str, *sensors: str) -> Measurement:
        return Measurement(name, 1.0, "Nm", "", Basis(sensors=sensors))

    cases = [
        replace(case("A", ""), measurements=(mean("torque_mean", unstated),)),
        replace(case("B", ""), measurements=(mean("torque_mean", unstated), mean("line", unstated, clock))),
    ]
    show_remarks(Output(as_json=False), cases)
    told = capsys.readouterr().out.splitlines()
    assert told == [f"{unstated} (torque_mean and 1 more)", f"B: {clock} (line)"]


def test_an_analysis_that_the_rows_do_not_allow_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    """It was told as undefined, for the numbers that a plan tabulates, and as not measured."""
    reason = "'theta_m' covers 1.30 mechanical revolutions, at least 2 are needed for orders"
    found = replace(case("A", reason), refused={"torque orders": reason})
    show_remarks(Output(as_json=False), [found])
    assert capsys.readouterr().out.splitlines() == [f"not measured: torque orders: {reason}"]
