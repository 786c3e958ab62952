"""The verbs of the command line: listed without being loaded, loaded when used."""

from __future__ import annotations

import subprocess
import sys

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.cli.verbs import COMPLETION_VERBS, PARAMETER_VERBS, PLAN_VERBS, PROFILE_VERBS, VERBS, Verb

HEAVY = ("numpy", "pydantic", "can", "pyarrow", "scipy", "rerun", "matplotlib", "numba")
DRAWN_IN = ("scipy", "rerun", "matplotlib", "numba", "reportlab", "jinja2")


@pytest.mark.parametrize(
    "verb",
    [*VERBS, *PARAMETER_VERBS, *PROFILE_VERBS, *PLAN_VERBS, *COMPLETION_VERBS],
    ids=lambda verb: f"{verb.module}-{verb.name}",
)
def test_every_verb_loads_and_tells_its_own_help(verb: Verb) -> None:
    command = verb.load()
    assert command.name == verb.name
    assert command.help
    assert command.context_settings["help_option_names"] == ["-h", "--help"]


@pytest.mark.parametrize(
    ("arguments", "verbs"),
    [
        ((), VERBS),
        (("params",), PARAMETER_VERBS),
        (("profile",), PROFILE_VERBS),
        (("plan",), PLAN_VERBS),
        (("completion",), COMPLETION_VERBS),
    ],
)
def test_the_list_of_verbs_is_whole(arguments: tuple[str, ...], verbs: tuple[Verb, ...]) -> None:
    shown = CliRunner().invoke(app, [*arguments, "--help"]).output
    listed = shown.partition("Commands:")[2]
    for verb in verbs:
        assert f"  {verb.name}" in listed
        assert verb.help in listed, "shortened"


def test_help_loads_no_verb_and_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from typer.testing import CliRunner\n"
        "from benchtool.cli import app\n"
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0\n"
        f"print([name for name in {HEAVY} if name in sys.modules])\n"
        "print([name for name in sys.modules if name == 'benchtool.cli.run'])\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert found.splitlines() == ["[]", "[]"]


def test_verbs_of_every_day_load_nothing_that_their_numbers_may_do_without() -> None:
    code = (
        "import sys\n"
        "from benchtool.cli import analyze, compare, run_plans, verify\n"
        f"print([name for name in {DRAWN_IN} if name in sys.modules])\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert found == "[]\n"


@pytest.mark.parametrize(
    ("arguments", "suggestion"), [(["rnu"], "'run'"), (["params", "gte"], "'get'"), (["anlyze"], "'analyze'")]
)
def test_a_misspelt_verb_is_answered_with_the_one_that_is_meant(
    arguments: list[str], suggestion: str
) -> None:
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == 2
    assert f"Did you mean {suggestion}" in answer.output
