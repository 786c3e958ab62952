"""Slopes of noisy samples, and whether the one before a step goes on after it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.lowest_frequencies import slow_noise
from benchtool.analysis.statistics.straight_lines import places_about_middle, slope_weights
from benchtool.analysis.steps.smoothing import Noise, without_a_line

Floats = NDArray[np.float64]

_SIGMAS = 3.5  # standard uncertainties of a slope that noise alone hardly ever has
_AT_REST = 5.0  # likewise, of one after the signal has settled
_AGREES = 3.0  # standard uncertainties between both, at most, of one drift
_ALONE, _RISES = 10.0, 0.7  # likewise, of one that none before it tells; octaves that slow noise rises by
_FEWEST = 20  # samples of a slope


@dataclass(frozen=True)
class Slope:
    """Slope of a line through samples, per sample, and its standard uncertainty."""

    value: float
    standard: float

    @classmethod
    def of(cls, samples: Floats) -> Slope | None:
        """Fit a line to samples, shape (n,); its uncertainty is what stationary noise of the autocovariance
        about that line does to its slope. None of too few samples."""
        if len(samples) < _FEWEST:
            return None
        weights = slope_weights(len(samples))
        return cls(float(weights @ samples), Noise.of(samples).of_sum(weights))

    @property
    def is_certain(self) -> bool:
        """Whether noise alone hardly ever has it."""
        return abs(self.value) > _SIGMAS * self.standard

    @property
    def is_certain_at_rest(self) -> bool:
        """Whether noise of samples at rest, of which more are slow, hardly ever has it."""
        return abs(self.value) > _AT_REST * self.standard

    def is_like(self, other: Slope) -> bool:
        """Return whether the other is the same within the uncertainties of both."""
        return abs(self.value - other.value) <= _AGREES * math.hypot(self.standard, other.standard)

    def seen_from(self, side: float) -> Slope:
        """Return the slope of the samples times a side, +1 or -1."""
        return Slope(side * self.value, self.standard)

    def goes_on_in(self, samples: Floats) -> bool:
        """Return whether samples at rest, shape (n,), have it too; the slope of slow noise does not go on."""
        later = Slope.of(samples)
        return later is not None and later.is_certain_at_rest and later.is_like(self)


def are_along_a_line(samples: Floats) -> bool:
    """Return whether samples at rest, shape (n,), show by themselves that they drift evenly: noise of those
    about a line hardly ever has their slope, and rises as little towards zero frequency as white noise. That
    of a walk, of jumps and of an answer that creeps bends, and rises."""
    slope = Slope.of(samples)
    if slope is None or not abs(slope.value) > _ALONE * slope.standard:
        return False
    noise = slow_noise(without_a_line(samples))
    return noise is not None and noise.rise < _RISES


def without_drift(before: Floats, at_rest: Floats) -> tuple[Floats, Floats]:
    """Return the samples before a step and those at rest after it without a drift that both have for certain:
    it is no slow noise. The level before the step is then that at the step."""
    drift = Slope.of(before)
    if drift is None or not drift.is_certain or not drift.goes_on_in(at_rest):
        return before, at_rest
    ahead, behind = np.arange(-len(before), 0), places_about_middle(len(at_rest))
    return before - drift.value * ahead, at_rest - drift.value * behind
