"""Figure of the inverter's states: share of the time of each vector."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from benchtool.analysis import Table, raw
from benchtool.report.figures.style import BLUE, ORANGE, add_legend, dress, new_figure

_WIDTH_IN = 3.6
_HEIGHT_IN = 3.5


def draw_switching_states(table: Table, *, title: str) -> Figure:
    """Return a bar for each vector: share of the time, and beside it share of the periods that use it.

    Args:
        table: `switching_states` of `benchtool.analysis.switching`.
    """
    vector, angle_deg, time_share, period_share = np.array(table.rows).T
    summary = f"without voltage {raw(time_share[0], 3)} % of the time"
    figure = new_figure(_HEIGHT_IN, title, summary, width_in=_WIDTH_IN)
    axes = figure.subplots()
    place = np.arange(len(vector))
    axes.bar(place - 0.2, time_share, 0.4, color=BLUE, label="of the time")
    axes.bar(
        place + 0.2,
        period_share,
        0.4,
        facecolor="none",
        edgecolor=ORANGE,
        hatch="////",
        linewidth=0.9,
        label="of the periods",
    )
    names = [
        "0, 7" if math.isnan(angle) else f"{number:.0f}\n{angle:.0f}°"
        for number, angle in zip(vector, angle_deg, strict=True)
    ]
    dress(axes, "voltage vector (0, 7: zero) and its angle", "share (%)")
    axes.set_xticks(place, names)
    axes.grid(visible=False, axis="x")
    add_legend(axes)
    return figure
