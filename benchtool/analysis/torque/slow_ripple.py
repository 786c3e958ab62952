"""What is slow of a ripple: its mean, and its size, as where two tones beat."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.torque.means_of_periods import MeanOverPeriods, Periods, mean_over_periods

Floats = NDArray[np.float64]

BEGINS: Floats = np.arange(16.0) * ((math.sqrt(5.0) - 1.0) / 2.0)
"""Where other records begin, in lengths of this one: evenly in the cycles of any line."""

_OF_ONE_SIZE = 4.0  # periods in a cycle
_LEAST_SIZE = 0.25  # of a ripple in its rms: at a node of a beat it is not known


@dataclass(frozen=True)
class SlowRipple:
    """Slow lines and courses of the `mean` of samples, and of their `squares` about it, by which a ripple
    grows and falls, over what `repeats`."""

    mean: MeanOverPeriods
    squares: MeanOverPeriods
    repeats: Periods

    @staticmethod
    def of(
        samples: Floats, repeats: Periods, of_mean: MeanOverPeriods, of_square: MeanOverPeriods
    ) -> SlowRipple:
        """Return those of samples, shape (n,), whose squares about the mean and its lines are `of_square`."""
        if of_mean.course is None:
            return SlowRipple(of_mean, of_square, repeats)
        # a course of the mean is in these squares, but not in the size of the ripple
        about = samples - of_mean.mean - of_mean.slowly(repeats.places(len(samples)))
        return SlowRipple(of_mean, mean_over_periods(np.square(about), repeats), repeats)

    @staticmethod
    def over(samples: Floats, repeats: Periods) -> SlowRipple:
        """Return those of samples, shape (n,), of whole periods."""
        of_mean = mean_over_periods(samples, repeats, may_fall=True)
        square = np.square((of_mean.left if of_mean.of_lines else samples) - of_mean.mean)
        return SlowRipple.of(samples, repeats, of_mean, mean_over_periods(square, repeats, may_fall=True))

    @property
    def is_steady(self) -> bool:
        """Whether neither has a line or a course."""
        return self.mean.is_steady and self.squares.is_steady

    @property
    def swings(self) -> bool:
        """Whether mean or size swing by a course, or the size by lines of which the largest is so slow that
        a period has nearly one size."""
        cycles = [0.0 if each.course is None else each.course.cycles for each in (self.mean, self.squares)]
        lines = self.squares.lines
        if lines is not None and self.squares.of_lines:
            cycles.append(float(lines.cycles[np.argmax(np.hypot(lines.cosine, lines.sine))]))
        return any(0.0 < _OF_ONE_SIZE * each < len(self.repeats) for each in cycles)

    def size(self, place: Floats, later: float = 0.0) -> Floats:
        """Return the size of the ripple at places, shape (n,), from 0 to 1, relative to its rms, in a record
        that begins a share of one later."""
        square = 1.0 + self.squares.slowly(place, later) / self.squares.mean
        return np.asarray(np.sqrt(np.maximum(square, _LEAST_SIZE**2)))

    def without(self, samples: Floats, place: Floats) -> tuple[Floats, Floats]:
        """Return what slow lines and courses leave of samples at places, shape (n,), of one size, and that of
        the larger half of the ripple alone, sorted: at its nodes noise has another distribution."""
        size = self.size(place)
        rest = self.mean.mean + (samples - self.mean.slowly(place) - self.mean.mean) / size
        return rest, np.sort(rest[size >= min(1.0, float(np.max(size)))])
