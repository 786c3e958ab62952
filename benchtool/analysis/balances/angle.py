"""The shaft's angle between the steps of its encoder: as smooth as these steps allow.

    minimise  sum (theta - measured)^2 + lambda sum (third difference of theta)^2

(E. T. Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63). The true angle is within half a step of every
count. The smoothest curve is looked for that is so as well, but for what its own noise takes it beyond; of
that one's smoothing a thirtieth is taken, because the largest that shows nothing already bends the fastest
motion. Each part of the record has its own: where dry friction stops a shaft its motion has a corner, which
says nothing of how smooth it is elsewhere.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.balances.space_vectors import Floats
from benchtool.analysis.quantisation.resolution import counting_step

_ORDER: Final = 3
_SMOOTHINGS: Final = 10.0 ** np.arange(1.0, 12.5, 0.5)
_LESS: Final = 3  # of them
_BEYOND, _SHARE_BEYOND = 0.55, 5e-3  # of a step; of the samples
_AROUND: Final = 200  # rows about one that a corner of the motion takes beyond
_CHUNK: Final = 1 << 17  # rows at a time
_FEWEST: Final = 4 * _ORDER


def smooth_angle(theta_m: Floats) -> Floats:
    """Return the mechanical angle, shape (n,), without jumps of a revolution, between the encoder's steps.

    Of an angle without steps, or of a few samples, it is the angle itself.
    """
    angle = np.unwrap(theta_m)
    step = counting_step(theta_m)
    if step == 0.0 or len(angle) < _FEWEST:
        return angle
    parts = max(1, round(len(angle) / _CHUNK))
    return np.concatenate([_smooth(part, step) for part in np.array_split(angle, parts)])


def _smooth(angle: Floats, step: float) -> Floats:
    """Return the smooth curve through the samples of an encoder of this step."""
    from scipy import ndimage

    rows = np.arange(len(angle))
    # third differences leave a parabola alone, whose size would be that of the rounding
    even = Polynomial.fit(rows, angle, _ORDER - 1)(rows)
    uneven = angle - even
    width = min(_AROUND, len(angle))
    smoothest = np.zeros(len(angle), dtype=np.int64)  # by its number, from one on; zero is none
    goes_on, is_whole = np.ones(len(angle), dtype=bool), True
    for number in range(1, len(_SMOOTHINGS) + 1):
        beyond = np.abs(_curve(uneven, np.where(goes_on, number, smoothest)) - uneven) > _BEYOND * step
        is_whole = is_whole and float(np.mean(beyond)) <= _SHARE_BEYOND
        if not is_whole:
            share = ndimage.uniform_filter1d(beyond.astype(np.float64), width, mode="nearest")
            goes_on &= ndimage.maximum_filter1d(share, width, mode="nearest") <= _SHARE_BEYOND
        if not np.any(goes_on):
            break
        smoothest[goes_on] = number
    return np.asarray(even + _curve(uneven, smoothest - _LESS))


def _curve(uneven: Floats, numbers: NDArray[np.int64]) -> Floats:
    """Return the curve with the smoothing of these numbers, shape (n,); below one, there is none."""
    from scipy.linalg import solveh_banded

    if not np.any(numbers > 0):
        return uneven
    smoothing = np.where(numbers > 0, _SMOOTHINGS[np.maximum(numbers, 1) - 1], 0.0)
    bands = _squared_differences(smoothing)
    bands[-1] += 1.0
    return np.asarray(solveh_banded(bands, uneven))


def _squared_differences(smoothing: Floats) -> Floats:
    """Return D^T S D of the third differences, with the smoothing of each row, shape (n,), as upper bands,
    shape (4, n)."""
    weights = np.array([-1.0, 3.0, -3.0, 1.0])
    inner = len(smoothing) - _ORDER
    # a difference over rows of two smoothings has the lesser
    of_difference = np.minimum.reduce([smoothing[k : k + inner] for k in range(_ORDER + 1)])
    bands = np.zeros((_ORDER + 1, len(smoothing)))
    for first in range(_ORDER + 1):
        for second in range(first, _ORDER + 1):
            row = _ORDER - (second - first)
            bands[row, second : second + inner] += weights[first] * weights[second] * of_difference
    return bands
