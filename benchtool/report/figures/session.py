"""Figures of acceptance tests: values over a map of operating points, and traces of a block."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from benchtool.block import Block
from benchtool.report.figures.envelope import trace
from benchtool.report.figures.labels import channel_label
from benchtool.report.figures.style import LIMIT, SERIES, WIDTH_IN, add_legend, dress, literal, new_figure

_HEIGHT_IN = 3.4
_TRACE_IN = 1.7
_COLUMNS = 1400


def draw_map(
    points: Sequence[tuple[float, float, float]], what: str, limit: float, x_label: str, y_label: str
) -> Figure:
    """Return a map of values, each at its operating point (x, y), as part of the greatest that is allowed."""
    largest = max((abs(value) for _, _, value in points), default=0.0)
    summary = f"largest {largest:.3g} of {limit:.3g} allowed; the area of a disc is the value"
    figure = new_figure(_HEIGHT_IN, what, summary)
    axes = figure.subplots()
    x, y, values = (np.array(each) for each in zip(*points, strict=True))
    within = np.abs(values) <= limit
    for chosen, color, label in ((within, SERIES[0], "within"), (~within, SERIES[1], "beyond the limit")):
        if chosen.any():
            size = 20.0 + 400.0 * np.minimum(np.abs(values[chosen]) / limit, 4.0)
            axes.scatter(x[chosen], y[chosen], s=size, color=color, alpha=0.6, label=label)
    for one, other, value in points:
        axes.annotate(f"{value:.2g}", (one, other), fontsize=7, ha="center", va="center")
    dress(axes, x_label, y_label)
    axes.margins(0.2)
    add_legend(axes)
    return figure


def draw_traces(
    block: Block, groups: Sequence[Sequence[str]], title: str, at_s: Mapping[str, float]
) -> Figure:
    """Return channels of a block against time, those of a group in one panel; `at_s` marks moments by name,
    from the first row on."""
    figure = new_figure(_TRACE_IN * len(groups) + 0.4, title, "")
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    for axes, names in zip(panels, groups, strict=True):
        for color, name in zip(SERIES, names, strict=False):
            label = channel_label(name, block.unit(name))
            axes.plot(*trace(block, name, columns=_COLUMNS), color=color, linewidth=0.8, label=label)
        for name, moment_s in at_s.items():
            axes.axvline(moment_s, **LIMIT, label=literal(name))
        dress(axes, "", "")
        axes.margins(x=0.0)
        add_legend(axes)
    panels[-1].set_xlabel("time $t$ (s)", fontsize=9)
    return figure


def figure_of_png(data: bytes) -> Figure:
    """Return a figure that shows a picture as it is."""
    pixels = mpl.image.imread(io.BytesIO(data), format="png")
    height, width = pixels.shape[:2]
    figure = Figure(figsize=(WIDTH_IN, WIDTH_IN * height / width), dpi=width / WIDTH_IN)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.imshow(pixels, aspect="auto", interpolation="none")
    axes.set_axis_off()
    return figure
