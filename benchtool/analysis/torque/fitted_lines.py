"""Sinusoids that do not repeat in each period of a signal: what is once per revolution, some times in it, or
in step with nothing, is no noise.

Means over periods differ by what is slower than a period, and by orders of a revolution between its
harmonics: cogging of nine in a revolution of two periods has another mean over every other one. Where that is
a few sinusoids it is known, and moves the mean of a record only by their incomplete cycles; what is left over
is the noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.lines.around_lines import MAIN_LOBE, surrounded
from benchtool.analysis.spectral_window import spectral_window
from benchtool.analysis.statistics.scatter import BLOCKS

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_MOST_LINES, _ROUNDS = 8, 2  # beside those of a revolution; harmonics show once the largest are away
_MOST_BLOCKS = 1 << 15  # of many periods, more of which are not looked at
_LOWEST, _FEWEST_BLOCKS = 3, 64  # cycles in the record under a Hann window; blocks
_STANDS_OUT = 6.0  # of the noise's rms amplitude
_BY_CHANCE, _FEWEST_DOF = 1e-4, 3
_LEAST_CYCLES = 1.2  # in the record: a slower one is not told from the mean
_APART = 1.0  # cycles between lines that are told from each other
_OF_LINE, _EXPLAINED = 2, 3.5  # bins on either side of a line; what it leaves there, of the noise around them
_FINER, _TURNS = 2, 4  # rounds of the fits
_ROWS_OF_BLOCK = 2  # at least
_BLOCKS_OF_CYCLE = 16  # that have a pace of their own
_MOST_ORDERS = 16  # between harmonics of the period
_HIGHEST = 0.25  # cycles in a block, whose mean makes a line smaller by a tenth
_OF_ORDER = 0.3  # bins from an order: a line further away is another one
_TOLD = 1e-3  # of singular values: lines that differ by less have one part of it
_CHUNK = 1 << 13


@dataclass(frozen=True)
class FittedLines:
    """Sinusoids of `cycles` over the record, shape (lines,); `cosine` and `sine` are their amplitudes, about
    the constant `mean`. Noise moves that `of_mean` times as much as it moves a mean without them.

    `untold` is the mean square over whole cycles that they may have more or less: that of lines that leave
    something beside them, as two within a part of a cycle do, and of the products of lines not far apart.
    Orders of a revolution that stand out are among them if they `are_of_revolution`.
    """

    mean: float
    cycles: Floats
    cosine: Floats
    sine: Floats
    of_mean: float = 1.0
    untold: float = 0.0
    are_of_revolution: bool = False

    @property
    def mean_square(self) -> float:
        """That of their sum, over whole cycles of all."""
        return 0.5 * float(np.sum(self.cosine**2 + self.sine**2))

    @property
    def are_apart(self) -> bool:
        """Whether each is more than a cycle away from the next, and from the mean."""
        return bool(np.all(np.diff(np.sort(self.cycles), prepend=0.0) > _APART))

    def mean_at(self, place: Floats) -> float:
        """Return by how much incomplete cycles move the mean of their sum at places, shape (n,), and no more
        than these can."""
        most = float(np.sum(np.hypot(self.cosine, self.sine) / (np.pi * self.cycles)))
        return float(np.clip(np.mean(self.at(place)) - self._over_whole_cycles(place), -most, most))

    def _over_whole_cycles(self, place: Floats) -> float:
        """Return the mean of their sum over the time of whole cycles, at places, shape (n,), that are evenly
        apart in time: it is not zero where the pace of the places swings along, as in a signal that a speed
        follows, or where that of few rows in a period rounds to a beat.

        With a pace of 1 + eta the integral of cos(x) dt is that of cos(x) dx, which whole cycles leave
        nothing of, less that of eta cos(x) dt. Of eta, a drift counts at the ends only, and is left out.
        Lines that are not apart may be large, and cancel each other: eta has one part for all of them, as
        slowly as they go in and out of step, that of a line in their middle.
        """
        order = np.argsort(self.cycles)
        begins = np.flatnonzero(np.diff(self.cycles[order], prepend=-np.inf) > _APART)
        lines = np.split(order, begins[1:])
        cycles = np.array([np.mean(self.cycles[each]) for each in lines])
        blocks = min(len(place) - 1, max(_FEWEST_BLOCKS, math.ceil(_BLOCKS_OF_CYCLE * np.max(self.cycles))))
        edges = np.linspace(0, len(place) - 1, blocks + 1).astype(np.int64)
        pace = np.diff(place[edges]) / np.diff(edges)
        middle = 0.5 * (place[edges[1:]] + place[edges[:-1]])
        turned = 2.0 * np.pi * np.outer(middle, cycles)
        basis = np.column_stack([np.ones(blocks), middle - 0.5, np.cos(turned), np.sin(turned)])
        eta = np.linalg.lstsq(basis, pace / np.mean(pace) - 1.0, rcond=_TOLD)[0][2:]
        phasors = self.cosine - 1j * self.sine
        together = np.zeros(len(lines), dtype=np.complex128)
        for index, each in enumerate(lines):  # on average over the record, against the line in their middle
            off = self.cycles[each] - cycles[index]
            together[index] = np.sum(phasors[each] * np.exp(1j * np.pi * off) * np.sinc(off))
        return -0.5 * float(eta @ np.concatenate([together.real, -together.imag]))

    def at(self, place: Floats) -> Floats:
        """Return their sum without the constant, at places from 0 to 1 in the record, shape (n,)."""
        found = np.empty(len(place))
        for start in range(0, len(place), _CHUNK):
            rows = slice(start, start + _CHUNK)
            turned = 2.0 * np.pi * np.outer(place[rows], self.cycles)
            found[rows] = np.cos(turned) @ self.cosine + np.sin(turned) @ self.sine
        return found


def slow_lines(samples: Floats, place: Floats, periods: int, per_revolution: int = 1) -> FittedLines | None:
    """Return the sinusoids of samples, shape (n,), that are slower than a period and stand out of the noise.

    `place`, shape (n,), is where the samples are in what repeats, from 0 to 1, increasing nearly evenly: in
    angle where that is known. A revolution has `per_revolution` periods: its orders are fitted also where the
    record has few of it. Others are sought in a spectrum under a Hann window.
    """
    if not _are_told(samples, periods):
        return None
    values, at, are_blocks = _aligned(samples, place, periods)
    cycles = _of_revolution(values, at, periods, per_revolution)
    are_of_revolution = len(cycles) > 0
    for _ in range(_ROUNDS):
        _, rest = _fitted(values, at, cycles, periods)
        more = _beside(rest, periods, _MOST_LINES + per_revolution - len(cycles))
        if not len(more):
            break
        cycles = _finer(values, at, np.concatenate([cycles, more]), len(cycles), periods)
    if not len(cycles):
        return None
    found, rest = _fitted(values, at, cycles, periods)
    if are_blocks:
        found = _before_blocks(found, len(values))
    return replace(found, untold=_untold(found, rest), are_of_revolution=are_of_revolution)


def lines_between_harmonics(
    samples: Floats, place: Floats, periods: int, per_revolution: int = 1
) -> FittedLines | None:
    """Return the lines that are faster than a period, no harmonics of it, and stand out of samples, shape
    (n,), at places as those of `slow_lines`: orders of a revolution, and others, such as hum, as far from the
    harmonics as a spectrum parts them. None without one."""
    if not _are_told(samples, periods):
        return None
    values, at, are_blocks = _aligned(samples, place, periods)
    highest = int(_HIGHEST * len(values))
    per_order = periods / per_revolution
    orders = np.arange(per_revolution + 1, int(highest / per_order))
    # of one period in a revolution, all are harmonics
    orders = orders[orders % per_revolution != 0] if per_order > MAIN_LOBE else orders[:0]
    _, rest = _fitted(values, at, np.empty(0), periods)
    cycles = _of_orders(rest, per_order * orders.astype(np.float64))
    if len(cycles):
        _, rest = _fitted(values, at, cycles, periods)
    inner = np.arange(periods + MAIN_LOBE + 1, highest)
    away = np.abs(inner - periods * np.round(inner / periods)) > MAIN_LOBE
    if len(more := _highest(rest, inner[away], _MOST_LINES)):
        cycles = _finer(values, at, np.concatenate([cycles, more]), len(cycles), periods)
    if not len(cycles):
        return None
    found, _ = _fitted(values, at, cycles, periods)
    return _before_blocks(found, len(values)) if are_blocks else found


def _of_orders(rest: Floats, cycles: Floats) -> Floats:
    """Return those of cycles over the record, shape (orders,), at which lines stand out, at most so many of
    the largest."""
    if not len(cycles):
        return cycles
    size, below = np.abs(_windowed(rest)), np.floor(cycles).astype(np.int64)
    places = _highest(rest, below + (size[below + 1] > size[below]), _MOST_ORDERS)
    return np.asarray(cycles[np.any(np.abs(cycles[:, np.newaxis] - places) < _OF_ORDER, axis=1)])


def _are_told(samples: Floats, periods: int) -> bool:
    """Return whether lines can be told in so many samples, and are sought in so many periods."""
    return len(samples) >= max(_FEWEST_BLOCKS, 2 * periods) and 2 * periods <= _MOST_BLOCKS


def _before_blocks(found: FittedLines, blocks: int) -> FittedLines:
    """Return lines as they are before means of so many blocks make them smaller."""
    kept = np.sinc(found.cycles / blocks)
    return replace(found, cosine=found.cosine / kept, sine=found.sine / kept)


def _untold(found: FittedLines, rest: Floats) -> float:
    """Return the mean square of lines that is not told, where they leave this rest, shape (n,)."""
    size, cycles = np.hypot(found.cosine, found.sine), found.cycles
    bins = _windowed(rest)
    left = np.abs(bins)
    is_left = np.zeros(len(cycles), dtype=np.bool_)
    for index, place in enumerate(np.round(cycles).astype(np.int64)):
        first = max(1, int(place) - _OF_LINE)
        peak = first + int(np.argmax(left[first : place + _OF_LINE + 1]))
        is_left[index] = left[peak] > _EXPLAINED * surrounded(bins, left, peak).noise
    one, other = np.triu_indices(len(cycles), 1)
    near = np.abs(cycles[one] - cycles[other]) < _APART
    of_products = float(np.sum(size[one[near]] * size[other[near]]))
    return of_products + 0.5 * float(np.sum(size[is_left] ** 2))


def _aligned(samples: Floats, place: Floats, periods: int) -> tuple[Floats, Floats, bool]:
    """Return values, as many in each period and two at least, and their places, at equal distances: means of
    parts of the distance, as the third says, or values between samples where these are few.

    They follow a cubic spline: what a straight line between few samples of a ripple misses beats slowly, as a
    line would, and so does what parts of equal time leave of a period whose speed drifts.
    """
    from scipy.interpolate import CubicSpline  # draws in scipy.optimize, which most runs do not need

    rows = np.arange(len(samples))
    within = min(BLOCKS, len(samples) // _ROWS_OF_BLOCK) // periods
    curve = CubicSpline(rows, samples)
    if within < 2:
        count = max(2, min(BLOCKS, len(samples)) // periods) * periods
        at: Floats = (np.arange(count) + 0.5) / count
        return curve(np.interp(at, place, rows)), at, False
    count = within * periods
    edges = np.interp(np.arange(count + 1) / count, place, rows)
    width = np.diff(edges)
    is_part = width > 0.0  # of rows at the same place there is none
    sums = np.diff(curve.antiderivative()(edges))
    means = np.where(is_part, sums / np.where(is_part, width, 1.0), curve(edges[:-1]))
    return np.asarray(means), (np.arange(count) + 0.5) / count, True


def _fitted(values: Floats, place: Floats, cycles: Floats, periods: int) -> tuple[FittedLines, Floats]:
    """Return the lines by least squares, and what neither they nor what each period repeats explain.

    Both by turns: over part of a cycle a line is not orthogonal to the harmonics of the period, which are far
    larger, and there are too many of these to fit them as well.
    """
    repeated, rest = np.zeros(len(values)), values
    turned = 2.0 * np.pi * np.outer(place, cycles)
    basis = np.concatenate([np.ones((len(place), 1)), np.cos(turned), np.sin(turned)], axis=1)
    inverse = np.linalg.pinv(basis)
    found = inverse @ values
    for _ in range(_TURNS):
        found = inverse @ (values - repeated)
        rest = values - basis @ found
        repeated = np.tile(np.mean(rest.reshape(periods, -1), axis=0), periods)
    cosine, sine = found[1 : 1 + len(cycles)], found[1 + len(cycles) :]
    of_mean = math.sqrt(len(place) * float(inverse[0] @ inverse[0]))
    return FittedLines(float(found[0]), cycles, cosine, sine, of_mean), rest - repeated


def _of_revolution(values: Floats, place: Floats, periods: int, per_revolution: int) -> Floats:
    """Return the orders of a revolution, in cycles over the record, of which noise as in the other bins below
    the period would make one as large once in ten thousand records."""
    cycles: Floats = np.arange(1.0, per_revolution) * (periods / per_revolution)
    cycles = cycles[cycles >= _LEAST_CYCLES]
    freedom = periods - 1 - len(cycles)
    if not len(cycles) or freedom < _FEWEST_DOF:
        return np.empty(0)
    found, rest = _fitted(values, place, cycles, periods)
    bins = fft.rfft(rest)[1:periods] / len(rest)
    of_noise = 4.0 * float(np.sum(np.abs(bins) ** 2)) / freedom
    if not of_noise > 0.0:
        return cycles
    power = found.cosine**2 + found.sine**2
    stands_out = [fisher_above(2.0, 2.0 * freedom, float(each) / of_noise) < _BY_CHANCE for each in power]
    return np.asarray(cycles[np.array(stands_out)])


def _beside(rest: Floats, periods: int, most: int) -> Floats:
    """Return the cycles of the largest lines of a spectrum that are slower than a period, at most so many."""
    return _highest(rest, np.arange(_LOWEST, periods - 1), most)


def _highest(rest: Floats, inner: NDArray[np.int64], most: int) -> Floats:
    """Return the cycles of the largest lines of a spectrum at inner bins, at most so many."""
    bins = _windowed(rest)
    size = np.abs(bins)
    peaks = inner[(size[inner] > size[inner - 1]) & (size[inner] >= size[inner + 1])]
    peaks = peaks[np.argsort(-size[peaks])][:most]
    found = [surrounded(bins, size, int(peak)) for peak in peaks]
    return np.array([each.place for each in found if each.amplitude > _STANDS_OUT * each.noise])


def _windowed(values: Floats) -> Complexes:
    """Return the bins of values, shape (n,), under a Hann window, shape (n // 2 + 1,), of any scale."""
    return np.asarray(fft.rfft((values - np.mean(values)) * spectral_window("hann", len(values))))


def _finer(values: Floats, place: Floats, cycles: Floats, known: int, periods: int) -> Floats:
    """Return the cycles by least squares, all but the first `known`, which are."""
    cycles = cycles.copy()
    free = slice(known, None)
    for _ in range(_FINER):
        found, rest = _fitted(values, place, cycles, periods)
        turned = 2.0 * np.pi * np.outer(place, cycles)
        turning = found.sine * np.cos(turned) - found.cosine * np.sin(turned)
        slope = 2.0 * np.pi * place[:, np.newaxis] * turning
        basis = np.concatenate(
            [np.ones((len(place), 1)), np.cos(turned), np.sin(turned), slope[:, free]], axis=1
        )
        moved = np.linalg.lstsq(basis, rest, rcond=None)[0][1 + 2 * len(cycles) :]
        cycles[free] += np.clip(moved, -0.5, 0.5)
    return cycles
