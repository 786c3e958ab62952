"""Whether the last lobe of a curve that rings leaves a band, which noise alone may decide.

Where a lobe is about as high as the band is wide, the curve enters it finally before the lobe or behind it.
The curve has noise already, and the greatest of a lobe is raised by it: what is drawn about the curve has the
noise twice, so that a lobe which noise has lifted out of the band is hardly ever drawn within.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.passages import last_passage

Floats = NDArray[np.float64]

_OF_BOTH = math.sqrt(2.0)  # times the noise of the curve: that of a draw, too
_SURE = 2.0  # standard deviations by which the curve is further within the band between two lobes


def rms_beyond_lobes(
    away: Floats, errors: Floats, standard: Floats, band: float, place: float, drawn: Floats
) -> float:
    """Return the rms distance from a `place` of final entries into the band that are in other lobes, over all
    draws, by how much larger it is for the noise of both the curve and a draw than for that of a draw.

    The curve is so far `away`, shape (n,), from the level amid the band; `errors`, shape (draws, n), of this
    `standard` deviation, are what noise makes of it, and `drawn`, shape (draws,), where each of them makes it
    enter, nan where it does not. The band is wider by what the noise of both lifts the greatest of the last
    lobe.
    """
    apart = _beside_other_lobes(away, standard, band, place)
    if not np.any(apart):
        return 0.0
    lifted = band + (1.0 + _OF_BOTH) * _lift(away, errors, place)
    found = (last_passage(each, 0.0, lifted) for each in away + _OF_BOTH * errors)
    of_both = np.array([math.nan if each is None else each.place for each in found])
    return math.sqrt(max(0.0, _square(of_both, place, apart) - _square(drawn, place, apart)))


def _square(drawn: Floats, place: float, apart: NDArray[np.bool_]) -> float:
    """Return the mean square distance of final entries, where they are apart by lobes."""
    places = np.where(np.isnan(drawn), place, drawn)
    before, behind = (each(places).astype(np.int64) for each in (np.floor, np.ceil))
    return float(np.mean(np.where(apart[before] | apart[behind], (places - place) ** 2, 0.0)))


def _beside_other_lobes(away: Floats, standard: Floats, band: float, place: float) -> NDArray[np.bool_]:
    """Return which rows are behind or before a trough within the band, seen from a place."""
    size, at = np.abs(away), _row_before(place, len(away))
    troughs = np.concatenate([np.minimum.accumulate(size[at::-1])[:0:-1], np.minimum.accumulate(size[at:])])
    return np.asarray(np.minimum(size, band) - troughs > _SURE * standard)


def _lift(away: Floats, errors: Floats, place: float) -> float:
    """Return by how much noise raises the greatest of the lobe that ends at a place."""
    last = _row_before(place, len(away))
    beyond_zero = np.flatnonzero(away[:last] * away[last] < 0.0)
    lobe = slice(int(beyond_zero[-1]) + 1 if len(beyond_zero) else 0, last + 1)
    raised = np.max(np.abs(away[lobe] + errors[:, lobe]), axis=1)
    return max(0.0, float(np.mean(raised) - np.max(np.abs(away[lobe]))))


def _row_before(place: float, count: int) -> int:
    return min(max(math.ceil(place) - 1, 0), count - 1)
