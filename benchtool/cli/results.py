"""Results of runs in the terminal: measurements, limits, verdicts, one case or several side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from rich.text import Text

from benchtool.analysis import (
    NOTHING,
    Measurement,
    catalogue,
    correction_notes,
    count_of,
    probability,
    raw,
    repeatability_notes,
    sensor_remarks,
    undefined,
    without_uncertainty,
)
from benchtool.cli.fitting import named
from benchtool.cli.output import VERDICT_COLOURS, Output, warn_overdue
from benchtool.cli.side_by_side import Column, show_beside
from benchtool.plan import JudgedLimit, Limit
from benchtool.results import (
    Assessment,
    Disagreement,
    JudgedTogether,
    Repeated,
    RunResult,
    overdue_text,
    waived_limits,
)

_MOST_COLUMNS = 7
_MOST_NAMED = 4


def show_run(output: Output, title: str, result: RunResult, tabulate: Sequence[str] = ()) -> None:
    """Print what every case of a run measured, and its verdicts."""
    if len(result.assessments) == 1:
        show_assessment(output, title, result.assessments[0])
    elif tabulate or len(result.assessments) > _MOST_COLUMNS:
        show_rows(output, title, result.assessments, tabulate or catalogue().headline)
    else:
        show_side_by_side(output, title, result.assessments)
    show_repeated(output, result.repeated, tabulate)
    show_remarks(output, result.assessments)
    warn_overdue(output, result.overdue)
    output.verdict(result.verdict, result.verdict_by_transducer, overdue_text(result.overdue))
    show_missed(output, result.assessments)
    show_waived(output, result)
    for name, together in result.unjudged.items():
        output.sentence(
            f"undecided: {name}: {together.of_one}", lead="  ", style=VERDICT_COLOURS["undecided"]
        )
    for case, missed in result.missed:
        output.sentence(
            f"{missed.verdict}: {case}, {missed}", lead="  ", style=VERDICT_COLOURS[missed.verdict]
        )
    for case, judged in result.contradicted:
        show_contradicted(output, f"{case}, ", judged)
    cases = result.assessments
    show_disagreements(output, [(_of(each, cases), each) for each in cases])


def show_missed(output: Output, cases: Sequence[Assessment]) -> None:
    """Print each limit that was missed, or met within its margin only: case, number, bound, by how much."""
    for case in cases:
        for each in case.missed:
            output.sentence(
                f"{each.verdict}: {_of(case, cases)}{each}", lead="  ", style=VERDICT_COLOURS[each.verdict]
            )


def show_waived(output: Output, result: RunResult) -> None:
    """Print each limit that was not met and is waived, with who consents and why."""
    prefixed = len(result.assessments) > 1
    for each in waived_limits(result.assessments, result.repeated):
        of, consent = f"{each.case}: " if prefixed else "", each.consent
        output.sentence(
            f"{of}{each.missed} ({consent.reason}, {consent.by})", lead="  waived: ", style="yellow"
        )


def show_disagreements(
    output: Output, found: Sequence[tuple[str, Assessment]], together: str = "cases"
) -> None:
    """Print where the transducer contradicts the drive's estimate, each case after its prefix: measurements
    with a limit in full, the first of the others by name, in how many of all `together`."""
    counts = Counter[str]()
    for prefix, case in found:
        for each in case.disagreements:
            if each.verdict is None:
                counts[each.name] += 1
                continue
            _show_contradicted(output, prefix, each)
    for count in sorted(set(counts.values()), reverse=True):
        names = [name for name, often in counts.items() if often == count]
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        among = f" in {count} of {len(found)} {together}" if len(found) > 1 else ""
        named = f"{', '.join(names[:_MOST_NAMED])}{more}"
        output.sentence(f"the transducer disagrees{among}: {named}", "dim", lead="  ")


def show_contradicted(output: Output, of: str, judged: JudgedTogether) -> None:
    """Print that the transducer contradicts the value that a limit over repetitions is held against, if it
    does."""
    if judged.disagreement is not None:
        _show_contradicted(output, f"{of}{judged.judge} of {judged.count} repetitions: ", judged.disagreement)


def _show_contradicted(output: Output, of: str, found: Disagreement) -> None:
    """Print a number with a limit that the transducer contradicts, in the colour of the verdict by it."""
    colour = "" if found.verdict is None else VERDICT_COLOURS[found.verdict]
    output.sentence(f"the transducer disagrees: {of}{found}", colour, lead="  ")


def show_remarks(output: Output, cases: Sequence[Assessment]) -> None:
    """Print what is odd in the recordings, what was not measured for lack of channels, what uncertainties do
    not contain, and where the drive contradicts the profile."""
    for case in cases:
        for text in case.remarks:
            output.sentence(f"warning: {_of(case, cases)}{text}", "yellow")
    told: dict[str, None] = {}
    for case in cases:
        if case.recorded is not None:
            told |= dict.fromkeys(f"regime: {each.text}" for each in case.recorded.regimes)
            told |= dict.fromkeys(f"{_of(case, cases)}{text}" for text in case.recorded.remarks(case.capture))
    told |= dict.fromkeys(_on_sensors(cases))
    told |= dict.fromkeys(correction_notes(each for case in cases for each in case.measurements))
    told |= dict.fromkeys(repeatability_notes(each for case in cases for each in case.measurements))
    told |= dict.fromkeys(f"{_of(case, cases)}{text}" for case in cases for text in case.notes)
    refused = {reason for case in cases for reason in case.refusals}  # each told once, by its analysis
    told |= dict.fromkeys(_reasons(cases, undefined, "undefined", refused))
    told |= dict.fromkeys(_reasons(cases, without_uncertainty, "without ±"))
    for case in cases:
        if case.refusal:
            told[f"{_of(case, cases)}nothing else was measured: {case.refusal}"] = None
        if case.without:
            lacking = (f"{title} ({', '.join(channels)})" for title, channels in case.without.items())
            told[f"not measured for lack of channels: {', '.join(lacking)}"] = None
        told |= dict.fromkeys(
            f"not measured: {', '.join(titles)}: {reason}" for reason, titles in case.refusals.items()
        )
        for key, values in case.parameter_check.get("contradicted", {}).items():
            told[f"the drive held {key} = {values['drive']}, the profile states {values['profile']}"] = None
    for line in told:
        output.sentence(line, "dim")


def _on_sensors(cases: Sequence[Assessment]) -> Iterator[str]:
    """Yield each remark on sensors once, over all cases; one that does not hold for all with the case."""
    in_each = [sensor_remarks(case.measurements) for case in cases]
    for said, text in sensor_remarks(each for case in cases for each in case.measurements).items():
        told = [case.case for case, own in zip(cases, in_each, strict=True) if said in own]
        where = f"{told[0]}: " if len(told) == 1 else f"{len(told)} of {len(cases)} cases: "
        yield text if len(told) == len(cases) else f"{where}{text}"


def _reasons(
    cases: Sequence[Assessment],
    lacking: Callable[[Sequence[Measurement]], Mapping[str, Sequence[str]]],
    what: str,
    besides: Collection[str] = (),
) -> Iterator[str]:
    """Yield why measurements have no value, or no uncertainty, each reason `besides` some once; of several
    that the same measurements have in other cases the first, and how many there are."""
    found: dict[str, dict[str, None]] = {}
    for case in cases:
        for reason, names in lacking(case.measurements).items():
            if reason in besides:
                continue
            found.setdefault(reason, {}).update(dict.fromkeys(names))
    reasons: dict[tuple[str, ...], list[str]] = {}
    for reason, distinct in found.items():
        reasons.setdefault(tuple(distinct), []).append(reason)
    for measured_names, (first, *others) in reasons.items():
        more = (
            f" (one of {len(others) + 1} such reasons in these cases: the report has all)" if others else ""
        )
        yield f"{what}: {named(measured_names)}: {first}{more}"


def _of(case: Assessment, cases: Sequence[Assessment]) -> str:
    return f"{case.case}: " if len(cases) > 1 else ""


def show_rows(output: Output, title: str, cases: Sequence[Assessment], names: Sequence[str]) -> None:
    """Print some measurements of many cases, a row for each case."""
    units = {each.name: each.unit for case in cases for each in case.measurements}
    columns = [
        Column(
            f">{name} ({units[name]})" if units.get(name) else f">{name}",
            tuple(_cell(case, name) for case in cases),
        )
        for name in names
    ]
    first = Column("case", tuple(case.case for case in cases))
    show_beside(output, f"{title}: value ± U (95 %)", [first], [[column] for column in columns])


def show_repeated(
    output: Output, repeated: Mapping[str, Sequence[Repeated]], names: Sequence[str] = ()
) -> None:
    """Print the means of each case over its repetitions, all of them or those named, and how it meets the
    limits that hold for them together."""
    for case, together in repeated.items():
        shown = [each for each in together if not names or each.name in names]
        rows = [(each.name, each.measured.text, each.n_of_count, each.unit) for each in shown]
        headings = ("measurement", ">mean ± U (95 %)", ">n", "unit")
        output.table(f"{case}: means of the repetitions", headings, rows)
        for remark in dict.fromkeys(each.remark for each in shown if each.remark):
            output.sentence(
                f"{named(tuple(each.name for each in shown if each.remark == remark))}: {remark}", "dim"
            )
        for reason, lacking in without_uncertainty([each.measured for each in shown]).items():
            output.sentence(f"without ±: {named(lacking)}: {reason}", "dim")
        _show_judged(output, case, [each.judged for each in together if each.judged is not None])


def _show_judged(output: Output, case: str, judged: Sequence[JudgedTogether]) -> None:
    """Print the limits that hold for the repetitions of a case together, with the value that is judged."""
    if not judged:
        return
    first = judged[0]
    rows = [
        (
            each.name,
            NOTHING if each.measured is None else each.measured.text,
            "" if each.measured is None else each.measured.unit,
            each.limit.bounds,
            verdict_text(each),
        )
        for each in judged
    ]
    title = f"{case}: limits that hold for the {first.judge} of {count_of(first.count, 'repetition')}"
    headings = ("measurement", f">{first.judge} ± U (95 %)", "unit", "limit", "verdict")
    output.table(title, headings, rows)
    _show_rules(output, {each.name: each for each in judged})


def show_side_by_side(output: Output, title: str, cases: Sequence[Assessment]) -> None:
    """Print the measurements of several cases beside each other; missed limits are red, published figures in
    brackets."""
    valued = {
        each.name for case in cases for each in case.measurements if case.recorded is None or each.is_told
    }
    found = dict.fromkeys((each.name, each.unit) for case in cases for each in case.measurements)
    shown = [(name, unit) for name, unit in found if name in valued]
    groups = [[Column(f">{case.case}", tuple(_cell(case, name) for name, _ in shown))] for case in cases]
    names = Column("measurement", tuple(name for name, _ in shown))
    units = Column("unit", tuple(unit for _, unit in shown))
    show_beside(output, f"{title}: value ± U (95 %)", [names], groups, [units])
    for case in cases:
        output.line(f"{case.case}: {case.bundle}")


def _cell(case: Assessment, name: str) -> Text:
    found = next((each for each in case.measurements if each.name == name), None)
    published = f" ({raw(case.published[name])})" if name in case.published else ""
    verdict = case.verdicts.get(name)
    text = f"{NOTHING if found is None else found.text}{published}"
    return Text(text, style=VERDICT_COLOURS[verdict] if verdict else "")


def show_assessment(output: Output, title: str, result: Assessment) -> None:
    """Print what one case measured, how it met its limits, and the published figures beside it."""
    published = ("published",) if result.published else ()
    rows = []
    limited = (each for each in result.quality if each.name in result.limits)
    for each in (*result.measurements, *limited):
        if result.recorded is not None and not each.is_told:
            continue  # below, with the reason
        held = result.judged.get(each.name)
        bounds = "" if held is None else held.limit.bounds
        beside = (
            (raw(result.published[each.name]) if each.name in result.published else NOTHING,)
            if published
            else ()
        )
        cells = (
            each.name,
            each.text,
            *beside,
            each.unit,
            bounds,
            verdict_text(held),
        )
        rows.append(cells)
    headings = (f">{name}" for name in published)
    columns = ("measurement", ">value ± U (95 %)", *headings, "unit", "limit", "verdict")
    output.table(title, columns, rows)
    _show_rules(output, result.judged)
    output.line(f"bundle: {result.bundle}")


def verdict_text(judged: JudgedLimit | None) -> str:
    """Return the verdict on a limit and, where that is known, the probability of conformance."""
    if judged is None or judged.conformance is None:
        return "" if judged is None else str(judged.verdict)
    return f"{judged.verdict}, P {probability(judged.conformance)}"


def _show_rules(output: Output, judged: Mapping[str, JudgedLimit]) -> None:
    """Print the decision rules of limits, what P is, and why some have none."""
    if not judged:
        return
    limits = {name: each.limit for name, each in judged.items()}
    meaning = next(iter(judged.values())).probability_of
    output.sentence(f"decision rule: {_rules(limits)}; P: {meaning}", "dim")
    for reason, names in _without_conformance(judged).items():
        output.sentence(f"no P of {named(tuple(names))}: {reason}", "dim")


def _without_conformance(judged: Mapping[str, JudgedLimit]) -> dict[str, list[str]]:
    """Return the names of limits without a probability of conformance, by the reason; those of measurements
    are told with these."""
    reasons: dict[str, list[str]] = {}
    for name, each in judged.items():
        if each.conformance is None:
            reasons.setdefault(each.without_conformance, []).append(name)
    return reasons


def _rules(limits: Mapping[str, Limit]) -> str:
    """Return the decision rule of each limit, those with simple acceptance together."""
    rules = [f"{name} {limit.rule}" for name, limit in limits.items() if limit.margin]
    simple = next((limit.rule for limit in limits.values() if not limit.margin), "")
    return ", ".join((*rules, f"{'others ' if rules else ''}{simple}") if simple else rules)
