"""`benchtool analyze --csv`: missing information, oddities, and the bundle of a table."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchtool.recording import Bundle
from tests.emulated.analyze_csv import Invoke, analyze, measured, values
from tests.emulated.csv_tables import TURN, sinusoid, write


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return analyze


def test_a_stated_rate_and_speed_stand_in_for_time_and_angle(invoke: Invoke) -> None:
    time_s = np.arange(10_000) / 5_000.0
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(time_s))
    write("t.csv", "T [%],x", [50.0 + 5.0 * np.cos(TURN * 12.5 * 24 * time_s) + noise, time_s])
    stated = ("--torque", "1", "--rate", "5000", "--rated-torque", "2", "--speed", "750rpm")
    case = measured(invoke("--csv", "t.csv", *stated, "--pole-pairs", "4", "--json"))
    assert values(case)["torque_mean"] == pytest.approx(1.0, rel=1e-4)
    assert values(case)["torque_order_24"] == pytest.approx(0.1, rel=1e-3)
    assert case["source"]["time"]["rate_Hz"] == pytest.approx(5_000.0)
    in_units = ("--torque", "1", "--rate", "5 kSa/s", "--rated-torque", "2000mNm", "--speed", "750rpm")
    assert values(measured(invoke("--csv", "t.csv", *in_units, "--pole-pairs", "4", "--json"))) == values(
        case
    )
    case = measured(invoke("--csv", "t.csv", *stated[:-2], "--json"))
    assert values(case)["torque_line_frequency"] == pytest.approx(300.0, abs=0.01)


@pytest.mark.parametrize(("option", "text"), [("--rate", "5k"), ("--rate", "1ms"), ("--rated-torque", "2A")])
def test_a_number_with_another_unit_is_told_what_is_expected(invoke: Invoke, option: str, text: str) -> None:
    write("t.csv", "T", [np.arange(100.0)])
    result = invoke("--csv", "t.csv", "--torque", "1", option, text)
    assert result.exit_code == 2
    assert f"'{text}' is no number of" in result.output


def test_tables_below_each_other_are_a_warning(invoke: Invoke) -> None:
    torque = [f"{1.0 + 0.1 * value:.4f}" for value in np.random.default_rng(2).standard_normal(200)]
    Path("two.csv").write_text("\n".join(["T_Nm", *torque, "T_Nm", *torque]), encoding="utf-8")
    result = invoke("--csv", "two.csv", "--torque", "T_Nm", "--rate", "1kHz")
    assert result.exit_code == 0
    assert "1 line of names is between the rows, the first 'T_Nm' at line 202" in " ".join(
        result.output.split()
    )


def test_lines_of_a_serial_plotter_are_a_table(invoke: Invoke) -> None:
    time_ms = np.arange(400)
    current = 3.0 * np.cos(TURN * 50e-3 * time_ms)
    rows = [f"t:{time}\tIq_mA:{1e3 * each:.1f}" for time, each in zip(time_ms, current, strict=True)]
    Path("serial.log").write_text("\n".join(rows), encoding="utf-8")
    case = measured(invoke("--csv", "serial.log", "--time", "t:ms", "--current", "Iq_mA", "--json"))
    assert case["source"]["columns"]["current"]["unit"] == "mA"
    assert case["source"]["rows_used"] == 400


def test_oddities_are_remarks_and_a_bundle_and_a_report_are_kept(invoke: Invoke) -> None:
    random = np.random.default_rng(1)
    time_s = np.asarray(np.arange(8_000) * 1e-3, dtype=np.float64)
    torque = np.where(time_s < 3.0, 0.14, 0.31) + 0.01 * random.standard_normal(8_000)
    torque[1::3] = torque[:-1:3]
    speed = np.clip(np.cos(TURN * 3.0 * time_s) + 1e-4 * random.standard_normal(8_000), -2.0, 0.8)
    speed[1::3] = speed[:-1:3]
    write("odd.csv", "t,T,n", [time_s, torque, speed])
    result = invoke(
        *(
            "--csv",
            "odd.csv",
            "--time",
            "t",
            "--torque",
            "T",
            "--speed",
            "n",
            "--out",
            "kept",
            "--report",
            "--json",
        )
    )
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    found = {(each["kind"], each["column"]): each["text"] for each in document["cases"]["csv"]["remarks"]}
    assert set(found) == {
        ("repeated_rows", ""),
        ("two_regimes", "torque"),
        ("clipped", "speed"),
        ("unit_assumed", "time"),
        ("unit_assumed", "speed"),
    }
    assert "average 0.14 Nm, 63 % at 0.31 Nm" in found["two_regimes", "torque"]
    bundle = Bundle.open(Path("kept"))
    assert bundle.complete
    np.testing.assert_allclose(bundle.block("table").column("T"), torque, rtol=1e-6)
    page = Path("kept/report.html").read_text(encoding="utf-8")
    assert "two regimes" in page
    assert "torque_ripple_pp" in page


@pytest.mark.parametrize(
    ("kind", "reason"),
    [
        ("turns back", "'angle [deg]' turns back by 10 electrical periods within the window"),
        (
            "dc",
            "'ia [mA]' has a mean of 0.232 A and a ripple of 0.0848 A rms: a direct current in 2",
        ),
        (
            "clicks",
            "3 samples are far from their neighbours, the first, 50 A, in row 100 (from 0): clicks, at",
        ),
        ("held", "'ia [mA]' is constant at 2.5 A over 10000 samples"),
    ],
)
def test_reasons_name_the_column_the_unit_and_the_cause(invoke: Invoke, kind: str, reason: str) -> None:
    time_s, current, angle = sinusoid(20.0)
    current = current + 1e-3 * np.random.default_rng(3).standard_normal(len(current))
    if kind == "turns back":
        angle = np.minimum(angle, 2.0 * angle[5000] - angle)
    elif kind == "dc":
        current = np.where(time_s < 0.46, 0.14, 0.31) + 0.01 * (current - np.round(current))
    elif kind == "clicks":
        current[[100, 2000, 7000]] = 50.0
    else:
        current[:] = 2.5
    write("x.csv", "t [s],ia [mA],angle [deg]", [time_s, 1e3 * current, np.degrees(angle)])
    turning = ("--angle", "angle", "--pole-pairs", "4") if kind == "turns back" else ()
    found = measured(invoke("--csv", "x.csv", "--time", "t", "--current", "ia", *turning, "--json"))
    told = found["measurements"]["current_fundamental"]
    assert told["value"] is None
    assert told["reason"].startswith(reason)


def test_a_drift_and_a_swing_are_no_regimes(invoke: Invoke) -> None:
    time_s = np.asarray(np.arange(8_000) * 1e-3, dtype=np.float64)
    for torque in (1.0 + time_s, np.sin(TURN * 0.2 * time_s) + 2.0):
        write("t.csv", "t,T", [np.asarray(time_s, np.float64), np.asarray(torque, np.float64)])
        assert measured(invoke("--csv", "t.csv", "--time", "t:s", "--torque", "T", "--json"))["remarks"] == []
