"""The command line: one module per verb, loaded when the verb is used."""

from __future__ import annotations

import signal
import sys
from types import FrameType
from typing import Annotated

import typer

from benchtool import __version__
from benchtool.cli.ending import run_to_the_end
from benchtool.cli.verbs import PARAMETER_VERBS, VERBS, group

app = group(
    VERBS,
    name="benchtool",
    help="A hardware-in-the-loop bench for motor drives.",
    epilog="Exit codes: 0 ok, 1 limits failed, 2 usage, 3 cannot connect or environment, 4 drive fault, "
    "130 interrupted.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(
    group(PARAMETER_VERBS, help="List, read, write, file and keep parameters of a drive."), name="params"
)


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


def main() -> None:
    """Run the command line and end the process with its exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    run_to_the_end(app)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    """The first signal interrupts; further ones must not cut short what disables the drive."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt
