"""The shipped suite: it passes on sound drives and finds mutants; the whole of it is a command."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from benchtool.acceptance import Trial, conduct_campaign, run_trial
from benchtool.acceptance.scores import shipped_score, suite_hash
from benchtool.cli import app
from benchtool.emulator.mutants import MUTANTS
from benchtool.errors import UsageError
from benchtool.profile import load_profile


def test_a_sound_drive_passes() -> None:
    trial = run_trial(Trial("zhu2011", "", 3), only="test_fault or silent_host")
    assert trial.ran == 8
    assert trial.found == ()


@pytest.mark.parametrize(
    ("mutant", "by"),
    [
        ("phase_gain", "test_phases_are_alike"),
        ("watchdog_sleeps", "test_silent_host"),
        ("save_drops_a_key", "test_saved_parameters_survive_a_reset"),
        ("loss_coasts", "test_quick_stop_on_loss"),
        ("i2t_tau_doubled", "test_overload"),
    ],
)
def test_a_mutant_is_found(mutant: str, by: str) -> None:
    trial = run_trial(Trial("zhu2011", mutant, 3), only=by.partition("[")[0])
    assert [name.partition("::")[2] for name, _ in trial.found] == [by]


def test_mutants_are_forty_at_least_and_leave_nothing_behind() -> None:
    names = [each.name for each in MUTANTS]
    assert len(set(names)) == len(names) >= 40
    parts = {(part.owner, part.name) for each in MUTANTS for part in each.substitutions}
    before = {part: getattr(*part) for part in parts}
    for each in MUTANTS:
        assert each.substitutions or each.alter(load_profile("zhu2011")), each.name
        with each.applied():
            changed = [part for part in parts if getattr(*part) is not before[part]]
            assert len(changed) == len(each.substitutions)
    assert {part: getattr(*part) for part in parts} == before


def test_an_unknown_mutant_is_refused() -> None:
    with pytest.raises(UsageError, match="no mutant nonsense: the mutants are phase_gain"):
        conduct_campaign(["zhu2011"], clean=0, jobs=1, tell=lambda *_: None, chosen=["nonsense"])


def test_what_is_interrupted_ends_the_campaign(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a KeyboardInterrupt pytest makes an exit code."""

    def interrupted(*_: object, **__: object) -> tuple[int, None]:
        tried.append(1)
        return int(pytest.ExitCode.INTERRUPTED), None

    tried: list[int] = []
    monkeypatch.setattr("benchtool.acceptance.campaign.run_suite", interrupted)
    with pytest.raises(KeyboardInterrupt):
        conduct_campaign(["zhu2011"], clean=3, jobs=1, tell=lambda *_: None)
    assert tried == [1]


def test_the_shipped_score_is_that_of_a_good_suite() -> None:
    score = shipped_score()
    assert score is not None
    assert score.caught >= 0.95 * score.mutants
    assert score.mutants >= 40
    assert score.false_failures == 0
    assert len(suite_hash()) == len(score.of) == 16


def test_the_verb_prints_one_document(tmp_path: pytest.TempPathFactory) -> None:
    words = ["acceptance", "--profile", "zhu2011", "--only", "test_periods or overload", "--json"]
    told = CliRunner().invoke(app, [*words, "--out", str(tmp_path)])
    assert told.exit_code == 0, told.output
    document = json.loads(told.stdout)
    assert document["verdict"] == "pass"
    assert document["counts"] == {"passed": 2, "waived": 0, "not run": 0, "failed": 0, "error": 0}


def test_the_verb_tries_the_suite() -> None:
    words = ["acceptance", "--mutants", "--mutant", "emcy_missing", "--clean", "0", "--json"]
    told = CliRunner().invoke(app, words)
    assert told.exit_code == 0, told.output
    document = json.loads(told.stdout)
    assert document["score"]["caught"] == document["score"]["mutants"] == 1
    assert document["mutants"]["emcy_missing"]["by"] == ["test_faults::test_fault[overcurrent]"]
