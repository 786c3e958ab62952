"""Families of few revolutions at uneven times, with orders along the angle alone, in coloured noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import of_orders
from benchmarks.coverage.noise import coloured
from benchtool.analysis.orders.angle import angle_coverage
from benchtool.analysis.orders.order_spectrum import fitted_orders
from benchtool.analysis.orders.orders import describe_orders

MEAN_NM = 1.8


@dataclass(frozen=True)
class FewTurns:
    """A torque with orders 1, 6 and 15 over few revolutions, and noise behind a low-pass with a pole."""

    revolutions: float = 2.1
    pole: float = 0.0
    noise_Nm: float = 0.02
    rows_per_turn: float = 600.0
    uneven: float = 0.6  # of the way from row to row
    highest: int = 0  # order of 0.01 Nm


def _trial(what: FewTurns, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.revolutions * what.rows_per_turn)
    turned = np.cumsum(random.uniform(1.0 - what.uneven, 1.0 + what.uneven, count))
    turned *= 2 * np.pi * what.revolutions / turned[-1]
    angle = turned + random.uniform(0, 2 * np.pi)
    orders = {1: 0.05, 6: 0.1, 15: 0.02} | ({what.highest: 0.01} if what.highest else {})
    torque = MEAN_NM + what.noise_Nm * coloured(random.standard_normal(count), what.pole)
    for order, amplitude in orders.items():
        torque += amplitude * np.cos(order * angle + order)
    spectrum = fitted_orders(angle_coverage(angle), torque, "torque", "Nm")
    found = describe_orders(spectrum, "torque", orders=sorted(orders)).measurements
    yield from selected(found, of_orders(orders, 1, int(spectrum.order[-1])))


FEW_TURNS: Mapping[str, FewTurns] = {
    "turns_two_uneven": FewTurns(),
    "turns_two_high_order": FewTurns(rows_per_turn=250.5, uneven=0.0, highest=125),
    "turns_two_uneven_coloured": FewTurns(pole=0.97),
    "turns_six_few_rows": FewTurns(revolutions=6.3, rows_per_turn=58.7, uneven=0.0),
    "turns_twelve_few_rows": FewTurns(revolutions=12.2, pole=0.9, rows_per_turn=58.7, uneven=0.0),
    "turns_three_uneven_coloured": FewTurns(revolutions=3.3, pole=0.9),
}
FAMILIES = families_of(_trial, FEW_TURNS)
