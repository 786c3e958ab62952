"""The command line: one module per verb, loaded when the verb is used."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import Annotated, NoReturn

import typer
from typer.completion import completion_init  # type: ignore[attr-defined] # typer imports it there

from benchtool import __version__
from benchtool.cli.exit_codes import end_quickly, run_to_the_end
from benchtool.cli.verbs import COMPLETION_VERBS, PARAMETER_VERBS, PLAN_VERBS, PROFILE_VERBS, VERBS, group
from benchtool.link import import_can_without_mdf

app = group(
    VERBS,
    name="benchtool",
    help="A hardware-in-the-loop bench for motor drives.",
    epilog="Exit codes: 0 ok, 1 limits failed, 2 usage, 3 cannot connect or environment, 4 drive fault, "
    "130 interrupted.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
for _name, _verbs, _help in (
    ("params", PARAMETER_VERBS, "List, read, write, file and keep parameters of a drive."),
    ("profile", PROFILE_VERBS, "Write a profile for a motor of one's own."),
    ("completion", COMPLETION_VERBS, "Tab completion of verbs, options and their values in your shell."),
    ("plan", PLAN_VERBS, "Write a test plan of one's own."),
):
    app.add_typer(group(_verbs, help=_help), name=_name)


COMPLETING = "_BENCHTOOL_COMPLETE"
"""Environment of a shell that asks for completion, see `benchtool.cli.completion`."""


def _version(show: bool) -> None:
    if show:
        sys.stdout.write(f"benchtool {__version__}\n")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None: ...


def run() -> NoReturn:
    """Be the process of the command line."""
    end_quickly(main)


def main() -> NoReturn:
    """Run the command line and raise SystemExit with its exit code."""
    import_can_without_mdf()
    if COMPLETING in os.environ:
        completion_init()
    for number in _interrupting():
        signal.signal(number, _interrupt)
    run_to_the_end(app)


def _interrupting() -> list[int]:
    """Return the signals that interrupt; SIGHUP, of a closed terminal, unless it is ignored (nohup)."""
    numbers = [int(signal.SIGINT), int(signal.SIGTERM)]
    hang_up = getattr(signal, "SIGHUP", None)  # Windows has none
    if hang_up is not None and signal.getsignal(hang_up) is signal.SIG_DFL:
        numbers.append(int(hang_up))
    return numbers


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    """The first signal interrupts; further ones must not interrupt the disabling of the drive."""
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt
