"""Errors that the steps of a converter make alike in every period of a signal, so that no scatter shows them.

Read in steps of q under normal noise of s rms, a waveform x has on average over the noise the error

    e = sum over k of c_k sin(2 pi k (x - level) / q),   c_k = (-1)^k q / (pi k) exp(-2 pi^2 k^2 s^2 / q^2)

(Widrow and Kollar, Quantization Noise, 2008, ch. 4 and 16; Gray, IEEE Trans. Inf. Theory 36 (1990) 1220). It
depends on where the levels lie to a fraction of the step: what it does to a mean, to an rms or to a line has
a mean square over levels in all places. Where they are known it has one over waveforms that differ by as much
as is not known of them: that levels lie evenly about a waveform is no chance, and its errors are then all in
odd harmonics, with twice as much power as they have otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.quantisation.few_steps import FewSteps, few_steps
from benchtool.analysis.quantisation.resolution import level_of

_DRAWS, _LEVELS = 24, 64
_APART = 0.1  # of a step, rms: how much the lines of two waveforms of the ensemble differ
_CELLS = 1 << 11  # of a step, in the table of its error
_NEGLIGIBLE = 1e-3  # of a step
_LAST_DIGIT = 1e-6  # of the strongest line: a smaller step is rounding, unless samples are at few places
_OF_STEPS = 1.25  # times the power that steps add on average: of one waveform it is another
_FEWEST_POINTS, _MOST_POINTS = 1 << 10, 1 << 16
_POINTS_PER_STEP = 7.2  # of the rms slope: the first two terms, of most of the power, do not fold back
_OF_PLACES = 2  # times as many where some of them count more than others
_AT_PLACES = 0.9  # mean vector of samples about their places
_WHOLE = 0.5  # of the distance of such points: rows that move by less over the record stay on their places
_TERMS = 20  # with which a share is computed
_FEW = 8.0  # steps, from least to greatest: below it a record does not show what its waveform is
_FEWEST_TURNS = 2
_NEAR = 2.0  # times as far apart as places of samples are on average
_FEWEST_CELLS, _CELLS_PER_POINT = 12, 32  # powers of two; of a period
_NOT_FOLLOWED, _COHERENT = 2.0, 0.5  # times the noise; share of a harmonic's power that is in the mean
_OF_SMEARED = 0.5  # share of what does not repeat, by harmonics whose phases wander
_LEAST_SLOPE, _UNSURE = 0.2, 0.05  # a weak line as read over as it is; share of the draws

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class RepeatedSteps:
    """Of one period of a waveform: `waveform`, shape (points,), at equal steps of its phase, and the `errors`
    of an ensemble of waveforms like it, shape (draws, points), times the share of samples at a point over the
    mean share. That period is one of `every` that the period has whose harmonics are asked for.
    """

    waveform: Floats
    errors: Floats
    every: int

    @property
    def are_few(self) -> bool:
        """Whether the waveform spans few steps, so that the errors are those of signals read alike."""
        return False

    def added_power(self, step: float) -> float:
        """Return the mean square that steps add to that of waveform and noise about their mean."""
        return _on_average(step)

    def of_mean(self, weights: Floats | float = 1.0) -> float:
        """Return the rms of the mean of the error times weights, shape (points,)."""
        return math.sqrt(float(np.mean(np.mean(self.errors * weights, axis=1) ** 2)))

    @property
    def of_square(self) -> float:
        """The standard deviation, over the ensemble, of the errors' mean square."""
        return float(np.std(np.mean(self.errors**2, axis=1)))

    @property
    def of_rms(self) -> float:
        """The rms of the change of the waveform's rms about its mean, beyond that by the added power."""
        deviation = self.waveform - np.mean(self.waveform)
        rms = float(np.std(self.waveform))
        return self.of_mean(deviation / rms) if rms > 0.0 else 0.0

    def of_lines(self, phasors: Complex) -> tuple[Floats, Floats]:
        """Return the rms of the change of the amplitudes of harmonics 1, 2 ..., shape (n,), with the phase of
        `phasors`, and the mean square of the amplitude that is added to each.
        """
        lines = self._lines(np.arange(1, len(phasors) + 1))
        along = np.real(lines * np.exp(-1j * np.angle(phasors)))
        return np.sqrt(np.mean(along**2, axis=0)), np.asarray(np.mean(np.abs(lines) ** 2, axis=0))

    def power_at(self, orders: NDArray[np.int64]) -> Floats:
        """Return the mean square of the amplitude that the errors have at these orders, shape (n,)."""
        return np.asarray(np.mean(np.abs(self._lines(orders)) ** 2, axis=0))

    def scatter_of_power(self, orders: NDArray[np.int64]) -> float:
        """Return the standard deviation, over the ensemble, of the sum of squares that the errors have at
        these orders, shape (n,), relative to its mean."""
        power = np.sum(np.abs(self._lines(orders)) ** 2, axis=1)
        mean = float(np.mean(power))
        return float(np.std(power)) / mean if mean > 0.0 else 0.0

    def largest_at(self, orders: NDArray[np.int64], share: float) -> float:
        """Return the amplitude that the largest of these orders, shape (n,), of the errors does not exceed in
        that share of the ensemble."""
        if len(orders) == 0:
            return 0.0
        return float(np.quantile(np.max(np.abs(self._lines(orders)), axis=1), share))

    @property
    def highest_order(self) -> int:
        return self.every * (int(self.errors.shape[1] - 1) // 2)

    def _lines(self, orders: NDArray[np.int64]) -> Complex:
        points = self.errors.shape[1]
        lines = self._transform[:, orders // self.every % points] * (2.0 / points)
        return np.asarray(lines * (orders % self.every == 0))

    @cached_property
    def _transform(self) -> Complex:
        return np.asarray(fft.fft(self.errors, axis=1))


@dataclass(frozen=True)
class _OfFewSteps(RepeatedSteps):
    """Errors of a waveform of few steps: those of all `signals` that would be read alike."""

    signals: FewSteps

    @property
    def are_few(self) -> bool:
        return True

    def added_power(self, step: float) -> float:
        read, before = self._squares
        return float(np.mean(read - before))

    @property
    def of_square(self) -> float:
        """The standard deviation, over the ensemble, of the errors' mean square."""
        return float(np.std(np.mean(self.errors**2, axis=1)))

    @property
    def of_rms(self) -> float:
        read, before = self._squares
        return float(np.std(np.sqrt(read) - np.sqrt(before)))

    @property
    def _squares(self) -> tuple[Floats, Floats]:
        """Mean squares of readings and of signals, with their noise, about their means, both (draws,)."""
        found = self.signals
        read = np.var(found.read, axis=1) + found.noise_read**2
        return read, np.var(found.signals, axis=1) + found.noise**2

    def of_lines(self, phasors: Complex) -> tuple[Floats, Floats]:
        """As of `RepeatedSteps`; the first is nan for a line of which next to nothing may be read."""
        orders = np.arange(1, len(phasors) + 1)
        errors, slope = self._lines(orders), self.signals.slope[:, np.newaxis]
        more = (phasors - errors) * (1.0 - 1.0 / np.maximum(slope, _LEAST_SLOPE))
        is_weak = ~np.isin(orders, self.signals.orders)
        along = np.abs(phasors) - np.abs(phasors - errors - is_weak * more)
        found = np.sqrt(np.mean(along**2, axis=0))
        if np.mean(slope < _LEAST_SLOPE) > _UNSURE:
            found[is_weak] = math.nan
        return found, np.asarray(np.mean(np.abs(errors) ** 2, axis=0))


def rms_before_steps(rms: float, step: float, repeated: RepeatedSteps | None = None) -> float:
    """Return the rms of a signal about its mean before a converter, of whose readings this is the `rms`.

    `repeated` are the errors of the steps that are alike in every period; None where noise hides them.
    """
    added = _on_average(step) if repeated is None else repeated.added_power(step)
    return math.sqrt(max(0.0, rms**2 - added))


def _on_average(step: float) -> float:
    """Return the mean square that steps add to that of a signal that spans many of them, or whose noise hides
    them (Widrow and Kollár, ch. 4)."""
    return step**2 / 12.0


def most_of_steps(step: float) -> float:
    """Return the mean square of lines up to which steps may have made them."""
    return _OF_STEPS * _on_average(step)


def repeated_steps(
    mean: float,
    phasors: Complex,
    step: float,
    beside: float,
    samples: float,
    periods: int,
    turns: Floats | None = None,
    level: float | None = None,
) -> RepeatedSteps | None:
    """Return the errors of a quantised signal that are the same in every period; None where noise hides them,
    or a period has no harmonics, or where samples are everywhere in it and steps a millionth of a line.

    Of the measured harmonics 1, 2 ..., peak `phasors` of shape (n,), the waveform takes the strongest, until
    those left out are no more together than the quantisation's own rms: weaker ones may be made by it. Where
    that is few steps of known levels, errors are those of signals that would be read alike (`few_steps`).

    Args:
        mean, phasors: of the signal as measured.
        step: of the converter.
        beside: mean square of all that differs from period to period, the steps' own part among it.
        samples: in all periods; where a whole number of them is in one or a few periods, they fall on the
            same few places of the waveform again and again.
        periods: of the record.
        turns: where the samples are, in periods from the phase of the phasors on, shape (n,), if it is known:
            those of a speed that swings are at some places more often than at others.
        level: a value that the converter gives, where it is known; without it levels may be anywhere.
    """
    table = _error_of_a_step(noise_beside(beside, step) / step)
    if table is None or not len(phasors):
        return None
    kept = _without_the_weakest(phasors, step)
    if level is not None and _spanned(kept, step) < _FEW:
        points = _distinct(samples, periods, max(_FEWEST_POINTS, 4 * len(phasors)))
        found = few_steps(mean, phasors, step, level, max(0.0, beside), samples, points)
        read = np.mean(found.read, axis=0)
        return _OfFewSteps(read, found.read - found.signals, 1, found)
    needed = _needed(kept, step)
    points = _distinct(samples, periods, needed)
    if turns is not None and points < needed and _stay(turns, points):
        turns = None
    at_same_places = points < needed and turns is None
    if not at_same_places and not step > _LAST_DIGIT * float(np.max(np.abs(phasors))):
        return None
    every = 1
    if not at_same_places:
        # of orders 12 and 24 alone a waveform has a period of a twelfth, and so have its errors
        every = math.gcd(*map(int, np.flatnonzero(kept) + 1)) or 1
        kept = kept[every - 1 :: every]
        points = min(_MOST_POINTS, _needed(kept, step) * (1 if turns is None else _OF_PLACES))
    waveform = mean + _waveforms(kept[np.newaxis], points)
    if level is None:
        waveforms, levels = waveform, step * np.arange(_LEVELS)[:, np.newaxis] / _LEVELS
        if at_same_places:
            waveforms = waveform + _unread(waveform[0], table, step)
    else:
        waveforms, levels = mean + _waveforms(_like(kept, step), points), np.array([level])
    errors = _looked_up(table, waveforms - levels, step)
    if turns is not None:
        place = np.floor(np.mod(every * turns, 1.0) * points).astype(np.int64) % points
        errors *= np.bincount(place, minlength=points) * (points / len(turns))
    return RepeatedSteps(waveform[0], errors, every)


def steps_of_periods(
    samples: Floats, begins: NDArray[np.int64], per_revolution: int, step: float, turns: Floats
) -> RepeatedSteps | None:
    """Return the errors of a converter's steps in samples, shape (n,), that are the same in every period or,
    where the waveform spans few steps, in every revolution; None where noise hides them.

    `begins`, shape (periods + 1,), are the rows at which periods begin, of which so many make a revolution.
    `turns`, shape (n,), is where samples are, in periods.
    """
    of_period = _Repeated.of(samples, begins, turns)
    if _spanned(_without_the_weakest(of_period.phasors, step), step) < _FEW:
        rows = begins[::per_revolution]
        is_period = per_revolution == 1 or len(rows) <= _FEWEST_TURNS
        of_turn = of_period if is_period else _Repeated.of(samples, rows, turns / per_revolution)
        found = of_turn.errors(step, level_of(samples, step))
        if found is not None and found.are_few:
            return found
    # where the mean lies between levels is off by what it is read wrong
    return of_period.errors(step, turns=turns)


@dataclass(frozen=True)
class _Repeated:
    """The mean of `periods` of a signal, its harmonics 1, 2 ..., peak `phasors` of shape (n,), and the mean
    square of the noise that is left, of so many `samples`."""

    mean: float
    phasors: NDArray[np.complex128]
    noise2: float
    samples: float
    periods: int

    @staticmethod
    def of(samples: Floats, begins: NDArray[np.int64], turns: Floats) -> _Repeated:
        """Return that of samples, shape (n,), whose periods begin at these rows, shape (periods + 1,), and
        which lie at `turns`, shape (n,), in periods."""
        periods, whole = len(begins) - 1, slice(begins[0], begins[-1])
        points = round((begins[-1] - begins[0]) / periods)
        values, place = samples[whole], np.mod(turns[whole], 1.0)
        mean = float(np.mean(values))
        cells = 1 << max(_FEWEST_CELLS, math.ceil(math.log2(_CELLS_PER_POINT * points)))
        cell = np.round(place * cells).astype(np.int64) % cells
        sums = np.bincount(cell, values - mean, cells)
        phasors = fft.rfft(sums)[1 : points // 2 + 1] * (2.0 / len(values))
        if points % 2 == 0:
            phasors[-1] *= 0.5
        # neighbours in the order of their places are apart by noise alone, where these are the same
        order = np.argsort(place, kind="stable")
        near = np.diff(place[order]) < _NEAR / len(values)
        left = 0.5 * float(np.mean(np.diff(values[order])[near] ** 2)) if np.any(near) else math.inf
        # nor are periods that the track does not follow closely, which leave neighbouring samples alike
        noise2 = min(left, float(np.mean(np.diff(samples, 2) ** 2)) / 6.0)
        if left > _NOT_FOLLOWED * noise2:
            at = begins[:-1, np.newaxis] + np.diff(begins)[:, np.newaxis] * (np.arange(points) / points)
            table = samples[np.minimum(np.round(at).astype(np.int64), len(samples) - 1)]
            smeared = _smeared(table, phasors)
            lost = 0.5 * float(np.sum(np.abs(phasors) ** 2 * (smeared**2 - 1.0)))
            if lost < _OF_SMEARED * left:  # noise has a memory
                noise2 = left
            else:
                phasors *= smeared
        return _Repeated(mean, phasors, noise2, float(len(values)), periods)

    def errors(
        self, step: float, level: float | None = None, turns: Floats | None = None
    ) -> RepeatedSteps | None:
        return repeated_steps(
            self.mean, self.phasors, step, self.noise2, self.samples, self.periods, turns, level
        )


def _smeared(table: Floats, phasors: Complex) -> Floats:
    """Return by how much the harmonics of the periods in rows of a table, shape (periods, points), are larger
    than those of their mean, shape (n,), which the wander of their phases makes smaller; 1 for those that are
    hardly in it."""
    points = table.shape[1]
    power = np.mean(np.abs(fft.rfft(table, axis=1)[:, 1:]) ** 2, axis=0) * (2.0 / points) ** 2
    if points % 2 == 0:
        power[-1] *= 0.25
    of_mean = np.abs(phasors) ** 2
    share = np.divide(of_mean, power, out=np.zeros(len(power)), where=power > 0.0)
    return np.asarray(np.where(share > _COHERENT, 1.0 / np.sqrt(np.maximum(share, _COHERENT)), 1.0))


def _spanned(kept: Complex, step: float) -> float:
    return 2.0 * float(np.sum(np.abs(kept))) / step


def _needed(kept: Complex, step: float) -> int:
    """Return at how many places of a waveform its errors are to be looked up."""
    slope = 2.0 * np.pi / step * np.arange(1, len(kept) + 1) * np.abs(kept)  # of each, steps per period
    of_slope = math.ceil(_POINTS_PER_STEP * math.sqrt(0.5 * float(np.sum(slope**2))))
    return min(_MOST_POINTS, max(_FEWEST_POINTS, 4 * len(kept), of_slope))


def _error_of_a_step(noise: float) -> Floats | None:
    """Return the mean error, in steps, over one step of the waveform, under noise of that many steps rms;
    None where it is negligible."""
    most = math.sqrt(math.log(1.0 / (math.pi * _NEGLIGIBLE)) / 2.0) / math.pi  # steps of noise for one term
    if noise > most:
        return None
    place = (np.arange(_CELLS) + 0.5) / _CELLS
    terms = np.arange(1, math.ceil(2.0 * most / noise) + 1 if noise > most / _CELLS else 1)
    if not len(terms):
        return np.asarray(np.round(place) - place)
    size = (-1.0) ** terms / (math.pi * terms) * np.exp(-2.0 * (math.pi * noise * terms) ** 2)
    return np.asarray(size @ np.sin(2.0 * np.pi * np.outer(terms, place)))


def error_of_steps(signal: Floats, step: float, noise_rms: float, level: Floats | float) -> Floats | None:
    """Return the mean error, over noise, of a signal, shape (n,), read in steps one of which is at `level`;
    or of signals, shape (draws, n), in steps at levels, shape (draws, 1). None where it is negligible."""
    table = _error_of_a_step(noise_rms / step)
    return None if table is None else _looked_up(table, signal - level, step)


def _looked_up(table: Floats, above: Floats, step: float) -> Floats:
    cells = np.floor(np.mod(above / step, 1.0) * _CELLS).astype(np.int64) % _CELLS
    return np.asarray(step * table[cells])


def _like(phasors: Complex, step: float) -> Complex:
    """Return phasors, shape (draws, n), each of whose lines differs by a part of a step."""
    apart = np.random.default_rng(0).standard_normal((2, _DRAWS, len(phasors)))
    return np.asarray(phasors + (_APART * step) * (phasors != 0.0) * (apart[0] + 1j * apart[1]))


def _unread(waveform: Floats, table: Floats, step: float) -> Floats:
    """Return what a waveform that is read at the same places in every period, shape (points,), may differ
    from what was read, shape (draws, points): as far as it lies at levels, anything within a step.

    That of neighbours is independent where they are more than a step apart; a waveform that rests is read
    wrong by the same everywhere, whatever that is.
    """
    at_levels = abs(complex(np.mean(np.exp(2j * np.pi * waveform / step))))
    if float(np.median(np.abs(np.diff(waveform)))) < step:
        at_levels = 0.0
    size = step * math.sqrt(3.0 * at_levels * float(np.mean(table**2)))
    return size * np.random.default_rng(0).uniform(-1.0, 1.0, (_LEVELS, len(waveform)))


def _waveforms(phasors: Complex, points: int) -> Floats:
    """Return the waveforms of harmonics 1, 2 ..., shape (draws, n), at equal steps of a period, shape (draws,
    points)."""
    bins = np.zeros((points, len(phasors)), dtype=np.complex128)
    np.add.at(bins, np.arange(1, phasors.shape[1] + 1) % points, phasors.T)
    return np.real(fft.ifft(bins, axis=0).T * points)


def noise_beside(power: float, step: float) -> float:
    """Return the rms of the noise in a signal, by the mean square of what does not repeat: of that a twelfth
    of the step's square may be of the steps themselves."""
    return math.sqrt(max(0.0, power - _on_average(step)))


def share_left(noise_rms: float, step: float) -> float:
    """Return the rms of the error of a mean, of steps under noise, over that of steps without: 1 / sqrt(12)
    of them.

    The terms are by the characteristic function of the noise; of one whose distribution is not known it is
    that of Laplace's, with which more is left than with the normal one.
    """
    number = np.arange(1, _TERMS + 1)
    left = 1.0 / (1.0 + 2.0 * (math.pi * number * noise_rms / step) ** 2)
    return math.sqrt(float(np.sum((left / number) ** 2) / np.sum(1.0 / number**2)))


def _stay(turns: Floats, places: int) -> bool:
    """Return whether samples are at that many equally spaced places of the period, again and again."""
    return float(np.abs(np.mean(np.exp(2j * np.pi * places * turns)))) > _AT_PLACES


def _without_the_weakest(phasors: Complex, step: float) -> Complex:
    power = 0.5 * np.abs(phasors) ** 2
    order = np.argsort(power)
    weak = order[np.cumsum(power[order]) <= most_of_steps(step)]
    kept = phasors.copy()
    kept[weak] = 0.0
    return kept


def periods_to_same_places(per_period: float, periods: int, rows: float) -> int | None:
    """Return the fewest periods that hold so nearly a whole number of samples, `per_period` each, that over
    all `periods` of a record samples stay within so many `rows` of their places; None where none do."""
    together = np.arange(1, periods + 1)
    moved = np.abs(together * per_period - np.round(together * per_period)) * periods / together
    same = np.flatnonzero(moved <= rows)
    return int(together[same[0]]) if len(same) else None


def _distinct(samples: float, periods: int, needed: int) -> int:
    """Return at how many places of the waveform the samples are, at most as many as are needed."""
    per_period = samples / periods
    together = periods_to_same_places(per_period, periods, _WHOLE * per_period / needed)
    return needed if together is None else min(needed, round(together * per_period))
