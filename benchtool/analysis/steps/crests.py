"""Whether a crest on the way up passes a level, which noise alone may decide.

Where a crest is about as high as a level, the curve first passes that at the crest or behind it. The curve
has noise already, and the greatest of a crest is raised by it: what is drawn about the curve has the noise
twice, so that a crest which noise has lifted over the level is hardly ever drawn below it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.passages import Crossing, first_passages, places_of

Floats = NDArray[np.float64]

_OF_BOTH = math.sqrt(2.0)  # times the noise of the curve: that of a draw, too
_SURE = 2.0  # standard deviations by which the curve is further below the level between two crests


def rms_beyond_crests(
    above: Floats, course: Floats, errors: Floats, standard: Floats, place: float, drawn: Floats
) -> float:
    """Return the rms distance from a `place` of first passages behind the crest at which a curve passes a
    level there, over all draws, by how much larger it is for the noise of both the curve and a draw than for
    that of a draw.

    The curve is so far `above` the level, shape (n,), and draws begin from its `course`; `errors`, shape
    (draws, n), of this `standard` deviation, are what noise makes of it, and `drawn`, shape (draws,), where
    each of them first passes the level, nan where it does not. The level is higher by what the noise of both
    lifts the greatest of the crest. A crest before the place, which the curve does not pass, is as often
    passed as draws are.
    """
    passed = np.flatnonzero(above[_row_before(place, len(above)) :] >= 0.0)
    if not len(passed):
        return 0.0
    first = _row_before(place, len(above)) + int(passed[0])
    apart = _behind_troughs(above, standard, first)
    apart[:first] = False
    behind = np.flatnonzero(apart)
    if not len(behind):
        return 0.0
    crest = slice(first, int(behind[0]))
    lifted = _lifted(above[crest], errors[:, crest])
    return _of_both(
        lambda curves: first_passages(curves - lifted, _SURE * standard),
        course,
        errors,
        apart,
        place,
        drawn,
    )


def _of_both(
    passed: Callable[[Floats], list[Crossing | None]],
    course: Floats,
    errors: Floats,
    apart: NDArray[np.bool_],
    place: float,
    drawn: Floats,
) -> float:
    """Return the rms distance from a place of passages that are apart by troughs, for the noise of both curve
    and draw, beyond that for the noise of a draw."""
    of_both = places_of(passed(course + _OF_BOTH * errors))
    return math.sqrt(max(0.0, _square(of_both, place, apart) - _square(drawn, place, apart)))


def _square(drawn: Floats, place: float, apart: NDArray[np.bool_]) -> float:
    """Return the mean square distance of passages, where they are apart by troughs."""
    places = np.clip(np.where(np.isnan(drawn), place, drawn), 0.0, len(apart) - 1.0)
    before, behind = (each(places).astype(np.int64) for each in (np.floor, np.ceil))
    return float(np.mean(np.where(apart[before] | apart[behind], (places - place) ** 2, 0.0)))


def _behind_troughs(above: Floats, standard: Floats, at: int) -> NDArray[np.bool_]:
    """Return which rows of a curve, so far above a level, are behind or before a trough below it, seen from
    a row."""
    troughs = np.concatenate([np.minimum.accumulate(above[at::-1])[:0:-1], np.minimum.accumulate(above[at:])])
    return np.asarray(np.minimum(above, 0.0) - troughs > _SURE * standard)


def _lifted(crest: Floats, errors: Floats) -> float:
    """Return by how much the noise of both curve and draw raises the greatest of a crest, shape (n,)."""
    raised = float(np.mean(np.max(crest + errors, axis=1)) - np.max(crest))
    return (1.0 + _OF_BOTH) * max(0.0, raised)


def _row_before(place: float, count: int) -> int:
    return min(max(math.ceil(place) - 1, 0), count - 1)
