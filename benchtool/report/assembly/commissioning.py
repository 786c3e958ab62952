"""The report of a commissioning: estimates beside the nameplate, parameters, each step's captures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final

from benchtool.analysis import (
    NOTHING,
    analyze_response,
    count_of,
    measurements_from_json,
    number,
    raw,
    with_expanded,
)
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.recording import Bundle
from benchtool.report import content
from benchtool.report.assembly.front import ROLES, fingerprint
from benchtool.report.content import Cell, Facts, Grid, Item, Mark, Picture, Report, Section, Signatures, Text
from benchtool.report.figures.bode import draw_bode
from benchtool.report.figures.overview import draw_channels
from benchtool.report.provenance import files_section, run_facts
from benchtool.report.results import budgets_section, measurements_section

_MARKS: Final[Mapping[str, Mark]] = {"pass": "pass", "fail": "fail", "skipped": "none"}
_MOST_PICTURES: Final = 3  # of a step
CAPTURES: Final = "captures"
"""Key of a manifest's details: the title of each capture, by the name of its stream."""
LOOPS: Final = "measured_loops"
"""Key of a manifest's details: captures that hold a loop's response, each with its input and output."""


def commissioning_report(document: Mapping[str, Any], bundles: Sequence[Bundle]) -> Report:
    """Return the report of a commissioning.

    Args:
        document: as `benchtool.commission.document` makes it.
        bundles: of the steps, in their order.

    Raises:
        RecordingError: a bundle cannot be read.
    """
    manifest = bundles[0].manifest if bundles else None
    when = manifest.when if manifest else ""
    front: list[Item] = [_verdict(document), *_warnings(document)]
    results = {name for each in document["steps"].values() for name in each["sets"]}
    results |= {name for name, each in document["estimates"].items() if each.get("nameplate") is not None}
    front.append(_estimates("Results", document, bundles, results))
    if manifest is not None:
        front.append(Section("What was commissioned", (run_facts(manifest),)))
    front.append(Signatures(ROLES))
    items: list[Item] = [_steps(document), *_conventions(document), _parameters(document)]
    items += [_step(bundle) for bundle in bundles]
    everything = _estimates("Every estimate", document, bundles, set(document["estimates"]))
    items.append(replace(everything, listed=True, folded=True, paper=False))
    appendix: list[Item] = [
        replace(budgets, title=f"{budgets.title} of step {each.directory.name}")
        for each in bundles
        if (budgets := budgets_section(measurements_from_json(each.measurements))) is not None
    ]
    if manifest is not None:
        command = f"benchtool {' '.join(manifest.command_line)}"
        named: list[tuple[str, Bundle, Mapping[str, Block]]] = [
            (f"{bundle.directory.name}/", bundle, {}) for bundle in bundles
        ]
        appendix.append(files_section(named, [command], by="the command"))
    profile = manifest.profile_name if manifest else ""
    return Report(
        f"Commissioning of {profile}",
        f"Motor and drive · {when}",
        when,
        tuple(items),
        front=tuple(front),
        appendix=tuple(appendix),
        fingerprint=fingerprint(bundles) if bundles else "",
    )


def _verdict(document: Mapping[str, Any]) -> content.Verdict:
    steps = document["steps"].values()
    passed = sum(each["verdict"] == "pass" for each in steps)
    kept = "the drive has stored the parameters" if document["saved"] else "nothing was stored"
    summary = f"{passed} of {len(steps)} steps passed, {kept}."
    mark: Mark = "pass" if document["verdict"] == "pass" else "fail"
    return content.Verdict(mark, f"{content.SYMBOLS[mark]} {mark.capitalize()}", summary)


def _warnings(document: Mapping[str, Any]) -> Iterator[Text]:
    for each in document["findings"]:
        yield Text(
            f"{_sentence(each['what'])} Probably {each['cause']}. Remedy: {each['remedy']}.", "warning"
        )
    if document["not_saved"]:
        yield Text(f"The drive stores what it stored before: {document['not_saved']}.", "note")


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


def _estimates(
    title: str, document: Mapping[str, Any], bundles: Sequence[Bundle], shown: Set[str]
) -> Section:
    """Return some estimates beside the nameplate; one that is not as it should be is always among them."""
    measured = {each.name: each for bundle in bundles for each in measurements_from_json(bundle.measurements)}
    rows = []
    for name, each in document["estimates"].items():
        found = measured.get(name)
        off = each.get("deviation_percent")
        said = each.get("looks_like", "")
        if name not in shown and not said:
            continue
        notes = tuple(filter(None, (each.get("method") or "", each.get("reason") or "")))
        rows.append(
            (
                Cell(name, notes=notes),
                NOTHING
                if found is None or each["value"] is None
                else with_expanded(found.value, found.uncertainty),
                each.get("unit") or "",
                NOTHING if each.get("nameplate") is None else number(each["nameplate"]),
                Cell(NOTHING if off is None else f"{off:+.2f}".replace("-", "−"), "fail" if said else ""),
                said or each.get("reason") or _contains(each),
            )
        )
    headings = ("estimate", ">value ± U (95 %)", "unit", ">nameplate", ">deviation (%)", "remark")
    caption = "Per phase, amplitude-invariant (peak); each with its method, which unfolds."
    return Section(title, (Grid.of(headings, rows, caption),))


def _contains(estimate: Mapping[str, Any]) -> str:
    contains = estimate.get("contains", "")
    return f"with {contains}" if contains else ""


def _steps(document: Mapping[str, Any]) -> Section:
    rows = [
        (
            name,
            Cell(each["verdict"], _MARKS[each["verdict"]]),
            number(each["energy_J"], 3),
            number(each["spent_J"], 3),
            each["reason"] or ("done in an earlier session" if each["resumed"] else ""),
        )
        for name, each in document["steps"].items()
    ]
    headings = ("step", "verdict", ">planned (J)", ">spent (J)", "remark")
    caption = (
        "Energy: heat in the winding and mechanical work, as planned with what was known before, and of "
        "the captures."
    )
    return Section("Steps", (Grid.of(headings, rows, caption),), listed=True)


def _conventions(document: Mapping[str, Any]) -> Iterator[Section]:
    """Yield the estimates as nameplates state them."""
    rows = [(each["name"], number(each["value"]), each["unit"]) for each in document["conventions"]]
    if rows:
        grid = Grid.of(("as a nameplate states it", ">value", "unit"), rows)
        yield Section("In other conventions", (grid,), listed=True, short=True)


def _parameters(document: Mapping[str, Any]) -> Section:
    pairs = tuple(
        (key, number(value) if isinstance(value, float) else str(value))
        for key, value in document["parameters"].items()
    )
    return Section("Parameters of the drive", (Facts(pairs),), listed=True, folded=True, short=True)


def _step(bundle: Bundle) -> Section:
    name = bundle.directory.name
    measurements = measurements_from_json(bundle.measurements)
    items: list[Item] = [measurements_section("Estimates and measurements", measurements, {}, {})]
    items += _pictures(bundle)
    return Section(f"Step {name}", tuple(items), listed=True, short=True)


def _pictures(bundle: Bundle) -> Iterator[Picture]:
    loops, titles = (bundle.manifest.details.get(key, {}) for key in (LOOPS, CAPTURES))
    for stream, loop in loops.items():
        try:
            bode = analyze_response(bundle.block(stream), loop["input"], loop["output"], **loop["rows"])
        except AnalysisError:
            continue
        figure = draw_bode({loop["title"]: bode}, loop["title"])
        yield Picture(
            figure, "Gain, phase and coherence of the closed loop.", content.describe_figure(figure)
        )
    streams = [each for each in bundle.streams if each not in loops]
    for stream in streams[:_MOST_PICTURES]:
        block = bundle.block(stream)
        figure = draw_channels(block, titles.get(stream, stream))
        captures = count_of(len(streams), "capture")
        caption = f"{count_of(len(block.data), 'row')} at {raw(block.sample_rate_Hz)} Hz of {captures}."
        yield Picture(figure, caption, content.describe_figure(figure))
