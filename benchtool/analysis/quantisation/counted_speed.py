"""A speed that is read by how far a counter has come since the row before.

Such a reading is a whole number of counts, as that of a converter is of steps. It is off by the rounding of
two positions, though, and what one reads too much the next reads too little: the sum of many readings is off
by one count, however many they are, while the sum of readings that are rounded each by itself wanders, with
whatever noise they have.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.counted_line import least_spread

Floats = NDArray[np.float64]

_WHOLE = 0.01  # of a count
_OFF = 1.5  # counts by which a counter is off a line, one by itself and the rest by a shaft that shakes
_MOST = 0.55  # counts: half of one, and a tenth more
_BY_CHANCE = 0.6  # of the deviation of a sum: one in 10^5 wanders by no more (Kuiper's distribution)


def is_counted(pieces: Iterable[Floats], step: float) -> bool:
    """Return whether readings at constant speed, `pieces` of shape (n,), are differences of whole counts,
    each worth a `step`: those of every piece that tells, and of one at least."""
    told = [_is_off_by_a_count(each / step) for each in pieces if step > 0.0 and _tells(each / step)]
    return bool(told) and all(told)


def covariance_of_counts(step: float) -> Floats:
    """Return the autocovariance of readings about the speed, at lags 0 and 1: that of a difference of two
    positions, each anywhere within its count."""
    return step**2 * np.array([1.0 / 6.0, -1.0 / 12.0])


def most_of_counts(step: float) -> float:
    """Return the greatest rms that differences of counts have about a constant speed, half way between two
    numbers of counts, with as much beside it as nothing tells."""
    return _MOST * step


def _tells(counts: Floats) -> bool:
    """Return whether a sum of as many independent readings would wander further than a counter is off."""
    if len(counts) == 0 or np.max(np.abs(counts - np.round(counts))) > _WHOLE:
        return False
    return _BY_CHANCE * math.sqrt(len(counts) * float(np.var(counts))) > _OFF


def _is_off_by_a_count(counts: Floats) -> bool:
    come = np.cumsum(np.round(counts))
    return least_spread(come, np.arange(len(come), dtype=np.float64)).spread < _OFF
