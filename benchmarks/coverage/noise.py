"""Noise that every family may have, and the steps of a converter."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]
Kind = Literal["white", "pink", "heavy", "bursts"]


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
    """Return noise of unit rms, nine tenths of whose power is in a tenth of the record, in five bursts."""
    size = count // 50
    level = np.full(count, math.sqrt(0.1 / 0.9))
    for begin in random.choice(np.arange(0, count - size, size), 5, replace=False):
        level[begin : begin + size] = 3.0
    return level * random.standard_normal(count)


def converted(values: Floats, step: float, random: np.random.Generator) -> Floats:
    """Return the values as a converter gives them, whose offset puts its levels anywhere."""
    offset = step * random.uniform(-0.5, 0.5)
    return np.asarray(np.round((values - offset) / step) * step + offset)
