"""A report as a PDF, without a browser: the same content as the page, on A4, with its fonts embedded."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import Any

from reportlab import rl_config
from reportlab.lib.pagesizes import A4
from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import BaseDocTemplate, Frame, PageTemplate

from benchtool.report.content import Report
from benchtool.report.pdf.flow import story
from benchtool.report.pdf.style import BOTTOM, HEIGHT, LEFT, MONO, SANS, SOFT, WIDTH, register_fonts

MARK = b"(benchtool)"
"""Producer of every document."""


def pdf_document(report: Report) -> bytes:
    """Return the document; the same report gives the same bytes, for its only date is the run's."""
    register_fonts()
    file = io.BytesIO()
    document = _Document(file, report)
    with _binary_streams():
        document.build(list(story(report)), canvasmaker=_Numbered)
    return file.getvalue()


@contextmanager
def _binary_streams() -> Iterator[None]:
    """Have compressed pictures and pages written as they are: as text, which a PDF need not be, they take a
    quarter more, and most of the time in Python."""
    as_text = rl_config.useA85
    rl_config.useA85 = 0
    try:
        yield
    finally:
        rl_config.useA85 = as_text


class _Document(BaseDocTemplate):  # type: ignore[misc]
    """A4 pages with a running title, the fingerprint of the data, and headings as bookmarks."""

    def __init__(self, file: io.BytesIO, report: Report) -> None:
        super().__init__(
            file,
            pagesize=A4,
            title=report.title,
            author="",
            subject=report.subtitle,
            creator="benchtool",
            producer="benchtool",
            lang="en",
            initialFontName=SANS,
            invariant=1,
        )
        frame = Frame(LEFT, BOTTOM, WIDTH, HEIGHT, 0, 0, 0, 0)
        self.addPageTemplates(PageTemplate(frames=[frame], onPage=self._run_title))
        self._report = report
        self._headings = 0

    def _run_title(self, canvas: Any, _: Any) -> None:
        canvas.saveState()
        canvas.setFont(SANS, 7)
        canvas.setFillColor(SOFT)
        title = self._report.title
        shown = title if len(title) <= 100 else f"{title[:99]}…"
        canvas.drawString(LEFT, 11 * mm, shown)
        if self._report.fingerprint:
            canvas.setFont(MONO, 5.5)
            canvas.drawString(LEFT, 7.5 * mm, f"recorded data: SHA-256 {self._report.fingerprint}")
        canvas.restoreState()

    def beforeDocument(self) -> None:
        date = _pdf_date(self._report.when)
        if date:
            self.canv.setDateFormatter(lambda *_: date)

    def afterFlowable(self, flowable: Any) -> None:
        level = getattr(flowable, "outline_level", None)
        if level is not None:
            self._headings += 1
            key = f"heading-{self._headings}"
            self.canv.bookmarkPage(key)
            self.canv.addOutlineEntry(flowable.heading, key, level, closed=level > 0)


class _Numbered(Canvas):  # type: ignore[misc]
    """Writes `page / pages` on each page once their number is known."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._pages: list[dict[str, Any]] = []

    def showPage(self) -> None:
        self._pages.append(dict(self.__dict__))
        self._startPage()

    def save(self) -> None:
        for state in self._pages:
            self.__dict__.update(state)
            self.setFont(SANS, 7)
            self.setFillColor(SOFT)
            self.drawRightString(A4[0] - LEFT, 11 * mm, f"{self._pageNumber} / {len(self._pages)}")
            super().showPage()
        super().save()


def _pdf_date(when: str) -> str:
    """Return the run's time as PDF writes dates; empty if it is none."""
    try:
        stamp = datetime.fromisoformat(when)
    except ValueError:
        return ""
    zone = stamp.strftime("%z")
    return f"D:{stamp:%Y%m%d%H%M%S}" + (f"{zone[:3]}'{zone[3:5]}'" if zone else "")
