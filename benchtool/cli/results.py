"""Results of runs in the terminal: measurements, limits, verdicts, one case or several side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rich.text import Text

from benchtool.analysis import Measurement
from benchtool.analysis.catalogue import catalogue
from benchtool.cli.output import VERDICT_COLOURS, Output, significant, tell_overdue
from benchtool.plan.limits import Limit
from benchtool.report.numbers import with_expanded
from benchtool.results.assessment import Assessment, RunResult
from benchtool.results.calibration import overdue_text
from benchtool.results.repetitions import Repeated

_MOST_COLUMNS = 7


def measured(measurement: Measurement) -> str:
    """Its value with its expanded uncertainty for 95 %, if it has one."""
    return with_expanded(measurement.value, measurement.uncertainty)


def show_run(output: Output, title: str, result: RunResult, tabulate: Sequence[str] = ()) -> None:
    """Print for people what every case of a run measured, and how it met its limits."""
    if len(result.assessments) == 1:
        show_assessment(output, title, result.assessments[0])
    elif tabulate or len(result.assessments) > _MOST_COLUMNS:
        show_rows(output, title, result.assessments, tabulate or catalogue().foremost)
    else:
        show_side_by_side(output, title, result.assessments)
    show_repeated(output, result.repeated, tabulate)
    show_remarks(output, result.assessments)
    tell_overdue(output, result.overdue)
    output.verdict(result.verdict, result.verdict_by_transducer, overdue_text(result.overdue))
    show_missed(output, result.assessments)
    for case, missed in result.missed:
        output.line(f"  {missed.verdict}: {case}, {missed}", VERDICT_COLOURS[missed.verdict])
    show_disagreements(output, result.assessments)


def show_missed(output: Output, cases: Sequence[Assessment]) -> None:
    """Print each limit that was missed, or met within its margin only: case, number, bound, by how much."""
    for case in cases:
        for each in case.missed:
            output.line(f"  {each.verdict}: {_of(case, cases)}{each}", VERDICT_COLOURS[each.verdict])


def show_disagreements(output: Output, cases: Sequence[Assessment]) -> None:
    """Print where the shaft does not agree with the estimate of the drive, on which a verdict rests: what has
    a limit in full, the rest by name with the number of cases."""
    others: dict[str, int] = {}
    for case in cases:
        for each in case.disagreements:
            if each.verdict is None:
                others[each.name] = others.get(each.name, 0) + 1
                continue
            true = f"{measured(each.true)} {each.true.unit}".rstrip()
            estimate = f"{measured(each.estimate)} {each.estimate.unit}".rstrip()
            output.line(
                f"  the transducer disagrees: {_of(case, cases)}{each.name} is {estimate} by the drive's own "
                f"estimate, {true} on the shaft: {each.verdict} there",
                VERDICT_COLOURS[each.verdict],
            )
    if others:
        named = [
            f"{name} ({count} of {len(cases)} cases)" if len(cases) > 1 else name
            for name, count in others.items()
        ]
        output.line(f"  the transducer disagrees: {', '.join(named)}", "dim")


def show_remarks(output: Output, cases: Sequence[Assessment]) -> None:
    """Print what was not measured for want of channels, what uncertainties leave out, and where the drive
    contradicts the profile."""
    told: dict[str, None] = {}
    for case in cases:
        told |= dict.fromkeys(f"{_of(case, cases)}{text}" for text in case.of_sensors)
    for case in cases:
        if case.refusal:
            told[f"{_of(case, cases)}nothing else was measured: {case.refusal}"] = None
        if case.without:
            lacking = (f"{title} ({', '.join(channels)})" for title, channels in case.without.items())
            told[f"not measured for want of channels: {', '.join(lacking)}"] = None
        for key, values in case.parameter_check.get("contradicted", {}).items():
            told[f"the drive held {key} = {values['drive']}, the profile states {values['profile']}"] = None
    for line in told:
        output.line(line, "dim")


def _of(case: Assessment, cases: Sequence[Assessment]) -> str:
    return f"{case.case}: " if len(cases) > 1 else ""


def show_rows(output: Output, title: str, cases: Sequence[Assessment], names: Sequence[str]) -> None:
    """Print some measurements of many cases, a row for each case."""
    rows: list[tuple[str | Text, ...]] = [
        (case.case, *(_cell(case, name) for name in names)) for case in cases
    ]
    output.table(title, ("case", *(f">{name}" for name in names)), rows)


def show_repeated(
    output: Output, repeated: Mapping[str, Sequence[Repeated]], names: Sequence[str] = ()
) -> None:
    """Print what the repetitions of each case come to, all of it or the measurements named."""
    for case, together in repeated.items():
        limited = any(each.limit is not None for each in together)
        rows: list[tuple[str | Text, ...]] = [
            (each.name, significant(each.mean), f"{each.combined:.2g}", str(each.n), each.unit)
            + ((_together(each),) if limited else ())
            for each in together
            if not names or each.name in names
        ]
        verdict = ("verdict",) if limited else ()
        columns = ("measurement", ">mean", ">uncertainty", ">n", "unit", *verdict)
        output.table(f"{case}: mean of the repetitions and its standard uncertainty", columns, rows)


def _together(repeated: Repeated) -> str:
    """What of the repetitions a limit holds for, and how that meets it."""
    limit = repeated.limit
    if limit is None:
        return ""
    what = "" if repeated.judged is None else f", {repeated.judge} {limit.bounds}"
    return f"{repeated.verdict}{what}"


def show_side_by_side(output: Output, title: str, cases: Sequence[Assessment]) -> None:
    """Print the measurements of several cases as one table; what misses its limit is red, published figures
    stand in brackets."""
    names = dict.fromkeys((each.name, each.unit) for case in cases for each in case.measurements)
    rows: list[tuple[str | Text, ...]] = [
        (name, *(_cell(case, name) for case in cases), unit) for name, unit in names
    ]
    output.table(title, ("measurement", *(f">{case.case}" for case in cases), "unit"), rows)
    for case in cases:
        output.line(f"{case.case}: {case.bundle}")


def _cell(case: Assessment, name: str) -> Text:
    value = next((each.value for each in case.measurements if each.name == name), math.nan)
    published = f" ({significant(case.published[name])})" if name in case.published else ""
    verdict = case.verdicts.get(name)
    return Text(f"{significant(value)}{published}", style=VERDICT_COLOURS[verdict] if verdict else "")


def show_assessment(output: Output, title: str, result: Assessment) -> None:
    """Print what one case measured, how it met its limits, and the published figures beside it."""
    published = ("published",) if result.published else ()
    rows = []
    limited = (each for each in result.quality if each.name in result.limits)
    for each in (*result.measurements, *limited):
        limit = result.limits.get(each.name)
        bounds = "" if limit is None else f"{_bound('≥', limit.min)}{_bound('≤', limit.max)}"
        beside = (significant(result.published.get(each.name, math.nan)),) if published else ()
        cells = (each.name, measured(each), *beside, each.unit, bounds.strip(), _judged(result, each.name))
        rows.append(cells)
    headings = (f">{name}" for name in published)
    columns = ("measurement", ">value ± U (95 %)", *headings, "unit", "limit", "verdict")
    output.table(title, columns, rows)
    if result.limits:
        output.line(f"decision rule: {_rules(result.limits)}; P: probability of conformance", "dim")
    output.line(f"bundle: {result.bundle}")


def _judged(result: Assessment, name: str) -> str:
    """Verdict and, where the measurement has an uncertainty, the probability of conformance."""
    if name not in result.verdicts:
        return ""
    probability = f", P {result.conformances[name]:.3g}" if name in result.conformances else ""
    return f"{result.verdicts[name]}{probability}"


def _rules(limits: Mapping[str, Limit]) -> str:
    """The decision rule of each limit, those with simple acceptance together."""
    rules = [f"{name} {limit.rule}" for name, limit in limits.items() if limit.margin]
    simple = next((limit.rule for limit in limits.values() if not limit.margin), "")
    return ", ".join((*rules, f"{'others ' if rules else ''}{simple}") if simple else rules)


def _bound(sign: str, value: float | None) -> str:
    return "" if value is None else f"{sign} {value:g} "
