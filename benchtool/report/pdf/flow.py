"""What a report says as what flows over the pages of a PDF: headings, texts, facts, figures and tables."""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.units import mm
from reportlab.platypus import CondPageBreak, Flowable, KeepTogether, PageBreak, Paragraph, Table

from benchtool.report.content import Facts, Grid, Item, Picture, Report, Section, Text, Verdict
from benchtool.report.pdf.canvas import draw_figure
from benchtool.report.pdf.grid import flow_grid
from benchtool.report.pdf.style import (
    BOLD,
    FAINT,
    FONT,
    HEIGHT,
    INK,
    MARKS,
    MONO,
    SOFT,
    WIDTH,
    ruled,
    text_style,
)


def story(report: Report) -> Iterator[Flowable]:
    """The whole report; the fonts are to be registered before."""
    yield Paragraph(escape(report.subtitle), text_style(8, color=SOFT))
    yield Paragraph(escape(report.title), text_style(15, font=BOLD, after=4))
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
            yield from flow_grid(item)
        case Picture():
            yield KeepTogether(
                [
                    _Figure(item),
                    Paragraph(escape(item.caption), text_style(8, color=SOFT, before=3, after=12)),
                ]
            )


class _Heading(Paragraph):  # type: ignore[misc]
    def __init__(self, title: str, level: int) -> None:
        size = (12.5, 10.5, 9.0)[min(level, 2)]
        super().__init__(escape(title), text_style(size, font=BOLD, before=14 - 3 * min(level, 2), after=4))
        self.outline_level = min(level, 3)
        self.heading = title


class _Rule(Flowable):  # type: ignore[misc]
    def wrap(self, width: float, _: float) -> tuple[float, float]:
        self._width = width
        return width, 8

    def draw(self) -> None:
        self.canv.setStrokeColor(INK)
        self.canv.setLineWidth(1)
        self.canv.line(0, 6, self._width, 6)


class _Figure(Flowable):  # type: ignore[misc]
    """A figure at its own size, or smaller where the page is."""

    def __init__(self, picture: Picture) -> None:
        super().__init__()
        self._figure = picture.figure

    def wrap(self, width: float, height: float) -> tuple[float, float]:
        own = (72.0 * self._figure.get_figwidth(), 72.0 * self._figure.get_figheight())
        scale = min(1.0, width / own[0], (HEIGHT - 25 * mm) / own[1])
        self.width, self.height = own[0] * scale, own[1] * scale
        return self.width, self.height

    def draw(self) -> None:
        draw_figure(self.canv, self._figure, 0.0, 0.0, self.width)


def _verdict(item: Verdict) -> Flowable:
    color = HexColor(MARKS.get(item.mark, "#595959"))
    lines = [
        Paragraph(escape(item.text), text_style(11, font=BOLD, color=color)),
        Paragraph(escape(item.summary), text_style(8.5)),
    ]
    return Table(
        [[lines]],
        colWidths=[WIDTH],
        style=[
            FONT,
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
            [[Paragraph(escape(item.text), text_style(8.5))]],
            colWidths=[WIDTH],
            style=[
                FONT,
                ("LINEBEFORE", (0, 0), (0, -1), 3, HexColor(MARKS["fail"])),
                ("BACKGROUND", (0, 0), (-1, -1), FAINT),
                ("LEFTPADDING", (0, 0), (-1, -1), 10),
            ],
            spaceAfter=6,
        )
    style = {"plain": text_style(8.5, after=5), "note": text_style(8, color=SOFT, after=5)}
    return Paragraph(escape(item.text), style.get(item.kind) or text_style(7.5, font=MONO, after=5))


def _facts(item: Facts) -> Flowable:
    rows = [
        [Paragraph(escape(name), text_style(7.5, color=SOFT)), Paragraph(escape(what), text_style(7.5))]
        for name, what in item.pairs
    ]
    return Table(rows or [[""]], colWidths=[42 * mm, WIDTH - 42 * mm], style=ruled(), spaceAfter=6)
