"""Phases of periods of a speed that settles: a line and an exponential, from the first to the last row."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_FASTEST, _RATES = 0.4, 60  # of a period
_PARAMETERS = 4  # of a line, an amplitude and a rate, as of a polynomial of the third degree
_CLEARLY = 16.0  # mean squares of noise
_AS_NOISE = 2.5  # times the noise


@dataclass(frozen=True)
class SettlingPhase:
    """`offset` + `slope` t + `settling` exp(-`rate` t), rad, t in periods from the first of `count` phases,
    each the mean over its period where they `are_means`; `noise2`, rad^2, is their mean square about it."""

    offset: float
    slope: float
    settling: float
    rate: float
    count: int
    noise2: float
    are_means: bool = True

    def turned(self, before: float, after: float) -> tuple[float, float]:
        """Return the phase from `before` periods before the first one to `after` periods after the last, rad,
        and its mean square error, rad^2."""
        ends = np.array([-before, self.count - 1.0 + after])
        derivatives = self._derivatives(ends)
        across = derivatives[1] - derivatives[0]
        of_phases = self._derivatives(np.arange(self.count, dtype=np.float64))
        if self.are_means:
            of_phases[:, 2:] *= _mean_over_period(self.rate)
        weights = across @ np.linalg.pinv(of_phases)
        turned_rad = float(across[:3] @ np.array([self.offset, self.slope, self.settling]))
        return turned_rad, float(weights @ weights) * self.noise2

    def _derivatives(self, periods: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return those with all four parameters, shape (n, 4)."""
        basis = _basis(periods, self.rate)
        return np.column_stack([basis, -self.settling * periods * basis[:, 2]])


def settling_phase(
    phase_rad: NDArray[np.float64], noise2: float, *, are_means: bool = True
) -> SettlingPhase | None:
    """Return the settling that phases, shape (n,), show, None where they show none. Each is the mean over its
    period, or, if they are no means, what the phase is in its middle, as along a track that follows it.

    They do where it leaves no more than noise of the mean square `noise2`, rad^2, and clearly less than a
    polynomial with as many parameters.
    """
    count = len(phase_rad)
    spare = count - _PARAMETERS
    if spare < 1 or not noise2 > 0.0:
        return None
    periods = np.arange(count, dtype=np.float64)
    cubic = np.polynomial.Polynomial.fit(periods, phase_rad, _PARAMETERS - 1)
    of_cubic2 = float(np.sum((phase_rad - cubic(periods)) ** 2))
    rates = 1.0 / np.geomspace(_FASTEST, count, _RATES)
    coarse = float(rates[np.argmin(_left2(periods, phase_rad, rates))])
    apart = float(rates[0] / rates[1])
    fine = coarse * np.geomspace(1.0 / apart, apart, _RATES)
    rate = _between(fine, _left2(periods, phase_rad, fine))
    left2, found = _fit(periods, phase_rad, rate, are_means)
    about2 = max(left2 / spare, noise2)
    if left2 > _AS_NOISE * noise2 * spare or of_cubic2 - left2 < _CLEARLY * about2:
        return None
    offset, slope, size = found.tolist()
    return SettlingPhase(offset, slope, size, rate, count, about2, are_means)


def _left2(
    periods: NDArray[np.float64], phase_rad: NDArray[np.float64], rates: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the sums of squares, rad^2, that settlings of these rates leave, both of shape (rates,)."""
    bases = np.empty((len(rates), len(periods), 3))
    bases[:, :, 0], bases[:, :, 1] = 1.0, periods
    np.exp(-rates[:, np.newaxis] * periods, out=bases[:, :, 2])
    orthogonal = np.linalg.qr(bases).Q
    left = phase_rad - np.matvec(orthogonal, np.vecmat(phase_rad, orthogonal))
    return np.asarray(np.vecdot(left, left))


def _fit(
    periods: NDArray[np.float64], phase_rad: NDArray[np.float64], rate: float, are_means: bool
) -> tuple[float, NDArray[np.float64]]:
    """Return the sum of squares that is left, rad^2, and offset, slope and settling."""
    basis = _basis(periods, rate)
    if are_means:
        basis[:, 2] *= _mean_over_period(rate)
    found = np.asarray(np.linalg.lstsq(basis, phase_rad, rcond=None)[0])
    return float(np.sum((phase_rad - basis @ found) ** 2)), found


def _between(rates: NDArray[np.float64], left2: NDArray[np.float64]) -> float:
    """Return the rate of the least sum of squares, by a parabola through it and those of its neighbours, all
    of shape (n,) and of equal ratios: a settling of many radians errs by more than noise in half a step."""
    least = int(np.argmin(left2))
    if not 0 < least < len(rates) - 1:
        return float(rates[least])
    before, here, after = left2[least - 1 : least + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * float((before - after) / bend) if bend > 0.0 else 0.0
    return float(rates[least] * (rates[1] / rates[0]) ** shift)


def _basis(periods: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    return np.column_stack([np.ones_like(periods), periods, np.exp(-rate * periods)])


def _mean_over_period(rate: float) -> float:
    """Return the mean of an exponential over a period, in units of its value in the middle."""
    return math.sinh(0.5 * rate) / (0.5 * rate)
