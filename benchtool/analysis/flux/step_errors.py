"""Errors that the steps of a converter make in the radius of a flux, alike in every revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, steps_of_periods


@dataclass(frozen=True)
class StepErrors:
    """Errors that the steps of a converter make alike in every revolution, of both coordinates."""

    both: tuple[RepeatedSteps | None, RepeatedSteps | None] = (None, None)

    @staticmethod
    def of(
        path: NDArray[np.complex128], begins: NDArray[np.int64], step: float, turns: NDArray[np.float64]
    ) -> StepErrors:
        """Return those of a path, shape (n,), whose revolutions begin at rows, shape (revolutions + 1,), and
        where its samples are, in revolutions, shape (n,)."""
        if not step > 0.0:
            return StepErrors()
        alpha, beta = (
            steps_of_periods(np.ascontiguousarray(part), begins, 1, step, turns)
            for part in (path.real, path.imag)
        )
        return StepErrors((alpha, beta))

    @property
    def of_radius(self) -> float:
        """Standard uncertainty of the mean radius, along which the error of a coordinate is by its share of
        it."""
        found = [each for each in self.both if each is not None]
        deviations = [each.waveform - np.mean(each.waveform) for each in found]
        return math.hypot(
            *(each.of_mean(of / np.max(np.abs(of))) for each, of in zip(found, deviations, strict=True))
        )

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

    def of_span(self, step: float) -> float:
        """Standard uncertainty of the difference of the extremes of the radius, by those of an ensemble."""
        alpha, beta = self.both
        if alpha is None or beta is None:
            return 0.0 if alpha is beta else step / math.sqrt(6.0)
        points = min(alpha.errors.shape[1], beta.errors.shape[1])
        places = [np.arange(points) * each.errors.shape[1] // points for each in (alpha, beta)]
        read = [
            each.waveform[at] + each.errors[:, at] for each, at in zip((alpha, beta), places, strict=True)
        ]
        # levels of one are anywhere beside those of the other
        draws = np.random.default_rng(0).permutation(len(read[1]))
        return float(np.std(np.ptp(np.hypot(read[0], read[1][draws]), axis=1)))

    @property
    def of_sixth(self) -> float:
        """Standard uncertainty of order 6 of the radius: half of a coordinate's orders 5 and 7 are in orders
        -5 and 7 of the path, and half of their power along it."""
        power = [float(np.sum(each.power_at(np.array([5, 7])))) for each in self.both if each is not None]
        return math.sqrt(sum(power) / 8.0)
