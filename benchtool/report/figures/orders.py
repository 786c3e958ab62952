"""Figure of orders: what a signal repeats per mechanical revolution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from benchtool.analysis.orders.order_spectrum import OrderSpectrum
from benchtool.analysis.orders.orders import order_meaning
from benchtool.report.figures.style import BLUE, LIGHT, ORANGE, add_legend, dress, new_figure

_LISTED = 5
_SHOWN_BEYOND = 1.25  # of the highest order listed
_FEWEST_SHOWN = 12
_FONT_PT = 8
_APART = 0.02  # of the axis, between numbers above stems


def draw_orders(
    spectrum: OrderSpectrum, title: str, *, pole_pairs: int | None = None, slots: int | None = None
) -> Figure:
    """Stems of peak amplitude over order; the largest five are numbered, and listed below.

    Grey steps are twice the standard uncertainty of each order: what does not stand out of them may be noise.
    Orders far above the largest five are left out. With pole pairs and slots the list says what each is.
    """
    largest = [int(order) for order in spectrum.largest[:_LISTED]]
    last = min(len(spectrum.order), max(_FEWEST_SHOWN, math.ceil(_SHOWN_BEYOND * max(largest))))
    order, amplitude, standard = spectrum.order[:last], spectrum.amplitude[:last], spectrum.standard[:last]
    summary = f"mean {spectrum.mean:.4g} {spectrum.unit}, {spectrum.revolutions:.4g} mechanical revolutions"
    figure = new_figure(4.4, title, summary)
    axes, below = figure.subplots(2, 1, height_ratios=(4.0, 1.0))
    axes.bar(order, 2.0 * standard, width=1.0, color=LIGHT, label="twice the standard uncertainty")
    axes.vlines(order, 0.0, amplitude, color=BLUE, linewidth=1.4)
    axes.plot(order, amplitude, linestyle="", marker="o", markersize=2.4, color=BLUE, label="peak amplitude")
    chosen = np.array(largest) - 1
    mark: dict[str, Any] = {"linestyle": "", "color": ORANGE, "capsize": 3, "linewidth": 1.0}
    axes.errorbar(order[chosen], amplitude[chosen], standard[chosen], label="standard uncertainty", **mark)
    axes.set_xlim(0.0, last + 1.0)
    axes.set_ylim(0.0, 1.12 * float(np.max(amplitude + standard)))
    _number(axes, spectrum, largest)
    listed = [_listed(spectrum, each, order_meaning(each, pole_pairs, slots)) for each in largest]
    below.set_axis_off()
    below.text(0.0, 1.0, "\n".join(listed), verticalalignment="top", fontsize=_FONT_PT)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    dress(axes, "order (per mechanical revolution)", f"{spectrum.signal}, peak ({spectrum.unit})")
    add_legend(axes)
    return figure


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
    amplitude, standard = float(spectrum.amplitude[order - 1]), float(spectrum.standard[order - 1])
    what = f" ({meaning})" if meaning else ""
    return f"order {order}: {amplitude:.3g} ± {standard:.2g} {spectrum.unit}{what}"
