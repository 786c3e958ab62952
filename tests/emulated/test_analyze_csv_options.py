"""What options of `analyze --csv` are refused with, and what the bundle keeps of a test."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.recording import Bundle
from benchtool.results import verify_run
from tests.emulated.analyze_csv import Invoke, analyze, measured
from tests.emulated.csv_tables import phase_current, write


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    time_s, current = phase_current()
    current = current + 1e-3 * np.random.default_rng(0).standard_normal(len(current))
    write("x.csv", "t [s],Id [A],T [%],n [rpm]", [time_s, current, 50.0 + current, 300.0 + current])
    return analyze


TABLE = ("--csv", "x.csv", "--time", "t")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--current", "Id*2"), "no column 'Id*2'"),
        (("--current", "Id*2"), "gain and offset follow a unit, as 'Id:A*2'"),
        (("--current", "2 - 0.1"), "gain and offset follow a unit, as '2:A- 0.1'"),
        (("--torque", "T"), "of percent state what 100 % is, as --rated-torque 2"),
        (("--torque", "T:Nm", "--speed", "n", "--pole-pairs", "4"), "a stated speed (--speed 1500rpm)"),
        (("--torque", "T:Nm", "--ac"), "--ac without --current"),
        (("--current", "Id", "--note", "x"), "a note or conditions without --out or --report"),
    ],
)
def test_a_refusal_says_how_it_is_written(invoke: Invoke, options: tuple[str, ...], message: str) -> None:
    result = invoke(*TABLE, *options)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_phase_current_may_be_called_as_one_in_rotating_coordinates(invoke: Invoke) -> None:
    """Its name alone is why it has no fundamental; three currents are those of phases anyway."""
    refused = measured(invoke(*TABLE, "--current", "Id", "--json"))["measurements"]["current_fundamental"]
    assert refused["reason"].endswith("if it is that of a phase all the same, state --ac")
    stated = ("--current", "Id", "--ac", "--out", "kept", "--json")
    assert measured(invoke(*TABLE, *stated))["measurements"]["current_fundamental"]["value"] == pytest.approx(
        3.0, rel=1e-3
    )
    assert verify_run(Path("kept")).holds


def test_the_bundle_of_a_table_keeps_note_and_conditions(invoke: Invoke) -> None:
    stated = ("--note", "cold", "--operator", "Ann", "--serial-number", "M1", "--temperature", "21.5")
    beside = ("--instrument", "scope 7", "--instrument", "probe 3")
    result = invoke(*TABLE, "--current", "Id", *stated, *beside, "--out", "kept", "--report")
    assert result.exit_code == 0, result.output
    manifest = Bundle.open(Path("kept")).manifest
    conditions = manifest.conditions
    assert (manifest.note, conditions.operator, conditions.test_object_serial_number) == ("cold", "Ann", "M1")
    assert conditions.temperature_degC == 21.5
    assert conditions.instruments == ("scope 7", "probe 3")
    page = Path("kept/report.html").read_text(encoding="utf-8")
    assert all(text in page for text in ("cold", "Ann", "M1", "scope 7"))
