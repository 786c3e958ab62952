"""Envelopes of long traces for drawing, which keep every peak and every gap."""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block

COLUMNS: Final = 2000  # more than a printed figure has dots across
_Array = NDArray[np.float64]


def envelope(x: _Array, y: _Array, columns: int = COLUMNS) -> tuple[_Array, _Array]:
    """Return the least and greatest of every one of at most `columns` stretches, in the order in which they
    occur.

    `x` and `y` have shape (n,). Up to four samples a stretch, all are returned as they are. A stretch with a
    nan keeps one beside its extremes, so that a drawn line breaks there.
    """
    rows = _kept(y, columns)
    return x[rows], y[rows]


def trace(block: Block, name: str, rows: int | None = None, columns: int = COLUMNS) -> tuple[_Array, _Array]:
    """Return the time since the first row in s and values of one channel, ready to be drawn; a nan stands for
    each gap.

    Args:
        rows: of the block's first rows only.
        columns: stretches of a long trace whose extremes are kept.

    Raises:
        AnalysisError: the block has no such channel.
    """
    values = block.column(name)[:rows]
    gaps = [gap for gap in block.gaps if 0 < gap.row < len(values)]
    edges = [0, *(gap.row for gap in gaps), len(values)]
    columns = max(8, columns // (len(edges) - 1))
    times, drawn = [], []
    missing = sum(gap.missing_rows for gap in block.gaps if gap.row == 0)
    for place, (begin, end) in enumerate(itertools.pairwise(edges)):
        if place:
            missing += gaps[place - 1].missing_rows
            times.append(np.array([np.nan]))
            drawn.append(np.array([np.nan]))
        kept = begin + _kept(values[begin:end], columns)
        times.append((kept + missing) * (block.stride * block.tick_s))
        drawn.append(values[kept])
    return np.concatenate(times), np.concatenate(drawn)


def band(block: Block, name: str, stretches: int) -> tuple[_Array, _Array, _Array]:
    """Return the middle times since the first row in s, least and greatest values of the stretches of one
    channel.

    No stretch contains a gap; a nan stands for each.

    Raises:
        AnalysisError: the block has no such channel.
    """
    values = block.column(name)
    edges, before = [0], [sum(gap.missing_rows for gap in block.gaps if gap.row == 0)]
    for gap in (each for each in block.gaps if 0 < each.row < len(values)):
        edges.append(gap.row)
        before.append(before[-1] + gap.missing_rows)
    parts: list[_Array] = []
    length = max(1, -(-len(values) // stretches))
    for (begin, end), missing in zip(itertools.pairwise([*edges, len(values)]), before, strict=True):
        begins = np.arange(begin, end, length)
        middles = 0.5 * (begins + np.minimum(begins + length, end) - 1) + missing
        least, greatest = (each.reduceat(values[:end], begins) for each in (np.minimum, np.maximum))
        parts += [np.full((3, 1), np.nan)] if parts else []
        parts.append(np.stack([middles * (block.stride * block.tick_s), least, greatest]))
    time_s, least, greatest = np.concatenate(parts, axis=1)
    return time_s, least, greatest


def _kept(y: _Array, columns: int) -> NDArray[np.intp]:
    """Return the rows that an envelope keeps."""
    if len(y) <= 4 * columns:
        return np.arange(len(y))
    length = -(-len(y) // columns)
    whole = len(y) // length
    begins = np.arange(whole)[:, np.newaxis] * length
    kept = [begins + rows for rows in _extremes(y[: whole * length].reshape(whole, length))]
    rest = y[whole * length :]
    if len(rest):
        kept += [whole * length + rows for rows in _extremes(rest[np.newaxis])]
    return np.unique(np.concatenate([[0, len(y) - 1], *(each.ravel() for each in kept)]))


def _extremes(folded: _Array) -> list[NDArray[np.intp]]:
    """Return the columns of the least, the greatest and, if there is any, a nan of each row, each of shape
    (rows, 1)."""
    if not np.isnan(folded.sum()):
        return [folded.argmin(axis=1, keepdims=True), folded.argmax(axis=1, keepdims=True)]
    missing = np.isnan(folded)
    return [
        np.where(missing, np.inf, folded).argmin(axis=1, keepdims=True),
        np.where(missing, -np.inf, folded).argmax(axis=1, keepdims=True),
        missing.argmax(axis=1, keepdims=True),
    ]
