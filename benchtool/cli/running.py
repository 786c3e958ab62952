"""`benchtool run` once its plans are read: checked, run, printed, written as a page."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchtool.bench.session import dictionary_of, equipment_of, open_session
from benchtool.bench.wires import registry
from benchtool.bench.wires.wire import FarEnd
from benchtool.cli import asking, options, viewing
from benchtool.cli.bundles import bundle_folder, conditions
from benchtool.cli.output import Output
from benchtool.cli.progress import RunProgress
from benchtool.cli.results import show_run
from benchtool.cli.run import NamedPlan, RunOptions
from benchtool.cli.run_views import RunViews
from benchtool.drive.capabilities import Capabilities
from benchtool.errors import DriveError, LinkError, UsageError
from benchtool.plan.cases import cases
from benchtool.plan.limits import worst
from benchtool.plan.model import load_plan, plan_path
from benchtool.plan.ranges import require_protected
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile, profile_path
from benchtool.recording.files import require_own, write_whole
from benchtool.report.page import MARK, PlanFigures, reproduction_page
from benchtool.results.assessment import RunResult
from benchtool.run.parallel import run_in_processes
from benchtool.run.requirements import require_capable
from benchtool.run.runner import RunInfo, run_plan


def run_plans(name: str, plans: Sequence[NamedPlan], chosen: RunOptions) -> int:
    """Run one plan or those of a folder, print what they measured, and return the exit code.

    Args:
        name: of the plan or the folder, as it was given.
    """
    if chosen.page is not None:
        require_own(chosen.page, MARK)
    single = [each.name for each in plans] == [name]
    output = Output(as_json=chosen.as_json)
    title = Path(name).stem if name.endswith(".toml") else name
    todo = [_checked(each, chosen) for each in plans]  # the last one too, before the first is run
    with (
        bundle_folder(chosen.out, options.wall_time(), title) as folder,
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


def _checked(named: NamedPlan, chosen: RunOptions) -> NamedPlan:
    """Refuse what cannot be, before anything is opened or sent."""
    plan, name, profile = named.plan, named.name, load_profile(named.profile)
    dictionary, equipment = dictionary_of(named.profile), equipment_of(named.profile, chosen.link)
    capabilities = Capabilities.of(dictionary)
    for case in cases(plan):
        require_capable(capabilities, plan, case)
    require_known(
        plan,
        plan_path(name),
        profile,
        dictionary,
        transducer=equipment.has_transducer,
        profile_file=profile_path(named.profile),
    )
    if registry.far_end(chosen.link) is FarEnd.EMULATED_DRIVE:
        require_protected(plan, plan_path(name), profile, dictionary)
    if chosen.jobs > 1 and (chosen.real_time or chosen.link != "emulated"):
        raise UsageError(
            f"--jobs {chosen.jobs} is for emulated benches in virtual time: leave out --link and --real-time"
        )
    if chosen.jobs > 1 and chosen.live:
        raise UsageError(f"--jobs {chosen.jobs} runs elsewhere than --live can look: leave one of them out")
    return named


def _run(
    checked: NamedPlan, folder: Path, part: str, chosen: RunOptions, output: Output, where: viewing.Places
) -> RunResult:
    """Run one plan; `part` of the command it is, empty if it is all of it."""
    plan, place, folder = checked.plan, checked.profile, folder / part
    info = RunInfo(
        options.wall_time().isoformat(timespec="seconds"),
        chosen.seed,
        tuple(sys.argv[1:]),
        chosen.allow_different,
        link=chosen.link,
        profile_toml=profile_path(place).read_text(encoding="utf-8"),
        note=chosen.note,
        conditions=conditions(
            chosen.operator, chosen.serial_number, chosen.temperature_degC, chosen.instruments
        ),
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


def _write_page(page: Path, command: str, results: Mapping[str, RunResult]) -> None:
    figures = []
    for name, result in results.items():
        plan = load_plan(name)
        measured = {each.case: each.measurements for each in result.assessments}
        published = {each.case: each.published for each in result.assessments if each.published}
        figures.append(PlanFigures(name, plan.title, plan.readings, plan.tabulate, measured, published))
    text = reproduction_page(load_profile(plan.profile), figures, f"benchtool run {command} --page")
    write_whole(page, text.encode("utf-8"))
