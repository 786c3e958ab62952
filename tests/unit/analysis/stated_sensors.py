"""Sensors that a bench states, and numbers that they have read."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.measurement import Basis
from benchtool.analysis.sensitivity import (
    MEASURED_AGAIN,
    NO_SENSORS,
    OF_MEAN_STEP,
    Component,
    Harmonics,
    Largest,
    Noise,
    PhaseSequence,
    Sensitivities,
    Sensitivity,
)
from benchtool.analysis.sensors.instruments import Instruments
from benchtool.block import Block
from benchtool.profile import Bench, Sensor


def _component(which: PhaseSequence, in_percent: bool) -> Callable[[float], Sensitivities]:
    phases = tuple(Sensitivity(name, 2.1) for name in ("i_a", "i_b", "i_c"))
    return lambda _: Sensitivities(phases, Component(which, 6.0, in_percent))


_SENSED: Final[Mapping[str, Callable[[float], Sensitivities]]] = {
    "torque_mean": lambda value: Sensitivities.of_mean("torque", value),
    "torque_ripple_rms": lambda value: Sensitivities.of_rms("torque", value),
    "torque_ripple_pp": lambda value: Sensitivities.of_extremes("torque", value),
    "torque_ripple_percent_of_rated": lambda value: Sensitivities.of_extremes("torque", value),
    "torque_error": lambda _: Sensitivities(
        (
            Sensitivity("torque", 1.0, 1.0, OF_MEAN_STEP),
            Sensitivity("torque_transducer", -0.9, -1.0, OF_MEAN_STEP),
        )
    ),
    **dict.fromkeys(
        ("torque_order_24", "torque_line_amplitude"), lambda value: Sensitivities.of_line("torque", value)
    ),
    "fundamental_frequency": lambda _: NO_SENSORS,
    "current_fundamental": lambda value: Sensitivities.of_line("i_a", value),
    "current_thd_f": lambda _: Sensitivities((Sensitivity("i_a"),), Harmonics(50.0, as_ratio=True)),
    "current_tdd": lambda value: Sensitivities((Sensitivity("i_a", value),), Harmonics(50.0)),
    "current_max_low_harmonic": lambda value: Sensitivities((Sensitivity("i_a", value),), Largest(50.0)),
    "current_noise_floor": lambda value: Sensitivities((Sensitivity("i_a", value),), Noise(50.0)),
    "current_sequence_positive": _component("positive", False),
    "current_sequence_negative": _component("negative", False),
    "current_unbalance_percent": _component("negative", True),
    "current_unbalance_zero_percent": _component("zero", True),
}
"""What analyses declare of measurements with these names, of a fundamental of 50 Hz."""


def sensor_of(**stated: object) -> Sensor:
    return Sensor.model_validate(stated)


def reading(
    name: str,
    value: float,
    standard: float | None = 0.0,
    unit: str = "Nm",
    frequency_Hz: float | None = None,
    rests_on: tuple[str, ...] = (),
) -> Measurement:
    uncertain = None if standard is None else Uncertainty(standard, "scatter", 10.0)
    sensed = _SENSED[name](value) if name in _SENSED else MEASURED_AGAIN
    sensed = replace(sensed, rests_on=rests_on)
    basis = Basis(frequency_Hz=frequency_Hz)
    return Measurement(name, value, unit, "", basis, uncertain, sensitivities=sensed)


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
