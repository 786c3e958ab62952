"""An answer that rings in few rows a period, by the mode that all of its samples are of.

Few samples of a period say little of its peaks and of when it passes a level. But a mode that decays is known
by its four constants and its level wherever it is sampled, if no period has fewer than two rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.passages import SEED, Instant

Floats = NDArray[np.float64]

_FEWEST, _MOST = 10, 60  # rows of a mode
_SHORTEST, _LONGEST = 2.3, 8.0  # rows of a period: those of more show its peaks
_DESCRIBED = 3.0  # standard deviations of a sum of squares beyond what noise leaves
_CLEAR = 20.0  # standard deviations of a sample that the mode has at its beginning, at least
_OF_A_ROW = 4.0  # of the squares that a row of the mode leaves, over noise
_RINGS = 5.0  # of them below its level goes the trough after its crest: less is the end of a rise
_EARLIER = 3  # rows before the greatest sample in which the mode may set in
_AHEAD, _BESIDE = 0.5, 1.5  # rows of a peak before the first row, and behind the greatest sample, at most
_NEWTON, _ENOUGH = 12, 1e-9  # steps of Gauss and Newton, and the change of a constant that ends them
_MOST_DAMPED = 3.0  # per row
_ROUNDING = 1e-7  # of the peak to peak
_SMALL = 1e-6  # change of a constant that tells a slope
_OF_ADDED, _OF_TIMES = 0.05, 0.01  # of what the mode adds to the samples; rows: its course is another there
_DRAWS, _PLACES = 80, 64  # of the constants; to a row
_ROW_BEFORE = 1.1  # rows before its first in which a mode sets in, with what noise moves that by
_AT_LEVEL = 0.01  # of the height: from how near its level the mode takes an answer away


@dataclass(frozen=True)
class Peak:
    """A peak between samples: its height, and its place in rows, with their standard uncertainties."""

    height: float
    height_error: float
    place: float
    place_error: float


@dataclass(frozen=True)
class Ringing:
    """A mode, from row `begin` of `samples` on: damping and angle per row, level, sizes of cosine and sine
    are its `constants`, of this `covariance`."""

    samples: Floats
    begin: int
    constants: Floats
    covariance: Floats

    @property
    def level(self) -> float:
        """The value that it decays to."""
        return float(self.constants[2])

    @property
    def crest(self) -> Peak:
        """The greatest value."""
        return self._peak(self._first)

    @property
    def trough(self) -> Peak:
        """The least value after it."""
        return self._peak(self._first + self._half)

    def rise(self, before: float, low: float, high: float) -> Instant | None:
        """Return how long the answer takes from a level to a higher one, if the mode is all of it: if it is
        tangent to the level `before`, in the row before its first."""
        onset = self._peak(self._first - self._half)
        apart = abs(onset.height - before)
        if not -_ROW_BEFORE < onset.place - self.begin <= 0.0 or not low < high < self.crest.height:
            return None
        if apart > max(_AT_LEVEL * (self.crest.height - before), 3.0 * onset.height_error):
            return None
        rows = np.linspace(onset.place, self.crest.place, round(_PLACES * self._half)) - self.begin
        took = np.array([np.subtract(*np.interp((high, low), each, rows)) for each in self._drawn(rows)])
        found = float(np.subtract(*np.interp((high, low), _course(self.constants, rows), rows)))
        return Instant(found, math.hypot(float(np.std(took)), _OF_TIMES), of_rows=_OF_TIMES)

    def last_outside(self, level: float, band: float) -> Instant | None:
        """Return where the mode enters `level` +- `band` finally; None where it does not leave that, or ends
        outside."""
        rows = np.arange(0.0, len(self.samples) - self.begin - 1.0, 1.0 / _PLACES)
        found = _last(np.abs(_course(self.constants, rows) - level) > band)
        if found is None:
            return None
        drawn = [_last(np.abs(each - level) > band) for each in self._drawn(rows)]
        places = np.array([found if each is None else each for each in drawn]) / _PLACES
        instant = self.begin + found / _PLACES
        scatter = float(np.sqrt(np.mean((places + self.begin - instant) ** 2)))
        return Instant(instant, scatter, tuple((self.begin + places).tolist())).widened(_OF_TIMES)

    @cached_property
    def _half(self) -> float:
        """Half a period, in rows."""
        return math.pi / float(self.constants[1])

    @cached_property
    def _first(self) -> float:
        """How many rows after the peak that its phase has about its first row the greatest value is: the
        first crest from the row before that on."""
        turn = _turn(self.constants)
        first = self._half * math.ceil((-1.0 - turn) / self._half)
        heights = (_extreme(self.constants, each)[0] for each in (first, first + self._half))
        return first if next(heights) > next(heights) else first + self._half

    def _peak(self, after: float) -> Peak:
        height, place = _extreme(self.constants, after)
        size = math.hypot(*self.constants[3:].tolist())
        changes = _SMALL * np.array([1.0, 1.0, size, size, size])
        moved = [_extreme(self.constants + each, after) for each in np.diag(changes)]
        slopes = (np.array(moved) - (height, place)) / changes[:, np.newaxis]
        of_height, of_place = np.sqrt(np.diag(slopes.T @ self.covariance @ slopes)).tolist()
        row = max(0, self.begin + math.floor(place))
        added = float(np.min(np.abs(height - self.samples[row : row + 2])))
        aside = min(place - math.floor(place), math.ceil(place) - place)
        of_height, of_place = (
            math.hypot(of_height, _OF_ADDED * added),
            math.hypot(of_place, _OF_TIMES * aside),
        )
        return Peak(height, of_height, self.begin + place, of_place)

    def _drawn(self, rows: Floats) -> Iterator[Floats]:
        """Yield courses as they may be, shape (n,), after so many rows."""
        random = np.random.default_rng(SEED)
        for each in random.multivariate_normal(self.constants, self.covariance, _DRAWS, check_valid="ignore"):
            yield _course(each, rows)


def ringing_about(samples: Floats, top: int, noise: float) -> Ringing | None:
    """Return the mode that samples, shape (n,), are of from a few rows before the greatest, in row `top`, on;
    None where they are of more than one mode, of one that is slow, or hardly of any.

    `noise` is the standard deviation of a sample, with that of a converter's steps.
    """
    noise = math.hypot(noise, _ROUNDING * float(np.ptp(samples)))
    first = max(0, top - _EARLIER)
    fits = (_fitted(samples[begin : begin + _MOST], noise) for begin in range(first, top + 2))
    for begin, (fit, later) in enumerate(pairwise(fits), first):
        # a row that is not of the mode leaves more than one that is
        if fit is None or (later is not None and fit.square - later.square > _OF_A_ROW):
            continue
        ringing = Ringing(samples, begin, fit.constants, fit.covariance)
        after = ringing.crest.place - begin
        is_there = -_AHEAD < after < top - begin + _BESIDE
        # what rings once it has arrived is a click
        arrives = bool(np.all(samples[:begin] < ringing.level))
        rings = ringing.level - ringing.trough.height > _RINGS * noise
        return ringing if is_there and arrives and rings else None
    return None


@dataclass(frozen=True)
class _Fit:
    """The constants of a mode and their covariance, and the sum of squares that it leaves, over the noise."""

    constants: Floats
    covariance: Floats
    square: float


def _fitted(piece: Floats, noise: float) -> _Fit | None:
    """Return the mode that describes samples, shape (n,), within their noise; None where none does, or they
    are too few."""
    if len(piece) < _FEWEST:
        return None
    before = np.stack([piece[1:-1], piece[:-2], np.ones(len(piece) - 2)], axis=1)
    (first, second, _), *_ = np.linalg.lstsq(before, piece[2:], rcond=None)
    root = complex(np.roots([1.0, -first, -second])[0])
    if root == 0.0 or root.imag == 0.0:
        return None
    rates = np.array([-math.log(abs(root)), abs(np.angle(root))])
    rows = np.arange(len(piece), dtype=np.float64)
    for _ in range(_NEWTON):
        linear, jacobian, left = _linearised(rates, rows, piece)
        change = np.linalg.lstsq(jacobian, left, rcond=None)[0][:2]
        rates = rates + change
        if not 0.0 < rates[0] < _MOST_DAMPED or not 0.0 < rates[1] < math.pi:
            return None
        if float(np.max(np.abs(change))) < _ENOUGH:
            break
    linear, jacobian, left = _linearised(rates, rows, piece)
    dof = len(piece) - 5
    square, size = float(left @ left) / noise**2, math.hypot(*linear[1:].tolist())
    if not _SHORTEST < 2.0 * math.pi / float(rates[1]) < _LONGEST:
        return None
    if square > dof + _DESCRIBED * math.sqrt(2.0 * dof) or size < _CLEAR * noise:
        return None
    covariance = noise**2 * np.linalg.pinv(jacobian.T @ jacobian)
    return _Fit(np.concatenate([rates, linear]), np.asarray(covariance), square)


def _linearised(rates: Floats, rows: Floats, piece: Floats) -> tuple[Floats, Floats, Floats]:
    """Return level and sizes of a mode of these rates, by least squares, how its values in the rows change
    with each constant, shape (n, 5), and what is left of the samples."""
    decay = np.exp(-rates[0] * rows)
    cosine, sine = decay * np.cos(rates[1] * rows), decay * np.sin(rates[1] * rows)
    columns = np.stack([np.ones(len(rows)), cosine, sine], axis=1)
    linear = np.linalg.lstsq(columns, piece, rcond=None)[0]
    _, a, b = linear.tolist()
    slopes = np.stack([-rows * (a * cosine + b * sine), rows * (b * cosine - a * sine)], axis=1)
    return linear, np.concatenate([slopes, columns], axis=1), np.asarray(piece - columns @ linear)


def _course(constants: Floats, rows: Floats) -> Floats:
    damping, angle, level, a, b = constants.tolist()
    return np.asarray(level + np.exp(-damping * rows) * (a * np.cos(angle * rows) + b * np.sin(angle * rows)))


def _turn(constants: Floats) -> float:
    """Return where a mode has a peak, in rows, of all that are half a period apart."""
    damping, angle, _, a, b = constants.tolist()
    return float(math.atan2(b * angle - a * damping, a * angle + b * damping) / angle)


def _extreme(constants: Floats, after: float) -> tuple[float, float]:
    """Return height and place of the peak of a mode that is so many rows after its first one."""
    place = _turn(constants) + after
    return float(_course(constants, np.array(place))), place


def _last(found: NDArray[np.bool_]) -> int | None:
    """Return the last place that is found, if it is neither none nor the very last."""
    places = np.flatnonzero(found)
    return int(places[-1]) if len(places) and places[-1] < len(found) - 1 else None
