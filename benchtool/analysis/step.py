"""Response of a signal to a step of its reference, or to a pulse as a torque limit makes of a speed step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement, MeasurementJson, measurements_to_json
from benchtool.analysis.scatter import error_of_mean
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.validity import require_signal, require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError

_LOW, _HIGH = 0.1, 0.9
_ARRIVED = 0.02  # of the step: what counts as having arrived, and the least band of having settled
_TAIL = 0.1  # of the window: where the final value and the noise are read
_SIGMAS = 3.0  # of the noise: the least that counts as a movement
_OUTSIDE = 0.05  # probability that noise alone leaves the settling band once within the window
_AN_INSTANT = 1.0 / math.sqrt(12.0)  # of the sample period (JCGM 100:2008, 4.3.7)


@dataclass(frozen=True)
class StepResponse:
    """Result of `analyze_step`; times are since the step of the reference, values in the signal's unit."""

    measurements: tuple[Measurement, ...]
    step_row: int

    def to_json(self) -> dict[str, MeasurementJson]:
        return measurements_to_json(self.measurements)


@dataclass(frozen=True)
class _Step:
    """A step as if it went upwards: `y` and `r` are times `sign`, from its row on; levels are of `r`.

    `earlier` and `jitter` are mean and rms deviation of the signal before the step, `noise` the rms deviation
    in the window's last tenth.
    """

    y: NDArray[np.float64]
    r: NDArray[np.float64]
    sign: float
    before: float
    greatest: float
    final: float
    earlier: float
    jitter: float
    noise: float
    period_s: float
    unit: str
    basis: Basis

    @property
    def height(self) -> float:
        return self.greatest - self.before

    @property
    def band(self) -> float:
        """Half the width within which the signal counts as settled."""
        sigmas = max(_SIGMAS, NormalDist().inv_cdf(1.0 - 0.5 * _OUTSIDE / len(self.y)))
        return max(_ARRIVED * self.height, sigmas * self.noise)

    def time(
        self, name: str, definition: str, value_s: float | None, reason: str, ends: int = 1
    ) -> Measurement:
        """A time between `ends` crossings and the step, each known to within a sample period."""
        if value_s is None:
            return Measurement.undefined(name, "s", definition, reason, self.basis)
        source = "sample period / sqrt(12)" if ends == 1 else "sample period / sqrt(6), of two crossings"
        uncertainty = Uncertainty(_AN_INSTANT * math.sqrt(ends) * self.period_s, f"{source}; noise left out")
        return Measurement(name, value_s, "s", definition, self.basis, uncertainty)

    def value(self, name: str, definition: str, value: float, uncertain: Uncertainty | None) -> Measurement:
        return Measurement(name, value, self.unit, definition, self.basis, uncertain)

    @property
    def of_one_sample(self) -> Uncertainty:
        return Uncertainty(self.noise, "rms deviation of one sample in the window's last tenth")


def analyze_step(block: Block, signal: str, reference: str) -> StepResponse:
    """Delay, rise, overshoot, settling and what is left of the error after a step of `reference`.

    The step is the row where the reference first leaves its first value by half of its greatest excursion,
    so that a reference which is itself a ramp counts from its middle. A reference that falls back after a
    while (a pulse) is allowed: overshoot and plateau are measured against its greatest value, undershoot and
    settling against its final one, the mean of its last tenth.

    A signal counts as settled within 2 % of the step or, where that is less than its noise, within as many
    rms of the noise as Gaussian noise would leave once in twenty windows of that length, at least three.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, or no step.
    """
    require_unbroken(block)
    y, r = block.column(signal), block.column(reference)
    require_signal(y, signal)
    row = _step_row(r, reference)
    step = _step(y, r, row, block, signal, reference)
    return StepResponse(tuple(_measurements(step)), row)


def _step_row(reference: NDArray[np.float64], name: str) -> int:
    excursion = np.abs(reference - reference[0])
    greatest = float(np.max(excursion))
    if not greatest > 0.0:
        raise AnalysisError(
            f"'{name}' holds {reference[0]:g} over {len(reference)} samples, a step is needed: "
            f"record across it"
        )
    return int(np.argmax(excursion >= 0.5 * greatest))


def _step(
    y: NDArray[np.float64], r: NDArray[np.float64], row: int, block: Block, signal: str, reference: str
) -> _Step:
    sign = 1.0 if np.max(r) - r[0] >= r[0] - np.min(r) else -1.0
    greatest, before, rate_Hz = float(np.max(sign * r)), sign * float(r[0]), block.sample_rate_Hz
    tail, unit = max(1, round(_TAIL * len(r))), block.unit(signal)
    earlier = sign * y[: max(1, row)]
    against = (
        f"{signal} against {reference}, which goes from {sign * before:.6g} to {sign * greatest:.6g} "
        f"{unit} in row {row}, where it has come half the way"
    )
    after = len(y) - row
    return _Step(
        y=sign * y[row:],
        r=sign * r[row:],
        sign=sign,
        before=before,
        greatest=greatest,
        final=float(np.mean(sign * r[-tail:])),
        earlier=float(np.mean(earlier)),
        jitter=float(np.std(earlier)),
        noise=float(np.std(y[-tail:])),
        period_s=1.0 / rate_Hz,
        unit=unit,
        basis=Basis(after, rate_Hz, after / rate_Hz, 0.5 * rate_Hz, reference=against, gaps=0),
    )


def _measurements(step: _Step) -> Iterator[Measurement]:
    arrived = _crossing(step.y, step.greatest - _ARRIVED * step.height, step.period_s)
    outside = np.flatnonzero(np.abs(step.y - step.final) > step.band)
    settled = int(outside[-1]) + 1 if len(outside) else 0
    yield from _times(step, arrived, settled)
    yield from _excursions(step, arrived)
    yield from _plateau(step, arrived)
    yield from _tracking(step, settled)


def _times(step: _Step, arrived: float | None, settled: int) -> Iterator[Measurement]:
    width = max(_ARRIVED * step.height, _SIGMAS * step.jitter)
    left = np.flatnonzero(step.y > step.earlier + width)
    text = (
        f"from the step to the first sample beyond the mean before it by {width:.4g} {step.unit}: greater "
        f"of {_ARRIVED:.0%} of the step and {_SIGMAS:g} x rms deviation before it"
    )
    yield step.time("dead_time", text, left[0] * step.period_s if len(left) else None, "it does not move")

    low, high = (
        _crossing(step.y, step.before + share * step.height, step.period_s) for share in (_LOW, _HIGH)
    )
    text = f"from {_LOW:.0%} to {_HIGH:.0%} of the step, linear between samples"
    rise = None if low is None or high is None else high - low
    yield step.time("rise_time", text, rise, "it is not reached", ends=2)
    text = f"from the step to {1 - _ARRIVED:.0%} of it, linear between samples"
    yield step.time("reach_time", text, arrived, "it is not reached")

    least, why = _ARRIVED * step.height, f"{_ARRIVED:.0%} of the step"
    if step.band > least:
        why = f"{step.band / step.noise:.2g} x noise of the last tenth, as {why} is less"
    text = f"from the step until it stays within {step.band:.4g} {step.unit} of the final reference: {why}"
    time_s = settled * step.period_s if settled < len(step.y) else None
    yield step.time("settling_time", text, time_s, "it does not settle")

    text = "from the step to the greatest sample"
    beyond = float(np.max(step.y)) - step.greatest
    peak = int(np.argmax(step.y)) * step.period_s
    reason = f"no sample is beyond the greatest reference by {_SIGMAS:g} times the noise"
    yield step.time("peak_time", text, peak if beyond > _SIGMAS * step.noise else None, reason)


def _excursions(step: _Step, arrived: float | None) -> Iterator[Measurement]:
    beyond = max(0.0, float(np.max(step.y)) - step.greatest)
    yield step.value("overshoot", "greatest value beyond the greatest reference", beyond, step.of_one_sample)
    text = "100 x overshoot / height of the step of the reference"
    percent = 100.0 / step.height
    uncertain = Uncertainty(percent * step.noise, step.of_one_sample.source)
    yield Measurement("overshoot_percent", percent * beyond, "%", text, step.basis, uncertain)

    name, text = "undershoot", "greatest value short of the final reference after 98% was reached"
    if arrived is None:
        yield Measurement.undefined(name, step.unit, text, "98% of the step is not reached", step.basis)
    else:
        rest = step.y[_row_after(arrived, step.period_s) :]
        yield step.value(name, text, max(0.0, step.final - float(np.min(rest))), step.of_one_sample)


def _plateau(step: _Step, arrived: float | None) -> Iterator[Measurement]:
    """What the signal holds while the reference is at its greatest, once the signal is there too."""
    at_top = step.r >= step.greatest - _ARRIVED * step.height
    begin = int(np.argmax(at_top))
    leaves = np.flatnonzero(~at_top[begin:])
    end = begin + int(leaves[0]) if len(leaves) else len(at_top)
    held = slice(end, end)
    if arrived is not None:
        held = slice(max(begin, _row_after(arrived, step.period_s)), end)
    values = step.sign * step.y[held]
    spread = error_of_mean(values)
    of_mean = (
        Uncertainty(spread, "scatter over ten parts of these samples") if math.isfinite(spread) else None
    )
    for name, which, of, uncertain in (
        ("plateau_mean", "mean", np.mean, of_mean),
        ("plateau_min", "least", np.min, step.of_one_sample),
        ("plateau_max", "greatest", np.max, step.of_one_sample),
    ):
        text = (
            f"{which} value from reaching 98% of the step until the reference leaves the {_ARRIVED:.0%} "
            f"below its greatest value, {len(values)} samples"
        )
        if len(values):
            yield step.value(name, text, float(of(values)), uncertain)
        else:
            reason = "the reference leaves its greatest value before the signal reaches it"
            yield Measurement.undefined(name, step.unit, text, reason, step.basis)


def _tracking(step: _Step, settled: int) -> Iterator[Measurement]:
    error = step.sign * (step.y[settled:] - step.r[settled:])
    if len(error) < 2:
        for name in ("mean", "rms", "max"):
            text = "signal minus reference after settling"
            yield Measurement.undefined(
                f"tracking_error_{name}", step.unit, text, "it does not settle", step.basis
            )
        return
    window = f"signal minus reference, {len(error)} samples after settling"
    scatter = "scatter over ten parts of these samples"
    mean, spread = float(np.mean(error)), error_of_mean(error)
    uncertain = Uncertainty(spread, scatter) if math.isfinite(spread) else None
    yield step.value("tracking_error_mean", f"mean of {window}", mean, uncertain)

    rms = float(np.sqrt(np.mean(error**2)))
    spread = error_of_mean(error**2) / (2.0 * rms) if rms > 0.0 else 0.0
    uncertain = Uncertainty(spread, scatter) if math.isfinite(spread) else None
    yield step.value("tracking_error_rms", f"rms, with the mean, of {window}", rms, uncertain)
    greatest = float(np.max(np.abs(error)))
    yield step.value("tracking_error_max", f"greatest magnitude of {window}", greatest, step.of_one_sample)


def _row_after(time_s: float, period_s: float) -> int:
    """First row at or after a time; the small share of a period takes up rounding."""
    return math.ceil(time_s / period_s - 1e-9)


def _crossing(y: NDArray[np.float64], level: float, period_s: float) -> float | None:
    """Time at which rising samples first reach a level, linear between them; None if they never do."""
    at = int(np.argmax(y >= level))
    if y[at] < level:
        return None
    if at == 0:
        return 0.0
    share = (level - y[at - 1]) / (y[at] - y[at - 1])
    return float((at - 1 + share) * period_s)
