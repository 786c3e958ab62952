"""Drift of an output between two rests of what excites it, by its levels and slopes at both.

With level and slope at either end a drift is a cubic. Rests that are short against the record hardly tell the
slopes: a drift is taken to bend, normally distributed, by about as much as it goes, and what the rests say is
combined with that (Box and Tiao, Bayesian Inference in Statistical Analysis, 1973, 2.7, of a normal prior).
What is left open is among the errors of the response.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_AT_REST = 1e-3  # rms deviation of an input at rest, over that of all
_BLOCKS = 8  # of a rest: their means scatter as slow noise makes them
_FEWEST_ROWS = 2  # of a block
_TERMS = 4  # level, line, and two that vanish at both ends: a parabola and a cubic
_CLEARLY = 5.0  # standard deviations
_FREEDOM = 4  # blocks more than terms that tell how they scatter


@dataclass(frozen=True)
class RestDrift:
    """A `course`, shape (n,), by which an output drifts, and the standard uncertainties of it that are
    independent of one another, shape (k, n); no rows where it does not clearly drift."""

    course: Floats
    doubts: Floats


def drift_between_rests(x: Floats, y: Floats) -> RestDrift:
    """Return the drift of output `y` while its input `x`, both of shape (n,), goes from rest to rest."""
    count = len(y)
    none = RestDrift(np.zeros(count), np.empty((0, count)))
    moving = np.flatnonzero(np.abs(x - x[0]) > _AT_REST * float(np.std(x)))
    if len(moving) == 0:
        return none
    begin, end = int(moving[0]), count - 1 - int(moving[-1])
    # the later half of what follows the stimulus: the answer has died away
    rests = np.arange(begin), np.arange(count - end // 2, count)
    blocks = [
        part
        for rest in rests
        if len(rest) >= _FEWEST_ROWS
        for part in np.array_split(rest, min(_BLOCKS, len(rest) // _FEWEST_ROWS))
    ]
    if len(blocks) < _TERMS + _FREEDOM:
        return none
    size = np.sqrt([float(len(part)) for part in blocks])
    time = np.array([float(np.mean(part)) for part in blocks]) / (count - 1.0)
    means = np.array([float(np.mean(y[part])) for part in blocks])
    columns = _columns(time) * size[:, np.newaxis]
    solution, *_ = np.linalg.lstsq(columns, means * size, rcond=None)
    left = means * size - columns @ solution
    scatter = float(left @ left) / (len(blocks) - _TERMS)
    information = columns.T @ columns
    standard = np.sqrt(np.diag(np.linalg.inv(information)) * scatter)
    clear = (np.abs(solution) > _CLEARLY * standard)[1:]
    if not np.any(clear):
        return none
    largest = float(np.max(np.abs(solution[1:])[clear]))
    # the level is any, and the line nearly so
    before = np.diag([0.0, 0.0, 1.0, 1.0]) * max(scatter, math.ulp(largest**2)) / largest**2
    covariance = np.linalg.inv(information + before)
    found = covariance @ (columns.T @ (means * size))
    shapes = _columns(np.arange(count) / (count - 1.0))
    own, turned = np.linalg.eigh(covariance[1:, 1:] * scatter)
    doubts = (shapes[:, 1:] @ (turned * np.sqrt(np.maximum(own, 0.0)))).T
    return RestDrift(np.asarray(shapes[:, 1:] @ found[1:]), np.asarray(doubts))


def _columns(time: Floats) -> Floats:
    """Return the terms of a drift over time from 0 to 1, shape (n, 4)."""
    bent = time * (1.0 - time)
    return np.stack([np.ones(len(time)), time - 0.5, bent, bent * (2.0 * time - 1.0)], axis=1)
