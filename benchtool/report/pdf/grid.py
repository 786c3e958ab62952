"""The tables of the PDF: columns as wide as their words need, headings again on each page."""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.platypus import CondPageBreak, Flowable, Paragraph, Spacer, Table

from benchtool.report.content import Cell, Column, Grid
from benchtool.report.pdf.style import BOLD, INK, MARKS, SANS, SOFT, WIDTH, ruled, text_style


def flow_grid(item: Grid) -> Iterator[Flowable]:
    """A grid with its caption; in smaller type where its words would not fit otherwise."""
    if item.caption:
        caption = Paragraph(escape(item.caption), text_style(8, color=SOFT, before=3, after=2))
        yield CondPageBreak(25 * mm)
        yield caption
    size = 7.5 if sum(_least(item, 7.5)) <= WIDTH else 6.5
    head = [
        Paragraph(escape(each.heading), text_style(size, font=BOLD, align=2 if each.numeric else 0))
        for each in item.columns
    ]
    rows = [
        [_cell(cell, size, numeric=column.numeric) for cell, column in zip(row, item.columns, strict=True)]
        for row in item.rows
    ]
    yield Table(
        [head, *rows], colWidths=_widths(item, size), repeatRows=1, style=ruled(head=True), hAlign="LEFT"
    )
    yield Spacer(1, 8)


def _cell(cell: Cell, size: float, *, numeric: bool) -> list[Flowable]:
    color = HexColor(MARKS[cell.mark]) if cell.mark else INK
    font = BOLD if cell.mark not in ("", "none") else SANS
    shown: list[Flowable] = [
        Paragraph(escape(cell.shown), text_style(size, font=font, color=color, align=2 if numeric else 0))
    ]
    notes = " ".join(cell.notes)
    return shown + ([Paragraph(escape(notes), text_style(size - 1, color=SOFT, before=1))] if notes else [])


def _needed(text: str, size: float) -> float:
    return float(pdfmetrics.stringWidth(text, BOLD, size)) + 9.0


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
        least.append(min(max((_needed(each, size) for each in unbroken), default=9.0), WIDTH / 3))
    return least


def _widths(item: Grid, size: float) -> list[float]:
    """Widths that fit the words: what is short as wide as it is, the rest by the length of its texts. What is
    left over goes to the names of the rows; a table of numbers alone stays narrow."""
    least = _least(item, size)
    natural = [
        max(*(_needed(text, size) for text in texts), 70 * mm if any(cell.notes for cell in cells) else 0.0)
        for _, cells, texts in _texts(item)
    ]
    if sum(natural) <= WIDTH:
        spare = WIDTH - sum(natural)
        if item.columns[0].numeric:
            return [width + min(spare / len(natural), 5 * mm) for width in natural]
        return [width + (spare if number == 0 else 0.0) for number, width in enumerate(natural)]
    room = max(0.0, WIDTH - sum(least))
    wish = [max(0.0, one - other) for one, other in zip(natural, least, strict=True)]
    widths = [base + room * each / (sum(wish) or 1.0) for base, each in zip(least, wish, strict=True)]
    return [width * WIDTH / sum(widths) for width in widths]
