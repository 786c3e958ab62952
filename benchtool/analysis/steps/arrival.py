"""Where samples that have arrived begin and come to rest, and what of their course until then is unsure."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.bursts import LOUD
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.smoothing import Noise, UnevenNoise
from benchtool.analysis.steps.tails import Tail

Floats = NDArray[np.float64]

_AT_REST, _IF_ROOM = 2, 3  # times the settling time: at the earliest, and where half of the samples are left
_UNIFORM = 1.0 / math.sqrt(12.0)  # standard deviation over width
_PLACES = 32  # in which an instant may be, each as likely
_OF_NEIGHBOURS = 1.5  # of the mean square slope a row away, times the mean square of times


def noise_on_the_way(uneven: UnevenNoise | None, at_rest: Noise, first: int, rest: int) -> UnevenNoise | None:
    """Return the noise of samples on their way from a row to another, if it is clearly another than at
    rest."""
    if uneven is None or not first < rest:
        return None
    found = uneven.rows(first, rest)
    way = math.sqrt(float(np.mean(found.rms**2)))
    return found if way > LOUD * at_rest.rms or LOUD * way < at_rest.rms else None


def left_in_course(errors: Floats, rms: float | Floats, begin: Instant) -> Floats:
    """Return the standard deviation of errors, shape (draws, n), of a course through noise of this rms, shape
    (n,).

    The level at the instant `begin` is the one that it is defined by: of the error in the first row only
    what a row after that instant leaves open is there, and of others only what is not correlated with it.
    """
    count = errors.shape[1]
    if not len(errors) or not count or not np.any(np.greater(rms, 0.0)):
        return np.zeros(count)
    square = float(np.mean(errors[:, 0] ** 2))
    if begin.drawn and square > 0.0:
        # within a row it is evenly distributed
        known = 1.0 - _UNIFORM / math.hypot(_UNIFORM, begin.standard)
        errors = errors - known * errors[:, :1] * (errors[:, 0] @ errors / (len(errors) * square))
    return np.asarray(np.minimum(np.std(errors, axis=0), rms))


def slopes_in_time(curve: Floats, scatter: float) -> Floats:
    """Return the slopes of a curve, shape (n,), as they may be where the times of its rows scatter: on a top,
    where they are zero at an instant, by its bend over as long, and by what its neighbours scatter."""
    if len(curve) < 2:
        return np.zeros(len(curve))
    square = np.pad(np.gradient(curve) ** 2, 1, mode="edge")
    beside = min(1.0, _OF_NEIGHBOURS * scatter**2)
    return np.asarray(np.sqrt((1.0 - beside) * square[1:-1] + 0.5 * beside * (square[:-2] + square[2:])))


def places_to_begin(begin: Instant) -> Floats:
    """Return places in which an instant may be, each as likely: as far about it as noise moves it about what
    noise makes of it in the middle, as one that is picked from noisy samples is, and is drawn, too late."""
    middles = (np.arange(_PLACES) + 0.5) / _PLACES
    if not begin.drawn:  # without noise, anywhere that the samples allow
        return begin.place + begin.standard * math.sqrt(3.0) * (2.0 * middles - 1.0)
    return np.asarray(begin.place + np.nanquantile(begin.drawn, middles) - begin.of_drawn)


def away_from_level(curve: Floats, first: int) -> Floats:
    """Return how far a curve, shape (n,), is from the level of the last quarter of what has arrived in the
    row `first`."""
    last = curve[len(curve) - max(1, (len(curve) - first) // 4) :]
    return np.asarray(curve - np.median(last))


def row_at_rest(curve: Floats, first: int, band: float, noise: float, event: int) -> int:
    """Return the row from which on what has arrived in the row `first` is at rest: where it stays near its
    last level, twice that time after the event, and thrice where half of the samples are left; later where
    its tail ends later, and leaves a third of them."""
    end, away = len(curve), away_from_level(curve, first)
    # a ripple that goes on is no way to the level
    band = max(band, float(np.max(np.abs(away[end - max(1, (end - first) // 4) :]), initial=0.0)))
    settled = int(np.max(np.flatnonzero(np.abs(away) > band) + 1, initial=0))
    if settled >= end:
        return first
    took = max(0, settled - event)
    rest = max(first, event + _AT_REST * took, min(event + _IF_ROOM * took, (first + end) // 2))
    later = Tail.of(away, band).end(noise)
    return later if rest < later <= end - (end - first) // _IF_ROOM else rest
