"""Single samples far from their neighbours, as interference leaves them in a transient."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.resolution import counting_step, step_between
from benchtool.analysis.statistics.straight_lines import places_about_middle, slope_weights

Floats = NDArray[np.float64]

_LONGEST = 2  # samples
_REACH = 3  # samples to either side, whose median is one of the levels around
_LINE = 5  # samples to either side, the line through which is what a course goes on along
_OF_LINE = 1.5  # times as far: noise of such a line, two samples on, is 1.3 times that of one sample
_NEAR = 10  # samples to either side, within which what oscillates is no click
_SIGMAS = 4.5  # standard deviations of a sample from the mean of its neighbours: 5.5 of white noise
_STEPS = 1.5  # of a converter: noise that its steps hide moves a sample by one of them
_OF_MEDIAN = 1.0 / 0.6745  # standard deviation over median magnitude, of normal values
RARE = 0.02
"""Of the samples: more clicks are no interference that could be left out."""
_PASSES = 5
_APART = (1, 2, 4, 8)  # samples between which the noise is looked for
_FEWEST, _FEWEST_LEVELS = 50, 16  # samples; of a converter


def without_clicks(samples: Floats) -> tuple[Floats, int]:
    """Return samples, shape (n,), with clicks replaced by the line between their neighbours, and how many
    samples that are.

    A click is one sample, or each of two, beyond both neighbours and beyond the medians of three samples to
    either side, by more than 4.5 standard deviations of the noise and by more than these four levels differ
    from each other, so that an edge is none. On the way of an answer, where these levels differ by what
    it has come, a click is what is so far beyond the line between both neighbours and those through five
    samples to either side, and by 4.5 times what these leave of their samples: an edge, a corner and a peak
    are within these, and a line through an edge says little of what follows. The noise is how far half of
    the samples, of all or of those near where that is more, are from the mean of their neighbours: what
    oscillates is none either. A signal that stays for some samples and then jumps, as what is computed of
    converted currents does, is hardly off its neighbours: where it would have too many clicks, those up
    to eight samples away count. Samples without noise are returned as they are, and so are those of which
    more than a fiftieth would be clicks, with their number.
    """
    count = len(samples)
    if count < _FEWEST:
        return samples, 0
    step = converter_step(samples)
    mended, hits = samples, 0
    for lag in _APART:
        noise = _OF_MEDIAN * float(np.median(_apart(samples, lag)))
        if not max(noise, step) > 0.0:
            continue
        mended, hits = _mended(samples, max(_SIGMAS * noise, _STEPS * step))
        if not too_many(hits, count):
            break
    return mended, hits


def clicks_among(samples: Floats, unit: str) -> str:
    """Return how many samples, shape (n,), are clicks, and the first of them; empty if none is, or if they
    are too many for that."""
    mended, _ = without_clicks(samples)
    rows = np.flatnonzero(mended != samples)
    if not len(rows):
        return ""
    first = f"{samples[rows[0]]:.4g} {unit}".rstrip()
    if len(rows) == 1:
        return f"the sample in row {rows[0]} (from 0), {first}, is far from its neighbours"
    return f"{len(rows)} samples are far from their neighbours, the first, {first}, in row {rows[0]} (from 0)"


def _apart(samples: Floats, lag: int) -> Floats:
    """Return how far samples, shape (n,), are from the mean of those `lag` before and after, shape (n - 2
    lag,)."""
    return np.asarray(np.abs(samples[lag:-lag] - 0.5 * (samples[: -2 * lag] + samples[2 * lag :])))


def _mended(samples: Floats, least: float) -> tuple[Floats, int]:
    """Return samples, shape (n,), without clicks beyond `least`, and their number; as they are where these
    are too many."""
    apart = _apart(samples, 1)
    mended, hits = samples, np.zeros(len(samples), dtype=np.bool_)
    for _ in range(_PASSES):  # of clicks side by side one hides the other
        hit = _hit(mended, apart, least) & ~hits
        if not np.any(hit):
            break
        hits |= hit
        if too_many(int(np.count_nonzero(hits)), len(samples)):
            return samples, int(np.count_nonzero(hits))
        mended = _bridged(samples, hits)
    return mended, int(np.count_nonzero(hits))


def without_outliers(samples: Floats, least: Floats) -> Floats:
    """Return samples, shape (n,), with those replaced by the line between their neighbours that are, alone or
    two of them, beyond all around by more than `least`, shape (n,), and by more than that differs."""
    if len(samples) <= 2 * _REACH + _LONGEST:
        return samples
    far = _beyond_around(samples) > least
    if not np.any(far) or np.all(far):
        return samples
    return _bridged(samples, far)


def _bridged(samples: Floats, hits: NDArray[np.bool_]) -> Floats:
    """Return samples, shape (n,), with those of the `hits` on the line between their neighbours, or between
    the medians of these and of the two beside each, as a neighbour may be an outlier itself."""
    rows, rest = np.arange(len(samples)), samples[~hits]
    ends = np.pad(rest, 1, mode="edge")
    middle = np.median([ends[:-2], rest, ends[2:]], axis=0)
    bridged = samples.copy()
    bridged[hits] = np.interp(rows[hits], rows[~hits], middle)
    return bridged


def too_many(clicks: int, count: int) -> bool:
    """Return whether so many of `count` samples are clicks that these are no interference."""
    return clicks > max(_LONGEST, math.floor(RARE * count))


def _hit(samples: Floats, apart: Floats, least: float) -> NDArray[np.bool_]:
    """Return which of the samples, shape (n,), are far from their neighbours, and those near are not."""
    course = _beyond_around(samples, of_course=True) / _OF_LINE
    beyond = np.maximum(_beyond_around(samples), course)
    hit = beyond > least
    for row in np.flatnonzero(hit):
        near = apart[max(0, row - 1 - _NEAR) : row + _NEAR]
        hit[row] = beyond[row] > _SIGMAS * _OF_MEDIAN * float(np.median(near))
    return hit


def converter_step(samples: Floats) -> float:
    """Return the step of a converter in samples, shape (n,); 0 of a curve that was drawn, not measured.

    Of an answer that is over in few rows few levels are seen, apart by different numbers of steps. Values
    that are read once among others that nearly all samples have may be on no step, as the first of a speed
    that is counted from row to row, which has none before it: they count where the others are too few.
    """
    values, place, reads = np.unique(samples, return_inverse=True, return_counts=True)
    is_level = reads > 1
    if np.sum(reads[is_level]) > (1.0 - RARE) * len(samples):
        found = _step_of(samples[is_level[place]], values[is_level])
        if found:
            return found
    return _step_of(samples, values)


def _step_of(samples: Floats, values: Floats) -> float:
    """Return the step of a converter in samples, shape (n,), of these different values; 0 without one."""
    counted = counting_step(samples) if len(values) >= _FEWEST_LEVELS else 0.0
    return counted or step_between(values, _FEWEST_LEVELS)


def _beyond_around(samples: Floats, *, of_course: bool = False) -> Floats:
    """Return how far each sample, shape (n,), is beyond what is around, or beyond the course there, alone or
    as one of two.

    At the ends that is continued as in a mirror, and along the line there: at the foot of a slope the first
    sample is beyond all others, and beyond those in the mirror too.
    """
    around = _LINE + _LONGEST
    if len(samples) <= around:
        return np.zeros(len(samples))
    mirrored = np.pad(samples, around, mode="reflect")
    beyond = _beyond_alone_or_of_two(mirrored, of_course)
    sloping = np.concatenate([_before(samples), samples[: 2 * around]])
    begin = _beyond_alone_or_of_two(sloping, of_course)[around : 2 * around]
    sloping = np.concatenate([samples[-2 * around :], _before(samples[::-1])[::-1]])
    end = _beyond_alone_or_of_two(sloping, of_course)[-2 * around : -around]
    beyond = beyond[around : len(samples) + around]
    beyond[:around] = np.minimum(beyond[:around], begin)
    beyond[-around:] = np.minimum(beyond[-around:], end)
    return beyond


def _before(samples: Floats) -> Floats:
    """Return what is before the first of samples, shape (n,), where they go on along the line through the
    medians behind the first, as many as are around: turned about where that line begins."""
    near, further = (float(np.median(samples[at : at + _REACH])) for at in (1, 1 + _REACH))
    begin = near - (further - near) * (1 + _REACH // 2) / _REACH
    return np.asarray(2.0 * begin - samples[_LINE + _LONGEST : 0 : -1])


def _beyond_alone_or_of_two(samples: Floats, of_course: bool) -> Floats:
    of = _courses if of_course else _levels
    beyond = [_beyond(samples, length, of) for length in range(1, _LONGEST + 1)]
    return np.asarray(np.maximum.reduce(beyond))


def _beyond(samples: Floats, length: int, of: Callable[[Floats, int], tuple[Floats, Floats]]) -> Floats:
    """Return how far each sample, shape (n,), is beyond what is around so many of which it is one; 0 where it
    is within, or by less than what is around differs or is unsure."""
    count = len(samples)
    first = np.arange(_LINE, count - length - _LINE + 1)
    around, unsure = of(samples, length)
    highest, lowest = np.max(around, axis=0), np.min(around, axis=0)
    within = samples[first[:, np.newaxis] + np.arange(length)]
    # of two, the one may be above and the other below
    each = np.maximum(within - highest, lowest - within)
    beyond = np.min(np.where(each > np.maximum(highest - lowest, unsure), each, 0.0), axis=1)
    found = np.zeros(count)
    for offset in range(length):
        at = first + offset
        found[at] = np.maximum(found[at], beyond)
    return found


def _levels(samples: Floats, length: int) -> tuple[Floats, Floats]:
    """Return the levels around every so many samples, shape (4, m, 1): their neighbours, and the medians to
    either side; none of them is unsure."""
    first = np.arange(_LINE, len(samples) - length - _LINE + 1)
    level = np.median(np.lib.stride_tricks.sliding_window_view(samples, _REACH), axis=1)
    around = [samples[first - 1], level[first - _REACH], samples[first + length], level[first + length]]
    return np.stack(around)[..., np.newaxis], np.zeros((len(first), 1))


def _courses(samples: Floats, length: int) -> tuple[Floats, Floats]:
    """Return the courses about every so many samples, shape (3, m, length): the line between their
    neighbours, and those through the samples to either side; and how unsure these are, shape (m, 1), by what
    they leave of their samples."""
    first = np.arange(_LINE, len(samples) - length - _LINE + 1)
    after = first + length
    rows = places_about_middle(_LINE)
    windows = np.lib.stride_tricks.sliding_window_view(samples, _LINE)
    mean, slope = np.mean(windows, axis=1), windows @ slope_weights(_LINE)
    within = np.arange(length)
    between = np.outer(samples[first - 1], length - within) + np.outer(samples[after], within + 1.0)
    before = mean[first - _LINE, np.newaxis] + np.outer(slope[first - _LINE], within + 1.0 - rows[0])
    behind = mean[after, np.newaxis] + np.outer(slope[after], within - length + rows[0])
    left = np.sum((windows - mean[:, np.newaxis] - slope[:, np.newaxis] * rows) ** 2, axis=1)
    unsure = _SIGMAS * np.sqrt(np.maximum(left[first - _LINE], left[after]) / (_LINE - 2))
    return np.stack([between / (length + 1.0), before, behind]), unsure[:, np.newaxis]
