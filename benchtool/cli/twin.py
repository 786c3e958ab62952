"""`benchtool twin RUN`."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from benchtool.analysis import NOTHING, number, signed
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import UsageError
from benchtool.recording import write_whole
from benchtool.report import draw_twin
from benchtool.results import Twin, incomplete_runs, twins

_FORMATS = (".png", ".svg", ".pdf")


def twin(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run bundle, or folder of a run.")],
    stream: Annotated[
        str,
        typer.Option(metavar="NAME", help="Which data.", show_default="capture, else the only stream"),
    ] = "",
    delay_ticks: Annotated[
        int,
        typer.Option(min=0, max=3, metavar="N", help="Ticks from a row until the voltage in it acts."),
    ] = 1,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw measured and simulated signals: PNG, SVG or PDF, of one case."
        ),
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Simulate a recorded run again, with the parameters that the drive believed and with those that the run
    itself tells, and name what is wrong.

    The run needs i_a, i_b, i_c, u_alpha, u_beta, u_dc and theta_m at every tick, as the plan zhu2011/identify
    captures them. What it does not tell has no estimate, and a line says what to capture. The exit code is 1
    where a belief is contradicted.
    """
    if figure is not None and figure.suffix.lower() not in _FORMATS:
        raise UsageError(f"--figure {figure}: a name that ends with {', '.join(_FORMATS)} is expected")
    output = Output(as_json=as_json)
    found = tuple(twins(run, stream=stream, delay_ticks=delay_ticks))
    if figure is not None and len(found) > 1:
        raise UsageError(f"{run} has {len(found)} cases, --figure draws one: give the folder of a case")
    for text in incomplete_runs(run):
        output.warning(text)
    for each in found:
        _show(output, each)
    if figure is not None:
        drawing = io.BytesIO()
        draw_twin(found[0]).savefig(drawing, format=figure.suffix.lower().removeprefix("."))
        write_whole(figure, drawing.getvalue())
        output.line(f"figure: {figure}")
    drawn = {} if figure is None else {"figure": str(figure)}
    output.document({"cases": {each.case: each.to_json() for each in found}, **drawn})
    return 1 if any(each.wrong for each in found) else 0


def _show(output: Output, twin: Twin) -> None:
    rows: list[tuple[str | Text, ...]] = [
        (
            each.name,
            number(each.believed),
            each.estimate.text if each.told else NOTHING,
            signed(each.percent, 3) if each.told and each.believed else NOTHING,
            each.estimate.unit,
            Text("wrong", style="red") if each.contradicts else "" if each.told else "not told",
        )
        for each in twin.deviations
    ]
    columns = ("parameter", ">believed", ">estimate ± U (95 %)", ">%", "unit", "")
    output.table(f"{twin.case}: what the run tells of its parameters", columns, rows)
    residuals: list[tuple[str | Text, ...]] = [
        (each.name, number(each.believed_rms), number(each.estimated_rms), each.unit) for each in twin.signals
    ]
    titles = ("signal", ">as believed", ">as estimated", "unit")
    output.table("simulated less measured, rms", titles, residuals)
    reasons: dict[str, list[str]] = {}
    for signal in twin.signals:
        if signal.reason:
            reasons.setdefault(signal.reason, []).append(signal.name)
    for each in twin.deviations:
        if not each.told:
            reasons.setdefault(each.estimate.reason, []).append(each.name)
    for reason, names in reasons.items():
        output.sentence(f"{', '.join(names)}: {reason}", "dim")
    unknown: dict[str, list[str]] = {}
    for each in twin.deviations:
        if each.estimate.uncertainty_reason:
            unknown.setdefault(each.estimate.uncertainty_reason, []).append(each.name)
    for reason, names in unknown.items():
        output.sentence(f"without ±: {', '.join(names)}: {reason}", "dim")
    if twin.motion:
        output.sentence(f"no balance of torque: {twin.motion}", "dim")
    for each in twin.wrong:
        output.sentence(f"wrong: {each}", "red")
    if twin.shared_cause:
        output.sentence(twin.shared_cause, "red")
    if not twin.wrong:
        output.line("nothing that the run tells contradicts what is believed", "green")
    output.line(f"bundle: {twin.bundle}")
