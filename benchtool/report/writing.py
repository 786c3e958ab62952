"""A report as files: the page, and the PDF beside it."""

from __future__ import annotations

from pathlib import Path

from benchtool.recording import require_own, write_whole
from benchtool.report.content import Report


def write_report(report: Report, page: Path, *, pdf: bool = False) -> tuple[Path, Path | None]:
    """Write the page and, if asked for, the PDF beside it; the paths of both. Earlier reports are replaced.

    Raises:
        RecordingError: a file cannot be written, or a file that is not a report exists.
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
    if not pdf:
        return page, None
    from benchtool.report.pdf.document import pdf_document

    write_whole(document, pdf_document(report))
    return page, document
