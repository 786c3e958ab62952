"""Families of tables some of whose rows repeat the one before, as of a reader that finds nothing new."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import HIGHEST_ORDER, of_harmonics, of_orders, of_ripple
from benchtool.analysis import Measurement
from benchtool.block import Channel
from benchtool.tables import TableQuestion
from benchtool.tables.analyses import results
from benchtool.tables.record import Record
from benchtool.tables.time_base import time_base

_ROWS, _RATE_HZ, _POLE_PAIRS = 6_000, 10_000.0, 3
_SLOWEST_HZ, _FASTEST_HZ = 30.0, 300.0
_AMPLITUDE_A, _FIFTH, _NEGATIVE = 5.0, 0.05, 0.02
_UNITS = {"current": "A", "current_b": "A", "current_c": "A", "torque": "Nm", "angle": "rad"}


@dataclass(frozen=True)
class Table:
    """Three unbalanced currents and a torque with orders 6 p and 1; a `share` of the rows is stale.

    `drift` is that of the speed, relative; `bits` those of the converters, 0 for none.
    """

    share: float
    noise: float = 2e-3
    bits: int = 0
    drift: float = 0.0
    has_angle: bool = False
    is_speed_stated: bool = False


def trial(what: Table, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one record, by what `analyze --csv` makes of its rows."""
    time_s = np.arange(_ROWS) / _RATE_HZ
    frequency_Hz = math.exp(random.uniform(math.log(_SLOWEST_HZ), math.log(_FASTEST_HZ)))
    theta_e = 2 * np.pi * frequency_Hz * time_s + random.uniform(0, 2 * np.pi)
    theta_e += np.pi * frequency_Hz * what.drift * (time_s**2 * _RATE_HZ / _ROWS - time_s)
    of_fifth, of_sixth = random.uniform(0, 2 * np.pi, 2)
    columns: dict[str, np.ndarray] = {}
    for phase, name in enumerate(("current", "current_b", "current_c")):
        apart = 2 * np.pi * phase / 3
        current = np.cos(theta_e - apart) + _NEGATIVE * np.cos(theta_e + apart)
        columns[name] = _AMPLITUDE_A * (current + _FIFTH * np.cos(5 * (theta_e - apart) + of_fifth))
    columns["torque"] = 2.0 + 0.1 * np.cos(6 * theta_e + of_sixth) + 0.05 * np.cos(theta_e / _POLE_PAIRS)
    for name, values in columns.items():
        size = _AMPLITUDE_A if name != "torque" else 1.0
        noisy = values + what.noise * size * random.standard_normal(_ROWS)
        step = 4.0 * size / 2**what.bits if what.bits else 0.0
        columns[name] = np.round(noisy / step) * step if step else noisy
    if what.has_angle:
        columns["angle"] = np.mod(theta_e / _POLE_PAIRS, 2 * np.pi)
    stale = random.random(_ROWS) < what.share
    read = np.maximum.accumulate(np.where(stale, 0, np.arange(_ROWS)))
    data = np.column_stack([time_s, *(values[read] for values in columns.values())])
    omega_m = 2 * np.pi * frequency_Hz / _POLE_PAIRS if what.is_speed_stated else None
    question = TableQuestion(
        Path(), "t", {name: name for name in columns}, pole_pairs=_POLE_PAIRS, omega_m_rad_s=omega_m
    )
    channels = {name: Channel(f"{name} read", _UNITS[name]) for name in columns}
    record = Record(data, time_base(data[:, 0], data[:, 1:]), channels, question).unbroken
    harmonics = {1: _AMPLITUDE_A * (1.0 + _NEGATIVE), 5: _AMPLITUDE_A * _FIFTH}
    of_current = {order * _POLE_PAIRS: size for order, size in harmonics.items()}
    mean_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi * time_s[-1])
    truths = {
        "fundamental_frequency": mean_Hz,
        **of_harmonics(harmonics),
        **of_orders(of_current, _POLE_PAIRS, HIGHEST_ORDER, "current"),
        "current_sequence_positive": _AMPLITUDE_A,
        "current_sequence_negative": _AMPLITUDE_A * _NEGATIVE,
        "current_sequence_zero": 0.0,
        "current_unbalance_percent": 100.0 * _NEGATIVE,
        "current_unbalance_zero_percent": 0.0,
        "current_noise_floor": OF_THE_ENSEMBLE,
        "current_noise_density": OF_THE_ENSEMBLE,
        **of_ripple(2.0, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE, OF_THE_ENSEMBLE),
        "torque_line_frequency": 6.0 * mean_Hz,
        "torque_line_amplitude": 0.1,
        **of_orders({1: 0.05, 6 * _POLE_PAIRS: 0.1}, _POLE_PAIRS, HIGHEST_ORDER),
    }
    yield from selected((each for each in results(record) if isinstance(each, Measurement)), truths)


_TABLE = Table(0.08)
FAMILIES = families_of(
    trial,
    {
        "stale_rows_none": replace(_TABLE, share=0.0),
        "stale_rows_3": replace(_TABLE, share=0.03),
        "stale_rows_8": _TABLE,
        "stale_rows_18": replace(_TABLE, share=0.18),
        "stale_rows_angle": replace(_TABLE, has_angle=True),
        "stale_rows_stated_speed": replace(_TABLE, is_speed_stated=True),
        "stale_rows_bits_12": replace(_TABLE, bits=12),
        "stale_rows_drift": replace(_TABLE, drift=0.03, has_angle=True),
        "stale_rows_noisy": replace(_TABLE, noise=0.03),
    },
)
