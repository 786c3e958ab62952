"""Options that choose what of a recording is measured, and by what."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from benchtool.errors import UsageError

if TYPE_CHECKING:
    from benchtool.results import Selection

Stream = Annotated[
    str, typer.Option("--stream", metavar="NAME", help="Measure this stream of a recording alone.")
]
From = Annotated[
    float | None,
    typer.Option(
        "--from", metavar="S", help="Measure from this time after the first row on, not steady regimes."
    ),
]
To = Annotated[
    float | None, typer.Option("--to", metavar="S", help="Measure up to this time after the first row.")
]
Asked = Annotated[
    list[str] | None,
    typer.Option(
        "--analysis",
        metavar="NAME[:KEY=VALUE,...]",
        help="Make this analysis too, as step:signal=omega_m,reference=omega_m_reference, with --csv of "
        "columns, as step:signal=T,reference=2:Nm; NAME=false leaves one of a recording out.",
    ),
]


def selection(
    stream: str, from_s: float | None, to_s: float | None, asked: Sequence[str] | None
) -> Selection:
    """Return what the options choose.

    Raises:
        UsageError: an option is misspelt, or the window has no length.
        AnalysisError: there is no such analysis, or no such setting of it.
    """
    from benchtool.results import EVERYTHING, Selection, analyses_of

    if from_s is not None and to_s is not None and from_s >= to_s:
        raise UsageError(f"--from {from_s:g} is not before --to {to_s:g}: give the earlier first")
    table = dict(_analysis(text) for text in asked or ())
    return Selection(stream, from_s, to_s, analyses_of(table) if table else EVERYTHING)


def asked_of_table(asked: Sequence[str] | None) -> dict[str, Mapping[str, Any]]:
    """Return the settings of each analysis that is asked of a table, by its name.

    Raises:
        UsageError: an option is misspelt, or leaves out what a table is not measured by anyway.
    """
    table = dict(_analysis(text) for text in asked or ())
    for name, settings in table.items():
        if settings is False:
            raise UsageError(f"--csv with --analysis {name}=false: it is made where it is asked for alone")
    return {name: settings if isinstance(settings, Mapping) else {} for name, settings in table.items()}


def _analysis(text: str) -> tuple[str, Any]:
    """Return the name and entry of `[analyses]`."""
    name, colon, rest = text.partition(":")
    if not colon:
        name, given, value = text.partition("=")
        if given and value not in ("true", "false"):
            raise UsageError(f"--analysis {text}: NAME, NAME=false or NAME:KEY=VALUE,... is expected")
        return name, value != "false"
    settings = dict(_setting(text, part) for part in rest.split(","))
    return name, settings


def _setting(text: str, part: str) -> tuple[str, Any]:
    key, given, value = part.partition("=")
    if not (key and given):
        raise UsageError(f"--analysis {text}: '{part}' is no KEY=VALUE: give settings as signal=torque")
    try:
        return key, json.loads(value)
    except ValueError:
        return key, value  # a name, which needs no quotes here
