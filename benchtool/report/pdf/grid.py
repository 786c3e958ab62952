"""The tables of the PDF: columns as wide as their words need, headings again on each page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.platypus import CondPageBreak, Flowable, Paragraph, Spacer, Table

from benchtool.report.content import Cell, Column, Grid
from benchtool.report.pdf.style import BOLD, FONT, INK, MARKS, SANS, SOFT, WIDTH, ruled, text_style

_GAP = 5 * mm  # between columns of a narrow grid
_SMALL = 6.0
_FEWEST_ROWS = 4  # of such a column
_MOST_ROWS = 40
_MANY_ROWS = 30  # from which on the type is smaller
_MOST_BESIDE = 3


class SideBySide(Table):  # type: ignore[misc]
    """Parts of a page beside each other, which no page break divides."""


def flow_grid(item: Grid) -> Iterator[Flowable]:
    """Yield a grid with its caption; in smaller type where its words would not fit otherwise."""
    if item.caption:
        caption = Paragraph(escape(item.caption), text_style(8, color=SOFT, before=3, after=2))
        yield CondPageBreak(25 * mm)
        yield caption
    printed = [number for number, column in enumerate(item.columns) if column.paper]
    rows = tuple(tuple(row[number] for number in printed) for row in item.rows[: item.shown])
    left_out = len(item.rows) - len(rows)
    item = replace(item, columns=tuple(item.columns[number] for number in printed), rows=rows)
    size = 7.0 if sum(_least(item, 7.0)) <= WIDTH and len(rows) <= _MANY_ROWS else 6.5
    narrow = _natural(item, _SMALL)
    beside = min(_MOST_BESIDE, len(rows) // _FEWEST_ROWS, int((WIDTH + _GAP) / (sum(narrow) + _GAP)))
    if beside < 2:
        yield _table(item, size, _widths(item, size))
    else:
        yield from _in_columns(item, _SMALL, narrow, beside)
    if left_out:
        text = f"The other {left_out} of {left_out + len(rows)} rows stand on the page."
        yield Paragraph(text, text_style(6.5, color=SOFT, before=1))
    yield Spacer(1, 6)


def _table(item: Grid, size: float, widths: list[float]) -> Table:
    head = [
        Paragraph(escape(each.heading), text_style(size, font=BOLD, align=2 if each.numeric else 0))
        for each in item.columns
    ]
    rows = [
        [_cell(cell, size, numeric=column.numeric) for cell, column in zip(row, item.columns, strict=True)]
        for row in item.rows
    ]
    return Table([head, *rows], colWidths=widths, repeatRows=1, style=ruled(head=True), hAlign="LEFT")


def _in_columns(item: Grid, size: float, widths: list[float], beside: int) -> Iterator[Flowable]:
    """Yield a long and narrow grid in columns beside each other, as many rows at a time as a page may
    hold."""
    spare = (WIDTH - _GAP * (beside - 1) - beside * sum(widths)) / beside
    widths = [widths[0] + spare, *widths[1:]]
    for begin in range(0, len(item.rows), _MOST_ROWS * beside):
        part = item.rows[begin : begin + _MOST_ROWS * beside]
        tall = -(-len(part) // beside)
        parts = [part[at : at + tall] for at in range(0, len(part), tall)]
        cells = [_table(replace(item, rows=each), size, widths) for each in parts]
        columns = [sum(widths) + _GAP] * (len(cells) - 1) + [sum(widths)]
        style = [FONT, ("VALIGN", (0, 0), (-1, -1), "TOP"), ("LEFTPADDING", (0, 0), (-1, -1), 0)]
        style += [("RIGHTPADDING", (0, 0), (-1, -1), 0), ("TOPPADDING", (0, 0), (-1, -1), 0)]
        yield SideBySide([cells], colWidths=columns, style=style, hAlign="LEFT")


def _cell(cell: Cell, size: float, *, numeric: bool) -> list[Flowable]:
    color = HexColor(MARKS[cell.mark]) if cell.mark else INK
    font = BOLD if cell.mark not in ("", "none") else SANS
    return [
        Paragraph(escape(cell.shown), text_style(size, font=font, color=color, align=2 if numeric else 0))
    ]


def _needed(text: str, size: float, font: str = BOLD) -> float:
    return float(pdfmetrics.stringWidth(text, font, size)) + 8.0


def _texts(item: Grid) -> Iterator[tuple[Column, list[Cell], list[str]]]:
    """Yield each column with its cells and all its texts; a heading but the first may be broken between
    words."""
    for number, column in enumerate(item.columns):
        cells = [row[number] for row in item.rows]
        headings = column.heading.split() if number else [column.heading]
        yield column, cells, [*headings, *(cell.shown for cell in cells)]


def _least(item: Grid, size: float) -> list[float]:
    """Return the widths of the longest words of the columns, and of the longest numbers."""
    least = []
    for column, _, texts in _texts(item):
        unbroken = texts if column.numeric else [word for text in texts for word in text.split(" ")]
        least.append(min(max((_needed(each, size) for each in unbroken), default=9.0), WIDTH / 3))
    return least


def _natural(item: Grid, size: float) -> list[float]:
    """Return the widths in which no cell is broken; a heading may be, between words."""
    return [
        max(
            *(_needed(text, size) for text in texts[: len(texts) - len(cells)]),
            *(_needed(cell.shown, size, BOLD if cell.mark else SANS) for cell in cells),
        )
        for _, cells, texts in _texts(item)
    ]


def _widths(item: Grid, size: float) -> list[float]:
    """Return the widths of the columns: short columns keep their width, others share by the length of their
    texts. The rest goes to the names of the rows; a table of numbers alone stays narrow."""
    least = _least(item, size)
    natural = _natural(item, size)
    if sum(natural) <= WIDTH:
        spare = WIDTH - sum(natural)
        if item.columns[0].numeric:
            return [width + min(spare / len(natural), 5 * mm) for width in natural]
        return [width + (spare if number == 0 else 0.0) for number, width in enumerate(natural)]
    room = max(0.0, WIDTH - sum(least))
    wish = [max(0.0, one - other) for one, other in zip(natural, least, strict=True)]
    widths = [base + room * each / (sum(wish) or 1.0) for base, each in zip(least, wish, strict=True)]
    return [width * WIDTH / sum(widths) for width in widths]
