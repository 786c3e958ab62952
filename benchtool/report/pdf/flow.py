"""The content of a report as flowables of a PDF: headings, texts, facts, figures and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.units import mm
from reportlab.platypus import CondPageBreak, Flowable, KeepTogether, PageBreak, Paragraph, Table

from benchtool.report.content import Facts, Grid, Item, Picture, Report, Section, Signatures, Text, Verdict
from benchtool.report.pdf.canvas import draw_figure
from benchtool.report.pdf.grid import SideBySide, flow_grid
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

_MOST_LEFT_OUT = 12  # sections that are named


def story(report: Report) -> Iterator[Flowable]:
    """Yield the whole report, with the definitions of its numbers in the appendix; the fonts are to be
    registered before."""
    yield Paragraph(escape(report.subtitle), text_style(8, color=SOFT))
    yield Paragraph(escape(report.title), text_style(15, font=BOLD, after=4))
    yield _Rule()
    for item in report.front:
        yield from _flow(item, 0)
    if report.front:
        yield PageBreak()
    begun = False
    for item in report.items:
        begins = isinstance(item, Section) and item.begins_page
        if begun and begins:
            yield PageBreak()
        begun = begun or begins
        yield from _flow(item, 0)
    everything = (*report.front, *report.items, *report.appendix)
    endnotes = tuple(_definitions(everything))
    left_out = tuple(dict.fromkeys(_left_out(everything)))
    if not (report.appendix or endnotes or left_out):
        return
    yield _Heading("Appendix", 0)
    if left_out:
        more = len(left_out) - _MOST_LEFT_OUT
        shown = [*left_out[:_MOST_LEFT_OUT], *([f"{more} more sections"] if more > 0 else [])]
        yield _paragraph(Text(f"On the page besides, in HTML: {'; '.join(shown)}.", "note"))
    if endnotes:
        yield _Heading("Definitions", 1)
        yield from (_endnote(name, notes) for name, notes in endnotes)
    for item in report.appendix:
        yield from _flow(item, 1)


def _on_paper(items: Sequence[Item]) -> Iterator[Item]:
    for item in items:
        if not isinstance(item, Section):
            yield item
        elif item.paper:
            yield from _on_paper(item.items)


def _left_out(items: Sequence[Item]) -> Iterator[str]:
    """Yield what stands on the page alone."""
    for item in items:
        if isinstance(item, Section) and not item.paper:
            yield item.title
        elif isinstance(item, Section):
            yield from _left_out(item.items)


def _definitions(items: Sequence[Item]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield each name with its definition once and, where it is judged, with the rest of its notes; the grids
    of a report may show the same numbers again."""
    found: dict[tuple[str, str], tuple[str, ...]] = {}
    for item in _on_paper(items):
        for row in item.rows if isinstance(item, Grid) else ():
            for cell in row:
                if cell.notes:
                    judged = any(each.mark for each in row)
                    key = cell.text, cell.notes[0]
                    found[key] = max(found.get(key, ()), cell.notes if judged else cell.notes[:1], key=len)
    yield from ((name, notes) for (name, _), notes in found.items())


def _endnote(name: str, notes: Sequence[str]) -> Paragraph:
    text = f'<font name="{BOLD}">{escape(name)}</font> {escape(" ".join(notes))}'
    return Paragraph(text, text_style(6, after=0.6))


def _flow(item: Item, level: int) -> Iterator[Flowable]:
    match item:
        case Section():
            if not item.paper:
                return
            if item.begins_page and level:
                yield PageBreak()
            heading = _Heading(item.title, level)
            body = list(_body(item.items, level + 1))
            yield CondPageBreak(28 * mm)
            whole = not isinstance(body[0], _Heading | PageBreak | CondPageBreak | Table) if body else False
            if whole or (body and isinstance(body[0], SideBySide)):
                first = body[0]._content if isinstance(body[0], KeepTogether) else [body[0]]
                yield KeepTogether([heading, *first])  # not one in another, which leaves half a page empty
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
            yield KeepTogether(_picture(item))
        case Signatures():
            yield _signatures(item)


def _body(items: Sequence[Item], level: int) -> Iterator[Flowable]:
    """Yield what a section holds; two narrow figures that follow each other stand side by side."""
    waiting: Picture | None = None
    for item in items:
        if isinstance(item, Picture) and waiting is not None and _across(waiting, item):
            one, other = waiting, item
            waiting = None
            widths = [_inches(each) + 0.5 * (WIDTH - _inches(one) - _inches(other)) for each in (one, other)]
            style = [FONT, ("VALIGN", (0, 0), (-1, -1), "TOP"), ("LEFTPADDING", (0, 0), (-1, -1), 0)]
            yield SideBySide([[_picture(one), _picture(other)]], colWidths=widths, style=style)
            continue
        if waiting is not None:
            yield from _flow(waiting, level)
        waiting = item if isinstance(item, Picture) else None
        if waiting is None:
            yield from _flow(item, level)
    if waiting is not None:
        yield from _flow(waiting, level)


def _inches(picture: Picture) -> float:
    """Return the width of a figure at its own size, in points."""
    return 72.0 * float(picture.figure.get_figwidth())


def _across(one: Picture, other: Picture) -> bool:
    return bool(_inches(one) + _inches(other) <= WIDTH)


def _picture(item: Picture) -> list[Flowable]:
    caption = Paragraph(escape(item.caption), text_style(7.5, color=SOFT, before=2, after=8))
    return [_Figure(item), caption]


def _signatures(item: Signatures) -> Flowable:
    """Return a line to sign on for each role, beside each other."""
    gap = 8 * mm
    each = (WIDTH - gap * (len(item.roles) - 1)) / max(1, len(item.roles))
    cells: list[Flowable | str] = []
    for role in item.roles:
        cells += [Paragraph(f"{escape(role)}: name, date, signature", text_style(7, color=SOFT)), ""]
    lines = [("LINEABOVE", (column, 0), (column, 0), 0.7, INK) for column in range(0, len(cells) - 1, 2)]
    return Table(
        [cells[:-1]],
        colWidths=[gap if number % 2 else each for number in range(len(cells) - 1)],
        style=[FONT, ("LEFTPADDING", (0, 0), (-1, -1), 0), *lines],
        spaceBefore=18 * mm,
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
