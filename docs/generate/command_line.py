"""The pages of the command line and of the exit codes, from the application and the tree of errors."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any, Final

import typer

from benchtool import errors
from benchtool.cli import app
from benchtool.cli.exit_codes import INTERRUPTED
from benchtool.errors import BenchError

_HEAD: Final = """# Command line

Every verb with its arguments and options, as `--help` behind a verb prints them. This page is generated
from the command line itself. [Exit codes](exit_codes.md) and [JSON documents](json_documents.md) have pages
of their own.
"""

_EXIT_CODES: Final = """# Exit codes

What a command ends with. A command that fails says in one line on standard error what was seen, what was
expected and what to do. This page is generated from `benchtool.errors`; a script may rely on the code, and
in Python on the class.

| code | meaning |
|---|---|
| 0 | Success: every limit was met (pass or marginal), or none was asked for |
| 1 | A limit failed or stayed undecided; `params diff` found differences, `twin` a wrong parameter |
| 2 | Usage: a command, profile, plan, value or run that is not there or does not allow what was asked for |
| 3 | The environment: no connection, another drive or dictionary than expected, a file not writable |
| 4 | The drive refused, failed or went into fault |
| {interrupted} | Interrupted by Ctrl-C, SIGTERM or a closed terminal (SIGHUP); the drive was disabled |

## Errors by exit code

Of an error that is indented, `except` of the one above catches it too.

| error | exit code | when |
|---|---|---|
"""


def page() -> str:
    """The page of all verbs."""
    lines = [_HEAD]
    command: Any = typer.main.get_command(app)
    lines += _verbs(command, "benchtool")
    return "\n".join(lines).rstrip() + "\n"


def exit_codes() -> str:
    """The page of the exit codes."""
    rows = [
        f"| {'&emsp;' * depth}`{error.__name__}` | {error.exit_code} | {_first_line(error)} |"
        for error, depth in _tree(BenchError, 0)
    ]
    return _EXIT_CODES.format(interrupted=INTERRUPTED) + "\n".join(rows) + "\n"


def _tree(error: type[BenchError], depth: int) -> Iterator[tuple[type[BenchError], int]]:
    yield error, depth
    for each in error.__subclasses__():
        if each.__module__ == errors.__name__:
            yield from _tree(each, depth + 1)


def _verbs(group: Any, path: str) -> Iterator[str]:
    for name in group.list_commands(group.context_class(group)):
        context = group.context_class(group, info_name=path)
        command = group.get_command(context, name)
        if hasattr(command, "list_commands"):
            yield from _verbs(command, f"{path} {name}")
            continue
        inner = command.context_class(command, info_name=f"{path} {name}")
        usage = " ".join((path, name, *command.collect_usage_pieces(inner)))
        yield from (f"## {path} {name}", "", _prose(command.help or ""), "", f"`{usage}`", "")
        yield from ("| argument or option | meaning |", "|---|---|")
        for parameter in command.get_params(inner):
            record = parameter.get_help_record(inner)
            if record is not None and parameter.name != "help":
                spelling, meaning = record
                yield f"| `{spelling.replace('|', chr(92) + '|')}` | {_cell(meaning)} |"
        yield ""


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def _prose(text: str) -> str:
    return "\n\n".join(_cell(part) for part in inspect.cleandoc(text).split("\n\n"))


def _first_line(error: type[BenchError]) -> str:
    return (inspect.getdoc(error) or "").splitlines()[0]
