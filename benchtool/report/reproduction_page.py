"""A Markdown page that compares the figures of a publication with those of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from benchtool.analysis import NOTHING, Measurement
from benchtool.profile import Choice, Profile
from benchtool.report.claims import claims_table, literal


@dataclass(frozen=True)
class PlanFigures:
    """One plan of the run: its cases' measurements and published figures, and the open points of its
    source."""

    name: str
    title: str
    readings: tuple[str, ...]
    tabulate: tuple[str, ...]
    measured: Mapping[str, Sequence[Measurement]]
    published: Mapping[str, Mapping[str, float]]


PAGE_MARK = b"Written by `benchtool run"
"""Text that identifies every page."""


def reproduction_page(profile: Profile, plans: Sequence[PlanFigures], command: str) -> str:
    """Return every published figure with ours and the ratio, every claim, other measurement, choice made.

    A number is one that the run measured, with its expanded uncertainty, or the publication's.
    """
    lines = ["# Reproduction", "", profile.title + ".", ""]
    lines += [f"Written by `{command}`. Numbers are value ± U (95 %).", ""]
    lines += [*_both_readings(plans), *_claims(profile, plans)]
    for plan in plans:
        lines += [f"## {plan.name}: {plan.title}", "", *_published(plan), *_table(plan)]
        lines += [f"- {reading}" for reading in plan.readings]
        lines += [""] if plan.readings else []
    lines += ["## Choices", "", *_choices(profile.choices)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _both_readings(plans: Sequence[PlanFigures]) -> Iterator[str]:
    """Yield every published figure beside that of the plan's two readings."""
    rows = [
        (plan, case, name, value)
        for plan in plans
        for case, figures in plan.published.items()
        for name, value in figures.items()
        if case in plan.measured and literal(case) in plan.measured
    ]
    if not rows:
        return
    yield from (
        "## Published figures in both readings",
        "",
        "| plan | case | measurement | published | literally | ratio | as run here | ratio |",
        "|---|---|---|---|---|---|---|---|",
    )
    for plan, case, name, value in rows:
        cells = []
        for reading in (literal(case), case):
            ours = next((each for each in plan.measured[reading] if each.name == name), None)
            cells += [ours.in_unit, _ratio(ours.value, value)] if ours else [NOTHING, NOTHING]
        yield f"| {_short(plan)} | {case} | {name} | {value:.4g} | {' | '.join(cells)} |"
    yield ""


def _claims(profile: Profile, plans: Sequence[PlanFigures]) -> Iterator[str]:
    if profile.claims:
        figures = {_short(plan): plan.measured for plan in plans}
        yield from ("## Claims", "", *claims_table(profile.claims, figures), "")


def _short(plan: PlanFigures) -> str:
    """Return the name of a plan without that of its folder."""
    return PurePath(plan.name).stem


def _published(plan: PlanFigures) -> Iterator[str]:
    rows = [
        (case, name, value, next((each for each in plan.measured[case] if each.name == name), None))
        for case, figures in plan.published.items()
        for name, value in figures.items()
        if case in plan.measured
    ]
    if not rows:
        return
    yield from (
        "| case | measurement | published | measured | ratio | definition |",
        "|---|---|---|---|---|---|",
    )
    for case, name, value, ours in rows:
        if ours is None:
            yield f"| {case} | {name} | {value:.4g} | {NOTHING} | {NOTHING} | not measured |"
            continue
        yield (
            f"| {case} | {name} | {value:.4g} {ours.unit} | {ours.in_unit} "
            f"| {_ratio(ours.value, value)} | {ours.definition} |"
        )
    yield ""


def _table(plan: PlanFigures) -> Iterator[str]:
    """Yield a column for each case or, where the plan chooses measurements, a row for each."""
    if plan.tabulate:
        yield f"| case | {' | '.join(plan.tabulate)} |"
        yield f"|---|{'---|' * len(plan.tabulate)}"
        for case, measured in plan.measured.items():
            cells = {each.name: each.in_unit for each in measured}
            yield f"| {case} | {' | '.join(cells.get(name, NOTHING) for name in plan.tabulate)} |"
        yield ""
        return
    units = {each.name: each.unit for measured in plan.measured.values() for each in measured}
    yield f"| measurement | unit | {' | '.join(plan.measured)} |"
    yield f"|---|---|{'---|' * len(plan.measured)}"
    columns = [{each.name: each.text for each in measured} for measured in plan.measured.values()]
    for name, unit in units.items():
        yield f"| {name} | {unit} | {' | '.join(column.get(name, NOTHING) for column in columns)} |"
    yield ""


def _choices(choices: Sequence[Choice]) -> Iterator[str]:
    yield from ("| about | choice | reason | effect |", "|---|---|---|---|")
    for each in choices:
        yield f"| {each.about} | {each.choice} | {each.reason} | {each.effect} |"


def _ratio(ours: float, published: float) -> str:
    return f"{ours / published:.3g}" if published and math.isfinite(ours) else NOTHING
