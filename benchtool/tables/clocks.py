"""Times as computers and firmware count them: since 1970, and modulo a power of two."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, date, datetime

import numpy as np
from numpy.typing import NDArray

from benchtool.errors import AnalysisError
from benchtool.tables.selection import Selection

_PER_S = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_FIRST_S, _LAST_S = 946_684_800.0, 4_102_444_800.0  # from 2000 up to 2100, UTC
_LARGEST_S = 1e11  # of a time in seconds of no stated unit
_MODULI = tuple(2**bits for bits in (8, 16, 24, 32))
_LONGEST_STEP = 0.25  # of the modulus: of longer ones it is not known how often they go round
_OFF = 1e-6  # of a count: what gain and unit round
_MOST_ROWS = 4  # from the last before a rollover to the first behind it


@dataclass(frozen=True)
class Clock:
    """What the times of a table say of the clock that counted them.

    `day` is that of the first row where its size says that the time counts since 1970, `modulus` the counts
    after which it starts again from the least, 0 if it does not, and `rollovers` how often it did.
    """

    day: date | None = None
    modulus: int = 0
    rollovers: int = 0


def read_clock(
    selection: Selection, time_s: NDArray[np.float64], *, is_one_table: bool = True
) -> tuple[Selection, NDArray[np.float64], Clock]:
    """Return the column of a time, its values in seconds, shape (n,), and its clock, from those as selected.

    A time of no stated unit that is between the years 2000 and 2100 in one of s, ms, us and ns is in that. A
    count of whole numbers that goes back is that of a counter of 8, 16, 24 or 32 bits where every step is
    then as the others are, and goes on behind it; but not where the rows may be more than one table.

    Raises:
        AnalysisError: a time of no stated unit is thousands of years in seconds.
    """
    clock = Clock()
    if selection.unit_from == "assumed" and (unit := _unit_since_1970(time_s)):
        selection = replace(selection, unit=unit, unit_from="size", factor=1.0 / _PER_S[unit])
        time_s = time_s / _PER_S[unit]
        clock = Clock(datetime.fromtimestamp(float(time_s[0]), UTC).date())
    if selection.unit_from == "assumed" and float(np.abs(time_s).max()) > _LARGEST_S:
        name = selection.in_option
        raise AnalysisError(
            f"the time '{name}' has no unit and counts up to {np.abs(time_s).max():.4g}, thousands of years "
            f"if in seconds: state its unit, as '{name}:us', with a gain where one step is another size, as "
            f"'{name}:us*0.1'"
        )
    scale_s = selection.gain * selection.factor
    counts = time_s / scale_s - selection.offset / selection.gain
    modulus = _modulus(counts) if is_one_table else 0
    if not modulus:
        return selection, time_s, clock
    went_round = np.diff(counts, prepend=counts[0]) < 0.0
    clock = replace(clock, modulus=modulus, rollovers=int(np.count_nonzero(went_round)))
    return selection, time_s + modulus * scale_s * np.cumsum(went_round), clock


def _unit_since_1970(times: NDArray[np.float64]) -> str:
    """Return the unit in which times since 1970 are all from 2000 up to 2100, empty where there is none."""
    first, last = float(times.min()), float(times.max())
    fits = (unit for unit, per_s in _PER_S.items() if _FIRST_S * per_s <= first and last < _LAST_S * per_s)
    return next(fits, "")


def _modulus(counts: NDArray[np.float64]) -> int:
    """Return the power of two modulo which counts go on at every row as they do at most, or as they do over a
    few rows that are missing there; 0 if there is none, or none goes back."""
    steps = np.diff(counts)
    back, forward = steps[steps < 0.0], steps[steps > 0.0]
    if not len(back) or not len(forward) or np.any(np.abs(counts - np.round(counts)) > _OFF):
        return 0
    modulus = next((each for each in _MODULI if np.ptp(counts) < each), 0)
    if forward.max() > _LONGEST_STEP * modulus:
        return 0
    onward = back + modulus
    rows = np.arange(1, _MOST_ROWS + 1)[:, np.newaxis]
    goes_on = (onward > rows * forward.min() - 1.5) & (onward < rows * forward.max() + 1.5)
    few = onward < _LONGEST_STEP * modulus + 1.5
    return modulus if np.all(np.any(goes_on, axis=0) & few) else 0
