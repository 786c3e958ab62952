"""`benchtool gauge TABLE`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.analysis import number
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.gauge import Component, GaugeStudy, read_readings, study

_ACCEPTABLE, _CONDITIONAL = 10.0, 30.0  # %GRR of AIAG


def gauge(
    table: Annotated[Path, typer.Argument(metavar="TABLE", help="CSV with a line for each reading.")],
    value: Annotated[
        str, typer.Option(metavar="COLUMN", help="Column with the readings, if several may be.")
    ] = "",
    tolerance: Annotated[
        float | None, typer.Option(help="Width of the tolerance, in the unit of the readings.")
    ] = None,
    limit: Annotated[
        float | None,
        typer.Option(metavar="PERCENT", help="Exit with 1 if the gauge has more of the variation than this."),
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Study the repeatability and reproducibility of a measurement over parts, operators and mountings."""
    output = Output(as_json=as_json)
    readings = read_readings(table, value)
    result = study(readings, tolerance)
    design = dict(zip(("parts", "operators", "mountings", "repetitions"), readings.values.shape, strict=True))
    rows = [
        (
            str(each.source),
            str(each.dof),
            number(each.mean_square),
            "–" if each.F is None else number(each.F),
            "–" if each.p is None else number(each.p),
            "pooled" if each.variance is None else number(each.variance**0.5),
        )
        for each in result.components
    ]
    shape = ", ".join(f"{count} {what}" for what, count in design.items() if count > 1)
    output.table(
        f"{readings.name}: {shape}", ("source", ">dof", ">mean square", ">F", ">p", ">std. deviation"), rows
    )
    low, high = result.gauge_interval
    output.line(f"gauge: {number(result.gauge)} (95 %: {number(low)} to {number(high)})")
    percent = result.percent_of_tolerance if result.percent_of_total is None else result.percent_of_total
    for what, share in (
        ("total variation", result.percent_of_total),
        ("tolerance", result.percent_of_tolerance),
    ):
        if share is not None:
            output.line(f"%GRR of the {what}: {number(share)} %, {_judged(share)}")
    if result.ndc is not None:
        output.line(f"distinct categories: {result.ndc} (5 or more are expected)")
    if percent is None:
        output.note("one part and no --tolerance: nothing to hold the gauge against")
    verdict = "none" if limit is None else "pass" if percent is not None and percent <= limit else "fail"
    if limit is not None:
        output.verdict(verdict)
    output.document(_document(table, readings.name, design, result, verdict))
    return 1 if verdict == "fail" else 0


def _judged(percent: float) -> str:
    if percent <= _ACCEPTABLE:
        return "acceptable"
    return "acceptable for some uses" if percent <= _CONDITIONAL else "not acceptable"


def _document(
    table: Path, name: str, design: dict[str, int], result: GaugeStudy, verdict: str
) -> dict[str, Any]:
    return {
        "verdict": verdict,
        "file": str(table),
        "readings": name,
        "design": design,
        "anova": {str(each.source): _line(each) for each in result.components},
        "standard_deviations": {
            "repeatability": result.repeatability,
            "reproducibility": result.reproducibility,
            "mounting": result.mounting,
            "gauge": result.gauge,
            "part": result.part,
            "total": result.total,
        },
        "gauge_interval": list(result.gauge_interval),
        "percent_of_total": result.percent_of_total,
        "percent_of_tolerance": result.percent_of_tolerance,
        "ndc": result.ndc,
    }


def _line(component: Component) -> dict[str, Any]:
    return {
        "dof": component.dof,
        "sum_of_squares": component.sum_of_squares,
        "mean_square": component.mean_square,
        "F": component.F,
        "p": component.p,
        "variance": component.variance,
    }
