"""A column that stands still while the others move, as where a logger lost a sensor for a while."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.answer import TableAnswer
from benchtool.tables.remarks import RemarkKind

RATE_HZ, ROWS, POLE_PAIRS = 2000.0, 1200, 4
LOST = slice(500, 700)
PHASES = ("current", "current_b", "current_c")


def answer(folder: Path, lost: str, *used: str, even: bool = True, rotor_rests: bool = False) -> TableAnswer:
    """Return what a table says of which one column stands still in some rows."""
    random = np.random.default_rng(7)
    steps = np.full(ROWS, 1.0) if even else random.uniform(0.5, 1.5, ROWS)
    time_s = np.cumsum(steps) / RATE_HZ
    speed = 100.0 + 0.5 * np.sin(2.0 * np.pi * 3.0 * time_s)
    if rotor_rests:
        speed *= np.clip(np.abs(np.arange(ROWS) - 600.0) / 100.0 - 1.0, 0.0, 1.0)
    theta = np.cumsum(speed * steps) / RATE_HZ
    columns = {
        "time": time_s,
        "angle": np.mod(theta, 2.0 * np.pi),
        "speed": speed + 0.1 * random.standard_normal(ROWS),
        "torque": 1.0 + 0.1 * np.cos(24.0 * theta) + 0.01 * random.standard_normal(ROWS),
    }
    for number, phase in enumerate(PHASES):
        noise = 0.02 * random.standard_normal(ROWS)
        columns[phase] = 5.0 * np.cos(POLE_PAIRS * theta - number * 2.0 * np.pi / 3.0) + noise
    if lost:
        columns[lost][LOST] = columns[lost][LOST.start]
    path = folder / "table.csv"
    header = ",".join(columns)
    np.savetxt(
        path, np.column_stack(list(columns.values())), delimiter=",", header=header, comments="", fmt="%.6f"
    )
    return analyze_table(TableQuestion(path, "time", {each: each for each in used}, pole_pairs=POLE_PAIRS))


def numbers(found: TableAnswer) -> dict[str, Measurement]:
    return {each.name: each for each in found.measurements}


def warned(found: TableAnswer) -> list[str]:
    return [each.column for each in found.remarks if each.kind is RemarkKind.STOOD_STILL]


@pytest.mark.parametrize("lost", ["current", "torque", "speed"])
def test_a_column_that_was_lost_is_told_once_and_has_no_level_of_its_own(tmp_path: Path, lost: str) -> None:
    found = answer(tmp_path, lost, "current", "torque", "speed")
    assert warned(found) == [lost]
    assert not any(each.kind is RemarkKind.TWO_REGIMES for each in found.remarks)
    of_size = "current_fundamental" if lost == "current" else f"{lost}_mean"
    assert "200 samples in a row" in numbers(found)[of_size].reason


@pytest.mark.parametrize("even", [True, False])
def test_orders_leave_out_rows_of_which_the_angle_was_lost(tmp_path: Path, even: bool) -> None:
    found = answer(tmp_path, "angle", "angle", "torque", even=even)
    assert warned(found) == ["angle"]
    order = numbers(found)["torque_order_24"]
    assert order.uncertainty is not None
    assert abs(order.value - 0.1) < 3.0 * order.uncertainty.standard
    mean = numbers(found)["torque_mean"]
    assert mean.uncertainty is None
    assert "'angle' stands still from row 500 (from 0) on, in 200 rows in all" in mean.uncertainty_reason


def test_an_angle_that_was_lost_gives_no_spectrum_and_no_mean_speed(tmp_path: Path) -> None:
    found = answer(tmp_path, "angle", "angle", "current", "speed")
    assert "'angle' stands still" in numbers(found)["current_fundamental"].reason
    assert "course of angle" not in numbers(found)["speed_mean"].definition
    assert not any(each.kind is RemarkKind.OTHER_SPEED for each in found.remarks)


def test_a_rotor_that_rests_loses_no_angle(tmp_path: Path) -> None:
    assert warned(answer(tmp_path, "", "angle", "torque", rotor_rests=True)) == []


def test_three_phases_of_which_one_was_lost_have_no_sequences(tmp_path: Path) -> None:
    found = answer(tmp_path, "current_b", *PHASES)
    assert warned(found) == ["current_b"]
    positive = numbers(found)["current_sequence_positive"]
    assert positive.reason.startswith("'current_b': 200 samples in a row")


@pytest.mark.parametrize(("speed_rad_s", "is_lost"), [(0.0, False), (100.0, True)])
def test_a_speed_says_whether_the_rotor_stood_as_well(
    tmp_path: Path, speed_rad_s: float, is_lost: bool
) -> None:
    """A rotor that a brake stops between two rows was told to have lost its sensor."""
    time_s, is_there = np.arange(ROWS) / RATE_HZ, np.arange(ROWS) >= 700
    angle = np.mod(100.0 * np.minimum(time_s, time_s[700]), 2.0 * np.pi)
    noise = 0.1 * np.random.default_rng(7).standard_normal(ROWS)
    columns = (time_s, angle, np.where(is_there, speed_rad_s, 100.0) + noise, 1.0 + noise)
    path = tmp_path / "rest.csv"
    head = "time_s,angle_rad,speed_rad_s,torque_Nm"
    np.savetxt(path, np.column_stack(columns), "%.6f", ",", header=head, comments="")
    asked = {"angle": "2", "speed": "3", "torque": "4"}
    found = analyze_table(TableQuestion(path, "1", asked))
    (text,) = (each.text for each in found.remarks if each.kind is RemarkKind.STOOD_STILL)
    assert ("while the rotor turned (its sensor or its link was lost)" in text) == is_lost
    assert ("and by 'speed_rad_s', whose mean there is" in text) != is_lost
