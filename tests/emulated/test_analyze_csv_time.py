"""`benchtool analyze --csv`: time stamps, rates, rows that are lost, and values that are held."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.emulated.analyze_csv import Invoke, analyze, measured, values
from tests.emulated.csv_tables import TURN, phase_current, write


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return analyze


def test_stamps_of_a_millisecond_are_no_hindrance_at_10_kHz(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("coarse.csv", "t [ms];I [mA]", [np.floor(time_s * 1e3 + 1e-9), current * 1e3], ";")

    case = measured(invoke("--csv", "coarse.csv", "--time", "t", "--current", "I", "--json"))

    assert values(case)["fundamental_frequency"] == pytest.approx(50.0, rel=1e-5)
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert case["source"]["time"]["jitter_s"] == pytest.approx(1e-3 / np.sqrt(12), rel=0.05)


def test_the_frequency_is_known_as_well_as_the_stamps_and_no_better(invoke: Invoke) -> None:
    time_s, current = phase_current()
    noisy = current + 1e-3 * np.random.default_rng(4).normal(size=len(current))
    # slopes off by up to a row over the record leave stamps of ten rows, the less the likelier
    for digits, (low, high) in {3: (0.95, 1.05), 4: (0.0, 0.01)}.items():
        write("stamps.csv", "t,I", [np.floor(time_s * 10**digits + 1e-6) / 10**digits, noisy])
        case = measured(invoke("--csv", "stamps.csv", "--time", "t", "--current", "I", "--json"))
        uncertainty = case["measurements"]["fundamental_frequency"]["uncertainty"]
        assert low < uncertainty["standard"] / (50.0 * 1e-4 / np.sqrt(6) / 0.4) < high
        assert "of the rate by the time stamps" in uncertainty["source"]


def test_a_row_lost_under_stamps_of_a_millisecond_is_seen(invoke: Invoke) -> None:
    time_s, current = phase_current()
    kept = np.delete(np.arange(4_000), 2_005)
    write("coarse.csv", "t,I", [np.floor(time_s[kept] * 1e3 + 1e-9) / 1e3, current[kept]])
    case = measured(invoke("--csv", "coarse.csv", "--time", "t", "--current", "I", "--json"))
    assert case["source"]["time"]["rows_missing"] == 1
    assert case["source"]["rows_used"] == 2_000, "it is under one of the stamps of 200.5 ms"
    assert "one row is missing: measured is the longest stretch" in case["remarks"][-1]["text"]
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-3)


def test_where_it_cannot_be_told_the_number_of_gaps_is_not_stated(invoke: Invoke) -> None:
    time_s, current = phase_current()
    kept = np.delete(np.arange(4_000), [1_005, 3_005])
    write("two.csv", "t,I,n", [np.floor(time_s[kept] * 1e3 + 1e-9) / 1e3, current[kept], 2 + current[kept]])
    case = measured(invoke("--csv", "two.csv", "--time", "t", "--current", "I", "--speed", "n", "--json"))
    assert case["source"]["time"]["gaps"] is None
    for name in ("current_fundamental", "current_thd_f", "speed_mean"):
        assert "gaps" not in case["measurements"][name]["basis"]
    assert "gaps" not in case["tables"]["current_harmonics"]["basis"]


def test_rows_written_twice_are_refused_as_a_time_base(invoke: Invoke) -> None:
    columns = [np.repeat(column, 2) for column in phase_current()]
    write("twice.csv", "t,I", columns)
    case = measured(invoke("--csv", "twice.csv", "--time", "t", "--current", "I", "--json"))
    assert (
        "4000 rows repeat both time and values of the row before, first row 2"
        in case["source"]["time"]["why_not"]
    )
    assert values(case)["current_fundamental"] is None


def test_held_samples_claim_no_more_than_they_are(invoke: Invoke) -> None:
    time_s, current = phase_current()
    held = np.repeat(current[::10], 10)
    write("held.csv", "t,I,T", [time_s, held, 2.0 + held])
    case = measured(invoke("--csv", "held.csv", "--time", "t", "--current", "I", "--torque", "T", "--json"))
    reason = "each value is held for 10 rows, the current was sampled at about 1000 Hz and not at 10000 Hz"
    assert reason in case["measurements"]["current_thd_f"]["reason"]
    ripple = case["measurements"]["torque_ripple_pp"]
    assert ripple["basis"]["bandwidth_Hz"] == pytest.approx(500.0)
    assert "each value held for 10 rows" in ripple["definition"]
    line = case["measurements"]["torque_line_amplitude"]
    assert line["value"] is None
    assert "the torque was sampled at about 1000 Hz" in line["reason"]
    of_orders = ("--torque", "T", "--speed", "1500 1/min")
    case = measured(invoke("--csv", "held.csv", "--time", "t", *of_orders, "--json"))
    assert reason.replace("current", "torque") in case["measurements"]["torque_order_largest"]["reason"]


def test_of_lost_rows_the_longest_stretch_is_measured_and_nothing_is_filled_in(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("gap.csv", "t,I", [time_s, current])
    lines = Path("gap.csv").read_text(encoding="utf-8").splitlines()
    lines[1001] = lines[1001].split(",")[0] + ",n/a"
    lines[2001] += ",9"
    Path("gap.csv").write_text("\n".join(lines), encoding="utf-8")

    case = measured(invoke("--csv", "gap.csv", "--time", "t", "--current", "I", "--json"))

    assert case["source"]["rows_dropped"] == {"wrong number of cells": 1, "a cell is no number": 1}
    assert (case["source"]["rows_read"], case["source"]["rows_used"]) == (4_000, 1_999)
    assert case["source"]["time"]["rows_of_span"] == 3_998
    assert (case["source"]["time"]["gaps"], case["source"]["time"]["rows_missing"]) == (2, 2)
    text = "2 rows are missing in 2 places: measured is the longest stretch without a gap"
    assert f"{text}, {time_s[2001]:.6g} s to {time_s[-1]:.6g} s, 1999 of 3998 rows" in [
        each["text"] for each in case["remarks"]
    ]
    assert case["measurements"]["current_fundamental"]["basis"]["gaps"] == 0
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-3)


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


def test_a_stated_rate_has_no_stamps_and_no_jitter(invoke: Invoke) -> None:
    _, current = phase_current()
    write("bare.csv", "i [A]", [current + 1e-3 * np.random.default_rng(0).standard_normal(len(current))])
    at_rate = ("--csv", "bare.csv", "--rate", "10kHz", "--current", "i")
    case = measured(invoke(*at_rate, "--json"))
    assert case["source"]["time"]["jitter_s"] is None
    frequency = case["measurements"]["fundamental_frequency"]
    assert "clock" not in frequency["uncertainty"]["source"]
    assert frequency["basis"]["sensors"] == "the tolerance of the record's clock is not stated"
    assert "time: even, at the stated 10000 Hz" in invoke(*at_rate).stdout
