"""Time base of imported data: one sample rate from the time stamps, or the reason why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import (
    count_of,
    error_of_series,
    least_spread,
    line_through_counts,
    without_slope,
)
from benchtool.block import Gap

_FEWEST_STAMPS = 8
_LARGEST_DEVIATION = 0.1  # of a step, peak to peak: a tone at a tenth of the rate keeps 3 % of phase
_REPEATED_BY_RESOLUTION = 0.05  # share of equal stamps from which the resolution, not a repeat, is the cause
_FEWEST_PER_STAMP = 2
_ONE_COUNT = 1.0 + 1e-6
_SUMMED = 4.0  # of what rounding does to a stamp: of stamps that are sums or products of steps
_COARSE = 1.1  # times the resolution: what rounding alone makes stamps deviate, peak to peak, from a fit
_REGULAR = 4  # stamps of a row less, at equal distances, are those of a rate a little lower
_REFINEMENTS = 4
_MOST_DECIMALS = 9
_MOST_PARTS, _FEWEST_PARTS, _FEWEST_OF_PART = 64, 10, 8  # parts of stamps, and stamps of each
_SKIPS = 0.5  # of a step: of a coarser resolution a count is skipped, or doubled, where the rate is off


@dataclass(frozen=True)
class TimeBase:
    """The time base of a column of time stamps.

    `refusal` is the reason why the rows have no even time base, empty if they have; then row k was taken at
    `begin_s + step_s * (k + rows missing before it)`, with the missing rows in `gaps`; with `gaps_known`
    false it is unknown whether rows are missing. `jitter_s` is the rms deviation of the stamps from that
    line, `resolution_s` the step in which stamps count (nan if there is none to be seen), `rate_relative` the
    standard uncertainty of the rate, relative to it: by the rates that rounding to the resolution allows
    (JCGM 100:2008, 4.3.7) or, of stamps that jitter more, by the scatter of the line's slope over parts of
    the record and their correlation. Stamps that are all multiples of one step show no rounding: they number
    the rows. The clock itself is not in it. Where the stamps are refused, `step_s` is the median step between
    different ones.
    """

    begin_s: float
    step_s: float
    jitter_s: float
    resolution_s: float
    gaps: tuple[Gap, ...] = ()
    refusal: str = ""
    gaps_known: bool = True
    rate_relative: float = math.nan

    @property
    def rate_Hz(self) -> float:
        return 1.0 / self.step_s if self.step_s > 0.0 else math.nan

    @property
    def missing_rows(self) -> int:
        return sum(gap.missing_rows for gap in self.gaps)


def time_base(time_s: NDArray[np.float64], values: NDArray[np.float64] | None = None) -> TimeBase:
    """Return the time base behind stamps, shape (n,), in the order of the rows and finite.

    With `values`, shape (n, columns), rows that repeat these with the stamp are refused.

    A line through row number and stamp by least squares gives the rate. Rows are missing where a stamp is
    later by a whole number of steps. Where stamps are coarser than the rows, such as 1 ms for rows at 10 kHz,
    many are equal; the rows are uniform if the stamps follow the line within their resolution. Where all
    stamps but one stand for the same number of rows, or but a few at unequal distances, rows are missing
    where there are fewer; else none is, if an even rate explains every stamp. If none does, or if two or
    three stamps of fewer rows may be those of another rate, it is unknown. Stamps that deviate by more than
    their resolution and a tenth of a step, peak to peak, that go back or that repeat are refused: nothing is
    interpolated.
    """
    if len(time_s) < _FEWEST_STAMPS:
        return _refused(time_s, f"{count_of(len(time_s), 'row')}, at least {_FEWEST_STAMPS} are needed")
    steps = np.diff(time_s)
    if not np.any(steps):
        return _refused(time_s, f"the time is {time_s[0]:g} s in every row")
    back = np.flatnonzero(steps < 0.0)
    if len(back) == len(steps):
        return _refused(
            time_s,
            "the time goes back at every row: the newest row is first, or the time counts down; sort the "
            "rows by when they were read",
        )
    if len(back):
        places = "once" if len(back) == 1 else f"{len(back)} times"
        return _refused(
            time_s,
            f"the time goes back {places}, first by {-steps[back[0]]:.6g} s at row {back[0] + 2}: "
            f"records joined together, or rows out of order",
        )
    resolution_s = _resolution(time_s, steps)
    repeated = np.flatnonzero(steps == 0.0)
    if values is not None and len(repeated) and len(twice := repeated_rows(time_s, values)):
        return _refused(
            time_s,
            f"{count_of(len(twice), 'row repeats', 'rows repeat')} both time and values of the row before, "
            f"first row {twice[0] + 1}",
            resolution_s,
        )
    if len(repeated) > _REPEATED_BY_RESOLUTION * len(steps):
        count = len(steps) - len(repeated) + 1
        if count < _FEWEST_STAMPS:
            return _refused(
                time_s,
                f"the time has {count} different values in {len(time_s)} rows, "
                f"{steps[steps > 0.0].min():.4g} s apart, at least {_FEWEST_STAMPS} are needed to tell a "
                f"rate: export the time with more digits, or state the rate in its place",
                resolution_s,
            )
        return _coarse(time_s, steps, max(resolution_s, _resolution_of_the_last(time_s), key=_number))
    if len(repeated):
        return _refused(
            time_s,
            f"{count_of(len(repeated), 'row repeats', 'rows repeat')} the time of the row before, first row "
            f"{repeated[0] + 2}",
            resolution_s,
        )
    advance = _advance(steps)
    return _on_a_line(time_s, _ticks(advance), advance, resolution_s)


def _coarse(time_s: NDArray[np.float64], steps: NDArray[np.float64], resolution_s: float) -> TimeBase:
    """Return the stamps that several rows have."""
    advance = np.ones(len(steps), dtype=np.int64)
    if not math.isfinite(resolution_s):
        return replace(_on_a_line(time_s, _ticks(advance), advance, resolution_s), gaps_known=False)
    count = (time_s - time_s[0]) / resolution_s
    is_even = least_spread(count, np.arange(len(count), dtype=np.float64)).spread <= _ONE_COUNT
    missing = _missing_of_equal_counts(np.round(count))
    places = 0 if missing is None else int(np.count_nonzero(missing))
    if missing is not None and (places == 1 or not is_even):
        base = _on_a_line(time_s, _ticks(advance + missing), advance + missing, resolution_s)
        if not base.refusal:
            return base
    base = _on_a_line(time_s, _ticks(advance), advance, resolution_s)
    return replace(base, gaps_known=is_even and (places == 0 or places >= _REGULAR))


def _ticks(advance: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate(([0], np.cumsum(advance)))


def _missing_of_equal_counts(stamp: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Return the rows missing before each row but the first, where all stamps but few stand for the same
    number of rows.

    The first and the last stamp may stand for fewer. None where numbers differ more often, as those of a rate
    that is no whole multiple do, where any is greater, or where none is missing.
    """
    first = np.flatnonzero(np.diff(stamp, prepend=-1.0))
    counts = np.diff(first, append=len(stamp))
    usual = int(np.median(counts))
    inner = counts[1:-1]
    short = np.flatnonzero(inner < usual) + 1
    skipped = np.flatnonzero(np.diff(stamp[first]) > 1.0) + 1
    if usual < _FEWEST_PER_STAMP or np.any(counts > usual) or 20 * len(short) > len(inner):
        return None
    if not len(short) and not len(skipped):
        return None
    missing = np.zeros(len(stamp) - 1, dtype=np.int64)
    missing[first[short + 1] - 1] += usual - counts[short]
    missing[first[skipped] - 1] += (np.diff(stamp[first])[skipped - 1].astype(np.int64) - 1) * usual
    return missing


def _number(value: float) -> float:
    return value if math.isfinite(value) else -math.inf


def _resolution_of_the_last(time_s: NDArray[np.float64]) -> float:
    """Return the resolution of the stamps with most digits before the point: of five digits in all it is
    coarser."""
    largest = float(np.abs(time_s).max())
    if not 0.0 < largest < math.inf:
        return math.nan
    last = time_s[np.abs(time_s) >= 10.0 ** math.floor(math.log10(largest))]
    steps = np.diff(last)
    return _resolution(last, steps) if np.any(steps > 0.0) else math.nan


def _on_a_line(
    time_s: NDArray[np.float64], tick: NDArray[np.int64], advance: NDArray[np.int64], resolution_s: float
) -> TimeBase:
    # about the middle, where offset and slope are independent
    number = tick - tick.mean()
    about = time_s - time_s.mean()
    step_s = float(number @ about) / float(number @ number)
    deviation = about - step_s * number
    spread_s = float(np.ptp(deviation))
    coarse_s = resolution_s if math.isfinite(resolution_s) else 0.0
    rounding_s = 4 * float(np.spacing(np.abs(time_s).max()))
    if np.any(advance < 1) or spread_s > max(_COARSE * coarse_s, _LARGEST_DEVIATION * step_s) + rounding_s:
        # steps that jitter by half a step count as rows that are missing
        off = min(deviation, _off_rows(time_s), key=lambda each: float(np.abs(each).max()))
        worst = int(np.argmax(np.abs(off)))
        steps = np.diff(time_s)
        return _refused(
            time_s,
            f"the time stamps are not even: steps of {steps.min():.4g} s to {steps.max():.4g} s, off an even "
            f"grid by up to {abs(off[worst]):.3g} s (row {worst + 1})",
            resolution_s,
        )
    late = np.flatnonzero(advance > 1)
    allowed = None
    if coarse_s and spread_s > _SUMMED * rounding_s:
        allowed = line_through_counts(about, number, _ONE_COUNT * coarse_s + 2.0 * rounding_s)
    if allowed is None:
        standard_s = _of_slope(number, deviation, coarse_s, rounding_s)
    else:
        step_s, standard_s = allowed.slope, allowed.standard
    jitter_s = float(np.sqrt(np.mean((about - step_s * number) ** 2)))
    if jitter_s <= rounding_s:  # of doubles
        jitter_s = 0.0
    return TimeBase(
        begin_s=float(time_s.mean() - step_s * tick.mean()),
        step_s=step_s,
        jitter_s=jitter_s,
        resolution_s=resolution_s,
        gaps=tuple(Gap(int(row) + 1, int(advance[row]) - 1) for row in late),
        rate_relative=standard_s / step_s + _of_gaps(advance, coarse_s, step_s),
    )


def _off_rows(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the deviation of stamps from a line by least squares through row numbers, none of which is
    missing."""
    return without_slope(time_s - time_s.mean())


def _of_slope(
    number: NDArray[np.float64], deviation: NDArray[np.float64], coarse_s: float, rounding_s: float
) -> float:
    """Return the standard uncertainty of the slope of a line by least squares from which stamps have this
    deviation, at row numbers about their mean, both of shape (n,)."""
    ends_s = (
        math.sqrt(2.0) * max(float(np.std(deviation)), coarse_s / math.sqrt(12.0)) / float(np.ptp(number))
    )
    if float(np.ptp(deviation)) <= _SUMMED * rounding_s:
        return rounding_s / float(np.ptp(number))
    parts = min(_MOST_PARTS, len(number) // _FEWEST_OF_PART)
    if parts < _FEWEST_PARTS:
        return ends_s
    moments = [
        float(a @ b) for a, b in zip(*(np.array_split(x, parts) for x in (number, deviation)), strict=True)
    ]
    scatter = error_of_series(np.array(moments)).standard * parts / float(number @ number)
    rounded_s = rounding_s / float(np.ptp(number))
    return min(ends_s, math.hypot(scatter, rounded_s)) if math.isfinite(scatter) else ends_s


def _of_gaps(advance: NDArray[np.int64], coarse_s: float, step_s: float) -> float:
    """Return the relative uncertainty of a rate at which a stamp that skips a count may be the rate in place
    of a missing row."""
    if coarse_s <= _SKIPS * step_s:
        return 0.0
    return float(np.count_nonzero(advance == 2)) / float(np.sum(advance)) / math.sqrt(3.0)


def _advance(steps: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return how many sample steps lie between rows, for steps above zero."""
    step = float(np.median(steps))
    short = steps[steps < 2.5 * step]  # of stamps in coarse counts the median may be far off the mean
    step = float(np.mean(short))
    advance = np.maximum(np.round(steps / step), 0).astype(np.int64)
    for _ in range(_REFINEMENTS):
        step = float(np.sum(steps)) / max(1, int(np.sum(advance)))
        advance = np.maximum(np.round(steps / step), 0).astype(np.int64)
    return advance


def _resolution(time_s: NDArray[np.float64], steps: NDArray[np.float64]) -> float:
    """Return the step in which stamps count: the smallest between two, if all are multiples, or a decimal
    place."""
    positive = steps[steps > 0.0]
    rounding_s = 4 * float(np.spacing(np.abs(time_s).max()))
    candidates = [float(positive.min()), *(10.0**-places for places in range(_MOST_DECIMALS + 1))]
    for unit_s in candidates:
        counts = positive / unit_s
        if unit_s > 4 * rounding_s and np.all(np.abs(counts - np.round(counts)) * unit_s <= rounding_s):
            return unit_s
    return math.nan


def repeated_rows(time_s: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the rows that repeat both stamp and values, shape (n, columns), of the row before; none if by
    coarseness.

    Of rows under a coarse stamp some may be equal by chance, as may rows under different stamps.
    """
    equal = np.all(values[1:] == values[:-1], axis=1)
    same = time_s[1:] == time_s[:-1]
    if np.mean(equal[same]) > 0.5 and (same.all() or np.mean(equal[~same]) < 0.5 * np.mean(equal[same])):
        return np.flatnonzero(equal & same) + 1
    return np.empty(0, dtype=np.int64)


def _refused(time_s: NDArray[np.float64], refusal: str, resolution_s: float = math.nan) -> TimeBase:
    steps = np.diff(time_s)
    forward = steps[steps > 0.0]
    step_s = float(np.median(forward)) if len(forward) else math.nan
    begin_s = float(time_s[0]) if len(time_s) else math.nan
    return TimeBase(begin_s, step_s, math.nan, resolution_s, refusal=refusal)
