"""A shaft whose speed ripples by its angle, read by the counts of an encoder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RATE_HZ = 8_000.0


@dataclass(frozen=True)
class Shaft:
    """A shaft that turns by `turns` at so many rad/s, by `drift` of it faster at the end than at first, with
    a `ripple` of (order, rad/s) of random phases, and an encoder of so many counts in a turn."""

    turns: float = 12.3
    speed_rad_s: float = 42.0
    drift: float = 0.0
    ripple: tuple[tuple[int, float], ...] = ((1, 0.08), (24, 0.05))
    counts: int = 16_384

    @property
    def count_rad(self) -> float:
        return 2.0 * np.pi / self.counts

    def angle_rad(self, random: np.random.Generator) -> Floats:
        """Return the angle at the rows, shape (n,), by the time at which each of many angles is passed."""
        fine = 2.0 * np.pi * np.arange(-0.2, self.turns + 0.3, 1e-4)
        passed_s = fine / self.speed_rad_s
        for order, size in self.ripple:
            wave = np.sin(order * fine + random.uniform(0.0, 2.0 * np.pi))
            passed_s -= size / (order * self.speed_rad_s**2) * wave
        even_s = np.arange(round(2.0 * np.pi * self.turns / self.speed_rad_s * RATE_HZ)) / RATE_HZ
        faster_s = even_s + 0.5 * self.drift * even_s * (even_s / even_s[-1] - 1.0)
        return np.asarray(np.interp(faster_s, passed_s, fine)) + 30.0 * self.count_rad * random.uniform()

    def read_rad(self, angle_rad: Floats) -> Floats:
        """Return what the encoder gives at angles, shape (n,)."""
        return np.asarray(np.floor(angle_rad / self.count_rad) * self.count_rad)


def difference(angle_rad: Floats, rows: int) -> Floats:
    """Return the speed by how far an angle, shape (n,), has come over rows, shape (n - rows,)."""
    return np.asarray((angle_rad[rows:] - angle_rad[:-rows]) * (RATE_HZ / rows))
