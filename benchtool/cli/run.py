"""`benchtool run PLAN`: its options, and its plans as they are read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.errors import PlanError
from benchtool.plan.model import Plan, load_plan, plan_names
from benchtool.profile import load_profile


@dataclass(frozen=True)
class RunOptions:
    """How to run, whatever the plan."""

    profile: str = ""
    link: str = "emulated"
    out: Path | None = None
    seed: int = 0
    real_time: bool = False
    as_json: bool = False
    resume: bool = False
    page: Path | None = None
    jobs: int = 1
    allow_different: bool = False
    live: tuple[str, ...] = ()
    note: str = ""
    operator: str = ""
    serial_number: str = ""
    temperature_degC: float | None = None
    instruments: tuple[str, ...] = ()
    yes: bool = False


@dataclass(frozen=True)
class NamedPlan:
    """A plan by the name it was given, and the profile that it runs with."""

    name: str
    plan: Plan
    profile: str


def run(
    plan: Annotated[
        str, typer.Argument(metavar="PLAN", help="Name of a shipped plan, a TOML file, or a folder of plans.")
    ],
    profile: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Profile to use instead of the plan's.")
    ] = "",
    link: options.Link = "emulated",
    out: options.Out = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Go on with a run that was cut short.")
    ] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write published and measured figures as Markdown.")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Emulated benches to run at a time.")] = 1,
    allow_different: Annotated[
        bool,
        typer.Option("--allow-different", help="Run a drive whose parameters contradict the profile."),
    ] = False,
    note: Annotated[str, typer.Option(help="A line for the manifest.")] = "",
    operator: Annotated[str, typer.Option(help="Who runs the test, for the manifest.")] = "",
    serial_number: Annotated[str, typer.Option(help="Of the motor under test, for the manifest.")] = "",
    temperature: Annotated[
        float | None, typer.Option(min=-273.15, help="Of the surroundings in degrees Celsius, likewise.")
    ] = None,
    instrument: Annotated[
        list[str] | None,
        typer.Option(help="An instrument beside the drive, with its certificate; once for each."),
    ] = None,
    live: options.Live = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    yes: options.Yes = False,
    as_json: options.Json = False,
) -> int:
    """Run a test plan: set up, run, capture, measure, judge; the drive is disabled afterwards."""
    chosen = RunOptions(
        profile,
        link,
        resume or out,
        seed,
        real_time,
        as_json,
        bool(resume),
        page,
        jobs,
        allow_different,
        tuple(live or ()),
        note,
        operator,
        serial_number,
        temperature,
        tuple(instrument or ()),
        yes,
    )
    return run_named(plan, chosen)


def run_named(name: str, chosen: RunOptions) -> int:
    """Read one plan or a folder of plans, and run them; returns the exit code.

    Raises:
        PlanError, ProfileError: one of them is not there, or a key is wrong.
    """
    options.require_temperature(chosen.temperature_degC)
    names = plan_names(name)
    if not names:
        raise PlanError(f"folder {name} holds no plans: TOML files are expected, one a plan")
    plans = [_read(each, chosen.profile) for each in names]
    # A slip of the pen is answered before what a run needs is loaded.
    from benchtool.cli.running import run_plans

    return run_plans(name, plans, chosen)


def _read(name: str, profile: str) -> NamedPlan:
    plan = load_plan(name)
    place = profile or plan.profile
    load_profile(place)
    return NamedPlan(name, plan, place)
