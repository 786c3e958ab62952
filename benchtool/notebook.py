"""HTML of values that a notebook shows (the `_repr_html_` protocol of IPython), everything in it escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

_CELL = "padding:0.15em 0.7em;text-align:{};vertical-align:top"


def table_html(
    columns: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "", footer: str = ""
) -> str:
    """Return a table; a column whose title begins with `>` is set flush right."""
    sides = ["right" if title.startswith(">") else "left" for title in columns]
    head = "".join(
        f'<th style="{_CELL.format(side)}">{escape(title.removeprefix(">"))}</th>'
        for title, side in zip(columns, sides, strict=True)
    )
    body = "".join(
        "<tr>"
        + "".join(
            f'<td style="{_CELL.format(side)}">{escape(str(cell))}</td>'
            for cell, side in zip(row, sides, strict=True)
        )
        + "</tr>"
        for row in rows
    )
    title = f'<caption style="text-align:left"><b>{escape(caption)}</b></caption>' if caption else ""
    below = f"<p>{escape(footer)}</p>" if footer else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{below}"
