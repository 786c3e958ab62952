"""Tables of any content: an answer that JSON can hold, or one line."""

from __future__ import annotations

import json
import os
from datetime import date, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings, strategies as st

from benchtool.analysis import Measurement
from benchtool.errors import BenchError
from benchtool.profile import Bench, ReferenceClock, Sensor
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from tests.at_length import at_length

NUMBERS = st.one_of(
    st.floats(-10.0, 10.0),
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([0.0, 1.0, -1.0, 1e308, 9.9e37, 9e37, -9e37, 1e-150, 5e-324]),
)
STAMPS = st.one_of(st.just("even"), st.just("coarse"), st.just("any"))


def answer_or_error(path: Path) -> None:
    columns = {"current": "2", "torque": "3", "angle": "4", "speed": "5"}
    question = TableQuestion(path, "1", columns, pole_pairs=2, slots=6, torque_rated_Nm=1.0)
    try:
        document = analyze_table(question).to_json()
    except BenchError as refused:
        assert len(str(refused).splitlines()) == 1  # noqa: PT017 # either outcome is right
    else:
        assert json.dumps(document, allow_nan=False)


@given(
    rows=st.lists(st.tuples(*[NUMBERS] * 5), min_size=1, max_size=40), repeat=st.integers(1, 6), stamps=STAMPS
)
@example(rows=[(0.0, 9e37, -9e37, 9e37, 1.0), (1.0, -9e37, 9e37, -9e37, 2.0)], repeat=6, stamps="even")
@example(rows=[(0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0, 0.0)], repeat=4, stamps="even")
@example(rows=[(0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0, 2e-298)], repeat=4, stamps="even")
@example(
    rows=[(0.0,) * 5, (0.0,) * 5, (0.0, 0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 2e-309, 0.0, 0.0)],
    repeat=1,
    stamps="even",
)
@settings(
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_any_numbers_give_an_answer_or_an_error_of_the_tree(
    tmp_path: Path, rows: list[tuple[float, ...]], repeat: int, stamps: str
) -> None:
    lines = []
    for number, row in enumerate(rows * repeat):
        time = {"even": number * 1e-3, "coarse": number // 10 * 1e-2, "any": row[0]}[stamps]
        lines.append(",".join(map(repr, (time, *row[1:]))))
    path = tmp_path / "table.csv"
    path.write_text("t,I,T,a,n\n" + "\n".join(lines), encoding="utf-8")
    answer_or_error(path)


@given(content=st.binary(max_size=300))
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_give_an_answer_or_an_error_of_the_tree(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    answer_or_error(path)


def test_every_number_of_a_table_declares_its_sensitivities_to_its_own_columns(tmp_path: Path) -> None:
    """A table is not measured again: what is not declared would leave its sensors out."""
    time_s = np.arange(4_000) * 1e-3
    angle, noise = 2 * np.pi * 3.0 * time_s, 1e-3 * np.random.default_rng(1).standard_normal((3, 4_000))
    current, torque = np.cos(4 * angle) + noise[0], 1.0 + 0.1 * np.cos(6 * angle) + noise[1]
    rows = np.stack([time_s, current, torque, 20.0 + np.cos(2 * angle) + noise[2], angle], axis=1)
    path = tmp_path / "table.csv"
    path.write_text("t,I,T,n,a\n" + "\n".join(",".join(map(repr, map(float, row))) for row in rows))
    columns = {"current": "I", "torque": "T", "speed": "n"}
    found: dict[str, Measurement] = {}
    for more in ({"angle": "a"}, {}):
        question = TableQuestion(path, "t", columns | more, pole_pairs=4, torque_rated_Nm=2.0)
        found |= {each.name: each for each in analyze_table(question).measurements}
    assert len(found) > 30
    assert [name for name, each in found.items() if not each.sensitivities.is_declared] == []
    of = {part.channel for each in found.values() for part in each.sensitivities.channels or ()}
    assert of == {"I", "T", "n"}


@pytest.mark.parametrize("scale", [1e-30, 1e30, *at_length(1e-9, 1e9)])
def test_amplitudes_of_any_size_are_measured(tmp_path: Path, scale: float) -> None:
    time_s = np.arange(4_000) * 1e-3
    angle = 2 * np.pi * 3.0 * time_s
    rows = zip(time_s, scale * np.cos(2 * angle), angle, strict=True)
    path = tmp_path / "table.csv"
    path.write_text("".join(",".join(map(repr, map(float, row))) + "\n" for row in rows), encoding="utf-8")

    answer = analyze_table(TableQuestion(path, "1", {"current": "2", "angle": "3"}, pole_pairs=2))

    found = {each.name: each.value for each in answer.measurements}
    assert found["current_fundamental"] == pytest.approx(scale, rel=1e-3)
    assert found["current_order_2"] == pytest.approx(scale, rel=1e-3)


@pytest.mark.parametrize(("recorded_on", "late"), [(date(2026, 3, 2), True), (date(2026, 3, 1), False)])
def test_the_day_and_the_clock_of_a_table_are_those_that_are_stated(
    tmp_path: Path, recorded_on: date, late: bool
) -> None:
    """A calibration that was due before the day is a remark; the clock is in the frequency's uncertainty."""
    time_s = np.arange(4000) / 2e3
    path = tmp_path / "table.csv"
    np.savetxt(path, np.stack([time_s, 5.0 * np.cos(2 * np.pi * 50.0 * time_s)], axis=1), delimiter=",")
    bench = Bench(
        channels={"current": Sensor(gain_U_percent=1.0, due=date(2026, 3, 1))},
        clock=ReferenceClock(tolerance_ppm=50.0),
    )
    question = TableQuestion(path, "1", {"current": "2"}, bench=bench, recorded_on=recorded_on)
    answer = analyze_table(question)

    kinds = [each.kind for each in answer.remarks]
    assert (RemarkKind.CALIBRATION_OVERDUE in kinds) is late
    assert answer.source["recorded_on"] == str(recorded_on)
    (frequency,) = (each for each in answer.measurements if each.name == "fundamental_frequency")
    assert frequency.uncertainty is not None
    (line,) = (each for each in frequency.uncertainty.budget if "ppm" in each.name)
    assert line.standard == pytest.approx(50.0 * 50e-6 / np.sqrt(3.0), rel=1e-3)


def test_without_a_stated_day_it_is_that_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("".join(f"{k / 1e3},{np.cos(0.3 * k)}\n" for k in range(200)))
    os.utime(path, (0.0, datetime(2020, 5, 17, 12).timestamp()))
    assert TableQuestion(path, "1", {"current": "2"}).day == date(2020, 5, 17)
