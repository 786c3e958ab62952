"""Parameters and results as documents of a recording, in Markdown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import rerun as rr

from benchtool.analysis import Measurement, catalogue, with_expanded
from benchtool.errors import PlugInError
from benchtool.live.panels.band import Limits


def parameters_document(title: str, parameters: Mapping[str, object]) -> rr.TextDocument:
    """Return the parameters of the drive, by name with their units."""
    rows = [f"| {_cell(name)} | {_cell(_text(value))} |" for name, value in parameters.items()]
    body = ["| parameter | value |", "|---|---:|", *rows] if rows else ["no parameters were read"]
    return _markdown([f"**{title}**", "", *body])


def results_document(
    title: str,
    measurements: Sequence[Measurement],
    limits: Limits | None = None,
    verdicts: Mapping[str, str] | None = None,
    remarks: Sequence[str] = (),
) -> rr.TextDocument:
    """Return the measurements: first those with a limit and its verdict, then the rest by analysis."""
    bounds, verdicts = limits or {}, verdicts or {}
    judged = [_row(each, bounds, verdicts) for each in measurements if each.name in bounds]
    rows, last = [], ""
    for each in measurements:
        if each.name in bounds:
            continue
        if (heading := _analysis(each.name)) not in ("", last):
            last = heading
            rows.append(f"| *{_cell(last)}* | | |")
        rows.append(f"| {_cell(each.name)} | {_text(each.value)} | {_cell(each.unit)} |")
    # two tables, as one is as wide as its longest name: the verdicts would be out of sight
    table = (
        ["| judged | value | unit | limit | verdict |", "|---|---:|---|---|---|", *judged, ""]
        if judged
        else []
    )
    table += ["| measurement | value | unit |", "|---|---:|---|", *rows] if rows else []
    undefined = [f"{_cell(each.name)}: {each.reason}" for each in measurements if each.reason]
    told = ["", "undefined:", "", *(f"- {line}" for line in undefined)] if undefined else []
    heads = [f"**{title}**", "", *(f"{remark}\n" for remark in remarks)]
    return _markdown([*heads, *table, *told])


class ShownStep(NamedTuple):
    """A step of a commissioning: its name, its verdict with a reason, what it estimated, and in sentences
    what it found."""

    name: str
    verdict: str
    reason: str
    estimates: Sequence[Measurement]
    findings: Sequence[str] = ()


def steps_document(title: str, steps: Sequence[ShownStep], remarks: Sequence[str] = ()) -> rr.TextDocument:
    """Return what steps have estimated, the last one first, each value with its expanded uncertainty."""
    heads = [f"**{title}**", "", *(f"{remark}\n" for remark in remarks)]
    rows, told = [], []
    for step in reversed(steps):
        rows.append(f"| **{_cell(step.name)}** | **{step.verdict}** | |")
        rows += [
            f"| {_cell(each.name)} | {with_expanded(each.value, each.uncertainty)} | {_cell(each.unit)} |"
            for each in step.estimates
        ]
        told += [f"- **{_cell(step.name)}**: {_cell(step.reason)}"] if step.reason else []
        told += [f"- **{_cell(step.name)}**: {_cell(text)}" for text in step.findings if text != step.reason]
        told += [f"- {_cell(each.name)}: {_cell(each.reason)}" for each in step.estimates if each.reason]
    table = ["| estimate | value | unit |", "|---|---:|---|", *rows] if rows else []
    return _markdown([*heads, *told, "", *table])


def _analysis(name: str) -> str:
    """Return the title of the analysis that measures it; empty if there is none, or if a package cannot be
    loaded."""
    with suppress(PlugInError):
        found = catalogue().measuring(name)
        return "" if found is None else found.title
    return ""


def _row(measured: Measurement, bounds: Limits, verdicts: Mapping[str, str]) -> str:
    name = measured.name
    return (
        f"| {_cell(name)} | {_text(measured.value)} | {_cell(measured.unit)} | {_limit(bounds.get(name))} "
        f"| {verdicts.get(name, '')} |"
    )


def certificate_document(measurements: Sequence[tuple[str, float, str]]) -> rr.TextDocument:
    """Return how good the data are: (name, value, unit) each, missing rows first, then what is not zero."""
    ordered = sorted(measurements, key=lambda each: (not each[0].endswith("_rows_missing"), each[1] == 0.0))
    rows = [f"| {_cell(name)} | {_text(value)} | {_cell(unit)} |" for name, value, unit in ordered]
    return _markdown(["| data quality | value | unit |", "|---|---:|---|", *rows])


def _limit(bounds: tuple[float | None, float | None] | None) -> str:
    if bounds is None:
        return ""
    least, most = bounds
    return " ".join(f"{sign} {value:g}" for sign, value in (("≥", least), ("≤", most)) if value is not None)


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else "–"
    return str(value)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ").replace("_", "\\_")


def _markdown(lines: Sequence[str]) -> rr.TextDocument:
    return rr.TextDocument("\n".join(lines), media_type=rr.MediaType.MARKDOWN)
