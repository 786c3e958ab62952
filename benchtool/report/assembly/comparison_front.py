"""The first page of a comparison: which runs, on what, what differs by more than its uncertainty, and the
verdicts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from benchtool.analysis import COVERAGE, catalogue
from benchtool.plan import Verdict, worst
from benchtool.recording import Manifest
from benchtool.report import content
from benchtool.report.assembly.front import ROLES, equipment, motor_rating
from benchtool.report.content import Cell, Facts, Grid, Item, Mark, Section, Signatures, Text
from benchtool.report.provenance import drive_numbers, link_of, profile_of
from benchtool.report.results import mark
from benchtool.results import Assessment, Comparison, Delta, Differences, Kind

_MOST_TOLD: Final = 14
_MOST_RUNS: Final = 12  # on paper


def comparison_front(
    comparisons: Sequence[Comparison], runs: Sequence[tuple[str, Assessment, Manifest]]
) -> Iterator[Item]:
    """Yield what stands on the first page of a comparison.

    Args:
        runs: label, result and manifest of each case of each run.
    """
    yield _banner(comparisons)
    rows = [
        (
            label,
            result.case,
            str(result.bundle.name),
            manifest.when,
            Cell(str(result.verdict), mark(result.verdict)),
        )
        for label, result, manifest in runs
    ]
    grid = Grid.of(("run", "case", "folder", "begun", "verdict"), rows, shown=_MOST_RUNS)
    yield Section("What is compared", (grid, _on_what([manifest for _, _, manifest in runs])))
    if besides := _besides(comparisons):
        yield Text(f"The runs differ besides in: {', '.join(besides)}.", "warning")
    yield Section(
        "Differences that exceed their uncertainty", (*_differences(comparisons), _reading(comparisons))
    )
    yield Signatures(ROLES)


def _banner(comparisons: Sequence[Comparison]) -> content.Verdict:
    deltas = [each for one in comparisons for found in one.deltas.values() for each in found]
    decided = [each for each in deltas if each.exceeds is not None]
    apart = sum(each.exceeds is True for each in decided)
    judged = {name: sum(each.judgement == name for each in deltas) for name in ("better", "worse")}
    said = ", ".join(f"{count} {name}" for name, count in judged.items() if count)
    by_limits = f": {said} by a limit" if said else ""
    parts = [f"{apart} of {len(decided)} differences exceed their uncertainty{by_limits}"]
    if open_ := len(deltas) - len(decided):
        parts.append(f"{open_} have none and are not decided")
    verdict = worst(each.verdict for one in comparisons for each in one.results.values())
    if verdict is not Verdict.NONE:
        parts.append(f"worst verdict of the cases, each by itself: {verdict}")
    sign: Mark = "worse" if judged["worse"] else "better" if judged["better"] else "none"
    title = {"worse": "Worse", "better": "Better", "none": "Differences" if apart else "No difference found"}[
        sign
    ]
    return content.Verdict(sign, f"{content.SYMBOLS[sign]} {title}", f"{'; '.join(parts)}.")


def _on_what(manifests: Sequence[Manifest]) -> Facts:
    """Return the motor, drive and bench; where the runs do not have the same, each of them."""
    pairs: dict[str, dict[str, None]] = {}
    for manifest in manifests:
        profile, identity = profile_of(manifest), manifest.identity
        number = manifest.conditions.test_object_serial_number
        drive = ", ".join(filter(None, (str(identity.get("device_name", "")), drive_numbers(identity))))
        versions = (
            str(identity[key]) for key in ("hardware_version", "firmware_version") if identity.get(key)
        )
        link = link_of(manifest)
        told = {
            "test object": f"serial number {number}" if number else "serial number not stated",
            "motor": "" if profile is None else motor_rating(profile),
            "profile": manifest.profile_name,
            "drive": drive,
            "hardware, firmware": ", ".join(versions),
            "link": link,
            "bench": "" if profile is None else ", ".join(equipment(profile, link)),
            "operator": manifest.conditions.operator or "not stated",
        }
        for name, what in told.items():
            if what:
                pairs.setdefault(name, {})[what] = None
    return Facts(tuple((name, "; ".join(found)) for name, found in pairs.items()))


def _besides(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    """Return the kinds of circumstances in which runs differ."""
    found = [Differences.of(one) for one in comparisons]
    return tuple(str(kind) for kind in Kind if any(list(each.of_kind(kind)) for each in found))


def _differences(comparisons: Sequence[Comparison]) -> Iterator[Item]:
    """Yield the first of them, those that a limit judges before headline measurements and others."""
    headline = catalogue().headline
    limited = {name for one in comparisons for result in one.results.values() for name in result.limits}

    def foremost(found: tuple[str, Delta]) -> int:
        delta = found[1]
        return 0 if delta.judgement else 1 if delta.name in limited else 2 if delta.name in headline else 3

    several = len(comparisons) > 1
    found = [
        (f"{one.case}: {label}" if several else label, delta)
        for one in comparisons
        for label, deltas in one.deltas.items()
        for delta in deltas
        if delta.exceeds
    ]
    if not found:
        yield Text("None.", "note")
        return
    first = next(iter(comparisons[0].results))
    headings = ("measurement", "run", f">{first}", ">run", ">difference ± U (95 %)", "unit", "judgement")
    shown = sorted(found, key=foremost)[:_MOST_TOLD]
    rows = [
        (
            delta.name,
            label,
            delta.reference_text,
            delta.value_text,
            delta.text,
            delta.unit,
            Cell(delta.judgement, delta.judgement) if delta.judgement else "",
        )
        for label, delta in shown
    ]
    yield Grid.of(headings, rows)
    if more := len(found) - len(shown):
        yield Text(f"{more} more stand with the measurements.", "note")


def _reading(comparisons: Sequence[Comparison]) -> Text:
    reference = next(iter(comparisons[0].results))
    return Text(
        f"Differences are taken against {reference}. A difference exceeds its uncertainty if it is larger "
        f"than U, the expanded uncertainty for {100 * COVERAGE:g} % from both values, with Student's factor "
        f"of their effective degrees of freedom; where one has no uncertainty, this is not decided. Better "
        f"and worse are said only where a limit tells which direction is good.",
        "note",
    )
