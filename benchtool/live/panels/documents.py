"""Parameters and results as documents of a recording, in Markdown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

import rerun as rr

from benchtool.analysis import Measurement
from benchtool.analysis.catalogue import catalogue
from benchtool.errors import PlugInError
from benchtool.live.panels.band import Limits


def parameters_document(title: str, parameters: Mapping[str, object]) -> rr.TextDocument:
    """What the drive was set to, by name with its unit."""
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
    """What was measured: what has a limit, with the verdict on it, then the rest by analysis."""
    bounds, verdicts = limits or {}, verdicts or {}
    rows = [_row(each, bounds, verdicts) for each in measurements if each.name in bounds]
    last = ""
    for each in measurements:
        if each.name in bounds:
            continue
        if (heading := _analysis(each.name)) not in ("", last):
            last = heading
            rows.append(f"| *{_cell(last)}* | | | | |")
        rows.append(_row(each, bounds, verdicts))
    table = ["| measurement | value | unit | limit | verdict |", "|---|---:|---|---|---|", *rows]
    undefined = [f"{_cell(each.name)}: {each.reason}" for each in measurements if each.reason]
    told = ["", "undefined:", "", *(f"- {line}" for line in undefined)] if undefined else []
    heads = [f"**{title}**", "", *(f"{remark}\n" for remark in remarks)]
    return _markdown([*heads, *(table if rows else []), *told])


def _analysis(name: str) -> str:
    """Title of the analysis that measures it; empty of what none does. A view ends no recording: a package
    that cannot be loaded costs it the titles."""
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
    """How good the data are: (name, value, unit) each, missing rows first, then what is not zero."""
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
