"""Tables of which a few rows are missing: numbers that need even rows are of the longest stretch of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.answer import TableAnswer
from benchtool.tables.remarks import RemarkKind

ROWS, STEP_S, FREQUENCY_HZ = 20_000, 1e-4, 50.03
TRUTH = {
    "fundamental_frequency": FREQUENCY_HZ,
    "current_fundamental": 3.0,
    "current_thd_f": 5.0,
    "torque_line_frequency": 6 * FREQUENCY_HZ,
    "torque_line_amplitude": 0.05,
}


def answer(folder: Path, missing: list[int], rows: int = ROWS) -> TableAnswer:
    rng = np.random.default_rng(7)
    time_s = STEP_S * np.arange(rows)
    angle = 2.0 * np.pi * FREQUENCY_HZ * time_s
    current = 3.0 * np.cos(angle) + 0.15 * np.cos(5.0 * angle) + 0.01 * rng.normal(size=rows)
    torque = 0.5 + 0.05 * np.cos(6.0 * angle) + 0.01 * rng.normal(size=rows)
    path = folder / "table.csv"
    kept = np.delete(np.column_stack((time_s, current, torque)), missing, axis=0)
    np.savetxt(path, kept, ["%.4f", "%.5f", "%.5f"], ",", header="t [s],i [A],T [Nm]", comments="")
    return analyze_table(TableQuestion(path, "t", {"current": "i", "torque": "T"}))


def by_name(found: TableAnswer) -> dict[str, Measurement]:
    return {each.name: each for each in found.measurements}


def text_of(found: TableAnswer) -> str:
    return next((each.text for each in found.remarks if each.kind == RemarkKind.ROWS_LEFT_OUT), "")


@pytest.mark.parametrize("missing", [[5_000, 9_000, 15_500], list(range(1_500, ROWS, 1_700))])
def test_true_values_are_within_the_uncertainty(tmp_path: Path, missing: list[int]) -> None:
    found = answer(tmp_path, missing)
    numbers = by_name(found)
    for name, truth in TRUTH.items():
        uncertainty = numbers[name].uncertainty
        assert uncertainty is not None
        assert abs(numbers[name].value - truth) <= uncertainty.expanded
        assert numbers[name].basis.gaps == 0
    assert f"{len(missing)} rows are missing in {len(missing)} places" in text_of(found)


def test_of_a_short_stretch_the_other_numbers_are_of_all_rows(tmp_path: Path) -> None:
    missing = list(range(1_500, ROWS, 1_700))
    found = answer(tmp_path, missing)
    mean = by_name(found)["torque_mean"]
    assert mean.basis.samples == ROWS - len(missing)
    assert mean.uncertainty is None
    assert "11 rows are missing in 11 gaps" in mean.uncertainty_reason
    assert text_of(found).endswith(
        "spectra are of the longest stretch without a gap, 0.1501 s to 0.3199 s, 1699 of 19989 rows; other "
        "numbers are of all"
    )


def test_a_stretch_that_is_too_short_for_a_spectrum_is_refused_with_both_reasons(tmp_path: Path) -> None:
    found = answer(tmp_path, list(range(100, 4_000, 190)), rows=4_000)
    reason = by_name(found)["current_fundamental"].reason
    assert reason.startswith("21 rows are missing in 21 gaps, the first before row 101; the longest stretch")
    assert "189 rows" in reason
