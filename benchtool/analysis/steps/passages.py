"""Where a curve passes a level: between two samples, through noise, and finally.

An instant is known as far as the samples allow, which a smooth curve narrows and a jump does not, and as far
as noise leaves it where it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_TROUGH = 2.0  # times as many, below a level that it has passed: no noise of a rise
LEAST_DEFINED = 0.9
"""Of the draws, for an instant that the noise leaves certain."""
_STRAIGHT = 1e-6  # a relative change of slope that is rounding
_OF_SMOOTH = 9.0 / 384.0  # of a fourth difference: a cubic half way between two samples
_OF_KINK = 0.375  # likewise, of a kink there, whose fourth difference is half of what its slope changes by
_FAR_APART = 0.3  # of how far draws are apart: of eighty from one distribution hardly any gap is
SEED = 20_110_301
"""Of all draws of a step, so that those of its instants belong together."""


@dataclass(frozen=True)
class Instant:
    """Place, in samples from the first, at which a curve passes a level, and its standard uncertainty.

    `standard` is infinite where, because of noise, it is unknown whether the level is passed at all;
    `of_rows` is what of it the samples leave open, which noise does not make. `drawn`, shape (draws,), are
    the places that noise may make of it, nan where none; empty without noise.
    """

    place: float
    standard: float
    drawn: tuple[float, ...] = ()
    of_rows: float = 0.0

    @property
    def of_noise(self) -> float:
        """Standard uncertainty without what the samples leave open."""
        return math.sqrt(max(0.0, self.standard**2 - self.of_rows**2))

    @cached_property
    def of_drawn(self) -> float:
        """What noise makes of the place in the middle: of draws far apart, as where the signal may leave a
        band once more, of those that are about as this place is. Nan where there are none."""
        known = np.sort(np.array([each for each in self.drawn if math.isfinite(each)]))
        if not len(known):
            return math.nan
        ends = np.flatnonzero(np.diff(known) > _FAR_APART * float(np.ptp(known))) + 1
        groups = np.split(known, ends)
        nearest = min(groups, key=lambda each: float(np.min(np.abs(each - self.place))))
        return float(np.median(nearest))

    def widened(self, standard: float) -> Instant:
        """Return the instant with another contribution of the samples, evenly distributed, to its
        uncertainty."""
        within = math.sqrt(3.0) * standard
        moved = np.random.default_rng(SEED).uniform(-within, within, len(self.drawn))
        drawn = tuple((moved + self.drawn).tolist())
        wider, of_rows = math.hypot(self.standard, standard), math.hypot(self.of_rows, standard)
        return Instant(self.place, wider, drawn, of_rows)


@dataclass(frozen=True)
class Passage:
    """Place at which a curve passes a level, half the width of the interval that the samples allow, and the
    `places` of the draws, shape (draws,), nan where one does not pass it; `of_crests` is what the noise that
    the curve has already adds to their scatter."""

    place: float
    reach: float
    places: Floats
    of_crests: float = 0.0

    @property
    def instant(self) -> Instant:
        """The place, with what noise and the samples leave open."""
        found = self.moved(self.place, self.places)
        return replace(found, standard=math.hypot(found.standard, self.of_crests))

    def moved(self, place: float, drawn: Floats) -> Instant:
        """Return another place that follows from this one, and `drawn`, shape (draws,), from its draws."""
        known = drawn[np.isfinite(drawn)]
        if len(known) < LEAST_DEFINED * len(drawn):
            return Instant(place, math.inf)
        noise = float(np.sqrt(np.mean((known - place) ** 2))) if len(known) else 0.0
        return Instant(place, noise, tuple(drawn.tolist())).widened(self.reach / math.sqrt(3.0))


@dataclass(frozen=True)
class Crossing:
    """Place of a crossing between two samples, and half the width of the interval that the samples allow."""

    place: float
    reach: float


def first_passage(above: Floats, sure: Floats) -> Crossing | None:
    """Return where a curve, shape (n,), so far `above` a level first rises to it; None where it does not.

    Until it is beyond the level by what is `sure`, shape (n,), or for longer than it went to and fro, samples
    below it put the place off.
    """
    at = int(np.argmax(above >= 0.0))
    if above[at] < 0.0:
        return None
    found = _between(above, at) if at else _before_the_first(above)
    after = above[at:]
    clear = np.flatnonzero((after >= sure[at:]) | (after <= -_TROUGH * sure[at:]))
    until = int(clear[0]) if len(clear) else _stays(after)
    if after[until] < 0.0:  # it falls from a crest beyond the level, and passes that again later
        until = int(np.flatnonzero(after[:until] >= 0.0)[-1])
    again = int(np.count_nonzero(after[:until] < 0.0))
    return Crossing(found.place + again, found.reach) if again else found


def _stays(after: Floats) -> int:
    """Return after how many values, shape (n,), the first of them not below zero, none is; 0 where that is
    later than their middle."""
    below = np.flatnonzero(after < 0.0)
    stays = int(below[-1]) + 1 if len(below) else 0
    return stays if 2 * stays < len(after) else 0


def rising(above: Floats, sure: Floats) -> Floats:
    """Return a course, shape (n,), without its noise until it is beyond zero by more than that, as it would
    be in a draw twice: up to there the least-squares one that falls nowhere (isotonic regression: Barlow et
    al., Statistical Inference under Order Restrictions, 1972, 1.2)."""
    from scipy import optimize  # takes longer than all else here

    beyond = int(np.argmax(above >= sure)) + 1
    rises = optimize.isotonic_regression(above[:beyond]).x
    within = np.abs(rises - above[:beyond]) <= sure[:beyond]
    return np.concatenate([np.where(within, rises, above[:beyond]), above[beyond:]])


def _before_the_first(above: Floats) -> Crossing:
    """Return where zero was crossed since the sample before the first, which was below.

    There a course leads whose slope goes on changing as it does after them, by a factor from row to row as
    that of an exponential. How far it is from the line through the first two is how little it is known. Where
    it does not lead to zero within the row, the curve jumped, and anywhere.
    """
    slope, later = np.diff(above[:3]).tolist() if len(above) > 2 else (0.0, 0.0)
    if slope <= 0.0:
        return Crossing(-0.5, 0.5)
    line = float(above[0]) / slope
    ahead = _back_to_zero(line, max(0.0, later) / slope)
    if ahead >= 1.0:
        return Crossing(-0.5, 0.5)
    apart = abs(line - ahead)
    first, last = max(-1.0, -ahead - apart), min(0.0, apart - ahead)
    return Crossing(0.5 * (first + last), 0.5 * (last - first))


def _back_to_zero(height: float, ratio: float) -> float:
    """Return how many rows before a value, relative to its change to the next, zero was, if changes go on by
    this ratio; infinity if never."""
    if ratio == 0.0 or height == 0.0:
        return 0.0
    if abs(ratio - 1.0) < _STRAIGHT:
        return height
    left = 1.0 + height * (1.0 - ratio)
    return -math.log(left) / math.log(ratio) if left > 0.0 else math.inf


def last_passage(values: Floats, level: float, band: float) -> Crossing | None:
    """Return where values, shape (n,), enter a band about a level finally; None where they end outside."""
    inside = band - np.abs(values - level)
    outside = np.flatnonzero(inside < 0.0)
    at = int(outside[-1]) + 1 if len(outside) else 0
    if at == len(inside):
        return None
    return _last_lobe(inside, at) or (_between(inside, at) if at else Crossing(0.0, 0.0))


def _last_lobe(inside: Floats, begin: int) -> Crossing | None:
    """Return where a curve, which samples from `begin` on show above zero, rises from the last lobe below it
    between samples: on the parabola through the lowest of three, with what a third difference changes."""
    first = max(begin, 1)
    rises = np.diff(inside[first:-1])
    lowest = np.flatnonzero((rises[:-1] < 0.0) & (rises[1:] >= 0.0)) + (first + 1)
    if not len(lowest):
        return None
    slope = 0.5 * (inside[lowest + 1] - inside[lowest - 1])
    bend = inside[lowest + 1] - 2.0 * inside[lowest] + inside[lowest - 1]
    below = slope**2 / (2.0 * bend) - inside[lowest]
    if not np.any(below > 0.0):
        return None
    last = int(np.flatnonzero(below > 0.0)[-1])
    row, bend_there = int(lowest[last]), float(bend[last])
    half = math.sqrt(2.0 * float(below[last]) / bend_there)
    bends = np.diff(inside[row - 2 : row + 3], 2)
    uneven = float(np.max(np.abs(bends - bend_there))) / (16.0 * bend_there)
    return Crossing(row - float(slope[last]) / bend_there + half, min(half, uneven / half))


def _between(above: Floats, at: int) -> Crossing:
    """Return the crossing of zero between samples `at` - 1, below it, and `at`, not below it.

    The line through the two before (or rest, before the first) and that through the two after bound it,
    unless the curve bends more than samples can show: for a smooth curve the cubic through the four locates
    it, for a jump nothing does. With fewer it is anywhere between, and on the line if that is narrow.
    """
    below, here = float(above[at - 1]), float(above[at])
    first = last = line = below / (below - here)
    slope = below - float(above[at - 2]) if at >= 2 else 0.0
    from_before = min(1.0, -below / slope) if slope > 0.0 else 1.0
    first, last = min(first, from_before), max(last, from_before)
    if at + 1 < len(above):
        slope = float(above[at + 1]) - here
        from_after = max(0.0, 1.0 - here / slope) if slope > 0.0 else 0.0
        first, last = min(first, from_after), max(last, from_after)
    width, middle = last - first, 0.5 * (first + last)
    if at >= 2 and at + 1 < len(above):
        cubic = min(max(_cubic_zero(above[at - 2 : at + 2], line), first), last)
        place, reach = (1.0 - width) * cubic + width * middle, 0.5 * width
        if 3 <= at < len(above) - 2:
            off = _off_a_cubic(above[at - 3 : at + 3]) / (here - below)
            if off < reach:
                place, reach = cubic, off
        return Crossing(at - 1 + place, reach)
    place = (1.0 - width) * line + width * middle
    # the width of as large a deviation from there as from the middle of the interval
    return Crossing(at - 1 + place, math.hypot(0.5 * width, math.sqrt(3.0) * (middle - place)))


def _off_a_cubic(six: Floats) -> float:
    """Return how far a curve may be from the cubic through the middle four of six samples, between them: by
    its fourth difference where it is smooth, and sixteen times as much at a kink, of which that is as large
    as its second difference. That of a mode is less by the square of its rate, and no kink at all."""
    seconds = _second_differences(six.tolist())  # lists of so few are quicker than arrays
    second, fourth = (max(map(abs, each)) for each in (seconds, _second_differences(seconds)))
    share = min(1.0, fourth / second) ** 2 if second > 0.0 else 0.0
    return fourth * (_OF_SMOOTH + share * _OF_KINK)


def _second_differences(values: list[float]) -> list[float]:
    return [
        after - 2.0 * here + before
        for before, here, after in zip(values, values[1:], values[2:], strict=False)
    ]


def _cubic_zero(four: Floats, start: float) -> float:
    """Return zero of the cubic through samples at -1, 0, 1 and 2, by Newton's method from between 0 and 1."""
    before, a, here, after = four.tolist()
    c = 0.5 * (before + here) - a
    d = (after - before) / 6.0 - 0.5 * (here - a)
    b = here - a - c - d
    place = start
    for _ in range(3):
        slope = b + place * (2.0 * c + place * 3.0 * d)
        if slope <= 0.0:
            return start
        place = min(max(place - (a + place * (b + place * (c + place * d))) / slope, 0.0), 1.0)
    return place
