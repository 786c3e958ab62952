"""The figure of orders."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.measurement import Basis
from benchtool.analysis.orders.order_spectrum import OrderSpectrum
from benchtool.report.figures.orders import draw_orders


def spectrum(count: int = 200) -> OrderSpectrum:
    order = np.arange(1, count + 1)
    amplitude = 0.001 / order
    amplitude[[5, 11, 12, 71]] = 0.03, 0.02, 0.019, 0.2
    return OrderSpectrum(
        *("T", "Nm", order, amplitude, np.full(count, 5e-4), 0.65, 7.25),
        *("a fit", "scatter", Basis(), np.full(count, 9.0)),
    )


def test_stems_stand_at_their_orders_and_the_largest_are_listed() -> None:
    figure = draw_orders(spectrum(), "orders", pole_pairs=12, slots=18)

    axes, below = figure.axes
    assert axes.get_xlabel() == "order (per mechanical revolution)"
    assert axes.get_ylabel() == "T, peak (Nm)"
    stems = np.asarray(axes.lines[0].get_xydata())
    assert len(stems) == 90  # a quarter beyond the highest of the largest
    assert stems[71] == pytest.approx((72, 0.2))
    listed = below.texts[0].get_text().splitlines()
    assert listed[0].startswith("order 72: 0.2 ± 0.0005 Nm (6p, phase harmonics 5 and 7; cogging")
    assert [line.split(":")[0] for line in listed[1:4]] == ["order 6", "order 12", "order 13"]


def test_numbers_above_stems_do_not_cover_each_other() -> None:
    axes = draw_orders(spectrum(), "orders").axes[0]
    assert [text.get_text() for text in axes.texts] == ["72", "6", "12", "1"]  # 13 is beside the larger 12


def test_few_orders_are_drawn_too() -> None:
    few = spectrum(72)
    short = OrderSpectrum(
        *(few.signal, few.unit, few.order[:3], few.amplitude[:3], few.standard[:3], 0.0, 2.0),
        *(few.method, few.uncertainty_source, few.basis, few.dof[:3]),
    )
    assert len(np.asarray(draw_orders(short, "orders").axes[0].lines[0].get_xydata())) == 3
