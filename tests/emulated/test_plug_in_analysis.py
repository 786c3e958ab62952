"""An analysis of another package: in the plan, the results, the figures, the report and `analyze`."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.analysis.catalogue import catalogue
from benchtool.cli import app
from benchtool.errors import PlugInError
from benchtool.recording import Bundle

from .shaft_power import MODULE, install

PLAN = """title = "Power at the shaft"
profile = "zhu2011"
{figure}
[operating_point]
omega_m_rad_s = 31.42
load_torque_Nm = 0.65
settle_s = 0.4
[sweep.setup]
law = ["tpc", "foc"]
[record]
duration_s = 0.05
channels = ["torque", "omega_m"]
[analyses]
{analyses}
[limits]
{limits}
"""

Installer = Callable[..., Path]


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Installer]:
    """Installs the package, as it is or altered; it is gone with the test."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)

    def put(was: str = "", now: str = "", **alterations: str) -> Path:
        assert was in MODULE
        install(folder, MODULE.replace(was, now) if was else MODULE, **alterations)
        catalogue.cache_clear()
        return folder

    catalogue.cache_clear()
    yield put
    sys.modules.pop("shaft_power_analysis", None)
    catalogue.cache_clear()


def _invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(each) for each in arguments])


def _plan(folder: Path, analyses: str = "", limits: str = "", figure: str = "") -> Path:
    path = folder / "power.toml"
    path.write_text(PLAN.format(analyses=analyses, limits=limits, figure=figure), encoding="utf-8")
    return path


def test_it_is_measured_limited_drawn_reported_and_listed(installed: Installer, tmp_path: Path) -> None:
    installed()
    limit = "shaft_power_mean_W = { min = 15.0, max = 25.0 }"
    plan, run = _plan(tmp_path, limits=limit, figure='figure = "shaft_power"'), tmp_path / "run"
    result = _invoke("run", plan, "--out", run, "--json")
    assert result.exit_code == 0, result.output
    cases = json.loads(result.stdout)["cases"]
    for law in ("tpc", "foc"):
        measured = cases[law]["measurements"]["shaft_power_mean"]
        capture = Bundle.open(run / law).block("capture")
        mean_W = float(np.mean(capture.column("torque") * capture.column("omega_m")))
        assert (measured["value"], measured["unit"]) == (pytest.approx(mean_W), "W")
        assert cases[law]["limits"]["shaft_power_mean"]["verdict"] == "pass"

    again = json.loads(_invoke("analyze", run, "--json").stdout)["cases"]
    assert again["tpc"]["measurements"] == cases["tpc"]["measurements"]
    reported = _invoke("report", run, "--png", "--json")
    assert reported.exit_code == 0
    drawn = [run / "tpc/plots/shaft_power.png", run / "foc/plots/shaft_power.png", run / "plots/cases.png"]
    assert {str(path) for path in drawn} <= set(json.loads(reported.stdout)["pictures"])
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)
    (page,) = run.glob("*.html")
    text = page.read_text(encoding="utf-8")
    assert "shaft_power_mean" in text
    assert "Mechanical power at every row." in text

    listed = json.loads(_invoke("analyze", "--list", "--json").stdout)["analyses"]
    assert listed["shaft_power"]["source"] == "package 'shaft-power' 1.2"
    assert listed["shaft_power"]["measurements"] == [
        {"name": "shaft_power_mean", "unit": "W", "definition": "mean of torque x omega_m"}
    ]


@pytest.mark.parametrize(
    ("analyses", "limits", "line", "complaint"),
    [
        ("shaft_power = false", "shaft_power_mean = { min = 1.0 }", "shaft_power_mean", "shaft_power = true"),
        ("", "shaft_power_maen = { min = 1.0 }", "shaft_power_maen", "did you mean 'shaft_power_mean'?"),
        ("", "shaft_power_mean_kW = { min = 1.0 }", "shaft_power_mean_kW", "is in W: convert it"),
        ("", 'shaft_power_mean = { min = 1.0, unit = "kW" }', "shaft_power_mean", "is in kW, that is in W"),
        (
            'shaft_power.torqe = "torque"',
            "torque_mean = { min = 0 }",
            "shaft_power.t",
            "did you mean 'torque'?",
        ),
        (
            'shaft_power.torque = "i_q"',
            "torque_mean = { min = 0 }",
            "shaft_power.t",
            "torque is 'i_q', which",
        ),
    ],
)
def test_what_a_plan_says_of_it_is_checked_by_line(
    installed: Installer, tmp_path: Path, analyses: str, limits: str, line: str, complaint: str
) -> None:
    installed()
    plan = _plan(tmp_path, analyses, limits)
    result = _invoke("run", plan, "--out", tmp_path / "run")
    assert result.exit_code == 2
    number = 1 + plan.read_text(encoding="utf-8").partition(f"\n{line}")[0].count("\n") + 1
    assert f"power.toml, line {number}: " in result.stderr
    assert complaint in result.stderr
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("was", "now", "complaint"),
    [
        ("import numpy as np", "import no_such_module", "cannot be loaded: ModuleNotFoundError: No module"),
        ("import numpy as np", "raise SystemExit(7)", "cannot be loaded: SystemExit: 7"),
        (
            "SHAFT_POWER = Analysis",
            "SHAFT_POWER = dict",
            "is of type dict, benchtool.analysis.",
        ),
        ("SHAFT_POWER = Analysis", "SHAFTPOWER = Analysis", "cannot be loaded: AttributeError"),
        ('name="shaft_power"', 'name="steady"', "is a key of [analyses] already"),
        ('name="shaft_power"', 'name="step"', "is called as one of benchtool"),
        ('("shaft_power_mean",)', '("torque_mean",)', "measures 'torque_mean' as 'torque_ripple'"),
        ('Drawing("shaft_power"', 'Drawing("bode"', "has figure 'bode' as 'frequency_response'"),
        (", draw=draw)", ")", "its figure 'shaft_power' has no draw"),
        ('torque: str = "torque"', "torque: str", "cannot be used: ValidationError"),
        ('quantities=(Quantity(("shaft_power_mean",)', 'quantities=() and (Quantity(("x",)', "declares no"),
    ],
)
def test_one_that_cannot_be_used_is_one_clear_error(
    installed: Installer, was: str, now: str, complaint: str
) -> None:
    installed(was, now)
    result = _invoke("analyze", "--list")
    assert result.exit_code == 3
    assert isinstance(result.exception, SystemExit)
    (line,) = (each for each in result.stderr.splitlines() if each)
    assert "shaft_power" in line or "'steady'" in line or "'step'" in line
    assert "package 'shaft-power' 1.2" in line
    assert complaint in line


@pytest.mark.parametrize(
    ("was", "now", "complaint"),
    [
        ("np.mean(power_W)", "power_W[10**9]", "cannot measure: IndexError: index 1000000000 is"),
        ("Findings((mean,), result=power_W)", "(mean, power_W)", "returns tuple, Findings are expected"),
        ('Measurement("shaft_power_mean"', 'Measurement("x"', "it measures 'x' and does not declare that"),
        ('"W", text', '"kW", text', "'shaft_power_mean' is in 'kW', declared is 'W'"),
    ],
)
def test_one_that_fails_at_work_is_one_clear_error_and_the_recording_stays(
    installed: Installer, tmp_path: Path, was: str, now: str, complaint: str
) -> None:
    installed(was, now)
    plan = _plan(tmp_path, "shaft_power = true")
    result = _invoke("run", plan, "--out", tmp_path / "run")
    assert result.exit_code == 3, result.output
    assert "Traceback" not in result.output
    assert complaint in result.stderr
    assert "analysis 'shaft_power' of package 'shaft-power' 1.2 cannot" in result.stderr
    assert len(Bundle.open(tmp_path / "run" / "tpc").block("capture").data) == 500


@pytest.mark.parametrize("option", [(), ("--png",)])
def test_a_figure_that_cannot_be_drawn_fails_the_report_and_not_the_run(
    installed: Installer, tmp_path: Path, option: tuple[str, ...]
) -> None:
    installed("axes = figure.subplots()", "axes = figure.axes[3]")
    run = tmp_path / "run"
    assert _invoke("run", _plan(tmp_path, "shaft_power = true"), "--out", run).exit_code == 0
    result = _invoke("report", run, *option)
    assert result.exit_code == 3, result.output
    assert "cannot draw 'shaft_power': IndexError" in result.stderr


def test_a_bundle_says_which_analysis_is_not_installed(
    installed: Installer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = installed()
    run = tmp_path / "run"
    assert _invoke("run", _plan(tmp_path, "shaft_power = true"), "--out", run).exit_code == 0
    monkeypatch.setattr(sys, "path", [each for each in sys.path if each != str(folder)])
    catalogue.cache_clear()
    result = _invoke("analyze", run / "tpc")
    assert result.exit_code == 2
    assert "analyses.shaft_power" in result.stderr
    assert "unknown key" in result.stderr
    with pytest.raises(PlugInError, match="cannot be loaded"):
        install_broken(folder, monkeypatch)


def install_broken(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Back on the path, without its module."""
    (folder / "shaft_power_analysis.py").unlink()
    sys.modules.pop("shaft_power_analysis", None)
    monkeypatch.syspath_prepend(folder)
    catalogue.cache_clear()
    catalogue()
