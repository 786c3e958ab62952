"""Delay of a response: the slope of the line of its phase between two frequencies that are its own.

The line that fits the phase of a lag depends on where it begins and ends, and on which frequencies count in
between: what noise leaves, or which lines are played, is no property of the response. It is that of the phase
at all frequencies alike, interpolated between those that are known, from a tenth of the bandwidth up to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.responses.response_curve import Point
from benchtool.analysis.uncertainty import Uncertainty

Floats = NDArray[np.float64]

_FROM = 0.1  # of the upper frequency
_FEWEST_FOR_A_LINE = 3
_HIGHER = 5  # degree of the splines that tell how far cubic ones are off
_BESIDE = 8  # frequencies beyond either end that an interpolation takes: splines end badly
_FINE, _FINER = 2_000, 4  # places over which the line is fitted, at least, and for each frequency


@dataclass(frozen=True)
class _Slope:
    """Slope of a phase over frequency, rad per Hz, its standard uncertainty by that of the phase, and what
    another interpolation differs by."""

    value: float
    standard: float
    between: float


def response_delay(
    frequency_Hz: Floats, gain: Floats, phase: Floats, error: Floats, bandwidth: Point | None, basis: Basis
) -> Measurement:
    """Return -1 / (2 pi) times the slope of the least-squares line of the phase over frequency, by gains and
    phases of shape (n,), these in rad, and their standard uncertainties as if uncorrelated.

    The line need not pass through zero at dc. Without a bandwidth it ends at the last frequency; where the
    lowest frequency is above a tenth of the upper end it begins there.
    """
    upper_Hz = float(frequency_Hz[-1]) if bandwidth is None else bandwidth.frequency_Hz
    lower_Hz = _lower(frequency_Hz, upper_Hz)
    begin = "the lowest frequency used" if lower_Hz == frequency_Hz[0] else "a tenth of that"
    end = "the highest frequency used" if bandwidth is None else "bandwidth_3dB"
    text = (
        f"-1/(2 pi) x slope of the least-squares line of phase over frequency, all frequencies alike, up to "
        f"{end} from {begin}, here from {raw(lower_Hz, 6)} Hz to {raw(upper_Hz, 6)} Hz"
    )
    count = int(np.count_nonzero((frequency_Hz >= lower_Hz) & (frequency_Hz <= upper_Hz)))
    if count < _FEWEST_FOR_A_LINE:
        reason = f"{count} frequencies between, at least {_FEWEST_FOR_A_LINE} are needed"
        return Measurement.undefined("response_delay", "s", text, reason, basis)
    slope = _slope(frequency_Hz, gain, phase, error, upper_Hz)
    of_end = 0.0
    if bandwidth is not None:
        ends = (min(upper_Hz + side * bandwidth.standard_Hz, float(frequency_Hz[-1])) for side in (-1.0, 1.0))
        low, high = (_slope(frequency_Hz, gain, phase, error, each).value for each in ends)
        of_end = 0.5 * (high - low)
    standard = math.hypot(slope.standard, slope.between, of_end) / (2.0 * math.pi)
    uncertain = Uncertainty(standard, "random error of the response, of the phase, and that of the upper end")
    return Measurement(
        "response_delay",
        -slope.value / (2.0 * math.pi),
        "s",
        text,
        basis,
        uncertain,
    )


def _lower(frequency_Hz: Floats, upper_Hz: float) -> float:
    return max(_FROM * upper_Hz, float(frequency_Hz[0]))


def _slope(frequency_Hz: Floats, gain: Floats, phase: Floats, error: Floats, upper_Hz: float) -> _Slope:
    """Return the slope of the line of the phase, at all frequencies alike, from a tenth of a frequency up to
    it."""
    lower_Hz = _lower(frequency_Hz, upper_Hz)
    first, last = np.searchsorted(frequency_Hz, [lower_Hz, upper_Hz]).tolist()
    near = slice(max(0, first - _BESIDE), last + _BESIDE)
    known_Hz, gain, phase, error = frequency_Hz[near], gain[near], phase[near], error[near]
    places = max(_FINE, _FINER * len(known_Hz))
    turned = float(np.polyfit(known_Hz - lower_Hz, phase, 1)[0])
    fine_Hz: Floats = lower_Hz + (upper_Hz - lower_Hz) / places * (np.arange(places, dtype=np.float64) + 0.5)
    across = fine_Hz - np.mean(fine_Hz)
    weights = np.asarray(across / float(across @ across), dtype=np.float64)
    smooth, other = min(
        (_by_reciprocals(known_Hz, gain, phase, fine_Hz, weights, less) for less in (0.0, turned)),
        key=lambda both: abs(both[1] - both[0]),
    )
    # what each of the phases counts, between neighbours along straight lines
    after = np.clip(np.searchsorted(known_Hz, fine_Hz), 1, len(known_Hz) - 1)
    share = (fine_Hz - known_Hz[after - 1]) / (known_Hz[after] - known_Hz[after - 1])
    counts = np.bincount(after - 1, weights * (1.0 - share), len(known_Hz))
    counts += np.bincount(after, weights * share, len(known_Hz))
    return _Slope(smooth, float(np.linalg.norm(counts * error)), other - smooth)


def _by_reciprocals(
    known_Hz: Floats, gain: Floats, phase: Floats, fine_Hz: Floats, weights: Floats, turned: float
) -> tuple[float, float]:
    """Return the slope of the phase, as the sum of the phases at finer frequencies times their weights, by
    a cubic spline of the reciprocal of the response, and by the nearest of others.

    About a resonance that is a parabola, whatever its phase does. A delay turns it between few frequencies:
    so much phase per Hz is taken off before.
    """
    from scipy import interpolate  # draws in scipy.stats, which takes longer than all else here

    phase = phase - turned * known_Hz
    reciprocal = np.stack([np.cos(phase) / gain, -np.sin(phase) / gain], axis=1)
    along = np.interp(fine_Hz, known_Hz, phase)
    interpolations: list[Callable[[Floats], Floats]] = [
        interpolate.CubicSpline(known_Hz, reciprocal),
        interpolate.Akima1DInterpolator(known_Hz, reciprocal),
    ]
    if len(known_Hz) > _HIGHER:
        interpolations.append(interpolate.make_interp_spline(known_Hz, reciprocal, _HIGHER))
    cubic, *others = (
        turned + float(weights @ (along + _turned(each(fine_Hz), along))) for each in interpolations
    )
    # of noise the higher order makes more than of a smooth course, and Akima's less
    return cubic, min(others, key=lambda other: abs(other - cubic))


def _turned(reciprocal: Floats, along: Floats) -> Floats:
    """Return by how much the phase of what has these reciprocals, shape (n, 2), is ahead of another, (n,)."""
    return np.asarray(np.angle(np.exp(-1j * along) * (reciprocal[:, 0] - 1j * reciprocal[:, 1])))
