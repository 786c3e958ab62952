"""From the time stamps of foreign data to one sample rate, or to the reason why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Gap

_FEWEST_STAMPS = 8
_LARGEST_DEVIATION = 0.1  # of a step, peak to peak: a tone at a tenth of the rate keeps 3 % of phase
_REPEATED_BY_RESOLUTION = 0.05  # share of equal stamps from which the resolution, not a repeat, is the cause
_REFINEMENTS = 4
_MOST_DECIMALS = 9


@dataclass(frozen=True)
class TimeBase:
    """What a column of time stamps comes to.

    `refusal` says why the rows are not taken at equal steps, and is empty where they are; then row k was
    taken at `begin_s + step_s * (k + rows missing before it)`, with the missing rows in `gaps`. `jitter_s` is
    the rms deviation of the stamps from that line, `resolution_s` the step in which stamps count (nan if
    there is none to be seen). Where they are refused, `step_s` is the median step between different stamps.
    """

    begin_s: float
    step_s: float
    jitter_s: float
    resolution_s: float
    gaps: tuple[Gap, ...] = ()
    refusal: str = ""

    @property
    def rate_Hz(self) -> float:
        return 1.0 / self.step_s if self.step_s > 0.0 else math.nan

    @property
    def missing_rows(self) -> int:
        return sum(gap.missing_rows for gap in self.gaps)


def time_base(time_s: NDArray[np.float64]) -> TimeBase:
    """The time base behind stamps, shape (n,), in the order of the rows and finite.

    A line through row number and stamp by least squares gives the rate. Rows are missing where a stamp is
    later by a whole number of steps. Where stamps are coarser than the rows, such as 1 ms for rows at 10 kHz,
    many are equal; the rows are uniform if the stamps follow the line within their resolution, and what is
    missing is seen from that length on only. Stamps that deviate by more than their resolution and a
    tenth of a step, peak to peak, that go back or that repeat are refused: nothing is interpolated.
    """
    if len(time_s) < _FEWEST_STAMPS:
        return _refused(time_s, f"{len(time_s)} rows, at least {_FEWEST_STAMPS} are needed")
    steps = np.diff(time_s)
    if not np.any(steps):
        return _refused(time_s, f"the time is {time_s[0]:g} s in every row")
    back = np.flatnonzero(steps < 0.0)
    if len(back):
        places = "once" if len(back) == 1 else f"{len(back)} times"
        return _refused(
            time_s,
            f"the time goes back {places}, first by {-steps[back[0]]:.6g} s at row {back[0] + 2}: "
            f"records joined together, or rows out of order",
        )
    resolution_s = _resolution(time_s, steps)
    repeated = np.flatnonzero(steps == 0.0)
    if len(repeated) > _REPEATED_BY_RESOLUTION * len(steps):
        advance = np.ones(len(steps), dtype=np.int64)
    elif len(repeated):
        return _refused(
            time_s,
            f"{len(repeated)} rows repeat the time of the row before, first row {repeated[0] + 2}",
            resolution_s,
        )
    else:
        advance = _advance(steps)
    return _on_a_line(time_s, np.concatenate(([0], np.cumsum(advance))), advance, resolution_s)


def _on_a_line(
    time_s: NDArray[np.float64], tick: NDArray[np.int64], advance: NDArray[np.int64], resolution_s: float
) -> TimeBase:
    # about the middle, where offset and slope do not hang on each other
    number = tick - tick.mean()
    about = time_s - time_s.mean()
    step_s = float(number @ about) / float(number @ number)
    deviation = about - step_s * number
    spread_s = float(np.ptp(deviation))
    coarse_s = resolution_s if math.isfinite(resolution_s) else 0.0
    rounding_s = 4 * float(np.spacing(np.abs(time_s).max()))
    if np.any(advance < 1) or spread_s > max(1.1 * coarse_s, _LARGEST_DEVIATION * step_s) + rounding_s:
        worst = int(np.argmax(np.abs(deviation)))
        steps = np.diff(time_s)
        return _refused(
            time_s,
            f"the time stamps are not even: steps of {steps.min():.4g} s to {steps.max():.4g} s, off an even "
            f"grid by up to {abs(deviation[worst]):.3g} s (row {worst + 1})",
            resolution_s,
        )
    late = np.flatnonzero(advance > 1)
    return TimeBase(
        begin_s=float(time_s.mean() - step_s * tick.mean()),
        step_s=step_s,
        jitter_s=float(np.sqrt(np.mean(deviation**2))),
        resolution_s=resolution_s,
        gaps=tuple(Gap(int(row) + 1, int(advance[row]) - 1) for row in late),
    )


def _advance(steps: NDArray[np.float64]) -> NDArray[np.int64]:
    """How many sample steps lie between rows, for steps above zero."""
    step = float(np.median(steps))
    short = steps[steps < 2.5 * step]  # of stamps in coarse counts the median may be far off the mean
    step = float(np.mean(short))
    advance = np.maximum(np.round(steps / step), 0).astype(np.int64)
    for _ in range(_REFINEMENTS):
        step = float(np.sum(steps)) / max(1, int(np.sum(advance)))
        advance = np.maximum(np.round(steps / step), 0).astype(np.int64)
    return advance


def _resolution(time_s: NDArray[np.float64], steps: NDArray[np.float64]) -> float:
    """The step in which stamps count: the smallest between two, if all are multiples, or a decimal place."""
    positive = steps[steps > 0.0]
    rounding_s = 4 * float(np.spacing(np.abs(time_s).max()))
    candidates = [float(positive.min()), *(10.0**-places for places in range(_MOST_DECIMALS + 1))]
    for unit_s in candidates:
        counts = positive / unit_s
        if unit_s > 4 * rounding_s and np.all(np.abs(counts - np.round(counts)) * unit_s <= rounding_s):
            return unit_s
    return math.nan


def _refused(time_s: NDArray[np.float64], refusal: str, resolution_s: float = math.nan) -> TimeBase:
    steps = np.diff(time_s)
    forward = steps[steps > 0.0]
    step_s = float(np.median(forward)) if len(forward) else math.nan
    begin_s = float(time_s[0]) if len(time_s) else math.nan
    return TimeBase(begin_s, step_s, math.nan, resolution_s, refusal=refusal)
