"""`benchtool report RUN`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options, selection as chosen
from benchtool.cli.output import Output, warn_incomplete, warn_overdue, warn_unsealed
from benchtool.commission import KeptCommissioning, read_commissioning
from benchtool.errors import RecordingError, UsageError
from benchtool.plan import worst
from benchtool.recording import SESSION, enlist, require_unchanged
from benchtool.report import Report, report_files, write_report as write_documents
from benchtool.report.assembly import (
    case_label,
    commissioning_report,
    run_report,
    session_report,
    write_pictures,
)
from benchtool.results import (
    earlier_sessions,
    overdue_text,
    read_session,
    recorded_runs,
    stated_overdue,
)


def report(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Run bundle, or folder of a run of several cases or plans.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The HTML page.", show_default="RUN/report.html")
    ] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write a PDF too, beside the page.")] = False,
    png: Annotated[
        bool, typer.Option("--png", help="Write each figure of a run as a PNG too, into the folder plots.")
    ] = False,
    stream: chosen.Stream = "",
    from_: chosen.From = None,
    to: chosen.To = None,
    analysis: chosen.Asked = None,
    as_json: options.Json = False,
) -> int:
    """Measure a recorded run again and write a self-contained report.

    A recording without a plan is measured in each of its steady regimes, or in the window of --from and --to.
    """

    if out is not None and out.suffix.lower() == ".pdf" and not pdf:
        raise UsageError(f"--out {out} names a PDF, the page is HTML: add --pdf, or name the page")
    output = Output(as_json=as_json)
    files = report_files(out or run / "report.html", pdf=pdf)  # before anything is measured
    require_unchanged(run, files if pdf else files[:1])
    selection = chosen.selection(stream, from_, to, analysis)
    is_session = (run / SESSION).is_file()
    commissioning = None if is_session else read_commissioning(run)
    if is_session or commissioning is not None:
        if png or not selection.everything:
            what, parts = ("an acceptance session", "runs") if is_session else ("a commissioning", "steps")
            raise UsageError(
                f"{run} is {what}, whose numbers and figures are those of its {parts}: with --png, --stream, "
                f"--from, --to or --analysis give the folder of one of these"
            )
        if commissioning is not None:
            return _commissioning(run, commissioning, out, pdf=pdf, output=output)
        return _session(run, out, pdf=pdf, output=output)
    runs = recorded_runs(run, selection)
    warn_unsealed(output, [case.bundle for each in runs for case in each.cases])
    page, document = write_report(run_report(run, runs), out or run / "report.html", pdf=pdf, output=output)
    enlist(run, [page] if document is None else [page, document])
    pictures = [path for each in runs for path in write_pictures(each)] if png else []
    for path in pictures:
        output.line(f"picture: {path}")
    verdict = worst(each.verdict for each in runs)
    found = [case.assessment for each in runs for case in each.cases if case.assessment]
    overdue = [late for each in found for late in each.overdue]
    warn_overdue(output, overdue)
    by_transducer = [by for each in runs if (by := each.verdict_by_transducer) is not None]
    shaft = str(worst(by_transducer)) if by_transducer else None
    output.verdict(str(verdict), shaft, overdue_text(overdue))
    warn_incomplete(output, runs)
    cases = {
        case_label(each, case): {"verdict": str(case.verdict), "bundle": str(case.bundle.directory)}
        | ({"failure": case.failure} if case.failure else {})
        for each in runs
        for case in each.cases
    }
    output.document(
        {
            "report": str(page),
            "pdf": None if document is None else str(document),
            "verdict": str(verdict),
            "cases": cases,
        }
        | ({"pictures": [str(path) for path in pictures]} if png else {})
        | stated_overdue(overdue)
    )
    damaged = [case.error for each in runs for case in each.cases if isinstance(case.error, RecordingError)]
    if damaged:
        raise damaged[0]
    return 0 if verdict.met else 1


def _session(folder: Path, out: Path | None, *, pdf: bool, output: Output) -> int:
    """Write the report of an acceptance session again."""
    record = read_session(folder)
    report = session_report(folder, record, earlier_sessions(folder, record))
    _written(folder, report, out, str(record.verdict), pdf=pdf, output=output)
    return 0 if record.verdict.met else 1


def _commissioning(
    folder: Path, kept: KeptCommissioning, out: Path | None, *, pdf: bool, output: Output
) -> int:
    """Write the report of a commissioning again."""
    report = commissioning_report(kept.document, kept.bundles)
    _written(folder, report, out, kept.document["verdict"], pdf=pdf, output=output)
    return 0 if kept.passed else 1


def _written(
    folder: Path, report: Report, out: Path | None, verdict: str, *, pdf: bool, output: Output
) -> None:
    """Write a report that a folder has of all its bundles, and tell of it."""
    page, document = write_report(report, out or folder / "report.html", pdf=pdf, output=output)
    enlist(folder, [page] if document is None else [page, document])
    output.verdict(verdict)
    output.document(
        {
            "report": str(page),
            "pdf": None if document is None else str(document),
            "verdict": verdict,
            "cases": {},
        }
    )


def write_report(report: Report, page: Path, *, pdf: bool, output: Output) -> tuple[Path, Path | None]:
    """As `benchtool.report.writing.write_report`, told of in lines."""
    page, document = write_documents(report, page, pdf=pdf)
    output.line(f"report: {page}")
    if document is not None:
        output.line(f"pdf: {document}")
    return page, document
