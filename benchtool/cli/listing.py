"""`benchtool plans`: the plans that there are, a line for each."""

from __future__ import annotations

from typing import Annotated

import typer

from benchtool.analysis import catalogue, count_of
from benchtool.cli import options, proposals
from benchtool.cli.output import Output
from benchtool.errors import PlanError
from benchtool.plan import Plan, cases, drive_time_s, load_plan, plan_names, profiles_of, shipped_plans


def plans(
    folder: Annotated[
        str,
        typer.Argument(
            metavar="[FOLDER]",
            help="Folder of plans, or a profile's; all that ship.",
            autocompletion=proposals.plans,
        ),
    ] = "",
    as_json: options.Json = False,
) -> int:
    """The plans that there are: name, what each tests and measures, its cases and how long they take."""
    output = Output(as_json=as_json)
    names = plan_names(folder) if folder else tuple(shipped_plans())
    found, refused = {}, []
    for name in names:
        try:
            found[name] = load_plan(name)
        except PlanError as error:
            if len(names) == 1:
                raise
            refused.append(str(error))
    width = max(map(len, found), default=0)
    for name, plan in found.items():
        runs = len(_profiles(name, plan))
        several = f" x {runs} profiles" if runs > 1 else ""
        lasts = f"{count(len(cases(plan)))}{several}, {duration(runs * drive_time_s(plan))}"
        output.sentence(plan.title, lead=f"{name:<{width}}  {lasts:<18}  {measured(plan):<18}  ")
    for each in refused:
        output.warning(f"no plan: {each}")
    output.document(
        {
            name: {
                "title": plan.title,
                "cases": len(cases(plan)),
                "profiles": list(_profiles(name, plan)),
                "measures": measured(plan),
                "duration_s": len(_profiles(name, plan)) * drive_time_s(plan),
            }
            for name, plan in found.items()
        }
    )
    return 0


def _profiles(name: str, plan: Plan) -> tuple[str, ...]:
    """Return the profiles that a plan is run with, as it names them where none fits yet."""
    try:
        return profiles_of(name, plan)
    except PlanError:
        return (plan.profile,)


def measured(plan: Plan) -> str:
    """Return the analyses of a plan in words: the steady state as one, and those that it asks for by name."""
    asked = [
        each.name.replace("_", " ")
        for each in catalogue().analyses
        if not each.of_steady_state and plan.analyses.made(each)
    ]
    return ", ".join((["steady state"] if plan.analyses.steady else []) + asked) or "quality of the data"


def duration(seconds: float) -> str:
    """Return a duration as a person reads it: `48 s`, `3 min`."""
    return f"{seconds:.3g} s" if seconds < 120.0 else f"{seconds / 60.0:.2g} min"


def count(cases: int) -> str:
    """`1 case`, `3 cases`."""
    return count_of(cases, "case")
