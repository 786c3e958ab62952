"""From a recording to measurements: streams, regimes, windows, gaps, and what cannot be measured."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from benchtool.errors import AnalysisError, RecordingError, UsageError
from benchtool.plan.limits import Verdict
from benchtool.results.recordings import Selection, assess_recording
from benchtool.results.runs import complete_cases, recorded_runs
from tests.unit.results.recorded_specimen import PROFILE, recording, stream, with_gaps

STEADY = [(4.0, 15.7, 0.65)]
TWO = [(3.0, 15.7, 0.65), (3.0, 40.0, 0.65)]


def test_each_steady_regime_is_measured_by_itself(tmp_path: Path) -> None:
    bundle = recording(tmp_path / "a", {"telemetry": stream(TWO)})
    one, two = assess_recording(bundle)
    assert (one.case, two.case) == ("telemetry 1", "telemetry 2")
    assert one.found["omega_m_reached"].value == pytest.approx(15.7, rel=1e-3)
    assert two.found["omega_m_reached"].value == pytest.approx(40.0, rel=1e-3)
    assert one.found["omega_m_reached"].uncertainty is not None
    assert one.verdict is Verdict.NONE
    source = two.to_json()["source"]
    assert source["sha256"] == bundle.manifest.files["data/telemetry.parquet"].sha256
    assert source["from_s"] >= 3.0
    assert [each["steady"] for each in source["regimes"]] == [True, False, True]


def test_a_window_is_measured_as_it_is_and_the_file_keeps_its_hash(tmp_path: Path) -> None:
    bundle = recording(tmp_path / "a", {"telemetry": stream(TWO)})
    (whole,) = assess_recording(bundle, Selection(from_s=0.0))
    (part,) = assess_recording(bundle, Selection(from_s=4.0, to_s=5.0))
    assert len(whole.capture.data) == 1500
    assert part.case == "telemetry 4-5 s"
    source = part.to_json()["source"]
    assert (source["from_s"], source["to_s"], source["rows"]) == (4.0, 5.0, 250)
    assert (source["first_tick"], source["last_tick"]) == (40_000, 49_960)
    assert source["sha256"] == whole.to_json()["source"]["sha256"]
    assert source["regimes"] == []


def test_several_streams_are_measured_each_at_its_own_rate(tmp_path: Path) -> None:
    slow = stream(STEADY, 100.0, channels=("torque",))
    bundle = recording(tmp_path / "a", {"fast": stream(STEADY, 1000.0), "slow": slow})
    assert [each.case for each in assess_recording(bundle)] == ["fast", "slow"]
    (only,) = assess_recording(bundle, Selection(stream="slow"))
    assert only.capture.sample_rate_Hz == pytest.approx(100.0)
    assert only.without
    with pytest.raises(RecordingError, match="has no stream 'fats', it has: fast, slow"):
        assess_recording(bundle, Selection(stream="fats"))


def test_a_transducer_beside_a_stream_is_the_true_torque(tmp_path: Path) -> None:
    torque = stream(STEADY, 1000.0, channels=("torque",), seed=1)
    shaft = replace(torque, channels=(replace(torque.channels[0], name="torque_transducer"),))
    bundle = recording(tmp_path / "a", {"telemetry": stream(STEADY, 1000.0), "transducer": shaft})
    (only,) = assess_recording(bundle)
    assert only.found["transducer_torque_mean"].value == pytest.approx(0.65, abs=0.003)


def test_missing_rows_leave_the_longest_stretch_and_are_told(tmp_path: Path) -> None:
    block = with_gaps(stream(STEADY), (100, 3), (400, 50))
    (only,) = assess_recording(recording(tmp_path / "a", {"telemetry": block}))
    assert len(only.capture.data) == 600
    assert math.isfinite(only.found["torque_mean"].value)
    source = only.to_json()["source"]
    assert (source["rows"], source["rows_of_window"], source["missing_rows"], source["gaps"]) == (
        600,
        1000,
        53,
        2,
    )
    assert only.recorded is not None
    assert "53 rows are missing in 2 gaps there" in " ".join(only.recorded.remarks(only.capture))


def test_what_has_no_two_rows_together_is_refused(tmp_path: Path) -> None:
    block = with_gaps(stream(STEADY), *((row, 1) for row in range(1, 1000)))
    bundle = recording(tmp_path / "a", {"telemetry": block})
    with pytest.raises(AnalysisError, match=r"999 are missing in 999 gaps and the longest stretch .* has 1"):
        assess_recording(bundle)


def test_a_recording_that_keeps_changing_asks_for_a_window(tmp_path: Path) -> None:
    block = stream([(0.2, 10.0 * number, 0.5) for number in range(12)])
    bundle = recording(tmp_path / "a", {"telemetry": block})
    with pytest.raises(AnalysisError, match=r"has no steady state of 0\.5 s.* --from"):
        assess_recording(bundle)
    (window,) = assess_recording(bundle, Selection(from_s=0.45, to_s=0.55))
    assert len(window.capture.data) == 25
    (case,) = recorded_runs(tmp_path / "a")[0].cases
    assert case.assessment is None
    assert case.verdict is Verdict.NONE, "nothing was judged"


def test_an_interrupted_recording_is_measured_as_far_as_it_came(tmp_path: Path) -> None:
    recording(tmp_path / "a", {"telemetry": stream(STEADY)}, finish=False)
    (only,) = complete_cases(tmp_path / "a")
    assert only.found["torque_mean"].value == pytest.approx(0.65, abs=0.01)
    assert only.to_json()["source"]["sha256"] is None


def test_an_empty_recording_says_why(tmp_path: Path) -> None:
    cut = recording(tmp_path / "cut", {}, finish=False)
    with pytest.raises(AnalysisError, match=r"holds no stream \(LinkClosed: the adapter vanished\)"):
        assess_recording(cut)
    block = stream(STEADY)
    none = recording(tmp_path / "none", {"telemetry": replace(block, data=block.data[:0])})
    with pytest.raises(AnalysisError, match=r"'telemetry' of .* has no rows: nothing was received"):
        assess_recording(none)


def test_without_a_motor_nothing_is_measured(tmp_path: Path) -> None:
    bundle = recording(tmp_path / "a", {"telemetry": stream(STEADY)}, toml="")
    with pytest.raises(AnalysisError, match="carries no profile with a motor"):
        assess_recording(bundle)
    wrong = recording(tmp_path / "b", {"telemetry": stream(STEADY)}, toml="[motor]\npole_pairs = -1\n")
    with pytest.raises(AnalysisError, match="cannot be read"):
        assess_recording(wrong)


def test_recordings_in_one_folder_are_told_apart(tmp_path: Path) -> None:
    for name in "ab":
        recording(tmp_path / "all" / name, {"telemetry": stream(TWO)})
    (run,) = recorded_runs(tmp_path / "all")
    assert [case.name for case in run.cases] == [
        "a telemetry 1",
        "a telemetry 2",
        "b telemetry 1",
        "b telemetry 2",
    ]
    with pytest.raises(UsageError, match="is no single bundle, of which a part can be measured"):
        recorded_runs(tmp_path / "all", Selection(from_s=1.0))


def test_pole_pairs_and_rating_are_those_of_the_profile_that_was_recorded(tmp_path: Path) -> None:
    bundle = recording(tmp_path / "a", {"telemetry": stream(STEADY, channels=("torque", "theta_m", "i_a"))})
    (only,) = assess_recording(bundle)
    assert only.found["torque_ripple_rms_percent_of_rated"].value == pytest.approx(
        100.0 * only.found["torque_ripple_rms"].value / PROFILE.motor.T_N_Nm
    )
