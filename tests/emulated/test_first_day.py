"""A newcomer's first day: a profile for a new motor, a plan, a run, and typing errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.plan.model import load_plan
from benchtool.profile import load_profile
from benchtool.recording import Bundle

GIMBAL = (
    *("--pole-pairs", "7", "--R-s", "10.58ohm:ll", "--L", "2.1mH:ll", "--Kv", "131.2rpm/V:ll-peak"),
    *("--J", "20gcm2", "--u-dc", "24V", "--i-rated", "0.5A:peak"),
)


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments: str) -> Result:
        return CliRunner().invoke(app, arguments)  # type: ignore[return-value]

    return invoke


def test_a_gimbal_motor_of_ones_own_runs_at_once(invoke: Callable[..., Result], tmp_path: Path) -> None:
    (tmp_path / "motors").mkdir()
    assert invoke("profile", "new", "motors/gimbal.toml", *GIMBAL).exit_code == 0
    motor = load_profile("motors/gimbal.toml").motor
    assert motor.psi_r_Wb == pytest.approx(6.0e-3, rel=1e-3)
    assert motor.R_s_ohm == pytest.approx(5.29)
    assert invoke("plan", "new", "ripple.toml", "--profile", "motors/gimbal.toml").exit_code == 0
    assert load_plan("ripple.toml").profile == "motors/gimbal.toml"
    ran = invoke("run", "ripple.toml", "--set", "omega_m=500rpm", "--out", "run", "--json")
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["verdict"] == "pass"
    manifest = Bundle.open(tmp_path / "run").manifest
    assert manifest.details["plan"]["operating_point"]["omega_m_rad_s"] == pytest.approx(52.3599, rel=1e-5)
    again = invoke("run", "ripple.toml", "--out", "run", "--json")
    assert again.exit_code == 3, "what is there is not overwritten"
    for command in (("profile", "new", "motors/gimbal.toml", *GIMBAL), ("plan", "new", "ripple.toml")):
        refused = invoke(*command)
        assert refused.exit_code == 2
        assert "exists: give another name, or --force" in refused.stderr


def test_templates_load_as_they_stand(invoke: Callable[..., Result]) -> None:
    for kind, load in (("profile", load_profile), ("plan", load_plan)):
        shown = invoke(kind, "new").stdout
        Path(f"{kind}.toml").write_text(shown, encoding="utf-8")
        load(f"{kind}.toml")
        assert shown.count("#") > 30


def test_a_nameplate_is_never_guessed_and_all_that_is_missing_is_told(invoke: Callable[..., Result]) -> None:
    answer = invoke(
        "profile", "new", "--pole-pairs", "7", "--R-s", "0.1ohm", "--Kv", "300rpm/V", "--i-rated", "5A"
    )
    assert answer.exit_code == 2
    for told in (
        "--R-s 0.1ohm: between what it was measured? write 0.1ohm:phase or 0.1ohm:ll",
        "--Kv 300rpm/V: per which volt, hobby motors state ll-peak? write 300rpm/V:ll-peak or ",
        "--i-rated 5A: of which amplitude? write 5A:peak or 5A:rms",
        "--L is missing (or --L-d and --L-q): --L 100uH:ll",
        "--J is missing: --J ",
        "--u-dc is missing: --u-dc 24V",
    ):
        assert f"benchtool: {told}" in answer.stderr
    for arguments, told in (
        (("--Kt", "1Nm/A:rms"), "--Kv and --Kt state one flux: give one of them"),
        (("--L-d", "1mH"), "--L and --L-d: give --L, or --L-d and --L-q"),
        (("--J", "1kg"), "--J = '1kg': a value in kgm2 (or gm2, kgcm2, gcm2, ...) is expected"),
        (("--J", "0kgm2"), "--J 0kgm2: a value above 0 is expected"),
        (("--J", "1kgm2:rms"), "--J 1kgm2:rms: no ':rms' is expected here"),
        (("--pole-pairs", "7.5"), "--pole-pairs 7.5: a whole number from 1 to 50 is expected"),
        (("--law", "fok"), "--law fok: did you mean 'foc'?"),
    ):
        answer = invoke("profile", "new", *GIMBAL, *arguments)
        assert answer.exit_code == 2
        assert told in answer.stderr


def test_a_dry_run_opens_nothing(invoke: Callable[..., Result], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a session was opened")

    monkeypatch.setattr("benchtool.cli.run_plans.open_session", refuse)
    link = ("--link", "can:socketcan:nowhere")
    answer = invoke("run", "zhu2011/laws", "--dry-run", "--json", "--set", "torque=0.1Nm", *link)
    assert answer.exit_code == 0, answer.output
    (plan,) = json.loads(answer.stdout)["plans"].values()
    assert [each["name"] for each in plan["cases"]][:2] == ["tpc", "tpc_stator"]
    assert plan["cases"][0]["operating_point"]["torque_Nm"] == 0.1
    assert plan["played"] == "constant of torque, amplitude 0.65 Nm, 0.7 s"
    assert plan["recorded"] == "12 channels for 0.58 s, 5800 rows at 10000 Hz"
    assert "nothing was opened or sent" in answer.stderr
    assert not list(Path().iterdir())
    refused = invoke("run", "zhu2011/laws", "--dry-run", "--set", "torque=100Nm")
    assert refused.exit_code == 2
    assert refused.stderr.splitlines()[-1] == "benchtool: with --set torque=100Nm"


def test_plans_are_listed_with_what_they_measure(invoke: Callable[..., Result]) -> None:
    listed = invoke("plans").stdout.splitlines()
    assert len(listed) == 16
    assert [each for each in listed if each.startswith("zhu2011/load ") and "49 cases, 2 min" in each]
    invoke("plan", "new", "own.toml")
    Path("bad.toml").write_text("titel = 3", encoding="utf-8")
    own = invoke("plans", ".")
    assert own.exit_code == 0
    assert own.stdout.startswith("own.toml  1 case, ")
    assert "no plan: bad.toml, line 1: unknown key 'titel'" in own.stderr


@pytest.mark.parametrize("words", [(), ("params",), ("run",), ("profile", "new")], ids=" ".join)
def test_every_verb_has_the_short_help_too(invoke: Callable[..., Result], words: tuple[str, ...]) -> None:
    assert invoke(*words, "-h").stdout == invoke(*words, "--help").stdout


def test_parameters_that_fit_the_motor_for_a_drive_that_has_its_defaults(
    invoke: Callable[..., Result],
) -> None:
    shown = invoke("params", "derive", "--json")
    assert shown.exit_code == 0
    told = json.loads(shown.stdout)["parameters"]
    assert told["u_s_V"]["value"] == pytest.approx(2.0 / 3.0 * 122.5, rel=1e-2)
    assert told["u_s_V"]["before"] == pytest.approx(81.65)
    written = invoke("params", "derive", "--write", "--u-dc", "100V", "--law", "foc", "--json")
    told = json.loads(written.stdout)["parameters"]
    assert (told["u_s_V"]["value"], told["law"]["value"]) == (pytest.approx(66.667, rel=1e-3), "foc")
    assert invoke("params", "derive", "--law", "fok").exit_code == 2
    restored = invoke("params", "restore", "--from-profile", "--json")
    assert json.loads(restored.stdout)["parameters"]["u_s"] == pytest.approx(81.65)


def test_a_plan_that_is_a_file_without_its_ending(invoke: Callable[..., Result]) -> None:
    invoke("plan", "new", "own.toml")
    answer = invoke("run", "own")
    assert answer.exit_code == 2
    assert "did you mean the file 'own.toml'?" in answer.stderr
