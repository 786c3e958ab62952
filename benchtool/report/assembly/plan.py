"""A plan of several cases in a report: all side by side, then each case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from benchtool.analysis import NOTHING, catalogue, raw, undefined, without_uncertainty
from benchtool.plan import Plan, Verdict
from benchtool.report.assembly.case import case_appendix, case_facts, case_items, circumstances, failure
from benchtool.report.assembly.figures import run_figures
from benchtool.report.assembly.pictures import picture
from benchtool.report.assembly.recording import plan_of
from benchtool.report.content import Cell, Grid, Item, Section, Text
from benchtool.report.results import (
    bounds_of,
    budgets_section,
    conformance_notes,
    conformance_of,
    judged_value,
    mark,
    verdict_cell,
)
from benchtool.results import Assessment, JudgedTogether, RecordedCase, RecordedRun, Repeated

_MOST_FOREMOST = 5
_MOST_NAMED = 4  # cases
_FEW_CASES = 4
_REPEATED = ("measurement", ">mean ± U (95 %)", "unit", ">n")
_OF_LIMITS = ("limit", "decision rule", ">P", "verdict")
_WELL = (Verdict.NONE, Verdict.PASS)


def plan_items(run: RecordedRun, *, listed: bool) -> Iterator[Item]:
    """Yield one plan of several cases: all of them in figures and one table, then each for itself.

    Of many cases each is closed until it is asked for, and on paper stand those alone that missed a limit.
    """
    yield Section("All cases", tuple(_overview(run)), listed=listed)
    many = len(run.cases) > _FEW_CASES
    for case in run.cases:
        items = (*failure(case), *case_items(case, alone=False, brief=many and case.verdict in _WELL))
        paper = not many or case.verdict not in _WELL
        yield Section(f"Case {case_label(run, case)}", items, listed=True, folded=many, paper=paper)


def plan_appendix(run: RecordedRun) -> Iterator[Item]:
    """Yield what is looked up: the run, the drive and the plan, and of each case the quality of its data."""
    yield Section("The run", (case_facts(run.cases[0]), *_differences(run)))
    yield from circumstances(run.cases[0].bundle)
    many = len(run.cases) > _FEW_CASES
    for case in run.cases:
        items = tuple(case_appendix(case, alone=False, brief=many and case.verdict in _WELL))
        yield Section(f"Data of case {case_label(run, case)}", items, folded=True, paper=False)


def case_label(run: RecordedRun, case: RecordedCase) -> str:
    """Return a case's name, with its plan's where there are several."""
    return f"{run.name}/{case.name}" if run.name else case.name


def _overview(run: RecordedRun) -> Iterator[Item]:
    results = [case.assessment for case in run.cases if case.assessment is not None]
    plan = plan_of(run.cases[0].bundle) if results else None
    names = _foremost(run, plan)
    units = {each.name: each.unit for result in results for each in result.measurements}
    several = len({case.bundle.manifest.link for case in run.cases}) > 1
    rows: list[tuple[str | Cell, ...]] = [
        (
            case.name,
            *(_overview_cell(case, name) for name in names),
            *((case.bundle.manifest.link,) if several else ()),
            Cell(str(case.verdict), mark(case.verdict)),
        )
        for case in run.cases
    ]
    if plan is not None:
        yield from (picture(name, figure) for name, figure in run_figures(plan, results).items())
    headings = [f">{name} ({units[name]})" if units[name] else f">{name}" for name in names]
    yield Grid.of(("case", *headings, *(("link",) if several else ()), "verdict"), rows)
    if any(result.published for result in results):
        yield Text("Published figures stand in brackets.", "note")
    yield from _lacking(results, names)
    if plan is None:
        return
    yield from _over_repetitions(run, names)


def _over_repetitions(run: RecordedRun, names: Sequence[str]) -> Iterator[Item]:
    """Yield what all cases come to over their repetitions: the headline in one table, and of each case
    everything."""
    if not run.repeated:
        return
    found = [
        (case, each)
        for case, together in run.repeated.items()
        for each in together
        if each.name in names or each.judged
    ]
    judged = [each.judged for _, each in found if each.judged]
    headings = _headings(judged)
    rows: list[tuple[str | Cell, ...]] = [
        (case, *_repeated_row(each, judged=bool(judged))) for case, each in found
    ]
    notes = conformance_notes(judged) if judged else ()
    yield Section("Over the repetitions", (Grid.of(("case", *headings), rows), *notes))
    for case, together in run.repeated.items():
        grid = Grid.of(headings, [_repeated_row(each, judged=bool(judged)) for each in together])
        missed = (each.judged.missed for each in together if each.judged)
        told = (Text(f"{str(each.verdict).capitalize()}: {each}.", "warning") for each in missed if each)
        items: list[Item] = [grid, *told]
        if (budgets := budgets_section([each.measured for each in together])) is not None:
            items.append(budgets)
        yield Section(f"{case} over its repetitions", tuple(items), folded=True, paper=False)


def _headings(judged: Sequence[JudgedTogether]) -> tuple[str, ...]:
    """Return the headings of means and, where there are any, of the limits that hold for repetitions."""
    if not judged:
        return _REPEATED
    return (*_REPEATED, f">{judged[0].judge} ± U (95 %)", *_OF_LIMITS)


def _repeated_row(each: Repeated, *, judged: bool) -> tuple[str | Cell, ...]:
    """Return a measurement over its repetitions and, where some are `judged`, what of it is and with which
    verdict."""
    reason = each.uncertainty_reason
    notes = (each.reason or each.remark, f"no uncertainty: {reason}" if reason else "")
    told = tuple(f"{note[0].upper()}{note[1:].rstrip('.')}." for note in notes if note)
    name = Cell(each.name, notes=told)
    row = (name, each.measured.text, each.unit, each.n_of_count)
    held = each.judged
    if held is None:
        return (*row, "", *("" for _ in _OF_LIMITS)) if judged else row
    return (
        *row,
        *(judged_value(held.measured), bounds_of(held.limit), held.limit.rule),
        *(conformance_of(held), verdict_cell(held)),
    )


def _foremost(run: RecordedRun, plan: Plan | None) -> list[str]:
    """Return measurements of an overview: those that the plan tabulates, else limited and headline ones."""
    found = dict.fromkeys(
        each.name
        for case in run.cases
        if case.assessment
        for each in case.assessment.measurements
        if plan is not None or each.is_told  # a recording has asked for none of them
    )
    if plan is not None and plan.tabulate:
        return [name for name in plan.tabulate if name in found]
    stated = () if plan is None else (plan.limits, *plan.case_limits.values())
    limited = [name for limits in stated for name in limits]
    asked = [name for name in dict.fromkeys((*limited, *catalogue().headline)) if name in found]
    return (asked or list(found))[:_MOST_FOREMOST]


def _overview_cell(case: RecordedCase, name: str) -> Cell:
    result = case.assessment
    measured = next((each for each in result.measurements if each.name == name), None) if result else None
    if result is None or measured is None:
        return Cell(NOTHING)
    text = measured.text
    if name in result.published:
        text += f" ({raw(result.published[name])})"
    return Cell(text, mark(result.verdicts[name]) if name in result.verdicts else "")


def _lacking(results: Sequence[Assessment], names: Sequence[str]) -> Iterator[Text]:
    """Yield why measurements of the overview have no value or no uncertainty in some cases."""
    for what, reasons_of in (("Undefined", undefined), ("Without ±", without_uncertainty)):
        found: dict[tuple[str, str], list[str]] = {}
        for result in results:
            shown = [each for each in result.measurements if each.name in names]
            for reason, lacking in reasons_of(shown).items():
                found.setdefault((", ".join(lacking), reason), []).append(result.case)
        for (lacking_of_all, reason), where in found.items():
            more = f" and {len(where) - _MOST_NAMED} more" if len(where) > _MOST_NAMED else ""
            told = f"{', '.join(where[:_MOST_NAMED])}{more}"
            yield Text(f"{what}: {lacking_of_all} of {told}: {reason.rstrip('.')}.", "note")


def _differences(run: RecordedRun) -> Iterator[Item]:
    """Yield the parameters of the drive that are not the same in all cases."""
    held = [case.bundle.manifest.parameters for case in run.cases]
    keys = dict.fromkeys(key for parameters in held for key in parameters)
    differing = [key for key in keys if len({parameters.get(key) for parameters in held}) > 1]
    if differing:
        rows = [
            (case.name, *(raw(case.bundle.manifest.parameters.get(key, NOTHING)) for key in differing))
            for case in run.cases
        ]
        yield Grid.of(("case", *differing), rows, "Parameters of the drive in which the cases differ.")
