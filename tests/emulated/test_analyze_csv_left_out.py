"""`benchtool analyze --csv`: rows that are left out, and what they do to the numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.emulated.analyze_csv import Invoke, analyze, measured, values
from tests.emulated.csv_tables import TURN, Array

RIPPLE = ("torque_mean", "torque_ripple_pp", "torque_ripple_rms")


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return analyze


def torque() -> tuple[Array, Array, Array]:
    time_s = np.arange(4_000) / 5_000.0
    theta = TURN * 12.5 * time_s
    noise = 0.002 * np.random.default_rng(5).standard_normal(len(time_s))
    return time_s, np.asarray(1.2 + 0.1 * np.cos(12 * theta) + noise), theta


def case(invoke: Invoke, word: str, lost: NDArray[np.bool_], *options: str) -> dict[str, Any]:
    time_s, torque_Nm, theta = torque()
    cells = (word if gone else f"{each:.5f}" for each, gone in zip(torque_Nm, lost, strict=True))
    rows = (f"{t:.4f},{cell},{angle:.5f}" for t, cell, angle in zip(time_s, cells, theta, strict=True))
    Path("t.csv").write_text("t,T,a\n" + "\n".join(rows), encoding="utf-8")
    columns = ("--time", "t", "--torque", "T", "--angle", "a")
    return measured(invoke("--csv", "t.csv", *columns, "--json", *options))


def reasons(found: dict[str, Any]) -> set[str]:
    numbers = found["measurements"]
    return {numbers[name].get("reason", "") for name in RIPPLE}


@pytest.mark.parametrize("word", ["OVER", "∞", "9.9E+37", "Überlauf", "-OL"])
def test_cells_of_an_overload_are_clipping(invoke: Invoke, word: str) -> None:
    found = case(invoke, word, torque()[1] > 1.28)
    assert {values(found)[name] for name in RIPPLE} == {None}
    assert all("of its cells state an overload: the record is clipped" in text for text in reasons(found))


@pytest.mark.parametrize("word", ["--", "", "nan"])
def test_what_is_missing_beside_the_extremes_may_be_an_overload(invoke: Invoke, word: str) -> None:
    found = case(invoke, word, torque()[1] > 1.285)
    assert all("what is missing there may be an overload" in text for text in reasons(found))


def test_a_few_rows_between_others_take_the_uncertainty(invoke: Invoke) -> None:
    lost = np.random.default_rng(1).random(4_000) < 0.01
    found = case(invoke, "n/a", lost)
    assert values(found)["torque_mean"] == pytest.approx(1.2, abs=1e-3)
    numbers = found["measurements"]
    for name in RIPPLE:
        assert "uncertainty" not in numbers[name] or numbers[name]["uncertainty"] is None
        assert "rows in between that have no number" in numbers[name]["definition"]
    remarks = found["remarks"]
    remarks = [each for each in remarks if each["kind"] != "unit_assumed"]
    assert [each["kind"] for each in remarks] == ["rows_left_out"]
    assert (
        f"{np.count_nonzero(lost)} (a cell is no number), the first 'n/a' in column 2" in remarks[0]["text"]
    )


def test_many_rows_take_the_number(invoke: Invoke) -> None:
    found = case(invoke, "n/a", np.random.default_rng(1).random(4_000) < 0.2)
    assert all("the rest does not stand for all" in text for text in reasons(found))


def test_rows_at_the_ends_and_out_of_the_span_only_shorten_the_record(invoke: Invoke) -> None:
    row = np.arange(4_000)
    for lost, options in (((row < 5) | (row > 3_990), ()), (row == 500, ("--from", "0.12"))):
        found = case(invoke, "OVER", lost, *options)
        numbers = found["measurements"]
        assert numbers["torque_mean"]["uncertainty"]["expanded"] < 0.01


def test_a_minus_sign_is_one(invoke: Invoke) -> None:
    time_s = np.arange(4_000) / 5_000.0
    rows = (f"{t:.4f},{3.0 * np.cos(TURN * 50.0 * t):.5f}" for t in time_s)
    Path("i.csv").write_text("t,I\n" + "\n".join(rows).replace("-", "\u2212"), encoding="utf-8")
    found = measured(invoke("--csv", "i.csv", "--time", "t", "--current", "I", "--json"))
    assert values(found)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert found["source"]["rows_dropped"] == {}


def test_pole_pairs_hold_a_speed_column_against_the_current(invoke: Invoke) -> None:
    time_s = np.arange(4_000) / 5_000.0
    noise = np.random.default_rng(2).standard_normal(4_000)
    columns = (time_s, 3.0 * np.cos(TURN * 50.0 * time_s) + 1e-3 * noise, 750.0 + 0.1 * noise)
    rows = (",".join(f"{each:.6f}" for each in row) for row in zip(*columns, strict=True))
    Path("n.csv").write_text("t,I,n_rpm\n" + "\n".join(rows), encoding="utf-8")
    options = (
        "--csv",
        "n.csv",
        "--time",
        "t",
        "--current",
        "I",
        "--speed",
        "n_rpm",
        "--json",
        "--pole-pairs",
    )
    time, *others = measured(invoke(*options, "4"))["remarks"]
    assert "the unit of the time 't' is not stated" in time["text"]
    assert others == []
    time, *remarks = measured(invoke(*options, "3"))["remarks"]
    assert [each["kind"] for each in remarks] == ["other_frequency"]
    assert "is at 50 Hz, the mean of 'n_rpm' with 3 pole pairs says 37.5 Hz" in remarks[0]["text"]
