"""How far a curve may be from the levels that a converter reads it on.

It is anywhere within a level that it passes; where it turns back within one, as far beyond the edge as its
widths there and in the levels before tell.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

HIDES = 0.5
"""Of a step: noise of so much rms leaves hardly anything of its errors in a mean."""

_FEWEST = 20  # samples
_OF_A_LINE, _BESIDE = 0.8, 2  # of the power; bins to either side under a Hann window
_AMPLITUDES = np.linspace(0.9, 1.1, 9)  # as well as readings in steps tell that of a line
_HARMONICS = 4  # of the errors of steps
_PHASES = (np.arange(64) + 0.5) * (2.0 * math.pi / 64)

_EDGE = 0.5  # of a step, from the middle of a level
_LEAST_DEPTH = 1e-6  # of a step
_WIDER = 1  # rows, as both ends are uncertain by
_TOGETHER = 0.5  # of the rows from the first to the last on the level
_UNLIKE = 3.0  # times as long in the level before on one side as on the other: no power of the width
_CORNER, _SMOOTH = 1.0, 2.0  # powers of the width in which a curve goes down from its turn
_POWERS = np.linspace(_CORNER, _SMOOTH, 41)[:, np.newaxis]  # that widths may show


@dataclass(frozen=True)
class _Turn:
    """Pairs of the first and the last row: on the level that is turned back in, on that and the one before
    together, and on three; the last pair is empty where the record does not show it."""

    on_it: tuple[int, int]
    on_two: tuple[int, int]
    on_three: tuple[int, ...]

    def errors(self, random: np.random.Generator, draws: int) -> Floats:
        """Return how far the curve may be above the middle of the level, in steps, shape (draws, rows).

        A level begins and ends anywhere between two rows. From its turn down a curve is a power of its width:
        the second where it is smooth, the first at a corner. Further down it is a lower one than near a
        smooth turn, which three widths show: down to two levels it is between that and the second.
        """
        middle, width = _interval(random, self.on_it, draws)
        middle_of_two, wider = _interval(random, self.on_two, draws)
        shown = np.full(draws, _CORNER)
        if self.on_three:
            _, widest = _interval(random, self.on_three, draws)
            # depths that should be in steps of one
            uneven = (widest**_POWERS - width**_POWERS) / wider**_POWERS + 2.0 * (width / wider) ** _POWERS
            shown = _POWERS[np.argmin(np.abs(uneven - 2.0), axis=0), 0]
        power = random.uniform(shown, _SMOOTH)
        deeper = np.maximum((wider / width) ** power, 2.0)  # it is beyond the edge by at most a step
        off = np.arange(self.on_it[0], self.on_it[1] + 1) - middle[:, np.newaxis]
        half, power, deeper = 0.5 * width[:, np.newaxis], power[:, np.newaxis], deeper[:, np.newaxis]
        beyond = (1.0 - (np.abs(off) / half) ** power) / (deeper - 1.0)
        # nearer to the turn its middle goes on as it does from the level before
        off = np.clip(off + (middle_of_two - middle)[:, np.newaxis] * beyond, -half, half)
        return np.asarray((1.0 - (np.abs(off) / half) ** power) / (deeper - 1.0) - _EDGE)


def _interval(random: np.random.Generator, rows: tuple[int, ...], draws: int) -> tuple[Floats, Floats]:
    """Return middle and width, shape (draws,), of where a curve may be on levels that it is on in these
    rows."""
    begin, end = rows[0] - random.uniform(size=draws), rows[-1] + random.uniform(size=draws)
    return 0.5 * (begin + end), end - begin


def within_levels(random: np.random.Generator, samples: Floats, step: float, draws: int) -> Floats:
    """Return errors, shape (draws, n), the same for all samples, shape (n,), on one level and independent
    otherwise; on the greatest one, where the curve stays, they rise from its lower edge to that."""
    level = _levels(samples, step)
    highest = int(np.max(level))
    of_level = random.uniform(-_EDGE, _EDGE, (draws, highest + 1))
    errors = of_level[:, level]
    if arrival := _arrival(level):
        first, rows = arrival
        rises = _arriving(random, of_level[:, highest:] + _EDGE, len(level) - first, rows)
        errors[:, first:] = np.where(level[first:] == highest, rises, errors[:, first:])
    return np.asarray(step * errors)


def _arrival(levels: Rows) -> tuple[int, int] | None:
    """Return the row in which levels, shape (n,), first are on the greatest, and after how many rows on the
    one before; None if they do not rise level by level to that and stay there until their end."""
    highest = int(np.max(levels))
    first, before = (int(np.argmax(levels == each)) for each in (highest, highest - 1))
    stays = levels[-1] == highest and np.mean(levels[first:] == highest) > _TOGETHER
    return (first, first - before) if stays and 0 < before < first else None


def _arriving(random: np.random.Generator, depth: Floats, count: int, rows: int) -> Floats:
    """Return how far a curve is above the middle of the level that it stays on, in steps, shape (draws,
    count), which comes to rest so deep in it, shape (draws, 1): as a lag that took so many rows for the level
    before."""
    since = np.arange(count) + random.uniform(size=depth.shape)
    rate = np.log1p(1.0 / np.maximum(depth, _LEAST_DEPTH)) / rows
    return np.asarray(depth * -np.expm1(-rate * since) - _EDGE)


def at_turns(random: np.random.Generator, samples: Floats, step: float, errors: Floats) -> Floats:
    """Return errors, shape (draws, n), of samples, shape (n,), with what widths tell of those in whose rows
    the curve turns back."""
    turned, levels = errors.copy(), _levels(samples, step)
    for sign in (1, -1):
        for turn in _turns(sign * levels):
            first, last = turn.on_it
            on_it = np.flatnonzero(levels[first : last + 1] == levels[first])
            turned[:, first + on_it] = sign * step * turn.errors(random, len(errors))[:, on_it]
    return turned


def _levels(samples: Floats, step: float) -> Rows:
    """Return which level each sample, shape (n,), is on, from the least."""
    return np.round((samples - np.min(samples)) / step).astype(np.int64)


def _turns(levels: Rows) -> Iterator[_Turn]:
    """Yield where levels, shape (n,), rise by one, and fall by one again before they rise further."""
    edges = np.flatnonzero(np.diff(levels))
    firsts, lasts = edges[:-1] + 1, edges[1:]
    rises = levels[firsts] - levels[firsts - 1]
    falls = levels[lasts] - levels[lasts + 1]
    tops = firsts[(rises == 1) & (falls == 1)]
    for level in np.unique(levels[tops]).tolist():
        found = {_around(levels, level - 1, row) for row in tops[levels[tops] == level].tolist()}
        for two in sorted(each for each in found if each):
            rows = two[0] + np.flatnonzero(levels[two[0] : two[1] + 1] >= level)
            first, last = int(rows[0]), int(rows[-1])
            if len(rows) < _TOGETHER * (last - first + 1) or np.max(levels[rows]) > level:
                continue
            shorter, longer = sorted((first - two[0], two[1] - last))
            if shorter + longer > _WIDER and longer <= _UNLIKE * (shorter + _WIDER):
                yield _Turn((first, last), (two[0], two[1]), _around(levels, level - 2, first))


def _around(levels: Rows, least: int, row: int) -> tuple[int, ...]:
    """Return the first and the last row around one in which levels, shape (n,), are not below the least;
    none where the record begins or ends there."""
    low = np.flatnonzero(levels < least)
    at = int(np.searchsorted(low, row))
    return (int(low[at - 1]) + 1, int(low[at]) - 1) if 0 < at < len(low) else ()


def left_on_a_course(course: Floats, step: float) -> float:
    """Return what a course, shape (n,), leaves of the error that a converter's `step` makes in the mean of
    samples, relative to that on one level: the harmonics of the rounding error average out over the levels
    that it passes, as far as their mean phasor along it is short."""
    if not step > 0.0 or not np.ptp(course) > 0.0:
        return 1.0
    number = np.arange(1, _HARMONICS + 1)
    phasors = np.mean(np.exp(2j * np.pi / step * np.outer(number, course)), axis=1)
    return math.sqrt(float(np.sum(np.abs(phasors / number) ** 2) / np.sum(1.0 / number**2)))


def left_beside_a_line(at_rest: Floats, step: float) -> float:
    """Return the standard uncertainty that a converter's `step` leaves in the mean of samples at rest, shape
    (n,), that one line makes most of: a ripple of a step and more hides its steps far less than noise of the
    same rms does. 0 of others.

    The harmonic k of the rounding error has a mean of step / (k pi) times the characteristic function, at
    2 pi k / step, of what moves the samples: J0(2 pi k A / step) of a line of amplitude A,
    exp(-2 (pi k rms / step)^2) of noise.
    """
    if not step > 0.0 or len(at_rest) < _FEWEST:
        return 0.0
    read = float(np.var(at_rest))
    power = np.abs(np.fft.rfft((at_rest - np.mean(at_rest)) * np.hanning(len(at_rest)))) ** 2
    whole = float(np.sum(power))
    if not whole > 0.0:
        return 0.0
    top = int(np.argmax(power))
    line = float(np.sum(power[max(0, top - _BESIDE) : top + _BESIDE + 1])) / whole * read
    square = read - step**2 / 12.0  # without what the steps add themselves, at other frequencies
    if not line > _OF_A_LINE * square:
        return 0.0
    noise = max(0.0, square - line) / step**2
    turns = 2.0 * math.pi * math.sqrt(2.0 * line) / step * _AMPLITUDES
    left = 0.0
    for k in range(1, _HARMONICS + 1):
        of_line = np.mean(np.cos(k * np.outer(turns, np.sin(_PHASES))), axis=1)
        of_noise = math.exp(-2.0 * noise * (math.pi * k) ** 2)
        left += float(np.mean(of_line**2)) * (of_noise / k) ** 2
    return step / (math.sqrt(2.0) * math.pi) * math.sqrt(left)
