"""Families of step answers and frequency responses that were read by sensors of a stated bandwidth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.families import Compared, Family, families_of, selected
from benchmarks.coverage.sensors import (
    ACTUAL,
    MOTOR,
    RATE_HZ,
    Actual,
    always_one_kind,
    own_response,
    stated_sensor,
)
from benchmarks.coverage.true_response import true_numbers_of_response
from benchmarks.coverage.true_step import KnownStep
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.plan import Analyses
from benchtool.profile import Bench
from benchtool.results import Calibration
from benchtool.results.block_result import analyze_block

Floats = NDArray[np.float64]

_CORNER_HZ = 50.0
_IDEAL = math.inf, 1  # bandwidth and order of a sensor
_UNITS = {"torque": "Nm", "torque_reference": "Nm"}


@dataclass(frozen=True)
class SensedStep:
    """A step answer of second order about 50 Hz, behind a sensor of `ratio` times that."""

    ratio: float = 5.0
    actual: Actual = "lag"
    damping: float = 0.5
    noise: float = 2e-3


def _answer(time_s: Floats, corner_Hz: float, damping: float, own: tuple[float, int]) -> Floats:
    """Return the answer behind a sensor, by partial fractions; one of infinite bandwidth leaves it."""
    w = 2 * np.pi * corner_Hz
    poles = [*np.roots([1.0 / w**2, 2.0 * damping / w, 1.0])]
    bandwidth_Hz, order = own
    if math.isfinite(bandwidth_Hz):
        b = 2 * np.pi * bandwidth_Hz
        poles += [-b] if order == 1 else [*np.roots([1.0 / b**2, math.sqrt(2.0) / b, 1.0])]
    later = np.maximum(time_s, 0.0)
    y = np.ones(len(time_s), dtype=np.complex128)
    for k, p in enumerate(poles):
        rest = np.prod([1.0 - p / each for n, each in enumerate(poles) if n != k])
        y -= np.exp(p * later) / rest
    return np.where(time_s >= 0.0, y.real, 0.0)


def _step(what: SensedStep, random: np.random.Generator) -> Iterator[Compared]:
    corner_Hz, damping = _CORNER_HZ * random.uniform(0.8, 1.25), what.damping * random.uniform(0.9, 1.1)
    stated_Hz = what.ratio * corner_Hz
    own = own_response(what.actual, stated_Hz, random)
    time_s = np.arange(-400, 4000) / RATE_HZ
    reference = np.where(time_s >= 0.0, 1.0, 0.0)

    def read(by: tuple[float, int]) -> Floats:
        return _answer(time_s, corner_Hz, damping, by) + what.noise * random.standard_normal(len(time_s))

    block = Block.from_arrays(RATE_HZ, _UNITS, torque=read(own), torque_reference=reference)
    bench = Bench(channels={"torque": stated_sensor(what.actual, stated_Hz)})
    analyses = Analyses.model_validate({"steady": False, "step": True})
    try:
        found = analyze_block(block, MOTOR, analyses, calibration=Calibration(bench)).measurements
    except AnalysisError:
        return
    known = KnownStep(
        partial(_answer, corner_Hz=corner_Hz, damping=damping, own=_IDEAL),
        time_s,
        reference,
        partial(read, _IDEAL),
    )
    yield from selected(found, known.true_numbers(found))


@dataclass(frozen=True)
class SensedResponse:
    """A lag of second order about 50 Hz that a sweep of its reference excites, read by a sensor of `ratio`
    times that."""

    ratio: float = 5.0
    actual: Actual = "lag"
    damping: float = 0.6
    noise: float = 2e-3


_FINE = 8  # steps of the simulation for each row
_FROM_HZ, _TO_HZ, _SWEEP_S = 2.0, 400.0, 2.0


def _response(what: SensedResponse, random: np.random.Generator) -> Iterator[Compared]:
    corner_Hz, damping = _CORNER_HZ * random.uniform(0.8, 1.25), what.damping * random.uniform(0.8, 1.2)
    stated_Hz = what.ratio * corner_Hz
    bandwidth_Hz, order = own_response(what.actual, stated_Hz, random)
    w, b = 2 * np.pi * corner_Hz, 2 * np.pi * bandwidth_Hz
    plant = [1.0 / w**2, 2.0 * damping / w, 1.0]
    sensor = [1.0 / b, 1.0] if order == 1 else [1.0 / b**2, math.sqrt(2.0) / b, 1.0]
    fine_Hz = _FINE * RATE_HZ
    time_s = np.arange(round(_SWEEP_S * fine_Hz)) / fine_Hz
    x = signal.chirp(time_s, _FROM_HZ, time_s[-1], _TO_HZ, phi=-90.0)
    x *= signal.windows.tukey(len(x), 0.02)
    y = signal.lfilter(*signal.bilinear([1.0], np.polymul(plant, sensor), fine_Hz), x)[::_FINE]
    read = y + what.noise * random.standard_normal(len(y))
    block = Block.from_arrays(RATE_HZ, _UNITS, torque=read, torque_reference=x[::_FINE])
    bench = Bench(channels={"torque": stated_sensor(what.actual, stated_Hz)})
    analyses = Analyses.model_validate({"steady": False, "frequency_response": True})
    found = analyze_block(block, MOTOR, analyses, calibration=Calibration(bench)).measurements

    def response(frequency_Hz: Floats) -> NDArray[np.complex128]:
        return np.asarray(1.0 / np.polyval(plant, 2j * np.pi * frequency_Hz))

    yield from selected(found, true_numbers_of_response(response, 0.5 * RATE_HZ, found))


FAMILIES: tuple[Family, ...] = (
    *families_of(
        _step,
        {
            f"sensor_{actual}_step_{ratio:g}": SensedStep(ratio, actual)
            for actual in ACTUAL
            for ratio in (3.0, 10.0)
        },
        always_one_kind,
    ),
    *families_of(
        _response,
        {
            f"sensor_{actual}_response_{ratio:g}": SensedResponse(ratio, actual)
            for actual in ACTUAL
            for ratio in (3.0, 10.0)
        },
        always_one_kind,
    ),
)
