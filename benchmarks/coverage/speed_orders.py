"""Families of the orders of speed and of current: what a shaft repeats in every revolution, by its angle.

The speed is a function of the angle, and the angle its integral: a rotor whose speed ripples wobbles about an
even motion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import HIGHEST_ORDER, of_orders
from benchmarks.coverage.noise import Kind as OfNoise, coloured, converted, noise_of
from benchtool.analysis import order_analysis
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ, POLE_PAIRS, SLOTS = 8_000.0, 4, 9
NAMED, ASKED = {"slots": 9, "cogging": 72}, (1, 5, 24)
ORDERS = ((1, 0.08), (8, 0.03), (24, 0.05), (72, 0.03))
LINES = ((4, 5.0), (20, 0.12), (28, 0.06), (5, 0.03))


@dataclass(frozen=True)
class Shaft:
    """A speed of some mean, rad/s, with (order, rad/s) of ripple by the angle, and how both are read.

    Attributes:
        ripple: of the speed, whose phases are random.
        drift: of the mean speed over the record, relative.
        swing: of the mean speed, relative, and its frequency in Hz.
        eccentricity_rad: of the encoder's disc: its error at order 1.
        counts: of the encoder in a revolution; 0 of one that reads the angle itself.
        backwards: whether it turns backwards.
    """

    revolutions: float = 12.3
    speed_rad_s: float = 42.0
    ripple: tuple[tuple[int, float], ...] = ORDERS
    drift: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    eccentricity_rad: float = 0.0
    counts: int = 0
    backwards: bool = False


@dataclass(frozen=True)
class Speed:
    """The speed of a shaft as a drive reads it, rad/s.

    With `ticks` it is the difference of the angle over so many rows; else the speed itself, with noise, the
    steps of a converter, and a ripple that is `second_regime` times as large from the middle on.
    """

    shaft: Shaft = Shaft()
    noise: float = 0.02
    colour: float = 0.0
    kind: OfNoise = "white"
    step: float = 0.0
    ticks: int = 0
    second_regime: float = 1.0


@dataclass(frozen=True)
class Current:
    """A phase current of (order, A) by a shaft's angle, and what disturbs it, A."""

    shaft: Shaft = Shaft(ripple=((1, 0.08), (24, 0.05)))
    noise: float = 0.02
    colour: float = 0.0
    kind: OfNoise = "white"
    step: float = 0.0
    line: tuple[float, float] = (0.0, 0.0)  # order, which is no whole one, and size in A
    swing: tuple[float, float] = (0.0, 1.0)  # of the amplitude, relative, and its frequency in Hz
    memory: tuple[float, float] = (0.0, 0.0)  # of the amplitude over revolutions: relative rms, correlation
    second_regime: float = 1.0


def _motion(what: Shaft, random: np.random.Generator) -> tuple[Floats, Floats, Floats, Floats]:
    """Return time, angle, mean speed and ripple of the speed at the rows, each of shape (n,)."""
    count = round(2 * np.pi * what.revolutions / what.speed_rad_s * RATE_HZ)
    half_s = 0.5 / RATE_HZ
    halves = half_s * np.arange(2 * count + 1)
    depth, swing_Hz = what.swing
    mean = 1.0 + what.drift * (halves / halves[-1] - 0.5)
    mean += depth * np.cos(2 * np.pi * (swing_Hz * halves + random.uniform()))
    mean *= what.speed_rad_s * (-1.0 if what.backwards else 1.0)
    waves = [(order, size, random.uniform(0, 2 * np.pi)) for order, size in what.ripple]

    def ripple(theta: float) -> float:
        return sum(size * math.cos(order * theta + phase) for order, size, phase in waves)

    theta, found, base = random.uniform(0, 2 * np.pi), np.empty(count), mean.tolist()
    for row in range(count):  # the method of Runge and Kutta
        found[row] = theta
        first, middle, last = base[2 * row : 2 * row + 3]
        a = first + ripple(theta)
        b = middle + ripple(theta + half_s * a)
        c = middle + ripple(theta + half_s * b)
        d = last + ripple(theta + 2.0 * half_s * c)
        theta += half_s / 3.0 * (a + 2.0 * b + 2.0 * c + d)
    rippling = np.zeros(count)
    for order, size, phase in waves:
        rippling += size * np.cos(order * found + phase)
    return np.asarray(halves[:-1:2]), found, np.asarray(mean[:-1:2]), rippling


def _read(what: Shaft, theta: Floats, random: np.random.Generator) -> Floats:
    """Return the angle as its encoder gives it, rad, without jumps."""
    angle = theta + what.eccentricity_rad * np.sin(theta + random.uniform(0, 2 * np.pi))
    if what.counts:
        angle = np.floor(angle * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts)
    return np.asarray(angle)


def _truths(name: str, orders: Mapping[int, float]) -> dict[str, float]:
    """Return the truths of orders, zero of those that are asked for and not there, and of the largest."""
    asked = dict.fromkeys(ASKED, 0.0) if name == "speed" else {}
    others = {f"{name}_order_{key}": orders.get(order, 0.0) for key, order in NAMED.items()}
    return of_orders(asked | dict(orders), POLE_PAIRS, HIGHEST_ORDER, name) | others


def _speed(what: Speed, random: np.random.Generator) -> Iterator[Compared]:
    _, theta, mean, ripple = _motion(what.shaft, random)
    angle, count = _read(what.shaft, theta, random), len(theta)
    size = np.where(np.arange(count) < count // 2, 1.0, what.second_regime)
    omega = mean + size * ripple
    truths = {order: each * 0.5 * (1.0 + what.second_regime) for order, each in what.shaft.ripple}
    if what.ticks:
        omega = (angle[what.ticks :] - angle[: -what.ticks]) * (RATE_HZ / what.ticks)
        angle, count = angle[what.ticks :], count - what.ticks
        # the mean over so many rows is less than the crests
        per_row = what.shaft.speed_rad_s / (2 * np.pi * RATE_HZ)
        truths = {order: each * np.sinc(order * per_row * what.ticks) for order, each in truths.items()}
    omega = omega + what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    if what.step:
        omega = converted(omega, what.step, random)
    block = Block.from_arrays(
        RATE_HZ, {"theta_m": "rad", "omega_m": "rad/s"}, theta_m=np.mod(angle, 2 * np.pi), omega_m=omega
    )
    found = order_analysis(
        block, "omega_m", "speed", pole_pairs=POLE_PAIRS, slots=SLOTS, orders=ASKED
    ).measurements
    yield from selected(found, _truths("speed", truths))


def _current(what: Current, random: np.random.Generator) -> Iterator[Compared]:
    time_s, theta, *_ = _motion(what.shaft, random)
    angle, count = _read(what.shaft, theta, random), len(theta)
    size = np.where(np.arange(count) < count // 2, 1.0, what.second_regime)
    depth, swing_Hz = what.swing
    size = size * (1.0 + depth * np.cos(2 * np.pi * (swing_Hz * time_s + random.uniform())))
    rms, memory = what.memory
    if rms:
        revolution = np.abs(theta - theta[0]) / (2 * np.pi)
        each = coloured(random.standard_normal(int(revolution.max()) + 1), memory)
        size = size * (1.0 + rms * each[revolution.astype(np.int64)])
    current = np.zeros(count)
    for order, amplitude in LINES:
        current += amplitude * np.cos(order * theta + random.uniform(0, 2 * np.pi))
    current *= size
    place, amplitude = what.line
    current += amplitude * np.cos(place * what.shaft.speed_rad_s * time_s + random.uniform(0, 2 * np.pi))
    current += what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    if what.step:
        current = converted(current, what.step, random)
    block = Block.from_arrays(
        RATE_HZ, {"theta_m": "rad", "i_a": "A"}, theta_m=np.mod(angle, 2 * np.pi), i_a=current
    )
    truths = {order: each * 0.5 * (1.0 + what.second_regime) for order, each in LINES}
    found = order_analysis(block, "i_a", "current", pole_pairs=POLE_PAIRS).measurements
    yield from selected(found, _truths("current", truths))


_SPEED, _SHAFT = Speed(), Shaft()
SPEEDS: Mapping[str, Speed] = {
    "speed_order": _SPEED,
    "speed_order_coloured": replace(_SPEED, colour=0.98),
    "speed_order_pink": replace(_SPEED, kind="pink"),
    "speed_order_heavy": replace(_SPEED, kind="heavy", noise=0.05),
    "speed_order_steps": replace(_SPEED, step=0.05, noise=1e-3),
    "speed_order_coarse_steps": replace(_SPEED, step=0.3, noise=1e-3),
    "speed_order_none": replace(_SPEED, shaft=replace(_SHAFT, ripple=())),
    "speed_order_few_revolutions": replace(_SPEED, shaft=replace(_SHAFT, revolutions=3.4)),
    "speed_order_two_revolutions": replace(_SPEED, shaft=replace(_SHAFT, revolutions=2.3)),
    "speed_order_many_revolutions": replace(
        _SPEED, shaft=replace(_SHAFT, revolutions=60.4, speed_rad_s=120.0), noise=0.1
    ),
    "speed_order_drift": replace(_SPEED, shaft=replace(_SHAFT, drift=0.04)),
    "speed_order_great_drift": replace(_SPEED, shaft=replace(_SHAFT, drift=0.4)),
    "speed_order_swing": replace(_SPEED, shaft=replace(_SHAFT, swing=(3e-3, 1.3))),
    "speed_order_great_swing": replace(_SPEED, shaft=replace(_SHAFT, swing=(0.03, 2.7), revolutions=20.4)),
    "speed_order_rotor_wobbles": replace(_SPEED, shaft=replace(_SHAFT, ripple=((1, 0.6), *ORDERS[1:]))),
    "speed_order_eccentric": replace(_SPEED, shaft=replace(_SHAFT, eccentricity_rad=5e-3)),
    "speed_order_slightly_eccentric": replace(_SPEED, shaft=replace(_SHAFT, eccentricity_rad=1e-3)),
    "speed_order_counts": replace(_SPEED, shaft=replace(_SHAFT, counts=10_000)),
    "speed_order_coarse_counts": replace(_SPEED, shaft=replace(_SHAFT, counts=1024)),
    "speed_order_by_differences": replace(
        _SPEED, shaft=replace(_SHAFT, counts=16_384), ticks=8, noise=0.0
    ),
    "speed_order_by_coarse_differences": replace(
        _SPEED, shaft=replace(_SHAFT, counts=2048, revolutions=30.3), ticks=16, noise=0.0
    ),
    "speed_order_two_regimes": replace(_SPEED, second_regime=2.0),
    "speed_order_backwards": replace(_SPEED, shaft=replace(_SHAFT, backwards=True)),
}  # fmt: skip
_CURRENT = Current()
CURRENTS: Mapping[str, Current] = {
    "current_order": _CURRENT,
    "current_order_coloured": replace(_CURRENT, colour=0.98),
    "current_order_pink": replace(_CURRENT, kind="pink"),
    "current_order_steps": replace(_CURRENT, step=0.05, noise=1e-3),
    "current_order_few_revolutions": replace(_CURRENT, shaft=replace(_CURRENT.shaft, revolutions=3.4)),
    "current_order_drift": replace(_CURRENT, shaft=replace(_CURRENT.shaft, drift=0.04)),
    "current_order_great_drift": replace(_CURRENT, shaft=replace(_CURRENT.shaft, drift=0.4)),
    "current_order_swing": replace(_CURRENT, shaft=replace(_CURRENT.shaft, swing=(0.02, 1.7))),
    "current_order_counts": replace(_CURRENT, shaft=replace(_CURRENT.shaft, counts=4096)),
    "current_order_eccentric": replace(_CURRENT, shaft=replace(_CURRENT.shaft, eccentricity_rad=5e-3)),
    "current_order_line": replace(_CURRENT, line=(6.37, 0.1)),
    "current_order_amplitude_swing": replace(_CURRENT, swing=(0.02, 1.9), shaft=replace(
        _CURRENT.shaft, revolutions=24.4)),
    "current_order_amplitude_memory": replace(_CURRENT, memory=(0.01, 0.6), shaft=replace(
        _CURRENT.shaft, revolutions=40.4)),
    "current_order_two_regimes": replace(_CURRENT, second_regime=1.3),
}  # fmt: skip


FAMILIES = (*families_of(_speed, SPEEDS), *families_of(_current, CURRENTS))
