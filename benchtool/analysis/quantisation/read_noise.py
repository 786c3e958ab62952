"""Noise of a value at rest, by where a converter reads it and how much its readings scatter, and what the
steps leave in their mean under that.

Of little noise the readings of a value in the middle between two levels scatter by half a step, and of one on
a level not at all: their variance alone does not tell it.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import noise_beside

Floats = NDArray[np.float64]

_RMS = np.geomspace(0.01, 1.0, 80)  # of noise, in steps: of more a reading has a twelfth of a square besides
_PLACES = np.linspace(0.0, 1.0, 201)  # of the value, from a level to the next
_LEVELS = np.arange(-6, 8)
_WHOLE = 0.01  # of a step
_FAR_STEPS, _FAR_SIGMAS = 2.0, 5.0  # from the median: noise that steps show in is hardly ever further
_WITHIN_SIGMA = 15.87, 84.13  # percentiles
_TWO_LEVELS, _AS_LIKELY = 1.5, 24  # steps from the least to the greatest; sizes of noise


def noise_of_readings(readings: Floats, step: float) -> float:
    """Return the rms of normal noise about a value whose `readings`, shape (n,), are whole steps apart: that
    with which both their mean and their variance are as they are. Of others, as about a reference that moves,
    the variance alone tells it. Few readings far from the others, of heavy tails or clicks, count as near:
    steps are in all others as without them."""
    readings = without_far(readings, step)
    on_average = noise_beside(float(np.var(readings)), step)
    if not step > 0.0:
        return on_average
    apart = (readings - readings[0]) / step
    level, variance = float(np.mean(apart)), float(np.var(apart))
    if np.max(np.abs(apart - np.round(apart))) > _WHOLE:
        return on_average
    place = level - math.floor(level)
    means, variances = _read()
    of_noise = np.array([np.interp(place, *each) for each in zip(means, variances, strict=True)])
    if not variance < of_noise[-1]:
        return on_average
    # of next to none the variance is that of two levels
    rises = np.maximum.accumulate(of_noise)
    return step * float(np.interp(variance, rises, _RMS, left=0.0))


def without_far(readings: Floats, step: float) -> Floats:
    """Return readings, shape (n,), none of them further from the median than two steps and than normal noise
    as wide as most of them is; as they are without steps."""
    if not step > 0.0:
        return readings
    low, median, high = np.percentile(readings, (_WITHIN_SIGMA[0], 50.0, _WITHIN_SIGMA[1])).tolist()
    reach = max(_FAR_STEPS * step, _FAR_SIGMAS * 0.5 * (high - low))
    return np.clip(readings, median - reach, median + reach)


def error_of_mean(readings: Floats, step: float) -> float:
    """Return the standard uncertainty that steps leave in the mean of `readings`, shape (n,), of a value at
    rest that may be anywhere between two levels, under the noise that these show.

    Readings of two levels alone are of a value near the edge between them, under noise of any rms up to that.
    Their mean is off by what it is there; of more noise a value is as much more likely near an edge.
    """
    means, _ = _read()
    off, noise = means - _PLACES, noise_of_readings(readings, step) / step
    if float(np.ptp(readings)) > _TWO_LEVELS * step:
        return step * float(np.interp(noise, _RMS, np.sqrt(np.mean(off**2, axis=1)), right=0.0))
    level = float(np.mean(readings - readings[0])) / step
    here = np.array([np.interp(level - math.floor(level), *each) for each in zip(means, off, strict=True)])
    as_likely = noise * np.sqrt((np.arange(_AS_LIKELY) + 0.5) / _AS_LIKELY)
    return step * float(np.sqrt(np.mean(np.interp(as_likely, _RMS, here) ** 2)))


@cache
def _read() -> tuple[Floats, Floats]:
    """Return mean and variance of the readings of values at all places under noise of every rms, in steps,
    both of shape (rms, places)."""
    from scipy.special import ndtr  # takes long to load

    above = (_LEVELS + 0.5 - _PLACES[:, np.newaxis]) / _RMS[:, np.newaxis, np.newaxis]
    share = np.diff(ndtr(above), axis=-1, prepend=0.0)
    mean = share @ _LEVELS
    return mean, share @ _LEVELS**2 - mean**2
