"""Families of two lines within a bin of one another, and of steps that a commensurate rate repeats."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import of_harmonics, of_white_noise
from benchmarks.coverage.noise import converted
from benchtool.analysis import (
    Measurement,
    Uncertainty,
    current_spectrum,
    spectral_lines,
    track_angle,
    track_tone,
)
from benchtool.block import Block

RATE_HZ, POLE_PAIRS = 10_000.0, 4
_HARMONICS = {3: 0.002, 5: 0.03, 7: 0.02, 11: 0.01, 13: 0.005}


def _log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return math.exp(random.uniform(math.log(low), math.log(high)))


@dataclass(frozen=True)
class Beside:
    """A current of 1 to 5 A, and steady lines so many bins beside one of its harmonics, of a share of that.

    Each record has its own, drawn from the ranges, those of shares and of noise in their logarithm. The speed
    drifts and swings, and the amplitude ramps, by up to so much.
    """

    orders: tuple[int, ...] = (5, 7, 11)
    bins: tuple[float, float] = (0.05, 1.0)
    share: tuple[float, float] = (0.02, 0.5)
    noise: tuple[float, float] = (1e-4, 3e-3)
    periods: tuple[float, float] = (20.0, 120.0)
    angle: bool = True
    harmonics: float = 1.0  # times the usual ones
    drift: float = 0.0
    swing: float = 0.0
    ramp: float = 0.0
    lines: int = 1


def _beside(what: Beside, random: np.random.Generator) -> Iterator[Compared]:
    f_Hz, periods, size_A = (
        random.uniform(17.0, 60.0),
        random.uniform(*what.periods),
        random.uniform(1.0, 5.0),
    )
    count = round(periods / f_Hz * RATE_HZ)
    time = np.arange(count) / count
    turns = periods * time
    turns = turns + what.drift * random.uniform(-0.5, 0.5) * periods * (time**2 - time)
    if what.swing:
        cycles = random.uniform(1.0, 6.0)
        of_swing = what.swing * random.uniform() * periods / (2 * np.pi * cycles)
        turns = turns + of_swing * np.sin(2 * np.pi * (cycles * time + random.uniform()))
    theta = 2 * np.pi * (turns + random.uniform())
    amplitudes = {1: 1.0} | {
        k: each * what.harmonics * random.uniform(0.5, 1.5) for k, each in _HARMONICS.items()
    }
    current = sum(
        a * np.cos(k * theta + random.uniform(0, 2 * np.pi) * (k > 1)) for k, a in amplitudes.items()
    )
    current = np.asarray(current) * (1.0 + what.ramp * random.uniform(-0.5, 0.5) * (2.0 * time - 1.0))
    order = int(random.choice(what.orders))
    for _ in range(what.lines):
        off = random.choice([-1.0, 1.0]) * random.uniform(*what.bins)
        share = _log_uniform(random, *what.share) if what.share[1] else 0.0
        beside = 2 * np.pi * (order * periods + off) * time + random.uniform(0, 2 * np.pi)
        current = current + share * amplitudes[order] * np.cos(beside)
    noise_rms = _log_uniform(random, *what.noise)
    read_A = size_A * (current + noise_rms * random.standard_normal(count))
    track = track_angle(theta / POLE_PAIRS, POLE_PAIRS) if what.angle else track_tone(read_A)
    found = current_spectrum(Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=read_A), "i_a", track)
    truths = {
        "fundamental_frequency": float(theta[-1] - theta[0]) / (2 * np.pi) * RATE_HZ / (count - 1),
        **of_harmonics({k: size_A * a for k, a in amplitudes.items()}),
        **of_white_noise(size_A * noise_rms, RATE_HZ, found.measurements),
    }
    if what.lines and what.share[1]:  # which are taken out or not, and the largest beside a harmonic or not
        del truths["current_max_low_harmonic"]
    yield from selected(found.measurements, truths)
    for table in found.tables:
        if table.name == "current_harmonics":
            named = {f"harmonic_{k}": k for k in (5, 7)} | {"harmonic_beside": order}
            for name, k in named.items():
                row = table.rows[k - 1]
                u = Uncertainty(row[5], "") if math.isfinite(row[5]) else None
                yield Measurement(name, row[2], "A", "", uncertainty=u), size_A * amplitudes[k]


@dataclass(frozen=True)
class Pair:
    """Two lines of a torque, of 0.1 Nm and a share of that, so many bins apart."""

    bins: tuple[float, float] = (0.1, 1.5)
    share: tuple[float, float] = (0.05, 0.9)
    noise: tuple[float, float] = (1e-4, 1e-2)
    cycles: tuple[float, float] = (30.0, 600.0)


def _pair(what: Pair, random: np.random.Generator) -> Iterator[Compared]:
    rate_Hz, count = 2_000.0, int(random.integers(4_000, 12_000))
    time, cycles = np.arange(count) / count, random.uniform(*what.cycles)
    off, share = random.choice([-1.0, 1.0]) * random.uniform(*what.bins), _log_uniform(random, *what.share)
    phases = random.uniform(0, 2 * np.pi, 2)
    torque = 1.8 + 0.1 * np.cos(2 * np.pi * cycles * time + phases[0])
    torque += 0.1 * share * np.cos(2 * np.pi * (cycles + off) * time + phases[1])
    torque += _log_uniform(random, *what.noise) * random.standard_normal(count)
    found = spectral_lines(Block.from_arrays(rate_Hz, {"torque": "Nm"}, torque=torque), "torque")
    truths = {"torque_line_frequency": cycles * rate_Hz / count, "torque_line_amplitude": 0.1}
    yield from selected(found.measurements, truths)
    if not found.tables[0].rows:
        return
    row = found.tables[0].rows[0]
    for name, value, u, truth in (
        ("row_frequency", row[0], row[2], truths["torque_line_frequency"]),
        ("row_amplitude", row[1], row[3], 0.1),
    ):
        yield (
            Measurement(name, value, "", "", uncertainty=Uncertainty(u, "") if math.isfinite(u) else None),
            truth,
        )


@dataclass(frozen=True)
class Commensurate:
    """A line of a torque, and a weaker one at three times its frequency, in steps of a converter whose rate
    is so many times that, a half or thirds more: the same few samples again and again."""

    bits: tuple[int, int] = (8, 12)
    samples: tuple[int, int] = (3, 40)
    noise: float = 0.0  # steps
    weaker: float = 0.0
    off: float = 0.0  # bins
    periods: tuple[int, int] = (20, 400)


def _commensurate(what: Commensurate, random: np.random.Generator) -> Iterator[Compared]:
    rate_Hz, bits = 2_000.0, int(random.integers(what.bits[0], what.bits[1] + 1))
    together, periods = int(random.integers(1, 4)), int(random.integers(*what.periods))
    samples = int(random.integers(*what.samples)) + (
        random.integers(1, together) / together if together > 1 else 0.0
    )
    count = round(samples * periods)
    turns = np.arange(count) / samples + what.off * random.uniform(-1.0, 1.0) * np.arange(count) / count
    size = random.uniform(0.3, 1.0)
    torque = size * np.cos(2 * np.pi * (turns + random.uniform()))
    torque += what.weaker * size * np.cos(2 * np.pi * (3.0 * turns + random.uniform()))
    step = 2.0 / 2**bits
    torque = converted(torque + what.noise * step * random.standard_normal(count), step, random)
    found = spectral_lines(Block.from_arrays(rate_Hz, {"torque": "Nm"}, torque=torque), "torque")
    frequency_Hz = (turns[-1] - turns[0]) * rate_Hz / (count - 1)
    truths = {"torque_line_frequency": float(frequency_Hz), "torque_line_amplitude": size}
    yield from selected(found.measurements, truths)


_BESIDE, _PAIR, _COMMENSURATE = Beside(), Pair(), Commensurate()
BESIDE: Mapping[str, Beside] = {
    "near_harmonic": _BESIDE,
    "near_harmonic_no_angle": replace(_BESIDE, angle=False),
    "near_harmonic_near": replace(_BESIDE, bins=(0.05, 0.3)),
    "near_harmonic_few": replace(_BESIDE, periods=(6.0, 20.0)),
    "near_harmonic_speed": replace(_BESIDE, drift=0.03, swing=0.005),
    "near_harmonic_ramp": replace(_BESIDE, ramp=0.03),
    "near_harmonic_two": replace(_BESIDE, lines=2),
    "near_harmonic_two_speed": replace(_BESIDE, lines=2, drift=0.03, swing=0.005),
    "near_fundamental": replace(_BESIDE, orders=(1,), share=(1e-3, 0.05)),
    "near_fundamental_no_angle": replace(_BESIDE, orders=(1,), share=(1e-3, 0.05), angle=False),
    "near_fundamental_alone": replace(_BESIDE, orders=(1,), share=(1e-3, 0.05), harmonics=1e-3, angle=False),
    "near_none": replace(_BESIDE, share=(0.0, 0.0)),
    "near_none_no_angle": replace(_BESIDE, share=(0.0, 0.0), angle=False),
    "near_none_speed": replace(_BESIDE, share=(0.0, 0.0), drift=0.03, swing=0.005),
    "near_none_ramp": replace(_BESIDE, share=(0.0, 0.0), ramp=0.03),
}
PAIRS: Mapping[str, Pair] = {
    "near_pair_of_lines": _PAIR,
    "near_pair_of_lines_near": replace(_PAIR, bins=(0.05, 0.5)),
    "near_pair_of_lines_alike": replace(_PAIR, share=(0.5, 0.98)),
    "near_pair_of_lines_quiet": replace(_PAIR, noise=(1e-6, 1e-4)),
}
STEPS: Mapping[str, Commensurate] = {
    "commensurate": _COMMENSURATE,
    "commensurate_few": replace(_COMMENSURATE, samples=(3, 9)),
    "commensurate_nearly": replace(_COMMENSURATE, off=0.3),
    "commensurate_noise": replace(_COMMENSURATE, noise=0.2),
    "commensurate_two": replace(_COMMENSURATE, weaker=0.1),
}

FAMILIES = (
    *families_of(_beside, BESIDE),
    *families_of(_pair, PAIRS),
    *families_of(_commensurate, STEPS),
)
