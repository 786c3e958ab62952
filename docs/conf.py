"""Sphinx configuration: `python -m sphinx -W --keep-going -b html docs docs/_build` builds the pages."""

from __future__ import annotations

from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

from benchtool import __version__

project = "benchtool"
author = "The benchtool authors"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "generate"]
root_doc = "index"
default_role = "literal"  # of names between single backticks in docstrings

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = f"benchtool {version}"
html_show_sourcelink = False
html_copy_source = False

ELSEWHERE = {"reference/objects": "objects.md", "reference/serial": "serial.md"}
"""Pages whose text is in firmware_protocol/, beside what it describes and ships with."""


def _take_from_elsewhere(_app: Sphinx, page: str, source: list[str]) -> None:
    if page in ELSEWHERE:
        protocol = Path(__file__).parents[1] / "firmware_protocol"
        text = (protocol / ELSEWHERE[page]).read_text(encoding="utf-8")
        source[0] = text.replace("(serial_vectors.json)", "(../../firmware_protocol/serial_vectors.json)")


def _read_docstring(
    _app: Sphinx, _kind: str, _name: str, _what: object, _options: object, lines: list[str]
) -> None:
    """Mark indented examples of a docstring as code."""
    found: list[str] = []
    for number, line in enumerate(lines):
        after_blank = number > 0 and not lines[number - 1].strip()
        above = next((each for each in reversed(lines[:number]) if each.strip()), "")
        if after_blank and line.startswith("    ") and not above.startswith(" ") and not above.endswith("::"):
            found += [".. code-block:: python", ""]
        found.append(line)
    lines[:] = found


def setup(app: Sphinx) -> None:
    """Join Sphinx: pages from elsewhere, docstrings as they are written, a lexer for diagrams."""
    app.connect("autodoc-process-docstring", _read_docstring, priority=100)  # before napoleon
    app.connect("source-read", _take_from_elsewhere)
    app.add_lexer("mermaid", TextLexer)
