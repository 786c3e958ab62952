"""The shaft's angle between the steps of its encoder: as smooth as these steps allow.

    minimise  sum (theta - measured)^2 + lambda sum (third difference of theta)^2

(E. T. Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63). The true angle is within half a step of every
count. The smoothest curve is looked for that is so as well, but for what its own noise takes it beyond; of
that one's smoothing a thirtieth is taken, because the largest that shows nothing already bends the fastest
motion.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.polynomial import Polynomial

from benchtool.analysis.balances.space_vectors import Floats
from benchtool.analysis.quantisation.resolution import counting_step

_ORDER: Final = 3
_SMOOTHINGS: Final = 10.0 ** np.arange(1.0, 12.5, 0.5)
_LESS: Final = 3  # of them
_BEYOND, _SHARE_BEYOND = 0.55, 5e-3  # of a step; of the samples
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
    from scipy.linalg import solveh_banded

    rows = np.arange(len(angle))
    # third differences leave a parabola alone, whose size would be that of the rounding
    even = Polynomial.fit(rows, angle, _ORDER - 1)(rows)
    differences = _squared_differences(len(angle))
    curves = [angle] * (_LESS + 1)
    for smoothing in _SMOOTHINGS:
        bands = smoothing * differences
        bands[-1] += 1.0
        curve = even + solveh_banded(bands, angle - even)
        if float(np.mean(np.abs(curve - angle) > _BEYOND * step)) > _SHARE_BEYOND:
            break
        curves.append(curve)
    return curves[-1 - _LESS]


def _squared_differences(rows: int) -> Floats:
    """Return D^T D of the third differences as upper bands, shape (4, rows)."""
    weights = np.array([-1.0, 3.0, -3.0, 1.0])
    bands = np.zeros((_ORDER + 1, rows))
    inner = rows - _ORDER
    for first in range(_ORDER + 1):
        for second in range(first, _ORDER + 1):
            row = _ORDER - (second - first)
            bands[row, second : second + inner] += weights[first] * weights[second]
    return bands
