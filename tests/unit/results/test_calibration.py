"""From a bundle with `[bench]` to verdicts, comparisons, reports and warnings."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from benchtool.analysis import Measurement, Sensitivities, Uncertainty
from benchtool.analysis.sensors.instruments import UNSTATED, Instruments
from benchtool.cli import app
from benchtool.errors import AnalysisError
from benchtool.plan.limits import Limit, Verdict
from benchtool.plan.model import Plan
from benchtool.profile import Bench, ReferenceClock, Sensor
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.report.assembly.case import remarks
from benchtool.report.content import Grid, Text
from benchtool.report.results import budgets_section, measurement_notes
from benchtool.results.assessment import Assessment
from benchtool.results.calibration import CLOCK, Calibration
from benchtool.results.case_assessment import assess, assess_bundle
from benchtool.results.delta import deltas
from benchtool.results.repetitions import over_repetitions
from tests.at_length import at_length
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture, step_capture

SENSORS = """
[bench.channels.torque]
sensor = "estimate"
serial_number = "{serial}"
certificate = "C-17"
due = 2026-03-01
gain_U_percent = 1.0
[bench.channels.i_a]
sensor = "LEM IT 60-S"
serial_number = "{serial}"
certificate = "C-18"
gain_U_percent = 0.5
offset_limit_A = 0.01
[bench.clock]
tolerance_ppm = 100
"""
ON = "2026-02-28T10:00:00+01:00"
LATE = "2026-03-03T10:00:00+01:00"


def _bundle(folder: Path, *, toml: str = "", when: str = ON, limits: dict[str, Any] | None = None) -> Path:
    block, transducer = steady_capture()
    plan = Plan.model_validate(
        {
            "title": "specimen",
            "profile": "zhu2011",
            "operating_point": {"omega_m_rad_s": 78.54, "load_torque_Nm": 1.0},
            "record": {"duration_s": 0.3, "channels": list(block.names)},
            "limits": limits or {},
        }
    )
    details = {
        "case": "a",
        "plan": plan.model_dump(mode="json"),
        "motor": EXAMPLE_MOTOR.model_dump(mode="json"),
        "u_dc_V": 100.0,
    }
    manifest = Manifest(what="specimen", when=when, profile_toml=toml, details=details)
    with BundleWriter(folder, manifest) as writer:
        writer.append("capture", block)
        writer.append("transducer", transducer)
        writer.finish(certificate={"complete": True, "measurements": {}})
    return folder


def _assessed(folder: Path, serial: str = "7", **stated: Any) -> Assessment:
    return assess_bundle(Bundle.open(_bundle(folder, toml=SENSORS.format(serial=serial), **stated)))


def _U(result: Assessment, name: str) -> float:
    uncertainty = result.found[name].uncertainty
    assert uncertainty is not None
    return uncertainty.expanded


def _mean(value: float, uncertainty: Uncertainty) -> Measurement:
    sensed = Sensitivities.of_mean("torque", value)
    return Measurement("torque_mean", value, "Nm", "", uncertainty=uncertainty, sensitivities=sensed)


def test_a_recording_is_measured_with_the_sensors_of_the_profile_that_it_carries(tmp_path: Path) -> None:
    without = assess_bundle(Bundle.open(_bundle(tmp_path / "without")))
    stated = _assessed(tmp_path / "stated")
    assert _U(without, "current_fundamental") < 2e-4
    assert _U(stated, "current_fundamental") == pytest.approx(1.96 * 0.0025, rel=0.01)
    assert _U(stated, "torque_mean") == pytest.approx(1.96 * 0.005, rel=0.02)
    assert _U(stated, "current_thd_f") == pytest.approx(_U(without, "current_thd_f"))
    assert _U(stated, "fundamental_frequency") == pytest.approx(1.96 * 50.0 * 1e-4 / math.sqrt(3.0), rel=0.01)
    for name, value in {each.name: each.value for each in without.measurements}.items():
        assert stated.found[name].value == pytest.approx(value, nan_ok=True), name
    # what is measured again
    assert _U(stated, "torque_residual_mean") > 2.0 * _U(without, "torque_residual_mean")
    assert _U(stated, "current_unbalance_percent") > 1.96 * 0.25 / 3.0
    assert without.found["torque_mean"].basis.sensors == (UNSTATED,)
    assert stated.found["flux_ripple_pp"].basis.sensors == (UNSTATED,)
    assert stated.found["torque_mean"].basis.sensors == ()


def test_a_guard_band_takes_the_sensors_in(tmp_path: Path) -> None:
    limits = {"current_fundamental": {"max": 1.002, "margin": "U"}}
    without = assess_bundle(Bundle.open(_bundle(tmp_path / "without", limits=limits)))
    assert without.verdicts["current_fundamental"] is Verdict.PASS
    stated = _assessed(tmp_path / "stated", limits=limits)
    assert stated.verdicts["current_fundamental"] is Verdict.UNDECIDED
    assert (stated.judged["current_fundamental"].conformance or 1.0) < 0.9


def test_runs_on_one_bench_differ_by_what_their_sensors_do_not_share(tmp_path: Path) -> None:
    one = _assessed(tmp_path / "one")
    same, other = _assessed(tmp_path / "same"), _assessed(tmp_path / "other", serial="8")
    for name in ("current_fundamental", "torque_mean", "torque_residual_mean"):
        (here,) = [each for each in deltas(one, same) if each.name == name]
        (there,) = [each for each in deltas(one, other) if each.name == name]
        assert here.uncertainty is not None
        assert there.uncertainty is not None
        own = next(each for each in (one.found[name].uncertainty,) if each is not None)
        statistical = own.without([line for line in own.budget if line.instrument is not None])
        assert here.uncertainty.standard == pytest.approx(math.sqrt(2.0) * statistical.standard)
        assert there.uncertainty.standard > 5.0 * here.uncertainty.standard or name == "torque_residual_mean"
        assert there.uncertainty.standard > here.uncertainty.standard


def test_a_step_knows_the_gain_of_its_signal() -> None:
    """Where the signal crosses a level depends on it, which no rule of homogeneity tells."""
    plan = {
        "title": "step",
        "profile": "zhu2011",
        "operating_point": {"mode": "torque", "torque_Nm": 1.0, "hold_speed_rad_s": 10.0},
        "record": {"duration_s": 0.04, "channels": ["torque", "torque_reference"]},
        "analyses": {"steady": False, "step": True},
    }
    block = step_capture()

    def assessed(bench: Bench) -> Assessment:
        calibration = Calibration(bench)
        return assess(
            Plan.model_validate(plan), "", EXAMPLE_MOTOR, Path(), block, None, calibration=calibration
        )

    sensor = Sensor(gain_U_percent=4.0)
    without, stated = assessed(Bench()), assessed(Bench(channels={"torque": sensor}))
    plateau = stated.found["plateau_mean"].uncertainty
    assert plateau is not None
    (line,) = [each for each in plateau.budget if each.instrument is not None]
    assert line.standard == pytest.approx(0.02, rel=0.1)
    # 1 - exp(-0.05 n) reaches 98 % at n = 78; with 2 % less it is far later
    assert _U(stated, "reach_time") > 5.0 * _U(without, "reach_time")


def test_the_mean_of_repetitions_shares_the_sensors() -> None:
    bench = Bench(channels={"torque": Sensor(serial_number="7", gain_U_percent=2.0)})
    plan = Plan.model_validate(
        {
            "title": "x",
            "profile": "zhu2011",
            "repetitions": 4,
            "judge": "mean",
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.3, "channels": ["torque"]},
            "limits": {"torque_mean": {"max": 1.01, "margin": "U"}},
        }
    )
    values = (0.999, 1.001, 1.002, 0.998)
    measured = {
        f"{number}": Instruments(bench).applied([_mean(value, Uncertainty(1e-3, "scatter", 9.0))])
        for number, value in enumerate(values, start=1)
    }
    ((_, (together,)),) = over_repetitions(plan, _named(plan, measured)).items()
    assert together.uncertainty is not None
    assert together.uncertainty.experimental == pytest.approx(math.hypot(together.standard_uncertainty, 0.01))
    assert together.judged is not None
    assert together.judged.verdict is Verdict.UNDECIDED


def _named(plan: Plan, measured: dict[str, Any]) -> dict[str, Any]:
    from benchtool.plan.cases import cases

    return dict(zip((case.name for case in cases(plan)), measured.values(), strict=True))


# --- due ------------------------------------------------------------------------------------------------


def test_a_calibration_that_was_due_is_told_by_the_day_of_the_run(tmp_path: Path) -> None:
    assert _assessed(tmp_path / "on").overdue == ()
    late = _assessed(tmp_path / "late", when=LATE)
    assert [str(each) for each in late.overdue] == [
        "calibration of torque (estimate, no. 7, certificate C-17) was due on 2026-03-01, "
        "2 days before this run"
    ]
    assert late.to_json()["overdue"][0]["due"] == "2026-03-01"
    assert late.verdict == _assessed(tmp_path / "again").verdict


def test_it_stands_on_stderr_and_beside_the_verdict(tmp_path: Path) -> None:
    limits = {"torque_mean": {"max": 2.0}}
    _bundle(tmp_path / "late", toml=SENSORS.format(serial="7"), when=LATE, limits=limits)
    result = CliRunner().invoke(app, ["analyze", str(tmp_path / "late")])
    assert "warning: calibration of torque" in result.stderr
    assert "(calibration overdue: torque)" in result.stdout


def test_a_report_shows_sensors_and_what_was_due(tmp_path: Path) -> None:
    late = _assessed(tmp_path / "late", when=LATE)
    texts = [item.text for item in remarks(late) if isinstance(item, Text)]
    assert texts[0].startswith("Overdue: calibration of torque (estimate, no. 7, certificate C-17) was due")
    budgets = budgets_section([late.found["current_fundamental"]])
    assert budgets is not None
    grid, *_ = budgets.items
    assert isinstance(grid, Grid)
    named = [row[2].text for row in grid.rows]
    assert "gain of i_a (LEM IT 60-S, no. 7, certificate C-18); U = 0.5 %, k = 2" in named
    assert any(UNSTATED in each for each in measurement_notes(late.found["flux_ripple_pp"]))


def test_without_a_bench_the_command_says_what_is_missing(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["analyze", str(_bundle(tmp_path / "run"))])
    assert UNSTATED in result.stdout
    assert "overdue" not in result.stdout


@pytest.mark.parametrize("toml", ["", "not toml", *at_length("title = 'ψ'\n", "[bench]\n")])
def test_a_bundle_without_sensors_is_read_as_before(tmp_path: Path, toml: str) -> None:
    found = Calibration.of(Manifest(what="x", when=ON, profile_toml=toml))
    assert not found.bench.channels
    assert found.on in (date(2026, 2, 28), None)
    assert assess_bundle(Bundle.open(_bundle(tmp_path / "run", toml=toml))).overdue == ()


def test_a_bench_that_this_version_does_not_understand_is_not_left_out_silently() -> None:
    toml = "[bench.channels.i_a]\nlinearity_percent = 0.1\n"
    with pytest.raises(AnalysisError, match="linearity_percent"):
        Calibration.of(Manifest(what="x", when=ON, profile_toml=toml))


def test_a_wall_time_without_a_date_judges_no_certificate() -> None:
    bench = Bench(channels={"i_a": Sensor(due=date(2000, 1, 1))})
    assert Calibration.at(bench, "yesterday").overdue(["i_a"]) == ()
    assert [each.channel for each in Calibration.at(bench, ON).overdue(["i_a", "i_b"])] == ["i_a"]
    assert Calibration.at(bench, ON).overdue(["i_b"]) == ()


def test_a_clock_that_is_overdue_is_named() -> None:
    bench = Bench(clock=ReferenceClock(tolerance_ppm=5.0, due=date(2026, 1, 31)))
    (found,) = Calibration.at(bench, ON).overdue([])
    assert found.channel == CLOCK
    assert found.to_json()["due"] == "2026-01-31"


def test_a_limit_is_judged_with_what_the_sensors_add() -> None:
    bench = Bench(channels={"torque": Sensor(gain_U_percent=2.0)})
    plain = _mean(1.0, Uncertainty(1e-4, "scatter"))
    (stated,) = Instruments(bench).applied([plain])
    limit = Limit(max=1.005, margin="U")
    assert limit.judge(plain.value, plain.uncertainty) is Verdict.PASS
    assert limit.judge(stated.value, stated.uncertainty) is Verdict.UNDECIDED
    assert replace(stated, uncertainty=plain.uncertainty) == plain
