"""Vectors that would be read much as a record was, in the steps of the converters of their two axes.

A vector that turns dwells where an axis is greatest, and is read wrong there by the same part of a step time
and again: no scatter shows it, and noise of less than a step does not hide it. What is made of the vector, a
mean that is no linear one, is found for several before and behind the converters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import error_of_steps, noise_beside
from benchtool.analysis.quantisation.resolution import counting_step, level_of
from benchtool.analysis.quantisation.steps_along import apart_from_noise, lines_of

_DRAWS, _SEED = 24, 20_261_129
_APART = 0.4  # of a step: by how much the size of a signal that is read in steps is not known
_MOST_ROWS = 1 << 14
_ORDER = 4  # of the differences that leave noise of a smooth course

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


class ReadVectors(NamedTuple):
    """A vector at rows, shape (n,), what is read of it on average over noise, and what is read once."""

    vectors: Complex
    on_average: Complex
    once: Complex


def vectors_as_read(x: Floats, y: Floats, largest_step: float) -> Iterator[ReadVectors]:
    """Yield vectors like those of two axes, shape (n,), at rows that are evenly spread, and what is read of
    them; none where noise hides the steps, and where there are none.

    The levels are those of the record, the vectors differ in size by part of a step. What has steps above
    `largest_step` was not made so by a converter.
    """
    axes = [_Axis(each, largest_step) for each in (x, y)]
    step = max(axis.step for axis in axes)
    size = math.sqrt(2.0 * sum(float(np.var(axis.signal)) for axis in axes))
    if not step > 0.0 or not size > 0.0:
        return
    random = np.random.default_rng(_SEED)
    for part in (np.arange(_DRAWS) + 0.5) / _DRAWS - 0.5:
        of_x, of_y = (axis.drawn(1.0 + part * _APART * step / size, random) for axis in axes)
        yield ReadVectors(*(real + 1j * imag for real, imag in zip(of_x, of_y, strict=True)))


class _Axis:
    """What stands out of the noise of one axis, that noise, and the step in which both are read: zero where
    noise hides it in a mean."""

    def __init__(self, samples: Floats, largest_step: float) -> None:
        self.mean, self.step = float(np.mean(samples)), counting_step(samples)
        about = samples - self.mean
        if not self.step <= largest_step or len(samples) <= 2 * _ORDER:
            self.step = 0.0
        if self.step > 0.0:
            about, noise = apart_from_noise(lines_of(samples), self.step, len(samples))
            # where the leaks of a line of many steps reach all over the spectrum they hold the noise
            power = float(np.mean(np.diff(samples, _ORDER) ** 2)) / math.comb(2 * _ORDER, _ORDER)
            self.noise = max(noise, noise_beside(power, self.step))
            if error_of_steps(about[:1], self.step, self.noise, 0.0) is None:
                self.step, about = 0.0, samples - self.mean
        self.level = level_of(samples, self.step)
        self.signal = about[:: -(-len(about) // _MOST_ROWS)]

    def drawn(self, larger: float, random: np.random.Generator) -> tuple[Floats, Floats, Floats]:
        """Return a signal so many times as large, and what is read of it on average and once."""
        signal = self.mean + larger * self.signal
        if not self.step > 0.0:
            return signal, signal, signal
        error = error_of_steps(signal, self.step, self.noise, self.level)
        assert error is not None
        noisy = signal + self.noise * random.standard_normal(len(signal))
        read = np.round((noisy - self.level) / self.step) * self.step + self.level
        return signal, signal + error, read
