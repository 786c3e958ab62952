"""`benchtool report RUN`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output, tell_overdue, tell_unsealed
from benchtool.errors import RecordingError, UsageError
from benchtool.plan.limits import worst
from benchtool.recording import enlist
from benchtool.recording.files import require_own, write_whole
from benchtool.report.assembly.plan import case_label
from benchtool.report.assembly.run import run_report
from benchtool.report.content import Report
from benchtool.results.calibration import overdue_text, stated_overdue
from benchtool.results.runs import recorded_runs


def report(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Run bundle, or folder of a run of several cases or plans.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The HTML page.", show_default="RUN/report.html")
    ] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write a PDF too, beside the page.")] = False,
    as_json: options.Json = False,
) -> int:
    """Measure a recorded run again and write a report that needs nothing else to be read."""

    if out is not None and out.suffix.lower() == ".pdf" and not pdf:
        raise UsageError(f"--out {out} names a PDF, the page is HTML: add --pdf, or name the page")
    output = Output(as_json=as_json)
    runs = recorded_runs(run)
    tell_unsealed(output, [case.bundle for each in runs for case in each.cases])
    page, document = write_report(run_report(run, runs), out or run / "report.html", pdf=pdf, output=output)
    enlist(run, [page] if document is None else [page, document])
    verdict = worst(each.verdict for each in runs)
    found = [case.assessment for each in runs for case in each.cases if case.assessment]
    overdue = [late for each in found for late in each.overdue]
    tell_overdue(output, overdue)
    output.verdict(str(verdict), remark=overdue_text(overdue))
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
        | stated_overdue(overdue)
    )
    damaged = [case.error for each in runs for case in each.cases if isinstance(case.error, RecordingError)]
    if damaged:
        raise damaged[0]
    return 0 if verdict.met else 1


def write_report(report: Report, page: Path, *, pdf: bool, output: Output) -> tuple[Path, Path | None]:
    """Write the page and, if asked for, the PDF beside it; the paths of both. Earlier reports are replaced.

    Raises:
        RecordingError: a file cannot be written, or one that is no report is there.
    """
    from benchtool.report.html import MARK, html_page

    if pdf and page.suffix == ".pdf":
        page = page.with_suffix(".html")
    document = page.with_suffix(".pdf")
    require_own(page, MARK)
    if pdf:
        from benchtool.report.pdf.document import MARK as PDF_MARK

        require_own(document, PDF_MARK)
    write_whole(page, html_page(report).encode("utf-8"))
    output.line(f"report: {page}")
    if not pdf:
        return page, None
    from benchtool.report.pdf.document import pdf_document

    write_whole(document, pdf_document(report))
    output.line(f"pdf: {document}")
    return page, document
