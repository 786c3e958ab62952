"""`benchtool gauge TABLE`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from benchtool.analysis import NOTHING, number, probability, raw
from benchtool.cli import options
from benchtool.cli.output import VERDICT_COLOURS, Output
from benchtool.errors import UsageError
from benchtool.gauge import Component, GaugeStudy, Inferred, read_readings, study
from benchtool.plan import Limit, Verdict

_ACCEPTABLE, _CONDITIONAL = 10.0, 30.0  # %GRR of AIAG
_CATEGORIES = 5


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
        typer.Option(
            metavar="PERCENT",
            help="Exit with 1 unless %GRR is shown to be at most this, of the total variation.",
        ),
    ] = None,
    margin: Annotated[
        str,
        typer.Option(
            metavar="U|PERCENT",
            help="Decision rule of --limit: U by the interval for 95 %; a number by the estimate alone, "
            "marginal within so much of the limit.",
        ),
    ] = "U",
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
            NOTHING if each.F is None else number(each.F),
            NOTHING if each.p is None else number(each.p),
            "pooled" if each.variance is None else number(each.variance**0.5),
        )
        for each in result.components
    ]
    shape = ", ".join(f"{count} {what}" for what, count in design.items() if count > 1)
    output.table(
        f"{readings.name}: {shape}", ("source", ">dof", ">mean square", ">F", ">p", ">std. deviation"), rows
    )
    low, high = result.gauge_interval
    output.line(f"gauge: {number(result.gauge)} (95 %: {number(low, 3)} to {number(high, 3)})")
    shares = {"total variation": result.percent_of_total, "tolerance": result.percent_of_tolerance}
    known = {what: share for what, share in shares.items() if share is not None}
    for what, share in known.items():
        output.line(f"%GRR of the {what}: {_shown(share)}, {_judged(share)}")
    if result.ndc_interval is not None:
        least, most = result.ndc_interval
        told = f"distinct categories: {result.ndc} (95 %: {least} to {most})"
        output.line(f"{told}, at least {_CATEGORIES} are expected")
    if not known:
        output.note("one part and no --tolerance: nothing to hold the gauge against")
    verdict, conformance = Verdict.NONE, None
    if limit is not None:
        what, held = next(iter(known.items()), ("", None))
        verdict = _verdict(held, Limit(max=limit, margin=_margin(margin)))
        output.verdict(str(verdict))
        if held is not None:
            conformance = held.probability_below(limit)
            told = f"%GRR of the {what} at most {raw(limit)} %: {verdict}, P {probability(conformance)}"
            output.sentence(f"{told} ({_rule(margin)})", VERDICT_COLOURS[verdict])
    document = _document(table, readings.name, design, result, verdict)
    output.document(document if conformance is None else {**document, "conformance": conformance})
    return 0 if verdict.met else 1


def _margin(stated: str) -> float | Literal["U"]:
    """Return the margin of a limit.

    Raises:
        UsageError: it is neither U nor a number from 0 on.
    """
    if stated == "U":
        return "U"
    try:
        found = float(stated)
    except ValueError:
        found = math.nan
    if not 0.0 <= found < math.inf:
        raise UsageError(f"--margin is {stated}, U or a number of percent from 0 on is expected")
    return found


def _rule(margin: str) -> str:
    if margin == "U":
        return "by its interval for 95 %: --margin 0 judges the estimate alone"
    return "by the estimate alone: --margin U judges its interval for 95 %"


def _verdict(share: Inferred | None, limit: Limit) -> Verdict:
    """Return how a percentage meets an upper limit; with a guard band it passes or fails where its whole
    interval does."""
    if share is None:
        return Verdict.FAIL
    if limit.margin != "U":
        return limit.judge(share.estimate)
    least, greatest = (limit.headroom(each) >= 0.0 for each in share.interval)
    return Verdict.PASS if greatest else Verdict.UNDECIDED if least else Verdict.FAIL


def _shown(share: Inferred) -> str:
    """Return a percentage with its interval."""
    low, high = share.interval
    return f"{number(share.estimate)} % (95 %: {number(low, 3)} to {number(high, 3)} %)"


def _judged(share: Inferred) -> str:
    """Return what AIAG says of a percentage, and what of the ends of its interval where that is another
    thing."""
    said, low, high = (_class(each) for each in (share.estimate, *share.interval))
    return said if low == high else f"{said} as estimated, {low} to {high} by the interval"


def _class(percent: float) -> str:
    if percent <= _ACCEPTABLE:
        return "acceptable"
    return "acceptable for some uses" if percent <= _CONDITIONAL else "not acceptable"


def _document(
    table: Path, name: str, design: dict[str, int], result: GaugeStudy, verdict: Verdict
) -> dict[str, Any]:
    return {
        "verdict": str(verdict),
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
        **_share("percent_of_total", result.percent_of_total),
        **_share("percent_of_tolerance", result.percent_of_tolerance),
        "ndc": result.ndc,
        "ndc_interval": None if result.ndc_interval is None else list(result.ndc_interval),
    }


def _share(name: str, share: Inferred | None) -> dict[str, Any]:
    """Return a percentage and its interval by their keys; null where there is none."""
    if share is None:
        return {name: None, f"{name}_interval": None}
    return {name: share.estimate, f"{name}_interval": list(share.interval)}


def _line(component: Component) -> dict[str, Any]:
    return {
        "dof": component.dof,
        "sum_of_squares": component.sum_of_squares,
        "mean_square": component.mean_square,
        "F": component.F,
        "p": component.p,
        "variance": component.variance,
    }
