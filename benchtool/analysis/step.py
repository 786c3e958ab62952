"""Response of a signal to a step of its reference, or to a pulse as a torque limit makes of a speed step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Measurement, MeasurementJson, measurements_to_json
from benchtool.analysis.validity import require_signal, require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError

_LOW, _HIGH = 0.1, 0.9
_ARRIVED = 0.02  # of the step: the band that counts as having arrived and settled
_TAIL = 0.1  # of the window: where the final value is read


@dataclass(frozen=True)
class StepResponse:
    """Result of `analyze_step`; times are since the step of the reference, values in the signal's unit."""

    measurements: tuple[Measurement, ...]
    step_row: int

    def to_json(self) -> dict[str, MeasurementJson]:
        return measurements_to_json(self.measurements)


@dataclass(frozen=True)
class _Levels:
    """Where a step goes: `sign` is its direction, the others are values times that sign."""

    sign: float
    before: float
    greatest: float
    final: float


def analyze_step(block: Block, signal: str, reference: str) -> StepResponse:
    """Rise, overshoot, undershoot and settling of channel `signal` after the first step of `reference`.

    The step is where the reference first leaves its first value by half of its greatest excursion. A
    reference that falls back after a while (a pulse) is allowed: overshoot is measured against its greatest
    value, undershoot and settling against its final one, the mean of its last tenth.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, or no step.
    """
    require_unbroken(block)
    y, r = block.column(signal), block.column(reference)
    require_signal(y, signal)
    row = _step_row(r, reference)
    levels = _levels(r)
    unit, period_s = block.unit(signal), 1.0 / block.sample_rate_Hz
    window = (
        f"{signal} against {reference}, {len(y) - row} samples at {block.sample_rate_Hz:.6g} Hz from the step"
    )
    after = levels.sign * y[row:]
    return StepResponse(tuple(_measurements(after, levels, unit, period_s, window)), row)


def _step_row(reference: NDArray[np.float64], name: str) -> int:
    excursion = np.abs(reference - reference[0])
    greatest = float(np.max(excursion))
    if not greatest > 0.0:
        raise AnalysisError(
            f"'{name}' holds {reference[0]:g} over {len(reference)} samples, a step is needed: "
            f"record across it"
        )
    return int(np.argmax(excursion >= 0.5 * greatest))


def _levels(reference: NDArray[np.float64]) -> _Levels:
    sign = 1.0 if np.max(reference) - reference[0] >= reference[0] - np.min(reference) else -1.0
    tail = reference[-max(1, round(_TAIL * len(reference))) :]
    return _Levels(
        sign, sign * float(reference[0]), float(np.max(sign * reference)), sign * float(np.mean(tail))
    )


def _measurements(
    y: NDArray[np.float64], levels: _Levels, unit: str, period_s: float, window: str
) -> Iterator[Measurement]:
    height = levels.greatest - levels.before
    low, high = (_crossing(y, levels.before + share * height, period_s) for share in (_LOW, _HIGH))
    band = _ARRIVED * height
    arrived = _crossing(y, levels.greatest - band, period_s)
    name, text = "rise_time", f"from {_LOW:.0%} to {_HIGH:.0%} of the step, {window}"
    yield _time(name, text, None if low is None or high is None else high - low, "it is not reached")
    name, text = "reach_time", f"from the step to {1 - _ARRIVED:.0%} of it, {window}"
    yield _time(name, text, arrived, "it is not reached")

    beyond = max(0.0, float(np.max(y)) - levels.greatest)
    yield Measurement("overshoot", beyond, unit, f"greatest value beyond the greatest reference, {window}")
    name, text = "undershoot", f"greatest value short of the final reference after 98% was reached, {window}"
    if arrived is None:
        yield Measurement.undefined(name, unit, text, "98% of the step is not reached")
    else:
        rest = y[math.ceil(arrived / period_s - 1e-9) :]
        yield Measurement(name, max(0.0, levels.final - float(np.min(rest))), unit, text)

    outside = np.flatnonzero(np.abs(y - levels.final) > band)
    text = (
        f"from the step until it stays within {_ARRIVED:.0%} of the step about the final reference, {window}"
    )
    settled = None if len(outside) and outside[-1] == len(y) - 1 else float(len(outside) and outside[-1] + 1)
    yield _time("settling_time", text, None if settled is None else settled * period_s, "it does not settle")


def _crossing(y: NDArray[np.float64], level: float, period_s: float) -> float | None:
    """Time at which rising samples first reach a level, linear between them; None if they never do."""
    at = int(np.argmax(y >= level))
    if y[at] < level:
        return None
    if at == 0:
        return 0.0
    share = (level - y[at - 1]) / (y[at] - y[at - 1])
    return float((at - 1 + share) * period_s)


def _time(name: str, definition: str, value_s: float | None, reason: str) -> Measurement:
    if value_s is None:
        return Measurement.undefined(name, "s", definition, reason)
    return Measurement(name, value_s, "s", definition)
