"""The one look of every figure: colours, sizes and axes, without pyplot or any other global state.

Colours are those of Okabe and Ito (Color Universal Design, 2008), distinct to the colour-blind. In print
without colour the phases differ in darkness, series by their markers and dashes.
"""

from __future__ import annotations

import textwrap
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

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

WIDTH_IN: Final = 7.0
DPI: Final = 220
_FONT_PT: Final = 9
_LINE_IN: Final = 0.25
_CHARACTERS_PER_IN: Final = 13  # of a title, on average


def new_figure(height_in: float, title: str, summary: str, width_in: float = WIDTH_IN) -> Figure:
    """An empty figure with its own Agg canvas; on the left above it the title and a line with its numbers."""
    lines = textwrap.wrap(title, round(width_in * _CHARACTERS_PER_IN))
    size = (width_in, height_in + _LINE_IN * (len(lines) - 1))
    figure = Figure(figsize=size, dpi=DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    figure.suptitle(
        literal("\n".join([*lines, summary]).rstrip()),
        x=0.01,
        horizontalalignment="left",
        fontsize=_FONT_PT + 1,
        color=BLACK,
    )
    return figure


def literal(text: str) -> str:
    """Text from outside, in which matplotlib is to find no formula."""
    return text.replace("$", r"\$")


def dress(axes: Axes, x_label: str, y_label: str) -> None:
    """Labels with units, a light grid, no frame where there is no scale."""
    axes.set_xlabel(x_label, fontsize=_FONT_PT, color=BLACK)
    axes.set_ylabel(y_label, fontsize=_FONT_PT, color=BLACK)
    axes.tick_params(labelsize=_FONT_PT - 1, color=GREY, labelcolor=BLACK)
    axes.grid(visible=True, color=LIGHT, linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(GREY)


def add_legend(axes: Axes) -> None:
    """A legend above the axes, on the right, where it covers no curve."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=4,
        frameon=False,
        fontsize=_FONT_PT - 1,
        borderaxespad=0.1,
        handlelength=1.8,
        columnspacing=1.4,
    )


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
