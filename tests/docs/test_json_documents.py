"""What commands print with `--json` is what the reference says: every key listed, every type right."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.shipped import shipped
from docs.generate.json_documents import DOCUMENTS
from docs.generate.json_results import Run

EDS = str(shipped("firmware_protocol") / "drive.eds")
CSV = "t,torque\n" + "".join(f"{row / 1000},{1 + 0.1 * (row % 7)}\n" for row in range(600))
PLAN = """
title = "short"
profile = "zhu2011"
repetitions = 2
operating_point = { omega_m_rad_s = 15.71, load_torque_Nm = 0.65, settle_s = 0.2 }
record = { duration_s = 0.03, channels = ["torque"] }
limits = { torque_ripple_pp = { max = 0.1 } }
"""
COMMANDS = {
    "run of a folder": ("run", "plans", "--out", "folder"),
    "run --dry-run": ("run", "plans/one.toml", "--dry-run"),
    "plans": ("plans",),
    "profiles": ("profiles",),
    "profile new": ("profile", "new", "new.toml"),
    "plan new": ("plan", "new", "ripple.toml", "--profile", "new.toml"),
    "params derive": ("params", "derive", "--profile", "new.toml"),
    "analyze": ("analyze", "folder/one"),
    "analyze --csv": ("analyze", "--csv", "table.csv", "--time", "t", "--torque", "torque"),
    "analyze --list": ("analyze", "--list"),
    "compare": ("compare", "folder/one", "folder/one"),
    "report": ("report", "folder/one"),
    "record": ("record", "--duration", "0.2", "--out", "recorded"),
    "analyze of a recording": ("analyze", "recorded"),
    "export": ("export", "recorded"),
    "commission": ("commission", "offsets", "--yes"),
    "commission --dry-run": ("commission", "--dry-run"),
    "jog": ("jog", "--duration", "0.1", "--speed", "1"),
    "verify": ("verify", "folder/one"),
    "gauge": ("gauge", "readings.csv"),
    "acceptance": ("acceptance", "--only", "test_periods", "--out", "session"),
    "acceptance --mutants": ("acceptance", "--mutants", "--mutant", "captures_not_counted", "--clean", "0"),
    "info": ("info",),
    "info --eds": ("info", "--eds", EDS),
    "reset": ("reset",),
    "doctor": ("doctor",),
    "params list": ("params", "list"),
    "params get": ("params", "get", "statusword", "law"),
    "params set": ("params", "set", "u_s=80"),
    "params dump": ("params", "dump", "motor.toml"),
    "params diff": ("params", "diff", "motor.toml"),
    "params load": ("params", "load", "motor.toml"),
    "params save": ("params", "save"),
    "params restore": ("params", "restore"),
}
ELSEWHERE = {"completion install", "demo", "run", "live", "live of a run", "emulate", "scan", "twin"}
"""`demo` and `run` print what `analyze` does; `completion` writes into the home folder; tests/emulated tries
what needs a viewer, a second process or an excited machine."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("documents")
    (place / "plans").mkdir()
    (place / "plans" / "one.toml").write_text(PLAN, encoding="utf-8")
    (place / "table.csv").write_text(CSV, encoding="utf-8")
    (place / "readings.csv").write_text("part,value\n1,1\n1,2\n2,3\n2,4\n", encoding="utf-8")
    return place


def test_every_document_is_tried() -> None:
    assert set(COMMANDS) | ELSEWHERE == set(DOCUMENTS)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_document_of(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    result = CliRunner().invoke(app, [*COMMANDS[name], "--json"])
    assert result.exit_code in (0, 1), result.output
    DOCUMENTS[name].model_validate(json.loads(result.stdout))


def test_a_key_that_is_not_listed_is_told() -> None:
    document: dict[str, Any] = {"verdict": "pass", "verdict_by_transducer": None, "cases": {}}
    Run.model_validate(document)
    with pytest.raises(ValidationError, match="novel"):
        Run.model_validate({**document, "novel": 1})
    with pytest.raises(ValidationError, match="cases"):
        Run.model_validate({key: value for key, value in document.items() if key != "cases"})
