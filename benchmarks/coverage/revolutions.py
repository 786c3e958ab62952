"""Families slower than an electrical period: revolutions, belts, load cycles, drifts, held angles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.channels import RADIUS_WB
from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import of_orders, of_ripple
from benchmarks.coverage.noise import coloured
from benchtool.analysis import (
    flux_trajectory,
    order_analysis,
    spectral_lines,
    torque_ripple,
    track_angle,
)
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ, TORQUE_NM, RIPPLE_NM = 8_000.0, 1.8, 0.06

_NOISE = 2e-4  # of a flux, relative to its radius


@dataclass(frozen=True)
class Shaft:
    """A torque along a mechanical angle: ripple of order 6 p, orders (order, Nm), lines (Hz, Nm), and noise.

    The angle is held for `held` rows, give or take `uneven`, and counts in `counts` of a turn; the speed
    swings by a share of it at some Hz.
    """

    revolutions: float = 12.3
    pole_pairs: int = 3
    speed_Hz: float = 6.7
    orders: tuple[tuple[float, float], ...] = ((1.0, 0.03),)
    lines: tuple[tuple[float, float], ...] = ()
    noise_Nm: float = 4e-3
    red: float = 0.0  # Nm at the end of a random walk
    drift_Nm: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    held: int = 1
    uneven: int = 0
    counts: int = 0


def _torque(what: Shaft, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.revolutions / what.speed_Hz * RATE_HZ)
    time_s, size = np.arange(count) / RATE_HZ, what.swing[0]
    theta_m = 2 * np.pi * what.speed_Hz * time_s + random.uniform(0, 2 * np.pi)
    swung = 2 * np.pi * what.swing[1] * time_s + random.uniform(0, 2 * np.pi)
    theta_m += size * what.speed_Hz / what.swing[1] * np.sin(swung)
    highest = 6 * what.pole_pairs
    parts = ((float(highest), RIPPLE_NM), *what.orders)
    torque = TORQUE_NM + what.noise_Nm * random.standard_normal(count)
    # one machine under one load: its shape is the same in all records
    for number, (order, amplitude) in enumerate(parts):
        torque += amplitude * np.cos(order * theta_m + 1.3 * number)
    begun_s = random.uniform(0, 10.0)
    for number, (frequency_Hz, amplitude) in enumerate(what.lines):
        torque += amplitude * np.cos(2 * np.pi * frequency_Hz * (time_s + begun_s) + 0.7 * number)
    torque += what.drift_Nm * (time_s / time_s[-1] - 0.5)
    if what.red:
        torque += what.red * np.cumsum(random.standard_normal(count)) / math.sqrt(count)
    truths = {f"torque_order_{highest}": RIPPLE_NM}
    if not what.red:
        square = sum(amplitude**2 for _, amplitude in (*parts, *what.lines))
        square = 0.5 * square + what.noise_Nm**2 + what.drift_Nm**2 / 12.0
        truths |= of_ripple(TORQUE_NM, math.sqrt(square), OF_THE_ENSEMBLE, OF_THE_ENSEMBLE)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque, theta_m=_read(what, theta_m, random))
    track = track_angle(theta_m, what.pole_pairs)
    yield from selected(torque_ripple(block, track=track, pole_pairs=what.pole_pairs), truths)
    found = order_analysis(block, "torque", orders=[highest])
    whole = {int(order): size for order, size in parts if order == int(order)}
    truths |= of_orders(whole, what.pole_pairs, int(found.spectrum.order[-1]))
    yield from selected(found.measurements, truths)


def _read(what: Shaft, theta_m: Floats, random: np.random.Generator) -> Floats:
    """Return the angle as a bus and an encoder give it, rad, wrapped."""
    steps = what.held + random.integers(-what.uneven, what.uneven + 1, len(theta_m))
    updates = np.concatenate([[0], np.cumsum(steps)])
    rows = updates[np.searchsorted(updates, np.arange(len(theta_m)), side="right") - 1]
    angle = theta_m[rows]
    if what.counts:
        angle = np.floor(angle * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts)
    return np.asarray(np.mod(angle, 2 * np.pi))


@dataclass(frozen=True)
class Tone:
    """A torque of one tone whose phase swings by `beta` at `modulation_Hz`, or of red noise alone."""

    beta: float = 0.0
    modulation_Hz: float = 3.0
    walk_Nm: float = 0.0
    duration_s: float = 1.5


def _tone(what: Tone, random: np.random.Generator) -> Iterator[Compared]:
    from scipy.special import j0

    time_s = np.arange(round(what.duration_s * RATE_HZ)) / RATE_HZ
    torque = TORQUE_NM + 2e-3 * random.standard_normal(len(time_s))
    if what.walk_Nm:
        torque += what.walk_Nm * np.cumsum(random.standard_normal(len(time_s))) / math.sqrt(len(time_s))
        truths = {"torque_line_frequency": 0.0, "torque_line_amplitude": 0.0}
    else:
        frequency_Hz = 187.3 + random.uniform(-0.3, 0.3)
        phase = 2 * np.pi * frequency_Hz * time_s + random.uniform(0, 2 * np.pi)
        swung = 2 * np.pi * what.modulation_Hz * time_s + random.uniform(0, 2 * np.pi)
        torque += RIPPLE_NM * np.cos(phase + what.beta * np.sin(swung))
        carrier = RIPPLE_NM * abs(float(j0(what.beta)))
        truths = {"torque_line_frequency": frequency_Hz, "torque_line_amplitude": carrier}
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    yield from selected(spectral_lines(block, "torque").measurements, truths)


@dataclass(frozen=True)
class Path:
    """A flux of orders 1, -5 and 7 about a centre: its speed swings (share, Hz), its radius drifts."""

    revolutions: float = 50.3
    swing: tuple[float, float] = (0.0, 1.0)
    drift: float = 0.0
    memory: float = 0.0  # of a radius that breathes by one per cent from revolution to revolution


def _path(what: Path, random: np.random.Generator) -> Iterator[Compared]:
    speed_Hz, centre, fifth, seventh = 25.0, 0.01, 0.03, 0.015
    count = round(what.revolutions / speed_Hz * RATE_HZ)
    time_s = np.arange(count) / RATE_HZ
    share, swing_Hz = what.swing
    angle = 2 * np.pi * speed_Hz * time_s + random.uniform(0, 2 * np.pi)
    swung = 2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi)
    angle += share * speed_Hz / swing_Hz * np.sin(swung)
    radius = 1.0 + what.drift * (time_s / time_s[-1] - 0.5)
    if what.memory:
        revolution = ((angle - angle[0]) / (2 * np.pi)).astype(np.int64)
        breath = coloured(random.standard_normal(int(revolution.max()) + 1), what.memory)
        radius += 0.01 * breath[revolution]
    hexagon = fifth * np.exp(-5j * angle + 0.4j) + seventh * np.exp(7j * angle + 0.4j)
    psi = RADIUS_WB * (radius * (np.exp(1j * angle) + hexagon) + centre * np.exp(2.0j))
    psi += _NOISE * RADIUS_WB * (random.standard_normal(count) + 1j * random.standard_normal(count))
    around = 2 * np.pi * np.arange(720) / 720
    hexagon = fifth * np.exp(-5j * around + 0.4j) + seventh * np.exp(7j * around + 0.4j)
    size = np.abs(np.exp(1j * around) + hexagon + centre * np.exp(2.0j))
    breathes = 0.01 if what.memory else 0.0
    square = float(np.var(size)) + (breathes * np.mean(size)) ** 2 + what.drift**2 / 12.0 + _NOISE**2
    truths = {
        "flux_radius_mean": RADIUS_WB * float(np.mean(size)),
        "flux_radius_rms": RADIUS_WB * math.sqrt(square),
        "flux_radius_pp": OF_THE_ENSEMBLE,
        "flux_centre_offset": RADIUS_WB * centre,
        "flux_radius_order_6": RADIUS_WB * abs(fifth * np.exp(-0.4j) + seventh * np.exp(0.4j)),
    }
    units = {"psi_alpha": "Wb", "psi_beta": "Wb"}
    block = Block.from_arrays(RATE_HZ, units, psi_alpha=psi.real, psi_beta=psi.imag)
    yield from selected(flux_trajectory(block), truths)


_SHAFT = Shaft()
TORQUE: Mapping[str, Shaft] = {
    "revolution_part": replace(_SHAFT, revolutions=3.6, orders=((1.0, 0.04), (2.0, 0.02))),
    "revolution_many_poles": replace(_SHAFT, revolutions=5.4, pole_pairs=8, speed_Hz=2.9),
    "revolution_belt": replace(_SHAFT, orders=((0.41, 0.05), (1.0, 0.02)), revolutions=16.8),
    "load_cycle_torque": replace(_SHAFT, lines=((2.7, 0.05), (8.1, 0.012)), revolutions=21.4),
    "load_cycles_that_beat": replace(_SHAFT, lines=((2.7, 0.05), (2.77, 0.03)), revolutions=16.8),
    "torque_drift_revolution": replace(_SHAFT, drift_Nm=0.1, revolutions=14.2),
    "held_angle": replace(_SHAFT, held=9),
    "held_angle_uneven": replace(_SHAFT, held=11, uneven=4, noise_Nm=8e-3),
    "held_angle_counts": replace(_SHAFT, held=6, counts=2048),
    "held_angle_swing": replace(_SHAFT, held=8, swing=(0.01, 1.3)),
}  # fmt: skip
TONES: Mapping[str, Tone] = {
    "tone_swings": Tone(beta=1.1, modulation_Hz=2.9),
    "tone_swings_slightly": Tone(beta=0.4, modulation_Hz=4.1),
    "tone_none_in_red": Tone(walk_Nm=0.3),
}
PATHS: Mapping[str, Path] = {
    "path_swing": Path(swing=(0.012, 2.3)),
    "path_drift": Path(drift=0.08),
    "path_long_memory": Path(memory=0.92, revolutions=70.2),
}

FAMILIES = (
    *families_of(_torque, TORQUE),
    *families_of(_tone, TONES),
    *families_of(_path, PATHS),
)
