"""The figures of Zhu, Xiao and Li (2011) as the shipped plans, over the wire, and what they have to show."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.plan.model import load_plan, plan_names

Measured = dict[str, dict[str, Any]]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Runs a plan once, and gives the values of its cases."""

    @cache
    def run(plan: str) -> Measured:
        folder = Path(mkdtemp(dir=tmp_path_factory.getbasetemp())) / "run"
        result = CliRunner().invoke(app, ["run", f"zhu2011/{plan}", "--json", "--out", str(folder)])
        assert result.exit_code in (0, 1), result.output
        cases = json.loads(result.stdout)["cases"]
        return {
            case: {name: each["value"] for name, each in content["measurements"].items()}
            for case, content in cases.items()
        }

    return run


def test_every_shipped_plan_is_valid() -> None:
    names = plan_names("zhu2011")
    assert {f"zhu2011/fig{number}" for number in (4, 5, 6, 7, 8)} <= set(names)
    for name in names:
        load_plan(name)


@pytest.mark.slow
def test_fig_4_the_earlier_tpc_has_at_least_three_times_the_ripple(measured: Any) -> None:
    cases = measured("fig4")
    assert cases["tpc_stator"]["torque_ripple_pp"] >= 3.0 * cases["tpc"]["torque_ripple_pp"]
    assert cases["literal,tpc_stator"]["torque_ripple_pp"] >= 3.0 * cases["literal,tpc"]["torque_ripple_pp"]
    assert cases["tpc"]["torque_mean"] == pytest.approx(3.0, abs=0.02)
    for case in ("tpc", "literal,tpc"):  # the ripple of the earlier TPC hides when it arrives
        assert cases[case]["reach_time"] <= 1e-3
    for each in cases.values():  # the speed controller moves the reference after the step
        assert each["overshoot"] <= each["torque_ripple_pp"]


def test_fig_5_the_torque_step(measured: Any) -> None:
    cases = measured("fig5")
    assert set(cases) == {"svm_dtc", "tpc", "literal,svm_dtc", "literal,tpc"}
    assert cases["tpc"]["reach_time"] <= 1.2e-3
    # As the drive sees it both are at the converter's resolution; from one peak to the other the scatter over
    # seeds is 10 %, more than what is between them.
    assert cases["tpc"]["torque_ripple_rms"] == pytest.approx(cases["svm_dtc"]["torque_ripple_rms"], rel=0.1)
    assert cases["tpc"]["torque_ripple_pp"] == pytest.approx(cases["svm_dtc"]["torque_ripple_pp"], rel=0.3)
    assert cases["literal,tpc"]["torque_ripple_pp"] > 2.0 * cases["svm_dtc"]["torque_ripple_pp"]
    assert cases["tpc"]["transducer_torque_ripple_pp"] > 2.0 * cases["svm_dtc"]["transducer_torque_ripple_pp"]
    assert cases["tpc"]["overshoot"] <= 0.1


def test_fig_6_and_7_steady_state(measured: Any) -> None:
    cases = measured("fig6")
    assert cases["tpc"]["torque_ripple_pp"] <= 0.06
    assert cases["tpc_stator"]["torque_ripple_pp"] > cases["tpc"]["torque_ripple_pp"]
    assert cases["tpc"]["current_max_low_harmonic"] <= 0.007


def test_fig_8_the_torque_holds_its_limit_and_falls_without_undershoot(measured: Any) -> None:
    for case in measured("fig8").values():
        assert case["overshoot"] <= 0.1
        assert case["undershoot"] <= 0.2
        assert case["plateau_mean"] == pytest.approx(1.0, abs=0.01)
        assert case["plateau_min"] >= 0.95


@pytest.mark.slow
def test_fig_7_the_letter_has_the_papers_order_and_the_improvements_turn_it_round(measured: Any) -> None:
    cases = measured("fig7")
    component = {case: content["current_max_low_harmonic"] for case, content in cases.items()}
    assert component["literal,tpc"] <= 0.007
    assert component["literal,tpc_stator"] >= 3.0 * component["literal,tpc"]
    assert component["tpc_stator"] < component["tpc"] <= 0.007


@pytest.mark.slow
def test_deadbeat_beats_tpc_in_the_same_run(measured: Any) -> None:
    cases = measured("laws")
    assert len(cases) == 7
    deadbeat, tpc = cases["deadbeat"], cases["tpc"]
    assert cases["foc"]["reach_time"] > 2.0 * tpc["reach_time"]
    assert deadbeat["transducer_torque_ripple_pp"] <= 0.5 * tpc["transducer_torque_ripple_pp"]
    assert deadbeat["flux_ripple_pp"] <= 0.1 * tpc["flux_ripple_pp"]
