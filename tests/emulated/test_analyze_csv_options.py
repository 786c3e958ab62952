"""What options of `analyze --csv` are refused with, and what the bundle keeps of a test."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.recording import Bundle
from benchtool.results import verify_run
from tests.emulated.analyze_csv import Invoke, analyze, measured
from tests.emulated.csv_tables import Array, phase_current, write


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


def _step() -> None:
    """Write a lag of 10 ms that is driven by a step at 0.1 s, with the reference in two columns."""
    time_s: Array = np.arange(4_000) / 10e3
    since_s: Array = np.clip(time_s - 0.1, 0.0, None)
    noise = 2e-3 * np.random.default_rng(3).standard_normal(4_000)
    answer: Array = 1.0 - np.exp(-since_s / 0.01) + noise
    driven: Array = np.where(since_s > 0.0, 1.0, 0.0)
    write("step.csv", "t [s],T [Nm],ref [mNm],bare", [time_s, answer, 1e3 * driven, driven])


@pytest.mark.parametrize("reference", ["ref", "3", "4:Nm", "bare"])
def test_a_table_has_a_step_response_of_the_columns_that_are_named(invoke: Invoke, reference: str) -> None:
    """A lag of 10 ms rises from 10 % to 90 % in ln 9 of it, whatever the reference is stated in."""
    _step()
    asked = ("--analysis", f"step:signal=T,reference={reference}")
    case = measured(invoke("--csv", "step.csv", "--time", "t", *asked, "--out", "kept", "--json"))
    rise = case["measurements"]["rise_time"]
    assert abs(rise["value"] - 0.01 * np.log(9.0)) < 1.5 * rise["uncertainty"]["expanded"]
    assert case["measurements"]["overshoot"]["unit"] == "Nm"
    assert case["remarks"] == []
    found = verify_run(Path("kept"))
    assert found.holds
    assert found.recomputed > 10


def test_a_column_of_a_step_is_in_the_unit_that_another_option_states(invoke: Invoke) -> None:
    """The step asked for the unit that `--torque` had, and a signal that rests before it stood still."""
    _step()
    asked = ("--torque", "bare:mNm", "--analysis", "step:signal=bare,reference=bare", "--json")
    case = measured(invoke("--csv", "step.csv", "--time", "t", *asked))
    assert case["source"]["columns"]["torque"]["unit"] == "mNm"
    assert "step_latency" in case["measurements"]
    assert case["remarks"] == []


def test_the_sensor_of_a_step_is_in_its_numbers(invoke: Invoke) -> None:
    _step()
    Path("bench.toml").write_text("[bench.channels.T]\ngain_U_percent = 4.0\n", encoding="utf-8")
    asked = ("--analysis", "step:signal=T,reference=ref", "--bench", "bench.toml", "--json")
    plateau = measured(invoke("--csv", "step.csv", "--time", "t", *asked))["measurements"]["plateau_mean"]
    assert plateau["uncertainty"]["standard"] == pytest.approx(0.02, rel=0.05)


def test_a_table_has_a_frequency_response_of_its_columns(invoke: Invoke) -> None:
    """A lag of 100 Hz, driven by a sweep from 1 Hz to 1 kHz."""
    time_s = np.arange(40_000) / 10e3
    sweep = np.cos(2.0 * np.pi * (time_s + 0.125 * 999.0 * time_s**2))
    kept = np.exp(-2.0 * np.pi * 100.0 / 10e3)
    answer = np.empty_like(sweep)
    last = 0.0
    for row, value in enumerate(sweep):
        answer[row] = last = kept * last + (1.0 - kept) * value
    write("sweep.csv", "t [s],u [A],y [mA]", [time_s, sweep, 1e3 * answer])
    asked = ("--analysis", "frequency_response:input=u,output=y", "--json")
    case = measured(invoke("--csv", "sweep.csv", "--time", "t", *asked))
    assert case["measurements"]["response_gain"]["value"] == pytest.approx(1.0, rel=0.02)
    assert case["measurements"]["bandwidth_3dB"]["value"] == pytest.approx(100.0, rel=0.02)
    assert "frequency_response" in case["tables"]


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("step:signal=T,reference=nope", "no column 'nope'"),
        ("step:signl=T", "unknown key 'signl': did you mean 'signal'?"),
        ("step:signal=bare,reference=bare", "no unit of 'bare' is stated"),
        (
            "flux_balance",
            "--analysis 'flux_balance' is none of a table: the names are step, frequency_response",
        ),
        ("step=false", "it is made where it is asked for alone"),
    ],
)
def test_an_analysis_that_a_table_does_not_allow_is_refused(invoke: Invoke, asked: str, message: str) -> None:
    _step()
    result = invoke("--csv", "step.csv", "--time", "t", "--analysis", asked)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_step_in_rows_with_a_gap_has_a_reason(invoke: Invoke) -> None:
    _step()
    lines = Path("step.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    Path("step.csv").write_text("".join(lines[:1990] + lines[1993:]), encoding="utf-8")
    asked = ("--torque", "T", "--analysis", "step:signal=T,reference=ref", "--json")
    case = measured(invoke("--csv", "step.csv", "--time", "t", *asked))
    assert case["measurements"]["rise_time"]["value"] is None
    assert "'ref [mNm]' holds 1 over" in case["measurements"]["rise_time"]["reason"]
    (remark,) = case["remarks"]
    assert remark["text"].startswith("3 rows are missing in 1 place: measured is the longest stretch")


@pytest.mark.parametrize("taken", ["kept", "x.csv"])
def test_a_place_that_is_taken_is_refused_before_anything_is_measured(invoke: Invoke, taken: str) -> None:
    """The whole table was printed before."""
    Path("kept").mkdir()
    (Path("kept") / "thesis.txt").touch()
    refused = invoke(*TABLE, "--current", "Id", "--ac", "--out", taken)
    assert (refused.exit_code, refused.stdout) == (3, "")
    assert {"kept": "kept has content", "x.csv": "cannot write x.csv: it is a file"}[taken] in refused.stderr


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        ((), 2, "neither RUN nor --csv FILE"),
        (("run", "--csv", "a.csv", "--time", "t", "--current", "I"), 2, "both run and --csv a.csv"),
        (("run", "--time", "t"), 2, "columns and motor go with --csv"),
        (("a.csv", "--time", "t"), 2, "a.csv is a table of numbers"),
        (("--csv", "a.csv"), 2, "or state --rate in Hz (it has 1 't', 2 'I')"),
        (("--csv", "no.csv"), 2, "--csv without --time"),
        (("--csv", "a.csv", "--time", "t"), 2, "current, torque or speed (it has 1 't', 2 'I')"),
        (("--csv", "a.csv", "--time", "t", "--angle", "t"), 2, "--csv without --current"),
        (
            ("--csv", "a.csv", "--time", "t", "--torque", "I", "--rated-torque", "-1"),
            2,
            "--rated-torque is -1",
        ),
        (("--csv", "no.csv", "--time", "t", "--current", "I"), 2, "cannot read no.csv: No such file"),
        (("--csv", "a.csv", "--time", "t", "--current", "x"), 2, "no column 'x', it has 1 't', 2 'I'"),
        (("--csv", "a.csv", "--time", "t", "--current", "I:rpm"), 2, "'rpm' is no unit of column 'I'"),
        (
            ("--csv", "a.csv", "--time", "t", "--current", "I", "--from", "9"),
            2,
            "no row of a.csv is from 9 s",
        ),
        (
            ("--csv", "a.csv", "--time", "t", "--current", "I", "--from", "0.5", "--to", "0.2"),
            2,
            "--from 0.5 is after --to 0.2",
        ),
        (("--csv", "a.csv", "--time", "t", "--current", "I", "--pole-pairs", "4"), 2, "without --angle"),
        (("--csv", "a.csv", "--time", "t", "--current", "I", "--slots", "6"), 2, "--slots without --angle"),
        (("--csv", "a.csv", "--time", "t", "--current", "I", "--rated-torque", "4"), 2, "without --torque"),
        (
            ("--csv", "a.csv", "--time", "t", "--current", "I", "--torque", "2"),
            2,
            "column 2 of a.csv is asked for as current and torque",
        ),
        (
            ("--csv", "a.csv", "--time", "t", "--current", "I", "--current", "t"),
            2,
            "three times, for phases a, b and c; where two were recorded of a motor without a neutral",
        ),
    ],
)
def test_mistakes(invoke: Invoke, arguments: tuple[str, ...], code: int, complaint: str) -> None:
    write("a.csv", "t,I", list(phase_current()))
    result = invoke(*arguments, "--json")
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("benchtool: ")
    assert complaint in line


def test_a_date_in_place_of_seconds_is_named(invoke: Invoke) -> None:
    Path("iso.csv").write_text("t,I,T\n" + "21.11.26 12:00:00,1,2\n" * 9, encoding="utf-8")
    result = invoke("--csv", "iso.csv", "--time", "t", "--current", "I")
    assert result.exit_code == 2
    assert "the first '21.11.26 12:00:00' in column 1: check the columns; times in seconds" in result.stderr


def test_the_help_says_how_columns_are_named(invoke: Invoke) -> None:
    text = " ".join(invoke("--help").stdout.split())
    assert "counted from 1" in text
    assert "--current Iq:mA" in text
