"""Style of all figures: colours, sizes and axes, without pyplot or other global state.

Colours are those of Okabe and Ito (Color Universal Design, 2008), distinct to the colour-blind. In print
without colour the phases differ in darkness, series by their markers and dashes.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text

BLACK: Final = "#1a1a1a"
BLUE: Final = "#0072b2"
ORANGE: Final = "#d55e00"
GREEN: Final = "#009e73"
GREY: Final = "#9a9a9a"
LIGHT: Final = "#d4d4d4"

SERIES: Final = (BLUE, ORANGE, GREEN, BLACK, "#cc79a7", "#e69f00", "#56b4e9")
PHASES: Final = {"i_a": "#003d66", "i_b": ORANGE, "i_c": "#56b4e9"}  # dark, middle, light
DASHES: Final = ((0, ()), (0, (5, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2)))
REFERENCE: Final[dict[str, Any]] = {"color": BLACK, "linewidth": 0.9, "linestyle": (0, (5, 3))}

LIMIT: Final[dict[str, Any]] = {"color": "#b34700", "linewidth": 1.2, "linestyle": (0, (6, 2, 1.5, 2))}

ABOVE: Final[dict[str, Any]] = {"loc": "left", "y": 1.0}
"""Place of a title; without a height, Matplotlib measures all axes several times to find the same one."""

WIDTH_IN: Final = 7.0
DPI: Final = 220
_FONT_PT: Final = 9
_LINE_IN: Final = 0.2
_MISSING: Final = "\N{REPLACEMENT CHARACTER}"
_BESIDE: Final = 6  # entries of a legend that begins on the left
_ON_THE_RIGHT: Final = 4
_HANDLE_EM, _APART_EM = 1.8, 1.4  # of an entry of a legend
_AXIS_IN: Final = 0.8  # for the numbers and the label beside axes
_CHARACTERS_PER_IN: Final = 13  # of a title, on average


def new_figure(height_in: float, title: str, summary: str, width_in: float = WIDTH_IN) -> Figure:
    """Return an empty figure with its own Agg canvas; on the left above it the title and a line with its
    numbers."""
    across = round(width_in * _CHARACTERS_PER_IN)
    lines, told = textwrap.wrap(title, across), textwrap.wrap(summary, across)
    size = (width_in, height_in + _LINE_IN * (len(lines) + max(0, len(told) - 1) - 1))
    figure = Figure(figsize=size, dpi=DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    figure.suptitle(
        literal("\n".join([*lines, *told])),
        x=0.01,
        horizontalalignment="left",
        fontsize=_FONT_PT + 1,
        color=BLACK,
    )
    return figure


def literal(text: str) -> str:
    """Return external text with the characters escaped that matplotlib takes for a formula.

    Those that the font has not become the sign for that, of which Matplotlib would draw a box and warn.
    """
    if not text.isascii():
        font = get_font(findfont(FontProperties()))
        text = "".join(
            each if each.isascii() or font.get_char_index(ord(each)) else _MISSING for each in text
        )
    return text.replace("$", r"\$")


def dress(axes: Axes, x_label: str, y_label: str) -> None:
    """Set labels with units, a light grid, and no frame on sides without a scale."""
    axes.set_xlabel(x_label, fontsize=_FONT_PT, color=BLACK)
    axes.set_ylabel(y_label, fontsize=_FONT_PT, color=BLACK)
    axes.tick_params(labelsize=_FONT_PT - 1, color=GREY, labelcolor=BLACK)
    axes.grid(visible=True, color=LIGHT, linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(GREY)


def add_legend(axes: Axes, *, at_left: bool = False) -> int:
    """Set a legend above the axes, where it covers no curve: on the right, or from the left edge on, over the
    axes beside it. Return its rows: as many as it takes not to be wider than its room."""
    _, labels = axes.get_legend_handles_labels()
    columns = _legend_columns(axes, labels, at_left=at_left)
    axes.legend(
        loc="lower left" if at_left else "lower right",
        bbox_to_anchor=(0.0 if at_left else 1.0, 1.0),
        ncols=columns,
        frameon=False,
        fontsize=_FONT_PT - 1,
        borderaxespad=0.1,
        handlelength=_HANDLE_EM,
        columnspacing=_APART_EM,
    )
    return -(-len(labels) // columns)


def _legend_columns(axes: Axes, labels: Sequence[str], *, at_left: bool) -> int:
    """Return the most columns of a legend that have room above the axes."""
    figure, place = axes.get_figure(root=True), axes.get_subplotspec()
    across = 1 if at_left or place is None else place.get_gridspec().ncols
    size = _FONT_PT - 1
    assert figure is not None
    room_pt = (float(figure.get_figwidth()) - _AXIS_IN * across) * 72.0 / across
    wide = [
        Text(text=label, fontsize=size, figure=figure).get_window_extent().width * 72.0 / figure.dpi
        + (_HANDLE_EM + _APART_EM + 0.8) * size
        for label in labels
    ]
    for columns in range(min(_BESIDE if at_left else _ON_THE_RIGHT, len(wide)), 1, -1):
        rows = -(-len(wide) // columns)
        if sum(max(wide[begin : begin + rows]) for begin in range(0, len(wide), rows)) <= room_pt:
            return columns
    return 1


def annotate_point(axes: Axes, text: str, x: float, y: float, color: str) -> None:
    """A marked point with a text above it, on the side where the axes (limits set before) have more room."""
    axes.plot([x], [y], marker="o", markersize=5, markerfacecolor="none", markeredgecolor=color, linestyle="")
    leftwards = x > sum(axes.get_xlim()) / 2
    axes.annotate(
        text,
        (x, y),
        xytext=(-7 if leftwards else 7, 3),
        textcoords="offset points",
        horizontalalignment="right" if leftwards else "left",
        fontsize=_FONT_PT - 1,
        color=color,
    )
