"""Steady and less steady records: current, torque and angle, with disturbances."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.noise import Converter, Kind, coloured, converted, noise_of
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ = 10_000.0
POLE_PAIRS = 4
AMPLITUDE_A = 5.0
RATED_A_RMS = 4.0
HARMONICS: Mapping[int, float] = {5: 0.03, 7: 0.02}
TORQUE_NM, RIPPLE_NM, COGGING_NM = 2.0, 0.1, 0.05
RIPPLE_ORDER, COGGING_ORDER = 6 * POLE_PAIRS, 3 * POLE_PAIRS
RIPPLE_RAD, COGGING_RAD = 0.3, 1.1
CREST = 6.0  # of narrow crests, exp(CREST (cos - 1)): how narrow they are
TEETH = 5  # of the sawtooth, in a period
TOOTH_ORDER = TEETH * POLE_PAIRS
_MEAN_OF_CRESTS = float(np.i0(CREST)) * math.exp(-CREST)
_MUCH_LESS = 0.05  # of a step
_BETWEEN_CLOCKS = 2e-5  # relative


@dataclass(frozen=True)
class Disturbance:
    """Disturbances of a record besides a current of 5 A, its harmonics, and a torque with ripple.

    Relative quantities are relative to the current's amplitude, or a tenth of that to the mean torque. Lines
    are (order, relative amplitude), swings (relative deviation of the speed, Hz).
    """

    periods: float = 40.0
    frequency_Hz: float = 20.0
    noise: float = 1e-3
    colour: float = 0.0  # pole of a first-order low-pass that the noise has passed
    kind: Kind = "white"
    drift: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    settling: tuple[float, float] = (0.0, 1.0)  # relative speed at the beginning, time constant over duration
    speed_walk: float = 0.0  # relative deviation, rms, at the end of a random walk of the speed
    speed_memory: tuple[float, float] = (0.0, 1.0)  # relative rms of a speed, its memory over the duration
    reverses: bool = False
    stands_still: float = 0.0  # share of the record, from 0.6 of it on
    phase_step_rad: float = 0.0  # of the current against the rotor, at 0.4 of the record
    lines: tuple[tuple[float, float], ...] = ()
    offset: float = 0.0
    decay: tuple[float, float] = (0.0, 1.0)  # relative dc at the beginning, time constant over the duration
    amplitude_noise: tuple[float, float] = (0.0, 0.0)  # rms, correlation over periods
    amplitude_swing: tuple[float, float] = (0.0, 1.0)  # relative, Hz
    amplitude_ramp: float = 0.0  # relative, from the beginning to the end
    amplitude_settling: tuple[float, float] = (
        0.0,
        1.0,
    )  # relative at the beginning, time constant over duration
    alternates: float = 0.0  # relative deviation of the amplitude, up in one period and down in the next
    frozen: int = 0  # rows for which the sensors of current and torque repeat their last value
    sawtooth: tuple[float, float] = (0.0, 0.0)  # of the torque, Nm, five a period; jitter of its teeth
    ripple_noise: tuple[float, float] = (0.0, 0.0)
    second_regime: float = 1.0
    clip: float = math.inf
    bits: int = 0
    harmonics: Mapping[int, float] = field(default_factory=lambda: HARMONICS)
    amplitude_A: float = AMPLITUDE_A
    torque_Nm: float = TORQUE_NM
    angle: bool = True
    counts: int = 0
    is_32_bit: bool = False  # an angle that a link carries in 32 bits
    wobble_rad: tuple[float, int] = (0.0, 1)  # rms of the encoder's own error, and its order
    slip: float = 0.0
    angle_noise_rad: float = 0.0
    angle_index_rad: float = 0.0  # rms, of an angle that is set again in each revolution
    angle_wander: tuple[float, float] = (0.0, 1.0)  # of the encoder's own error, rad, and its frequency, Hz
    time_jitter: float = 0.0  # of a sample period, rms
    across: float = 0.0  # relative rms of a current that makes no torque, of which little is slow
    spikes: float = 0.0  # relative height, some ten in a record
    chirp: tuple[float, float, float] = (0.0, 1.0, 1.0)  # relative amplitude; first and last order
    turns_Nm: tuple[float, float] = (0.0, 0.0)  # of the torque, once and twice in a revolution
    peaked: float = 0.0  # of the torque: ripple of narrow crests to one side, Nm


@dataclass(frozen=True)
class Record:
    """A block and its true values."""

    block: Block
    frequency_Hz: float
    clean_torque_Nm: Floats
    noise_A: Floats
    phases_rad: Mapping[int, float]  # of the harmonics, when the fundamental is at its maximum
    theta_e: Floats
    clean_current_A: Floats  # without noise, before it was read
    converter: Converter | None  # of the current


def record(what: Disturbance, random: np.random.Generator, like: Record | None = None) -> Record:
    """Return one random record: phases of everything are random, and so is the noise; of one `like` another
    the waveform is the same, where it begins, and the converter that reads it."""
    count = round(what.periods / what.frequency_Hz * RATE_HZ)
    time_s = (np.arange(count) + what.time_jitter * random.standard_normal(count)) / RATE_HZ
    duration_s = count / RATE_HZ
    deviation, swing_Hz = what.swing
    swing_rad = 2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi)
    speed = 2 * np.pi * what.frequency_Hz
    if what.counts:  # the rotor and the samples have no clock in common, to which counts would be locked
        speed *= 1.0 + _BETWEEN_CLOCKS * random.standard_normal()
    cycles = speed * time_s + 0.5 * speed * what.drift * (time_s**2 / duration_s - time_s)
    if deviation:
        cycles = cycles + speed * deviation / (2 * np.pi * swing_Hz) * np.sin(swing_rad)
    cycles = cycles + _of_speed(what, time_s / duration_s, random) * speed * duration_s
    if what.reverses:
        cycles = np.where(time_s < 0.7 * duration_s, cycles, 2 * cycles[int(0.7 * count)] - cycles)
    if what.stands_still:
        at, back = (int(share * count) for share in (0.6, 0.6 + what.stands_still))
        cycles = cycles - np.clip(cycles, cycles[at], cycles[back])  # it turns on where it stood
    drawn_rad = random.uniform(0, 2 * np.pi)
    begin_rad = drawn_rad if like is None else float(like.theta_e[0])
    theta_e = cycles + begin_rad
    frequency_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi * (time_s[-1] - time_s[0]))

    noise = coloured(noise_of(what.kind, random, count), what.colour)
    noise_A = what.noise * what.amplitude_A * noise if what.amplitude_A else what.noise * noise
    theta_i = theta_e + np.where(time_s < 0.4 * duration_s, 0.0, what.phase_step_rad)
    current = np.cos(theta_i)
    drawn = {order: random.uniform(0, 2 * np.pi) for order in what.harmonics}
    phases_rad = drawn if like is None else like.phases_rad
    for order, amplitude in what.harmonics.items():
        current += amplitude * np.cos(order * theta_i + phases_rad[order])
    period = np.floor((theta_e - theta_e[0]) / (2 * np.pi)).astype(np.int64)
    period -= period.min()
    current *= 1.0 + _by_period(what.amplitude_noise, period, random)
    size, swing_Hz = what.amplitude_swing
    current *= 1.0 + size * np.cos(2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi))
    current *= 1.0 + what.amplitude_ramp * (time_s / duration_s - 0.5)
    begin, constant = what.amplitude_settling
    settled = constant * math.expm1(-1.0 / constant)  # less its mean
    current *= 1.0 + begin * (np.exp(-time_s / (constant * duration_s)) + settled)
    current *= 1.0 + what.alternates * (1.0 - 2.0 * (period % 2))
    current *= np.where(time_s < 0.5 * duration_s, 1.0, what.second_regime)
    for place, amplitude in what.lines:
        current += amplitude * np.cos(
            2 * np.pi * place * what.frequency_Hz * time_s + random.uniform(0, 6.28)
        )
    if what.chirp[0]:
        size, first, last = what.chirp
        turned = (first + 0.5 * (last - first) * time_s / duration_s) * what.frequency_Hz * time_s
        current += size * np.cos(2 * np.pi * turned + random.uniform(0, 2 * np.pi))
    start, constant = what.decay
    current += what.offset + start * random.choice([-1, 1]) * np.exp(-time_s / (constant * duration_s))
    if what.across:
        ripple = np.diff(random.standard_normal(count + 3), n=3) / math.sqrt(20.0)  # of variance 1, 3, 3, 1
        current -= what.across * ripple * np.sin(theta_i)
    if what.spikes:
        current[random.integers(0, count, random.poisson(10.0))] += what.spikes
    clean_current_A = what.amplitude_A * current
    current = np.clip(clean_current_A + noise_A, -what.clip * AMPLITUDE_A, what.clip * AMPLITUDE_A)

    theta_true = theta_e / POLE_PAIRS
    # between the levels of a converter the extremes are anywhere; without it the ensemble's are the truth
    of_ripple, of_cogging = random.uniform(0, 2 * np.pi, 2) if is_clean(what) else (RIPPLE_RAD, COGGING_RAD)
    torque = what.torque_Nm + RIPPLE_NM * (1.0 + _by_period(what.ripple_noise, period, random)) * np.cos(
        RIPPLE_ORDER * theta_true + of_ripple
    )
    torque += COGGING_NM * np.cos(COGGING_ORDER * theta_true + of_cogging)
    for order, size_Nm in enumerate(what.turns_Nm, 1):
        torque += size_Nm * np.cos(order * theta_true + 0.7 * order)
    torque += TORQUE_NM * what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    if what.peaked:
        torque += what.peaked * (np.exp(CREST * np.cos(RIPPLE_ORDER * theta_true) - CREST) - _MEAN_OF_CRESTS)
    torque += _sawtooth(what.sawtooth, TEETH * theta_e / (2 * np.pi), random)
    clean_torque, converter = torque, None
    if what.bits:
        of_any = Converter.drawn(2.0 * AMPLITUDE_A / 2**what.bits * 1.02, random)
        converter = of_any if like is None or like.converter is None else like.converter
        current = converter.read(current)
        torque = converted(torque, 2.0 * TORQUE_NM / 2**what.bits, random)

    if what.frozen:
        begin = int(random.integers(count // 4, count // 2))
        rows = slice(begin, begin + what.frozen)
        current[rows], torque[rows] = current[begin], torque[begin]

    rms_rad, order_of_wobble = what.wobble_rad
    angle = theta_true * (1.0 + what.slip)
    angle += math.sqrt(2.0) * rms_rad * np.sin(order_of_wobble * theta_true + random.uniform(0, 2 * np.pi))
    angle += what.angle_noise_rad * random.standard_normal(count)
    if what.angle_index_rad:
        revolution = np.floor(theta_true / (2 * np.pi)).astype(np.int64)
        revolution -= revolution.min()
        angle += what.angle_index_rad * random.standard_normal(int(revolution.max()) + 1)[revolution]
    size_rad, wander_Hz = what.angle_wander
    if size_rad:
        angle += size_rad * np.sin(2 * np.pi * wander_Hz * time_s + random.uniform(0, 2 * np.pi))
    angle = np.mod(angle, 2 * np.pi)
    if what.counts:
        angle = np.floor(angle * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts)
    if what.is_32_bit:
        angle = angle.astype(np.float32).astype(np.float64)
    columns = {"i_a": current, "torque": torque} | ({"theta_m": angle} if what.angle else {})
    units = {"i_a": "A", "torque": "Nm", "theta_m": "rad"}
    block = Block.from_arrays(RATE_HZ, {name: units[name] for name in columns}, **columns)
    if what.reverses and not what.angle:
        frequency_Hz = what.frequency_Hz  # a cosine alone does not tell its direction
    return Record(block, frequency_Hz, clean_torque, noise_A, phases_rad, theta_e, clean_current_A, converter)


def is_clean(what: Disturbance) -> bool:
    """Return whether there is a converter, whose steps are much more than the noise."""
    return bool(what.bits) and what.noise <= _MUCH_LESS * 2.0 / 2**what.bits


def _of_speed(what: Disturbance, time: Floats, random: np.random.Generator) -> Floats:
    """Return the phase that deviations of the speed add, over that of the whole record; time from 0 to 1."""
    begin, constant = what.settling
    added = begin * constant * (1.0 - np.exp(-time / constant))
    steps = math.sqrt(1.0 / len(time))
    if what.speed_walk:
        walk = what.speed_walk * steps * np.cumsum(random.standard_normal(len(time)))
        added = added + np.cumsum(walk) / len(time)
    rms, memory = what.speed_memory
    if rms:
        speed = coloured(random.standard_normal(len(time)), math.exp(-1.0 / (memory * len(time))))
        added = added + rms * np.cumsum(speed) / len(time)
    return added


def _sawtooth(size: tuple[float, float], place: Floats, random: np.random.Generator) -> Floats:
    """Return teeth about zero, one for each whole number of `place`, each of which begins a little off."""
    height, jitter = size
    if not height:
        return np.zeros(len(place))
    first, last = math.floor(place.min()) - 2, math.ceil(place.max()) + 3
    edges = np.arange(first, last) + jitter * random.standard_normal(last - first)
    edges.sort()
    at = np.searchsorted(edges, place, side="right") - 1
    return np.asarray(height * ((place - edges[at]) / (edges[at + 1] - edges[at]) - 0.5))


def _by_period(noise: tuple[float, float], period: NDArray[np.int64], random: np.random.Generator) -> Floats:
    """Return a Gauss-Markov sequence, one value a period, smooth between."""
    rms, memory = noise
    if not rms:
        return np.zeros(len(period))
    values = rms * coloured(random.standard_normal(int(period.max()) + 1), memory)
    return np.asarray(values[period])
