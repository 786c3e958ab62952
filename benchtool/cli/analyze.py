"""`benchtool analyze RUN` and `benchtool analyze --csv FILE`."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.analysis import catalogue
from benchtool.cli import options, selection as chosen
from benchtool.cli.conditions import conditions
from benchtool.cli.output import Output, warn_unsealed
from benchtool.cli.results import show_run
from benchtool.cli.table_options import TableOptions
from benchtool.cli.tables import keep_table, show_table
from benchtool.errors import UsageError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.recording import Bundle, Conditions, require_empty
from benchtool.results import (
    Assessment,
    RunResult,
    Selection,
    assess_bundle,
    assess_recording,
    assess_table,
    complete_of,
    cut_short,
    incomplete,
    is_planned,
    is_table,
    recorded_runs,
    stored_remarks,
)
from benchtool.tables import analyze_table, quantity


def _column(what: str) -> Any:
    return typer.Option(metavar="COLUMN[:UNIT[*GAIN][+OFFSET]]", help=what)


def _in_unit(si_unit: str, example: str) -> Callable[[str], float]:
    """Return what reads an option's number in that unit, or with its own behind it."""

    def number(text: str) -> float:
        value = quantity(text, si_unit)
        try:
            return float(text) if value is None else value
        except ValueError:
            raise typer.BadParameter(
                f"'{text}' is no number of {si_unit}: one is expected, perhaps with its unit, as {example}"
            ) from None

    return number


def analyze(
    run: Annotated[
        Path | None, typer.Argument(metavar="RUN", help="Run bundle, or folder of a run of several cases.")
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Measure a text table of another tool instead: CSV, tabs or blanks."
        ),
    ] = None,
    time: Annotated[
        str | None, _column("With --csv: column of the time; it or --rate, and a column.")
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(
            metavar="HZ",
            parser=_in_unit("Hz", "10kHz"),
            help="With --csv: rows per second of a table without a time; or with its unit, as 10kHz.",
        ),
    ] = None,
    current: Annotated[
        list[str] | None,
        _column(
            "With --csv: column of a phase current or q-current; three times, of phases a, b and c, for "
            "their symmetrical components."
        ),
    ] = None,
    torque: Annotated[str | None, _column("With --csv: column of the torque.")] = None,
    angle: Annotated[
        str | None, _column("With --csv: column of the mechanical angle; gives orders per revolution.")
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN|VALUE",
            help="With --csv: column of the mechanical speed, or a constant one with its unit "
            "(1500rpm), which gives orders and periods without an angle.",
        ),
    ] = None,
    ac: Annotated[
        bool, typer.Option("--ac", help="With --csv: the current is that of a phase, whatever its name says.")
    ] = False,
    pole_pairs: Annotated[
        int | None, typer.Option(min=1, metavar="P", help="With --csv: pole pairs of the motor.")
    ] = None,
    slots: Annotated[
        int | None, typer.Option(min=1, metavar="Q", help="With --csv: slots of the stator.")
    ] = None,
    rated_torque: Annotated[
        float | None,
        typer.Option(
            metavar="NM",
            parser=_in_unit("Nm", "500mNm"),
            help="With --csv: base of the ripple in percent; or with its unit, as 500mNm.",
        ),
    ] = None,
    from_: chosen.From = None,
    to: chosen.To = None,
    stream: chosen.Stream = "",
    analysis: chosen.Asked = None,
    bench: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="With --csv: profile, or TOML file, whose [bench] states the sensors of the columns.",
        ),
    ] = None,
    decimal: Annotated[
        str | None,
        typer.Option(
            metavar="SIGN", help="With --csv: decimal sign, . or , where the numbers leave it open (1,095)."
        ),
    ] = None,
    recorded_on: Annotated[
        datetime | None,
        typer.Option(
            "--date",
            formats=["%Y-%m-%d"],
            metavar="YYYY-MM-DD",
            help="With --csv: day of the recording, by which calibrations are due, instead of the file's.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="With --csv: write a run bundle of it.")
    ] = None,
    note: options.Note = "",
    operator: options.Operator = "",
    serial_number: options.SerialNumber = "",
    temperature: options.Temperature = None,
    instrument: options.InstrumentsBeside = None,
    report: Annotated[
        bool, typer.Option("--report", help="With --csv: write the bundle, and a report in it.")
    ] = False,
    list_: Annotated[
        bool,
        typer.Option("--list", help="List the kinds of analysis: what each needs, measures and draws."),
    ] = False,
    as_json: options.Json = False,
) -> int:
    """Measure a recorded run again, by the plan that it carries; a recording; or data from elsewhere, --csv.

    A recording without a plan is measured in each of its steady regimes, by every analysis that its channels
    allow, or in the window of --from and --to. With one of these, --stream or --analysis, so is a run of a
    plan, without its limits.

    COLUMN is a name in the head of the table, or a number counted from 1; where a column is called by a
    number, #2 is the second one. Its unit is SI (s, A, Nm, rad, rad/s) unless the head states another, as
    "Iq [mA]" or "Iq/mA", or the option does behind a colon: --current Iq:mA, --angle 2:deg, --time
    "t:ms"; the time may be a date and time of day. A probe's gain and offset may follow, the offset in
    that unit: --current CH1:A*10-0.2 is ten times the cell, less 0.2 A.
    """
    if list_:
        return _list(run, csv, as_json=as_json)
    table = TableOptions(
        time=time,
        rate=rate,
        currents=tuple(current or ()),
        torque=torque,
        angle=angle,
        speed=speed,
        ac=ac,
        pole_pairs=pole_pairs,
        slots=slots,
        rated_torque=rated_torque,
        bench=bench,
        decimal=decimal,
        recorded_on=None if recorded_on is None else recorded_on.date(),
    )
    circumstances = conditions(operator, serial_number, temperature, instrument or ())
    is_kept = out is not None or report
    if csv is None:
        of_table = table != TableOptions() or is_kept or bool(note) or circumstances != Conditions()
        return _analyze_run(run, chosen.selection(stream, from_, to, analysis), as_json, of_table)
    if stream:
        raise UsageError("--csv with --stream: that chooses of a recording, leave it out")
    if run is not None:
        raise UsageError(f"both {run} and --csv {csv}: give the folder of a run or a table, one of the two")
    question = table.question(csv, from_, to, chosen.asked_of_table(analysis))
    if (note or circumstances != Conditions()) and not is_kept:
        raise UsageError("a note or conditions without --out or --report: nothing would keep them, add one")
    if out is not None:
        require_empty(out)  # before the table is measured
    answer = analyze_table(question)
    output = Output(as_json=as_json)
    show_table(output, answer)
    document = {"verdict": "none", "cases": {"csv": answer.to_json()}}
    if is_kept:
        document |= keep_table(output, answer, out, with_report=report, note=note, conditions=circumstances)
    output.document(document)
    return 0


def _list(run: Path | None, csv: Path | None, *, as_json: bool) -> int:
    """Return the catalogue: kinds of analysis with channels, settings and measurements."""

    if run is not None or csv is not None:
        raise UsageError(f"--list with {run or csv}: the catalogue is of no run, leave one of them out")
    output = Output(as_json=as_json)
    for each in catalogue().analyses:
        rows = [
            (", ".join(quantity.names), str(quantity.unit), quantity.text) for quantity in each.quantities
        ]
        source = f" ({each.source})" if each.source else ""
        output.table(f"{each.name}: {each.title}{source}", ("measurement", "unit", "definition"), rows)
        needs = [*each.needs(each.settings()), *each.conditions]
        output.sentence(f"{each.measured}; needs {', '.join(needs) or 'nothing else'}", "dim")
        settings = each.settings().model_dump(mode="json")
        if settings:
            stated = ", ".join(f"{key} = {json.dumps(value)}" for key, value in settings.items())
            output.sentence(f"[analyses.{each.name}] {stated}", "dim")
        if figures := list(dict.fromkeys(one.name for one in (*each.figures, *each.comparisons))):
            output.sentence(f"figures {', '.join(figures)}", "dim")
        output.line("")
    output.document({"analyses": {each.name: each.to_json() for each in catalogue().analyses}})
    return 0


def _analyze_run(run: Path | None, selection: Selection, as_json: bool, has_csv_options: bool) -> int:
    if run is None:
        raise UsageError("neither RUN nor --csv FILE: give the folder of a run, or a table of another tool")
    if run.is_file():
        why = f"{run} is a file, RUN is the folder of a run: a table of another tool is --csv {run}"
        raise UsageError(mistaken(run, FileKind.RUN) or why)
    if has_csv_options:
        raise UsageError(
            f"{run} is measured by the plan or the profile that it carries, columns and motor go with --csv: "
            f"leave them out"
        )
    output = Output(as_json=as_json)
    if (run / "manifest.json").is_file() or not run.is_dir():
        bundle = Bundle.open(run)
        warn_unsealed(output, [bundle])
        result = RunResult(_assessed(bundle, selection))
        show_run(output, bundle.manifest.what, result)
        document = result.to_json()
        for remark in stored_remarks(bundle):
            output.warning(remark)
        if failure := cut_short(bundle):
            output.warning(incomplete(run, [("", bundle)]))
            document |= {"complete": False, "failure": failure}
        output.document(document)
        return 0 if result.verdict.met and bundle.complete else 1
    runs = recorded_runs(run, selection)
    if len(runs) > 1:
        raise UsageError(f"{run} holds {len(runs)} plans: give the folder of one, such as {runs[0].folder}")
    warn_unsealed(output, [case.bundle for case in runs[0].cases])
    result = RunResult(tuple(complete_of(runs, run)), runs[0].repeated)
    show_run(output, str(run), result)
    document = result.to_json()
    if failure := runs[0].incomplete:
        output.warning(failure)
        document |= {"complete": False, "failure": failure}
    output.document(document)
    return 0 if result.verdict.met and not failure else 1


def _assessed(bundle: Bundle, selection: Selection) -> tuple[Assessment, ...]:
    """By its plan, as a table of another tool, or as a recording, where a part is chosen too."""
    if selection.everything and is_planned(bundle):
        return (assess_bundle(bundle),)
    if selection.everything and is_table(bundle):
        return (assess_table(bundle),)
    return assess_recording(bundle, selection)
