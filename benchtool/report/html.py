"""A report as one self-contained HTML page, without scripts, further files or network access."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from benchtool.report.content import (
    Facts,
    Grid,
    Picture,
    Report,
    Section,
    Signatures,
    Text,
    Verdict,
    anchor,
    contents,
)
from benchtool.report.figures.style import WIDTH_IN
from benchtool.report.images import data_uri

MARK = b'<meta name="generator" content="benchtool">'
"""Text that identifies every page."""

_TEMPLATES = Path(__file__).parent / "templates"
_KINDS = {
    Facts: "facts",
    Grid: "grid",
    Picture: "picture",
    Section: "section",
    Signatures: "signatures",
    Text: "text",
    Verdict: "verdict",
}


def html_page(report: Report) -> str:
    """Return the page; the same report gives the same text. All content is escaped as text."""
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["kind"] = lambda item: _KINDS[type(item)]
    environment.filters["uri"] = data_uri
    environment.filters["anchor"] = anchor
    listed = contents((*report.front, *report.items))
    page = environment.get_template("report.html").render(report=report, contents=listed, full_in=WIDTH_IN)
    return page + "\n"
