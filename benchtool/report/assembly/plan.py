"""A plan of several cases in a report: all of them side by side, then each for itself."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.analysis.catalogue import catalogue
from benchtool.plan.model import Plan
from benchtool.report.assembly.case import case_facts, case_items, circumstances, failure
from benchtool.report.assembly.figures import run_figures
from benchtool.report.assembly.marks import mark, picture
from benchtool.report.content import Cell, Grid, Item, Section, Text
from benchtool.report.numbers import NOTHING, raw, with_expanded
from benchtool.results.repetitions import Repeated
from benchtool.results.runs import RecordedCase, RecordedRun

_MOST_FOREMOST = 5


def plan_items(run: RecordedRun, *, listed: bool) -> Iterator[Item]:
    """One plan of several cases: all of them in one table and one figure, then each for itself."""
    first = run.cases[0].bundle
    yield Section("Overview" if listed else "All cases", tuple(_overview(run)), listed=listed)
    yield Section("The run" if listed else "Run", (case_facts(run.cases[0]), *_differences(run)))
    yield from circumstances(first)
    for case in run.cases:
        title = f"Case {case_label(run, case)}"
        yield Section(title, (*failure(case), *case_items(case, alone=False)), listed=True)


def case_label(run: RecordedRun, case: RecordedCase) -> str:
    """A case's name, with its plan's where there are several."""
    return f"{run.name}/{case.name}" if run.name else case.name


def _overview(run: RecordedRun) -> Iterator[Item]:
    results = [case.assessment for case in run.cases if case.assessment is not None]
    plan = Plan.model_validate(run.cases[0].bundle.manifest.details["plan"]) if results else None
    names = _foremost(run, plan)
    units = {each.name: each.unit for result in results for each in result.measurements}
    rows: list[tuple[str | Cell, ...]] = [
        (
            case.name,
            *(_overview_cell(case, name) for name in names),
            case.bundle.manifest.link,
            Cell(str(case.verdict), mark(case.verdict), _reasons(case)),
        )
        for case in run.cases
    ]
    headings = [f">{name} ({units[name]})" if units[name] else f">{name}" for name in names]
    yield Grid.of(("case", *headings, "link", "verdict"), rows)
    if any(result.published for result in results):
        yield Text("Published figures stand in brackets.", "note")
    if plan is None:
        return
    for case, together in run.repeated.items():
        repeated = [_repeated_row(each) for each in together]
        headings_ = (
            "measurement",
            ">mean ± U (95 %)",
            "unit",
            ">repetitions",
            "limit",
            "verdict",
        )
        missed = (each.missed for each in together)
        told = (Text(f"{str(each.verdict).capitalize()}: {each}.", "warning") for each in missed if each)
        yield Section(f"{case} over its repetitions", (Grid.of(headings_, repeated), *told))
    for name, figure in run_figures(plan, results).items():
        yield picture(name, figure)


def _repeated_row(each: Repeated) -> tuple[str | Cell, ...]:
    """A measurement over its repetitions, and how it meets the limit that holds for these together."""
    row = (each.name, with_expanded(each.mean, each.uncertainty), each.unit, str(each.n))
    if each.limit is None:
        return (*row, "", "")
    what = "" if each.judged is None else f" ({each.judged.definition}; {each.limit.rule})"
    return (*row, f"{each.limit.bounds}{what}", Cell(str(each.verdict), mark(each.verdict)))


def _reasons(case: RecordedCase) -> tuple[str, ...]:
    """Why a case has its verdict: what cut it short, which limits it missed and by how much."""
    missed = case.assessment.missed if case.assessment is not None else ()
    return (*((case.failure,) if case.failure else ()), *(str(each) for each in missed))


def _foremost(run: RecordedRun, plan: Plan | None) -> list[str]:
    """What an overview shows: what the plan tabulates, else what it limits and what is asked first."""
    found = dict.fromkeys(
        each.name for case in run.cases if case.assessment for each in case.assessment.measurements
    )
    if plan is not None and plan.tabulate:
        return [name for name in plan.tabulate if name in found]
    limited = [name for case in run.cases if case.assessment for name in case.assessment.limits]
    return list(dict.fromkeys(name for name in (*limited, *catalogue().foremost, *found) if name in found))[
        :_MOST_FOREMOST
    ]


def _overview_cell(case: RecordedCase, name: str) -> Cell:
    result = case.assessment
    measured = next((each for each in result.measurements if each.name == name), None) if result else None
    if result is None or measured is None:
        return Cell(NOTHING)
    text = with_expanded(measured.value, measured.uncertainty)
    if name in result.published:
        text += f" ({raw(result.published[name])})"
    return Cell(text, mark(result.verdicts[name])) if name in result.verdicts else Cell(text)


def _differences(run: RecordedRun) -> Iterator[Item]:
    """Parameters of the drive that are not the same in all cases."""
    held = [case.bundle.manifest.parameters for case in run.cases]
    keys = dict.fromkeys(key for parameters in held for key in parameters)
    differing = [key for key in keys if len({parameters.get(key) for parameters in held}) > 1]
    if differing:
        rows = [
            (case.name, *(raw(case.bundle.manifest.parameters.get(key, NOTHING)) for key in differing))
            for case in run.cases
        ]
        yield Grid.of(("case", *differing), rows, "Parameters of the drive in which the cases differ.")
