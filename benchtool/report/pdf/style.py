"""Style of the PDF: page size, fonts, colours, and lines of tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from reportlab.lib.colors import HexColor
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont

INK, SOFT, LINE, FAINT = (HexColor(code) for code in ("#1a1a1a", "#595959", "#d4d4d4", "#f4f4f2"))
MARKS: Final = {
    "pass": "#00664b",
    "better": "#00664b",
    "marginal": "#7a4f00",
    "undecided": "#5b3a8e",
    "fail": "#a32b00",
    "worse": "#a32b00",
    "none": "#595959",
}
SANS, BOLD, MONO = "DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono"
LEFT, _TOP, BOTTOM = 17 * mm, 16 * mm, 19 * mm
WIDTH: Final = A4[0] - 2 * LEFT
HEIGHT: Final = A4[1] - _TOP - BOTTOM
FONT: Final = ("FONTNAME", (0, 0), (-1, -1), SANS)  # else a table names one that is not embedded


def register_fonts() -> None:
    """Register the fonts."""
    for name in (SANS, BOLD, MONO):
        if name not in pdfmetrics.getRegisteredFontNames():
            pdfmetrics.registerFont(TTFont(name, Path(mpl.get_data_path(), "fonts", "ttf", f"{name}.ttf")))


def text_style(
    size: float, *, font: str = SANS, color: Any = INK, before: float = 0, after: float = 0, align: int = 0
) -> ParagraphStyle:
    """Return the style of text of `size` pt; `align` is 0 for left and 2 for right."""
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


def ruled(*, head: bool = False) -> list[tuple[Any, ...]]:
    """Return the style of a table with a line below each row, a stronger one below its head if it has one."""
    style: list[tuple[Any, ...]] = [
        FONT,
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LINEBELOW", (0, 0), (-1, -1), 0.4, LINE),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 6),
        ("RIGHTPADDING", (-1, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 0.8),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 1.4),
    ]
    if head:
        style += [("LINEBELOW", (0, 0), (-1, 0), 0.8, INK), ("VALIGN", (0, 0), (-1, 0), "BOTTOM")]
        style += [("TOPPADDING", (0, 1), (-1, 1), 1.8)]  # off the stronger line
    return style
