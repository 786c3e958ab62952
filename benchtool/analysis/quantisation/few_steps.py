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
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.readings import Readings

_DRAWS = 120  # of each model
_MOST_LINES, _MORE_LINES = 5, 2
_FEWEST_POINTS, _PER_CYCLE, _MOST_POINTS = 128, 16, 2048
_POINTS_PER_LINE = 6
_TIMES_SHOWN, _MOST_SHOWN = 4, 1 << 15
_TOLERANCE = 0.01  # of a step: what places in the period and rows between them make of a line
_OF_VARIANCE, _LEAST_VARIANCE = 0.2, 2e-3  # of its logarithm; of a step's square
_LEAST_NOISE, _MOST_NOISE = 5e-3, 0.8  # steps
_STANDS_OUT, _HARDLY = 4.0, 1e-9  # standard deviations: a line that those before do not make
_OF_DRAWS = 0.1  # share that makes all lines: the others may not have come to it
_LEAST_LINE = 0.05  # steps: below it a line is as likely at any size
_AHEAD = 0.02  # steps, for a slope
_MOVES, _LAST_MOVES = 8, 24
_SCALED_EACH, _SCALES = 3, np.array([0.5, 0.2, 0.05])  # of the moves; rms of a logarithm
_SMALLER = np.array([1.0, 1.0, 0.3, 0.1])  # of the difference of two draws
_MOST_STAGES = 60

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


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

    The strongest harmonics are taken in, then the strongest of those that they do not make, until they make
    all. `points` are the places of a period at which there are samples; more than needed are as good as all.
    """
    in_steps = (math.sqrt(beside) / step) ** 2  # the square of a tiny step is zero
    record = _Record((mean - level) / step, phasors / step, in_steps, samples, points)
    fewest, sample = _fewest_lines(record)
    richer = _Model(record, _with_strongest(fewest.orders, np.abs(record.lines), _MORE_LINES))
    shown = fewest.shown(sample, richer.orders), richer.shown(richer.sampled(_DRAWS), richer.orders)
    signals, read, noise, noise_read, slope = (np.concatenate(each) for each in zip(*shown, strict=True))
    return FewSteps(
        level + step * signals,
        level + step * read,
        step * noise,
        step * noise_read,
        slope,
        richer.orders,
    )


def _fewest_lines(record: _Record) -> tuple[_Model, Floats]:
    """Return signals of as few lines as make all those of a record, and a sample of their unknowns."""
    size = np.abs(record.lines)
    orders = np.array([1 + int(np.argmax(size))])
    while True:
        model = _Model(record, orders)
        sample = model.sampled(_DRAWS)
        missing = model.missing(sample)
        if len(orders) == _MOST_LINES or np.quantile(np.max(missing, axis=1), _OF_DRAWS) < _STANDS_OUT:
            return model, sample
        stands_out = np.median(missing, axis=0)
        more = _with_strongest(orders, np.where(stands_out > _STANDS_OUT, size, _HARDLY * stands_out), 1)
        if len(more) == len(orders):
            return model, sample
        orders = more


def _with_strongest(orders: NDArray[np.int64], size: Floats, count: int) -> NDArray[np.int64]:
    """Return orders with so many of the others whose size, shape (harmonics,), is largest, none of zero, as
    far as the places of a waveform tell them from each other."""
    least = len(orders)
    for order in 1 + np.argsort(-size):
        joined = np.append(orders, order)
        is_told = np.max(joined) // np.gcd.reduce(joined) <= _MOST_POINTS // _POINTS_PER_LINE
        if order not in orders and size[order - 1] > 0.0 and is_told:
            orders = joined
        if len(orders) == least + count:
            break
    return orders


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
class _Model:
    """Signals with lines of some `orders`, in steps, of which a record may be. Unknown are their mean, the
    logarithm of the noise's rms, its shape, and real and imaginary parts of the lines, peak."""

    record: _Record
    orders: NDArray[np.int64]

    @cached_property
    def common(self) -> int:
        """Periods of the signals in one of the record."""
        return int(np.gcd.reduce(self.orders))

    @cached_property
    def _needed(self) -> int:
        points, cycles = _FEWEST_POINTS, int(np.max(self.orders)) // self.common
        while points < min(_PER_CYCLE * cycles, _MOST_POINTS):
            points *= 2
        return points

    @cached_property
    def are_few(self) -> bool:
        """Whether the record has samples at few places of the signals, always the same ones."""
        record = self.record
        return record.points % self.common == 0 and record.points // self.common < self._needed

    @cached_property
    def points(self) -> int:
        return self.record.points // self.common if self.are_few else self._needed

    @cached_property
    def _seen(self) -> Complex:
        """The harmonics of the record at the signals' own, as far as their places show them."""
        own = self.record.lines[self.common - 1 :: self.common]
        return own[: (self.points - 1) // 2 if self.are_few else self.points // _POINTS_PER_LINE]

    @cached_property
    def _smoothed(self) -> Complex:
        """What means from each place to the next make of these."""
        order = np.arange(1, len(self._seen) + 1) / self.points
        smoothed = np.ones(len(order)) if self.are_few else np.sinc(order) * np.exp(1j * np.pi * order)
        return np.asarray(smoothed, dtype=np.complex128)

    def signals(self, z: Floats, points: int, common: int) -> Floats:
        """Return the signals at so many places of a period, so many of which are in that of the record, shape
        (draws, points)."""
        lines = z[:, 3 : 3 + len(self.orders)] + 1j * z[:, 3 + len(self.orders) :]
        bins = np.zeros((len(z), points), dtype=np.complex128)
        for cycles, line in zip(self.orders // common, lines.T, strict=True):
            bins[:, cycles % points] += line
        return np.asarray(z[:, :1] + points * np.real(fft.ifft(bins, axis=1)))

    def log_likelihood(self, z: Floats) -> Floats:
        readings = Readings.of(np.exp(z[:, 1]), np.clip(z[:, 2], -1.0, 1.0))
        signals = self.signals(z, self.points, self.common)
        read, variance = readings.at(signals) if self.are_few else readings.from_place_to_place(signals)
        bins = fft.rfft(read, axis=1)[:, : len(self._seen) + 1] * (2.0 / self.points)
        off = np.sum(np.abs(bins[:, 1:] / self._smoothed - self._seen) ** 2, axis=1)
        off += 2.0 * (0.5 * bins[:, 0].real - self.record.mean) ** 2
        beside = np.mean(variance, axis=1) + _LEAST_VARIANCE
        ratio = np.log(beside / (self.record.beside + _LEAST_VARIANCE))
        return np.asarray(-0.5 * off / self.record.of_line**2 - 0.5 * (ratio / _OF_VARIANCE) ** 2)

    def log_prior(self, z: Floats) -> Floats:
        """Of lines and noise of any size, in the logarithm, alike, and of any shape."""
        lines = np.hypot(z[:, 3 : 3 + len(self.orders)], z[:, 3 + len(self.orders) :])
        within = (z[:, 1] > math.log(_LEAST_NOISE)) & (z[:, 1] < math.log(_MOST_NOISE))
        within &= (np.abs(z[:, 0] - self.record.mean) < 1.0) & (np.abs(z[:, 2]) < 1.0)
        return np.where(within, -2.0 * np.sum(np.log(lines + _LEAST_LINE), axis=1), -np.inf)

    def scaled(self, z: Floats, logarithm: Floats) -> tuple[Floats, Floats]:
        """Return signals and noise scaled about the edge next to their mean, by factors whose logarithms have
        shape (draws,), and the logarithm of what that does to a volume: without noise a record only tells
        when edges are passed."""
        factor, edge = np.exp(logarithm)[:, np.newaxis], np.floor(z[:, :1]) + 0.5
        moved = np.concatenate([edge + factor * (z[:, :1] - edge), z[:, 1:3], factor * z[:, 3:]], axis=1)
        moved[:, 1] += logarithm
        # the way back is about the same edge
        is_same = np.floor(moved[:, 0]) == np.floor(z[:, 0])
        return moved, np.where(is_same, (z.shape[1] - 2) * logarithm, -np.inf)

    def sampled(self, count: int) -> Floats:
        """Return so many samples of the unknowns with which it would be read as the record was."""
        random = np.random.default_rng(0)
        start = random.uniform(-1.0, 1.0, (count, 3 + 2 * len(self.orders)))
        start[:, 0] = self.record.mean + 0.5 * start[:, 0]
        start[:, 1] = np.log(np.geomspace(1.01 * _LEAST_NOISE, 0.99 * _MOST_NOISE, count))
        own = self.record.lines[self.orders - 1]
        start[:, 3:] = 0.5 * start[:, 3:] + np.concatenate([own.real, own.imag])
        return _sampled(self, start, random)

    def missing(self, z: Floats) -> Floats:
        """Return by how many standard deviations the other harmonics of the record differ from those read,
        shape (draws, harmonics)."""
        read = self.shown(z, self.orders)[1]
        bins = fft.rfft(read, axis=1)[:, 1:] * (2.0 / read.shape[1])
        apart = np.tile(self.record.lines, (len(z), 1))
        taken = min(apart.shape[1], bins.shape[1])
        apart[:, :taken] -= bins[:, :taken]
        apart[:, self.orders - 1] = 0.0
        return np.asarray(np.abs(apart) / self.record.of_line)

    def shown(self, z: Floats, orders: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Return signals, what is read of them, both over a period of the record at as many places as these
        orders need, their noise before and after, and what is read of a weak line, for all draws."""
        model = _Model(self.record, orders)
        points = model.points if model.are_few else model.places_shown
        signals = self.signals(z, points, model.common)
        noise, shape = np.exp(z[:, 1]), np.clip(z[:, 2], -1.0, 1.0)
        read, variance = Readings.of(noise, shape).at(signals)
        # the mean density of readings at the edges between steps
        dithered = Readings.of(np.maximum(noise, _LEAST_LINE), shape)
        more, less = (dithered.at(signals + apart)[0] for apart in (_AHEAD, -_AHEAD))
        slope = np.mean(more - less, axis=1) / (2.0 * _AHEAD)
        signals, read = (np.tile(each, (1, model.common)) for each in (signals, read))
        return signals, read, noise, np.sqrt(np.mean(variance, axis=1)), slope

    @property
    def places_shown(self) -> int:
        """Places of the signals' period at which lines of the record are seen, as far as there is room."""
        points, lines = self.points, len(self.record.lines) // self.common
        cycles = int(np.max(self.orders)) // self.common
        while points * self.common > _MOST_SHOWN and points > _PER_CYCLE * cycles:
            points //= 2
        while points < _TIMES_SHOWN * max(self.points, lines) and 2 * points * self.common <= _MOST_SHOWN:
            points *= 2
        return points


def _sampled(model: _Model, start: Floats, random: np.random.Generator) -> Floats:
    """Return a sample of the likely unknowns of a model from a broad one, both of shape (draws, unknowns)."""
    z, count = start, len(start)
    likely, prior, power = model.log_likelihood(z), model.log_prior(z), 0.0
    for _ in range(_MOST_STAGES):
        rise = _next(likely, 1.0 - power)
        weights = np.exp(rise * (likely - np.max(likely)))
        chosen = random.choice(count, count, p=weights / np.sum(weights))
        z, likely, prior, power = z[chosen], likely[chosen], prior[chosen], power + rise
        for move in range(_MOVES if power < 1.0 else _LAST_MOVES):
            moved, of_volume = _towards_others(z, random), np.zeros(count)
            if move % _SCALED_EACH == 0:
                moved, of_volume = model.scaled(z, random.normal(0.0, random.choice(_SCALES, count)))
            its, before = model.log_likelihood(moved), model.log_prior(moved)
            odds = power * (its - likely) + before - prior + of_volume
            taken = np.log(random.random(count)) < odds
            z = np.where(taken[:, np.newaxis], moved, z)
            likely, prior = np.where(taken, its, likely), np.where(taken, before, prior)
        if power >= 1.0:
            break
    return z


def _towards_others(z: Floats, random: np.random.Generator) -> Floats:
    """Return draws moved by differences of others, all of shape (draws, unknowns)."""
    one, other = random.permutation(len(z)), random.permutation(len(z))
    scale = 1.7 / math.sqrt(z.shape[1]) * random.choice(_SMALLER, (len(z), 1))
    return np.asarray(z + scale * (z[one] - z[other]) + 1e-4 * random.standard_normal(z.shape))


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
