"""Gain of a frequency response continued to zero frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.numbers import raw
from benchtool.analysis.responses.rational_fit import RationalFit, rational_fit

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]

_ORDERS = (0, 0), (0, 1), (0, 2), (1, 2), (1, 3), (2, 3), (2, 4), (3, 4)
"""Zeros and poles of the fits, each with all those of the one before."""

_FEWEST, _LONGER = 3, 1.5
_FITS = 2.0  # standard deviations of the mean squared residual above 1: a fit that describes its points
_CLEARLY = 3.0  # standard deviations of a normal value that is as rare as what a piece leaves: there are many
_FAR_OFF, _FEWEST_FREE = 5.0, 8.0  # mean square, and degrees of freedom: of more points it is off by more
_ABOUT_AS_SURE = 2.0  # times the uncertainty
_MISSED = 2  # counts in a row: one may be by chance
_DETERMINED = 0.5  # largest relative uncertainty of a gain
_OF_UNKNOWN = 2.0  # squares, by which an unknown is expected to improve a fit to other points
_LEAST_ERROR = 1e-9  # least error, so that a fit of exact values has weights
_HALF_POWER = math.sqrt(0.5)
_SURE = 0.2  # largest relative uncertainty of a gain that says something


@dataclass(frozen=True)
class GainAtRest:
    """Gain of a response at zero frequency and its standard uncertainty relative to it.

    `undefined_because` is the reason why it is undefined, empty where it is not; `goes_on` tells that it
    changes by more than 3 dB below the lowest frequency, where the phase changes with it.
    """

    gain: float
    relative_error: float
    undefined_because: str = ""
    goes_on: bool = False


@dataclass(frozen=True)
class _Answer:
    """`missed` is the least mean square by which a ratio misses the points, in units of their variance."""

    value: float
    standard: float
    describes: bool
    missed: float


def gain_at_rest(
    frequency_Hz: Floats, response: Complex, error: Floats, shared: Floats | None = None
) -> GainAtRest:
    """Return the gain continued to zero frequency, from responses of shape (n,), rising in frequency, whose
    gain and phase have the relative standard uncertainties `error` as if uncorrelated; `shared` of them each
    tell as much as one, all different ones without it.

    A response is a ratio of polynomials of s = j 2 pi f with real coefficients, and its phase tells of a slow
    pole or zero, as of a controller with an integral part, at frequencies where the gain is level already.
    Such ratios are fitted to the lowest frequencies, to more and more of them. The answer of each is the
    mean over the orders, by how well they describe the points for the unknowns that they have; the most
    certain answer of those that describe theirs counts. By as much as it differs from such of fewer points
    that are about as certain, beyond chance, it is more uncertain. Where no ratio describes its points, the
    lowest gain stands for it, as far off as a parabola through it and the next is at zero frequency, and as
    the ratio is that misses its points least.

    It is undefined where it is 3 dB off the lowest gain, as of a machine whose slow pole is below the
    frequencies that are played, and where it is uncertain by a fifth. A slow pole and a zero that nearly
    cancel each other show only about their own frequency: below the lowest no error tells of them.
    """
    found = _continued(frequency_Hz, response, error, shared)
    lowest, lowest_Hz = abs(complex(response[0])), float(frequency_Hz[0])
    reason, goes_on = "", not _HALF_POWER <= found.gain / lowest <= 1.0 / _HALF_POWER
    if goes_on:
        reason = (
            f"the gain is {raw(lowest, 3)} at {raw(lowest_Hz, 4)} Hz, the lowest frequency used, and goes on "
            f"to change below that: play lower frequencies"
        )
    elif found.relative_error > _SURE:
        percent = 100.0 * found.relative_error
        reason = f"it is uncertain by {raw(percent, 2)} %: play lower frequencies, or stronger ones"
    return replace(found, undefined_because=reason, goes_on=goes_on)


def _continued(frequency_Hz: Floats, response: Complex, error: Floats, shared: Floats | None) -> GainAtRest:
    """Return the gain by the answers of more and more points."""
    spread = np.maximum(error, _LEAST_ERROR) * np.abs(response)
    independent = np.cumsum(np.ones(len(response)) if shared is None else 1.0 / shared)
    count, counts, first = _FEWEST, [], 0
    answers, others = list[_Answer](), list[_Answer]()
    missed = 0
    while count <= len(response) and missed < _MISSED:
        counts.append(count)
        s = 1j * frequency_Hz[:count] / frequency_Hz[count - 1]
        powers = s[:, np.newaxis] ** np.arange(_ORDERS[-1][1] + 1)
        pieces = independent[np.array(counts) - 1]
        fits: list[RationalFit] = []
        for zeros, poles in _ORDERS[first:]:
            if zeros + poles + 1 >= 2.0 * pieces[-1] - 1.0:  # with more than a degree of freedom left
                break
            begin = fits[-1] if fits else None
            within = next((fit for fit in fits if (fit.zeros, fit.poles) == (zeros - 1, poles - 1)), None)
            of_points = powers, response[:count], spread[:count]
            fits.append(rational_fit(*of_points, zeros, poles, begin, within))
        if fits:
            answer = _mean(fits, counts, pieces)
            is_determined = answer.standard < _DETERMINED * abs(answer.value)
            if answer.describes and is_determined:
                answers.append(answer)
                missed = 0
            elif answers:
                missed += 1
            elif is_determined:
                others.append(answer)
        first += _far_off(fits, 2.0 * float(pieces[-1]))
        count = math.ceil(_LONGER * count)
    if answers:
        return _of_answers(answers)
    lowest = _lowest(frequency_Hz, np.abs(response), error)
    if not others:
        return lowest
    least = min(others, key=lambda each: each.missed)
    apart = abs(least.value) / lowest.gain - 1.0
    return replace(lowest, relative_error=math.hypot(lowest.relative_error, apart))


def _of_answers(answers: Sequence[_Answer]) -> GainAtRest:
    surest = min(range(len(answers)), key=lambda number: answers[number].standard)
    value, square = answers[surest].value, answers[surest].standard ** 2
    changed = [
        # the more certain of two differs by the difference of the variances (Hausman, Econometrica 46 (1978))
        (each.value - value) ** 2 - (each.standard**2 - square)
        for each in answers[:surest]
        if each.standard**2 < _ABOUT_AS_SURE**2 * square
    ]
    standard = math.sqrt(square + max([0.0, *changed]))
    return GainAtRest(abs(value), standard / abs(value))


def _lowest(frequency_Hz: Floats, gain: Floats, error: Floats) -> GainAtRest:
    if len(gain) < 2:
        return GainAtRest(float(gain[0]), float(error[0]))
    first, second = frequency_Hz[:2] ** 2
    apart = float(gain[1] / gain[0] - 1.0) * max(1.0, first / (second - first))
    return GainAtRest(float(gain[0]), math.hypot(float(error[0]), apart))


def _far_off(fits: Sequence[RationalFit], values: float) -> int:
    """Return how many of the lowest orders miss so many independent values by far."""
    number = 0
    for each in fits[:-1]:
        freedom = values - each.unknowns
        if freedom < _FEWEST_FREE or float(np.sum(each.squares)) < _FAR_OFF * freedom:
            break
        number += 1
    return number


def _mean(fits: Sequence[RationalFit], counts: Sequence[int], pieces: Floats) -> _Answer:
    """Return the mean of the values at rest of fits of several orders, by how well they describe the points.

    The lowest `counts` of points are so many independent `pieces`, of two components each, the last of these
    all. The best fit describes them if it misses no such piece by more than chance: many points far above
    would hide that. Weights by Akaike (IEEE Trans. Autom. Control 19 (1974) 716), which miss fewer slow poles
    than those of Schwarz (Annals of Statistics 6 (1978) 461), variance within and between the fits (Hoeting,
    Madigan, Raftery and Volinsky, Statistical Science 14 (1999) 382, equations 1 to 3).
    """
    values = 2.0 * pieces
    unknowns = np.array([each.unknowns for each in fits])
    at_rest, variances = np.array([[each.at_rest, each.variance] for each in fits]).T
    squares = np.array([float(np.sum(each.squares)) for each in fits])
    freedom = values[-1] - unknowns
    scatter = max(1.0, float(np.min(squares / freedom)))
    criterion = squares / scatter + _OF_UNKNOWN * unknowns
    best = int(np.argmin(criterion))
    weights = np.exp(-0.5 * (criterion - criterion[best]))
    weights /= np.sum(weights)
    mean = float(weights @ at_rest)
    variance = float(weights @ (scatter * variances + (at_rest - mean) ** 2))
    # quantile of chi squared (Wilson and Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684)
    ninth = 2.0 / (9.0 * values)
    of_pieces = np.cumsum(fits[best].squares)[np.array(counts) - 1]
    misses = bool(np.any(of_pieces > values * (1.0 - ninth + _CLEARLY * np.sqrt(ninth)) ** 3))
    close = squares[best] / freedom[best] <= 1.0 + _FITS * math.sqrt(2.0 / freedom[best])
    # the last that so few points allow follows them whatever they are
    is_last = best == len(fits) - 1
    describes = close and not misses and not is_last and variance > 0.0
    standard = math.sqrt(variance) if variance > 0.0 else math.inf
    return _Answer(mean, standard, describes, float(np.min(squares / freedom)))
