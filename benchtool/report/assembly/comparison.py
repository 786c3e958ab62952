"""The report that sets runs side by side: differences of what was measured, of the drive and of the plan."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import Measurement
from benchtool.analysis.uncertainty import COVERAGE
from benchtool.block import Block
from benchtool.plan.model import Plan
from benchtool.recording import Bundle, Manifest
from benchtool.recording.manifest import read_manifest
from benchtool.report.assembly.figures import panel_of
from benchtool.report.assembly.marks import mark, picture, read_already
from benchtool.report.content import Cell, Facts, Grid, Item, Report, Section, Text
from benchtool.report.figures.drawings import comparable, draw_side_by_side
from benchtool.report.numbers import NOTHING, raw, signed, with_expanded
from benchtool.report.origin import files_section, supervision_notes
from benchtool.report.results import measurement_notes
from benchtool.results.assessment import Assessment
from benchtool.results.comparison import Comparison, Delta

_MOST_PANELS = 9
_LONGEST = 24  # characters of a label that heads a column


def comparison_report(
    comparisons: Sequence[Comparison], alone: Sequence[str], folders: Sequence[str]
) -> Report:
    """The report of a comparison.

    Args:
        alone: cases without a counterpart.
        folders: of the runs, as they were given.
    """
    first = next(iter(comparisons[0].results.values()))
    bundles = _bundles(comparisons)
    newest = max(bundle.manifest.when for _, bundle, _ in bundles)
    rows = [(label, result.case, str(result.bundle.name), when) for label, result, when in _runs(comparisons)]
    items: list[Item] = [
        Section(
            "What is compared", (Grid.of(("run", "case", "folder", "begun"), rows), _reading(comparisons))
        ),
        *supervision_notes(bundle.manifest for _, bundle, _ in bundles),
    ]
    if alone:
        items.append(Text(f"Without a counterpart in the other runs: {', '.join(alone)}.", "warning"))
    for each in comparisons:
        many = len(comparisons) > 1
        warned = (Text(each.lengths, "warning"),) if each.lengths else ()
        late = (Text(f"Overdue: {one}.", "warning") for one in each.overdue)
        body = (*warned, *late, *_measured(each), *_figures(each), *_circumstances(each))
        items.append(Section(f"Case {each.case}" if many else "Comparison", body, listed=many))
    items.append(files_section(bundles, [f"benchtool compare {shlex.join(folders)}"]))
    title = f"Comparison: {read_manifest(first.bundle)[0].what}"
    subtitle = f"Comparison of {len({label for label, _, _ in _runs(comparisons)})} runs · {newest}"
    return Report(title, subtitle, newest, tuple(items))


def _runs(comparisons: Sequence[Comparison]) -> Iterator[tuple[str, Assessment, str]]:
    for comparison in comparisons:
        for label, result in comparison.results.items():
            yield label, result, read_manifest(result.bundle)[0].when


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


def _reading(comparisons: Sequence[Comparison]) -> Text:
    reference = next(iter(comparisons[0].results))
    return Text(
        f"Differences are taken against {reference}. A difference exceeds its uncertainty if it is larger "
        f"than U, the expanded uncertainty for {100 * COVERAGE:g} % from both values, with k from their "
        f"effective degrees of freedom; where one has no uncertainty, this is not decided. Better and worse "
        f"are said only where a limit tells which direction is good.",
        "note",
    )


def _measured(comparison: Comparison) -> Iterator[Item]:
    labels = list(comparison.results)
    units = {each.name: each.unit for result in comparison.results.values() for each in result.measurements}
    rows: list[tuple[str | Cell, ...]] = [
        (
            Cell(name, notes=tuple(_notes(comparison, name))),
            *(_value(result, name) for result in comparison.results.values()),
            units[name],
        )
        for name in comparison.names
    ]
    values = Grid.of(("measurement", *(f">{_short(label)}" for label in labels), "unit"), rows)
    yield Section("Measurements", (values,))
    for label, deltas in comparison.deltas.items():
        headings = (
            "measurement",
            f">difference ± U ({100 * COVERAGE:g} %)",
            "unit",
            ">percent",
            "exceeds uncertainty",
            "judgement",
        )
        grid = Grid.of(headings, [delta_row(delta) for delta in deltas])
        yield Section(f"{label} against {labels[0]}", (grid,))
    if chance := str(comparison.chance):
        yield Text(chance, "note")


def _notes(comparison: Comparison, name: str) -> Iterator[str]:
    """Definition, basis and source of the uncertainty, once where all runs have the same."""
    found = {label: _named(result, name) for label, result in comparison.results.items()}
    notes = {label: measurement_notes(each) for label, each in found.items() if each is not None}
    for sentences in zip_longest(*notes.values(), fillvalue=""):
        if len(set(sentences)) == 1:
            yield sentences[0]
        else:
            yield " ".join(f"{label}: {each}" for label, each in zip(notes, sentences, strict=True) if each)


def _named(result: Assessment, name: str) -> Measurement | None:
    return next((each for each in result.measurements if each.name == name), None)


def _value(result: Assessment, name: str) -> Cell:
    measured = _named(result, name)
    if measured is None:
        return Cell(NOTHING)
    text = with_expanded(measured.value, measured.uncertainty)
    return Cell(text, mark(result.verdicts[name])) if name in result.verdicts else Cell(text)


def delta_row(delta: Delta) -> tuple[str | Cell, ...]:
    """Name, difference with its uncertainty, unit, percent, whether it exceeds that, better or worse."""
    exceeds = {True: "yes", False: "no", None: NOTHING}[delta.exceeds]
    judged = Cell(delta.judgement, delta.judgement) if delta.judgement else Cell("")
    percent = f"{signed(delta.percent)} %" if math.isfinite(delta.percent) else NOTHING
    return delta.name, difference(delta), delta.unit, percent, exceeds, judged


def difference(delta: Delta) -> str:
    """A difference with its sign and its expanded uncertainty, as far as there is one."""
    text = with_expanded(delta.absolute, delta.uncertainty)
    if "±" not in text:
        return signed(delta.absolute)
    if delta.absolute <= 0.0:
        return text
    return f"(+{text[1:]}" if text.startswith("(") else f"+{text}"


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


def _circumstances(comparison: Comparison) -> Iterator[Item]:
    manifests = {label: read_manifest(result.bundle)[0] for label, result in comparison.results.items()}
    kinds: dict[str, Mapping[str, Mapping[str, object]]] = {
        "Drive parameters": {label: each.parameters for label, each in manifests.items()},
        "Plan": {label: _flat(_plan(each)) for label, each in manifests.items()},
        "Operating point": {
            label: _flat(each.details.get("operating_point", {})) for label, each in manifests.items()
        },
        "Profile, drive and versions": {
            label: {
                "link": each.link,
                "profile": each.profile_name,
                "contents of the profile": "as the first"
                if each.profile_toml == _first(manifests).profile_toml
                else "differ",
                "seed": each.seed,
                "dictionary": each.dictionary_hash,
                **each.identity,
                **each.versions,
            }
            for label, each in manifests.items()
        },
    }
    sections: list[Item] = []
    same = []
    for title, held in kinds.items():
        if rows := differences(held):
            sections.append(
                Section(title, (Grid.of(("what", *(f"{_short(label)}" for label in held)), rows),))
            )
        else:
            same.append(title.lower())
    if same:
        sections.append(Facts((("the same in all runs", "; ".join(same)),)))
    yield Section("What else differs", tuple(sections))


def _plan(manifest: Manifest) -> Mapping[str, Any]:
    """The plan of a bundle as this version writes it, so that an older form is no difference."""
    recorded: Mapping[str, Any] = manifest.details.get("plan", {})
    try:
        return Plan.model_validate(recorded).model_dump(mode="json") if recorded else {}
    except ValidationError:
        return recorded


def _first(manifests: Mapping[str, Any]) -> Any:
    return next(iter(manifests.values()))


def differences(held: Mapping[str, Mapping[str, object]]) -> list[tuple[str, ...]]:
    """The keys whose values are not the same in all of `held`, with every value."""
    keys = dict.fromkeys(key for values in held.values() for key in values)
    rows = []
    for key in keys:
        values = [values.get(key) for values in held.values()]
        if any(each != values[0] for each in values):
            rows.append((key, *(NOTHING if each is None else raw(each) for each in values)))
    return rows


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, object]:
    flat: dict[str, object] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            flat[f"{prefix}{key}"] = ", ".join(str(each) for each in value)
        else:
            flat[f"{prefix}{key}"] = value
    return flat
