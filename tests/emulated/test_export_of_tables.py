"""The bundle of a table, exported and read again, gives the same numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.recording import Bundle
from tests.emulated.analyze_csv import analyze, measured
from tests.emulated.csv_tables import sinusoid, write


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _columns() -> list[np.ndarray[tuple[int], np.dtype[np.float64]]]:
    time_s, current, angle = sinusoid(50.0)
    random = np.random.default_rng(2)
    current = current + 1e-3 * random.standard_normal(len(current))
    torque = 1.0 + 0.1 * np.cos(24.0 * angle) + 1e-3 * random.standard_normal(len(current))
    return [1e3 * time_s, 1e3 * current, torque, np.degrees(angle)]


@pytest.mark.parametrize("missing", [(), (1200, 7000)])
def test_an_exported_table_is_read_back_to_the_same_numbers(missing: tuple[int, ...]) -> None:
    columns = [np.delete(each, missing) for each in _columns()]
    write("scope.csv", "t [ms],i_L1 [mA],T [Nm],theta [deg]", columns, digits=9)
    asked = ("--current", "i_L1", "--torque", "T", "--angle", "theta", "--pole-pairs", "4", "--json")
    first = measured(analyze("--csv", "scope.csv", "--time", "t", *asked, "--out", "kept"))
    assert CliRunner().invoke(app, ["export", "kept", "--out", "again.csv"]).exit_code == 0
    head = Path("again.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert head == "tick,time_s [s],i_L1 [A],T [Nm],theta [rad]"
    again = measured(analyze("--csv", "again.csv", "--time", "time_s", *asked))
    assert len(first["measurements"]) > 20
    assert {name: each["value"] for name, each in again["measurements"].items()} == {
        name: each["value"] for name, each in first["measurements"].items()
    }


@pytest.mark.parametrize(
    ("head", "name"),
    [
        ("Iq_mA", "Iq"),
        ("Iq/mA", "Iq"),
        ("Iq [mA]", "Iq"),
        ("Iq[0] [mA]", "Iq[0]"),
        ("Iq in mA", "Iq"),
        ("ripple", "ripple"),
        ("time_s", "time_s [A]"),
    ],
)
def test_channels_of_a_table_are_called_without_the_unit_of_the_file(head: str, name: str) -> None:
    """Its values are in SI; what would be called as a column that is computed keeps its name."""
    head, name = ("time_s [A]", name) if head == "time_s" else (head, name)
    time_ms, current, *_ = _columns()
    write("x.csv", f"t [ms],{head}", [time_ms[:500], current[:500]])
    assert analyze("--csv", "x.csv", "--time", "t", "--current", "2", "--out", "kept").exit_code == 0
    assert Bundle.open(Path("kept")).block("table").names == ("time_s", name)
