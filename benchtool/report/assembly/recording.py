"""What a report says of a recording without a plan: regimes, rows that were measured, what is undefined."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.analysis import NOTHING, number, raw, undefined
from benchtool.plan import Plan, recorded_plan
from benchtool.recording import Bundle
from benchtool.report.content import Facts, Grid, Item, Section, Text
from benchtool.results import Assessment, Recorded, is_planned


def plan_of(bundle: Bundle) -> Plan | None:
    """Return the plan that was run; None of a recording."""
    return recorded_plan(bundle.manifest.details["plan"]) if is_planned(bundle) else None


def recording_items(result: Assessment) -> Iterator[Item]:
    """Yield which rows of a recording the numbers are of; nothing of a run of a plan."""
    if result.recorded is None:
        return
    source = result.recorded.source(result.capture)
    facts = (
        (
            "stream",
            f"{source['stream']}, {raw(source['rate_Hz'])} Hz, every {source['stride']} control ticks",
        ),
        ("measured", f"{raw(source['from_s'])} s to {raw(source['to_s'])} s after the first row"),
        ("ticks", f"{source['first_tick']} to {source['last_tick']}"),
        ("rows", number(source["rows"])),
    )
    items: list[Item] = [Facts(facts)]
    items += [
        Text(f"{text[0].upper()}{text[1:]}.", "note") for text in result.recorded.remarks(result.capture)
    ]
    if len(result.recorded.regimes) > 1:
        items.append(_regimes(result.recorded))
    items += [
        Text(f"Undefined: {', '.join(names)}: {reason}.", "note")
        for reason, names in undefined(result.measurements).items()
    ]
    yield Section("What was measured", tuple(items))


def _regimes(recorded: Recorded) -> Grid:
    found = recorded.regimes
    names = list(dict.fromkeys(name for each in found for name in each.levels))
    rows = [
        (
            raw(each.from_s),
            raw(each.to_s),
            "steady" if each.steady else "transient",
            *(raw(each.levels[name]) if each.steady and name in each.levels else NOTHING for name in names),
        )
        for each in found
    ]
    headings = (">from (s)", ">to (s)", "regime", *(f">{name}" for name in names))
    return Grid.of(headings, rows, "Regimes of the recording, with the means of their operating points.")
