"""`benchtool commission`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import typer

from benchtool.analysis import with_expanded
from benchtool.bench import Session, open_session
from benchtool.cli import options
from benchtool.cli.output import Output, significant
from benchtool.commission import Known, Step, commission as run, document, planned, steps_for
from benchtool.errors import UsageError


def commission(
    steps: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[STEP]...",
            help="preflight, offsets, resistance, encoder, inductance, flux_linkage, mechanics; all without.",
        ),
    ] = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Print what would be played and the heat of it; nothing is enabled."),
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Confirm that currents may flow and the shaft may turn.")
    ] = False,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Identify a motor step by step, with the profile as its nameplate; the drive is left as it was found."""
    wanted = steps_for(steps or ())
    if not (yes or dry_run):
        raise UsageError(
            "a commissioning has rated current flow and turns the shaft: give --yes once that is safe, or "
            "--dry-run to see what it would do"
        )
    output = Output(as_json=as_json)
    with open_session(
        profile, link, seed=seed, real_time=real_time, note=output.note, instruments=False
    ) as session:
        session.drive.connect()
        if dry_run:
            return _show_plan(session, wanted, output)
        done = run(session.drive, session.profile, wanted, output.note)
    content = document(done)
    rows = [
        (each.name, with_expanded(each.value, each.uncertainty), each.unit, _shown(content, each.name))
        for result in done.results
        for each in result.estimates.values()
    ]
    if rows:
        output.table(f"commissioning of {profile}", ("estimate", ">value", "unit", ">nameplate"), rows)
    for result in done.results:
        output.sentence(result.reason or "done", lead=f"{result.name}: {result.verdict.value}, ")
    for finding in (each for result in done.results for each in result.findings):
        output.sentence(f"{finding.cause}; {finding.remedy}", lead=f"{finding.what}: ")
    output.verdict(content["verdict"])
    output.document(content)
    return 0 if done.passed else 1


def _show_plan(session: Session, steps: Sequence[Step], output: Output) -> int:
    """Print what the steps would play and how much heat that puts into the winding, by the nameplate."""
    known = Known.of(session.drive, session.profile.motor)
    plan = planned(steps, known)
    heat_J = {
        name: sum(each.energy_J(known.R_s_ohm) for each in excitations) for name, excitations in plan.items()
    }
    rows = [
        (name, each.name, significant(each.energy_J(known.R_s_ohm)))
        for name, excitations in plan.items()
        for each in excitations
    ]
    output.table("what would be played", ("step", "excitation", ">J in the winding"), rows)
    output.line("nothing was enabled; each step's estimates would be for the parameters that it sets")
    output.document(
        {
            "dry_run": True,
            "steps": {step.name: {"energy_J": heat_J[step.name], "sets": list(step.sets)} for step in steps},
            "energy_J": sum(heat_J.values()),
        }
    )
    return 0


def _shown(content: dict[str, Any], name: str) -> str:
    stated = content["estimates"][name]["nameplate"]
    return "" if stated is None else significant(stated)
