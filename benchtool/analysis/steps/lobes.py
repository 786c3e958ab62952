"""Which lobe of a curve that rings is the last to leave a band, which noise may decide.

Where a lobe is about as high as a band is wide, the curve enters that finally before the lobe or behind it.
Noise raises the greatest of a lobe, and a draw about the curve, which has the noise already, raises it twice.
The height of a lobe is therefore that of the parabola through its upper half, of the curve as of a draw; of a
polynomial of fourth degree where noise is so little that the lobe is seen to be no parabola. Where the lobes
are of one mode, the height of each follows from all of them. The lobe that is not chosen is as likely as
another record would show it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.decrement import of_one_mode
from benchtool.analysis.steps.passages import last_passage

Floats = NDArray[np.float64]

_SURE = 2.5  # standard deviations between a lobe and a trough beside it: noise alone hardly makes both
_UPPER = 0.5  # of the way from the higher of both troughs to the top
_DEGREE, _HIGHER = 2, 4  # of the curve through that, and of one where that is seen to be no parabola
_RAISED = 2.5  # standard deviations by which noise may raise the greatest of a lobe
_OF_BOTH = 1.7  # times the noise of the curve: sqrt(2) of two records, 1.2 by which rows are the upper half


@dataclass(frozen=True)
class Lobe:
    """Rows of a curve from one trough to before the next, and that of the greatest between both."""

    begin: int
    top: int
    end: int


@dataclass(frozen=True)
class Entries:
    """Where a curve enters a band finally: `expected` of all lobes that may leave that as the last one,
    behind the `likeliest` of them, and where draws do, shape (draws,), nan where one does not."""

    expected: float
    likeliest: float
    drawn: Floats


@dataclass(frozen=True)
class Lobes:
    """The `lobes` of a curve so far `away` from a level, shape (n,), the first of them where it begins."""

    away: Floats
    lobes: tuple[Lobe, ...]

    @classmethod
    def of(cls, away: Floats, standard: Floats, most: float) -> Lobes:
        """Return the lobes of a curve, shape (n,), between troughs that noise of this `standard` deviation,
        shape (n,), does not make, and higher than the `most` of these that noise at rest does."""
        size, of_noise = np.abs(away), most * standard
        first, *others = _lobes(size, _SURE * standard)
        return cls(away, (first, *(each for each in others if size[each.top] > of_noise[each.top])))

    def at(self, place: float) -> int:
        """Return the number of the lobe behind which the curve enters a band at a place."""
        row = math.ceil(place) - 1
        return max(0, bisect_right(self.lobes, row, key=lambda each: each.begin) - 1)

    def entries(self, place: float, drawn: Floats, errors: Floats, band: float) -> Entries:
        """Return where the curve finally enters a band about the level, behind whichever lobe leaves that as
        the last one.

        A `place` and those `drawn`, nan where there is none, are entries of the curve and of draws as they
        are, with these `errors`, shape (draws, n).
        """
        if len(self.lobes) == 1:
            return Entries(place, place, drawn)
        heights = self._of_mode(self._heights_in(errors))
        leaves = heights > band
        leaves[:, 0] = True
        last = leaves.shape[1] - 1 - np.argmax(leaves[:, ::-1], axis=1)
        own = self.at(place)
        later = {own: 0.0}
        for number in np.unique(last[last != own]).tolist():
            height = float(np.mean(heights[last == number, number]))
            later[number] = self._entry(self.lobes[number], band, height) - place
        known = drawn[np.isfinite(drawn)].tolist()
        behind = [each - place for each in known if self.at(each) == own] or [0.0]
        moved = place + np.array([later[each] for each in last.tolist()]) + np.resize(behind, len(drawn))
        expected = place + float(np.mean([later[each] for each in last.tolist()]))
        likeliest = int(np.argmax(np.bincount(last)))
        return Entries(expected, place + later.get(likeliest, 0.0), np.where(np.isnan(drawn), np.nan, moved))

    def _entry(self, lobe: Lobe, band: float, height: float) -> float:
        """Return where the curve enters the band behind a lobe, or would if that were of a height beyond."""
        top = abs(float(self.away[lobe.top]))
        found = last_passage(self.away[: lobe.end], 0.0, band if top > band else band + top - height)
        return float(lobe.end) if found is None else found.place

    def _heights_in(self, errors: Floats) -> Floats:
        """Return the heights of all lobes in each draw, shape (draws, lobes); the greatest of whatever is
        drawn is raised by noise, of which a lobe is as high as in the curve on average."""
        drawn = np.pad(_OF_BOTH * errors, ((1, 0), (0, 0)))
        heights = np.stack([self._heights(each, drawn) for each in self.lobes], axis=1)
        tops = [each.top for each in self.lobes]
        # a lobe is no parabola: of what noise does not raise the greatest is the height
        least = np.abs(self.away[tops]) - _RAISED * np.std(errors[:, tops], axis=0)
        return np.asarray(np.maximum(heights[0], least) + heights[1:] - np.mean(heights[1:], axis=0))

    def _of_mode(self, heights: Floats) -> Floats:
        """Return heights in draws, shape (draws, lobes), as those of one mode where they are."""
        successive = self._successive
        own = np.mean(heights[:, successive], axis=0)
        found = of_one_mode(own, heights[:, successive] - own)
        if found is None:
            return heights
        heights = heights.copy()
        heights[:, successive] = found
        return heights

    @property
    def _successive(self) -> slice:
        """Which lobes follow each other behind the first, on either side of the level in turn."""
        tops = self.away[[each.top for each in self.lobes]]
        end = 2
        for before, lobe in pairwise(range(1, len(self.lobes))):
            if self.lobes[lobe].begin != self.lobes[before].end or tops[lobe] * tops[before] > 0.0:
                break
            end += 1
        return slice(1, end)

    def _heights(self, lobe: Lobe, errors: Floats) -> Floats:
        """Return the height of a lobe in each draw, shape (draws,), by least squares.

        Orthogonal powers are told apart one by one (Draper and Smith, Applied Regression Analysis, 3rd ed.
        1998, 22): of a half wave those beyond the second lift the top by some tenths of a percent of it.
        """
        sign = -1.0 if self.away[lobe.top] < 0.0 else 1.0
        size = sign * self.away[lobe.begin : lobe.end]
        height, *troughs = np.abs(
            self.away[[lobe.top, lobe.begin, min(lobe.end, len(self.away) - 1)]]
        ).tolist()
        upper = np.flatnonzero(size >= height - _UPPER * (height - max(troughs)))
        rows = slice(int(upper[0]), int(upper[-1]) + 1)
        values, drawn = size[rows], sign * errors[:, lobe.begin : lobe.end][:, rows]
        if len(values) <= _HIGHER + 1:  # on such a curve themselves
            return np.asarray(np.max(values + drawn, axis=1))
        powers = np.vander(np.linspace(-1.0, 1.0, len(values)), _HIGHER + 1, increasing=True)
        basis, _ = np.linalg.qr(powers)
        own, moved = values @ basis, drawn @ basis
        is_told = np.abs(own) > _SURE * np.std(moved, axis=0)
        count = _HIGHER + 1 if np.any(is_told[_DEGREE + 1 :]) else _DEGREE + 1
        return np.asarray(np.max((own + moved)[:, :count] @ basis[:, :count].T, axis=1))


def _lobes(size: Floats, sure: Floats) -> Iterator[Lobe]:
    """Yield the lobes of a size, shape (n,): behind each it falls by what is `sure`, shape (n,), and before
    the next it rises by as much."""
    slopes = np.diff(size)
    turns = np.flatnonzero(slopes[1:] * slopes[:-1] <= 0.0) + 1
    begin = top = trough = 0
    falls = False
    for row in (*turns.tolist(), len(size) - 1):
        if not falls and size[row] > size[top]:
            top = row
        elif not falls and size[row] < size[top] - sure[row]:
            falls, trough = True, row
        elif falls and size[row] < size[trough]:
            trough = row
        elif falls and size[row] > min(size[trough] + sure[row], size[top]):
            yield Lobe(begin, top, trough)
            falls, begin, top = False, trough, row
    yield Lobe(begin, top, len(size))
