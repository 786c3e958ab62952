"""Figure of orders: components of a signal that repeat per mechanical revolution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from benchtool.analysis import Panel, raw, with_expanded
from benchtool.analysis.orders import Orders, OrderSpectrum, machine_orders, order_meaning
from benchtool.report.figures.labels import channel_label, with_unit
from benchtool.report.figures.style import BLUE, LIGHT, LIMIT, ORANGE, add_legend, dress, new_figure

_LISTED = 5
_SHOWN_BEYOND = 1.25  # of the highest order listed
_FEWEST_SHOWN = 12
_FONT_PT = 8
_APART = 0.02  # of the axis, between numbers above stems


def draw_orders(panel: Panel, analysis: str, title: str) -> Figure:
    """Return the stems of peak amplitude over order; the largest five are numbered, and listed below.

    Grey steps are twice the standard uncertainty of each order: amplitudes below them may be noise. Orders
    far above the largest five are left out. With pole pairs and slots the list states the cause of each.
    Orders that the plan judges have a line at their limit.

    Args:
        analysis: name of the analysis that found the orders.
    """
    found: Orders = panel.result(analysis)
    spectrum = found.spectrum
    largest = [int(order) for order in spectrum.largest[:_LISTED]]
    last = min(len(spectrum.order), max(_FEWEST_SHOWN, math.ceil(_SHOWN_BEYOND * max(largest))))
    order, amplitude, standard = spectrum.order[:last], spectrum.amplitude[:last], spectrum.standard[:last]
    summary = (
        f"mean {raw(spectrum.mean, 4)} {spectrum.unit}, {raw(spectrum.revolutions, 4)} mechanical revolutions"
    )
    figure = new_figure(4.4, title, summary)
    axes, below = figure.subplots(2, 1, height_ratios=(4.0, 1.0))
    axes.bar(order, 2.0 * standard, width=1.0, color=LIGHT, label="twice the standard uncertainty")
    axes.vlines(order, 0.0, amplitude, color=BLUE, linewidth=1.4)
    axes.plot(order, amplitude, linestyle="", marker="o", markersize=2.4, color=BLUE, label="peak amplitude")
    chosen = np.array(largest) - 1
    mark: dict[str, Any] = {"linestyle": "", "color": ORANGE, "capsize": 3, "linewidth": 1.0}
    axes.errorbar(order[chosen], amplitude[chosen], standard[chosen], label="standard uncertainty", **mark)
    limits = _limits(panel, found)
    if limits:
        at, level = zip(*limits.items(), strict=True)
        axes.hlines(
            level, np.array(at) - 0.5, np.array(at) + 0.5, label="limit", **LIMIT | {"linestyle": "-"}
        )
    axes.set_xlim(0.0, last + 1.0)
    highest = float(np.max(amplitude + np.nan_to_num(standard)))  # of few revolutions none is known
    axes.set_ylim(0.0, 1.12 * max(highest, *limits.values(), 0.0))
    _number(axes, spectrum, largest)
    meanings = (order_meaning(each, found.pole_pairs, found.slots) for each in largest)
    listed = [_listed(spectrum, each, meaning) for each, meaning in zip(largest, meanings, strict=True)]
    below.set_axis_off()
    listed.append("± is U (95 %), of what the samples tell")
    below.text(0.0, 1.0, "\n".join(listed), verticalalignment="top", fontsize=_FONT_PT)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    amplitude_of = with_unit(f"{channel_label(spectrum.signal, '')}, peak", spectrum.unit)
    dress(axes, "order $k$ (per mechanical revolution)", amplitude_of)
    add_legend(axes)
    return figure


def _limits(panel: Panel, found: Orders) -> dict[int, float]:
    """Return the greatest amplitude allowed, by order: of those that are named by their number or by what the
    machine has there, and of the largest."""
    numbers = machine_orders(found.pole_pairs, found.slots)
    largest = {"largest_amplitude": int(found.spectrum.largest[0])}
    limits: dict[int, float] = {}
    for each in found.measurements:
        _, _, key = each.name.partition("_order_")
        _, greatest = panel.limits.get(each.name, (None, None))
        order = int(key) if key.isdigit() else {**numbers, **largest}.get(key)
        if order is not None and greatest is not None:
            limits[order] = min(greatest, limits.get(order, greatest))
    return limits


def _number(axes: Axes, spectrum: OrderSpectrum, largest: Sequence[int]) -> None:
    """Numbers above the stems, but for one too near the number of a larger."""
    apart = _APART * (axes.get_xlim()[1] - axes.get_xlim()[0])
    numbered: list[int] = []
    for each in largest:
        if any(abs(each - other) < apart for other in numbered):
            continue
        numbered.append(each)
        top = float(spectrum.amplitude[each - 1] + spectrum.standard[each - 1])
        axes.annotate(
            str(each),
            (each, top),
            xytext=(0, 3),
            textcoords="offset points",
            horizontalalignment="center",
            fontsize=_FONT_PT,
        )


def _listed(spectrum: OrderSpectrum, order: int, meaning: str) -> str:
    amplitude = with_expanded(float(spectrum.amplitude[order - 1]), spectrum.uncertainty(order))
    what = f" ({meaning})" if meaning else ""
    return f"order {order}: {amplitude} {spectrum.unit}{what}"
