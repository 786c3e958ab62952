"""Figures embedded in a page: SVG, or PNG where the drawing is dense."""

from __future__ import annotations

import base64
import io
from typing import Any, Final

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from benchtool.report.figures.files import lay_out, write_png

MOST_SVG_BYTES: Final = 400_000
_SETTINGS: Final[Any] = {
    "svg.fonttype": "path",
    "svg.hashsalt": "benchtool",
}  # the same drawing, the same bytes
_NO_METADATA: Final = {"Date": None, "Creator": None}


def data_uri(figure: Figure) -> str:
    """Return the figure as a `data:` address: an SVG of at most `MOST_SVG_BYTES`, else a PNG.

    As the source of an image an SVG runs no script and loads nothing, whatever its texts say.
    """
    lay_out(figure)
    drawing = _svg(figure)
    if len(drawing) <= MOST_SVG_BYTES:
        return _uri("image/svg+xml", drawing)
    file = io.BytesIO()
    write_png(figure, file, metadata={"Software": None})
    return _uri("image/png", file.getvalue())


def _svg(figure: Figure) -> bytes:
    file = io.BytesIO()
    with mpl.rc_context(_SETTINGS):
        FigureCanvasSVG(figure).print_svg(file, metadata=_NO_METADATA)  # type: ignore[no-untyped-call]
    return file.getvalue()


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"
