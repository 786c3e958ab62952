"""The operating point reached: measurements of it, each with a default limit.

Speed, torque, load and dc link are means over the rows that are measured, or, with a stimulus, over those
before it. Signals that are not captured are read from the drive just before the capture; without either a
measurement is undefined, and fails.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace as copied
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import (
    OF_MEAN_STEP,
    Basis,
    Contribution,
    MeanReading,
    Measurement,
    Sensitivities,
    Sensitivity,
    combined,
    crop_to,
    error_of_record,
    record_basis,
    slope_weights,
    speed_beside_angle,
    without_slope,
)
from benchtool.block import Block, Channel
from benchtool.drive import RemoteDrive
from benchtool.errors import AnalysisError
from benchtool.plan.limits import Limit
from benchtool.plan.model import OperatingPoint, Plan
from benchtool.profile import Motor
from benchtool.protocol import Mode

SIGNALS: Final = ("omega_m", "torque", "u_dc")
_UNITS: Final = dict(zip(SIGNALS, ("rad/s", "Nm", "V"), strict=True))
READINGS, READING_EVERY_S = 20, 5e-3
NAMES: Final = ("omega_m_reached", "torque_reached", "load_torque_reached", "u_dc_reached")

_FEWEST_ROWS = 20
_TRANSDUCER = "torque_transducer"
_TOO_SLOW = "it wanders more slowly than the record shows, or was read too few times"


@dataclass(frozen=True)
class CaseReadings:
    """Readings of a case besides its capture.

    `readings` are of the drive just before it, by signal, `u_dc_V` is the dc link of the bench that the
    profile describes, `parameter_check` is the result of `ParameterCheck.to_json`, `driven_Nm` the mean
    torque that the driven machine of an emulated bench takes at the case's speed.
    """

    readings: Mapping[str, Sequence[float]] = field(default_factory=dict)
    u_dc_V: float | None = None
    parameter_check: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    driven_Nm: float = 0.0

    @classmethod
    def of(cls, details: Mapping[str, Any]) -> CaseReadings:
        """Return the readings from the details of a manifest."""
        return cls(
            details.get("readings", {}),
            details.get("u_dc_V"),
            details.get("parameter_check", {}),
            details.get("driven_Nm", 0.0),
        )

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The readings of the drive, one block for each signal."""
        rate_Hz = 1.0 / READING_EVERY_S
        return tuple(
            Block.from_arrays(rate_Hz, {}, **{name: np.array(values, dtype=np.float64)})
            for name, values in self.readings.items()
            if len(values)
        )

    def to_json(self) -> dict[str, Any]:
        """Return the fields for the manifest."""
        readings = {name: list(values) for name, values in self.readings.items()}
        told = {"readings": readings, "u_dc_V": self.u_dc_V, "parameter_check": dict(self.parameter_check)}
        return told | ({"driven_Nm": self.driven_Nm} if self.driven_Nm else {})


@dataclass(frozen=True)
class Target:
    """Target of a quantity of the operating point, with its tolerance.

    `tolerance` is None if there is no target value.
    """

    name: str
    value: float
    unit: str
    tolerance: float | None

    @property
    def limit(self) -> Limit | None:
        """The limit that holds unless the plan sets another."""
        if self.tolerance is None:
            return None
        return Limit(min=self.value - self.tolerance, max=self.value + self.tolerance)


def targets(
    point: OperatingPoint, motor: Motor, u_dc_V: float | None, driven_Nm: float = 0.0
) -> tuple[Target, ...]:
    """Return the targets of an operating point, with a driven machine that takes a torque of its own there.

    The tolerance is the greater of a share of the setpoint and a share of the motor's rating: speed 2 % and
    0.5 %, torque 5 % and 1 %, load 10 % and 2 %, dc link 10 %. That of the rating is at most half of the
    setpoint, so that a missing load is detected; without load, friction may take 5 % of the rated torque.
    """
    return tuple(_targets(point, motor, point.u_dc_V or u_dc_V, driven_Nm))


def _targets(point: OperatingPoint, motor: Motor, u_dc_V: float | None, driven_Nm: float) -> Iterator[Target]:
    speed, rated_Nm = motor.omega_m_N_rad_s, motor.T_N_Nm
    velocity = point.mode_of_operation is Mode.VELOCITY
    omega_m = point.omega_m_rad_s if velocity else point.hold_speed_rad_s
    if omega_m is not None:
        yield Target("omega_m_reached", omega_m, "rad/s", _tolerance(omega_m, 0.02, 0.005 * speed))
    if not velocity:
        torque = point.torque_Nm
        yield Target("torque_reached", torque, "Nm", _tolerance(torque, 0.05, 0.01 * rated_Nm))
    load = point.load_torque_Nm + driven_Nm
    if velocity or load:
        least = 0.02 * rated_Nm if load else 0.05 * rated_Nm
        yield Target("load_torque_reached", load, "Nm", _tolerance(load, 0.1, least))
    if u_dc_V is None:
        yield Target("u_dc_reached", math.nan, "V", None)
    else:
        yield Target("u_dc_reached", u_dc_V, "V", 0.1 * u_dc_V)


def _tolerance(value: float, share: float, least: float) -> float:
    return max(share * abs(value), min(least, 0.5 * abs(value)) if value else least)


def default_limits(wanted: Iterable[Target]) -> dict[str, Limit]:
    """Return the limits by the names of their measurements."""
    return {each.name: each.limit for each in wanted if each.limit is not None}


def signals_to_read(plan: Plan, control_period_s: float) -> tuple[str, ...]:
    """Return the signals of the operating point that are not captured."""
    before = round(plan.record.pretrigger_s / (control_period_s * plan.record.stride))
    told = plan.stimulus is None or before >= _FEWEST_ROWS
    return tuple(name for name in SIGNALS if not (told and name in plan.record.channels))


def read(drive: RemoteDrive, names: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return the readings of these signals over a tenth of a second, as far as the drive has them."""
    known = [name for name in names if name in drive.dictionary]
    found: dict[str, list[float]] = {name: [] for name in known}
    for _ in range(READINGS if known else 0):
        for name in known:
            if math.isfinite(value := drive.number(name)):
                found[name].append(value)
        drive.wait(READING_EVERY_S)
    return {name: tuple(values) for name, values in found.items()}


def measure_reached(
    wanted: Sequence[Target],
    plan: Plan,
    point: OperatingPoint,
    motor: Motor,
    capture: Block,
    transducer: Block | None,
    seen: CaseReadings,
) -> tuple[Measurement, ...]:
    """Return the measured value of each target.

    Args:
        wanted: as `targets` returns them.
        plan: what was captured and played.
        point: the operating point of the case.
        motor: its inertia separates load from acceleration in torque mode, and its pole pairs tell the speed
            of a current's phase.
        capture: rows that are measured.
        transducer: torque on the shaft over the same time, if there is one.
        seen: readings of the drive.
    """
    signals = _Signals(_rows(plan, capture), transducer, seen, motor.pole_pairs)
    return tuple(_measured(each, point, motor, signals) for each in wanted)


def measure_held(rows: Block) -> Iterator[Measurement]:
    """Yield where the machine ran while these rows were taken, of which nothing was asked.

    Speed and dc link, as far as they were recorded; the mean torque is that of its own analysis.
    """
    for name in SIGNALS:
        if name in rows.names and name != "torque":
            mean = _mean_of(rows, name, f"{name} in the rows")
            text = f"mean of {mean.source}; nothing was asked for"
            yield _number(f"{name}_reached", rows.unit(name), text, mean)


def _rows(plan: Plan, capture: Block) -> Block | None:
    """Return rows at the operating point: all, or those before the stimulus; None if these are too few."""
    if capture.gaps:
        return None
    begin, end = 0, len(capture.data)
    if plan.stimulus is not None:
        end = round(plan.record.pretrigger_s * capture.sample_rate_Hz)
    elif plan.analyses.steady:
        begin = round(plan.analyses.steady_from_s * capture.sample_rate_Hz)
    if end - begin < _FEWEST_ROWS:
        return None
    first = capture.first_tick + begin * capture.stride
    return copied(capture, first_tick=first, data=capture.data[begin:end])


@dataclass(frozen=True)
class _Mean:
    """Mean of a signal: its `value` with the `errors` and the readings behind it, its basis, and its source
    in words; `between_records` is how much more another record differs, if that is known."""

    value: float
    errors: tuple[Contribution, ...]
    reading: MeanReading
    basis: Basis
    source: str
    unresolved: tuple[Channel, ...] = ()
    between_records: Contribution | None = None

    def less(self, slope: _Slope, J_kgm2: float) -> _Mean:
        """Return a mean torque less what the slope of the speed takes of it."""
        value = self.value - J_kgm2 * slope.value
        errors = (*self.errors, *(each.scaled(J_kgm2) for each in slope.errors))
        source = f"{self.source}, less J x slope of {slope.reading.channel}"
        return copied(self, value=value, errors=errors, source=source, unresolved=slope.reading.unresolved)


@dataclass(frozen=True)
class _Slope:
    """Slope of a signal by least squares, a second, with the errors and the readings behind it.

    Steps move it as they move the means of two halves of the record, which are half of it apart: by
    `of_steps` times what they leave in a mean.
    """

    value: float
    scatter: Contribution
    reading: MeanReading
    of_steps: float

    @classmethod
    def of(cls, name: str, samples: NDArray[np.float64], period_s: float) -> Self:
        """Return that of even samples, shape (n,), two or more."""
        count = len(samples)
        weights = slope_weights(count) / period_s
        slope = float(weights @ samples)
        left = without_slope(samples) - np.mean(samples)
        # it is a mean of samples so weighted
        scatter = error_of_record(count * weights * left).line(f"scatter of the slope of {name}")
        reading = MeanReading.of(Channel(name, _UNITS[name]), samples, 1.0 / period_s)
        return cls(slope, scatter, reading, 2.0 * math.sqrt(2.0) / (count * period_s))

    @property
    def errors(self) -> tuple[Contribution, ...]:
        """Lines of its budget."""
        steps = (copied(each, name=f"{each.name} in its slope") for each in self.reading.line(self.of_steps))
        return self.scatter, *steps

    def sensitivity(self, J_kgm2: float) -> Sensitivity:
        """Return that of the torque that is left without what accelerates an inertia."""
        steps = J_kgm2 * self.of_steps * OF_MEAN_STEP
        return Sensitivity(self.reading.channel, -J_kgm2 * self.value, resolution=steps)


@dataclass(frozen=True)
class _Signals:
    """Sources of the signals of an operating point."""

    rows: Block | None
    transducer: Block | None
    seen: CaseReadings
    pole_pairs: int

    def mean(self, name: str) -> _Mean | None:
        """Return the mean over the rows, or else of the readings; None without both."""
        if self.rows is not None and name in self.rows.names:
            return _mean_of(self.rows, name, f"{name} in the capture", self.pole_pairs)
        readings = np.array(self.seen.readings.get(name, ()), dtype=np.float64)
        if not len(readings):
            return None
        basis = Basis(len(readings), 1.0 / READING_EVERY_S, len(readings) * READING_EVERY_S)
        spread = float(np.std(readings, ddof=1)) / math.sqrt(len(readings)) if len(readings) > 1 else math.nan
        source = f"{name} read just before the capture"
        scatter = Contribution("scatter of the readings", "A", spread, max(1.0, len(readings) - 1.0))
        reading = MeanReading.of(Channel(name, _UNITS[name]), readings, 1.0 / READING_EVERY_S)
        return _Mean(reading.mean, (scatter,), reading, basis, source)

    def on_shaft(self) -> _Mean | None:
        """Return the mean of the transducer over the rows, or else of the drive's estimate."""
        if self.transducer is not None and self.rows is not None:
            try:
                inside = crop_to(self.transducer, self.rows)
            except AnalysisError:  # it covers the stimulus, but not all rows before it
                return self.mean("torque")
            return _mean_of(inside, _TRANSDUCER, f"{_TRANSDUCER} over the same time")
        return self.mean("torque")

    def acceleration(self) -> _Slope | None:
        """Return the slope of the speed over the rows, or else over the readings."""
        if self.rows is not None and "omega_m" in self.rows.names:
            omega_m, period_s = self.rows.column("omega_m"), 1.0 / self.rows.sample_rate_Hz
        else:
            omega_m, period_s = np.array(self.seen.readings.get("omega_m", ())), READING_EVERY_S
        if len(omega_m) < 2:
            return None
        return _Slope.of("omega_m", omega_m, period_s)


def _mean_of(block: Block, name: str, source: str, pole_pairs: int = 1) -> _Mean:
    samples, beside = block.column(name), None
    scatter = error_of_record(samples).line("scatter over parts of the record")
    if name == "omega_m":
        theta_m, i_a = (
            np.ascontiguousarray(block.column(each)) if each in block.names else None
            for each in ("theta_m", "i_a")
        )
        beside = speed_beside_angle(
            np.ascontiguousarray(samples), block.sample_rate_Hz, theta_m, i_a, pole_pairs
        )
    reading = MeanReading.of(Channel(name, block.unit(name)), samples, block.sample_rate_Hz)
    if beside is None:
        return _Mean(reading.mean, (scatter,), reading, record_basis(block), source)
    source = f"{source}, over time from the first row to the last, by the trapezoidal rule"
    errors, further = (beside.line,), beside.between_records
    return _Mean(beside.value, errors, reading, record_basis(block), source, between_records=further)


def _measured(each: Target, point: OperatingPoint, motor: Motor, signals: _Signals) -> Measurement:
    text = (
        f"asked for: {each.value:g} {each.unit}" if each.tolerance is not None else "nothing says where to be"
    )
    mean: _Mean | None = None
    by_slope: tuple[Sensitivity, ...] = ()
    match each.name:
        case "load_torque_reached" if point.mode_of_operation is Mode.TORQUE:
            torque, slope = signals.mean("torque"), signals.acceleration()
            if torque is not None and slope is not None:
                mean, by_slope = torque.less(slope, motor.J_kgm2), (slope.sensitivity(motor.J_kgm2),)
        case "load_torque_reached":
            mean = signals.on_shaft()
        case name:
            mean = signals.mean(name.removesuffix("_reached"))
    if mean is None:
        return Measurement.undefined(
            each.name, each.unit, f"mean; {text}", "neither the capture nor the drive provides it"
        )
    return _number(each.name, each.unit, f"mean of {mean.source}; {text}", mean, *by_slope)


def _number(name: str, unit: str, definition: str, mean: _Mean, *besides: Sensitivity) -> Measurement:
    lines = (*mean.errors, *mean.reading.line())
    uncertain = combined(lines, ", ".join(each.name for each in lines))
    of_mean = Sensitivities.of_mean(mean.reading.channel, mean.reading.mean)
    each = Measurement(
        name,
        mean.value,
        unit,
        definition,
        mean.basis,
        uncertain,
        uncertainty_reason=_TOO_SLOW if uncertain is None else "",
        repeatability=mean.between_records,
        sensitivities=Sensitivities((*(of_mean.channels or ()), *besides)),
    )
    return each.without_resolution_of(*mean.reading.unresolved, *mean.unresolved)
