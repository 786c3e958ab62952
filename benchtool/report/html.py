"""A report as one HTML page that needs nothing else: no script, no file beside it, no network."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from benchtool.report.content import Facts, Grid, Picture, Report, Section, Text, Verdict, anchor, contents
from benchtool.report.images import data_uri

MARK = b'<meta name="generator" content="benchtool">'
"""What every page has, whatever the report."""

_TEMPLATES = Path(__file__).parent / "templates"
_KINDS = {
    Facts: "facts",
    Grid: "grid",
    Picture: "picture",
    Section: "section",
    Text: "text",
    Verdict: "verdict",
}


def html_page(report: Report) -> str:
    """The page; the same report gives the same text. Whatever stands in the report is shown as text."""
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
    listed = contents(report.items)
    return environment.get_template("report.html").render(report=report, contents=listed) + "\n"
