"""Signals as faulty sensors, wrong channels and windows cut anywhere make them.

They are constant, in steps, spiky, drifting, held, of other magnitudes, of few rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block

Floats = NDArray[np.float64]

ROWS = (2, 3, 5, 8, 16, 33, 100, 257, 1000, 3000)
_MAGNITUDES = (1e-12, 1e-6, 1e6, 1e12)
_UNITS = {
    "i_a": "A",
    "i_b": "A",
    "i_c": "A",
    "torque": "Nm",
    "torque_reference": "Nm",
    "psi_s": "Wb",
    "psi_alpha": "Wb",
    "psi_beta": "Wb",
    "u_alpha": "V",
    "u_beta": "V",
    "u_dc": "V",
    "omega_m": "rad/s",
    "switching_count": "",
}
_KINDS: tuple[Callable[[np.random.Generator, Floats, Floats], Floats], ...] = (
    lambda random, place, sine: sine,
    lambda random, place, sine: sine + 0.01 * random.standard_normal(len(sine)),
    lambda random, place, sine: np.round(sine * random.choice([1, 2, 3, 7, 100])),
    lambda random, place, sine: np.sign(sine),
    lambda random, place, sine: random.standard_normal(len(sine)),
    lambda random, place, sine: random.standard_t(1.5, len(sine)),
    lambda random, place, sine: np.cumsum(random.standard_normal(len(sine))),
    lambda random, place, sine: np.full(len(sine), random.choice([0.0, 1.0, -3.3])),
    lambda random, place, sine: np.where(np.arange(len(sine)) == random.integers(len(sine)), 1.0, 0.0),
    lambda random, place, sine: np.where(place > random.uniform(), 1.0, 0.0),
    lambda random, place, sine: sine * place,
    lambda random, place, sine: sine * np.exp(-place * random.choice([1, 5, 50])),
    lambda random, place, sine: np.clip(sine, -0.3, 0.5),
    lambda random, place, sine: sine[np.arange(len(sine)) // 7 * 7],
    lambda random, place, sine: np.mod(np.arange(len(sine), dtype=np.float64), random.integers(1, 9)),
    lambda random, place, sine: place,
    lambda random, place, sine: np.cos(2.0 * math.pi * random.choice([3, 40]) * place**2),
    lambda random, place, sine: sine + 10.0 * (random.random(len(sine)) < 1e-3),
    lambda random, place, sine: np.where(random.random(len(sine)) < 0.5, 0.0, 1.0),
    lambda random, place, sine: np.exp(5.0 * random.standard_normal(len(sine))),
    lambda random, place, sine: 1.0 - np.exp(-20.0 * np.maximum(place - 0.3, 0.0)) + 0.02 * sine,
    lambda random, place, sine: np.round(random.choice([0.3, 1, 2]) * random.standard_normal(len(sine))),
)


def odd_signal(random: np.random.Generator, rows: int) -> Floats:
    """Return one signal of so many rows."""
    place = np.linspace(0.0, 1.0, rows)
    cycles = random.choice([1, 2.5, 3, 7, 20, 60]) * random.choice([1, 1.003])
    sine = np.cos(2.0 * math.pi * cycles * place + random.uniform(0, 6))
    signal = np.asarray(_KINDS[random.integers(len(_KINDS))](random, place, sine), dtype=np.float64)
    if random.random() < 0.2:
        signal = signal + random.choice([0.1, 3, 100])
    if random.random() < 0.15:
        signal = signal * random.choice(_MAGNITUDES)
    if random.random() < 0.15:
        other = odd_signal(random, rows)
        signal = signal + 0.3 * other if random.random() < 0.5 else np.where(place < 0.5, signal, other)
    if random.random() < 0.1:
        step = random.choice([0.01, 0.1, 0.5])
        signal = np.round(signal / step) * step
    return signal


def odd_block(seed: int) -> Block:
    """Return a block with the channels of a drive, of which currents and flux mostly turn with the angle."""
    random = np.random.default_rng([2026, seed])
    rows, rate_Hz = int(random.choice(ROWS)), float(random.choice([1.0, 100.0, 1e4, 1e6]))
    columns = {name: odd_signal(random, rows) for name in _UNITS}
    theta_m = _odd_angle(random, rows)
    if random.random() < 0.7:
        for number, name in enumerate(("i_a", "i_b", "i_c")):
            turning = np.cos(theta_m * random.choice([1, 4]) - number * 2.0 * math.pi / 3.0)
            columns[name] = turning + random.choice([0.0, 0.1]) * columns[name]
        columns["psi_alpha"] = np.cos(theta_m) + 0.01 * columns["psi_alpha"]
        columns["psi_beta"] = np.sin(theta_m) + 0.01 * columns["psi_beta"]
    if random.random() < 0.7:
        begin = random.choice([0.02, 0.2, 0.5, 0.97])
        columns["torque_reference"] = np.where(np.arange(rows) > begin * rows, 1.0, 0.0)
    if random.random() < 0.5:
        answer = np.convolve(columns["torque_reference"], [0.1, 0.5, 0.2])[:rows]
        columns["torque"] = answer + 0.01 * columns["torque"]
    columns["theta_m"] = theta_m
    if random.random() < 0.05:
        columns[random.choice(list(columns))][random.integers(rows)] = random.choice([math.nan, math.inf])
    return Block.from_arrays(rate_Hz, {**_UNITS, "theta_m": "rad"}, **columns)


def _odd_angle(random: np.random.Generator, rows: int) -> Floats:
    theta_m = 2.0 * math.pi * random.choice([0.3, 1, 2.2, 8, 40, 100]) * np.linspace(0.0, 1.0, rows)
    if random.random() < 0.3:
        theta_m = theta_m * random.choice([0.0, -1.0])
    if random.random() < 0.2:
        step_rad = 2.0 * math.pi / random.choice([16, 200])
        theta_m = np.floor(theta_m / step_rad) * step_rad
    if random.random() < 0.1:
        theta_m = odd_signal(random, rows)
    if random.random() < 0.5:
        theta_m = np.mod(theta_m, 2.0 * math.pi)
    return np.asarray(theta_m, dtype=np.float64)
