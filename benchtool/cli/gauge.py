"""`benchtool gauge TABLE`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.analysis import NOTHING, number, probability, raw
from benchtool.cli import options
from benchtool.cli.output import VERDICT_COLOURS, Output
from benchtool.errors import UsageError
from benchtool.gauge import Component, GaugeStudy, Inferred, read_readings, study
from benchtool.plan import Limit, Verdict

_CRITERIA = (
    (10.0, "under 10 %, acceptable"),
    (30.0, "10 to 30 %, which may be acceptable for some applications"),
    (math.inf, "over 30 %, not acceptable"),
)
"""%GRR up to which each holds: AIAG, Measurement Systems Analysis, 4th edition, chapter II, section D."""

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
        str | None,
        typer.Option(
            metavar="U|PERCENT",
            help="Decision rule of --limit: U by the interval for 95 %, as without it; a number by the "
            "estimate alone, marginal within so much of the limit.",
        ),
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Study the repeatability and reproducibility of a measurement over parts, operators and mountings."""
    output = Output(as_json=as_json)
    rule = _rule(limit, margin)
    readings = read_readings(table, value)
    result = study(readings, tolerance)
    if rule is not None and result.part is None and tolerance is None:
        raise UsageError(
            f"--limit with one part in {table}: %GRR of the total variation needs several parts, that of the "
            f"tolerance its width; measure more parts, give --tolerance, or leave --limit out"
        )
    design = dict(zip(("parts", "operators", "mountings", "repetitions"), readings.values.shape, strict=True))
    rows = [
        (
            str(each.source),
            str(each.dof),
            number(each.mean_square),
            NOTHING if each.F is None else number(each.F),
            NOTHING if each.p is None else probability(each.p),
            "pooled" if each.variance is None else number(each.variance**0.5),
        )
        for each in result.components
    ]
    shape = ", ".join(f"{count} {what}" for what, count in design.items() if count > 1)
    output.table(
        f"{readings.name}: {shape}", ("source", ">dof", ">mean square", ">F", ">p", ">std. deviation"), rows
    )
    if result.gauge_interval is not None:
        low, high = result.gauge_interval
        interval = f"(95 %: {number(low, 3)} to {number(high, 3)})"
        output.sentence(f"standard deviation of the gauge: {number(result.gauge)} {interval}")
    shares = {"total variation": result.percent_of_total, "tolerance": result.percent_of_tolerance}
    known = {what: share for what, share in shares.items() if share is not None}
    for what, share in known.items():
        output.sentence(f"{_shown(share)}; {_by_criteria(share)}", lead=f"%GRR of the {what}: ")
    if result.ndc_interval is not None:
        least, most = result.ndc_interval
        told = f"number of distinct categories (ndc): {result.ndc} (95 %: {least} to {most})"
        output.sentence(f"{told}, AIAG asks for {_CATEGORIES} or more")
    if result.gauge_interval is None:
        output.warning(
            "repeated readings do not differ: their resolution hides the spread of the gauge, by which %GRR "
            "is told; write the readings with more digits"
        )
    elif not known:
        output.sentence(
            "one part and no tolerance: %GRR has nothing to be a share of; measure several parts, or give "
            "--tolerance, its width in the unit of the readings"
        )
    verdict, conformance = Verdict.NONE, None
    if rule is not None:
        what, held = next(iter(known.items()), ("", None))
        if held is None:
            verdict, told = Verdict.UNDECIDED, f"nothing tells whether %GRR is at most {rule.text}"
        else:
            verdict, conformance = _verdict(held, rule), held.probability_below(rule.greatest)
            told = f"%GRR of the {what} {_decided(verdict, rule)}; {_probably(conformance, rule)}"
        output.verdict(str(verdict))
        output.sentence(told, VERDICT_COLOURS[verdict])
    document = _document(table, readings.name, design, result, verdict)
    output.document(document if conformance is None else {**document, "conformance": conformance})
    return 0 if verdict.met else 1


@dataclass(frozen=True)
class _Rule:
    """The greatest %GRR that is allowed, and the `margin` by which an estimate is marginal; None where its
    whole interval decides."""

    greatest: float
    margin: float | None

    @property
    def text(self) -> str:
        return f"{raw(self.greatest)} %"


def _rule(limit: float | None, margin: str | None) -> _Rule | None:
    """Return the decision rule, None without a limit.

    Raises:
        UsageError: a limit that is no percentage above 0, a margin without one, or one that is neither U nor
            a number from 0 on.
    """
    if limit is None:
        if margin is not None:
            raise UsageError(
                f"--margin {margin} without --limit: it is the rule of a limit, give both or none"
            )
        return None
    if not 0.0 < limit < math.inf:
        raise UsageError(f"--limit is {limit:g}, a number of percent above 0 is expected, such as 30")
    if margin is None or margin == "U":
        return _Rule(limit, None)
    try:
        found = float(margin)
    except ValueError:
        found = math.nan
    if not 0.0 <= found < math.inf:
        raise UsageError(f"--margin is {margin}, U or a number of percent from 0 on is expected")
    return _Rule(limit, found)


def _verdict(share: Inferred, rule: _Rule) -> Verdict:
    """Return how a percentage meets an upper limit; without a margin it passes or fails where its whole
    interval does."""
    if rule.margin is not None:
        return Limit(max=rule.greatest, margin=rule.margin).judge(share.estimate)
    least, greatest = (each <= rule.greatest for each in share.interval)
    return Verdict.PASS if greatest else Verdict.UNDECIDED if least else Verdict.FAIL


def _decided(verdict: Verdict, rule: _Rule) -> str:
    """Return what a verdict says of a percentage, and by what."""
    if rule.margin is not None:
        met = "is at most" if verdict.met else "is more than"
        near = f", by less than {raw(rule.margin)} %" if verdict is Verdict.MARGINAL else ""
        return f"{met} {rule.text} as estimated{near} (--margin U judges its interval)"
    if verdict is Verdict.UNDECIDED:
        return (
            f"may be below or above {rule.text}, its interval holds both: more operators, parts or mountings "
            f"narrow it (--margin 0 judges the estimate alone)"
        )
    return f"is {'at most' if verdict.met else 'more than'} {rule.text} by its whole interval"


def _probably(conformance: float, rule: _Rule) -> str:
    """Return the probability that a percentage is within the limit, in words."""
    return f"probability of at most {rule.text}: {probability(conformance)}"


def _shown(share: Inferred) -> str:
    """Return a percentage with its interval."""
    low, high = share.interval
    return f"{number(share.estimate)} % (95 %: {number(low, 3)} to {number(high, 3)} %)"


def _by_criteria(share: Inferred) -> str:
    """Return which of AIAG's criteria a percentage falls under, and which others its interval reaches."""
    said, low, high = (_criterion(each) for each in (share.estimate, *share.interval))
    others = [text for _, text in _CRITERIA[low : high + 1] if text != _CRITERIA[said][1]]
    if not others:
        return f"by AIAG's criteria {_CRITERIA[said][1]}"
    return f"by AIAG's criteria {_CRITERIA[said][1]}; its interval also reaches {'; and '.join(others)}"


def _criterion(percent: float) -> int:
    return next(place for place, (most, _) in enumerate(_CRITERIA) if percent <= most)


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
        "gauge_interval": None if result.gauge_interval is None else list(result.gauge_interval),
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
