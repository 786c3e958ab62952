"""`benchtool run PLAN`."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchtool.cli import asking, options, viewing
from benchtool.cli.output import Output, show_run

if TYPE_CHECKING:
    from benchtool.plan.model import Plan
    from benchtool.recording import Conditions
    from benchtool.results.assessment import RunResult


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
    live: viewing.Live = None,
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
    """Run one plan or a folder of plans, print what they measured, and return the exit code."""
    from benchtool.errors import DriveError, LinkError, PlanError, UsageError
    from benchtool.plan.limits import worst
    from benchtool.plan.model import plan_names

    if chosen.temperature_degC is not None and not math.isfinite(chosen.temperature_degC):
        raise UsageError(f"--temperature is {chosen.temperature_degC}: give a number of degrees Celsius")
    if chosen.page is not None:
        _require_page(chosen.page)
    names = plan_names(name)
    if not names:
        raise PlanError(f"folder {name} holds no plans: TOML files are expected, one a plan")
    single = names == (name,)
    output = Output(as_json=chosen.as_json)
    title = Path(name).stem if name.endswith(".toml") else name
    todo = [_check(each, chosen) for each in names]  # the last one too, before the first is run
    with (
        options.bundle_folder(chosen.out, options.wall_time(), title) as folder,
        viewing.places(chosen.live, output) as where,
    ):
        try:
            results = {
                each.name: _run(each, folder, "" if single else Path(each.name).stem, chosen, output, where)
                for each in todo
            }
        except (KeyboardInterrupt, DriveError, LinkError) as end:
            if any(folder.rglob("manifest.json")):
                end.add_note(f"go on with: {_resumption(name, folder, chosen)}")
            raise
        where.linger(output)
    if chosen.page is not None:
        _write_page(chosen.page, name, results)
    verdict = worst(result.verdict for result in results.values())
    documents = {each: result.to_json() for each, result in results.items()}
    output.document(documents[name] if single else {"verdict": str(verdict), "plans": documents})
    return 0 if verdict.met else 1


def _require_page(page: Path) -> None:
    """Refuse to write the page over a file that no such run wrote."""
    from benchtool.recording.files import require_own
    from benchtool.report.page import MARK

    require_own(page, MARK)


def _resumption(name: str, folder: Path, chosen: RunOptions) -> str:
    """The command that goes on with a run, as a shell takes it: all that it was begun with."""
    words = ["benchtool", "run", name, "--resume", str(folder)]
    words += ["--profile", chosen.profile] if chosen.profile else []
    words += ["--link", chosen.link] if chosen.link != "emulated" else []
    words += ["--seed", str(chosen.seed)] if chosen.seed else []
    words += ["--jobs", str(chosen.jobs)] if chosen.jobs > 1 else []
    words += ["--page", str(chosen.page)] if chosen.page is not None else []
    words += [word for place in chosen.live for word in ("--live", place)]
    words += ["--note", chosen.note] if chosen.note else []
    words += ["--operator", chosen.operator] if chosen.operator else []
    words += ["--serial-number", chosen.serial_number] if chosen.serial_number else []
    words += [] if chosen.temperature_degC is None else ["--temperature", f"{chosen.temperature_degC:g}"]
    words += [word for instrument in chosen.instruments for word in ("--instrument", instrument)]
    words += ["--allow-different"] if chosen.allow_different else []
    words += ["--real-time"] if chosen.real_time else []
    words += ["--yes"] if chosen.yes else []
    words += ["--json"] if chosen.as_json else []
    return shlex.join(words)


@dataclass(frozen=True)
class _Checked:
    """A plan that was found sound, by the name it was given, and the profile that it runs with."""

    name: str
    plan: Plan
    profile: str


def _check(name: str, chosen: RunOptions) -> _Checked:
    """Read a plan, and refuse what cannot be, before anything is opened or sent."""
    from benchtool.errors import UsageError
    from benchtool.plan.model import load_plan, plan_path
    from benchtool.profile import load_profile

    plan = load_plan(name)
    place = chosen.profile or plan.profile
    profile = load_profile(place)

    # Imported once plan and profile are known to be there: a slip of the pen is answered at once.
    from benchtool.bench.session import dictionary_of, equipment_of
    from benchtool.plan.ranges import require_protected
    from benchtool.plan.validation import require_known

    dictionary, equipment = dictionary_of(place), equipment_of(place, chosen.link)
    require_known(plan, plan_path(name), profile, dictionary, transducer=equipment.has_transducer)
    if chosen.link == "emulated":
        require_protected(plan, plan_path(name), profile, dictionary)
    if chosen.jobs > 1 and (chosen.real_time or chosen.link != "emulated"):
        raise UsageError(
            f"--jobs {chosen.jobs} is for emulated benches in virtual time: leave out --link and --real-time"
        )
    if chosen.jobs > 1 and chosen.live:
        raise UsageError(f"--jobs {chosen.jobs} runs elsewhere than --live can look: leave one of them out")
    return _Checked(name, plan, place)


def _run(
    checked: _Checked, folder: Path, part: str, chosen: RunOptions, output: Output, where: viewing.Places
) -> RunResult:
    """Run one plan; `part` of the command it is, empty if it is all of it."""
    from benchtool.bench.session import open_session
    from benchtool.cli.progress import RunProgress
    from benchtool.cli.run_views import RunViews
    from benchtool.profile import profile_path
    from benchtool.run.parallel import run_in_processes
    from benchtool.run.runner import RunInfo, run_plan

    plan, place, folder = checked.plan, checked.profile, folder / part
    info = RunInfo(
        options.wall_time().isoformat(timespec="seconds"),
        chosen.seed,
        tuple(sys.argv[1:]),
        chosen.allow_different,
        link=chosen.link,
        profile_toml=profile_path(place).read_text(encoding="utf-8"),
        note=chosen.note,
        conditions=_conditions(chosen),
    )
    with RunProgress(output) as bar:
        alone = chosen.as_json or chosen.jobs > 1
        info = replace(info, prompt=asking.prompt(output, bar.aside, yes=chosen.yes, alone=alone))
        progress = RunViews(where, bar, output, part)
        opener = partial(
            open_session,
            place,
            chosen.link,
            real_time=chosen.real_time,
            note=progress.note,
        )
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
    show_run(output, plan.title, result, plan.tabulate)
    return result


def _conditions(chosen: RunOptions) -> Conditions:
    from benchtool.recording import Conditions

    return Conditions(
        operator=chosen.operator,
        test_object_serial_number=chosen.serial_number,
        temperature_degC=chosen.temperature_degC,
        instruments=chosen.instruments,
    )


def _write_page(page: Path, command: str, results: Mapping[str, RunResult]) -> None:
    from benchtool.plan.model import load_plan
    from benchtool.profile import load_profile
    from benchtool.recording.files import write_whole
    from benchtool.report.page import PlanFigures, reproduction_page

    figures = []
    for name, result in results.items():
        plan = load_plan(name)
        measured = {each.case: each.measurements for each in result.assessments}
        published = {each.case: each.published for each in result.assessments if each.published}
        figures.append(PlanFigures(name, plan.title, plan.readings, plan.tabulate, measured, published))
    text = reproduction_page(load_profile(plan.profile), figures, f"benchtool run {command} --page")
    write_whole(page, text.encode("utf-8"))
