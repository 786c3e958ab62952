"""`benchtool analyze --csv`: imported tables from a user's point of view."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.at_length import at_length
from tests.emulated.analyze_csv import Invoke, analyze, measured, values
from tests.emulated.csv_tables import TURN, Array, gimbal, phase_current, sinusoid, write


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return analyze


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
    assert listed[:5] == ["current_order_largest", "current_order_largest_amplitude", *truth]
    assert found["current_order_largest_amplitude"] == found["current_order_72"]
    assert len(case["tables"]["current_orders"]["rows"]) == 200

    for name in ("fundamental_frequency", "current_fundamental", "current_thd_f"):
        assert found[name] is None
        assert "the time stamps are not even" in case["measurements"][name]["reason"]
    assert found["current_mean"] == pytest.approx(0.1, abs=0.01)
    assert "sample_rate_Hz" not in case["measurements"]["current_mean"]["basis"]
    source = case["source"]
    stated = {"number": 4, "name": "Iq", "unit": "A", "unit_from": "assumed", "gain": 1.0, "offset": 0.0}
    assert source["columns"]["current"] == stated
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
    assert found["current_thd_f"] == pytest.approx(5.0, rel=1e-3)
    assert "current_ripple_pp" not in found
    assert case["source"]["time"]["rate_Hz"] == pytest.approx(10e3)
    assert case["source"]["columns"]["current"]["unit_from"] == "head"


@pytest.mark.parametrize(
    ("mean", "name", "reason"),
    [
        (2.0, "I", "its mean is 2.02 A and its largest sinusoid 3 A peak"),
        (0.0, "Iq", "'Iq' is by its name a current in rotating coordinates"),
        (0.0, "i_d", "'i_d' is by its name"),
        (0.0, "motor i q", "'motor i q' is by its name"),
    ],
)
def test_a_current_in_rotating_coordinates_has_ripple_and_no_thd(
    invoke: Invoke, mean: float, name: str, reason: str
) -> None:
    time_s, current = phase_current()
    write("q.csv", f"t,{name}", [time_s, current + mean])

    case = measured(invoke("--csv", "q.csv", "--time", "t", "--current", name, "--json"))

    assert values(case)["current_thd_f"] is None
    assert reason in case["measurements"]["current_thd_f"]["reason"]
    assert values(case)["current_ripple_pp"] == pytest.approx(np.ptp(current), rel=1e-6)


def test_noise_is_no_phase_current(invoke: Invoke) -> None:
    time_s, _ = phase_current()
    write("noise.csv", "t,I", [time_s, np.random.default_rng(2).normal(size=len(time_s))])
    case = measured(invoke("--csv", "noise.csv", "--time", "t", "--current", "I", "--json"))
    assert "no sinusoid stands out" in case["measurements"]["current_thd_f"]["reason"]


RAMP = sinusoid(np.linspace(40.0, 48.0, 10_000))
HALF = sinusoid(43.7, np.where(np.arange(10_000) < 5_000, 5.0, 0.0))


@pytest.mark.parametrize(
    ("record", "arguments", "reason"),
    [
        (
            RAMP,
            ("--angle", "3", "--pole-pairs", "4"),
            "the speed changes by 18 % within the window, at most 10 %",
        ),
        (RAMP, (), "the frequency of the largest sinusoid of 'I' changes by 18 % within the window"),
        (HALF, (), "the amplitude of the largest sinusoid of 'I' changes by 200 %"),
        (
            sinusoid(43.7),
            ("--angle", "3", "--pole-pairs", "3"),
            "the largest sinusoid of 'I' is at 43.7 Hz, the angle with 3 pole pairs says 32.77 Hz",
        ),
    ],
)
def test_a_current_that_is_not_steady_or_not_at_the_angles_frequency_has_no_fundamental(
    invoke: Invoke, record: tuple[Array, Array, Array], arguments: tuple[str, ...], reason: str
) -> None:
    write("ramp.csv", "t,I,a", list(record))
    case = measured(invoke("--csv", "ramp.csv", "--time", "t", "--current", "I", *arguments, "--json"))
    for name in ("fundamental_frequency", "current_fundamental", "current_thd_f"):
        assert values(case)[name] is None
        assert reason in case["measurements"][name]["reason"]
    assert values(case)["current_ripple_pp"] == pytest.approx(10.0, rel=1e-3)


@pytest.mark.parametrize("rise_Hz", [2.0, *at_length(0.0)])
def test_a_slow_drift_is_no_hindrance(invoke: Invoke, rise_Hz: float) -> None:
    write("drift.csv", "t,I,a", list(sinusoid(np.linspace(40.0, 40.0 + rise_Hz, 10_000))))
    arguments = ("--csv", "drift.csv", "--time", "t", "--current", "I", "--json")
    by_angle = values(measured(invoke(*arguments, "--angle", "a", "--pole-pairs", "4")))
    assert by_angle["current_fundamental"] == pytest.approx(5.0, rel=1e-4)
    by_tone = values(measured(invoke(*arguments)))
    assert by_tone["fundamental_frequency"] == pytest.approx(40.0 + rise_Hz / 2, rel=1e-3)


@pytest.mark.parametrize("wraps", [True, False])
def test_an_angle_in_degrees_says_so_and_gives_no_scatter(invoke: Invoke, wraps: bool) -> None:
    time_s, current, angle = sinusoid(43.7)
    torque = 2.0 + 0.1 * np.cos(24 * angle) + 0.01 * np.random.default_rng(3).normal(size=len(angle))
    degrees = np.degrees(angle)
    write("degrees.csv", "t,I,T,a", [time_s, current, torque, np.mod(degrees, 360.0) if wraps else degrees])
    arguments = ("--csv", "degrees.csv", "--time", "t", "--torque", "T", "--pole-pairs", "4", "--json")

    if wraps:
        alone = measured(invoke(*arguments, "--angle", "a"))
        assert "uncertainty" not in alone["measurements"]["torque_mean"]

    case = measured(invoke(*arguments, "--current", "I", "--angle", "a"))

    reason = "'a' starts over at about 360" if wraps else "the angle with 4 pole pairs says 2504 Hz: check"
    assert reason in case["measurements"]["current_fundamental"]["reason"]
    mean = case["measurements"]["torque_mean"]["uncertainty"]
    assert "scatter over 43 electrical periods" in mean["source"]  # the current's own


@pytest.mark.parametrize("lost", [0, 1])
def test_torque_has_the_scatter_of_what_repeats_and_all_its_numbers(invoke: Invoke, lost: int) -> None:
    time_s, current, angle = sinusoid(40.0)
    torque = 2.0 + 0.1 * np.cos(24 * angle) + 0.05 * np.random.default_rng(6).normal(size=len(angle))
    kept = np.delete(np.arange(10_000), np.s_[5_000 : 5_000 + lost])
    write("torque.csv", "t,I,T,a", [each[kept] for each in (time_s, current, torque, angle)])
    arguments = ("--csv", "torque.csv", "--time", "t", "--torque", "T", "--rated-torque", "4", "--json")

    by_angle = measured(invoke(*arguments, "--angle", "a"))["measurements"]
    numbers = ("mean", "ripple_pp", "ripple_rms", "ripple_percentile_range", "ripple_percent_of_mean")
    for name in (*numbers, "ripple_rms_percent_of_mean", "ripple_rms_percent_of_rated"):
        assert by_angle[f"torque_{name}"]["uncertainty"]["standard"] > 0.0
    mean = by_angle["torque_mean"]
    assert "scatter over 9 revolutions of a" in mean["uncertainty"]["source"]
    assert 0.1e-3 < mean["uncertainty"]["standard"] < 2e-3  # 0.05 / sqrt(10000) = 0.5e-3
    assert ("each counting the same" in mean["definition"]) == bool(lost)

    by_current = measured(invoke(*arguments, "--current", "I"))["measurements"]["torque_mean"]
    periods = 19 if lost else 39  # those of the longer half
    assert f"scatter over {periods} electrical periods" in by_current["uncertainty"]["source"]


@pytest.mark.parametrize("name", ["I grid", "ia valid", "CH1 grid"])
def test_a_name_that_only_ends_in_id_is_that_of_a_phase(invoke: Invoke, name: str) -> None:
    time_s, current = phase_current()
    write("grid.csv", f"t,{name}", [time_s, current])
    case = measured(invoke("--csv", "grid.csv", "--time", "t", "--current", name, "--json"))
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)


def test_a_dead_column_costs_its_own_numbers_only(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("dead.csv", "t,I,T,n", [time_s, current, 0 * time_s + 2.0, 10.0 + current])
    columns = ("--current", "I", "--torque", "T", "--speed", "n")
    case = measured(invoke("--csv", "dead.csv", "--time", "t", *columns, "--json"))
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)
    assert values(case)["speed_mean"] == pytest.approx(10.02, rel=1e-3)
    assert values(case)["torque_mean"] is None
    assert "'T' is constant at 2" in case["measurements"]["torque_mean"]["reason"]

    dead = measured(invoke("--csv", "dead.csv", "--time", "t", "--current", "T", "--json"))
    assert set(values(dead).values()) == {None}


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


def test_an_angle_that_does_not_turn_leaves_orders_undefined(invoke: Invoke) -> None:
    time_s, current = phase_current()
    write("still.csv", "t,I,a", [time_s, current, 0.1 * time_s])
    case = measured(invoke("--csv", "still.csv", "--time", "t", "--current", "I", "--angle", "a", "--json"))
    assert values(case)["current_order_largest"] is None
    assert "mechanical revolutions" in case["measurements"]["current_order_largest"]["reason"]
    assert values(case)["current_fundamental"] == pytest.approx(3.0, rel=1e-4)


def test_for_people(invoke: Invoke) -> None:
    gimbal()
    result = invoke("--csv", "gimbal.txt", "--time", "Time", "--current", "Iq", "--angle", "Position")
    assert result.exit_code == 0, result.output
    text = " ".join(result.stdout.split())
    assert "current_order_72" in text
    assert "undefined: fundamental_frequency, current_fundamental, current_thd_f: the time" in text
    assert "12000 rows, 12000 used; time from column 1 'Time' in s (assumed)" in text


def test_people_are_told_why_a_number_has_no_uncertainty(invoke: Invoke) -> None:
    rows = np.column_stack([np.arange(2000) / 1e3, np.random.default_rng(1).normal(2.0, 0.1, 2000)])
    np.savetxt("log.csv", rows, delimiter=",", header="Time [s],Torque [Nm]", comments="", fmt="%.6f")
    result = invoke("--csv", "log.csv", "--time", "Time", "--torque", "Torque")
    assert result.exit_code == 0, result.output
    text = " ".join(result.stdout.split())
    assert "without ±: torque_mean, torque_ripple_pp, torque_ripple_rms and 3 more: no angle, current" in text


def test_a_current_that_stands_still_has_no_offset_to_take_off(invoke: Invoke) -> None:
    time_s, current, angle = sinusoid(43.7)
    current = current + 1e-3 * np.random.default_rng(4).standard_normal(len(current))
    current[4_000:8_000] = current[4_000]
    write("stuck.csv", "t,I,a", [time_s, current, angle])
    arguments = ("--csv", "stuck.csv", "--time", "t", "--current", "I", "--angle", "a", "--pole-pairs", "4")
    case = measured(invoke(*arguments, "--json"))
    assert "4000 samples in a row from row 4000" in case["measurements"]["current_fundamental"]["reason"]
