"""The report of recorded runs: every case measured again, and all that its bundle says of its origin."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from benchtool.plan.limits import Verdict, worst
from benchtool.report import content
from benchtool.report.assembly.case import case_facts, case_items, failure
from benchtool.report.assembly.marks import mark, read_already
from benchtool.report.assembly.plan import plan_items
from benchtool.report.assembly.table import is_table, table_report
from benchtool.report.content import Cell, Grid, Item, Mark, Report, Section
from benchtool.report.origin import files_section, supervision_notes
from benchtool.results.calibration import overdue_text
from benchtool.results.runs import RecordedCase, RecordedRun

_WORDS: Final[dict[Verdict, str]] = {
    Verdict.NONE: "No limits",
    Verdict.PASS: "Pass",
    Verdict.MARGINAL: "Marginal",
    Verdict.UNDECIDED: "Undecided",
    Verdict.FAIL: "Fail",
}


def run_report(folder: Path, runs: Sequence[RecordedRun]) -> Report:
    """The report of what `folder` holds; the same bundles give the same report.

    Raises:
        RecordingError: a file of a bundle cannot be read.
    """
    cases = [case for run in runs for case in run.cases]
    if len(cases) == 1 and is_table(cases[0].bundle) and cases[0].error is None:
        return table_report(cases[0].bundle)
    manifest = cases[0].bundle.manifest
    title = manifest.what if len(runs) == 1 else f"{len(runs)} plans: {folder.resolve().name}"
    subtitle = f"Test report · {manifest.when} · profile {manifest.profile_name or 'unknown'}"
    together = [each.verdict for run in runs for group in run.repeated.values() for each in group]
    items: list[Item] = [
        _banner(worst(run.verdict for run in runs), cases, together),
        *supervision_notes(case.bundle.manifest for case in cases),
    ]
    if len(cases) == 1:
        (case,) = cases
        items += [
            *failure(case),
            Section("The run", (case_facts(case),)),
            *case_items(case),
            *_own_files(folder, case),
        ]
    elif len(runs) == 1:
        items += [*plan_items(runs[0], listed=True), _common_files(folder, runs)]
    else:
        plans = [_plan_row(run) for run in runs]
        items.append(Section("Plans", (Grid.of(("plan", "cases", "verdict", "title"), plans),)))
        items += [
            Section(f"Plan {run.name}", tuple(plan_items(run, listed=False)), listed=True) for run in runs
        ]
        items.append(_common_files(folder, runs))
    return Report(title, subtitle, manifest.when, tuple(items))


def _banner(verdict: Verdict, cases: Sequence[RecordedCase], together: Sequence[Verdict]) -> content.Verdict:
    """The outcome of all limits, those of each case and those of repetitions `together`."""
    limits = [each for case in cases if case.assessment for each in case.assessment.verdicts.values()]
    limits += [each for each in together if each is not Verdict.NONE]
    failures = [case for case in cases if case.failure]
    parts = []
    if limits:
        met = sum(each.met for each in limits)
        parts.append(f"{met} of {len(limits)} limits met")
        if undecided := sum(each is Verdict.UNDECIDED for each in limits):
            parts.append(f"{undecided} undecided")
        if tight := sum(each is Verdict.MARGINAL for each in limits):
            parts.append(f"{tight} of them marginally")
    else:
        parts.append("no limits were set")
    if failures:
        parts.append(f"{len(failures)} of {len(cases)} cases failed or were cut short")
    elif len(cases) > 1:
        parts.append(f"{len(cases)} cases")
    overdue = [each for case in cases if case.assessment for each in case.assessment.overdue]
    parts += [overdue_text(overdue)] if overdue else []
    mark_: Mark = mark(verdict)
    text = f"{content.SYMBOLS[mark_]} {_WORDS[verdict]}"
    summary = ", ".join(parts)
    return content.Verdict(mark_, text, f"{summary[0].upper()}{summary[1:]}.")


def _plan_row(run: RecordedRun) -> tuple[str | Cell, ...]:
    verdict = Cell(str(run.verdict), mark(run.verdict))
    return run.name, str(len(run.cases)), verdict, run.cases[0].bundle.manifest.what


def _own_files(folder: Path, case: RecordedCase) -> Iterator[Item]:
    name = folder.resolve().name
    yield files_section(
        [("", case.bundle, read_already(case.assessment))],
        [f"benchtool analyze {name}", f"benchtool export {name} --format csv"],
    )


def _common_files(folder: Path, runs: Sequence[RecordedRun]) -> Section:
    name = folder.resolve().name
    bundles = [
        (
            f"{case.bundle.directory.relative_to(folder).as_posix()}/",
            case.bundle,
            read_already(case.assessment),
        )
        for run in runs
        for case in run.cases
    ]
    commands = [f"benchtool compare {name}", f"benchtool analyze {name}/{bundles[0][0].rstrip('/')}"]
    section = files_section(bundles, commands)
    return Section(section.title, section.items, listed=True)
