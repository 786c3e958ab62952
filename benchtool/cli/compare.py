"""`benchtool compare RUN RUN ...`."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from benchtool.analysis import NOTHING, catalogue, placed
from benchtool.cli import options, selection as chosen
from benchtool.cli.differences import show_differences
from benchtool.cli.fitting import named
from benchtool.cli.output import VERDICT_COLOURS, Output, warn_incomplete, warn_overdue
from benchtool.cli.results import show_contradicted, show_disagreements, verdict_text
from benchtool.cli.side_by_side import Column, show_beside
from benchtool.errors import UsageError, of_each
from benchtool.report import report_files
from benchtool.results import (
    Chance,
    Comparison,
    Delta,
    Differences,
    MeasuredCase,
    Repeated,
    RepeatedCase,
    SideBySide,
    compare_cases,
    compare_repeated,
    complete_of,
    recorded_bundles,
    recorded_runs,
    repeated_cases,
    valued,
)

_LEAST_PLACE = 1e-6  # of a value without uncertainty: smaller differences do not show in it
_MOST_PLACE = 0.01  # likewise: of another run that is far off, it keeps its digits
_MOST_COLUMNS = 3  # runs side by side in a terminal; more are listed below each other


def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN...", help="Run bundles, or folders of a run of several cases."),
    ],
    stream: chosen.Stream = "",
    from_: chosen.From = None,
    to: chosen.To = None,
    analysis: chosen.Asked = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as an HTML page.")
    ] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write a PDF too, beside the page.")] = False,
    as_json: options.Json = False,
) -> int:
    """Measure recorded runs again and set them side by side; differences are against the first.

    What else differs stands before the numbers: operating points, parameters, limits, firmware, profile and
    options of the analyses, and what cannot be compared. --stream, --from, --to and --analysis choose of
    every run, as with analyze.
    """
    if pdf and html is None:
        raise UsageError("--pdf writes a PDF beside the page of --html, which was not given: add --html FILE")
    output = Output(as_json=as_json)
    selection = chosen.selection(stream, from_, to, analysis)
    of_each(recorded_bundles, runs)  # before the first is measured
    if html is not None:
        report_files(html, pdf=pdf)
    recorded = {label: recorded_runs(run, selection) for label, run in zip(_labels(runs), runs, strict=True)}
    found = {
        label: complete_of(of_one, run) for (label, of_one), run in zip(recorded.items(), runs, strict=True)
    }
    warn_incomplete(output, [each for of_one in recorded.values() for each in of_one])
    repeated = {label: repeated_cases(of_one) for label, of_one in recorded.items()}
    comparisons, alone = compare_cases(found)
    over_repetitions = compare_repeated(repeated)
    if len(found) == 1 and not any(comparison.deltas for comparison in comparisons):
        raise UsageError(f"{runs[0]} is one run of one case, two are compared: name another run beside it")
    differences = [Differences.of(comparison) for comparison in comparisons]
    for comparison, circumstances in zip(comparisons, differences, strict=True):
        show_differences(output, comparison.case, circumstances)
        show(output, comparison)
        warn_overdue(output, comparison.overdue)
    for means in over_repetitions:
        _show_repeated(output, means)
    if alone:
        output.sentence(f"without a counterpart: {', '.join(alone)}")
    written = {}
    if html is not None:
        if not comparisons:
            raise UsageError("no case of the first run has a counterpart: compare runs of the same plan")
        from benchtool.cli.report import write_report  # draws in matplotlib, which a comparison does not need
        from benchtool.report.assembly import comparison_report

        report = comparison_report(comparisons, alone, [str(run) for run in runs], over_repetitions)
        page, document = write_report(report, html, pdf=pdf, output=output)
        written = {"report": str(page), "pdf": None if document is None else str(document)}
    output.document(
        {
            "cases": {
                f"{label}:{each.case}" if len(found) > 1 else each.case: each.to_json()
                for label, results in found.items()
                for each in results
            },
            "circumstances": {
                comparison.case or "comparison": each.to_json()
                for comparison, each in zip(comparisons, differences, strict=True)
            },
            "without_counterpart": list(alone),
            "deltas": _deltas(comparisons, alone_run=len(found) == 1),
            **_repeated(repeated, over_repetitions),
            **written,
        }
    )
    return 0


def _labels(runs: Sequence[Path]) -> list[str]:
    """Return the folders' names; where two are called the same, their paths."""
    names = [os.path.basename(os.path.realpath(run)) for run in runs]  # resolve() raises on a loop of links
    labels = [str(run) if names.count(name) > 1 else name for run, name in zip(runs, names, strict=True)]
    return [
        f"{label}#{labels[: place + 1].count(label)}" if labels.count(label) > 1 else label
        for place, label in enumerate(labels)
    ]


def _deltas(comparisons: Sequence[SideBySide[MeasuredCase]], *, alone_run: bool) -> dict[str, object]:
    """Return every difference by case (as `cases` lists it), with what it is a difference to."""
    document: dict[str, object] = {}
    for comparison in comparisons:
        keys = {
            label: label if alone_run else f"{label}:{result.case}"
            for label, result in comparison.results.items()
        }
        reference, *_ = keys.values()
        for label, deltas in comparison.deltas.items():
            document[keys[label]] = {
                "against": reference,
                "differences": Chance.of(deltas).to_json(),
                "measurements": {delta.name: delta.to_json() for delta in deltas},
            }
    return document


def _repeated(
    runs: Mapping[str, Mapping[str, Sequence[Repeated]]], compared: Sequence[SideBySide[RepeatedCase]]
) -> dict[str, object]:
    """Return what each case came to over its repetitions, and the differences of the means; nothing without
    repetitions."""
    found = {
        f"{label}:{case}" if len(runs) > 1 else case: {each.name: each.to_json() for each in together}
        for label, cases in runs.items()
        for case, together in cases.items()
    }
    return (
        {"repeated": found, "repeated_deltas": _deltas(compared, alone_run=len(runs) == 1)} if found else {}
    )


def _show_repeated(output: Output, comparison: SideBySide[RepeatedCase]) -> None:
    """Print the means of runs side by side, and how each meets the limits over its repetitions."""
    letters = _letters(comparison)
    title = f"{comparison.case or 'comparison'}: means of the repetitions"
    _show_columns(output, title, comparison, letters)
    _show_lacking(output, comparison)
    for label, result in comparison.results.items():
        for each in result.judged:
            told = f": it {each.told.reason}" if each.told else ""
            waived = " (waived)" if each.waived else ""
            output.sentence(
                f"{letters[label]}: {each.name}: {verdict_text(each)}, {each.judge} {each.bounds}"
                f"{waived}{told}",
                VERDICT_COLOURS[each.counted],
            )
            show_contradicted(output, f"{letters[label]}: ", each)


def _show_lacking(output: Output, comparison: SideBySide[MeasuredCase]) -> None:
    """Print why values are not compared, and why differences have no uncertainty, or are not in percent."""
    for sentence in comparison.not_compared:
        output.sentence(f"not compared: {sentence}", "dim")
    for what, found in (("±", comparison.without_uncertainty), ("%", comparison.without_percent)):
        for reason, names in found.items():
            output.sentence(f"without {what}: {named(names)}: {reason}", "dim")


def _letters(comparison: SideBySide[MeasuredCase]) -> dict[str, str]:
    """Return by what each run is called in a table."""
    labels = enumerate(comparison.results)
    return {label: chr(ord("A") + place) if place < 26 else str(place + 1) for place, label in labels}


def show(output: Output, comparison: Comparison) -> None:
    """Print the measurements of runs side by side, and what bears on the differences."""
    results, letters = comparison.results, _letters(comparison)
    _show_columns(output, comparison.case or "comparison", comparison, letters)
    output.sentence(
        "* beyond its expanded uncertainty (95 %), ~ within it; ✓ better, ✗ worse by a limit", "dim"
    )
    if chance := str(comparison.chance):
        output.sentence(chance, "dim")
    _show_lacking(output, comparison)
    for sentence in comparison.unlike:
        output.sentence(sentence, "yellow")
    prefixed = [(f"{letters[label]}: ", result) for label, result in results.items()]
    show_disagreements(output, prefixed, "runs")
    for label, result in results.items():
        place = "" if label == str(result.bundle) else f": {result.bundle}"
        output.line(f"{letters[label]}  {label}{place}")


def _show_columns(
    output: Output, title: str, comparison: SideBySide[MeasuredCase], letters: Mapping[str, str]
) -> None:
    """Print what was measured, with the difference of each run to the first: a row for each measurement or,
    of many runs, for each run with the headline measurements."""
    if len(comparison.results) > _MOST_COLUMNS:
        _show_many(output, title, comparison, letters)
        return
    first, *others = comparison.results
    units = _units(comparison)
    shown = list(valued(comparison))
    groups = [
        [
            Column(f">{letters[label]}", tuple(_value(comparison, label, name) for name in shown)),
            Column(f">{letters[label]}−A ± U", tuple(_difference(comparison, label, name) for name in shown)),
            Column(">%", tuple(_percent(_delta(comparison, label, name)) for name in shown)),
        ]
        for label in others
    ]
    names = Column("measurement", tuple(shown))
    reference = Column(f">{letters[first]}", tuple(_value(comparison, first, name) for name in shown))
    show_beside(
        output, title, [names, reference], groups, [Column("unit", tuple(units[name] for name in shown))]
    )


def _show_many(
    output: Output, title: str, comparison: SideBySide[MeasuredCase], letters: Mapping[str, str]
) -> None:
    """Print a row for each run with the headline measurements; the documents contain all."""
    known, units = comparison.names, _units(comparison)
    names: list[str] = [name for name in catalogue().headline if name in known] or list(known[:4])
    runs = list(comparison.results)
    groups = [
        [
            Column(
                f">{name} ({units[name]})" if units[name] else f">{name}",
                tuple(_value(comparison, label, name) for label in runs),
            ),
            Column(">less A ± U", tuple(_difference(comparison, label, name) for label in runs)),
            Column(">%", tuple(_percent(_delta(comparison, label, name)) for label in runs)),
        ]
        for name in names
    ]
    labels = Column("run", tuple(f"{letters[label]} {label}" for label in runs))
    show_beside(output, title, [labels], groups)


def _units(comparison: SideBySide[MeasuredCase]) -> dict[str, str]:
    return {each.name: each.unit for result in comparison.results.values() for each in result.measurements}


def _value(comparison: SideBySide[MeasuredCase], label: str, name: str) -> str:
    """Return the value to the place of its uncertainty; where it has none, to that of the difference, and
    with four digits at least."""
    found = next((each for each in comparison.results[label].measurements if each.name == name), None)
    if found is None:
        return NOTHING
    if found.upper_bound is not None:
        return found.text
    if found.uncertainty is not None:
        return placed(found.value, found.uncertainty.expanded)
    apart = [
        abs(each.absolute) for each in _deltas_of(comparison, label, name) if math.isfinite(each.absolute)
    ]
    least = min((each for each in apart if each > 0.0), default=math.nan)
    size = abs(found.value)
    return placed(found.value, min(max(least, _LEAST_PLACE * size), _MOST_PLACE * size))


def _deltas_of(comparison: SideBySide[MeasuredCase], label: str, name: str) -> list[Delta]:
    """Return the differences of a run to the reference, or of all runs to it if it is the reference."""
    labels = [label] if label in comparison.deltas else list(comparison.deltas)
    return [delta for each in labels if (delta := _delta(comparison, each, name)) is not None]


def _delta(comparison: SideBySide[MeasuredCase], label: str, name: str) -> Delta | None:
    return next((each for each in comparison.deltas.get(label, ()) if each.name == name), None)


def _difference(comparison: SideBySide[MeasuredCase], label: str, name: str) -> str:
    """Return the difference to the first run with its uncertainty."""
    delta = _delta(comparison, label, name)
    return NOTHING if delta is None else delta.text


def _percent(delta: Delta | None) -> Text:
    if delta is None:
        return Text(NOTHING)
    judged, style = {"better": ("✓", "green"), "worse": ("✗", "red"), "": ("", "")}[delta.judgement]
    return Text(f"{delta.marked_percent()}{judged}", style=style)
