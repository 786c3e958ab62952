"""Lines about a fundamental: sidebands of its swing, or no part of it.

Where the fundamental swings, so do its harmonics: lines are as far below and above one of these as about the
fundamental. Amplitude and phase may swing so that one of its own sidebands is small, or gone. Lines that are
merely near it, as of another motor on the supply, have no such counterparts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

_WITHIN = 0.5  # bins
_NEAR, _LEAK = 1.0, 2.0  # cycles in a period
_ABOUT = 2.0  # times a size
_FAST = 0.5  # cycles in a period: a line halfway to a harmonic is as far from that


def off_by_lines(orders: Floats, sizes: Floats, harmonics: Floats, periods: float) -> tuple[bool, float]:
    """Return whether lines tell that the fundamental swings within few periods, and the size of the largest
    line about it that is no sideband, by which means over periods are off.

    Args:
        orders: where the lines are, cycles in a period, shape (lines,).
        sizes: their amplitudes, shape (lines,), relative to the fundamental.
        harmonics: amplitudes from the fundamental on, shape (orders,), relative to it.
        periods: of the record: a bin is one of as many parts of a cycle in a period.
    """
    within = _WITHIN / periods
    of_order = np.arange(1.0, len(harmonics) + 1.0)

    def has_both_sidebands(apart: float) -> bool:
        """Return whether lines are so far from a harmonic that is larger, on both sides."""
        is_sideband = [
            (np.abs(np.subtract.outer(of_order + side * apart, orders)) < within)
            & (sizes < harmonics[:, np.newaxis])
            for side in (-1.0, 1.0)
        ]
        below, above = (np.any(each, axis=1) for each in is_sideband)
        return bool(np.any((below & above)[1:]))

    aparts = np.abs(orders - 1.0)
    swings = np.array([each for each in aparts[aparts < _NEAR] if has_both_sidebands(float(each))])
    from_harmonics = np.abs(np.subtract.outer(of_order, orders))
    # a phase that swings far has sidebands at twice the distance as well
    at = np.concatenate([swings, 2.0 * swings])
    of_swing = np.min(np.abs(np.subtract.outer(at, from_harmonics)), axis=0, initial=np.inf) < within
    is_sideband = np.any(of_swing & (sizes < harmonics[:, np.newaxis]), axis=0)
    if len(swings):  # a track that follows phases of periods has it at another frequency, on both sides
        is_sideband |= _has_counterpart(orders - 1.0, sizes, within)
    alone = float(np.max(sizes[(aparts < _LEAK) & ~is_sideband], initial=0.0))
    return len(swings) > 0, alone


def _has_counterpart(apart: Floats, sizes: Floats, within: float) -> Bools:
    """Return whether lines have others as far on the other side, about as large, shape (lines,)."""
    is_other_side = np.abs(np.add.outer(apart, apart)) < within
    is_as_large = np.maximum.outer(sizes, sizes) < _ABOUT * np.minimum.outer(sizes, sizes)
    return np.asarray(np.any(is_other_side & is_as_large, axis=0))


def may_be_swing(orders: Floats, sizes: Floats, periods: float) -> bool:
    """Return whether lines, as of `off_by_lines`, are as far below and above the fundamental, and farther
    than half its frequency, so that they may be a swing of it, or of it alone."""
    within = _WITHIN / periods
    apart = orders - 1.0
    is_fast = (np.abs(apart) > _FAST + within) & (np.abs(apart) < _NEAR) & (sizes < 1.0)
    of_fast = apart[is_fast]
    return bool(np.any(np.abs(np.add.outer(of_fast, of_fast)) < within))
