"""By how much the numbers of a ripple differ from period to period, and so from record to record."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, steps_of_periods
from benchtool.analysis.quantisation.steps_along import are_read_alike, steps_along
from benchtool.analysis.statistics.between_samples import Between, between_samples
from benchtool.analysis.statistics.excesses import FEWEST_EXTREMES
from benchtool.analysis.statistics.scatter import TOO_SLOW, MeanError, error_of_root
from benchtool.analysis.torque.means_of_periods import FEWEST_PERIODS, Periods, mean_over_periods
from benchtool.analysis.torque.ripple_extremes import Tails, extremes_of_ripple
from benchtool.analysis.torque.ripple_percentiles import percentile_scatter
from benchtool.analysis.torque.ripple_sizes import is_size_untold
from benchtool.analysis.torque.slow_ripple import SlowRipple

Floats = NDArray[np.float64]

_MOST_UNTOLD, _OF_SIZE = 2.0, 0.02  # standard uncertainties of the rms; of the rms itself
_ROUNDING = 1e-6  # of the rms
_LINES_BEAT = (
    "sinusoids slower than a period are less than a cycle of the record apart, so that it shows part of "
    "their beat: record longer"
)


@dataclass(frozen=True)
class Scatter:
    """Uncertainties of mean, rms and percentile range, and the standard deviation of a peak-to-peak.

    That of the percentile range is None of fewer than four periods, in which it is an extreme as well.
    `whole_mean` and `whole_rms` are the mean and rms without what incomplete periods and cycles make of them,
    `steps` the errors of a converter's steps that repeat, `between` what the ripple does between its samples.
    Where there is a reason `untold` why the size of the ripple is not known, all but that of the mean are
    nan.
    """

    periods: int
    repeated: str
    mean: MeanError
    rms: MeanError
    percentile_range: MeanError | None
    peak_to_peak: float
    mean_peak_to_peak: float
    whole_mean: float
    whole_rms: float
    steps: RepeatedSteps | None
    between: Between | None
    untold: str = ""

    def without_sizes(self, reason: str) -> Scatter:
        """Return it where the size of the ripple is not known, for this reason."""
        unknown = MeanError(math.nan, math.nan)
        of_range = None if self.percentile_range is None else unknown
        return replace(self, rms=unknown, percentile_range=of_range, peak_to_peak=math.nan, untold=reason)


def scatter_of_periods(
    samples: Floats,
    repeats: Periods,
    step: float = 0.0,
    *,
    percentiles: bool = True,
    reference: Floats | None = None,
) -> Scatter | None:
    """Return the scatter of the numbers of samples, shape (n,), over whole periods; None where there are too
    few."""
    rows, count = repeats.rows, len(repeats)
    if not repeats.tell_scatter:
        return None
    within, begin, counts = samples[: rows[-1]], rows[:-1], np.diff(rows)
    of_mean = mean_over_periods(samples, repeats, may_fall=True, reference=reference, by_revolutions=True)
    rest = within if of_mean.left is samples else of_mean.left[: rows[-1]]
    # what lines and the rest have in common is nothing over whole cycles of both
    square = np.square((of_mean.left if of_mean.of_lines else samples) - of_mean.mean)
    of_square = mean_over_periods(square, repeats, may_fall=True)
    squares = repeats.means(square)
    of_pace = _of_pace(samples[: rows[-1]] - rest, rest - of_mean.mean, repeats) if of_mean.of_lines else 0.0
    rms = math.sqrt(max(0.0, of_square.mean + of_mean.of_lines + of_pace))
    # noise as that of the mean moves an amplitude sqrt(2) times as much
    of_lines = 2.0 * math.sqrt(of_mean.of_lines) * of_mean.error.standard if of_mean.of_lines else 0.0
    # a record that has little of a slow noise by chance shows little scatter of its square
    of_square_alone = max(of_square.error.standard, of_mean.of_slow_noise)
    error_of_square = replace(of_square.error, standard=math.hypot(of_square_alone, of_lines))
    spans = np.maximum.reduceat(within, begin) - np.minimum.reduceat(within, begin)
    tails = Tails.of(within, begin, counts)
    slow = SlowRipple.of(within, repeats, of_mean, of_square)
    scatter = Scatter(
        periods=count,
        repeated=repeats.name,
        mean=of_mean.error,
        rms=error_of_root(squares, rms, error_of_square),
        percentile_range=percentile_scatter(within, slow)
        if percentiles and count >= FEWEST_EXTREMES
        else None,
        peak_to_peak=extremes_of_ripple(within, rest, begin, tails, step, slow),
        mean_peak_to_peak=float(np.mean(spans)),
        whole_mean=of_mean.mean,
        whole_rms=rms,
        steps=_errors_of_steps(within, repeats, step) if percentiles and step > 0.0 else None,
        between=between_samples(rest, repeats.turns),
    )
    lines = of_mean.lines if of_mean.course is None else None  # a course looks like lines that are near
    if lines is not None and _beat(lines.untold, rms, scatter.rms.standard):
        return scatter.without_sizes(_LINES_BEAT)
    return scatter.without_sizes(TOO_SLOW) if is_size_untold(of_mean.left, repeats) else scatter


def _of_pace(lines: Floats, rest: Floats, repeats: Periods) -> float:
    """Return the mean over time of what slow lines, shape (n,), have in common with themselves and with the
    rest, less that over what repeats: a speed that swings with them stays longer where they are high, or low.

    A drift of the pace counts in the incomplete cycles at both ends only, and is left out.
    """
    place = repeats.places(len(lines))
    pace = np.gradient(place)
    swing = pace - np.polynomial.Polynomial.fit(place, pace, 1)(place)
    return -float(np.mean(swing * lines * (lines + 2.0 * rest))) / float(np.mean(pace))


def _beat(untold: float, rms: float, standard: float) -> bool:
    """Return whether a mean square that slow lines do not tell is too much for an rms with a standard
    uncertainty, nan where that is not known."""
    of_rms = untold / (2.0 * rms) if untold > 0.0 else 0.0
    most = _OF_SIZE * rms
    if math.isfinite(standard):
        most = min(most, max(_MOST_UNTOLD * standard, _ROUNDING * rms))
    return of_rms > most


def _errors_of_steps(samples: Floats, repeats: Periods, step: float) -> RepeatedSteps | None:
    """Return the errors of a converter's steps in samples, shape (n,): alike in every period or revolution,
    or along what repeats in none."""
    rows, turns = repeats.rows, repeats.turns
    every = repeats.per_revolution if len(repeats) >= FEWEST_PERIODS * repeats.per_revolution else 1
    if are_read_alike(samples, turns / every, step):
        return steps_of_periods(samples, rows, repeats.per_revolution, step, turns)
    return steps_along(samples, step)
