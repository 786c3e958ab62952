"""`benchtool run PLAN`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output, show_run


def run(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="Name of a shipped plan or a TOML file.")],
    profile: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Profile to use instead of the plan's.")
    ] = "",
    link: options.Link = "emulated",
    out: options.Out = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Go on with a run that was cut short.")
    ] = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Run a test plan: set up, run, capture, measure, judge; the drive is disabled afterwards."""
    return run_named(
        plan,
        profile,
        link,
        resume or out,
        seed=seed,
        real_time=real_time,
        as_json=as_json,
        resume=bool(resume),
    )


def run_named(
    name: str,
    profile: str,
    link: str,
    out: Path | None,
    *,
    seed: int,
    real_time: bool,
    as_json: bool,
    resume: bool = False,
) -> int:
    """Run the plan of a name or file, print what it measured, and return the exit code."""
    from benchtool.bench import open_session
    from benchtool.cli.progress import RunProgress
    from benchtool.experiment.limits import Verdict
    from benchtool.experiment.plan import load_plan
    from benchtool.experiment.runner import RunInfo, run_plan

    output = Output(as_json=as_json)
    plan = load_plan(name)
    when = options.wall_time()
    info = RunInfo(when.isoformat(timespec="seconds"), seed, tuple(sys.argv[1:]))
    folder = options.bundle_folder(out, when, Path(name).stem if name.endswith(".toml") else name)
    place = profile or plan.profile
    with (
        RunProgress(output) as progress,
        open_session(place, link, seed=seed, real_time=real_time, note=progress.note) as session,
    ):
        try:
            result = run_plan(session, plan, folder, info, progress, resume=resume)
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(f"go on with: benchtool run {name} --resume {folder}")
            raise
    show_run(output, plan.title, result)
    return 1 if result.verdict is Verdict.FAIL else 0
