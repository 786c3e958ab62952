"""`benchtool run` once its plans are read: checked, run, printed, written as a page."""

from __future__ import annotations

import itertools
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchtool.bench import open_session
from benchtool.cli import live_views, operator_prompt, options
from benchtool.cli.conditions import conditions
from benchtool.cli.junit_file import JunitFile
from benchtool.cli.output import Output
from benchtool.cli.progress import RunProgress
from benchtool.cli.results import show_run
from benchtool.cli.run import NamedPlan, RunOptions, noting
from benchtool.cli.run_views import RunViews
from benchtool.errors import DriveError, LinkError, UsageError
from benchtool.plan import plan_path, worst
from benchtool.profile import load_profile, profile_path
from benchtool.recording import enlist, require_own, write_whole
from benchtool.results import RunResult, recorded_bundles
from benchtool.run import RunInfo, bundle_folder, check_plan, run_plan


def run_plans(name: str, plans: Sequence[NamedPlan], chosen: RunOptions, junit: JunitFile) -> int:
    """Run one plan or the plans of a folder, print the results, and return the exit code.

    Args:
        name: of the plan or the folder, as it was given.
        junit: which is written once all plans have run; of a run that fails its owner writes it.
    """
    if chosen.page is not None:
        from benchtool.report import PAGE_MARK

        require_own(chosen.page, PAGE_MARK)
    single = not plans[0].part
    output = Output(as_json=chosen.as_json)
    title = Path(name).stem if name.endswith(".toml") else name
    with noting(chosen.changes):
        todo = [_checked(each, chosen) for each in plans]  # the last one too, before the first is run
    if chosen.dry_run:
        from benchtool.cli.dry_run import show_dry_run

        return show_dry_run(todo, chosen.link, output)
    with (
        bundle_folder(chosen.out, options.wall_time(), title) as folder,
        live_views.open_destinations(chosen.shown, output) as where,
    ):
        junit.folder = folder
        try:
            results: dict[str, RunResult] = {}
            for shown in _shown_together(todo):
                run = {each.label: _run(each, folder, chosen, output, where) for each in shown}
                show_run(output, shown[0].plan.title, _joined(shown, run), shown[0].plan.tabulate)
                results |= run
        except (KeyboardInterrupt, DriveError, LinkError) as end:
            if any(folder.rglob("manifest.json")):
                end.add_note(f"go on with: {_resumption(name, folder, chosen)}")
            raise
        junit.write()
        enlist(folder, [each.directory for each in recorded_bundles(folder)])
        output.line(f"report with figures: benchtool report {shlex.quote(str(folder))}", "dim")
        if chosen.page is not None:
            _write_page(chosen.page, name, [(each, results[each.label]) for each in todo])
        verdict = worst(result.verdict for result in results.values())
        documents = {each: result.to_json() for each, result in results.items()}
        alone = next(iter(documents.values()))
        output.document(alone if single else {"verdict": str(verdict), "plans": documents})
        where.keep_open(output, stay=chosen.web)  # a program has its document before
    return 0 if verdict.met else 1


def _resumption(name: str, folder: Path, chosen: RunOptions) -> str:
    """Return the shell command that resumes a run, with all of its options."""
    words = ["benchtool", "run", name, "--resume", str(folder)]
    words += ["--profile", chosen.profile] if chosen.profile else []
    words += ["--link", chosen.link] if chosen.link != "emulated" else []
    words += [word for change in chosen.changes for word in ("--set", change)]
    words += ["--seed", str(chosen.seed)] if chosen.seed else []
    words += ["--jobs", str(chosen.jobs)] if chosen.jobs > 1 else []
    words += ["--page", str(chosen.page)] if chosen.page is not None else []
    words += ["--junit", str(chosen.junit)] if chosen.junit is not None else []
    words += [word for place in chosen.live for word in ("--live", place)]
    words += ["--web"] if chosen.web else []
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
    """Validate a plan before anything is opened or sent."""
    check_plan(named.plan, plan_path(named.name), named.profile, chosen.link)
    if chosen.jobs > 1 and (chosen.real_time or chosen.link != "emulated"):
        raise UsageError(
            f"--jobs {chosen.jobs} is for emulated benches in virtual time: leave out --link and --real-time"
        )
    if chosen.jobs > 1 and chosen.shown:
        raise UsageError(f"--jobs {chosen.jobs} runs elsewhere than --live can look: leave one of them out")
    return named


def _shown_together(plans: Sequence[NamedPlan]) -> list[list[NamedPlan]]:
    """Return the plans by what is shown as one table: a plan with all of its profiles."""
    return [list(same) for _, same in itertools.groupby(plans, key=lambda each: each.name)]


def _joined(plans: Sequence[NamedPlan], results: Mapping[str, RunResult]) -> RunResult:
    """Return the results of a plan with its profiles as those of one run, each case with its profile."""
    if len(plans) == 1:
        return results[plans[0].label]

    def named(plan: NamedPlan, case: str) -> str:
        profile = Path(plan.part).name
        return case if case == profile else f"{profile} {case}"

    found = [(plan, results[plan.label]) for plan in plans]
    return RunResult(
        tuple(replace(each, case=named(plan, each.case)) for plan, run in found for each in run.assessments),
        {named(plan, case): each for plan, run in found for case, each in run.repeated.items()},
    )


def _run(
    checked: NamedPlan,
    folder: Path,
    chosen: RunOptions,
    output: Output,
    where: live_views.LiveDestinations,
) -> RunResult:
    """Run one plan with one profile."""
    plan, place, folder = checked.plan, checked.profile, folder / checked.part
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
        info = replace(info, prompt=operator_prompt.prompt(output, bar.aside, yes=chosen.yes, alone=alone))
        progress = RunViews(where, bar, output, checked.part)
        opener = partial(
            open_session,
            place,
            chosen.link,
            real_time=chosen.real_time,
            note=progress.note,
        )
        if chosen.jobs > 1:
            from benchtool.run import run_in_processes

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
                observer=progress,
            )
    return result


def _write_page(page: Path, command: str, results: Sequence[tuple[NamedPlan, RunResult]]) -> None:
    from benchtool.report import PlanFigures, reproduction_page

    figures = []
    for named, result in results:
        plan = named.plan
        measured = {each.case: each.measurements for each in result.assessments}
        published = {each.case: each.published for each in result.assessments if each.published}
        figures.append(
            PlanFigures(named.label, plan.title, plan.readings, plan.tabulate, measured, published)
        )
    stated = load_profile(results[-1][0].profile)
    text = reproduction_page(stated, figures, f"benchtool run {command} --page")
    write_whole(page, text.encode("utf-8"))
