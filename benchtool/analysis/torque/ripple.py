"""Ripple of a signal about its mean."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.period_marks import PeriodMarks, marks_of_rotor
from benchtool.analysis.quantisation.repeated_steps import rms_before_steps
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.statistics.between_samples import BETWEEN
from benchtool.analysis.statistics.excesses import FEWEST_EXTREMES
from benchtool.analysis.statistics.mean_beside import MeanBeside
from benchtool.analysis.statistics.scatter import TOO_SLOW, MeanError
from benchtool.analysis.torque.means_of_periods import FEWEST_PERIODS, Periods
from benchtool.analysis.torque.ripple_percent import no_base, percent
from benchtool.analysis.torque.ripple_percentiles import HIGH_PERCENT, LOW_PERCENT, percentile_range
from benchtool.analysis.torque.ripple_scatter import Scatter, scatter_of_periods
from benchtool.analysis.uncertainty import (
    Contribution,
    Uncertainty,
    combined,
    combined_by_names,
    coverage_factor,
)
from benchtool.analysis.validity import clipping, held_rows, require_signal, require_unbroken, standing
from benchtool.block import Block, as_samples

_TOO_FEW_EXTREMES = "the extremes of fewer than four periods do not tell how much they scatter: record longer"
_GROWS = "the ripple grows or falls over the whole record: record longer, or choose a window in steady state"
_FEWEST_UPDATES = 18.0  # in a period: three of each crest of the sixth order, that of a bridge of six pulses
_TOO_SLOW_NOISE = "noise slower than the record, which moves its mean and not its rms"
_MEET_SLOWLY = (
    "it, or where in its few steps the rows fall, wanders more slowly than the record shows: record longer, "
    "or in finer steps"
)
_DOF_OF_EXTREMES = 10.0  # of a tail from a few of the largest values


@dataclass(frozen=True)
class Ripple:
    """Mean and deviation of a signal, in the signal's `unit`."""

    mean: float
    peak_to_peak: float
    rms: float
    unit: str


def ripple(samples: NDArray[np.float64], unit: str, name: str = "signal") -> Ripple:
    """Return the ripple of uniformly sampled values, shape (n,).

    `peak_to_peak` is maximum minus minimum of all samples, `rms` the root mean square of the deviation from
    the mean (divided by n, not n - 1). Nothing is filtered. `name` stands in the messages.

    Raises:
        AnalysisError: too short, not finite, constant, or not of shape (n,).
    """
    samples = as_samples(samples, name)
    require_signal(samples, name, unit)
    return Ripple(
        mean=float(np.mean(samples)),
        peak_to_peak=float(np.max(samples) - np.min(samples)),
        rms=float(np.std(samples)),
        unit=unit,
    )


def record_basis(block: Block) -> Basis:
    """Return basis of all rows of a block without gaps: unfiltered, with aliases from above half the rate."""
    samples, rate_Hz = len(block.data), block.sample_rate_Hz
    return Basis(
        samples,
        rate_Hz,
        samples / rate_Hz,
        0.5 * rate_Hz,
        "rectangular, all samples",
        gaps=0,
        alignment_s=block.alignment_s or None,
    )


def ripple_numbers(
    block: Block,
    channel: str,
    name: str,
    *,
    rated: float | None = None,
    track: PhaseTrack | None = None,
    pole_pairs: int = 1,
    what: str = "",
    reference: str = "",
) -> tuple[Measurement, ...]:
    """Return the mean of a channel, and its ripple peak to peak, rms and between percentiles, absolute and
    relative.

    Args:
        block: rows without gaps; of any uniform rate.
        channel: the channel to measure.
        name: what the names of the measurements begin with, such as torque.
        rated: the base of the numbers "of rated", in the channel's unit; None leaves them out.
        track: phase over the rows, for uncertainties from the scatter over whole electrical periods; without
            it, or with fewer than three periods, there are none.
        pole_pairs: electrical periods in a mechanical revolution, where the track is by its angle: what is
            slower than a period may repeat with that.
        what: words for the channel in the definitions.
        reference: a channel that this one follows, if one is known: its slow noise is in the mean, and hidden
            by less.

    Raises:
        AnalysisError: a gap, no such channel, or one that is too short, not finite or constant.
    """
    require_unbroken(block)
    samples, unit = np.ascontiguousarray(block.column(channel)), block.unit(channel)
    # without an angle the machine may slip
    has_angle = track is not None and track.residual_rad is not None
    marks = None if track is None else marks_of_rotor(track)
    followed = np.ascontiguousarray(block.column(reference)) if reference else None
    return ripple_of_rows(
        samples,
        unit,
        name,
        record_basis(block),
        rated=rated,
        marks=marks,
        per_revolution=pole_pairs if has_angle else 1,
        what=what or channel,
        channel=channel,
        reference=None if followed is None or not np.all(np.isfinite(followed)) else followed,
    )


def ripple_of_rows(
    samples: NDArray[np.float64],
    unit: str,
    name: str,
    basis: Basis,
    *,
    rated: float | None = None,
    marks: PeriodMarks | None = None,
    repeated: str = "electrical periods",
    per_revolution: int = 1,
    what: str = "signal",
    channel: str = "",
    no_periods: str = "",
    reference: NDArray[np.float64] | None = None,
    beside: MeanBeside | None = None,
) -> tuple[Measurement, ...]:
    """`ripple_numbers` of samples, shape (n,), at any times, each counting the same.

    `marks` are where what repeats begins, and where the last one ends; `repeated` says what that is,
    `per_revolution` how many make a revolution. Messages name `channel`, or `what` where it is not given.
    `no_periods` is why nothing tells `marks`, where that is not for lack of an angle, a current or a speed.
    `beside` is the mean where another channel tells its course: that over all rows, which needs no periods.

    Raises:
        AnalysisError: too short, not finite, or constant.
    """
    whole = ripple(samples, unit, channel or what)
    step = counting_step(samples)
    scatter = None
    if marks is not None:
        repeats = Periods.of(marks, per_revolution, repeated)
        scatter = scatter_of_periods(samples, repeats, step, reference=reference)
    unknown = ""
    if scatter is None or marks is None:
        unknown = _without_periods(None if marks is None else marks.numbers, repeated, no_periods)
    else:
        rms = rms_before_steps(scatter.whole_rms, step, scatter.steps)
        whole = replace(whole, mean=scatter.whole_mean, rms=rms)
        unknown = _few_updates(samples, marks.numbers, repeated)
        scatter = replace(scatter, percentile_range=None) if unknown else scatter
    if beside is not None:
        whole = replace(whole, mean=beside.value)
    invalid = _clipped(samples, whole.unit)
    seen = _Seen(whole, scatter, unknown, step, what, channel or what, basis, invalid, beside)
    return tuple(_numbers(seen, percentile_range(samples), name, rated))


def _without_periods(
    marks: NDArray[np.float64] | None, repeated: str = "electrical periods", no_periods: str = ""
) -> str:
    """Return why nothing tells how much numbers scatter."""
    if marks is None:
        return no_periods or "no angle, current or stated speed tells periods, whose scatter would tell it"
    return (
        f"of whole {repeated} the record has {len(marks) - 1}, at least {FEWEST_PERIODS} are needed for the "
        f"scatter: record longer"
    )


def _few_updates(samples: NDArray[np.float64], marks: NDArray[np.float64], repeated: str) -> str:
    """Return why percentiles of held samples, shape (n,), are not known: of few values at the same places of
    all periods it is chance how near the crests they are; empty if they are enough."""
    held = held_rows(samples)
    updates = float(marks[-1]) / (len(marks) - 1) / held
    if held == 1.0 or updates >= _FEWEST_UPDATES:
        return ""
    return (
        f"each value is held for {held:.3g} rows, and {repeated} have {updates:.3g} of them, at least "
        f"{_FEWEST_UPDATES:g} are needed for their percentiles: record the signal at a higher rate"
    )


def peak_to_peak_number(
    block: Block, channel: str, name: str, *, track: PhaseTrack | None = None, what: str = ""
) -> Measurement:
    """Return the peak-to-peak ripple alone of a channel, called `name`; arguments and errors of
    `ripple_numbers`."""
    require_unbroken(block)
    samples = np.ascontiguousarray(block.column(channel))
    whole = ripple(samples, block.unit(channel), channel)
    scatter, step = None, counting_step(samples)
    if track is not None:
        repeats = Periods(track.period_rows())
        scatter = scatter_of_periods(samples, repeats, step, percentiles=False)
    basis, invalid = record_basis(block), _clipped(samples, whole.unit)
    unknown = "" if scatter is not None else _without_periods(None if track is None else track.period_marks())
    seen = _Seen(whole, scatter, unknown, step, what or channel, channel, basis, invalid)
    return seen.peak_to_peak(name)


def _clipped(samples: NDArray[np.float64], unit: str) -> str:
    """Return why samples, shape (n,), are no signal of their own; empty if they are."""
    return clipping(samples, unit) or standing(samples, unit)


@dataclass(frozen=True)
class _Seen:
    """A ripple with what tells how much its numbers scatter, or `unknown`, why something does not; `clipped`
    is why there are no numbers. `step` is that of the converter, `what` the channel in words, `beside` the
    mean by what another channel tells."""

    whole: Ripple
    scatter: Scatter | None
    unknown: str
    step: float
    what: str
    channel: str
    basis: Basis
    clipped: str
    beside: MeanBeside | None = None

    def mean(self, name: str, of_steps: float) -> Measurement:
        """Return the mean, of which the converter's steps leave `of_steps` uncertain."""
        beside, scatter, value = self.beside, self.scatter, self.whole.mean
        sensitivities, steps = Sensitivities.of_mean(self.channel, value), self.resolution(of_steps)
        if beside is None or self.clipped:
            text, error = f"mean of {self.what}{self.without}", scatter.mean if scatter else None
            return self.number(name, text, value, error, sensitivities, steps)
        text = (
            f"mean of {self.what} over time, from the first row to the last, by the trapezoidal rule; its "
            f"error by what it reads beside the course of {beside.channel}"
        )
        lines = tuple(each for each in (beside.line, steps) if each.standard != 0.0)
        return Measurement(
            name,
            value,
            self.whole.unit,
            text,
            self.basis,
            combined_by_names(lines or (beside.line,)),
            repeatability=beside.between_records,
            sensitivities=sensitivities,
        )

    @property
    def without(self) -> str:
        """What a number leaves out, in words."""
        return "" if self.scatter is None else ", without what the incomplete period at the end makes of it"

    def number(
        self,
        name: str,
        text: str,
        value: float,
        error: MeanError | None,
        sensitivities: Sensitivities,
        *further: Contribution,
        bound: float = 0.0,
    ) -> Measurement:
        """Return a number with its `error` by scatter and `further` lines, all of it within `bound` where
        that is not 0."""
        unit = self.whole.unit
        if self.clipped:
            return Measurement.undefined(name, unit, text, self.clipped, self.basis)
        uncertain, why = None, self.unknown or _TOO_FEW_EXTREMES
        if self.scatter is not None and error is not None:
            in_few_steps = self.scatter.steps is not None and self.scatter.steps.are_few
            why = _MEET_SLOWLY if in_few_steps else self.scatter.untold or TOO_SLOW
            line = error.line(f"scatter over {self.scatter.periods} {self.scatter.repeated}")
            lines = tuple(each for each in (line, *further) if each.standard != 0.0)
            uncertain = combined_by_names(lines or (line,))
        return Measurement(
            name,
            value,
            unit,
            text,
            self.basis,
            _of_two_readings(uncertain, bound),
            uncertainty_reason=why if uncertain is None else "",
            sensitivities=sensitivities,
        )

    def peak_to_peak(self, name: str) -> Measurement:
        """Return the peak-to-peak ripple."""
        whole, scatter, step = self.whole, self.scatter, self.step
        text, value = f"maximum minus minimum of {self.what}", whole.peak_to_peak
        if self.clipped:
            return Measurement.undefined(name, whole.unit, text, self.clipped, self.basis)
        uncertain, why = None, ""
        if scatter is None:
            why = self.unknown
        elif not math.isfinite(scatter.peak_to_peak):
            # a resolution beside a scatter that is not known would be stated as if it were all
            why = _TOO_FEW_EXTREMES if scatter.periods < FEWEST_EXTREMES else _GROWS
            why = scatter.untold or why
        else:
            # of a difference of two readings, each known to within a step (JCGM 100:2008, F.2.2.1)
            budget = [self.resolution(step / math.sqrt(6.0))] if step else []
            budget.append(
                Contribution("scatter of the extremes", "A", scatter.peak_to_peak, _DOF_OF_EXTREMES)
            )
            if missed := _missed(scatter, np.ptp):
                budget.append(Contribution(BETWEEN, "B", missed))
            source = (
                f"scatter of maximum and minimum over records of this length, by those of the "
                f"{scatter.periods} single {scatter.repeated}, whose mean peak-to-peak is "
                f"{scatter.mean_peak_to_peak:.4g} {whole.unit}; a longer record reads more"
            )
            uncertain = _of_two_readings(combined(budget, source), step)
        return Measurement(
            name,
            value,
            whole.unit,
            text,
            self.basis,
            uncertain,
            uncertainty_reason=why,
            sensitivities=Sensitivities.of_extremes(self.channel, value),
        )

    def resolution(self, standard: float) -> Contribution:
        """Return the line of a resolution."""
        return Contribution(f"resolution {self.step:.3g} {self.whole.unit}", "B", standard)


def _numbers(seen: _Seen, range_between: float, name: str, rated: float | None) -> Iterator[Measurement]:
    """Yield the numbers of a ripple between whose percentiles there is a range."""
    whole, scatter, step, what, channel = seen.whole, seen.scatter, seen.step, seen.what, seen.channel
    less_steps = "" if scatter is None or not step else f", less what steps of {step:.3g} {whole.unit} add"
    # what noise turns into noise, the scatter holds already
    of_mean, of_rms = step / math.sqrt(12.0) if scatter is None else 0.0, 0.0
    if scatter is not None and scatter.steps is not None:
        of_mean, of_rms = scatter.steps.of_mean(), scatter.steps.of_rms
    # noise too slow for the record moves its mean in place of its rms: nan where that is not known
    taken = 0.0
    if scatter is not None and whole.rms > 0.0:
        taken = scatter.mean.standard**2 / (2.0 * whole.rms)
    of_range = taken * range_between / whole.rms if math.isfinite(taken) and whole.rms > 0.0 else 0.0
    mean = seen.mean(f"{name}_mean", of_mean)
    yield mean
    peak_to_peak = seen.peak_to_peak(f"{name}_ripple_pp")
    yield peak_to_peak
    rms = seen.number(
        f"{name}_ripple_rms",
        f"rms of {what} about its mean{seen.without}{less_steps}",
        whole.rms,
        scatter.rms if scatter else None,
        Sensitivities.of_rms(channel, whole.rms),
        seen.resolution(of_rms),
        Contribution(_TOO_SLOW_NOISE, "B", taken),
    )
    yield rms
    yield seen.number(
        f"{name}_ripple_percentile_range",
        f"{HIGH_PERCENT:g}th minus {LOW_PERCENT:g}th percentile of {what}",
        range_between,
        scatter.percentile_range if scatter else None,
        Sensitivities.of_extremes(channel, range_between, LOW_PERCENT),
        seen.resolution(step / math.sqrt(6.0)),
        Contribution(_TOO_SLOW_NOISE, "B", of_range),
        Contribution(BETWEEN, "B", _missed(scatter, percentile_range)),
        bound=step,
    )
    reason = seen.clipped or no_base(mean, whole.peak_to_peak, name)
    for number in (peak_to_peak, rms):
        yield percent(number, f"{name}_ripple", "of_mean", abs(whole.mean), f"|{name}_mean|", reason, mean)
    if rated is not None:
        reason = seen.clipped or ("" if rated > 0.0 else f"it is {rated:g} {whole.unit}")
        for number in (peak_to_peak, rms):
            base = f"rated torque of {rated:g} {whole.unit}"
            yield percent(number, f"{name}_ripple", "of_rated", rated, base, reason)


def _missed(scatter: Scatter | None, number: Callable[[NDArray[np.float64]], float]) -> float:
    """Return by how much samples at the same places of all periods miss a number of the curve."""
    return 0.0 if scatter is None or scatter.between is None else scatter.between.error_of(number)


def _of_two_readings(uncertain: Uncertainty | None, step: float) -> Uncertainty | None:
    """Return the uncertainty of a difference of two readings, each on the nearest level of a converter.

    Where the steps are most of it the reading is one of two, by how far the difference is from a whole number
    of steps: for none of them does the error exceed a step, but for most of them it is near one at times.
    """
    if uncertain is None or not step > 0.0:
        return uncertain
    of_step = step / math.sqrt(6.0)
    rest = math.sqrt(max(0.0, uncertain.experimental**2 - of_step**2))
    return replace(uncertain, half_width=math.hypot(step, coverage_factor(uncertain.dof) * rest))
