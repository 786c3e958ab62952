"""A report as a PDF, without a browser: the same content as the page, on A4, with its fonts embedded."""

from __future__ import annotations

import io
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any, Final
from xml.sax.saxutils import escape

import matplotlib as mpl
from reportlab.lib.colors import HexColor
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import (
    BaseDocTemplate,
    CondPageBreak,
    Flowable,
    Frame,
    KeepTogether,
    PageBreak,
    PageTemplate,
    Paragraph,
    Spacer,
    Table,
)

from benchtool.report.canvas import draw_figure
from benchtool.report.content import (
    Cell,
    Column,
    Facts,
    Grid,
    Item,
    Picture,
    Report,
    Section,
    Text,
    Verdict,
)

_INK, _SOFT, _LINE, _FAINT = (HexColor(code) for code in ("#1a1a1a", "#595959", "#d4d4d4", "#f4f4f2"))
_MARKS: Final = {
    "pass": "#00664b",
    "better": "#00664b",
    "marginal": "#7a4f00",
    "fail": "#a32b00",
    "worse": "#a32b00",
    "none": "#595959",
}
_SANS, _BOLD, _MONO = "DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono"
_LEFT, _TOP, _BOTTOM = 17 * mm, 16 * mm, 19 * mm
_WIDTH: Final = A4[0] - 2 * _LEFT
_HEIGHT: Final = A4[1] - _TOP - _BOTTOM
_FONT: Final = ("FONTNAME", (0, 0), (-1, -1), _SANS)  # else a table names one that is not embedded


def pdf_document(report: Report) -> bytes:
    """The document; the same report gives the same bytes, for its only date is the run's."""
    for name in (_SANS, _BOLD, _MONO):
        if name not in pdfmetrics.getRegisteredFontNames():
            pdfmetrics.registerFont(TTFont(name, Path(mpl.get_data_path(), "fonts", "ttf", f"{name}.ttf")))
    file = io.BytesIO()
    document = _Document(file, report)
    document.build(list(_story(report)), canvasmaker=_Numbered)
    return file.getvalue()


class _Document(BaseDocTemplate):  # type: ignore[misc]
    """A4 pages with a running title, and headings as bookmarks."""

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
            initialFontName=_SANS,
            invariant=1,
        )
        frame = Frame(_LEFT, _BOTTOM, _WIDTH, _HEIGHT, 0, 0, 0, 0)
        self.addPageTemplates(PageTemplate(frames=[frame], onPage=self._run_title))
        self._report = report
        self._headings = 0

    def _run_title(self, canvas: Any, _: Any) -> None:
        canvas.saveState()
        canvas.setFont(_SANS, 7)
        canvas.setFillColor(_SOFT)
        title = self._report.title
        shown = title if len(title) <= 100 else f"{title[:99]}…"
        canvas.drawString(_LEFT, 10 * mm, shown)
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
            self.setFont(_SANS, 7)
            self.setFillColor(_SOFT)
            self.drawRightString(A4[0] - _LEFT, 10 * mm, f"{self._pageNumber} / {len(self._pages)}")
            super().showPage()
        super().save()


def _pdf_date(when: str) -> str:
    """The run's time as PDF writes dates; empty if it is none."""
    try:
        stamp = datetime.fromisoformat(when)
    except ValueError:
        return ""
    zone = stamp.strftime("%z")
    return f"D:{stamp:%Y%m%d%H%M%S}" + (f"{zone[:3]}'{zone[3:5]}'" if zone else "")


def _story(report: Report) -> Iterator[Flowable]:
    yield Paragraph(escape(report.subtitle), _style(8, color=_SOFT))
    yield Paragraph(escape(report.title), _style(15, font=_BOLD, after=4))
    yield _Rule()
    begun = False
    for item in report.items:
        if isinstance(item, Section) and item.listed:
            if begun:
                yield PageBreak()
            begun = True
        yield from _flow(item, 0)


def _flow(item: Item, level: int) -> Iterator[Flowable]:
    match item:
        case Section():
            if item.listed and level:
                yield PageBreak()
            heading = _Heading(item.title, level)
            body = [each for part in item.items for each in _flow(part, level + 1)]
            yield CondPageBreak(35 * mm)
            if body and not isinstance(body[0], _Heading | PageBreak | CondPageBreak | Table):
                yield KeepTogether([heading, body[0]])
                yield from body[1:]
            else:
                yield heading
                yield from body
        case Verdict():
            yield _verdict(item)
        case Text():
            yield _paragraph(item)
        case Facts():
            yield _facts(item)
        case Grid():
            yield from _grid(item)
        case Picture():
            yield KeepTogether(
                [
                    _Figure(item),
                    Paragraph(escape(item.caption), _style(8, color=_SOFT, before=3, after=12)),
                ]
            )


def _style(
    size: float, *, font: str = _SANS, color: Any = _INK, before: float = 0, after: float = 0, align: int = 0
) -> ParagraphStyle:
    return ParagraphStyle(
        "",
        fontName=font,
        fontSize=size,
        leading=size * 1.32,
        textColor=color,
        spaceBefore=before,
        spaceAfter=after,
        alignment=align,
        splitLongWords=True,
    )


class _Heading(Paragraph):  # type: ignore[misc]
    def __init__(self, title: str, level: int) -> None:
        size = (12.5, 10.5, 9.0)[min(level, 2)]
        super().__init__(escape(title), _style(size, font=_BOLD, before=14 - 3 * min(level, 2), after=4))
        self.outline_level = min(level, 3)
        self.heading = title


class _Rule(Flowable):  # type: ignore[misc]
    def wrap(self, width: float, _: float) -> tuple[float, float]:
        self._width = width
        return width, 8

    def draw(self) -> None:
        self.canv.setStrokeColor(_INK)
        self.canv.setLineWidth(1)
        self.canv.line(0, 6, self._width, 6)


class _Figure(Flowable):  # type: ignore[misc]
    """A figure at its own size, or smaller where the page is."""

    def __init__(self, picture: Picture) -> None:
        super().__init__()
        self._figure = picture.figure

    def wrap(self, width: float, height: float) -> tuple[float, float]:
        own = (72.0 * self._figure.get_figwidth(), 72.0 * self._figure.get_figheight())
        scale = min(1.0, width / own[0], (_HEIGHT - 25 * mm) / own[1])
        self.width, self.height = own[0] * scale, own[1] * scale
        return self.width, self.height

    def draw(self) -> None:
        draw_figure(self.canv, self._figure, 0.0, 0.0, self.width)


def _verdict(item: Verdict) -> Flowable:
    color = HexColor(_MARKS.get(item.mark, "#595959"))
    lines = [
        Paragraph(escape(item.text), _style(11, font=_BOLD, color=color)),
        Paragraph(escape(item.summary), _style(8.5)),
    ]
    return Table(
        [[lines]],
        colWidths=[_WIDTH],
        style=[
            _FONT,
            ("BOX", (0, 0), (-1, -1), 0.7, color),
            ("LINEBEFORE", (0, 0), (0, -1), 5, color),
            ("LEFTPADDING", (0, 0), (-1, -1), 12),
            ("TOPPADDING", (0, 0), (-1, -1), 5),
            ("BOTTOMPADDING", (0, 0), (-1, -1), 7),
        ],
        spaceBefore=6,
        spaceAfter=8,
    )


def _paragraph(item: Text) -> Flowable:
    if item.kind == "warning":
        return Table(
            [[Paragraph(escape(item.text), _style(8.5))]],
            colWidths=[_WIDTH],
            style=[
                _FONT,
                ("LINEBEFORE", (0, 0), (0, -1), 3, HexColor(_MARKS["fail"])),
                ("BACKGROUND", (0, 0), (-1, -1), _FAINT),
                ("LEFTPADDING", (0, 0), (-1, -1), 10),
            ],
            spaceAfter=6,
        )
    style = {"plain": _style(8.5, after=5), "note": _style(8, color=_SOFT, after=5)}
    return Paragraph(escape(item.text), style.get(item.kind) or _style(7.5, font=_MONO, after=5))


def _facts(item: Facts) -> Flowable:
    rows = [
        [Paragraph(escape(name), _style(7.5, color=_SOFT)), Paragraph(escape(what), _style(7.5))]
        for name, what in item.pairs
    ]
    return Table(rows or [[""]], colWidths=[42 * mm, _WIDTH - 42 * mm], style=_lines(0), spaceAfter=6)


def _grid(item: Grid) -> Iterator[Flowable]:
    if item.caption:
        caption = Paragraph(escape(item.caption), _style(8, color=_SOFT, before=3, after=2))
        yield CondPageBreak(25 * mm)
        yield caption
    size = 7.5 if sum(_least(item, 7.5)) <= _WIDTH else 6.5
    head = [
        Paragraph(escape(each.heading), _style(size, font=_BOLD, align=2 if each.numeric else 0))
        for each in item.columns
    ]
    rows = [
        [_cell(cell, size, numeric=column.numeric) for cell, column in zip(row, item.columns, strict=True)]
        for row in item.rows
    ]
    yield Table([head, *rows], colWidths=_widths(item, size), repeatRows=1, style=_lines(1), hAlign="LEFT")
    yield Spacer(1, 8)


def _cell(cell: Cell, size: float, *, numeric: bool) -> list[Flowable]:
    color = HexColor(_MARKS[cell.mark]) if cell.mark else _INK
    font = _BOLD if cell.mark not in ("", "none") else _SANS
    shown: list[Flowable] = [
        Paragraph(escape(cell.shown), _style(size, font=font, color=color, align=2 if numeric else 0))
    ]
    notes = " ".join(cell.notes)
    return shown + ([Paragraph(escape(notes), _style(size - 1, color=_SOFT, before=1))] if notes else [])


def _needed(text: str, size: float) -> float:
    return float(pdfmetrics.stringWidth(text, _BOLD, size)) + 9.0


def _texts(item: Grid) -> Iterator[tuple[Column, list[Cell], list[str]]]:
    """Each column with its cells and all its texts; the heading of numbers may be broken between words."""
    for number, column in enumerate(item.columns):
        cells = [row[number] for row in item.rows]
        headings = column.heading.split() if column.numeric else [column.heading]
        yield column, cells, [*headings, *(cell.shown for cell in cells)]


def _least(item: Grid, size: float) -> list[float]:
    """Widths of the longest words of the columns, and of the longest numbers."""
    least = []
    for column, _, texts in _texts(item):
        unbroken = texts if column.numeric else [word for text in texts for word in text.split()]
        least.append(min(max((_needed(each, size) for each in unbroken), default=9.0), _WIDTH / 3))
    return least


def _widths(item: Grid, size: float) -> list[float]:
    """Widths that fit the words: what is short as wide as it is, the rest by the length of its texts. What is
    left over goes to the names of the rows; a table of numbers alone stays narrow."""
    least = _least(item, size)
    natural = [
        max(*(_needed(text, size) for text in texts), 70 * mm if any(cell.notes for cell in cells) else 0.0)
        for _, cells, texts in _texts(item)
    ]
    if sum(natural) <= _WIDTH:
        spare = _WIDTH - sum(natural)
        if item.columns[0].numeric:
            return [width + min(spare / len(natural), 5 * mm) for width in natural]
        return [width + (spare if number == 0 else 0.0) for number, width in enumerate(natural)]
    room = max(0.0, _WIDTH - sum(least))
    wish = [max(0.0, one - other) for one, other in zip(natural, least, strict=True)]
    widths = [base + room * each / (sum(wish) or 1.0) for base, each in zip(least, wish, strict=True)]
    return [width * _WIDTH / sum(widths) for width in widths]


def _lines(head: int) -> list[tuple[Any, ...]]:
    style: list[tuple[Any, ...]] = [
        _FONT,
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LINEBELOW", (0, 0), (-1, -1), 0.4, _LINE),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 6),
        ("RIGHTPADDING", (-1, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 1.6),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2.6),
    ]
    return [*style, ("LINEBELOW", (0, 0), (-1, 0), 0.8, _INK), ("VALIGN", (0, 0), (-1, 0), "BOTTOM")][
        : None if head else len(style)
    ]
