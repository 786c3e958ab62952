"""Plans made in Python, bundles on disk, comparison, report and live view, by the Python API."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import benchtool
from benchtool.errors import AnalysisError, CapabilityMissing, PlanError, RecordingError, UsageError

CONTENT = {
    "title": "Ripple of two laws",
    "profile": "zhu2011",
    "operating_point": {"omega_m_rad_s": 78.5, "load_torque_Nm": 1.0, "settle_s": 0.5},
    "record": {"duration_s": 0.3, "channels": ["torque", "theta_m"]},
    "limits": {"torque_ripple_pp_Nm": {"max": 0.5}},
}
TWO = {**CONTENT, "sweep": {"setup": {"law": ["tpc", "foc"]}}}


def test_a_plan_made_in_python_is_run_judged_compared_reported_and_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told: list[str] = []
    result = benchtool.run_plan(benchtool.Plan(**TWO), tmp_path / "run", progress=told.append)
    assert list(result) == ["tpc", "foc"]
    assert result.verdict == "pass"
    assert any("case 2 of 2: foc" in line for line in told)
    assert result.measurement("torque_mean") == pytest.approx({"tpc": 1.0, "foc": 1.0}, abs=0.02)
    assert "torque_ripple_pp" in str(result)
    assert "≤ 0.5: pass" in result._repr_html_()
    with pytest.raises(UsageError, match="2 cases, tpc, foc"):
        _ = result.case
    with pytest.raises(UsageError, match="no case 'dtc'"):
        _ = result["dtc"]
    with pytest.raises(AnalysisError, match="did you mean 'torque_ripple_pp'"):
        _ = result["tpc"]["torque_riple_pp"]

    bundle = benchtool.open_bundle(tmp_path / "run" / "tpc")
    ripple = result["tpc"]["torque_ripple_pp"]
    assert bundle.results["torque_ripple_pp"].value == ripple.value
    assert set(json.loads((tmp_path / "run" / "hashes.json").read_text())["files"]) == {
        "tpc/manifest.json",
        "foc/manifest.json",
    }
    assert bundle.analyze()["torque_ripple_pp"] == ripple
    assert bundle.verdict == "pass"
    assert bundle.streams == ("capture", "telemetry", "transducer")
    block = bundle.block()
    assert block.names == ("torque", "theta_m")
    assert block.transducer is not None
    assert benchtool.analyze(block, bundle.profile)["torque_ripple_pp"].value == ripple.value
    assert "Ripple of two laws" in bundle._repr_html_()
    with pytest.raises(RecordingError, match="holds 2 runs"):
        benchtool.open_bundle(tmp_path / "run")

    compared = benchtool.compare(bundle, result["foc"])
    assert compared["torque_ripple_pp"].reference == ripple.value
    assert compared["torque_ripple_pp"].exceeds is True
    assert "torque_ripple_pp" in str(compared)
    assert "foc" in compared._repr_html_()
    with pytest.raises(AnalysisError, match="was not measured of both"):
        _ = compared["torque_thd"]
    with pytest.raises(UsageError, match="2 cases"):
        benchtool.compare(tmp_path / "run", bundle)

    page = benchtool.write_report(bundle, tmp_path / "report.html")
    assert "torque_ripple_pp" in page.read_text(encoding="utf-8")
    with pytest.raises(UsageError, match="pdf=True"):
        benchtool.write_report(bundle, tmp_path / "report.pdf")
    benchtool.show_live(bundle, tmp_path / "run.rrd")
    assert (tmp_path / "run.rrd").stat().st_size > 10_000
    with pytest.raises(UsageError, match="'viewer', 'web'"):
        benchtool.show_live(bundle, "window")
    assert capsys.readouterr().out == ""


def test_a_plan_runs_on_the_bench_as_it_stands(bench: benchtool.Bench, tmp_path: Path) -> None:
    bench.drive["law"] = "foc"
    plan = benchtool.Plan(**CONTENT)
    result = bench.run(plan, tmp_path / "run", allow_different=True)
    assert result.bundle.parameters["law"] == "foc"
    assert bench.drive["law"] == "foc"
    assert result.case["torque_mean"].value == pytest.approx(1.0, abs=0.02)
    altered = benchtool.Plan(**{**CONTENT, "emulator": {"inverter.u_dc_V": 250.0}})
    with pytest.raises(UsageError, match="the plan with benchtool"):
        bench.run(altered, tmp_path / "other")
    with bench.drive.enabled("velocity"):
        bench.wait(0.1)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("operating_point", {"omega_m_rads": 78.5}, "did you mean 'omega_m_rad_s'"),
        ("operating_point", {"omega_m_rad_s": "fast"}, "key 'operating_point.omega_m_rad_s' is 'fast'"),
        ("record", {"duration_s": 0.1, "channels": []}, "record.channels"),
        ("limits", {"torque_ripple_pp": {}}, "limits.torque_ripple_pp"),
    ],
)
def test_a_plan_made_in_python_is_refused_by_the_same_rules(key: str, value: object, message: str) -> None:
    with pytest.raises(PlanError, match=message):
        benchtool.Plan(**{**CONTENT, key: value})


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (
            "record",
            {"duration_s": 0.1, "channels": ["torqe"]},
            "plan 'Ripple.*channels.*mean 'torque'",
        ),
        ("limits", {"torque_riple_pp": {"max": 1}}, "limits.torque_riple_pp: .*mean 'torque_ripple_pp'"),
        ("setup", {"u_ss_V": 1.0}, "setup.u_ss_V"),
        ("setup", {"i_trip_A": 1e6}, "setup"),
    ],
)
def test_a_plan_is_held_against_the_bench_before_it_is_opened(
    key: str, value: object, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((PlanError, CapabilityMissing), match=message):
        benchtool.run_plan(benchtool.Plan(**{**CONTENT, key: value}))
    assert list(tmp_path.iterdir()) == []


def test_a_plan_that_ships_is_loaded_and_altered() -> None:
    plan = benchtool.Plan.load("zhu2011/ripple")
    assert plan.model_copy(update={"repetitions": 3}).repetitions == 3
    with pytest.raises(PlanError, match="no plan 'zhu2011/riple'"):
        benchtool.Plan.load("zhu2011/riple")


def test_a_recording_is_read_and_measured_without_a_plan(bench: benchtool.Bench, tmp_path: Path) -> None:
    bundle = bench.record(0.5, ["torque", "omega_m"], tmp_path / "recorded", rate_Hz=250)
    assert bundle.verdict == "none"
    assert bundle.complete
    assert len(bundle.block("telemetry").data) == pytest.approx(125, abs=2)
    assert bundle.block().names == ("torque", "omega_m")
    with pytest.raises(RecordingError, match="no stream 'capture'"):
        bundle.block("capture")
