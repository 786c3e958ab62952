"""The course by which a noisy curve settles, without what noise alone makes of it at rest.

A draw about a noisy curve has the noise twice: at rest it leaves a band far more often than noise does once.
Once the curve is in the band for good it is therefore taken to fall towards its level and nowhere to rise
again, as far as it is within the noise of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SURE = 2.0  # standard deviations beyond the band, or within it, for no lobe to be made or hidden by noise
_AS_LONG = 2.0  # times as long as until then: what rings has its next lobe sooner
_OF_NOISE = 0.95  # of the draws whose greatest deviation is less: what noise alone makes of many rows


@dataclass(frozen=True)
class SettledCourse:
    """How a curve settles within `band` of a level, from row `last` on, where it was surely beyond.

    `standard`, shape (n,), is the standard uncertainty of the curve; in that row it is above the level times
    `sign`. Until row `soon` it may still ring: `most_soon` standard deviations are what noise makes there,
    and `most_late` afterwards.
    """

    band: float
    standard: Floats
    last: int
    soon: int
    sign: float
    most_soon: float
    most_late: float

    @classmethod
    def of(cls, away: Floats, errors: Floats, standard: Floats, band: float, since: int) -> SettledCourse:
        """Return that of a curve so far `away` from the level, shape (n,), after a step or fall in the row
        `since`; noise makes these `errors` of it, shape (draws, n), of the `standard` deviation, shape
        (n,)."""
        relative = np.abs(errors) / np.maximum(standard, np.finfo(np.float64).tiny)

        def most(rows: slice) -> float:
            if rows.start >= rows.stop:
                return _SURE
            return max(_SURE, float(np.quantile(np.max(relative[:, rows], axis=1), _OF_NOISE)))

        def soon_after(last: int) -> int:
            return min(len(away), last + 1 + round((_AS_LONG - 1.0) * max(0, last - since)))

        # of many rows at rest noise takes some beyond the band, too: those are far from all that it does not
        last = _last(np.abs(away) >= band + most(slice(0, len(away))) * standard)
        near = soon_after(last)
        last = max(last, _last(np.abs(away[:near]) >= band + _SURE * standard[:near]))
        soon = soon_after(last)
        sign = -1.0 if away[last] < 0.0 else 1.0
        return cls(band, standard, last, soon, sign, most(slice(last, soon)), most(slice(soon, len(away))))

    def without_noise(self, away: Floats) -> Floats:
        """Return a course `away` from the level, shape (n,), where it is at rest without the noise: as the
        least-squares one that rises nowhere (isotonic regression: Barlow et al., Statistical Inference under
        Order Restrictions, 1972, 1.2).

        What noise does not make of that stays. So does a lobe on the other side of the level while it may
        ring, unless it is surely within the band.
        """
        return np.asarray(self.all_without_noise(away[np.newaxis])[0])

    def all_without_noise(self, away: Floats) -> Floats:
        """Return `without_noise` of many courses, shape (courses, n)."""
        from scipy import optimize  # takes longer than all else here

        rest, standard = self.sign * away[:, self.last :], self.standard[self.last :]
        falls = np.array([optimize.isotonic_regression(each, increasing=False).x for each in rest])
        is_soon = np.arange(self.last, away.shape[1]) < self.soon
        noise = np.where(is_soon, self.most_soon, self.most_late) * standard
        is_lobe = is_soon & (rest < _SURE * standard - self.band)
        course = np.where((np.abs(falls - rest) <= noise) & ~is_lobe, falls, rest)
        return np.concatenate([away[:, : self.last], self.sign * course], axis=1)

    def leaves_late(self, course: Floats) -> bool:
        """Return whether a course `without_noise`, shape (n,), leaves the band again once it rings no longer:
        by more than noise makes in most records, and by less than all of it."""
        beyond = np.abs(course[self.soon - 1 :]) > self.band
        return bool(np.any(beyond[1:] > beyond[:-1]))

    def with_rises(self, course: Floats, away: Floats) -> Floats:
        """Return a course `without_noise`, shape (n,), that rises as the curve itself does while it may still
        ring: within the noise an answer that creeps and rings at once does so as well."""
        return np.concatenate([away[: self.soon], course[self.soon :]])


def _last(beyond: NDArray[np.bool_]) -> int:
    """Return the last row, of shape (n,), that is beyond; 0 if none is."""
    return int(np.max(np.flatnonzero(beyond), initial=0))
