"""Torque without an angle and a current: the periods are those of the constant speed that was stated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.profile import Bench, Sensor
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from benchtool.tables.scaling import quantity, speed_hint
from tests.at_length import at_length

SPEED_RAD_S = 80.0
MEAN_NM, RIPPLE_NM = 2.0, 0.1
RECORDS = 16


def numbers(
    folder: Path, seed: int, pole_pairs: int | None, speed_rad_s: float | None
) -> dict[str, Measurement]:
    """Measure 1.5 s of torque with a ripple of order 6 and noise that remembers twenty rows."""
    random = np.random.default_rng(seed)
    time_s = np.arange(3_000) / 2_000.0
    noise = np.convolve(random.standard_normal(len(time_s) + 99), 0.95 ** np.arange(100), "valid")
    ripple = RIPPLE_NM * np.cos(6.0 * SPEED_RAD_S * time_s + random.uniform(0.0, 6.0))
    path = folder / "torque.csv"
    np.savetxt(path, np.column_stack([time_s, MEAN_NM + ripple + 0.01 * noise]), "%.9g", ",", header="t,T")
    answer = analyze_table(
        TableQuestion(
            file=path,
            time="1",
            columns={"torque": "2"},
            pole_pairs=pole_pairs,
            omega_m_rad_s=speed_rad_s,
        )
    )
    return {each.name: each for each in answer.measurements}


@pytest.mark.parametrize("pole_pairs", [4, *at_length(None)])
def test_the_uncertainty_of_the_mean_is_what_repeated_records_scatter_by(
    tmp_path: Path, pole_pairs: int | None
) -> None:
    errors = []
    for seed in range(RECORDS):
        mean = numbers(tmp_path, seed, pole_pairs, SPEED_RAD_S)["torque_mean"]
        assert mean.uncertainty is not None
        errors.append((mean.value - MEAN_NM) / mean.uncertainty.standard)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.5


@pytest.mark.parametrize("pole_pairs", [None, 4])
def test_backwards_a_torque_has_the_same_mean_and_uncertainty(tmp_path: Path, pole_pairs: int | None) -> None:
    forwards, backwards = (
        numbers(tmp_path, 0, pole_pairs, speed)["torque_mean"] for speed in (SPEED_RAD_S, -SPEED_RAD_S)
    )
    assert forwards.uncertainty is not None
    assert backwards.uncertainty is not None
    assert backwards.value == pytest.approx(forwards.value, rel=1e-9)
    assert backwards.uncertainty.standard == pytest.approx(forwards.uncertainty.standard, rel=1e-6)


def test_ripple_has_an_uncertainty_by_the_periods_of_the_stated_speed_alone(tmp_path: Path) -> None:
    with_speed, without = (numbers(tmp_path, 0, None, speed) for speed in (SPEED_RAD_S, None))
    for name in ("torque_mean", "torque_ripple_rms", "torque_ripple_pp"):
        assert with_speed[name].uncertainty is not None
        assert without[name].uncertainty is None
        assert "stated speed" in without[name].uncertainty_reason


@pytest.mark.parametrize("speed_rad_s", [0.0, 1.0, 1e5])
def test_a_speed_without_three_periods_or_with_one_in_a_row_gives_no_uncertainty(
    tmp_path: Path, speed_rad_s: float
) -> None:
    found = numbers(tmp_path, 0, None, speed_rad_s)
    assert found["torque_mean"].uncertainty is None
    assert found["torque_mean"].uncertainty_reason


@pytest.mark.parametrize("by_angle", [False, True])
def test_the_speed_tells_at_which_frequency_a_sensor_has_read_an_order(
    tmp_path: Path, by_angle: bool
) -> None:
    time_s = np.arange(3_000) / 2_000.0
    read = MEAN_NM + RIPPLE_NM * np.cos(6.0 * SPEED_RAD_S * time_s)
    path = tmp_path / "torque.csv"
    np.savetxt(
        path, np.column_stack([time_s, read, SPEED_RAD_S * time_s]), "%.9g", ",", header="t,T,theta [rad]"
    )
    bandwidth_Hz = 6.0 * SPEED_RAD_S / (2.0 * np.pi)
    sensor = Sensor(bandwidth_Hz=bandwidth_Hz, bandwidth_tolerance_percent=5.0)
    answer = analyze_table(
        TableQuestion(
            file=path,
            time="1",
            columns={"torque": "2"} | ({"angle": "3"} if by_angle else {}),
            omega_m_rad_s=None if by_angle else SPEED_RAD_S,
            bench=Bench(channels={"torque": sensor}),
        )
    )
    order = next(each for each in answer.measurements if each.name == "torque_order_6")
    assert order.value == pytest.approx(RIPPLE_NM * np.sqrt(2.0), rel=1e-3)
    assert order.correction is not None
    assert order.uncertainty is not None


@pytest.mark.parametrize(
    ("speed_rad_s", "told"),
    [(0.995 * SPEED_RAD_S, False), (0.95 * SPEED_RAD_S, True), (1.05 * SPEED_RAD_S, True)],
)
def test_a_fundamental_elsewhere_than_the_stated_speed_says_is_told(
    tmp_path: Path, speed_rad_s: float, told: bool
) -> None:
    time_s = np.arange(3_000) / 2_000.0
    path = tmp_path / "current.csv"
    current_A = np.cos(4.0 * SPEED_RAD_S * time_s) + 0.01 * np.random.default_rng(4).standard_normal(3_000)
    np.savetxt(path, np.column_stack([time_s, current_A]), "%.9g", ",", header="t [s],I [A]")

    answer = analyze_table(
        TableQuestion(file=path, time="1", columns={"current": "2"}, pole_pairs=4, omega_m_rad_s=speed_rad_s)
    )

    assert [each.kind for each in answer.remarks] == [RemarkKind.OTHER_FREQUENCY] * told
    if told:
        text = answer.remarks[0].text
        assert "is at 50.93 Hz, the stated speed with 4 pole pairs says" in text
        assert ("slips" in text) == (speed_rad_s < SPEED_RAD_S)


@pytest.mark.parametrize(
    "stated", ["750rpm", "750 rpm", "750 1/min", "12.5 1/s", "12.5rev/s", "-750 1 / min"]
)
def test_a_constant_speed_with_its_unit(stated: str) -> None:
    found = quantity(stated, "rad/s")
    assert found is not None
    assert abs(found) == pytest.approx(750.0 * np.pi / 30.0)


@pytest.mark.parametrize("column", ["7501/min", "750", "12.5Hz", "n", "2", "750.5.1rpm"])
def test_what_may_be_a_column_is_no_constant_speed(column: str) -> None:
    assert quantity(column, "rad/s") is None


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("750", "as '750rpm'"),
        ("750rpx", "as '750rpm': one of rad/s, "),
        ("12.5Hz", "as '12.5rev/s' or '750rpm' if 'Hz' counts the shaft's revolutions"),
        ("7501/min", "as '750 1/min' or '7501 1/min'"),
        ("n_1", ""),
    ],
)
def test_a_speed_that_is_no_column_is_told_its_units(text: str, hint: str) -> None:
    assert hint in speed_hint(text)
    assert bool(hint) == bool(speed_hint(text))


@pytest.mark.parametrize("stated", [True, False])
def test_uneven_stamps_are_the_reason_for_no_periods(tmp_path: Path, stated: bool) -> None:
    random = np.random.default_rng(3)
    time_s = np.arange(3_000) / 2_000.0 + random.normal(0.0, 2e-5, 3_000)
    torque, current = 2.0 + 0.1 * np.cos(480.0 * time_s), np.cos(240.0 * time_s)
    path = tmp_path / "uneven.csv"
    np.savetxt(path, np.column_stack([time_s, torque, current]), "%.9g", ",")
    columns = {"torque": "2"} if stated else {"torque": "2", "current": "3"}
    speed_rad_s = SPEED_RAD_S if stated else None
    answer = analyze_table(TableQuestion(path, "1", columns, omega_m_rad_s=speed_rad_s))
    reasons = {each.name: each.uncertainty_reason for each in answer.measurements}
    by = "the stated speed" if stated else "the current"
    for name in ("torque_mean", "torque_ripple_pp"):
        assert "the time stamps are not even" in reasons[name]
        assert f"{by} tells no periods of such rows" in reasons[name]
