"""Amplitude over order, cycles per mechanical revolution: by time in steady state, else by angle alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.angle import AngleCoverage
from benchtool.analysis.angle_orders import fit_orders
from benchtool.analysis.measurement import Basis
from benchtool.analysis.periods import track_angle
from benchtool.analysis.spectrum import coherent_spectrum
from benchtool.analysis.validity import require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError

HIGHEST_ORDER = 200

LARGEST_WOBBLE_RAD = 1.5e-3
"""Rms deviation of the angle from a smooth track at which order 200 loses 5 %: it turns by 0.3 rad."""

_NEIGHBOURS = 4  # bins on either side that give the noise, at least
_MEDIAN_OF_RAYLEIGH = math.sqrt(2.0 * math.log(2.0))  # of noise of unit variance in each component


@dataclass(frozen=True)
class OrderSpectrum:
    """Peak `amplitude` of orders `order` (1, 2, 3 ... per mechanical revolution), both of shape (orders,).

    `standard` is the standard uncertainty of each amplitude, from `uncertainty_source`; `mean` is order 0.
    All are in `unit`. `method` says in words how they were made.
    """

    signal: str
    unit: str
    order: NDArray[np.int64]
    amplitude: NDArray[np.float64]
    standard: NDArray[np.float64]
    mean: float
    revolutions: float
    method: str
    uncertainty_source: str
    basis: Basis

    @property
    def largest(self) -> NDArray[np.int64]:
        """Orders by falling amplitude."""
        return self.order[np.argsort(-self.amplitude, kind="stable")]


def resampled_orders(
    block: Block, channel: str, angle: str = "theta_m", largest_wobble_rad: float = LARGEST_WOBBLE_RAD
) -> OrderSpectrum:
    """Orders of a uniformly sampled channel: bin k x revolutions of its coherent spectrum is order k.

    The uncertainty is from the median of the bins between orders, nearest to each: noise has a Rayleigh
    distribution there, whose median is sqrt(2 ln 2) = 1.177 standard deviations of one component.

    Raises:
        AnalysisError: as `track_angle` and `coherent_spectrum`, a gap, or an angle that is off its smooth
            track by more than `largest_wobble_rad`, rms, so that orders by time are not orders by angle.
    """
    require_unbroken(block)
    theta_m, samples = block.column(angle), block.column(channel)
    track = track_angle(theta_m, 1)
    wobble_rad = track.residual_rad or 0.0
    if wobble_rad > largest_wobble_rad:
        raise AnalysisError(
            f"'{angle}' is off a smooth track by {wobble_rad:.3g} rad rms, at most {largest_wobble_rad:.3g} "
            f"is allowed: fit orders to the angle itself"
        )
    spectrum = coherent_spectrum(samples, block.sample_rate_Hz, track, channel)
    turns = spectrum.periods
    count = min(HIGHEST_ORDER, (len(spectrum.amplitude) - 1) // turns)
    orders = np.arange(1, count + 1)
    return OrderSpectrum(
        signal=channel,
        unit=block.unit(channel),
        order=orders,
        amplitude=spectrum.amplitude[orders * turns],
        standard=_noise_between(spectrum.amplitude, turns, count),
        mean=float(spectrum.amplitude[0]) * math.copysign(1.0, float(np.mean(samples))),
        revolutions=float(turns),
        method=f"DFT over {turns} whole revolutions, resampled to equal steps of a {track.source}",
        uncertainty_source="median of the bins between orders nearest to it, as noise",
        basis=Basis(
            samples=spectrum.samples,
            sample_rate_Hz=block.sample_rate_Hz,
            duration_s=spectrum.samples / block.sample_rate_Hz,
            bandwidth_Hz=float(spectrum.frequency_Hz[-1]),
            window=f"rectangular, {turns} whole mechanical revolutions",
            harmonics=count,
            gaps=0,
        ),
    )


def fitted_orders(
    coverage: AngleCoverage,
    values: NDArray[np.float64],
    signal: str,
    unit: str,
    angle: str = "theta_m",
    basis: Basis | None = None,
) -> OrderSpectrum:
    """Orders of samples taken at any times, by angle alone: see `angle_orders.fit_orders`.

    Args:
        coverage: the angle, from `angle_coverage`.
        values: the signal at those angles, shape (n,).
        signal, unit, angle: names for the definitions.
        basis: what is known of the samples; window and highest order are filled in.

    Raises:
        AnalysisError: not finite, constant, or an arc of the circle is left out.
    """
    fit = fit_orders(coverage, values, HIGHEST_ORDER)
    count = len(fit.coefficient)
    arc = math.degrees(coverage.largest_arc_rad)
    method = (
        f"least squares of orders 1 to {count} on {angle}, each degree of each of {coverage.revolutions:.4g} "
        f"revolutions weighted the same, largest arc without a sample {arc:.3g} degrees"
    )
    if coverage.resolution_rad > 0.0:
        method += f", angle in steps of {math.degrees(coverage.resolution_rad):.3g} degrees"
    return OrderSpectrum(
        signal=signal,
        unit=unit,
        order=np.arange(1, count + 1),
        amplitude=2.0 * np.abs(fit.coefficient),
        standard=fit.standard,
        mean=fit.mean,
        revolutions=coverage.revolutions,
        method=method,
        uncertainty_source=fit.uncertainty_source,
        basis=replace(
            basis or Basis(len(values)),
            window=f"by angle, {coverage.revolutions:.4g} mechanical revolutions",
            harmonics=count,
        ),
    )


def _noise_between(amplitude: NDArray[np.float64], turns: int, count: int) -> NDArray[np.float64]:
    """Standard deviation of one component of the noise near each order, shape (count,)."""
    between = np.flatnonzero(np.arange(len(amplitude)) % turns)
    reach = max(turns // 2, _NEIGHBOURS)
    first = np.searchsorted(between, np.arange(1, count + 1) * turns - reach)
    last = np.searchsorted(between, np.arange(1, count + 1) * turns + reach, side="right")
    medians = [float(np.median(amplitude[between[a:b]])) for a, b in zip(first, last, strict=True)]
    return np.array(medians) / _MEDIAN_OF_RAYLEIGH
