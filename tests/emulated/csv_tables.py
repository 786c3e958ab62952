"""Text tables in the formats of other tools, with known contents."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TURN = 2 * np.pi


def write(name: str, head: str, columns: list[Array], delimiter: str = ",", digits: int = 7) -> None:
    row = delimiter.join([f"%.{digits}f"] * len(columns))
    rows = (row % values for values in zip(*(each.tolist() for each in columns), strict=True))
    Path(name).write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


def gimbal(name: str = "gimbal.txt", *, order: int = 72) -> None:
    """A q-current that holds a small motor against its cogging, at stamps that jitter, angle in counts."""
    random = np.random.default_rng(1)
    steps = np.round(1e-3 + 4e-4 * random.standard_t(2, size=12_000).clip(-2, 5), 4)
    time_s = np.cumsum(steps)
    angle = 5.2 * time_s + 0.05 * np.sin(6 * 5.2 * time_s) - 6.3
    current = 0.1 + 0.2 * np.cos(order * angle) + 0.04 * np.sin(18 * angle) + 0.015 * np.cos(12 * angle)
    current += 0.03 * random.normal(size=len(angle))
    counts = np.round(angle / TURN * 20_000) * TURN / 20_000
    write(
        name,
        "Time, Position, Velocity, Iq, Active",
        [time_s, counts, 0 * time_s, current, 0 * time_s + 1],
        ", ",
        5,
    )


def phase_current(rate_Hz: float = 10_000.0, samples: int = 4_000) -> tuple[Array, Array]:
    time_s = np.arange(samples) / rate_Hz
    angle = TURN * 50.0 * time_s
    return time_s, 3.0 * np.cos(angle) + 0.15 * np.cos(5 * angle + 1.0) + 0.02


def sinusoid(frequency_Hz: Array | float, amplitude: Array | float = 5.0) -> tuple[Array, Array, Array]:
    """Time, current and the mechanical angle of four pole pairs, 1 s at 10 kHz."""
    time_s = np.arange(10_000) / 10_000
    theta_e = TURN * np.cumsum(np.broadcast_to(frequency_Hz, 10_000)) / 10_000
    return time_s, amplitude * np.cos(theta_e), theta_e / 4
