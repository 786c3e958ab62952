"""Samples that were lost one by one, continued from their neighbours, for what needs even steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis.quantisation.resolution import resolution

Floats = NDArray[np.float64]

_ORDER, _PER_COEFFICIENT = 48, 50
_MOST_ROUNDS, _SETTLED = 30, 0.02  # relative change of the power that is not predicted
_LOOKED_AT = 1 << 15  # samples


def continued(samples: Floats, lost: NDArray[np.bool_]) -> Floats:
    """Return samples, shape (n,), with those that are `lost`, of the same shape, as their neighbours have it.

    Of all values the lost ones may have had, those are drawn that an autoregression of the others predicts
    and is predicted from, with the noise that is left of it (Janssen, Veldhuis and Vries, Adaptive
    interpolation of discrete-time signals that can be modeled as autoregressive processes, IEEE Trans.
    ASSP 34 (1986) 317): lines keep their size, and noise its density. They are whole steps of a converter, as
    the others are.
    """
    at, kept = np.flatnonzero(lost), np.flatnonzero(~lost)
    order = min(_ORDER, len(kept) // _PER_COEFFICIENT)
    values = np.array(samples, dtype=np.float64)
    values[at] = np.interp(at, kept, samples[kept])
    if len(at) and order:
        mean = float(np.mean(values))
        values -= mean
        squares, before = 0.0, np.inf
        for _ in range(_MOST_ROUNDS):
            weights = _prediction(values, order)
            values[at] += _towards_prediction(values, at, weights)
            squares = float(np.sum(np.convolve(values, weights, mode="valid") ** 2))
            if squares > (1.0 - _SETTLED) * before:
                break
            before = squares
        # as many of the residuals are zero as values were fitted
        rms = math.sqrt(squares / max(1, len(values) - 2 * order - len(at)))
        values[at] += _towards_prediction(values, at, weights, np.random.default_rng(0), rms)
        values += mean
    if (step := resolution(samples[kept])) > 0.0:
        level = samples[kept[0]]
        values[at] = level + step * np.round((values[at] - level) / step)
    values[kept] = samples[kept]
    return values


def _prediction(values: Floats, order: int) -> Floats:
    """Return weights, the latest first and 1, of neighbouring values, shape (order + 1,), with the least sum
    of squares, forwards and backwards in time."""
    windows = sliding_window_view(values, order + 1)
    windows = windows[:: max(1, len(windows) // _LOOKED_AT)]
    products = windows.T @ windows
    products += products[::-1, ::-1]
    solution = np.linalg.lstsq(products[1:, 1:], -products[1:, 0], rcond=1e-13)[0]
    return np.concatenate(([1.0], solution))


def _towards_prediction(
    values: Floats,
    at: NDArray[np.int64],
    weights: Floats,
    random: np.random.Generator | None = None,
    rms: float = 0.0,
) -> Floats:
    """Return what is to be added to some of the values for the least residuals of all predictions, forwards
    and backwards in time, or for residuals of this `rms`."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    predictions = len(values) - len(weights) + 1
    of_time = (
        (_table(at, weights, predictions), values),
        (_table(len(values) - 1 - at, weights, predictions), values[::-1]),
    )
    normal, wanted = csc_array((len(at), len(at))), np.zeros(len(at))
    for table, course in of_time:
        residuals = -np.convolve(course, weights, mode="valid")
        if random is not None:  # both ways tell the same
            residuals += math.sqrt(2.0) * rms * random.standard_normal(predictions)
        normal += table.T @ table
        wanted += table.T @ residuals
    return np.asarray(splu(csc_array(normal)).solve(wanted))


def _table(at: NDArray[np.int64], weights: Floats, predictions: int) -> Any:
    """Return what values at some rows are in each prediction, as a sparse array of shape (predictions, n)."""
    from scipy.sparse import csc_array

    rows = at[:, np.newaxis] + np.arange(1 - len(weights), 1)
    inside = (rows >= 0) & (rows < predictions)
    columns = np.broadcast_to(np.arange(len(at))[:, np.newaxis], rows.shape)
    entries = np.broadcast_to(weights, rows.shape)
    return csc_array((entries[inside], (rows[inside], columns[inside])), shape=(predictions, len(at)))
