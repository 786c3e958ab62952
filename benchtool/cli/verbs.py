"""The verbs of the command line, and the module that is loaded when one of them is used."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, Final

import typer
from typer.core import TyperGroup

from benchtool.cli.exit_codes import with_exit_code

PLAIN: Final = "_BENCHTOOL_PLAIN"
"""Environment of a shell that shows no help beside proposals, whose rendering takes a tenth of a second."""

HELP: Final = {"help_option_names": ["-h", "--help"]}


@dataclass(frozen=True)
class Verb:
    """One command: the function of its name in `benchtool.cli.MODULE`, its help, and whether it may enable
    the drive."""

    name: str
    module: str
    help: str
    enables: bool = False

    def load(self) -> Any:
        """Return the typer command; imports its module."""
        return _command(self)


@cache
def _command(verb: Verb) -> Any:
    module = import_module(f"benchtool.cli.{verb.module}")
    function = getattr(module, verb.name, None) or getattr(module, f"{verb.name}_")
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    alone.command(verb.name, context_settings=HELP)(with_exit_code(function, enables=verb.enables))
    return typer.main.get_command(alone)


VERBS: Final = (
    Verb("demo", "demo", "Run a torque-ripple test on the emulated drive.", enables=True),
    Verb("run", "run", "Run a test plan: set up, capture, measure, judge.", enables=True),
    Verb("plans", "listing", "List the test plans, a line for each."),
    Verb("profiles", "profiles", "List the profiles of motors, a line for each."),
    Verb("commission", "commission", "Identify a motor, step by step.", enables=True),
    Verb("jog", "jog", "Turn the shaft by setpoints from this computer.", enables=True),
    Verb("shell", "shell", "Open a bench in IPython: parameters, captures, plots.", enables=True),
    Verb("record", "record", "Record the stream of a drive; nothing is enabled."),
    Verb("live", "live", "Show a drive, or a recorded run, live in Rerun."),
    Verb("analyze", "analyze", "Measure a recorded run again, or another tool's table."),
    Verb("report", "report", "Write a self-contained report of a run."),
    Verb("export", "export", "Write the data of a run as CSV, MATLAB or MDF4."),
    Verb("compare", "compare", "Set recorded runs side by side, with their differences."),
    Verb("twin", "twin", "Simulate a run again with believed and estimated parameters."),
    Verb("verify", "verify", "Check a run by its hashes, and measure it again to the bit."),
    Verb("gauge", "gauge", "Study how repeatable and reproducible a measurement is."),
    Verb("info", "info", "Show which drive answers on a link, and its state."),
    Verb("reset", "reset", "Clear a latched fault; nothing is enabled."),
    Verb("scan", "scan", "Find drives on serial ports and CAN buses."),
    Verb("emulate", "emulate", "Offer the emulated drive to other programs, in real time."),
    Verb("doctor", "doctor", "Check that this machine has what benchtool needs."),
)
"""What `benchtool` offers."""

PROFILE_VERBS: Final = (Verb("new", "profile", "Write a profile: a template, or that of a motor."),)
"""What `benchtool profile` offers."""

COMPLETION_VERBS: Final = (
    Verb("install", "completion", "Install tab completion for your shell."),
    Verb("show", "completion", "Print the script of a shell."),
)
"""What `benchtool completion` offers."""

PLAN_VERBS: Final = (Verb("new", "plan", "Write a commented plan that runs with a profile."),)
"""What `benchtool plan` offers."""

PARAMETER_VERBS: Final = (
    Verb("list", "params", "List the parameters; '*' marks what is not the default."),
    Verb("get", "params", "Read objects of any kind by name."),
    Verb("set", "params", "Write parameters: all of them, or none."),
    Verb("dump", "parameter_files", "Write every parameter to a TOML file."),
    Verb("diff", "parameter_files", "Compare a file with the drive, or two files."),
    Verb("load", "parameter_files", "Write the parameters of a file, each read back."),
    Verb("derive", "derive", "Show or write parameters that fit the profile's motor."),
    Verb("save", "params", "Store the drive's parameters, to survive a reset."),
    Verb("restore", "params", "Set every parameter to its default."),
)
"""What `benchtool params` offers."""


class LazyGroup(TyperGroup):
    """A group whose verbs are listed by name and help, and loaded one at a time."""

    verbs: tuple[Verb, ...] = ()
    _listing = False

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a name, loaded now unless it is only listed; None where there is none."""
        for verb in self.verbs:
            if verb.name == cmd_name and not self._listing:
                return verb.load()
        return super().get_command(ctx, cmd_name)

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        """Return the propose verbs, without loading any of them."""
        self._listing = True
        proposals = super().shell_complete(ctx, incomplete)
        if PLAIN in os.environ:
            for each in proposals:
                each.help = None
        return proposals

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List what the group offers, without loading any of it."""
        rows = [(name, command.help or "") for name, command in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def group(verbs: tuple[Verb, ...], **settings: Any) -> typer.Typer:
    """Return a typer application of these verbs."""

    class Group(LazyGroup):
        pass

    Group.verbs = verbs
    app = typer.Typer(
        cls=Group, no_args_is_help=True, rich_markup_mode=None, context_settings=HELP, **settings
    )
    for verb in verbs:
        app.command(verb.name, help=verb.help)(_listed)
    return app


def _listed() -> None:
    """Stands for a verb that is not loaded yet."""
