"""Families of a torque transducer, of the model of a machine against it, and of the ripple of a flux.

A shaft turns a machine that follows its model; its transducer has samples of its own between the rows of the
drive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.channels import MOTOR
from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import of_ripple
from benchmarks.coverage.noise import Kind as OfNoise, coloured, converted, noise_of
from benchtool.analysis import Window, analyze_steady_state, torque_residual
from benchtool.analysis.flux.ripple import FLUX_RIPPLE
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ, FREQUENCY_HZ = 10_000.0, 21.3
TORQUE_NM, RIPPLE_NM, COGGING_NM = 2.0, 0.1, 0.03
_MUCH_LESS = 0.05  # of a step


@dataclass(frozen=True)
class Signal:
    """What is beside a ripple of order 6 of the electrical angle and a cogging of order 9 of the mechanical.

    Attributes:
        line: a sinusoid of some Hz and size, in no step with the angle.
        walk: the size of a slow wander with a memory of 0.2 s, rms.
        swells: the size of the ripple from period to period: relative rms, and its correlation.
        second_regime: how many times as large the ripple is from the middle on.
    """

    noise: float = 0.02
    kind: OfNoise = "white"
    colour: float = 0.0
    step: float = 0.0
    line: tuple[float, float] = (0.0, 0.0)
    walk: float = 0.0
    swells: tuple[float, float] = (0.0, 0.0)
    second_regime: float = 1.0


@dataclass(frozen=True)
class Angle:
    """A rotor's angle: its electrical periods in the record, and how an encoder reads it."""

    periods: float = 30.3
    drift: float = 0.0
    counts: int = 0
    eccentricity_rad: float = 0.0

    def electrical(self, rate_Hz: float, random: np.random.Generator) -> Floats:
        """Return the electrical angle at the rows of a rate, rad; drawn from `random` is where it begins."""
        rows = round(self.periods / FREQUENCY_HZ * RATE_HZ) * round(rate_Hz / RATE_HZ * 10) // 10
        time = np.arange(rows) / rows
        turned = self.periods * (time + 0.5 * self.drift * (time**2 - time))
        return np.asarray(2 * np.pi * (turned + random.uniform()))

    def read(self, theta_e: Floats, random: np.random.Generator) -> Floats:
        """Return the mechanical angle as the encoder gives it, rad."""
        theta_m = theta_e / MOTOR.pole_pairs
        theta_m = theta_m + self.eccentricity_rad * np.sin(theta_m + random.uniform(0, 2 * np.pi))
        if self.counts:
            theta_m = np.floor(theta_m * self.counts / (2 * np.pi)) * (2 * np.pi / self.counts)
        return np.mod(theta_m, 2 * np.pi)


def _deviation(
    what: Signal, theta_e: Floats, rate_Hz: float, sizes: tuple[float, float], random: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return a signal about its mean, with its ripple and cogging of some sizes: as a converter gives it, and
    before."""
    count = len(theta_e)
    period = ((theta_e - theta_e[0]) / (2 * np.pi)).astype(np.int64)
    rms, memory = what.swells
    ripple = sizes[0] * (1.0 + rms * coloured(random.standard_normal(period[-1] + 1), memory)[period])
    ripple *= np.where(np.arange(count) < count // 2, 1.0, what.second_regime)
    # one machine: its shape is the same in all records, unless steps fall anywhere on it
    first, second = random.uniform(0, 2 * np.pi, 2) if what.step else (0.4, 2.1)
    found = ripple * np.cos(6 * theta_e + first)
    found += sizes[1] * np.cos(9 * theta_e / MOTOR.pole_pairs + second)
    line_Hz, size = what.line
    found += size * np.cos(2 * np.pi * (line_Hz * np.arange(count) / rate_Hz + random.uniform()))
    found += what.walk * coloured(random.standard_normal(count), math.exp(-5.0 / rate_Hz))
    found += what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    return (converted(found, what.step, random) if what.step else found), found


def _square(what: Signal, sizes: tuple[float, float]) -> float:
    """Return the mean square of such a signal."""
    ripple = 0.5 * sizes[0] ** 2 * 0.5 * (1.0 + what.second_regime**2) * (1.0 + what.swells[0] ** 2)
    return ripple + 0.5 * (sizes[1] ** 2 + what.line[1] ** 2) + what.walk**2 + what.noise**2


def _is_clean(what: Signal) -> bool:
    return what.noise <= _MUCH_LESS * what.step


@dataclass(frozen=True)
class Shaft:
    """A transducer of `times` as many samples as the capture has rows."""

    signal: Signal = Signal()
    angle: Angle = Angle()
    times: float = 5.0
    mean_Nm: float = TORQUE_NM


def _shaft(what: Shaft, random: np.random.Generator) -> Iterator[Compared]:
    rate_Hz, sizes = what.times * RATE_HZ, (RIPPLE_NM, COGGING_NM)
    begin = random.bit_generator.state
    theta_e = what.angle.electrical(RATE_HZ, random)
    random.bit_generator.state = begin  # the same motion at other times
    fine = what.angle.electrical(rate_Hz, random)
    read, before = _deviation(what.signal, fine, rate_Hz, sizes, random)
    theta_m = what.angle.read(theta_e, random)
    block = Block.from_arrays(RATE_HZ, {"theta_m": "rad"}, theta_m=theta_m)
    transducer = Block.from_arrays(
        rate_Hz, {"torque_transducer": "Nm"}, torque_transducer=what.mean_Nm + read
    )
    steady = analyze_steady_state(
        block, pole_pairs=MOTOR.pole_pairs, torque_rated_Nm=MOTOR.T_N_Nm, transducer=transducer
    )
    clean = _is_clean(what.signal)
    low, high = np.percentile(before, [0.5, 99.5])
    pp = float(np.ptp(before)) if clean else OF_THE_ENSEMBLE
    percentile = float(high - low) if clean else OF_THE_ENSEMBLE
    rms = math.sqrt(_square(what.signal, sizes))
    truths = of_ripple(what.mean_Nm, rms, pp, percentile, MOTOR.T_N_Nm, "transducer_torque")
    yield from selected(steady.measurements, truths)


@dataclass(frozen=True)
class Flux:
    """The length of a stator flux as a drive estimates it, Wb."""

    signal: Signal = Signal(noise=3e-4)
    angle: Angle = Angle()
    ripple_Wb: tuple[float, float] = (4e-3, 1e-3)


def _flux(what: Flux, random: np.random.Generator) -> Iterator[Compared]:
    theta_e = what.angle.electrical(RATE_HZ, random)
    read, before = _deviation(what.signal, theta_e, RATE_HZ, what.ripple_Wb, random)
    theta_m = what.angle.read(theta_e, random)
    units = {"theta_m": "rad", "psi_s": "Wb"}
    block = Block.from_arrays(RATE_HZ, units, theta_m=theta_m, psi_s=0.17 + read)
    found = FLUX_RIPPLE.measure(Window.of(block, MOTOR), FLUX_RIPPLE.settings()).measurements
    pp = float(np.ptp(before)) if _is_clean(what.signal) else OF_THE_ENSEMBLE
    yield from selected(found, {"flux_ripple_pp": pp})


@dataclass(frozen=True)
class Residual:
    """A machine of the model's own currents and voltages, a transducer that reads `offset_Nm` less, and an
    estimate that reads half of that less.

    `noise_A` is that of the currents, of which all modelled torques are made.
    """

    signal: Signal = Signal()
    angle: Angle = Angle()
    times: float = 5.0
    offset_Nm: float = 0.05
    noise_A: float = 0.0


def _residual(what: Residual, random: np.random.Generator) -> Iterator[Compared]:
    T_s, i_dq = 1.0 / RATE_HZ, -1.0 + 4.0j
    begin = random.bit_generator.state
    theta_e = what.angle.electrical(RATE_HZ, random)
    random.bit_generator.state = begin
    fine = what.angle.electrical(what.times * RATE_HZ, random)
    psi_dq = MOTOR.L_d_H * i_dq.real + MOTOR.psi_r_Wb + 1j * MOTOR.L_q_H * i_dq.imag
    torque_Nm = 1.5 * MOTOR.pole_pairs * (psi_dq.real * i_dq.imag - psi_dq.imag * i_dq.real)
    i_s, rotor = i_dq * np.exp(1j * theta_e), np.exp(1j * theta_e)
    # the mean voltage over the period from a row to the next moves the flux from one to the other
    u_s = psi_dq * np.diff(rotor) / T_s + MOTOR.R_s_ohm * 0.5 * (i_s[1:] + i_s[:-1])
    asked = np.append(u_s[1:], [u_s[-1], u_s[-1]])  # in the row before
    sizes = (RIPPLE_NM, COGGING_NM)
    read, _ = _deviation(what.signal, fine, what.times * RATE_HZ, sizes, random)
    own, _ = _deviation(what.signal, theta_e, RATE_HZ, sizes, random)
    phases = {
        name: np.real(i_s * np.exp(-2j * np.pi * k / 3.0)) + what.noise_A * random.standard_normal(len(i_s))
        for k, name in enumerate(("i_a", "i_b", "i_c"))
    }
    block = Block.from_arrays(
        RATE_HZ,
        {},
        **phases,
        theta_m=np.mod(theta_e / MOTOR.pole_pairs, 2 * np.pi),
        omega_m=np.gradient(theta_e) * RATE_HZ / MOTOR.pole_pairs,
        u_alpha=asked.real,
        u_beta=asked.imag,
        torque=torque_Nm - 0.5 * what.offset_Nm - own,
    )
    shaft = torque_Nm - what.offset_Nm - read
    transducer = Block.from_arrays(what.times * RATE_HZ, {"torque_transducer": "Nm"}, torque_transducer=shaft)
    truths = {
        "torque_residual_mean": 0.5 * what.offset_Nm,
        "transducer_torque_residual_mean": what.offset_Nm,
        "torque_residual_rms": OF_THE_ENSEMBLE,
        "transducer_torque_residual_rms": OF_THE_ENSEMBLE,
    }
    if not what.noise_A and not what.signal.step and what.signal.kind == "white":
        truths["torque_residual_rms"] = math.hypot(
            0.5 * what.offset_Nm, math.sqrt(_square(what.signal, sizes))
        )
        averaged = _averaged(what.signal, round(what.times))
        truths["transducer_torque_residual_rms"] = math.hypot(
            what.offset_Nm, math.sqrt(_square(averaged, sizes))
        )
    yield from selected(torque_residual(block, MOTOR, transducer), truths)


def _averaged(what: Signal, times: int) -> Signal:
    """Return the signal averaged over so many samples, but for a ripple that is slow beside them: of noise
    with this memory from sample to sample."""
    lags = np.arange(1, times)
    share = (1.0 + 2.0 * float(np.sum((1.0 - lags / times) * what.colour**lags))) / times
    return replace(what, noise=what.noise * math.sqrt(share))


_SHAFT, _NOISE, _ANGLE = Shaft(), Signal(), Angle()


SIGNALS: Mapping[str, Signal] = {
    "": _NOISE,
    "_quiet": replace(_NOISE, noise=2e-4),
    "_loud": replace(_NOISE, noise=0.2),
    "_coloured": replace(_NOISE, colour=0.98),
    "_slow_noise": replace(_NOISE, colour=0.9995),
    "_pink": replace(_NOISE, kind="pink"),
    "_heavy": replace(_NOISE, kind="heavy"),
    "_bursts": replace(_NOISE, kind="bursts"),
    "_resonant": replace(_NOISE, kind="resonant"),
    "_line": replace(_NOISE, line=(33.7, 0.04)),
    "_slow_line": replace(_NOISE, line=(1.9, 0.03)),
    "_walk": replace(_NOISE, walk=0.03),
    "_swells": replace(_NOISE, swells=(0.2, 0.0)),
    "_swells_memory": replace(_NOISE, swells=(0.15, 0.7)),
    "_two_regimes": replace(_NOISE, second_regime=1.6),
    "_steps": replace(_NOISE, step=0.05),
    "_coarse_steps": replace(_NOISE, step=0.05, noise=1e-3),
}
ANGLES: Mapping[str, Angle] = {
    "_few_periods": replace(_ANGLE, periods=4.6),
    "_three_periods": replace(_ANGLE, periods=3.2),
    "_many_periods": replace(_ANGLE, periods=120.7),
    "_drift": replace(_ANGLE, drift=0.06),
    "_counts": replace(_ANGLE, counts=1024),
    "_eccentric": replace(_ANGLE, eccentricity_rad=5e-3),
}
SHAFTS: Mapping[str, Shaft] = {
    **{f"transducer{name}": Shaft(signal) for name, signal in SIGNALS.items()},
    **{f"transducer{name}": Shaft(angle=angle) for name, angle in ANGLES.items()},
    "transducer_few_periods_coloured": Shaft(replace(_NOISE, colour=0.98), replace(_ANGLE, periods=6.4)),
    "transducer_drive_s_rate": Shaft(times=1.0),
    "transducer_slow": Shaft(times=0.2),
    "transducer_little_mean": Shaft(mean_Nm=0.05),
}


def _of_flux(signal: Signal) -> Signal:
    """Return the like of a disturbance of a torque, in Wb."""
    return replace(
        signal,
        noise=0.015 * signal.noise,
        step=0.04 * signal.step,
        walk=0.02 * signal.walk,
        line=(signal.line[0], 0.04 * signal.line[1]),
    )


FLUXES: Mapping[str, Flux] = {
    **{f"ripple_of_flux{name}": Flux(_of_flux(signal)) for name, signal in SIGNALS.items()},
    **{f"ripple_of_flux{name}": Flux(angle=angle) for name, angle in ANGLES.items()},
    "ripple_of_flux_noise_alone": Flux(ripple_Wb=(0.0, 0.0)),
}
_RESIDUAL = Residual()
_LEFT_OUT = ("_loud", "_heavy", "_bursts", "_resonant", "_swells_memory", "_two_regimes", "_coarse_steps")
RESIDUALS: Mapping[str, Residual] = {
    **{f"against_shaft{name}": Residual(signal) for name, signal in SIGNALS.items() if name not in _LEFT_OUT},
    "against_shaft_few_periods": Residual(angle=replace(_ANGLE, periods=2.7)),
    "against_shaft_drift": Residual(angle=replace(_ANGLE, drift=0.06)),
    "against_shaft_noisy_currents": Residual(noise_A=0.03),
    "against_shaft_drive_s_rate": Residual(times=1.0),
    "against_shaft_no_offset": Residual(offset_Nm=0.0),
}


FAMILIES = (
    *families_of(_shaft, SHAFTS),
    *families_of(_flux, FLUXES),
    *families_of(_residual, RESIDUALS),
)
