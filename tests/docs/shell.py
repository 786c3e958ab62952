"""Shell blocks: their commands, run in this process or parsed by the command line that they are for."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import typer
from typer.testing import CliRunner

from benchtool.bench.wires.registry import parse
from benchtool.cli import app
from tests.docs.blocks import ROOT

BENCHTOOL: Final = re.compile(r"(\.venv/bin/|\S*\\Scripts\\)?benchtool(\.exe)?$")
OUTSIDE: Final = {
    *(
        "apt-get",
        "candump",
        "cansend",
        "cd",
        "dmesg",
        "gcc",
        "git",
        "groups",
        "ip",
        "jupyter",
        "ls",
        "lsusb",
        "make",
        "pytest",
    ),
    *("pip", "pipx", "python", "python3", "rerun", "slcand", "stty", "sudo", "usermod"),
    *(".venv/bin/pip", ".venv/bin/pre-commit", ".venv/bin/pytest", ".venv/bin/python"),
}
"""Programs other than benchtool that a block may name; they are not run."""

_EXIT_CODE: Final = re.compile(r"# *exit code (\d+)")


@dataclass(frozen=True)
class Command:
    """One command of a block and the exit code that its comment states."""

    words: tuple[str, ...]
    exit_code: int

    @property
    def is_benchtool(self) -> bool:
        """Whether it is benchtool's."""
        return bool(BENCHTOOL.match(self.words[0]))


def commands(text: str) -> Iterator[Command]:
    """The commands of a block: lines joined, `&&` and `|` taken apart; no comments, no redirections."""
    for line in text.replace("\\\n", " ").splitlines():
        stated = _EXIT_CODE.search(line)
        lexer = shlex.shlex(line, posix=True, punctuation_chars="&|;>")
        lexer.whitespace_split = True
        words: list[str] = []
        tokens = list(lexer)
        places = {place for place, word in enumerate(tokens) if word == ">"}
        for place, word in enumerate((*tokens, ";")):
            if {place, place - 1} & places:
                continue
            if set(word) <= set("&|;"):
                if words:
                    yield Command(tuple(words), int(stated[1]) if stated else 0)
                words = []
            else:
                words.append(word)


def require_parsed(words: tuple[str, ...]) -> None:
    """Check a command of benchtool against its options, without running it.

    Raises:
        Exception: of the command line's own: a verb, an option or a value that it does not know.
        UsageError: an address is none.
    """
    command: Any = typer.main.get_command(app)
    arguments = list(words)
    while hasattr(command, "list_commands") and arguments and not arguments[0].startswith("-"):
        name = arguments.pop(0)
        found = command.get_command(command.context_class(command), name)
        assert found is not None, f"no verb '{name}' in: benchtool {' '.join(words)}"
        command = found
    if arguments in (["--help"], ["--version"], ["-h"]):
        return
    context = command.make_context("benchtool", arguments)
    links = context.params.get("link")
    if isinstance(links, str):
        parse(links)


@cache
def _application() -> Any:
    return typer.main.get_command(app)


@cache
def _subcommand(command: Any, name: str) -> Any:
    """To make one takes typer a twentieth of a second, and pages name many. Nothing runs these."""
    return command.get_command(command.context_class(command), name)


@cache
def require_options(words: tuple[str, ...]) -> None:
    """Check that a command named in the text has that verb and its options; other words may stand for any."""
    command: Any = _application()
    rest = list(words)
    while hasattr(command, "list_commands") and rest and not rest[0].startswith("-"):
        name = rest.pop(0)
        found = _subcommand(command, name)
        assert found is not None, f"no verb '{name}' in: benchtool {' '.join(words)}"
        command = found
    parameters = command.get_params(command.context_class(command))
    known = {each for parameter in parameters for each in (*parameter.opts, *parameter.secondary_opts)}
    unknown = {word for word in rest if word.startswith("--")} - known
    assert not unknown, f"no {', '.join(sorted(unknown))} in: benchtool {' '.join(words)}"


def require_known(command: Command) -> None:
    """Check a command of another program as far as the tree can tell: modules and extras that it names."""
    program, *rest = command.words
    assert program in OUTSIDE, f"{program} is no program that tests/docs/shell.py knows"
    if rest[:1] == ["-m"] and rest[1] not in ("venv", "pip", "sphinx"):
        assert importlib.util.find_spec(rest[1]) is not None, f"no module {rest[1]}"
    known = extras()
    for extra in re.findall(r"benchtool\[([\w,]+)\]", " ".join(rest)):
        for name in extra.split(","):
            assert name in known, f"pyproject.toml has no extra '{name}': {', '.join(known)}"


def extras() -> Mapping[str, Any]:
    """The optional dependencies of the package."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        found: Mapping[str, Any] = tomllib.load(file)["project"]["optional-dependencies"]
    return found


def run(command: Command) -> str:
    """Run a command of benchtool in this process and return what it printed, on both streams."""
    result = CliRunner().invoke(app, command.words[1:])
    where = f"benchtool {' '.join(command.words[1:])}"
    assert result.exit_code == command.exit_code, f"{where}: exit code {result.exit_code}\n{result.output}"
    return result.output
