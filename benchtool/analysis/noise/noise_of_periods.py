"""Noise floor beside harmonics that change, by what differs between successive periods."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum
from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.noise.noise import (
    NoiseFloor,
    followed_bins,
    noise_floor,
    relative_to_found,
    sidebands,
)
from benchtool.analysis.noise.noise_over_time import ONE_LEVEL
from benchtool.analysis.noise.swing_of_periods import without_swing

_BY_CHANCE = 1e-2  # of a ratio of variances
_BESIDE = 2  # orders
_OF_WHITE = 6.0  # 1 + 4 + 1: the power of a second difference, times that of white noise
_AS_ONE = 35.0 / 18.0  # second differences overlap: the sum of their squared correlations
_ALIKE = 1e-3  # by chance, of the powers of two differences
_LEAST = 0.95  # of a power: with more, a floor without a step stays as it is
_FEWEST_PERIODS = 7  # of five differences two are without a step, wherever it is
_FEWEST_BESIDE_A_STEP = 4  # periods: of three one difference tells no step from noise
_OF_A_STEP, _ONE_IN = 3, 20  # differences that a step is in, and of many, that may have more besides
_FEWEST_TO_SCATTER = 4  # powers
_BESIDE_STEPS = 2.0  # times what errors of steps come to that are white
_MANY_PERIODS = 32  # in which a phase moves so slowly that differences hardly show what is left of it
_PARTLY = 0.25  # of the distance between two levels
_GUARD = 2  # bins beside a line, or dc, from where on they count
_IMAGE = 0.2  # of sidebands of a ramp, those of its image at the negative frequency, in quadrature to it
_ONE_LINE_IN = 10  # pairs of sidebands, in which a phase that swings may be
_MOST_TAKEN = 0.5  # of a power
_MOST_VARIANCE = 0.5  # of a power, relative: with more, so few differences do not tell it


class NoFloor(Enum):
    """Why the noise between harmonics is not known; the value says it to a reader."""

    FEW_BINS = "fewer than 8 bins are between harmonics: record longer"
    TAKEN = (
        "sinusoids between the harmonics, or a dc that decays, are where the noise is most, and not told "
        "from it: record longer"
    )
    FEW_PERIODS = (
        f"the harmonics change, and the differences of fewer than {_FEWEST_PERIODS} periods do not tell a "
        f"step from noise: record longer"
    )
    SILENT = (
        "the harmonics change, and most periods are the same to the last digit, which have no noise between "
        "them: record while the signal is on"
    )
    BURSTS = (
        "the harmonics change, and so does the noise, in bursts: what is of either is not told apart; record "
        "while both are steady"
    )
    UNCERTAIN = (
        "the harmonics change, and the differences between periods are too few to tell the noise beside it: "
        "record longer, or at a higher rate"
    )


@dataclass(frozen=True)
class _Differences:
    """Mean square of a bin by the second differences of successive periods, its relative variance, and how
    many of them were left out of how many, `in_a_step` of which a step is in; `from_first` is that of the
    bins from order 1 on, `below` that of the lowest orders, which those below order 1 are taken to have,
    `with_bursts` that of all differences.
    """

    power: float
    from_first: float
    below: float
    with_bursts: float
    variance: float
    left_out: int
    of: int
    in_a_step: int

    @property
    def has_bursts(self) -> bool:
        """Whether more have more than the others than a step would leave: noise in bursts is no step."""
        return self.left_out > self.in_a_step + self.of // _ONE_IN


def without_changes(
    floor: NoiseFloor | None,
    spectrum: CoherentSpectrum,
    samples: CoherentSamples,
    *,
    has_stepped: bool,
    follows_signal: bool = False,
    step: float = 0.0,
) -> NoiseFloor | NoFloor:
    """Return the floor of a spectrum, of these samples, without what harmonics leave in it whose amplitude or
    phase changes.

    A ramp, or a step, of an amplitude has sidebands that fall off as the inverse distance, and are more than
    the noise in all bins of a spectrum. They are in phase with the harmonic, and those of a phase in
    quadrature to it, as of one that slips too little to be followed: where the fundamental has more of the
    one than of the other, the floor is by the second differences of successive periods if these have less.
    Neither a harmonic nor a ramp is in them; a step is in three, which are left out where they have more, and
    what bends otherwise shows in the fundamental first. What is below order 1 these differences do not show:
    it is as at the lowest orders, unless sidebands of the fundamental have more. Of an amplitude that
    `has_stepped` the step was divided out, but for what it leaves in the period that it is in. There is none
    where too few differences tell it, or more of them have more than a step would leave, and all together
    have less than the spectrum.

    Where they do not have less, they tell how probable it is that a phase that follows the signal over many
    periods has left something; the counts of an angle leave fast errors.
    """
    if floor is None:
        return NoFloor.FEW_BINS
    if floor.taken > _MOST_TAKEN:
        return NoFloor.TAKEN
    if samples.periods < 3 or samples.per_period < 2 * (_BESIDE + 2):
        return floor
    of_steps = math.sqrt(step**2 / 3.0 / samples.samples)
    if floor.amplitude < _BESIDE_STEPS * of_steps:
        return floor
    changes = has_stepped or _changes(spectrum, floor.over_time.evenness, follows_signal)
    tells_rest = follows_signal and floor.least < 1.0 and samples.periods >= _MANY_PERIODS
    if not changes and not tells_rest:
        return floor
    found = _differences(samples)
    if isinstance(found, NoFloor):
        return found if changes else floor
    from_first = noise_floor(spectrum, 1.0) or floor
    there = from_first.amplitude**2
    if not there > 0.0:
        return floor
    if tells_rest:
        of_noise = math.sqrt((found.with_bursts if found.has_bursts else found.from_first) / there)
        all_noise = _all_noise(floor.least, of_noise, 0.5 * math.sqrt(found.variance))
        floor = replace(floor, all_noise=all_noise)
    least = 1.0 if has_stepped else _LEAST
    # noise in bursts is in all of them, and more than they have is of what changes; a step is in three
    all_of_them = found.has_bursts and not has_stepped
    by_differences = found.with_bursts if all_of_them else found.from_first
    if not changes or not 0.0 < by_differences < least * there:
        return floor
    if found.has_bursts:
        return NoFloor.BURSTS
    if found.variance > _MOST_VARIANCE:
        return NoFloor.UNCERTAIN
    power, variance = found.power, found.variance
    if not has_stepped:  # of a step something is left beside the fundamental in any phase
        power, variance = _with_lowest(found, spectrum, samples.usable_order)
    return replace(
        floor,
        highest=math.sqrt(power),
        of_bins=relative_to_found(math.sqrt(variance)),
        least=1.0,
        dof=2.0 / variance,
        over_time=ONE_LEVEL,
    )


def _with_lowest(found: _Differences, spectrum: CoherentSpectrum, orders: float) -> tuple[float, float]:
    """Return the power of differences over so many orders, and its relative variance, with what the noise
    below order 1 has more than at the lowest orders, if it is clearly more.

    It shows in the sidebands of the fundamental, in phase with it or in quadrature to it, whichever of both
    has less of what changes: they have the mean of both sides, of the orders from 0 to 2.
    """
    known = found.power, found.variance
    reach = spectrum.periods - _GUARD
    if reach <= _GUARD:
        return known
    pairs = sidebands(spectrum.phasor, spectrum.periods, reach)
    pair, moved = sorted((each[_GUARD - 1 :] for each in pairs), key=lambda each: float(np.sum(each)))
    but_lines = np.sort(moved)[: len(moved) - len(moved) // _ONE_LINE_IN]
    if float(np.sum(pair)) < _IMAGE * float(np.sum(but_lines)):
        return known
    both = 0.5 * float(np.mean(pair))
    alike = float(np.sum(pair)) ** 2 / float(pair @ pair)
    if not _is_more(both, found.below, 2.0 * alike, _ALIKE):
        return known
    power = found.power + 2.0 * (both - found.below) / orders
    of_both = (2.0 * both / orders) ** 2 / alike
    return power, (found.variance * found.power**2 + of_both) / power**2


def _all_noise(least: float, ratio: float, standard: float) -> float:
    """Return the probability that a floor has noise alone, and not `least` of it, which is below 1, by
    another estimate of it, `ratio` of it, and the standard uncertainty of that.

    A rest of a phase may be partly in that estimate too: so much of the distance counts as uncertain.
    """
    variance = standard**2 + (_PARTLY * (1.0 - least)) ** 2
    log_odds = 0.5 * ((ratio - least) ** 2 - (ratio - 1.0) ** 2) / variance
    return 0.5 * (1.0 + math.tanh(0.5 * log_odds))


def _differences(samples: CoherentSamples) -> _Differences | NoFloor:
    """Return what second differences of successive periods tell of the noise from order 1 on; a reason where
    they are too few to tell a step from it, or have nothing in most of the record."""
    phasors = fft.rfft(samples.values.reshape(samples.periods, -1), axis=1) * (2.0 / samples.per_period)
    phasors = phasors[:, 1 : max(_BESIDE + 2, math.floor(samples.usable_order) + 1)]
    differences = np.diff(phasors, 2, axis=0)
    square = np.abs(differences) ** 2 / _OF_WHITE / samples.periods
    own, beside = square[:, 0], np.mean(square[:, 1 : 1 + _BESIDE], axis=1)
    typical = float(np.median(own)), float(np.median(beside))  # of those without a step
    if _is_more(*typical, len(own)):
        left = without_swing(differences)
        others = square[:, 1:] if left is None else np.abs(left) ** 2 / _OF_WHITE / samples.periods
        square = np.insert(others, 0, np.mean(others[:, :_BESIDE], axis=1), axis=1)
    of_orders, half = np.median(square, axis=0), square.shape[1] // 2
    lower, upper = float(np.mean(of_orders[:half])), float(np.mean(of_orders[half:]))
    if samples.periods < _FEWEST_PERIODS and (
        samples.periods < _FEWEST_BESIDE_A_STEP or _is_more(lower, upper, half)
    ):
        # a step, the power of whose part of a period falls with the square of the order
        return NoFloor.FEW_PERIODS
    of_each = np.mean(square, axis=1)
    order = np.argsort(of_each)
    usual = float(of_each[order[len(order) // 8]])  # a step is in three, and the least of many is low
    if not usual > 0.0:
        return NoFloor.SILENT
    quiet = square[order[: max(1, len(order) // 2)]]
    alike = _alike(quiet)
    kept = [index for index, each in enumerate(of_each) if not _is_more(each, usual, alike, _ALIKE)]
    alike = min(_alike(square[kept]), _even(of_each[kept]))
    from_first, below = float(np.mean(of_each[kept])), float(np.mean(square[kept, : 1 + _BESIDE]))
    of_one, of_below = _AS_ONE / len(kept), 1.0 / samples.usable_order
    power = (1.0 - of_below) * from_first + of_below * below
    variance = of_one / alike + (of_below * below / power) ** 2 * of_one / (1 + _BESIDE)
    left_out = len(of_each) - len(kept)
    in_a_step = _OF_A_STEP + len(differences) - len(square)  # where the fit has those before and after
    of_all = float(np.mean(of_each))
    return _Differences(power, from_first, below, of_all, variance, left_out, len(of_each), in_a_step)


def _alike(square: NDArray[np.float64]) -> float:
    """Return of how many orders alike the mean would scatter as that of these, of shape (differences,
    orders), which scatter themselves."""
    of_orders = np.mean(square, axis=0)
    scatter = 1.0 + _AS_ONE / len(square)
    return scatter * float(np.sum(of_orders)) ** 2 / float(of_orders @ of_orders)


def _even(powers: NDArray[np.float64]) -> float:
    """Return how many orders alike would have means that scatter as these do; as many as may be where they
    are too few to tell."""
    if len(powers) < _FEWEST_TO_SCATTER:
        return math.inf
    variance = float(np.var(powers, ddof=1))
    return float(np.mean(powers)) ** 2 / variance if variance > 0.0 else math.inf


def _is_more(power: float, other: float, count: float, by_chance: float = _BY_CHANCE) -> bool:
    """Return whether a mean of so many exponentially distributed powers is more than another of as many, and
    not by chance."""
    return other > 0.0 and fisher_above(2.0 * count, 2.0 * count, power / other) < by_chance


def _changes(spectrum: CoherentSpectrum, evenness: float, follows_signal: bool) -> bool:
    """Return whether sidebands of the fundamental are more in phase with it than in quadrature, or less, and
    not by chance: noise that is most in a part of the record, `evenness` of it, scatters by more. Those that
    a phase which follows the signal took along tell nothing."""
    reach = spectrum.periods - 1
    in_phase, quadrature = sidebands(spectrum.phasor, spectrum.periods, reach)
    first = followed_bins(in_phase, quadrature) if follows_signal else 0
    powers = float(np.sum(in_phase[first:])), float(np.sum(quadrature[first:]))
    return _is_more(max(powers), min(powers), evenness * (reach - first))
