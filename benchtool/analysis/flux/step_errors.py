"""Errors that the steps of a converter make in the radius of a flux, alike in every revolution.

A coordinate that has come to its greatest dwells there, and is read wrong by the same part of a step all the
while: what that does to a number is the sum of it over the revolution, with the sign that it has there, and
not the power of a line or two.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, steps_of_periods
from benchtool.analysis.statistics.magnitudes import standard_of_root

_MOST_PLACES, _SAMPLES_AT_PLACE = 256, 4

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class StepErrors:
    """Errors that the steps of a converter make alike in every revolution, of both coordinates, along a mean
    revolution of the `path`, shape (places,)."""

    both: tuple[RepeatedSteps | None, RepeatedSteps | None] = (None, None)
    path: Complex | None = None

    @staticmethod
    def of(path: Complex, begins: NDArray[np.int64], step: float, turns: Floats) -> StepErrors:
        """Return those of a path, shape (n,), whose revolutions begin at rows, shape (revolutions + 1,), and
        where its samples are, in revolutions, shape (n,)."""
        if not step > 0.0:
            return StepErrors()
        alpha, beta = (
            steps_of_periods(np.ascontiguousarray(part), begins, 1, step, turns)
            for part in (path.real, path.imag)
        )
        return StepErrors((alpha, beta), _mean_revolution(path, turns))

    @property
    def of_radius(self) -> float:
        """Standard uncertainty of the mean radius."""
        return 0.0 if self.path is None else self._along_radius(np.ones(len(self.path)))

    def of_rms(self, rms: float) -> float:
        """Standard uncertainty of the `rms` of the radius about its mean, by what errors do with that, and by
        how much their power differs from what steps add on average: that may be all of it."""
        if self.path is None:
            return 0.0
        radius = np.abs(self.path)
        of_powers = (
            float(np.std(np.mean(each.errors**2 * _at_points(share**2, each.errors.shape[1]), axis=1)))
            for share, each in self._shares
        )
        along = self._along_radius(2.0 * (radius - np.mean(radius)))
        return standard_of_root(rms**2, math.hypot(along, *of_powers))

    def of_sixth(self, sixth: complex, begin_rad: float) -> float:
        """Standard uncertainty of the length of order 6 of the radius, along an angle that is `begin_rad`
        where a revolution begins."""
        if self.path is None:
            return 0.0
        turn_rad = 2.0 * np.pi * _places(len(self.path)) + begin_rad
        return self._along_radius(2.0 * np.cos(6.0 * turn_rad + np.angle(sixth)))

    def of_centre(self, centre: complex) -> float:
        """Standard uncertainty of the distance of a centre from zero."""
        away = centre / abs(centre) if centre else 1.0
        shares = (complex(away).real, complex(away).imag)
        return math.hypot(
            *(
                share * each.of_mean()
                for share, each in zip(shares, self.both, strict=True)
                if each is not None
            )
        )

    def _along_radius(self, weights: Floats) -> float:
        """Return the rms of the mean error of the radius times weights at the places of the path."""
        return math.hypot(
            *(each.of_mean(_at_points(share * weights, each.errors.shape[1])) for share, each in self._shares)
        )

    @property
    def _shares(self) -> Iterator[tuple[Floats, RepeatedSteps]]:
        """Yield what the radius at the places of the path has of an error of each coordinate, and these."""
        assert self.path is not None, "the shares are along it"
        away = self.path / np.abs(self.path)
        for share, each in zip((away.real, away.imag), self.both, strict=True):
            if each is not None:
                yield share, each


def _places(count: int) -> Floats:
    """Return the middles of so many parts of a revolution."""
    return np.asarray((np.arange(count) + 0.5) / count)


def _mean_revolution(path: Complex, turns: Floats) -> Complex:
    """Return means of a path, shape (n,), at places of a revolution."""
    count = min(_MOST_PLACES, max(1, len(path) // _SAMPLES_AT_PLACE))
    place = np.floor(np.mod(turns, 1.0) * count).astype(np.int64) % count
    samples = np.bincount(place, minlength=count)
    seen = samples > 0
    sums = np.bincount(place, path.real, count) + 1j * np.bincount(place, path.imag, count)
    at = _places(count)
    return np.asarray(np.interp(at, at[seen], sums[seen] / samples[seen], period=1.0))


def _at_points(values: Floats, points: int) -> Floats:
    """Return values at places of a revolution at so many points of it, the first where it begins."""
    return np.asarray(np.interp(np.arange(points) / points, _places(len(values)), values, period=1.0))
