"""Noise that every family may have, and the steps of a converter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]
Kind = Literal[
    "white", "pink", "heavy", "bursts", "walk", "resonant", "popcorn", "bounded", "clicks", "fractional",
    "pink_and_white", "skewed", "mixed_tails", "two_levels",
]  # fmt: skip

UNCORRELATED: frozenset[Kind] = frozenset(
    {"white", "heavy", "bursts", "bounded", "clicks", "skewed", "mixed_tails", "two_levels"}
)
"""Of a level density, whatever their distribution, and whenever their level changes."""

OF_RANGE = 0.07  # of a converter, relative


def noise_of(kind: Kind, random: np.random.Generator, count: int) -> Floats:
    """Return noise of unit rms, shape (count,)."""
    match kind:
        case "white":
            return random.standard_normal(count)
        case "pink":
            return pink(random, count)
        case "heavy":
            return heavy(random, count)
        case "bursts":
            return bursts(random, count)
        case "walk":
            return walk(random, count)
        case "resonant":
            return resonant(random, count)
        case "popcorn":
            return popcorn(random, count)
        case "bounded":
            return random.uniform(-math.sqrt(3.0), math.sqrt(3.0), count)
        case "clicks":
            return clicks(random, count)
        case "fractional":
            return fractional(random, count)
        case "pink_and_white":
            return math.sqrt(0.1) * pink(random, count) + math.sqrt(0.9) * random.standard_normal(count)
        case "skewed":
            return random.standard_exponential(count) - 1.0
        case "mixed_tails":
            return 0.8 * random.standard_normal(count) + 0.6 * random.laplace(0.0, math.sqrt(0.5), count)
        case "two_levels":
            return two_levels(random, count)


def coloured(noise: Floats, pole: float) -> Floats:
    """Return the white noise of unit rms behind a first-order low-pass with this pole, of unit rms again."""
    if not pole:
        return noise
    begin = np.array([pole * noise[0] / math.sqrt(1.0 - pole**2)])
    filtered, _ = signal.lfilter([1.0], [1.0, -pole], noise, zi=begin)
    return np.asarray(filtered * math.sqrt(1.0 - pole**2))


def pink(random: np.random.Generator, count: int) -> Floats:
    """Return noise of unit rms whose density falls as 1 / f, down to a quarter of a cycle in the record."""
    whole = 4 * count
    bins = np.arange(whole // 2 + 1, dtype=np.float64)
    shape = np.zeros(len(bins))
    shape[1:] = 1.0 / np.sqrt(bins[1:])
    phasors = random.standard_normal(len(bins)) + 1j * random.standard_normal(len(bins))
    noise = np.fft.irfft(shape * phasors, whole)
    return np.asarray(noise[:count] * (0.5 * whole / math.sqrt(float(np.sum(shape**2)))))


def heavy(random: np.random.Generator, count: int) -> Floats:
    """Return noise of unit rms with heavy tails: Student's distribution of four degrees of freedom."""
    return np.asarray(random.standard_t(4.0, count) / math.sqrt(2.0))


def bursts(random: np.random.Generator, count: int) -> Floats:
    """Return noise of unit rms, nine tenths of whose power is on average in a fifth of the record, in bursts
    that each begin anywhere, whatever the others do: as many in every record would be no independent ones."""
    size = count // 50
    power = np.full(count, 0.1)
    for begin in random.integers(-size, count, random.poisson(10.0 * (1.0 + size / count))):
        power[max(0, begin) : begin + size] += 4.5
    return np.asarray(np.sqrt(power) * random.standard_normal(count))


def two_levels(random: np.random.Generator, count: int) -> Floats:
    """Return white noise of unit rms that goes from one level to another of three times as much and back, at
    random, some thirty times."""
    switched = np.cumsum(random.random(count) < 30.0 / count) + random.integers(2)
    level = np.where(switched % 2, 3.0, 1.0) / math.sqrt(5.0)
    return np.asarray(level * random.standard_normal(count))


def walk(random: np.random.Generator, count: int) -> Floats:
    """Return white noise and, of as much power, a random walk about zero that begins before the record."""
    steps = np.cumsum(random.standard_normal(count)) / math.sqrt(count)
    return np.asarray((steps - 0.5 * steps[-1] + random.standard_normal(count)) / math.sqrt(1.25))


def resonant(random: np.random.Generator, count: int) -> Floats:
    """Return white noise behind a resonance, of second order, at 0.0137 of the rate."""
    pole, omega = 0.998, 2.0 * math.pi * 0.0137
    driven = random.standard_normal(count + 5000)
    noise = signal.lfilter([1.0], [1.0, -2.0 * pole * math.cos(omega), pole**2], driven)[5000:]
    gain = 1.0 + pole**2
    power = gain / ((1.0 - pole**2) * (gain**2 - (2.0 * pole * math.cos(omega)) ** 2))
    return np.asarray(noise / math.sqrt(power))


def popcorn(random: np.random.Generator, count: int) -> Floats:
    """Return white noise of a tenth of the power, and a level that jumps up and down at random, some forty
    times."""
    jumps = np.cumsum(random.random(count) < 40.0 / count)
    level = np.where((jumps + random.integers(2)) % 2, 1.0, -1.0)
    return np.asarray(math.sqrt(0.9) * level + math.sqrt(0.1) * random.standard_normal(count))


def clicks(random: np.random.Generator, count: int) -> Floats:
    """Return noise of unit rms, half of its power in single samples, one in a thousand, of normal height."""
    hit = random.random(count) < 1e-3
    noise = math.sqrt(0.5) * random.standard_normal(count)
    return noise + np.where(hit, math.sqrt(500.0) * random.standard_normal(count), 0.0)


def fractional(random: np.random.Generator, count: int) -> Floats:
    """Return fractionally integrated noise of the order 0.3: its density falls as f^-0.6 from zero on."""
    d, whole = 0.3, 4 * count
    number = np.arange(1, whole)
    weights = np.concatenate([[1.0], np.cumprod((number - 1 + d) / number)])
    noise = signal.fftconvolve(random.standard_normal(whole), weights)[whole - count : whole]
    return np.asarray(noise * (math.gamma(1.0 - d) / math.sqrt(math.gamma(1.0 - 2.0 * d))))


@dataclass(frozen=True)
class Converter:
    """A converter of equal steps, one of whose levels is at the offset."""

    step: float
    offset: float

    @classmethod
    def drawn(cls, step: float, random: np.random.Generator, tolerance: float = OF_RANGE) -> Converter:
        """Return one of this step, within a tolerance, whose levels are anywhere.

        What its steps do to one waveform depends on the waveform's size in steps.
        """
        step *= random.uniform(1.0 - tolerance, 1.0 + tolerance)
        return cls(step, step * random.uniform(-0.5, 0.5))

    def read(self, values: Floats) -> Floats:
        """Return the values as it gives them."""
        return np.asarray(np.round((values - self.offset) / self.step) * self.step + self.offset)


def converted(
    values: Floats, step: float, random: np.random.Generator, tolerance: float = OF_RANGE
) -> Floats:
    """Return the values as any converter of this step gives them (`Converter.drawn`)."""
    return Converter.drawn(step, random, tolerance).read(values)
