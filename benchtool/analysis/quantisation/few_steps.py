"""What a periodic signal may have been of which a converter shows few steps.

Where a waveform spans less than some steps, and noise does not hide them, the record is far from the signal:
lines are too large, too small or missing, and alike so in every period. What is read on average over the
noise at each place of a period, and how much it scatters there, is known of any mean, lines and noise (Widrow
and Kollár, Quantization Noise, 2008, ch. 4): of those that would have been read as the record was, by what
its own noise leaves open, a sample is drawn. They are taken from a broad one step by step, each weighted by a
higher power of their likelihood, resampled and moved by the differences of others (sequential Monte Carlo:
Del Moral, Doucet and Jasra, J. R. Stat. Soc. B 68 (2006) 411; ter Braak, Stat. Comput. 16 (2006) 239).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy import fft
from numpy.typing import NDArray

_DRAWS, _FEWER_DRAWS = 120, 40  # in the end, and to find the lines
_MOST_LINES = 6
_FEWEST_POINTS, _PER_CYCLE, _MOST_POINTS = 128, 16, 2048
_MOST_PLACES, _FEWEST_PLACES = 1 << 16, 32  # of a whole period; of the shortest one
_EDGES = 3  # to either side of a reading: those beyond are three standard deviations of noise away
_TOLERANCE = 0.01  # of a step: what places in the period and rows between them make of a line
_OF_VARIANCE, _LEAST_VARIANCE = 0.2, 2e-3  # of its logarithm; of a step's square
_LEAST_NOISE, _MOST_NOISE = 5e-3, 0.8  # steps
_STANDS_OUT = 4.0  # standard deviations: a line that those before do not make
_LEAST_LINE = 0.05  # steps: below it a line is as likely at any size
_FURTHEST, _CELLS = 8.0, 1 << 11  # standard deviations of noise, in a table
_AHEAD = 0.02  # steps, for a slope
_MOVES, _LAST_MOVES = 5, 12
_SMALLER = np.array([1.0, 1.0, 0.3, 0.1])  # of the difference of two draws
_MOST_STAGES = 60

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
LogDensity = Callable[[Floats], Floats]


@dataclass(frozen=True)
class FewSteps:
    """Signals that would be read alike, in their own unit: `signals` and how they are `read` on average over
    noise, both of shape (draws, points) over a whole period, and the rms of the noise in them, of shape
    (draws,), before and after. `slope`, of shape (draws,), is how much of a weak line more is read, and
    `orders` are those that the signals consist of.
    """

    signals: Floats
    read: Floats
    noise: Floats
    noise_read: Floats
    slope: Floats
    orders: NDArray[np.int64]


def few_steps(
    mean: float, phasors: Complex, step: float, level: float, beside: float, samples: float, points: int
) -> FewSteps:
    """Return signals that a converter with a `step` and a `level` would read as a mean and harmonics 1, 2
    ..., peak `phasors` of shape (n,), with a mean square `beside` them, in so many samples.

    Harmonics are taken in, the strongest first, until those taken make the others. `points` are the places of
    a period at which there are samples; more than needed are as good as all.
    """
    in_steps = (math.sqrt(beside) / step) ** 2  # the square of a tiny step is zero
    record = _Record((mean - level) / step, phasors / step, in_steps, samples, points)
    orders = [1 + int(np.argmax(np.abs(phasors)))]
    while len(orders) < _MOST_LINES:
        draws = _drawn(record, np.array(orders), _FEWER_DRAWS)
        left = np.abs(record.lines - draws.lines_read(len(phasors)))
        left[np.array(orders) - 1] = 0.0
        next_one = int(np.argmax(left))
        if left[next_one] < _STANDS_OUT * record.of_line:
            break
        orders.append(next_one + 1)
    draws = _drawn(record, np.array(orders), _DRAWS)
    signals, read = draws.whole(draws.signals), draws.whole(draws.read)
    return FewSteps(
        level + step * signals,
        level + step * read,
        step * draws.noise,
        step * np.sqrt(draws.variance),
        draws.slope,
        np.array(orders),
    )


@dataclass(frozen=True)
class _Record:
    """Of a record in steps from a level: mean, harmonics, what does not repeat, samples, places."""

    mean: float
    lines: Complex
    beside: float
    samples: float
    points: int

    @property
    def of_line(self) -> float:
        """Standard deviation of each part of a line by noise, or by what else is left open."""
        return math.hypot(math.sqrt(2.0 * self.beside / self.samples), _TOLERANCE)


@dataclass(frozen=True)
class _Draws:
    """Signals, in steps, over the shortest period of their orders, and what is read of them."""

    signals: Floats
    read: Floats
    noise: Floats
    variance: Floats
    slope: Floats
    common: int

    def lines_read(self, count: int) -> Complex:
        """Return the mean harmonics 1 to `count` as read."""
        bins = np.mean(fft.rfft(self.read, axis=1), axis=0) * (2.0 / self.read.shape[1])
        lines = np.zeros(count, dtype=np.complex128)
        own = lines[self.common - 1 :: self.common]
        taken = min(len(own), len(bins) - 1)
        own[:taken] = bins[1 : taken + 1]
        return lines

    def whole(self, values: Floats) -> Floats:
        """Return values over the shortest period over the whole one, at as many places for each; of very many
        of them at fewer, which still show the signals' own lines."""
        size, every = values.shape[1], 1
        while size // every * self.common > _MOST_PLACES and size % (2 * every * _FEWEST_PLACES) == 0:
            every *= 2
        return np.tile(values[:, ::every], (1, self.common))


def _drawn(record: _Record, orders: NDArray[np.int64], count: int) -> _Draws:
    """Return so many signals with these orders that would be read as the record was."""
    common = int(np.gcd.reduce(orders))
    cycles = orders // common
    needed = _FEWEST_POINTS
    while needed < min(_PER_CYCLE * int(np.max(cycles)), _MOST_POINTS):
        needed *= 2
    are_few = record.points % common == 0 and record.points // common < needed
    points = record.points // common if are_few else needed
    place = np.exp(2j * np.pi * np.outer(cycles, np.arange(points)) / points)
    seen = record.lines[common - 1 :: common][: (points - 1) // 2]

    def signals(z: Floats) -> Floats:
        lines = z[:, 3 : 3 + len(orders)] + 1j * z[:, 3 + len(orders) :]
        return np.asarray(z[:, :1] + np.real(lines @ place))

    def log_likelihood(z: Floats) -> Floats:
        read, variance = _read(signals(z), np.exp(z[:, 1]), np.clip(z[:, 2], -1.0, 1.0))
        bins = fft.rfft(read, axis=1) * (2.0 / points)
        off = np.sum(np.abs(bins[:, 1 : len(seen) + 1] - seen) ** 2, axis=1)
        off += 2.0 * (0.5 * bins[:, 0].real - record.mean) ** 2
        ratio = np.log((variance + _LEAST_VARIANCE) / (record.beside + _LEAST_VARIANCE))
        return np.asarray(-0.5 * off / record.of_line**2 - 0.5 * (ratio / _OF_VARIANCE) ** 2)

    def log_prior(z: Floats) -> Floats:
        """Of lines and noise of any size, in the logarithm, alike, and of any shape."""
        lines = np.hypot(z[:, 3 : 3 + len(orders)], z[:, 3 + len(orders) :])
        within = (z[:, 1] > math.log(_LEAST_NOISE)) & (z[:, 1] < math.log(_MOST_NOISE))
        within &= (np.abs(z[:, 0] - record.mean) < 1.0) & (np.abs(z[:, 2]) < 1.0)
        return np.where(within, -2.0 * np.sum(np.log(lines + _LEAST_LINE), axis=1), -np.inf)

    random = np.random.default_rng(0)
    start = random.uniform(-1.0, 1.0, (count, 3 + 2 * len(orders)))
    start[:, 0] = record.mean + 0.5 * start[:, 0]
    start[:, 1] = np.log(np.geomspace(1.01 * _LEAST_NOISE, 0.99 * _MOST_NOISE, count))
    own = record.lines[orders - 1]
    start[:, 3:] = 0.5 * start[:, 3:] + np.concatenate([own.real, own.imag])
    found = _sampled(start, log_prior, log_likelihood, random)
    drawn, noise, shape = signals(found), np.exp(found[:, 1]), found[:, 2]
    read, variance = _read(drawn, noise, shape)
    return _Draws(drawn, read, noise, variance, _slope(drawn, noise, shape), common)


def _read(signals: Floats, noise: Floats, shape: Floats) -> tuple[Floats, Floats]:
    """Return what is read, in steps, on average of signals of shape (draws, points), with noise of an rms and
    a shape, both (draws,), and the mean over the points of its variance, shape (draws,)."""
    nearest = np.round(signals)
    apart, inverse = signals - nearest, 1.0 / noise[:, np.newaxis]
    mean, square = np.zeros_like(apart), np.zeros_like(apart)
    for edge in range(_EDGES):
        reached = noise > edge / _FURTHEST
        value, scale, of = apart[reached], inverse[reached], shape[reached]
        above, below = (_below((each - (edge + 0.5)) * scale, of) for each in (value, -value))
        mean[reached] += above - below
        square[reached] += (2.0 * edge + 1.0) * (above + below)
        # to both sides further away than the table
        square[~reached] += (4.0 * edge + 2.0) * _below(-_FURTHEST * np.ones((1, 1)), shape[~reached])
    return nearest + mean, np.mean(square - mean**2, axis=1)


def _below(value: Floats, shape: Floats) -> Floats:
    """Return the probability that noise of rms 1 is less than values of shape (draws, points): between that
    of the normal distribution (shape 0), of the rectangular one (1), and of Laplace's (-1)."""
    tables = _distributions()
    cell = np.clip((value + _FURTHEST) * (_CELLS / _FURTHEST), 0.0, 2.0 * _CELLS).astype(np.int32)
    found = tables[0].take(cell)
    other = tables.ravel().take(cell + (tables.shape[1] * np.where(shape > 0.0, 1, 2))[:, np.newaxis])
    return np.asarray(found + np.abs(shape)[:, np.newaxis] * (other - found))


@cache
def _distributions() -> Floats:
    """Return the normal, the rectangular and Laplace's distribution function of rms 1 at the cells of a
    table."""
    from scipy.special import ndtr

    value = (np.arange(2 * _CELLS + 1) + 0.5) * (_FURTHEST / _CELLS) - _FURTHEST
    tail = 0.5 * np.exp(-math.sqrt(2.0) * np.abs(value))
    laplace = np.where(value < 0.0, tail, 1.0 - tail)
    return np.array([ndtr(value), np.clip(0.5 + value / math.sqrt(12.0), 0.0, 1.0), laplace])


def _slope(signals: Floats, noise: Floats, shape: Floats) -> Floats:
    """Return the mean density of readings at the edges between steps: what is read of a weak line."""
    noise = np.maximum(noise, _LEAST_LINE)
    more, less = (_read(signals + apart, noise, shape)[0] for apart in (_AHEAD, -_AHEAD))
    return np.asarray(np.mean(more - less, axis=1) / (2.0 * _AHEAD))


def _sampled(
    start: Floats, log_prior: LogDensity, log_likelihood: LogDensity, random: np.random.Generator
) -> Floats:
    """Return a sample of the likely ones from a broad one, both of shape (draws, unknowns)."""
    z, unknowns = start, start.shape[1]
    likely, prior, power = log_likelihood(z), log_prior(z), 0.0
    for _ in range(_MOST_STAGES):
        rise = _next(likely, 1.0 - power)
        weights = np.exp(rise * (likely - np.max(likely)))
        chosen = random.choice(len(z), len(z), p=weights / np.sum(weights))
        z, likely, prior, power = z[chosen], likely[chosen], prior[chosen], power + rise
        for _ in range(_MOVES if power < 1.0 else _LAST_MOVES):
            one, other = random.permutation(len(z)), random.permutation(len(z))
            scale = 1.7 / math.sqrt(unknowns) * random.choice(_SMALLER, (len(z), 1))
            moved = z + scale * (z[one] - z[other]) + 1e-4 * random.standard_normal(z.shape)
            its, before = log_likelihood(moved), log_prior(moved)
            taken = np.log(random.random(len(z))) < power * (its - likely) + before - prior
            z = np.where(taken[:, np.newaxis], moved, z)
            likely, prior = np.where(taken, its, likely), np.where(taken, before, prior)
        if power >= 1.0:
            break
    return z


def _next(likely: Floats, most: float) -> float:
    """Return by how much the power of likelihoods rises for half of the draws to count."""

    def counts(rise: float) -> float:
        weights = np.exp(rise * (likely - np.max(likely)))
        return float(np.sum(weights) ** 2 / np.sum(weights**2))

    if counts(most) >= 0.5 * len(likely):
        return most
    low, high = 0.0, most
    for _ in range(40):
        middle = 0.5 * (low + high) if low > 0.0 else 0.1 * high
        low, high = (middle, high) if counts(middle) >= 0.5 * len(likely) else (low, middle)
        if low > 0.9 * high:
            break
    return low
