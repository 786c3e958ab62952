"""A table of another tool as a block: the catalogue measures it as it measures a capture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import analyze_steady_state
from benchtool.errors import AnalysisError
from benchtool.profile import load_profile
from benchtool.results.block_result import analyze
from benchtool.tables import TableQuestion, analyze_table, table_block

COLUMNS = {"torque": "T", "current": "I", "angle": "phi"}


def _written(path: Path, *, skipped: int = 0, jitter_s: float = 0.0) -> TableQuestion:
    rng = np.random.default_rng(3)
    time_s = np.arange(5000) / 10e3 + jitter_s * rng.normal(size=5000)
    theta_m = 20.0 * np.arange(5000) / 10e3
    columns = [
        time_s,
        0.65 + 0.05 * np.sin(24.0 * theta_m) + 0.01 * rng.normal(size=5000),
        np.cos(4.0 * theta_m) + 0.02 * np.cos(20.0 * theta_m) + 1e-3 * rng.normal(size=5000),
        np.mod(theta_m, 2.0 * math.pi),
    ]
    rows = np.delete(np.column_stack(columns), np.s_[2000 : 2000 + skipped], axis=0)
    np.savetxt(path, rows, delimiter=",", header="t,T,I,phi", comments="", fmt="%.9g")
    return TableQuestion(path, "t", COLUMNS, pole_pairs=4, torque_rated_Nm=9.55)


def test_the_catalogue_gives_the_numbers_of_the_table(tmp_path: Path) -> None:
    question = _written(tmp_path / "scope.csv")
    block = table_block(question)
    assert set(block.names) == {"torque", "i_a", "theta_m"}
    table = {each.name: each for each in analyze_table(question).measurements}
    result = analyze(block, load_profile("zhu2011"))
    same = [
        each.name
        for each in result
        if each.name in table and math.isfinite(each.value) and math.isfinite(table[each.name].value)
    ]
    assert {"torque_mean", "fundamental_frequency", "current_thd_f"} <= set(same)
    for name in same:
        assert result[name].value == pytest.approx(table[name].value, rel=1e-9), name


@pytest.mark.parametrize("swing_rad", [0.0, 0.02])
def test_what_a_revolution_repeats_is_in_a_table_what_it_is_in_a_run(
    tmp_path: Path, swing_rad: float
) -> None:
    """Orders below the pole pairs are no scatter of the periods, in either, and these begin where the rotor
    is."""
    time_s = np.arange(900) / 1e3
    theta_m = 21.0 * time_s + swing_rad * np.sin(2.0 * math.pi * 2.3 * time_s)
    torque = 0.65 + 0.05 * np.sin(theta_m) + 1e-3 * np.random.default_rng(2).normal(size=900)
    columns = [time_s, torque, np.cos(4.0 * theta_m), np.mod(theta_m, 2.0 * math.pi)]
    path = tmp_path / "eccentric.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="t,T,I,phi", comments="", fmt="%.9g")
    question = TableQuestion(path, "t", COLUMNS, pole_pairs=4, torque_rated_Nm=9.55)
    table = {each.name: each for each in analyze_table(question).measurements}
    run = analyze_steady_state(table_block(question), pole_pairs=4, torque_rated_Nm=9.55)
    for name in ("torque_mean", "torque_ripple_rms"):
        found, other = table[name].uncertainty, run[name].uncertainty
        assert found is not None
        assert other is not None
        assert table[name].value == pytest.approx(run[name].value, rel=1e-9)
        assert found.standard == pytest.approx(other.standard, rel=1e-6)


def test_missing_rows_are_gaps_and_uneven_ones_are_refused(tmp_path: Path) -> None:
    (gap,) = table_block(_written(tmp_path / "gap.csv", skipped=30)).gaps
    assert (gap.row, gap.missing_rows) == (2000, 30)
    with pytest.raises(AnalysisError, match="are not evenly spaced"):
        table_block(_written(tmp_path / "uneven.csv", jitter_s=3e-5))
