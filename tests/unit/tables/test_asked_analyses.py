"""Analyses that are asked of a table by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.tables import TableQuestion, analyze_table

PERIOD_S = 1e-3


def test_a_recorder_of_tables_does_not_run_with_the_steps_of_a_drive(tmp_path: Path) -> None:
    """A step of a table was made at any instant since the row before, as its reach time is uncertain by."""
    rows = np.arange(600)
    answer = 1.0 - np.exp(-np.maximum(rows - 99.6, 0.0) / 40.0)
    path = tmp_path / "step.csv"
    columns = [rows * PERIOD_S, answer, np.where(rows >= 100, 1.0, 0.0)]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="t [s],T [Nm],ref [Nm]", comments="")
    question = TableQuestion(path, "t", {}, analyses={"step": {"signal": "T", "reference": "ref"}})
    found = {each.name: each for each in analyze_table(question).measurements}
    reach = found["reach_time"]
    assert reach.uncertainty is not None
    assert reach.uncertainty.standard == pytest.approx(PERIOD_S / 3.0, rel=0.1)
    assert abs(reach.value - 40.0 * np.log(50.0) * PERIOD_S) < reach.uncertainty.expanded


def test_a_unit_that_a_name_ends_in_is_the_longest_one(tmp_path: Path) -> None:
    """A speed in rad/s was taken for an angle, as rad stands in its name."""
    path = tmp_path / "speed.csv"
    rows = np.arange(600)
    reference = np.where(rows >= 100, 50.0, 0.0)
    columns = [rows * PERIOD_S, 50.0 * (1.0 - np.exp(-np.maximum(rows - 99.6, 0.0) / 40.0)), reference]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="time_s,n_rpm,ref_rad_s", comments="")
    question = TableQuestion(path, "time_s", {}, analyses={"step": {"signal": "n_rpm", "reference": "ref"}})
    assert analyze_table(question).source["columns"]["step reference"]["unit"] == "rad/s"
