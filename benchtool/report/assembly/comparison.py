"""The report that sets runs side by side: differences of measurements, of drives and of plans."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest

from benchtool.analysis import COVERAGE, NOTHING, Measurement, raw
from benchtool.block import Block
from benchtool.recording import Bundle, Manifest, read_manifest
from benchtool.report.assembly.comparison_front import comparison_front
from benchtool.report.assembly.figures import panel_of
from benchtool.report.assembly.front import fingerprint
from benchtool.report.assembly.pictures import picture, read_already
from benchtool.report.content import Cell, Facts, Grid, Item, Report, Section, Text
from benchtool.report.figures.drawings import comparable, draw_side_by_side
from benchtool.report.provenance import files_section, supervision_notes
from benchtool.report.results import (
    bounds_of,
    conformance_of,
    judged_value,
    mark,
    measurement_notes,
    verdict_cell,
)
from benchtool.results import (
    Assessment,
    Comparison,
    Delta,
    Differences,
    Kind,
    MeasuredCase,
    RepeatedCase,
    SideBySide,
    valued,
)

_MOST_PANELS = 9
_LONGEST = 24  # characters of a label that heads a column


def comparison_report(
    comparisons: Sequence[Comparison],
    alone: Sequence[str],
    folders: Sequence[str],
    repeated: Sequence[SideBySide[RepeatedCase]] = (),
) -> Report:
    """Return the report of a comparison.

    Args:
        alone: cases without a counterpart.
        folders: of the runs, as they were given.
        repeated: means over the repetitions of their cases.
    """
    first = next(iter(comparisons[0].results.values()))
    bundles = _bundles(comparisons)
    newest = max(bundle.manifest.when for _, bundle, _ in bundles)
    runs = list(_runs(comparisons))
    front = [*supervision_notes(bundle.manifest for _, bundle, _ in bundles)]
    items: list[Item] = []
    if alone:
        items.append(Text(f"Without a counterpart in the other runs: {', '.join(alone)}.", "warning"))
    for each in comparisons:
        many = len(comparisons) > 1
        warned = (Text(sentence, "warning") for sentence in each.unlike)
        late = (Text(f"Overdue: {one}.", "warning") for one in each.overdue)
        circumstances = _circumstances(Differences.of(each))
        body = (*warned, *late, *circumstances, *_measured(each), *_figures(each))
        items.append(Section(f"Case {each.case}" if many else "Comparison", body, listed=many))
    for means in repeated:
        title = "Means of the repetitions" + (f" of case {means.case}" if means.case else "")
        items.append(Section(title, (*_measured(means), *_limits_together(means)), listed=True))
    files = files_section(bundles, [f"benchtool compare {shlex.join(folders)}"])
    title = f"Comparison: {read_manifest(first.bundle)[0].what}"
    subtitle = f"Comparison of {len({label for label, _, _ in runs})} runs · {newest}"
    return Report(
        title,
        subtitle,
        newest,
        tuple(items),
        front=(*comparison_front(comparisons, runs), *front),
        appendix=(files,),
        fingerprint=fingerprint([bundle for _, bundle, _ in bundles]),
    )


def _runs(comparisons: Sequence[Comparison]) -> Iterator[tuple[str, Assessment, Manifest]]:
    for comparison in comparisons:
        for label, result in comparison.results.items():
            yield label, result, read_manifest(result.bundle)[0]


def _bundles(comparisons: Sequence[Comparison]) -> list[tuple[str, Bundle, Mapping[str, Block]]]:
    several = len(comparisons) > 1
    return [
        (
            f"{label}/{result.case}: " if several else f"{label}: ",
            Bundle.open(result.bundle, checked=True),
            read_already(result),
        )
        for comparison in comparisons
        for label, result in comparison.results.items()
    ]


def _limits_together(comparison: SideBySide[RepeatedCase]) -> Iterator[Item]:
    """Yield how each run meets its limits over the repetitions."""
    rows = [
        (
            *(each.name, label, bounds_of(each.limit), each.limit.rule),
            *("" if each.measured is None else each.measured.definition, judged_value(each.measured)),
            *(conformance_of(each), verdict_cell(each)),
        )
        for label, result in comparison.results.items()
        for each in result.judged
    ]
    headings = (
        "measurement",
        "run",
        "limit",
        "decision rule",
        "judged",
        ">value ± U (95 %)",
        ">P",
        "verdict",
    )
    if rows:
        yield Section("Limits over the repetitions", (Grid.of(headings, rows),))


def _measured(comparison: SideBySide[MeasuredCase]) -> Iterator[Item]:
    labels, names = list(comparison.results), valued(comparison)
    units = {each.name: each.unit for result in comparison.results.values() for each in result.measurements}
    rows: list[tuple[str | Cell, ...]] = [
        (
            Cell(name, notes=tuple(_notes(comparison, name))),
            *(_value(result, name) for result in comparison.results.values()),
            units[name],
        )
        for name in names
    ]
    values = Grid.of(("measurement", *(f">{_short(label)}" for label in labels), "unit"), rows)
    nowhere = [name for name in comparison.names if name not in names]
    left_out = (Text(f"Without a value in any run: {', '.join(nowhere)}.", "note"),) if nowhere else ()
    yield Section("Measurements", (values, *left_out))
    for label, deltas in comparison.deltas.items():
        headings = (
            "measurement",
            f">difference ± U ({100 * COVERAGE:g} %)",
            "unit",
            ">percent",
            "exceeds U",
            "judgement",
        )
        grid = Grid.of(headings, [delta_row(delta) for delta in deltas if delta.name in names])
        yield Section(f"{label} against {labels[0]}", (grid,))
    if chance := str(comparison.chance):
        yield Text(chance, "note")
    for sentence in comparison.not_compared:
        yield Text(f"Not compared: {sentence}", "note")
    for reason, without in comparison.without_uncertainty.items():
        yield Text(f"Without ±: {', '.join(without)}: {reason}.", "note")
    for reason, without in comparison.without_percent.items():
        yield Text(f"Not in percent: {', '.join(without)}: {reason}.", "note")


def _notes(comparison: SideBySide[MeasuredCase], name: str) -> Iterator[str]:
    """Definition, basis and source of the uncertainty, once where all runs have the same."""
    found = {label: _named(result, name) for label, result in comparison.results.items()}
    notes = {label: measurement_notes(each) for label, each in found.items() if each is not None}
    for sentences in zip_longest(*notes.values(), fillvalue=""):
        if len(set(sentences)) == 1:
            yield sentences[0]
        else:
            yield " ".join(f"{label}: {each}" for label, each in zip(notes, sentences, strict=True) if each)


def _named(result: MeasuredCase, name: str) -> Measurement | None:
    return next((each for each in result.measurements if each.name == name), None)


def _value(result: MeasuredCase, name: str) -> Cell:
    measured = _named(result, name)
    if measured is None:
        return Cell(NOTHING)
    return Cell(measured.text, mark(result.verdicts[name]) if name in result.verdicts else "")


def delta_row(delta: Delta) -> tuple[str | Cell, ...]:
    """Name, difference with its uncertainty, unit, percent, whether it exceeds that, better or worse."""
    exceeds = {True: "yes", False: "no", None: NOTHING}[delta.exceeds]
    judged = Cell(delta.judgement, delta.judgement) if delta.judgement else Cell("")
    percent = f"{delta.percent_text} %" if delta.percent_text else NOTHING
    return delta.name, delta.text, delta.unit, percent, exceeds, judged


def _short(label: str) -> str:
    return label if len(label) <= _LONGEST else f"…{label[1 - _LONGEST :]}"


def _figures(comparison: Comparison) -> Iterator[Item]:
    shown = list(comparison.results.items())[:_MOST_PANELS]
    panels = [panel_of(result, label) for label, result in shown]
    figures: list[Item] = [picture(name, draw_side_by_side(name, panels)) for name in comparable(panels)]
    if figures:
        left_out = len(comparison.results) - len(shown)
        more = [Text(f"{left_out} more runs are not drawn.", "note")] if left_out else []
        yield Section("Figures", (*figures, *more))


def _circumstances(differences: Differences) -> Iterator[Item]:
    """Yield what else the runs differ in, and what of their measurements cannot be compared."""
    headings = ("what", *(_short(label) for label in differences.labels))
    sections: list[Item] = []
    for kind in Kind:
        rows = [
            (each.key, *(NOTHING if value is None else raw(value) for value in each.values.values()))
            for each in differences.of_kind(kind)
        ]
        if rows:
            title = f"{str(kind)[0].upper()}{str(kind)[1:]}"
            sections.append(Section(title, (Grid.of(headings, rows),)))
    if differences.same:
        sections.append(Facts((("the same in all runs", "; ".join(map(str, differences.same))),)))
    sections += [
        Text(f"Not compared with {label}: {', '.join(names)}: {reason}.", "note")
        for (label, reason), names in differences.reasons.items()
    ]
    yield Section("What else differs", tuple(sections))
