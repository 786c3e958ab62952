"""Crests of a waveform that are level: those of one that was clipped before noise came in.

Where an amplifier saturates ahead of what adds the noise, no value is repeated (`validity.clipping`). Of a
waveform that is folded to one period each crest is level then, within the noise of so many periods, and ends
in a corner on either side. A round crest, however flat, falls slowly beyond what of it seems level.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Measurement

Floats = NDArray[np.float64]

_PLACES, _FEWEST_PLACES, _FEWER = 240, 60, 0.9  # of a period; how many of them next
_SAMPLES, _FEWEST_SAMPLES = 6, 3  # at a place: on average, and at least
_FEWEST_PERIODS = 3.0
_AT_THE_CREST = 0.025  # of a period to either side of the greatest
_ROUNDING = 1e-12  # of the greatest value: what levels without noise differ by
_LEVEL = 4.0  # standard uncertainties of the mean at a place, over some of which a level crest stays
_SHORTEST = 7  # places: of fewer a level crest is not told from a round one
_BEYOND, _FALLS = 0.25, 5.0  # of half of the stretch; times its tolerance: a round crest falls by 2.4
_PASSES = 10


def flat_crest(samples: Floats, turns: Floats, step: float = 0.0) -> float:
    """Return the share of a period for which samples, shape (n,), stay level at their greatest or least, the
    longer of both; 0 where neither crest is level or noise hides it.

    `turns`, shape (n,), are the periods passed, and `step` that of a converter, of which a level may hold a
    whole one.
    """
    if float(turns[-1] - turns[0]) < _FEWEST_PERIODS:
        return 0.0
    folded = _folded(samples, turns)
    if folded is None:
        return 0.0
    wave, error = folded
    return max(_level_share(sign * wave, error, step) for sign in (1.0, -1.0))


def crest_is_flat(share: float) -> str:
    """Return what a crest that is level for a share of a period says of the current."""
    return (
        f"the current stays at its greatest or least value for {100.0 * share:.2g} % of a period, as one "
        f"that is clipped before noise comes in: how far it went is not known then; look at the range of "
        f"sensor and amplifier"
    )


def with_flat_crest(each: Measurement, share: float) -> Measurement:
    """Return a number of a current with such a crest, which has no uncertainty: it may be clipped."""
    basis = replace(each.basis, flat_crest=share)
    return replace(each, basis=basis).without_uncertainty(crest_is_flat(share))


def flat_crest_remark(measurements: Iterable[Measurement]) -> str:
    """Return the remark that a current has such crests, empty if none has."""
    shares = [each.basis.flat_crest for each in measurements if each.basis.flat_crest is not None]
    return crest_is_flat(shares[0]) if shares else ""


def _folded(samples: Floats, turns: Floats) -> tuple[Floats, Floats] | None:
    """Return the mean at each place of a period and its standard uncertainty, both of shape (places,); None
    where too few samples are at them.

    Of a period of about a whole number of rows the samples are at the same places in each: there are as
    many places as that leaves none of them without samples.
    """
    places = min(_PLACES, len(samples) // _SAMPLES)
    phase = np.mod(turns, 1.0)
    while places >= _FEWEST_PLACES:
        place = places * phase
        at = np.minimum(place.astype(np.int64), places - 1)
        count = np.bincount(at, minlength=places)
        if np.min(count) >= _FEWEST_SAMPLES:
            break
        places = int(_FEWER * places)
    else:
        return None
    beside = place - at - 0.5
    wave = np.bincount(at, samples, places) / count
    slope = _slope(wave)
    left = samples - wave[at] - slope[at] * beside
    left -= (np.bincount(at, left, places) / count)[at]
    wave -= slope * np.bincount(at, beside, places) / count
    return wave, np.sqrt(np.bincount(at, left**2, places)) / count


def _slope(wave: Floats) -> Floats:
    """Return the slope of a waveform from place to place, shape (places,): that to the side of which it is
    less, so that beside a corner a level has none."""
    ahead = np.roll(wave, -1) - wave
    behind = np.roll(ahead, 1)
    return np.where(ahead * behind > 0.0, np.sign(ahead) * np.minimum(np.abs(ahead), np.abs(behind)), 0.0)


def _level_share(wave: Floats, error: Floats, step: float) -> float:
    """Return the share of a period for which a waveform, shape (places,), is level at its greatest."""
    places = len(wave)
    middle = places // 2
    by = middle - int(np.argmax(wave))
    wave, error = np.roll(wave, by), np.roll(error, by)
    near = math.ceil(_AT_THE_CREST * places)
    tolerance = _LEVEL * float(np.median(error[middle - near : middle + near + 1])) + 0.5 * step
    tolerance += _ROUNDING * float(np.max(np.abs(wave)))
    level, first, last = float(wave[middle]), middle, middle
    for _ in range(_PASSES):  # the greatest of a level crest is above its mean
        known = first, last
        is_level = np.abs(wave - level) <= tolerance
        if not np.any(is_level):
            return 0.0
        first, last = _longest(is_level)
        level = float(np.mean(wave[first : last + 1]))
        if (first, last) == known:
            break
    length = last - first + 1
    beyond = math.ceil(0.5 * _BEYOND * length)
    if length < _SHORTEST or not beyond <= first <= last < places - beyond:
        return 0.0
    before, after = wave[first - beyond : first], wave[last + 1 : last + 1 + beyond]
    fallen = level - max(float(np.min(before)), float(np.min(after)))
    return length / places if fallen > _FALLS * tolerance else 0.0


def _longest(is_level: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first and the last of the longest run of places that are level: of a crest with a dip there
    is one on either side."""
    edges = np.diff(np.concatenate([[False], is_level, [False]]).astype(np.int8))
    begins, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    longest = int(np.argmax(ends - begins))
    return int(begins[longest]), int(ends[longest]) - 1
