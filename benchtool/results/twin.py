"""A recorded run beside its twin: the machine simulated again with what is believed and with what is found.

    for twin in twins(Path("runs/2026-11-22-identify")):
        print(twin.wrong, twin.residuals)

The parameters come from the flux balance and the balance of torque of the run itself; those believed are what
the drive held when it ran, and the profile's where that was not recorded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import (
    Findings,
    Instruments,
    Measurement,
    Perturbed,
    Window,
    measurements_to_json,
)
from benchtool.analysis.balances import (
    FLUX_BALANCE,
    MOTION_BALANCE,
    Deviation,
    Electrical,
    FluxBalance,
    FluxBalanceSettings,
    MotionBalance,
    MotionBalanceSettings,
    contradictions,
    deviations,
    shared_cause,
    simulated_currents,
    simulated_speed,
)
from benchtool.block import Block
from benchtool.errors import AnalysisError, RecordingError
from benchtool.profile import Bench, Motor
from benchtool.recording import Bundle
from benchtool.results.calibration import Calibration
from benchtool.results.recordings import BESIDE, motor_of
from benchtool.results.runs import recorded_bundles
from benchtool.results.windows import longest_unbroken

Floats = NDArray[np.float64]

_HELD: Final[Mapping[str, str]] = {
    "R_s": "R_s_ohm",
    "L_d": "L_d_H",
    "L_q": "L_q_H",
    "psi_r": "psi_r_Wb",
    "J": "J_kgm2",
}
"""Key of a parameter in the manifest and in `[motor]`, by its name."""


@dataclass(frozen=True)
class Signal:
    """A measured signal, and the twin's of it, shape (n,): with the parameters believed, and estimated.

    A simulation that diverges is nan from there on, and its residual has no rms.
    """

    name: str
    unit: str
    measured: Floats
    believed: Floats
    estimated: Floats

    def residual(self, twin: Floats) -> Floats:
        """Return the twin's less the measured signal."""
        return twin - self.measured

    @property
    def believed_rms(self) -> float:
        """Rms of the residual with the parameters believed."""
        return _rms(self.residual(self.believed))

    @property
    def estimated_rms(self) -> float:
        """Rms of the residual with the parameters estimated."""
        return _rms(self.residual(self.estimated))

    @property
    def reason(self) -> str:
        """Why a residual has no rms; empty where both have one."""
        of = (("believed", self.believed_rms), ("estimated", self.estimated_rms))
        which = " and ".join(name for name, rms in of if math.isnan(rms))
        if not which:
            return ""
        return (
            f"with the parameters as {which} the simulation diverges, as no machine does: see which of them "
            f"are not told, and what to capture"
        )

    def to_json(self) -> dict[str, Any]:
        """Return the residuals."""
        document = {
            "unit": self.unit,
            "measured_rms": _rms(self.measured),
            "residual_rms_believed": _or_null(self.believed_rms),
            "residual_rms_estimated": _or_null(self.estimated_rms),
        }
        return document | ({"reason": self.reason} if self.reason else {})


@dataclass(frozen=True)
class Twin:
    """One capture beside its twin.

    Attributes:
        case: the case's name, or that of the stream of a recording.
        bundle: where it is recorded.
        time_s: of the signals, since the first row of the capture, shape (n,).
        signals: i_d and i_q, and omega_m where the balance of torque tells the inertia.
        deviations: each estimate beside its belief.
        motion: why there is no balance of torque; empty if there is one.
    """

    case: str
    bundle: Path
    time_s: Floats
    signals: tuple[Signal, ...]
    deviations: tuple[Deviation, ...]
    motion: str = ""

    @property
    def wrong(self) -> tuple[Deviation, ...]:
        """What contradicts its belief, the plainest first."""
        return contradictions(self.deviations)

    @property
    def shared_cause(self) -> str:
        """What explains several contradictions at once; empty if nothing known does."""
        return shared_cause(self.wrong)

    def to_json(self) -> dict[str, Any]:
        """As `benchtool twin --json` has a case."""
        document: dict[str, Any] = {
            "bundle": str(self.bundle),
            "wrong": [each.name for each in self.wrong],
            "shared_cause": self.shared_cause or None,
            "parameters": {each.name: _parameter(each) for each in self.deviations},
            "residuals": {each.name: each.to_json() for each in self.signals},
        }
        return document | ({"motion": self.motion} if self.motion else {})


def twins(folder: Path, *, stream: str = "", delay_ticks: int = 1) -> Iterator[Twin]:
    """Yield each capture of a run, or a stream of a recording, beside its twin.

    Args:
        folder: a run bundle, or the folder of a run of several cases.
        stream: its name; without it `capture`, else the only stream there is.
        delay_ticks: from a row to the period over which the voltage in it acts.

    Raises:
        RecordingError: there is no bundle, or it cannot be read.
        AnalysisError: a channel is missing, or the capture does not tell any parameter.
    """
    for bundle in recorded_bundles(folder):
        bundle.require_intact()
        block = bundle.block(_stream_of(bundle, stream))
        case = str(bundle.manifest.details.get("case", "") or bundle.directory.resolve().name)
        bench = Calibration.of(bundle.manifest).bench
        yield twin_of(block, _believed_motor(bundle), case, bundle.directory, delay_ticks, bench)


def twin_of(
    block: Block, motor: Motor, case: str, bundle: Path, delay_ticks: int = 1, bench: Bench | None = None
) -> Twin:
    """Return a capture beside its twin; of one with gaps, its longest stretch without.

    What is stated of the sensors on its `bench` is in the uncertainties of the estimates.

    Raises:
        AnalysisError: a channel is missing, or the capture does not tell any parameter.
    """
    if missing := [name for name in FLUX_BALANCE.channels if name not in block.names]:
        raise AnalysisError(
            f"{bundle} has no {', '.join(missing)}, which a twin needs besides "
            f"{', '.join(name for name in FLUX_BALANCE.channels if name in block.names) or 'others'}: record "
            f"{', '.join(FLUX_BALANCE.channels)} with every tick"
        )
    unbroken = longest_unbroken(block)
    window = Window.of(unbroken, motor)
    found = FLUX_BALANCE.measure(window, FluxBalanceSettings(delay_ticks=delay_ticks))
    flux: FluxBalance = found.result
    moved, refusal = _of_motion(window, delay_ticks)
    signals = [*_currents(flux)]
    if moved.result is not None and moved.result.solution.told("J"):
        signals.append(_speed(moved.result, motor))
    believed = {name: float(getattr(motor, key)) for name, key in _HELD.items()}

    def again(altered: Perturbed) -> Iterator[Measurement]:
        """Yield the estimates with a perturbed channel; none where it does not allow them."""
        with suppress(AnalysisError):
            yield from _estimates(Window.of(altered.of(unbroken), motor), delay_ticks)

    instruments = Instruments(bench or Bench(), [unbroken])
    measurements = instruments.applied((*found.measurements, *moved.measurements), again)
    beside = deviations(measurements, believed, motor, float(np.mean(flux.ticks.u_dc)))
    time_s = flux.ticks.T_s * (delay_ticks + np.arange(len(signals[0].measured), dtype=np.float64))
    return Twin(case, bundle, time_s, tuple(signals), beside, refusal)


def _estimates(window: Window, delay_ticks: int) -> Iterator[Measurement]:
    """Yield what both balances of a window estimate."""
    yield from FLUX_BALANCE.measure(window, FluxBalanceSettings(delay_ticks=delay_ticks)).measurements
    moved, _ = _of_motion(window, delay_ticks)
    yield from moved.measurements


def _of_motion(window: Window, delay_ticks: int) -> tuple[Findings, str]:
    """Return what the balance of torque finds, or nothing and why."""
    try:
        return MOTION_BALANCE.measure(window, MotionBalanceSettings(delay_ticks=delay_ticks)), ""
    except AnalysisError as refused:
        return Findings(()), str(refused)


def _currents(flux: FluxBalance) -> Iterator[Signal]:
    measured = flux.ticks.measured_dq
    believed, estimated = (simulated_currents(flux.ticks, p) for p in (flux.belief, flux.estimate))
    yield Signal("i_d", "A", measured.real, believed.real, estimated.real)
    yield Signal("i_q", "A", measured.imag, believed.imag, estimated.imag)


def _speed(motion: MotionBalance, motor: Motor) -> Signal:
    """Return the speed that the torque makes, from the first measured one on."""
    T_s, measured = motion.flux.ticks.T_s, motion.omega_m_rad_s

    def simulated(p: Electrical, J: float, friction: float, coulomb: float, load: float) -> Floats:
        torque = motion.flux.torque(p, motor.pole_pairs)
        return simulated_speed(torque, measured, T_s, J, friction, coulomb, load)

    believed = simulated(motion.flux.belief, motor.J_kgm2, 0.0, 0.0, 0.0)
    found = (motion.solution.value(name) for name in motion.solution.names)
    return Signal("omega_m", "rad/s", measured, believed, simulated(motion.flux.estimate, *found))


def _believed_motor(bundle: Bundle) -> Motor:
    """Return the motor with the parameters that the drive held."""
    motor, held = motor_of(bundle), bundle.manifest.parameters
    changed = {
        key: float(value)
        for key in _HELD.values()
        if isinstance(value := held.get(key), float | int) and (value > 0.0 or key == "R_s_ohm")
    }
    return motor.model_copy(update=changed)


def _stream_of(bundle: Bundle, stream: str) -> str:
    if stream:
        return stream
    streams = [name for name in bundle.streams if name not in BESIDE]
    if "capture" in streams:
        return "capture"
    if len(streams) != 1:
        known = ", ".join(streams) or "none"
        raise RecordingError(f"{bundle.directory} has the streams {known}: choose one with --stream")
    return streams[0]


def _parameter(each: Deviation) -> dict[str, Any]:
    (entry,) = measurements_to_json([each.estimate]).values()
    return entry | {
        "believed": each.believed,
        "difference": each.difference if each.told else None,
        "difference_percent": each.percent if each.told and math.isfinite(each.percent) else None,
        "threshold": each.threshold,
        "contradicts": each.contradicts,
    }


def _or_null(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))
