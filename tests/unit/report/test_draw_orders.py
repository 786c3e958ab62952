"""The figure of orders."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchtool.analysis.declaration import Findings, Panel
from benchtool.analysis.measurement import Basis
from benchtool.analysis.orders.order_spectrum import OrderSpectrum
from benchtool.analysis.orders.orders import describe_orders
from benchtool.block import Block, Channel
from benchtool.report.figures.drawings import draw_of_case


def spectrum(count: int = 200) -> OrderSpectrum:
    order = np.arange(1, count + 1)
    amplitude = 0.001 / order
    amplitude[[5, 11, 12, 71]] = 0.03, 0.02, 0.019, 0.2
    return OrderSpectrum(
        *("torque", "Nm", order, amplitude, np.full(count, 5e-4), 0.65, 7.25),
        *("a fit", "scatter", Basis(), np.full(count, 9.0), np.full(count, 5e-3)),
        others=np.zeros(count),
        lost=np.zeros(count),
        beside=np.zeros(count),
    )


def panel(
    found: OrderSpectrum, pole_pairs: int | None = None, slots: int | None = None, **limits: float
) -> Panel:
    orders = describe_orders(found, "torque", pole_pairs, slots)
    findings = {"torque_orders": Findings(orders.measurements, orders.tables, orders)}
    block = Block((Channel("torque", "Nm"), Channel("theta_m", "rad")), 0, 1, 1e-4, np.zeros((9, 2)))
    bounds = {name: (None, greatest) for name, greatest in limits.items()}
    return Panel("case", block, findings=findings, limits=bounds)


def draw(shown: Panel) -> Figure:
    return draw_of_case(shown, "orders")["torque_orders"]


def test_stems_stand_at_their_orders_and_the_largest_are_listed() -> None:
    figure = draw(panel(spectrum(), 12, 18))

    axes, below = figure.axes
    assert axes.get_xlabel() == "order $k$ (per mechanical revolution)"
    assert axes.get_ylabel() == "torque $T$, peak (Nm)"
    stems = np.asarray(axes.lines[0].get_xydata())
    assert len(stems) == 90  # a quarter beyond the highest of the largest
    assert stems[71] == pytest.approx((72, 0.2))
    listed = below.texts[0].get_text().splitlines()
    # 2.26 times the experimental standard uncertainty, of 9 degrees of freedom; it was u, to other digits
    assert listed[0].startswith("order 72: 0.2000 ± 0.0010 Nm (6p, phase harmonics 5 and 7; cogging")
    assert [line.split(":")[0] for line in listed[1:4]] == ["order 6", "order 12", "order 13"]
    assert listed[-1] == "± is U (95 %), of what the samples tell"


def test_numbers_above_stems_do_not_cover_each_other() -> None:
    axes = draw(panel(spectrum())).axes[0]
    assert [text.get_text() for text in axes.texts] == ["72", "6", "12", "1"]  # 13 is beside the larger 12


def test_few_orders_are_drawn_too() -> None:
    few = spectrum(72)
    short = OrderSpectrum(
        *(few.signal, few.unit, few.order[:3], few.amplitude[:3], few.standard[:3], 0.0, 2.0),
        *(few.method, few.uncertainty_source, few.basis, few.dof[:3], few.stands_out_above[:3]),
        others=few.others[:3],
        lost=few.lost[:3],
        beside=few.beside[:3],
    )
    assert len(np.asarray(draw(panel(short)).axes[0].lines[0].get_xydata())) == 3


def test_an_order_that_is_judged_has_its_limit_at_its_place() -> None:
    axes = draw(panel(spectrum(), torque_order_72=0.25)).axes[0]
    (limit,) = (each for each in axes.collections if each.get_label() == "limit")
    assert np.asarray(limit.get_paths()[0].vertices) == pytest.approx(np.array([[71.5, 0.25], [72.5, 0.25]]))


def test_an_order_of_the_machine_has_its_limit_where_that_is() -> None:
    shown = panel(spectrum(), 12, 18, torque_order_6p=0.3, torque_order_largest_amplitude=0.25)
    (limit,) = (each for each in draw(shown).axes[0].collections if each.get_label() == "limit")
    assert np.asarray(limit.get_paths()[0].vertices)[:, 1] == pytest.approx([0.25, 0.25])  # 72 is both


def test_too_few_revolutions_have_no_figure() -> None:
    block = Block((Channel("torque", "Nm"), Channel("theta_m", "rad")), 0, 1, 1e-4, np.zeros((9, 2)))
    assert draw_of_case(Panel("case", block, findings={"torque_orders": Findings(())}), "orders") == {}
