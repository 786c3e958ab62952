"""Families of a converter whose steps are about as coarse as what is measured, with noise that hides them or
not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import signal

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import of_orders, of_ripple
from benchmarks.coverage.noise import coloured, converted
from benchmarks.coverage.true_response import sampled, true_numbers_of_response
from benchtool.analysis import analyze_response, order_analysis, torque_ripple, track_angle
from benchtool.block import Block

RATE_HZ, STEP_NM = 2_000.0, 0.05


@dataclass(frozen=True)
class Coarse:
    """A torque along an angle, in steps of 0.05 Nm: orders (order, steps), each 30 % larger or smaller from
    record to record, noise of as many steps, and a speed, each from the first to the second number. Lines
    (cycles in a revolution, steps) are 10 % faster or slower, in step with nothing. Where revolutions are
    not known, electrical periods alone are."""

    orders: tuple[tuple[int, float], ...] = ((6, 0.6),)
    noise: tuple[float, float] = (0.02, 0.02)
    kind: Literal["normal", "rectangular", "coloured"] = "normal"
    absent: int = 4
    revolutions: float = 60.3
    speed_Hz: tuple[float, float] = (7.5, 7.5)
    lines: tuple[tuple[float, float], ...] = ()
    pole_pairs: int = 2
    are_revolutions_known: bool = True


def _coarse(what: Coarse, random: np.random.Generator) -> Iterator[Compared]:
    least, most = what.speed_Hz
    speed_Hz = least if most == least else random.uniform(least, most)
    count = round(what.revolutions / speed_Hz * RATE_HZ)
    theta_m = 2 * np.pi * speed_Hz / RATE_HZ * np.arange(count, dtype=np.float64) + random.uniform(
        0, 2 * np.pi
    )
    mean = random.uniform(0.9, 1.1)
    torque, noise = np.full(count, mean), STEP_NM * random.uniform(*what.noise)
    truths = {f"torque_order_{what.absent}": 0.0}
    for order, steps in what.orders:
        amplitude = STEP_NM * steps * random.uniform(0.7, 1.3)
        torque += amplitude * np.cos(order * theta_m + random.uniform(0, 2 * np.pi))
        truths[f"torque_order_{order}"] = amplitude
    square = 0.5 * sum(amplitude**2 for amplitude in truths.values()) + noise**2
    for cycles, steps in what.lines:
        amplitude = STEP_NM * steps * random.uniform(0.7, 1.3)
        torque += amplitude * np.cos(
            cycles * random.uniform(0.9, 1.1) * theta_m + random.uniform(0, 2 * np.pi)
        )
        square += 0.5 * amplitude**2
    if what.kind == "rectangular":
        torque += noise * random.uniform(-math.sqrt(3.0), math.sqrt(3.0), count)
    else:
        torque += noise * coloured(random.standard_normal(count), 0.9 if what.kind == "coloured" else 0.0)
    read = converted(torque, STEP_NM, random)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=read, theta_m=np.mod(theta_m, 2 * np.pi))
    track = track_angle(np.asarray(theta_m), what.pole_pairs)
    found = order_analysis(block, "torque", orders=[what.absent, *(order for order, _ in what.orders)])
    sizes = [(order, truths[f"torque_order_{order}"]) for order, _ in what.orders]
    named = of_orders(dict(sizes), what.pole_pairs, int(found.spectrum.order[-1]))
    yield from selected(found.measurements, named | truths)
    truths = of_ripple(mean, math.sqrt(square))
    pole_pairs = what.pole_pairs if what.are_revolutions_known else 1
    yield from selected(torque_ripple(block, track=track, pole_pairs=pole_pairs), truths)


@dataclass(frozen=True)
class CoarseOutput:
    """A first-order lag behind random bits of 1, each held for some rows; noise of its output in steps, which
    lie from 0.01 to 0.1 apart."""

    rows: tuple[int, int] = (2, 9)
    noise: float = 0.03


def _output(what: CoarseOutput, random: np.random.Generator) -> Iterator[Compared]:
    rate_Hz, count, step = 4_000.0, 16_000, random.uniform(0.01, 0.1)
    corner_Hz, held = random.uniform(40.0, 130.0), random.integers(*what.rows)
    x = np.repeat(random.choice([-1.0, 1.0], count // held + 1), held)[:count]
    left = math.exp(-2 * np.pi * corner_Hz / rate_Hz)
    above, below = np.array([0.0, 1.0 - left]), np.array([1.0, -left])
    y = np.asarray(signal.lfilter(above, below, x))
    y = step * np.round((y + what.noise * step * random.standard_normal(count)) / step)
    block = Block.from_arrays(rate_Hz, {"x": "Nm", "y": "Nm"}, x=x, y=y)
    found = analyze_response(block, "x", "y").measurements
    response = sampled(above, below, rate_Hz)
    yield from selected(found, true_numbers_of_response(response, 0.5 * rate_Hz, found))


TORQUE: Mapping[str, Coarse] = {
    "coarse_order": Coarse(),
    "coarse_order_larger": Coarse(orders=((6, 1.7),), noise=(0.02, 0.3)),
    "coarse_order_dithered": Coarse(orders=((6, 0.3),), noise=(0.4, 1.0)),
    "coarse_order_half_dithered": Coarse(orders=((6, 0.6),), noise=(0.1, 0.4)),
    "coarse_two_orders": Coarse(orders=((6, 0.8), (1, 0.3)), noise=(0.02, 0.3), absent=2),
    "coarse_weak_order": Coarse(orders=((12, 1.2), (2, 0.08)), noise=(0.05, 0.4)),
    "coarse_rectangular": Coarse(noise=(0.1, 0.5), kind="rectangular"),
    "coarse_coloured": Coarse(noise=(0.1, 0.5), kind="coloured"),
    "coarse_three_orders": Coarse(((12, 0.6), (24, 0.3), (3, 0.25)), (0.01, 0.3), speed_Hz=(5.0, 15.0)),
    "coarse_three_orders_silent": Coarse(((12, 0.6), (24, 0.3), (3, 0.25)), (0.0, 0.0), speed_Hz=(5.0, 15.0)),
    "coarse_slow_line": Coarse(((6, 0.4),), (0.02, 0.3), lines=((0.1, 3.5),)),
    "coarse_slow_line_of_a_step": Coarse(((6, 1.0),), (0.02, 0.3), lines=((0.1, 1.0),)),
    "coarse_slow_line_silent": Coarse(((6, 0.4),), (0.0, 0.0), lines=((0.1, 3.5),)),
    "coarse_line": Coarse(((6, 0.4),), (0.02, 0.3), lines=((7.4, 2.0),)),
    "coarse_two_lines_silent": Coarse((), (0.0, 0.0), lines=((0.23, 1.4), (7.4, 2.0))),
    "coarse_order_of_no_period": Coarse(((6, 3.0),), (0.02, 0.3), pole_pairs=4, are_revolutions_known=False),
    "coarse_order_of_no_period_silent": Coarse(
        ((6, 1.0),), (0.0, 0.0), speed_Hz=(5.0, 15.0), pole_pairs=4, are_revolutions_known=False
    ),
    "coarse_few_turns": Coarse(orders=((6, 0.9),), noise=(0.05, 0.3), revolutions=8.4),
}
OUTPUTS: Mapping[str, CoarseOutput] = {
    "coarse_output_bits": CoarseOutput(),
    "coarse_output_slow_bits": CoarseOutput(rows=(30, 60)),
}

FAMILIES = (*families_of(_coarse, TORQUE), *families_of(_output, OUTPUTS))
