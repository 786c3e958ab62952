"""A report as files: the page, and the PDF beside it."""

from __future__ import annotations

from pathlib import Path

from benchtool.recording import require_own, write_whole
from benchtool.report.content import Report


def report_files(page: Path, *, pdf: bool = False) -> tuple[Path, Path]:
    """Return the names of a page and of the PDF beside it; before a long measurement they tell whether both
    can be written.

    Raises:
        RecordingError: a folder, or a file that is not a report, has the name of one that is asked for.
    """
    from benchtool.report.html import MARK

    if pdf and page.suffix == ".pdf":
        page = page.with_suffix(".html")
    document = page.with_suffix(".pdf")
    require_own(page, MARK)
    if pdf:
        from benchtool.report.pdf.document import MARK as PDF_MARK

        require_own(document, PDF_MARK)
    return page, document


def write_report(report: Report, page: Path, *, pdf: bool = False) -> tuple[Path, Path | None]:
    """Write the page and, if asked for, the PDF beside it; the paths of both. Earlier reports are replaced.

    Raises:
        RecordingError: a file cannot be written, or a file that is not a report exists.
    """
    from benchtool.report.html import html_page

    page, document = report_files(page, pdf=pdf)
    write_whole(page, html_page(report).encode("utf-8"))
    if not pdf:
        return page, None
    from benchtool.report.pdf.document import pdf_document

    write_whole(document, pdf_document(report))
    return page, document
