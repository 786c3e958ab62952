"""`benchtool run PLAN`."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchtool.cli import options, viewing
from benchtool.cli.output import Output, show_run

if TYPE_CHECKING:
    from benchtool.experiment.assessment import RunResult


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
    live: tuple[str, ...] = ()


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
    live: viewing.Live = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Run a test plan: set up, run, capture, measure, judge; the drive is disabled afterwards."""
    chosen = RunOptions(
        profile, link, resume or out, seed, real_time, as_json, bool(resume), page, jobs, tuple(live or ())
    )
    return run_named(plan, chosen)


def run_named(name: str, chosen: RunOptions) -> int:
    """Run one plan or a folder of plans, print what they measured, and return the exit code."""
    from benchtool.errors import PlanError
    from benchtool.experiment.limits import Verdict, worst
    from benchtool.experiment.plan import plan_names

    names = plan_names(name)
    if not names:
        raise PlanError(f"folder {name} holds no plans: TOML files are expected, one a plan")
    single = names == (name,)
    output = Output(as_json=chosen.as_json)
    title = Path(name).stem if name.endswith(".toml") else name
    folder = options.bundle_folder(chosen.out, options.wall_time(), title)
    with viewing.places(chosen.live, output) as where:
        results = {
            each: _run(each, folder, "" if single else Path(each).stem, chosen, output, where)
            for each in names
        }
        where.linger(output)
    if chosen.page is not None:
        _write_page(chosen.page, name, results)
    verdict = worst(result.verdict for result in results.values())
    documents = {each: result.to_json() for each, result in results.items()}
    output.document(documents[name] if single else {"verdict": str(verdict), "plans": documents})
    return 1 if verdict is Verdict.FAIL else 0


def _run(
    name: str, folder: Path, part: str, chosen: RunOptions, output: Output, where: viewing.Places
) -> RunResult:
    """Run one plan; `part` of the command it is, empty if it is all of it."""
    from benchtool.bench import dictionary_of, open_session
    from benchtool.cli.progress import RunProgress
    from benchtool.cli.run_views import RunViews
    from benchtool.errors import UsageError
    from benchtool.experiment.parallel import run_in_processes
    from benchtool.experiment.plan import load_plan, plan_path
    from benchtool.experiment.ranges import require_protected
    from benchtool.experiment.runner import RunInfo, run_plan
    from benchtool.experiment.validation import require_known
    from benchtool.profile import load_profile

    plan, folder = load_plan(name), folder / part
    place = chosen.profile or plan.profile
    dictionary = dictionary_of(place)
    require_known(plan, plan_path(name), dictionary)
    if chosen.link == "emulated":
        require_protected(plan, plan_path(name), load_profile(place), dictionary)
    info = RunInfo(options.wall_time().isoformat(timespec="seconds"), chosen.seed, tuple(sys.argv[1:]))
    if chosen.jobs > 1 and (chosen.real_time or chosen.link != "emulated"):
        raise UsageError(
            f"--jobs {chosen.jobs} is for emulated benches in virtual time: leave out --link and --real-time"
        )
    if chosen.jobs > 1 and chosen.live:
        raise UsageError(f"--jobs {chosen.jobs} runs elsewhere than --live can look: leave one of them out")
    with RunProgress(output) as bar:
        progress = RunViews(where, bar, output, part)
        opener = partial(
            open_session,
            place,
            chosen.link,
            real_time=chosen.real_time,
            note=progress.note,
        )
        try:
            if chosen.jobs > 1:
                result = run_in_processes(
                    plan, place, folder, info, progress, jobs=chosen.jobs, resume=chosen.resume
                )
            else:
                result = run_plan(
                    lambda case, seed: opener(seed=seed, alter=case.emulator),
                    plan,
                    folder,
                    info,
                    progress,
                    resume=chosen.resume,
                    watcher=progress,
                )
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(f"go on with: benchtool run {name} --resume {folder}")
            raise
    show_run(output, plan.title, result, plan.tabulate)
    return result


def _write_page(page: Path, command: str, results: Mapping[str, RunResult]) -> None:
    from benchtool.errors import RecordingError
    from benchtool.experiment.plan import load_plan
    from benchtool.profile import load_profile
    from benchtool.report.page import PlanFigures, reproduction_page

    figures = []
    for name, result in results.items():
        plan = load_plan(name)
        measured = {each.case: each.measurements for each in result.assessments}
        figures.append(PlanFigures(name, plan.title, plan.readings, plan.tabulate, measured, plan.published))
    text = reproduction_page(load_profile(plan.profile), figures, f"benchtool run {command} --page")
    try:
        page.write_text(text, encoding="utf-8")
    except OSError as reason:
        raise RecordingError(
            f"cannot write {page}: {reason.strerror}; the page of the run was to go there: "
            f"choose another file"
        ) from None
