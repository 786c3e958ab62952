"""How much the mean speed of another record differs, by how the phase wanders within this one."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.scatter import MeanError

_MOST_VALUES = 4096
_FEWEST_VALUES = 6
_FITTED = 3  # unknowns of a quadratic
_LAG, _LAGS = 12, 2  # a lag is a twelfth of the record, the shorter one half of that
_STEADIEST, _LOOSEST = 1.0, 2.0  # how much faster the mean square grows than not at all, or in proportion


def wander_of_difference(phase_rad: NDArray[np.float64]) -> MeanError:
    """Return the standard deviation, over records, of the phase from the first to the last value, rad.

    `phase_rad`, shape (n,), are phases at equal times. What a quadratic leaves of them is rms sigma: of a
    phase that a control holds on to a constant speed the difference of its ends scatters by sqrt(2) sigma. Of
    one that it lets go, because the speed itself wanders, the mean square of differences grows with the time
    between them: from a twenty-fourth to a twelfth of the record by a factor of 1 (held) to 2 (random walk
    of the phase), which is continued to the whole of it. A speed that keeps its value for longer than that
    does not show in one record. nan with fewer than six values.
    """
    step = max(1, len(phase_rad) // _MOST_VALUES)
    phase_rad = phase_rad[::step]
    count = len(phase_rad)
    if count < _FEWEST_VALUES:
        return MeanError(math.nan, math.nan)
    number = np.arange(count, dtype=np.float64)
    left = phase_rad - Polynomial.fit(number, phase_rad, 2)(number)
    freedom = float(count - _FITTED)
    held = 2.0 * float(left @ left) / freedom
    lag = count // _LAG
    if lag < _LAGS:
        return MeanError(math.sqrt(held), freedom)
    longer, shorter = _mean_square(left, lag), _mean_square(left, lag // _LAGS)
    growth = min(max(longer / shorter, _STEADIEST), _LOOSEST) if shorter > 0.0 else _STEADIEST
    let_go = longer * growth ** math.log2(_LAG)
    return MeanError(math.sqrt(max(held, let_go)), min(freedom, 0.5 * _LAG))


def _mean_square(values: NDArray[np.float64], lag: int) -> float:
    return float(np.mean((values[lag:] - values[:-lag]) ** 2))
