"""Families of further channels: flux, switching, torque residual, unbalance, lines, transducer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.noise import OF_RANGE, Kind as OfNoise, coloured, converted, noise_of
from benchtool.analysis import (
    current_spectrum,
    current_unbalance,
    flux_trajectory,
    spectral_lines,
    switching_frequency,
    torque_residual,
    torque_ripple,
    track_angle,
    track_tone,
    transducer_torque,
)
from benchtool.block import Block
from benchtool.profile import Motor

Floats = NDArray[np.float64]
Found = Iterator[Compared]

RATE_HZ = 10_000.0
MOTOR = Motor(
    pole_pairs=4,
    R_s_ohm=0.4,
    L_d_H=6e-3,
    L_q_H=9e-3,
    psi_r_Wb=0.17,
    J_kgm2=1e-3,
    T_N_Nm=3.0,
    omega_m_N_rad_s=200.0,
    I_N_A_rms=5.0,
)
RADIUS_WB = 0.17
_MUCH_LESS = 0.05  # of a step


@dataclass(frozen=True)
class Flux:
    """A path of the flux: orders -5 and 7, centre and noise relative to its radius."""

    revolutions: float = 40.3
    frequency_Hz: float = 20.0
    hexagon: tuple[float, float] = (0.02, 0.01)
    centre: float = 0.01
    noise: float = 1e-3
    colour: float = 0.0
    kind: OfNoise = "white"
    ramp: float = 0.0  # of the radius, relative, over the record
    drift: float = 0.0
    centre_drift: complex = 0j  # of the centre, relative to the radius, over the record
    breathing: tuple[float, float] = (0.0, 0.0)  # rms of the radius over revolutions, and its memory
    bits: int = 0
    backwards: bool = False
    reverses: bool = False
    second_regime: float = 1.0
    swing: tuple[float, float] = (0.0, 1.0)  # relative deviation of the speed, revolutions
    line: tuple[float, float] = (0.0, 0.0)  # order and relative size of a rotating interharmonic


def _flux(what: Flux, random: np.random.Generator) -> Found:
    count = round(what.revolutions / what.frequency_Hz * RATE_HZ)
    time = np.arange(count) / count
    angle = 2 * np.pi * what.revolutions * (time + 0.5 * what.drift * (time**2 - time))
    if what.reverses:
        angle = np.where(time < 0.6, angle, 2 * angle[int(0.6 * count)] - angle)
    angle += random.uniform(0, 2 * np.pi)
    deviation, swings = what.swing
    if deviation:
        angle += (
            deviation * what.revolutions / swings * np.sin(2 * np.pi * (swings * time + random.uniform()))
        )
    fifth, seventh, centre = (
        size * np.exp(1j * phase)
        for size, phase in zip((*what.hexagon, what.centre), (0.7, 2.1, 4.0), strict=True)
    )

    def path(x: Floats) -> NDArray[np.complex128]:
        return np.asarray(np.exp(1j * x) + fifth * np.exp(-5j * x) + seventh * np.exp(7j * x) + centre)

    psi = path(angle)
    rms, memory = what.breathing
    if rms:
        revolution = np.floor((angle - angle.min()) / (2 * np.pi)).astype(np.int64)
        psi *= 1.0 + rms * coloured(random.standard_normal(int(revolution.max()) + 1), memory)[revolution]
    psi *= np.where(time < 0.5, 1.0, what.second_regime)
    psi *= 1.0 + what.ramp * (time - 0.5)
    psi += what.centre_drift * (time - 0.5)
    order, size = what.line
    if size:
        psi += size * np.exp(2j * np.pi * (order * what.revolutions * time + random.uniform()))
    parts = [coloured(noise_of(what.kind, random, count), what.colour) for _ in range(2)]
    psi = RADIUS_WB * (psi + what.noise * (parts[0] + 1j * parts[1]))
    if what.backwards:
        psi = np.conj(psi)
    pp_Wb = OF_THE_ENSEMBLE
    if what.bits:
        step = 2.2 * RADIUS_WB / 2**what.bits * random.uniform(1.0 - OF_RANGE, 1.0 + OF_RANGE)
        if what.noise * RADIUS_WB <= _MUCH_LESS * step:
            pp_Wb = float(np.ptp(np.abs(psi)))
        psi = converted(psi.real, step, random, 0.0) + 1j * converted(psi.imag, step, random, 0.0)
    block = Block.from_arrays(
        RATE_HZ, {"psi_alpha": "Wb", "psi_beta": "Wb"}, psi_alpha=psi.real, psi_beta=psi.imag
    )
    radius = np.abs(path(np.arange(0.0, 2 * np.pi, 1e-3)))
    # the noise across the radius makes it longer by its variance over twice the radius
    mean = float(np.mean(radius)) + 0.5 * what.noise**2
    variance = float(np.var(radius)) + what.noise**2 + (rms * float(np.mean(radius))) ** 2
    mean += 0.25 * what.line[1] ** 2
    variance += 0.5 * what.line[1] ** 2 + (what.ramp * mean) ** 2 / 12.0
    truths = {
        "flux_radius_mean": RADIUS_WB * mean * 0.5 * (1.0 + what.second_regime),
        "flux_radius_rms": RADIUS_WB * math.sqrt(variance),
        "flux_radius_pp": pp_Wb,
        "flux_centre_offset": RADIUS_WB * what.centre,
        "flux_radius_order_6": RADIUS_WB * abs(np.conj(fifth) + seventh),
    }
    yield from selected(flux_trajectory(block), truths)


@dataclass(frozen=True)
class Switching:
    """Turn-ons at `rate_Hz` of each leg; `scatter` is that of the time between two, relative to it."""

    rate_Hz: float = 1234.5
    duration_s: float = 1.0
    scatter: float = 0.0
    modulation: tuple[float, float] = (0.0, 1.0)  # of the rate, and its frequency
    wander: tuple[float, float] = (0.0, 0.0)  # of the rate: rms, correlation time in s


def _switching(what: Switching, random: np.random.Generator) -> Found:
    count = round(what.duration_s * RATE_HZ) + 1
    time_s = np.arange(count) / RATE_HZ
    depth, modulation_Hz = what.modulation
    rate_Hz = what.rate_Hz * (
        1.0 + depth * np.sin(2 * np.pi * modulation_Hz * time_s + random.uniform(0, 2 * np.pi))
    )
    rms, memory_s = what.wander
    if rms:
        rate_Hz *= 1.0 + rms * coloured(random.standard_normal(count), math.exp(-1.0 / (memory_s * RATE_HZ)))
    turns = np.concatenate(([0.0], np.cumsum(rate_Hz[:-1]) / RATE_HZ))
    total = np.zeros(count)
    for _ in range(3):
        if what.scatter:
            steps = random.gamma(1 / what.scatter**2, what.scatter**2, int(2 * turns[-1]) + 100)
            events = np.cumsum(steps) - 20.0  # long before the record, so that the beginning has no effect
        else:
            events = np.arange(-1.0, turns[-1] + 1.0) + random.uniform()
        total += np.searchsorted(events, turns)
    block = Block.from_arrays(RATE_HZ, {}, switching_count=total)
    mean_Hz = float(turns[-1]) / what.duration_s if not rms else what.rate_Hz
    yield switching_frequency(block), mean_Hz


@dataclass(frozen=True)
class Residual:
    """A machine that follows its model, and an estimate with offset, noise and ripple, Nm."""

    offset_Nm: float = 0.02
    noise_Nm: float = 0.01
    colour: float = 0.0
    ripple_Nm: float = 0.0
    periods: float = 30.3


def _residual(what: Residual, random: np.random.Generator) -> Found:
    frequency_Hz, i_dq = 20.0, -1.0 + 4.0j
    rows = round(what.periods / frequency_Hz * RATE_HZ)
    omega, T_s = 2 * np.pi * frequency_Hz, 1.0 / RATE_HZ
    theta_e = omega * T_s * np.arange(rows) + random.uniform(0, 2 * np.pi)
    i_s = i_dq * np.exp(1j * theta_e)
    psi_dq = MOTOR.L_d_H * i_dq.real + MOTOR.psi_r_Wb + 1j * MOTOR.L_q_H * i_dq.imag
    # the mean voltage over the period before a row moves the flux to the row
    forth = np.exp(1j * omega * T_s)
    u_s = (psi_dq * (forth - 1.0) / T_s + MOTOR.R_s_ohm * 0.5 * i_dq * (1.0 + forth)) * np.exp(1j * theta_e)
    asked = u_s * forth  # in the row before
    torque_Nm = 1.5 * MOTOR.pole_pairs * (psi_dq.real * i_dq.imag - psi_dq.imag * i_dq.real)
    off = what.offset_Nm + what.ripple_Nm * np.cos(6 * theta_e)
    off += what.noise_Nm * coloured(random.standard_normal(rows), what.colour)
    third = np.exp(2j * np.pi / 3)
    block = Block.from_arrays(
        RATE_HZ,
        {},
        i_a=i_s.real,
        i_b=(i_s * np.conj(third)).real,
        i_c=(i_s * third).real,
        theta_m=np.mod(theta_e / MOTOR.pole_pairs, 2 * np.pi),
        omega_m=np.full(rows, omega / MOTOR.pole_pairs),
        u_alpha=asked.real,
        u_beta=asked.imag,
        torque=torque_Nm - off,
    )
    square = what.offset_Nm**2 + what.noise_Nm**2 + 0.5 * what.ripple_Nm**2
    truths = {"torque_residual_mean": what.offset_Nm, "torque_residual_rms": math.sqrt(square)}
    yield from selected(torque_residual(block, MOTOR), truths)


@dataclass(frozen=True)
class Unbalance:
    """Three currents of 5 A: negative and zero sequence relative to the positive one, and disturbances."""

    negative: float = 0.03
    zero: float = 0.01
    noise: float = 1e-2
    colour: float = 0.0
    line: float = 0.0  # an interharmonic of order 1.37
    periods: float = 30.3
    second_regime: float = 1.0
    reverses: bool = False
    backwards: bool = False
    amplitude_noise: tuple[float, float] = (0.0, 0.0)
    clip: float = math.inf
    drift: float = 0.0
    bits: int = 0
    swing: tuple[float, float] = (0.0, 0.0)  # of all alike: amplitude, about how many cycles in the record


def _unbalance(what: Unbalance, random: np.random.Generator) -> Found:
    frequency_Hz, size_A = 20.0, 5.0
    rows = round(what.periods / frequency_Hz * RATE_HZ)
    time = np.arange(rows) / rows
    theta = 2 * np.pi * what.periods * (time + 0.5 * what.drift * (time**2 - time))
    if what.reverses:
        theta = np.where(time < 0.63, theta, 2 * theta[int(0.63 * rows)] - theta)
    theta = (-theta if what.backwards else theta) + random.uniform(0, 2 * np.pi)
    negative, zero = (x * np.exp(2j * np.pi * random.uniform()) for x in (what.negative, what.zero))
    third = 2 * np.pi / 3
    rms, memory = what.amplitude_noise
    size = np.where(time < 0.5, 1.0, what.second_regime)
    if rms:
        period = (what.periods * time).astype(np.int64)
        size = size * (1.0 + rms * coloured(random.standard_normal(int(period.max()) + 1), memory)[period])
    shift = random.uniform(0, 2 * np.pi)
    if what.swing[0]:
        cycles = what.swing[1] * random.uniform(0.8, 1.2)
        size = size * (1.0 + what.swing[0] * np.cos(2 * np.pi * (cycles * time + random.uniform())))
    currents = {}
    for name, turn in (("i_a", 0.0), ("i_b", third), ("i_c", -third)):
        current = np.cos(theta - turn) + np.real((negative * np.exp(-1j * turn) + zero) * np.exp(-1j * theta))
        current += what.line * np.cos(2 * np.pi * 1.37 * what.periods * time - turn + shift)
        current = size * current + what.noise * coloured(random.standard_normal(rows), what.colour)
        currents[name] = size_A * np.clip(current, -what.clip, what.clip)
        if what.bits:
            currents[name] = converted(currents[name], 2.2 * size_A / 2**what.bits, random)
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(currents, "A"), **currents)
    mean = 0.5 * (1.0 + what.second_regime)
    truths = {
        "current_sequence_positive": size_A * mean,
        "current_sequence_negative": size_A * mean * what.negative,
        "current_sequence_zero": size_A * mean * what.zero,
        "current_unbalance_percent": 100.0 * what.negative,
        "current_unbalance_zero_percent": 100.0 * what.zero,
    }
    track = track_tone(currents["i_a"], "i_a")
    if what.drift:  # which the spectrum of one of them follows
        track = current_spectrum(block, "i_a", track).track
    yield from selected(current_unbalance(block, track), truths)


@dataclass(frozen=True)
class Lines:
    """Sinusoids (Hz, Nm) in a torque with noise, Nm."""

    lines: tuple[tuple[float, float], ...] = ((123.4, 0.1), (311.7, 0.05))
    noise: float = 0.02
    colour: float = 0.0
    bits: int = 0
    duration_s: float = 1.0


def _lines(what: Lines, random: np.random.Generator) -> Found:
    rows = round(what.duration_s * RATE_HZ)
    time_s = np.arange(rows) / RATE_HZ
    off_Hz = random.uniform(-0.5, 0.5) / what.duration_s
    torque = 2.0 + what.noise * coloured(random.standard_normal(rows), what.colour)
    for frequency_Hz, size in what.lines:
        torque += size * np.cos(2 * np.pi * (frequency_Hz + off_Hz) * time_s + random.uniform(0, 2 * np.pi))
    if what.bits:
        step = 4.0 / 2**what.bits
        torque = converted(torque, step, random)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    frequency_Hz, size = what.lines[0]
    truths = {"torque_line_frequency": frequency_Hz + off_Hz, "torque_line_amplitude": size}
    yield from selected(spectral_lines(block, "torque").measurements, truths)


@dataclass(frozen=True)
class Shaft:
    """A transducer at 50 kHz and an estimate with an error of 0.05 Nm, with ripple and noise, Nm."""

    noise: float = 0.02
    colour: float = 0.0
    wander: float = 0.0  # of both, rms, alike
    periods: float = 30.3


def _shaft(what: Shaft, random: np.random.Generator) -> Found:
    frequency_Hz, times = 20.0, 5
    rows = round(what.periods / frequency_Hz * RATE_HZ)
    fine = 2 * np.pi * what.periods * np.arange(rows * times) / (rows * times)
    alike = what.wander * coloured(random.standard_normal(rows * times), 0.9999)
    true_Nm = 2.0 + 0.1 * np.cos(6 * fine + 1.0) + alike
    own, other = (coloured(random.standard_normal(each), what.colour) for each in (rows * times, rows))
    theta_m = np.mod(fine[::times] / MOTOR.pole_pairs, 2 * np.pi)
    block = Block.from_arrays(
        RATE_HZ, {"torque": "Nm"}, torque=true_Nm[::times] + 0.05 + what.noise * other, theta_m=theta_m
    )
    shaft = Block.from_arrays(
        times * RATE_HZ, {"torque_transducer": "Nm"}, torque_transducer=true_Nm + what.noise * own
    )
    track = track_angle(theta_m, MOTOR.pole_pairs)
    estimate = torque_ripple(block, track=track)[0]
    truths = {
        "transducer_torque_mean": 2.0,
        "torque_error": 0.05,
        "transducer_torque_ripple_pp": OF_THE_ENSEMBLE,
    }
    yield from selected(transducer_torque(shaft, block, estimate=estimate, track=track), truths)


_FLUX, _SWITCHING, _RESIDUAL = Flux(), Switching(), Residual()
_UNBALANCE, _LINES, _SHAFT = Unbalance(), Lines(), Shaft()
Kind = Flux | Switching | Residual | Unbalance | Lines | Shaft
KINDS: Mapping[str, Kind] = {
    "flux_hexagon": _FLUX,
    "flux_circle": replace(_FLUX, hexagon=(0.0, 0.0), centre=0.0, noise=3e-3),
    "flux_coloured": replace(_FLUX, colour=0.97, noise=3e-3),
    "flux_few_revolutions": replace(_FLUX, revolutions=4.6, noise=3e-3),
    "flux_three_revolutions": replace(_FLUX, revolutions=3.4, noise=3e-3),
    "flux_three_revolutions_ramp": replace(_FLUX, revolutions=3.6, ramp=0.03, frequency_Hz=41.3),
    "flux_few_pink": replace(_FLUX, revolutions=4.4, kind="pink", noise=3e-3),
    "flux_nine_pink": replace(_FLUX, revolutions=9.3, kind="pink", noise=3e-3),
    "flux_offset": replace(_FLUX, centre=0.1),
    "flux_drift": replace(_FLUX, drift=0.03),
    "flux_breathing": replace(_FLUX, breathing=(0.01, 0.0), revolutions=80.4),
    "flux_breathing_memory": replace(_FLUX, breathing=(0.01, 0.9), revolutions=200.4),
    "flux_breathing_some_memory": replace(_FLUX, breathing=(0.01, 0.5), revolutions=120.4),
    "flux_breathing_long": replace(_FLUX, breathing=(0.01, 0.8), revolutions=400.3),
    "flux_breathing_slow": replace(_FLUX, breathing=(0.01, 0.95), revolutions=400.3),
    "flux_bits_8": replace(_FLUX, bits=8, noise=1e-4),
    "flux_bits_7_quiet": replace(_FLUX, bits=7, noise=1e-5, hexagon=(0.025, 0.0), revolutions=50.2),
    "flux_bits_10_noise": replace(_FLUX, bits=10, noise=4e-4, hexagon=(0.017, 0.0), revolutions=50.4),
    "flux_centre_drifts": replace(
        _FLUX, hexagon=(0.0, 0.0), centre=0.0, centre_drift=0.03j, revolutions=50.3
    ),
    "flux_fifty_pink": replace(_FLUX, kind="pink", noise=8e-3, revolutions=50.6),
    "flux_backwards": replace(_FLUX, backwards=True),
    "flux_reversal": replace(_FLUX, reverses=True),
    "flux_two_regimes": replace(_FLUX, second_regime=0.6),
    "switching_regular": _SWITCHING,
    "switching_short": replace(_SWITCHING, duration_s=0.02),
    "switching_irregular": replace(_SWITCHING, scatter=0.5),
    "switching_poisson": replace(_SWITCHING, scatter=1.0, rate_Hz=300.0),
    "switching_modulated": replace(_SWITCHING, modulation=(0.3, 40.0)),
    "switching_wander": replace(_SWITCHING, wander=(0.1, 0.01), scatter=0.2),
    "switching_slow_wander": replace(_SWITCHING, wander=(0.1, 0.05), scatter=0.2, duration_s=3.0),
    "residual": _RESIDUAL,
    "residual_coloured": replace(_RESIDUAL, colour=0.99),
    "residual_ripple": replace(_RESIDUAL, ripple_Nm=0.05),
    "residual_short": replace(_RESIDUAL, periods=1.3, ripple_Nm=0.02),
    "unbalance": _UNBALANCE,
    "unbalance_none": replace(_UNBALANCE, negative=0.0, zero=0.0),
    "unbalance_coloured": replace(_UNBALANCE, colour=0.98),
    "unbalance_interharmonic": replace(_UNBALANCE, line=0.02, noise=1e-3),
    "unbalance_few_periods": replace(_UNBALANCE, periods=4.6),
    "unbalance_amplitude_memory": replace(_UNBALANCE, amplitude_noise=(0.02, 0.9), periods=100.3),
    "unbalance_backwards": replace(_UNBALANCE, backwards=True),
    "unbalance_reversal": replace(_UNBALANCE, reverses=True),
    "unbalance_two_regimes": replace(_UNBALANCE, second_regime=2.2),
    "unbalance_swing": replace(_UNBALANCE, swing=(0.04, 3.1), periods=41.3, noise=3e-3),
    "unbalance_swing_slow": replace(_UNBALANCE, swing=(0.02, 1.9), periods=60.7, colour=0.9),
    "unbalance_swing_fast": replace(_UNBALANCE, swing=(0.05, 11.0), periods=80.2, noise=1e-3),
    "unbalance_swing_little": replace(_UNBALANCE, swing=(0.005, 4.4), periods=50.6, noise=3e-2),
    "unbalance_clipped": replace(_UNBALANCE, clip=0.8, noise=1e-4),
    "lines": _LINES,
    "lines_coloured": replace(_LINES, colour=0.98),
    "lines_bits_8": replace(_LINES, bits=8, noise=1e-3),
    "lines_close": replace(_LINES, lines=((123.4, 0.1), (130.9, 0.05))),
    "lines_none": replace(_LINES, lines=((123.4, 0.0),)),
    "shaft": _SHAFT,
    "shaft_coloured": replace(_SHAFT, colour=0.98),
    "shaft_wander": replace(_SHAFT, wander=0.05, periods=100.3),
}


def trial(what: Kind, random: np.random.Generator) -> Found:
    """Return one record, measured."""
    match what:
        case Flux():
            return _flux(what, random)
        case Switching():
            return _switching(what, random)
        case Residual():
            return _residual(what, random)
        case Unbalance():
            return _unbalance(what, random)
        case Lines():
            return _lines(what, random)
        case Shaft():
            return _shaft(what, random)


FAMILIES = families_of(trial, KINDS)
