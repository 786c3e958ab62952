"""`benchtool analyze --csv`: data from elsewhere, as a user hands it over."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner, Result

from benchtool.cli import app

Array = NDArray[np.float64]
Invoke = Callable[..., Result]
TURN = 2 * np.pi


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(app, ("analyze", *arguments))

    return run


def measured(result: Result) -> dict[str, Any]:
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["verdict"] == "none"
    assert list(document["cases"]) == ["csv"]
    case: dict[str, Any] = document["cases"]["csv"]
    assert set(case) == {"source", "measurements", "tables"}
    return case


def values(case: dict[str, Any]) -> dict[str, float | None]:
    return {name: each["value"] for name, each in case["measurements"].items()}


def write(name: str, head: str, columns: list[Array], delimiter: str = ",", digits: int = 7) -> None:
    rows = (delimiter.join(f"{value:.{digits}f}" for value in row) for row in zip(*columns, strict=True))
    Path(name).write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


def gimbal(name: str = "gimbal.txt", *, order: int = 72) -> None:
    """A q-current that holds a small motor against its cogging, at stamps that jitter, angle in counts."""
    random = np.random.default_rng(1)
    steps = np.round(1e-3 + 4e-4 * random.standard_t(2, size=12_000).clip(-2, 5), 4)
    time_s = np.cumsum(steps)
    angle = 5.2 * time_s + 0.05 * np.sin(6 * 5.2 * time_s) - 6.3
    current = 0.1 + 0.2 * np.cos(order * angle) + 0.04 * np.sin(18 * angle) + 0.015 * np.cos(12 * angle)
    current += 0.03 * random.normal(size=len(angle))
    counts = np.round(angle / TURN * 20_000) * TURN / 20_000
    write(
        name,
        "Time, Position, Velocity, Iq, Active",
        [time_s, counts, 0 * time_s, current, 0 * time_s + 1],
        ", ",
        5,
    )


def phase_current(rate_Hz: float = 10_000.0, samples: int = 4_000) -> tuple[Array, Array]:
    time_s = np.arange(samples) / rate_Hz
    angle = TURN * 50.0 * time_s
    return time_s, 3.0 * np.cos(angle) + 0.15 * np.cos(5 * angle + 1.0) + 0.02


def test_orders_of_a_q_current_at_jittered_stamps(invoke: Invoke) -> None:
    gimbal()

    case = measured(
        invoke("--csv", "gimbal.txt", "--time", "Time", "--current", "Iq", "--angle", "Position", "--json")
    )

    found = values(case)
    assert found["current_order_largest"] == 72
    truth = {"current_order_72": 0.2, "current_order_18": 0.04, "current_order_12": 0.015}
    for name, amplitude in truth.items():
        entry = case["measurements"][name]
        assert entry["value"] == pytest.approx(amplitude, abs=4 * entry["uncertainty"]["standard"])
        assert 1e-4 < entry["uncertainty"]["standard"] < 1e-3
        assert entry["unit"] == "A"
    listed = [name for name in found if name.startswith("current_order_")]
    assert listed[:4] == ["current_order_largest", *truth]
    assert len(case["tables"]["current_orders"]["rows"]) == 200

    for name in ("fundamental_frequency", "current_fundamental", "current_thd"):
        assert found[name] is None
        assert "undefined here: the time stamps are not even" in case["measurements"][name]["definition"]
    assert found["current_mean"] == pytest.approx(0.1, abs=0.01)
    assert "sample_rate_Hz" not in case["measurements"]["current_mean"]["basis"]
    source = case["source"]
    assert source["columns"]["current"] == {"number": 4, "name": "Iq", "unit": "A", "unit_from": "assumed"}
    assert (source["head_lines"], source["delimiter"], source["rows_used"]) == (1, ",", 12_000)
    assert not source["time"]["uniform"]
    assert source["time"]["rate_Hz"] is None


def test_what_an_order_is_stands_in_its_definition(invoke: Invoke) -> None:
    gimbal()
    arguments = ("--csv", "gimbal.txt", "--time", "1", "--current", "4", "--angle", "2", "--pole-pairs", "12")
    case = measured(invoke(*arguments, "--slots", "18", "--json"))
    definition = case["measurements"]["current_order_72"]["definition"]
    assert "6p, phase harmonics 5 and 7; cogging, lcm of 18 slots and 24 poles" in definition


def test_a_phase_current_of_an_oscilloscope(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("scope.csv", "x-axis,4\nsecond,Ampere", [time_s - 0.2, current])

    case = measured(invoke("--csv", "scope.csv", "--time", "x-axis", "--current", "4", "--json"))

    found = values(case)
    assert found["fundamental_frequency"] == pytest.approx(50.0, rel=1e-6)
    assert found["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert found["current_thd"] == pytest.approx(5.0, rel=1e-3)
    assert "current_ripple_pp" not in found
    assert case["source"]["time"]["rate_Hz"] == pytest.approx(10e3)
    assert case["source"]["columns"]["current"]["unit_from"] == "head"


def test_stamps_of_a_millisecond_are_no_hindrance_at_10_kHz(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("coarse.csv", "t [ms];I [mA]", [np.floor(time_s * 1e3 + 1e-9), current * 1e3], ";")

    case = measured(invoke("--csv", "coarse.csv", "--time", "t", "--current", "I", "--json"))

    assert values(case)["fundamental_frequency"] == pytest.approx(50.0, rel=1e-5)
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert case["source"]["time"]["jitter_s"] == pytest.approx(1e-3 / np.sqrt(12), rel=0.05)


@pytest.mark.parametrize(
    ("mean", "name", "reason"),
    [
        (2.0, "I", "its mean is 2.02 A and its fundamental 3 A peak"),
        (0.0, "Iq", "'Iq' is by its name a current in rotating coordinates"),
        (0.0, "i_d", "'i_d' is by its name"),
    ],
)
def test_a_current_in_rotating_coordinates_has_ripple_and_no_thd(
    invoke: Invoke, mean: float, name: str, reason: str
) -> None:
    time_s, current = phase_current()
    write("q.csv", f"t,{name}", [time_s, current + mean])

    case = measured(invoke("--csv", "q.csv", "--time", "t", "--current", name, "--json"))

    assert values(case)["current_thd"] is None
    assert f"undefined here: {reason}" in case["measurements"]["current_thd"]["definition"]
    assert values(case)["current_ripple_pp"] == pytest.approx(np.ptp(current), rel=1e-6)


def test_noise_is_no_phase_current(invoke: Invoke) -> None:
    time_s, _ = phase_current()
    write("noise.csv", "t,I", [time_s, np.random.default_rng(2).normal(size=len(time_s))])
    case = measured(invoke("--csv", "noise.csv", "--time", "t", "--current", "I", "--json"))
    assert "no sinusoid stands out" in case["measurements"]["current_thd"]["definition"]


def test_a_lost_row_is_a_gap_and_nothing_is_filled_in(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("gap.csv", "t,I", [time_s, current])
    lines = Path("gap.csv").read_text(encoding="utf-8").splitlines()
    lines[1001] = lines[1001].split(",")[0] + ",OL"
    lines[2001] += ",9"
    Path("gap.csv").write_text("\n".join(lines), encoding="utf-8")

    case = measured(invoke("--csv", "gap.csv", "--time", "t", "--current", "I", "--json"))

    assert case["source"]["rows_dropped"] == {"wrong number of cells": 1, "a cell is no number": 1}
    assert (case["source"]["rows_read"], case["source"]["rows_used"]) == (4_000, 3_998)
    assert (case["source"]["time"]["gaps"], case["source"]["time"]["rows_missing"]) == (2, 2)
    definition = case["measurements"]["current_thd"]["definition"]
    assert "undefined here: 2 rows are missing in 2 gaps, the first before row 1001" in definition
    assert case["measurements"]["current_ripple_pp"]["basis"]["gaps"] == 2
    assert values(case)["current_ripple_rms"] == pytest.approx(np.std(current), rel=1e-3)


def test_torque_against_angle_in_steady_state(invoke: Invoke) -> None:
    time_s = np.arange(20_000) / 5_000
    angle = TURN * 2.5 * time_s
    torque = 0.5 + 0.05 * np.cos(24 * angle)
    columns = [time_s, np.mod(np.degrees(angle), 360.0), torque * 1e3, np.full(20_000, 150.0) + np.sin(angle)]
    write("torque.csv", "t\tangle\tT\tn", columns, "\t")
    arguments = ("--time", "t", "--torque", "T:mNm", "--angle", "angle:deg", "--speed", "n:rpm", "--json")

    case = measured(invoke("--csv", "torque.csv", *arguments, "--pole-pairs", "4", "--rated-torque", "2"))

    found = values(case)
    assert found["torque_mean"] == pytest.approx(0.5, rel=1e-4)
    assert found["torque_ripple_pp"] == pytest.approx(0.1, rel=1e-3)
    assert found["torque_ripple_percent_of_rated"] == pytest.approx(5.0, rel=1e-3)
    assert found["torque_order_24"] == pytest.approx(0.05, rel=1e-4)
    assert "resampled to equal steps" in case["measurements"]["torque_order_24"]["definition"]
    assert case["measurements"]["torque_ripple_rms"]["uncertainty"]["standard"] >= 0.0
    assert found["speed_mean"] == pytest.approx(150 * np.pi / 30, rel=1e-4)


def test_the_same_torque_at_shuffled_stamps_keeps_what_needs_no_time(invoke: Invoke) -> None:
    time_s = np.arange(20_000) / 5_000
    angle = TURN * 2.5 * time_s
    torque = 0.5 + 0.05 * np.cos(24 * angle)
    write("joined.csv", "t,a,T", [np.tile(time_s[:10_000], 2), angle, torque])

    case = measured(
        invoke(
            "--csv",
            "joined.csv",
            "--time",
            "t",
            "--torque",
            "T",
            "--angle",
            "a",
            "--rated-torque",
            "2",
            "--json",
        )
    )

    assert "goes back once" in case["source"]["time"]["why_not"]
    assert values(case)["torque_ripple_percent_of_rated"] == pytest.approx(5.0, rel=1e-3)
    assert values(case)["torque_order_24"] == pytest.approx(0.05, rel=1e-6)


def test_an_angle_that_does_not_turn_leaves_orders_undefined(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("still.csv", "t,I,a", [time_s, current, 0.1 * time_s])
    case = measured(invoke("--csv", "still.csv", "--time", "t", "--current", "I", "--angle", "a", "--json"))
    assert values(case)["current_order_largest"] is None
    assert "mechanical revolutions" in case["measurements"]["current_order_largest"]["definition"]
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)


def test_a_span_of_the_files_own_time(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("scope.csv", "t,I", [time_s - 0.2, np.where(time_s < 0.1, 10.0, current)])
    arguments = (
        "--csv",
        "scope.csv",
        "--time",
        "t",
        "--current",
        "I",
        "--from",
        "-0.1",
        "--to",
        "0.15",
        "--json",
    )
    case = measured(invoke(*arguments))
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert case["source"]["rows_used"] == 2_501


def test_for_people(invoke: Invoke) -> None:
    gimbal()
    result = invoke("--csv", "gimbal.txt", "--time", "Time", "--current", "Iq", "--angle", "Position")
    assert result.exit_code == 0, result.output
    text = " ".join(result.stdout.split())
    assert "current_order_72" in text
    assert "undefined: fundamental_frequency, current_fundamental, current_thd: the time" in text
    assert "12000 rows, 12000 used; time from column 1 'Time' in s (assumed)" in text


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        ((), 2, "neither RUN nor --csv FILE"),
        (("run", "--csv", "a.csv", "--time", "t", "--current", "I"), 2, "both run and --csv a.csv"),
        (("run", "--time", "t"), 2, "columns and motor go with --csv"),
        (("--csv", "a.csv"), 2, "--csv without --time"),
        (("--csv", "a.csv", "--time", "t"), 2, "--csv without --current, --torque and --speed"),
        (("--csv", "a.csv", "--time", "t", "--angle", "t"), 2, "--csv without --current"),
        (
            ("--csv", "a.csv", "--time", "t", "--torque", "I", "--rated-torque", "-1"),
            2,
            "--rated-torque is -1",
        ),
        (("--csv", "no.csv", "--time", "t", "--current", "I"), 3, "cannot read no.csv: No such file"),
        (("--csv", "a.csv", "--time", "t", "--current", "x"), 2, "no column 'x', it has 1 't', 2 'I'"),
        (("--csv", "a.csv", "--time", "t", "--current", "I:rpm"), 2, "'rpm' is no unit of column 'I'"),
        (
            ("--csv", "a.csv", "--time", "t", "--current", "I", "--from", "9"),
            2,
            "no row of a.csv is from 9 s",
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


def test_the_help_says_how_columns_are_named(invoke: Invoke) -> None:
    text = " ".join(invoke("--help").stdout.split())
    assert "counted from 1" in text
    assert "--current Iq:mA" in text
