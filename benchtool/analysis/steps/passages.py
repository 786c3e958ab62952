"""Where a curve passes a level: between two samples, through noise, and finally.

An instant is known as far as the samples allow, which a smooth curve narrows and a jump does not, and as far
as noise leaves it where it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
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
_AT_ONCE = 1 << 17  # values
_FAR_APART = 0.3  # of how far draws are apart: of eighty from one distribution hardly any gap is
SEED = 20_110_301
"""Of all draws of a step, so that those of its instants belong together."""


@dataclass(frozen=True)
class Instant:
    """Place, in samples from the first, at which a curve passes a level, and its standard uncertainty.

    `standard` is infinite where, because of noise, it is unknown whether the level is passed at all;
    `of_rows` is what of it the samples leave open, which noise does not make. `drawn`, shape (draws,), are
    the places that noise may make of it, nan where none; empty without noise. Where noise leaves open which
    of several instants far apart it is, `place` is the one expected and `likeliest` one of them.
    """

    place: float
    standard: float
    drawn: tuple[float, ...] = ()
    of_rows: float = 0.0
    likeliest: float | None = None

    @property
    def at_likeliest(self) -> Instant:
        """The instant, at the likeliest of several places instead of between them."""
        return self if self.likeliest is None else replace(self, place=self.likeliest)

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
        return replace(self, standard=wider, drawn=drawn, of_rows=of_rows)


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


def places_of(found: Sequence[Crossing | None]) -> Floats:
    """Return the places of crossings, nan where there is none."""
    return np.array([math.nan if each is None else each.place for each in found])


def first_passage(above: Floats, sure: Floats) -> Crossing | None:
    """Return where a curve, shape (n,), so far `above` a level first rises to it; None where it does not.

    Until it is beyond the level by what is `sure`, shape (n,), or for longer than it went to and fro, samples
    below it put the place off.
    """
    return first_passages(above[np.newaxis], sure)[0]


def first_passages(above: Floats, sure: Floats) -> list[Crossing | None]:
    """Return `first_passage` of many curves, shape (curves, n)."""
    return [each for part in _parts(above) for each in _first_passages(part, sure)]


def _first_passages(above: Floats, sure: Floats) -> Iterator[Crossing | None]:
    first = np.argmax(above >= 0.0, axis=1)
    is_clear = (above >= sure) | (above <= -_TROUGH * sure)
    for curve, clear, at, found in zip(above, is_clear, first.tolist(), _between(above, first), strict=True):
        if curve[at] < 0.0:
            yield None
            continue
        crossing = found if at else _before_the_first(curve)
        again = _below_again(curve[at:], clear[at:])
        yield replace(crossing, place=crossing.place + again) if again else crossing


def _below_again(after: Floats, is_clear: NDArray[np.bool_]) -> int:
    """Return how many values, shape (n,), are below zero from the first, which is not, until the curve is
    clear of it, as it is in some rows, shape (n,)."""
    until = int(np.argmax(is_clear))
    if not is_clear[until]:
        until = _stays(after)
    if after[until] < 0.0:  # it falls from a crest beyond the level, and passes that again later
        until = int(np.flatnonzero(after[:until] >= 0.0)[-1])
    return int(np.count_nonzero(after[:until] < 0.0)) if until else 0


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
    return last_passages(values[np.newaxis], level, band)[0]


def last_passages(values: Floats, level: float, band: float) -> list[Crossing | None]:
    """Return `last_passage` of many curves, shape (curves, n)."""
    return [each for part in _parts(values) for each in _last_passages(band - np.abs(part - level))]


def _last_passages(inside: Floats) -> Iterator[Crossing | None]:
    """Yield where curves so far `inside` a band, shape (curves, n), enter it finally."""
    count = inside.shape[1]
    outside = [np.flatnonzero(each) for each in inside < 0.0]
    begin = np.array([int(each[-1]) + 1 if len(each) else 0 for each in outside])
    lobes, between = _last_lobes(inside, begin), _between(inside, np.minimum(begin, count - 1))
    for curve, (at, found) in enumerate(zip(begin.tolist(), between, strict=True)):
        if at == count:
            yield None
        else:
            yield lobes.get(curve) or (found if at else Crossing(0.0, 0.0))


def _last_lobes(inside: Floats, begin: NDArray[np.int64]) -> dict[int, Crossing]:
    """Return where curves, shape (curves, n), which samples from `begin` on, shape (curves,), show above
    zero, rise from the last lobe below it between samples: on the parabola through the lowest of three, with
    what a third difference changes. A curve without such a lobe has none."""
    least = max(int(np.min(begin)), 1)
    rises = np.diff(inside[:, least:-1], axis=1)
    falls = rises < 0.0
    # a vertex is lower than its row by an eighth of the bend at most, and that is no more than two rises
    is_near = inside[:, least + 1 : -2] < 0.5 * np.max(np.abs(rises), initial=0.0)
    curve, row = np.nonzero(is_near & falls[:, :-1] & ~falls[:, 1:])
    row += least + 1
    later = row > np.maximum(begin, 1)[curve]
    curve, row = curve[later], row[later]
    before, lowest, after = (inside[curve, row + offset] for offset in (-1, 0, 1))
    slope = 0.5 * (after - before)
    bend = after - 2.0 * lowest + before
    below = slope**2 / (2.0 * bend) - lowest
    found: dict[int, Crossing] = {}
    for at in np.flatnonzero(below > 0.0).tolist():  # the last of each curve
        of_lobe = int(row[at]), float(slope[at]), float(bend[at]), float(below[at])
        found[int(curve[at])] = _rise_of_lobe(inside[curve[at]], *of_lobe)
    return found


def _rise_of_lobe(inside: Floats, row: int, slope: float, bend: float, below: float) -> Crossing:
    """Return where a curve, shape (n,), rises from a lobe about a row, whose parabola has this slope there, a
    bend, and its vertex so far below zero."""
    half = math.sqrt(2.0 * below / bend)
    bends = np.diff(inside[row - 2 : row + 3], 2)
    uneven = float(np.max(np.abs(bends - bend))) / (16.0 * bend)
    return Crossing(row - slope / bend + half, min(half, uneven / half))


def _parts(curves: Floats) -> Iterator[Floats]:
    """Yield curves, shape (curves, n), as many at once as the processor's cache holds."""
    size = max(1, _AT_ONCE // curves.shape[1])
    return (curves[begin : begin + size] for begin in range(0, len(curves), size))


def _between(above: Floats, at: NDArray[np.int64]) -> Iterator[Crossing]:
    """Yield the crossing of zero of curves, shape (curves, n), between samples `at` - 1, shape (curves,),
    below it, and `at`, not below it; of a curve that does not cross it there, any.

    The line through the two before (or rest, before the first) and that through the two after bound it,
    unless the curve bends more than samples can show: for a smooth curve the cubic through the four locates
    it, for a jump nothing does. With fewer it is anywhere between, and on the line if that is narrow.
    """
    count = above.shape[1]
    rows = np.clip(at[:, np.newaxis] + np.arange(-3, 3), 0, count - 1)
    six = np.take_along_axis(above, rows, axis=1)
    _, earlier, below, here, later, _ = six.T
    has_before, has_after = at >= 2, at + 1 < count
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # of those that do not cross it
        line = below / (below - here)
        rises = has_before & (below > earlier)
        from_before = np.where(rises, np.minimum(1.0, -below / (below - earlier)), 1.0)
        rises = later > here
        from_after = np.where(rises, np.maximum(0.0, 1.0 - here / (later - here)), 0.0)
        first, last = np.minimum(line, from_before), np.maximum(line, from_before)
        first = np.where(has_after, np.minimum(first, from_after), first)
        last = np.where(has_after, np.maximum(last, from_after), last)
        width, middle = last - first, 0.5 * (first + last)
        off = _off_a_cubic(six) / (here - below)
        cubic = np.minimum(np.maximum(_cubic_zero(six[:, 1:5], line), first), last)
        has_four, has_six = has_before & has_after, (at >= 3) & (at < count - 2)
        place = (1.0 - width) * np.where(has_four, cubic, line) + width * middle
        # with fewer the width of as large a deviation from there as from the middle of the interval
        off_middle = np.hypot(0.5 * width, math.sqrt(3.0) * (middle - place))
        reach = np.where(has_four, 0.5 * width, off_middle)
    is_smooth = has_six & (off < reach)
    place, reach = np.where(is_smooth, cubic, place), np.where(is_smooth, off, reach)
    return map(Crossing, (at - 1 + place).tolist(), reach.tolist())


def _off_a_cubic(six: Floats) -> Floats:
    """Return how far curves may be from the cubic through the middle four of six samples, shape (curves, 6),
    between them: by the fourth difference where one is smooth, and sixteen times as much at a kink, of which
    that is as large as its second difference. That of a mode is less by the square of its rate, and no kink
    at all."""
    seconds = np.diff(six, 2, axis=1)
    second, fourth = (np.max(np.abs(each), axis=1) for each in (seconds, np.diff(seconds, 2, axis=1)))
    share = np.where(second > 0.0, np.minimum(1.0, fourth / second) ** 2, 0.0)
    return np.asarray(fourth * (_OF_SMOOTH + share * _OF_KINK))


def _cubic_zero(four: Floats, start: Floats) -> Floats:
    """Return zero of cubics through samples at -1, 0, 1 and 2, shape (curves, 4), by Newton's method from
    between 0 and 1; from where it leads nowhere, the start."""
    before, a, here, after = four.T
    c = 0.5 * (before + here) - a
    d = (after - before) / 6.0 - 0.5 * (here - a)
    b = here - a - c - d
    place, rises = start, np.ones(len(start), dtype=np.bool_)
    for _ in range(3):
        slope = b + place * (2.0 * c + place * 3.0 * d)
        rises = rises & (slope > 0.0)
        place = np.clip(place - (a + place * (b + place * (c + place * d))) / slope, 0.0, 1.0)
    return np.where(rises, place, start)
