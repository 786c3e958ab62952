"""Overview of a recording: every channel over its entire length."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from benchtool.block import Block
from benchtool.report.figures.envelope import trace
from benchtool.report.figures.labels import channel_label
from benchtool.report.figures.style import ABOVE, BLUE, dress, new_figure

_PANEL_IN = 1.05
_FEW_CHANNELS = 4
_STRETCHES = 700  # across a panel of half the width


def draw_channels(block: Block, title: str) -> Figure:
    """Return every channel against time, each in a panel of its own; of a long trace, least and greatest
    values."""
    columns = 1 if len(block.channels) <= _FEW_CHANNELS else 2
    rows = math.ceil(len(block.channels) / columns)
    figure = new_figure(_PANEL_IN * rows + 0.6, title, "")
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False)
    for axes, channel in zip(panels.flat, block.channels, strict=False):
        axes.plot(*trace(block, channel.name, columns=_STRETCHES), color=BLUE, linewidth=0.6)
        dress(axes, "", "")
        axes.margins(x=0.0)
        axes.locator_params(axis="y", nbins=4)
        axes.set_title(channel_label(channel.name, channel.unit), **ABOVE, fontsize=8)
    for axes in panels.flat[len(block.channels) :]:
        axes.set_axis_off()
    for column in panels.T:
        last = [axes for axes in column if axes.axison][-1]
        last.set_xlabel("time $t$ (s)", fontsize=9)
        last.tick_params(labelbottom=True)
    return figure
