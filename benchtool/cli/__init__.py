"""The command line: one module per verb, which imports what is heavy when it is used."""

from __future__ import annotations

import signal
import sys
from types import FrameType
from typing import Annotated

import typer

from benchtool import __version__
from benchtool.cli import (
    analyze,
    compare,
    demo,
    doctor,
    emulate,
    export,
    info,
    jog,
    live,
    parameter_files,
    params,
    record,
    report,
    reset,
    run,
    scan,
)
from benchtool.cli.ending import reporting, run_to_the_end

app = typer.Typer(
    name="benchtool",
    help="A hardware-in-the-loop bench for motor drives.",
    epilog="Exit codes: 0 ok, 1 limits failed, 2 usage, 3 cannot connect or environment, 4 drive fault, "
    "130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
_ENABLING = (demo.demo, run.run, jog.jog)
for _verb in (
    demo.demo,
    run.run,
    jog.jog,
    record.record,
    live.live,
    analyze.analyze,
    report.report,
    export.export,
    compare.compare,
    info.info,
    reset.reset,
    scan.scan,
    emulate.emulate,
    doctor.doctor,
):
    app.command(_verb.__name__)(reporting(_verb, enables=_verb in _ENABLING))

_params = typer.Typer(
    help="Parameters of a drive: list, get, set; dump, diff and load as a file; save and restore.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for _command in (
    *(params.list_, params.get, params.set_),
    *(parameter_files.dump, parameter_files.diff, parameter_files.load),
    *(params.save, params.restore),
):
    _params.command(_command.__name__.rstrip("_"))(reporting(_command))
app.add_typer(_params, name="params")


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
