"""What is missing of a table: rows with a cell that is no number, and what they keep from being told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchtool.tables.cells import Cell
from benchtool.tables.text import Rows

_FEWEST_ROWS = 8
_LARGEST_SHARE = 0.05  # of the rows of the span
_OUTER, _FEWEST_RUNS, _MOST = 10.0, 6, 0.8  # per cent at each end; of the values beside what is missing


@dataclass(frozen=True)
class Lost:
    """Rows that were left out, of those in the span that was asked for.

    `left_out` counts rows by reason, `within` those of them between the first and the last that were used:
    others only make the record shorter. `reasons` says by kind of column why the rest of it stands for
    nothing. `first` is the first cell that is no number, for a message.
    """

    left_out: Mapping[str, int] = field(default_factory=dict)
    within: int = 0
    reasons: Mapping[str, str] = field(default_factory=dict)
    first: str = ""

    def reason(self, what: str) -> str:
        """Return why the rows that are left say nothing on a column; empty if they do."""
        return self.reasons.get(what, "")


def lost_among(
    rows: Rows,
    inside: NDArray[np.bool_],
    lost_inside: NDArray[np.bool_],
    kinds: Sequence[str],
    first: str,
) -> Lost:
    """Return what is missing among the rows of a span.

    Args:
        rows: those that were read.
        inside: which of the rows with numbers are in the span, shape (n,).
        lost_inside: which of the others are, shape (k,).
        kinds: of the last columns, those behind the time if that is one.
        first: the first cell that is no number.
    """
    out = rows.left_out
    place = rows.place[inside]
    within = lost_inside & (out.place > place[0]) & (out.place < place[-1])
    count = int(np.count_nonzero(within)) + out.broken
    share = count / (count + len(place))
    reasons: dict[str, str] = {}
    if len(place) < _FEWEST_ROWS <= len(out.place):
        few = (
            f"of {len(place) + len(out.place)} rows {len(out.place)} are left out, with a cell that is no "
            f"number{_of(first)}: the rest does not stand for all, correct these rows"
        )
        return Lost(rows.dropped, count, dict.fromkeys(kinds, few), first)
    first_kind = out.cells.shape[1] - len(kinds)
    is_timed = np.all(out.cells[within, :first_kind] == Cell.NUMBER, axis=1)
    for column, what in enumerate(kinds, first_kind):
        cells = out.cells[within, column]
        elsewhere = int(np.count_nonzero(is_timed & (cells == Cell.NUMBER)))
        overloads = int(np.count_nonzero(cells == Cell.OVERLOAD))
        if overloads:
            reasons[what] = (
                f"{overloads} of its cells state an overload: the record is clipped, choose a span without "
                f"any, or a larger range"
            )
        elif _beside_extremes(rows.data[:, column], rows.place, out.place[within][cells == Cell.MISSING]):
            reasons[what] = (
                f"{np.count_nonzero(cells)} of its cells are no numbers{_of(first)}, next to its greatest or "
                f"its least values: what is missing there may be an overload"
            )
        elif share > _LARGEST_SHARE and 2 * elsewhere > len(cells):
            reasons[what] = (
                f"{elsewhere} of its values are in rows in which another column has none{_of(first)}: "
                f"measure it without that column"
            )
        elif share > _LARGEST_SHARE:
            reasons[what] = (
                f"{100 * share:.2g} % of the rows are left out, with a cell that is no number or a wrong "
                f"number of cells{_of(first)}: the rest does not stand for all, correct these rows or "
                f"choose a span without them"
            )
    return Lost(rows.dropped, count, reasons, first)


def _of(first: str) -> str:
    return f", the first {first}" if first else ""


def _beside_extremes(
    values: NDArray[np.float64], place: NDArray[np.int64], missing: NDArray[np.int64]
) -> bool:
    """Return whether most values next to those that are missing are in the outer tenths of all."""
    if not len(missing):
        return False
    begins = missing[np.diff(missing, prepend=-2) > 1]
    if len(begins) < _FEWEST_RUNS:
        return False
    low, high = np.percentile(values, (_OUTER, 100.0 - _OUTER))
    after = np.searchsorted(place, begins)
    beside = values[np.clip(np.concatenate((after - 1, after)), 0, len(values) - 1)]
    return bool(np.mean((beside < low) | (beside > high)) >= _MOST)
