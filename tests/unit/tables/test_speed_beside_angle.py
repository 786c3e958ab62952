"""The mean of a speed in a table that has the angle too, or a phase current and the pole pairs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from tests.at_length import at_length

RATE_HZ, ROWS, POLE_PAIRS = 2000.0, 2000, 4
COLUMNS = {"speed": "omega", "angle": "theta", "current": "ia"}


def wandering(
    folder: Path, seed: int, sign: float = 1.0, *, jitter: float = 0.0, lost: slice = slice(0)
) -> tuple[Path, float]:
    """Write a speed that swings and wanders slowly, with its angle and current, at times that jitter by a
    share of a step, without rows that were lost; return its mean as well."""
    random = np.random.default_rng(seed)
    time_s = (np.arange(ROWS) + jitter * random.uniform(0.0, 1.0, ROWS)) / RATE_HZ
    slow = 0.4 * np.cumsum(random.standard_normal(ROWS)) / np.sqrt(ROWS)
    omega = sign * (100.0 + 0.7 * np.sin(2.0 * np.pi * 3.3 * time_s + 0.4) + slow)
    theta = np.concatenate([[0.0], np.cumsum(0.5 * (omega[1:] + omega[:-1]) * np.diff(time_s))])
    columns = (
        time_s,
        omega + 0.3 * random.standard_normal(ROWS),
        np.mod(theta + 1e-4 * random.standard_normal(ROWS), 2.0 * np.pi),
        5.0 * np.sin(POLE_PAIRS * theta) + 0.02 * random.standard_normal(ROWS),
    )
    path = folder / f"{seed}.csv"
    rows = np.delete(np.column_stack(columns), lost, axis=0)
    np.savetxt(path, rows, delimiter=",", header="t,omega,theta,ia", comments="")
    return path, float(theta[-1] - theta[0]) / float(time_s[-1] - time_s[0])


def speed_mean(path: Path, *columns: str, pole_pairs: int | None = POLE_PAIRS) -> Measurement:
    chosen = {each: COLUMNS[each] for each in columns}
    answer = analyze_table(TableQuestion(path, "t", chosen, pole_pairs=pole_pairs))
    return {each.name: each for each in answer.measurements}["speed_mean"]


@pytest.mark.parametrize(
    ("beside", "sign", "named"),
    [("angle", 1.0, "theta"), ("current", -1.0, "ia"), *at_length(("current", 1.0, "ia"))],
)
def test_it_is_as_certain_as_the_other_column_tells_it(
    tmp_path: Path, beside: str, sign: float, named: str
) -> None:
    errors = []
    for seed in range(3):
        path, mean = wandering(tmp_path, seed, sign)
        found = speed_mean(path, "speed", beside)
        assert found.uncertainty is not None, found.uncertainty_reason
        assert found.uncertainty.standard < 0.02
        assert found.repeatability is not None
        assert f"beside the course of {named}" in found.definition
        errors.append((found.value - mean) / found.uncertainty.standard)
    assert np.max(np.abs(errors)) < 3.0


@pytest.mark.parametrize(
    ("jitter", "lost"), [(0.8, slice(0)), (0.0, slice(700, 790)), (0.8, slice(700, 790))]
)
def test_so_it_is_at_uneven_times_and_beside_a_gap(tmp_path: Path, jitter: float, lost: slice) -> None:
    errors = []
    for seed in range(3):
        path, mean = wandering(tmp_path, seed, jitter=jitter, lost=lost)
        found = speed_mean(path, "speed", "angle")
        assert found.uncertainty is not None, found.uncertainty_reason
        assert found.uncertainty.standard < 0.02
        assert "each counting the same" not in found.definition
        errors.append((found.value - mean) / found.uncertainty.standard)
    assert np.max(np.abs(errors)) < 3.0


def test_without_either_it_wanders_more_slowly_than_is_seen(tmp_path: Path) -> None:
    path, _ = wandering(tmp_path, 1)
    for columns, pole_pairs in ((("speed",), POLE_PAIRS), (("speed", "current"), None)):
        found = speed_mean(path, *columns, pole_pairs=pole_pairs)
        assert found.uncertainty is None or found.uncertainty.standard > 0.02
        assert found.repeatability is None


def test_the_ends_of_a_speed_count_by_half(tmp_path: Path) -> None:
    """The mean of all rows is off by half of what both ends differ from it, of 2000 rows by 5e-4."""
    random, time_s = np.random.default_rng(4), np.arange(ROWS) / RATE_HZ
    theta = 100.0 * time_s + 0.2 * np.sin(2.0 * np.pi * 1.05 * time_s)
    omega = 100.0 + 0.2 * 2.0 * np.pi * 1.05 * np.cos(2.0 * np.pi * 1.05 * time_s)
    columns = time_s, omega + 1e-4 * random.standard_normal(ROWS), theta
    path = tmp_path / "quiet.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="t,omega,theta", comments="")
    found = speed_mean(path, "speed", "angle")
    assert found.value == pytest.approx((theta[-1] - theta[0]) / time_s[-1], abs=1e-5)


def test_an_angle_beside_a_gap_advances_at_the_speed_of_its_column(tmp_path: Path) -> None:
    """The turns in the gap were not counted: 100 rad/s was called 50."""
    path, _ = wandering(tmp_path, 3, lost=slice(600, 1400))
    chosen = {each: COLUMNS[each] for each in ("speed", "angle")}
    answer = analyze_table(TableQuestion(path, "t", chosen, pole_pairs=POLE_PAIRS))
    assert not any(each.kind is RemarkKind.OTHER_SPEED for each in answer.remarks)
