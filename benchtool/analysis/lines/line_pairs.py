"""Two steady lines that are too close to be two maxima: how large the larger one is, over all distances."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.lines.close_distances import likely_fits
from benchtool.analysis.lines.line_models import DOF_OF_NOISE, Complexes, Floats, Integers, hann_kernel

_NEAREST, _FARTHEST, _DISTANCES = 0.02, 1.6, 30  # bins
_STEPS, _MOST_STEP, _STEP = 6, 0.3, 1e-3  # of the fit of a place; bins
_ANYWHERE = 0.5  # bins: as far from the maximum the place is before, standard deviation
_BY_HANN = 1.5  # bins of noise that count as one, under a Hann window


@dataclass(frozen=True)
class Pair:
    """The larger of two lines, with the standard deviations of its place, in bins, and of its amplitude, and
    what the most likely pair leaves of the bins, mean square over that of noise, of `dof` degrees of
    freedom."""

    place: float
    amplitude: float
    of_place: float
    of_amplitude: float
    left: float
    dof: float

    @property
    def by_chance(self) -> float:
        """The probability that noise leaves no less."""
        return fisher_above(self.dof / _BY_HANN, DOF_OF_NOISE, self.left)


def pair_of(measured: Complexes, number: Integers, count: int, place: float, noise: float) -> Pair:
    """Return two lines near a place fitted to bins, shape (bins,), of a record of `count` samples.

    At each distance both phasors and the place are fitted (least squares). A distance is as likely as it
    explains the bins, and an amplitude is before as likely as any other in its logarithm.
    """

    def fitted(first: float, last: float) -> _Fits:
        return _Fits.of(measured, number, count, place, noise, np.linspace(first, last, _DISTANCES))

    fits, dof = likely_fits(fitted, _NEAREST, _FARTHEST), _dof(number)
    weight = np.exp(fits.likely - np.max(fits.likely))
    weight /= np.sum(weight)
    larger, row = np.argmax(fits.sizes, axis=1), np.arange(len(fits.apart))
    amplitude, places = fits.sizes[row, larger], fits.places[row, larger]
    mean, middle = float(weight @ amplitude), float(weight @ places)
    of_amplitude2 = (amplitude - mean) ** 2 + fits.of_size2[row, larger]
    of_place2 = (places - middle) ** 2 + fits.of_place2
    return Pair(
        middle,
        mean,
        math.sqrt(float(weight @ of_place2)),
        math.sqrt(float(weight @ of_amplitude2)),
        2.0 * float(np.min(fits.rest)) / (dof * noise**2),
        dof,
    )


@dataclass(frozen=True)
class _Fits:
    """Pairs at distances `apart`, shape (distances,): `places` and `sizes` of both lines, shape (distances,
    2), what they leave, `rest`, and the variances of sizes and place by noise; and the logarithm of their
    likelihood with that of amplitudes before."""

    apart: Floats
    places: Floats
    sizes: Floats
    rest: Floats
    of_size2: Floats
    of_place2: Floats
    likely: Floats

    @staticmethod
    def of(
        measured: Complexes, number: Integers, count: int, place: float, noise: float, distances: Floats
    ) -> _Fits:
        """Return the pairs whose larger line is near the place, the other above it or below."""
        apart = np.concatenate([-distances, distances])
        at = np.full(len(apart), place)
        for step in range(_STEPS + 1):
            places = np.stack([at, at + apart], axis=1)[:, np.newaxis, :]  # of each pair
            from_places = number[:, np.newaxis] - places
            both, after, before = hann_kernel(
                np.stack([from_places, from_places - _STEP, from_places + _STEP]), count
            )
            adjoint = both.transpose(0, 2, 1)
            square = adjoint @ both
            phasors = np.linalg.solve(square, adjoint @ measured[:, np.newaxis])
            left = measured - (both @ phasors)[:, :, 0]
            slope = (((after - before) / (2.0 * _STEP)) @ phasors)[:, :, 0]
            # what the phasors explain of the slope is none of the place
            slope -= (both @ np.linalg.solve(square, adjoint @ slope[:, :, np.newaxis]))[:, :, 0]
            size = np.maximum(np.sum(np.abs(slope) ** 2, axis=1), 1e-300)
            if step < _STEPS:
                moved = np.sum(np.real(np.conj(slope) * left), axis=1) / size
                at = at + np.clip(moved, -_MOST_STEP, _MOST_STEP)
        rest = np.sum(np.abs(left) ** 2, axis=1)
        half = len(apart) // 2
        best = np.where(rest[:half] < rest[half:], np.arange(half), np.arange(half, 2 * half))
        of_size = np.real(np.diagonal(np.linalg.inv(square), axis1=1, axis2=2))
        certain = 2.0 * np.log(np.linalg.det(square).real)[best]
        places, sizes = np.stack([at, at + apart], axis=1)[best], np.abs(phasors[best, :, 0])
        scale = _BY_HANN * max(noise**2, 2.0 * float(np.min(rest)) / _dof(number))
        # which noise alone allows of two that cancel, many times of both together where they are close
        of_size = 0.5 * scale * of_size[best]
        together2 = np.abs(np.sum(phasors[best, :, 0], axis=1, keepdims=True)) ** 2
        before = np.sum(np.log(sizes**2 + of_size + noise**2), axis=1)
        of_place = 1.0 / (size[best] / (0.5 * scale) + 1.0 / _ANYWHERE**2)
        return _Fits(
            distances,
            places,
            sizes,
            rest[best],
            of_size * together2 / (of_size + together2),
            of_place,
            -rest[best] / scale - 0.5 * certain + 0.5 * np.log(of_place) - before,
        )


def _dof(number: Integers) -> float:
    """Return the degrees of freedom that two lines leave to bins of these numbers."""
    return 2.0 * len(number) - 6.0
