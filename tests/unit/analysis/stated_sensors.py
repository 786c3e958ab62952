"""Sensors that a bench states, and numbers that they have read."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.instruments import Instruments
from benchtool.analysis.measurement import Basis
from benchtool.block import Block
from benchtool.profile import Bench, Sensor


def sensor_of(**stated: object) -> Sensor:
    return Sensor.model_validate(stated)


def reading(
    name: str,
    value: float,
    standard: float | None = 0.0,
    unit: str = "Nm",
    frequency_Hz: float | None = None,
) -> Measurement:
    uncertain = None if standard is None else Uncertainty(standard, "scatter", 10.0)
    return Measurement(name, value, unit, "", Basis(frequency_Hz=frequency_Hz), uncertain)


def applied(bench: Bench, *measurements: Measurement, blocks: Sequence[Block] = ()) -> list[Measurement]:
    return list(Instruments(bench, blocks).applied(measurements))


def uncertainty_of(measurement: Measurement) -> Uncertainty:
    assert measurement.uncertainty is not None
    return measurement.uncertainty


def lines(**amplitudes: float) -> Block:
    """A second of lines of i_a or torque, by their frequency: `f250=0.1`."""
    time_s = np.arange(20_000) / 20e3
    parts = (a * np.cos(2.0 * math.pi * float(f[1:]) * time_s) for f, a in amplitudes.items())
    values = np.sum(list(parts), axis=0)
    return Block.from_arrays(20e3, {"i_a": "A", "torque": "Nm"}, i_a=values, torque=values)
