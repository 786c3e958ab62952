"""The report of recorded runs: every case measured again, with its provenance."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchtool.report.assembly.case import case_appendix, case_facts, case_items
from benchtool.report.assembly.front import fingerprint, front_items
from benchtool.report.assembly.pictures import read_already
from benchtool.report.assembly.plan import plan_appendix, plan_items
from benchtool.report.assembly.table import table_report
from benchtool.report.content import Cell, Facts, Grid, Item, Report, Section
from benchtool.report.provenance import files_section
from benchtool.report.results import mark
from benchtool.results import RecordedCase, RecordedRun, is_table

_TOGETHER: Final = {
    "drive's numbers": "drive",
    "hardware": "hardware, firmware",
    "firmware": "hardware, firmware",
}
"""Facts that the first page states with others, by their names there."""


def run_report(folder: Path, runs: Sequence[RecordedRun]) -> Report:
    """Return the report of what `folder` holds; the same bundles give the same report.

    Raises:
        RecordingError: a file of a bundle cannot be read.
    """
    cases = [case for run in runs for case in run.cases]
    if len(cases) == 1 and is_table(cases[0].bundle) and cases[0].error is None:
        return table_report(cases[0].bundle)
    manifest = cases[0].bundle.manifest
    title = _title(folder, runs[0]) if len(runs) == 1 else f"{len(runs)} plans: {folder.resolve().name}"
    subtitle = f"Test report · {manifest.when} · profile {manifest.profile_name or 'unknown'}"
    front = tuple(front_items(runs))
    items: list[Item] = []
    if len(cases) == 1:
        (case,) = cases
        items += case_items(case)
        appendix = [
            *case_appendix(case),
            Section("The run", (_beyond(front, case_facts(case)),)),
            _own_files(folder, case),
        ]
    elif len(runs) == 1:
        items += plan_items(runs[0], listed=True)
        appendix = [*plan_appendix(runs[0]), _common_files(folder, runs)]
    else:
        plans = [_plan_row(run) for run in runs]
        items.append(Section("Plans", (Grid.of(("plan", "cases", "verdict", "title"), plans),)))
        items += [
            Section(f"Plan {run.name}", tuple(plan_items(run, listed=False)), listed=True) for run in runs
        ]
        appendix = [Section(f"Of plan {run.name}", tuple(plan_appendix(run))) for run in runs]
        appendix.append(_common_files(folder, runs))
    return Report(
        title,
        subtitle,
        manifest.when,
        tuple(items),
        front=front,
        appendix=tuple(appendix),
        fingerprint=fingerprint([case.bundle for case in cases]),
    )


def _beyond(front: Sequence[Item], facts: Facts) -> Facts:
    """Return the facts that the first page does not state already."""
    sections = (section for section in front if isinstance(section, Section))
    stated = {
        name
        for section in sections
        for part in section.items
        if isinstance(part, Facts)
        for name, _ in part.pairs
    }
    return Facts(tuple((name, what) for name, what in facts.pairs if _TOGETHER.get(name, name) not in stated))


def _plan_row(run: RecordedRun) -> tuple[str | Cell, ...]:
    verdict = Cell(str(run.verdict), mark(run.verdict))
    return run.name, str(len(run.cases)), verdict, run.cases[0].bundle.manifest.what


def _own_files(folder: Path, case: RecordedCase) -> Section:
    name = folder.resolve().name
    return files_section(
        [("", case.bundle, read_already(case.assessment))],
        [f"benchtool analyze {name}", f"benchtool export {name} --format csv"],
        by=_by([case]),
    )


def _common_files(folder: Path, runs: Sequence[RecordedRun]) -> Section:
    name = folder.resolve().name
    cases = {case.bundle.directory: case for run in runs for case in run.cases}  # a recording has several
    bundles = [
        (
            "" if directory == folder else f"{directory.relative_to(folder).as_posix()}/",
            case.bundle,
            read_already(case.assessment),
        )
        for directory, case in cases.items()
    ]
    commands = [f"benchtool compare {name}", f"benchtool analyze {name}/{bundles[0][0]}".rstrip("/")]
    return files_section(bundles, commands, by=_by([case for run in runs for case in run.cases]))


def _title(folder: Path, run: RecordedRun) -> str:
    """Return the title of the plan; a recording has none but its folder's name."""
    first = run.cases[0]
    recorded = first.assessment is not None and first.assessment.recorded is not None
    return f"Recording {folder.resolve().name}" if recorded else first.bundle.manifest.what


def _by(cases: Sequence[RecordedCase]) -> str:
    recorded = any(case.assessment is not None and case.assessment.recorded is not None for case in cases)
    return "the analyses that its channels allow" if recorded else "the plan that the bundle carries"
