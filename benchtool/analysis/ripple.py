"""Ripple of a signal about its mean."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy import fft
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.quantisation import counting_step
from benchtool.analysis.repeated_steps import RepeatedSteps, noise_beside, repeated_steps
from benchtool.analysis.scatter import (
    MeanError,
    at_lowest_frequencies,
    error_of_root,
    error_of_series,
    scatter_of_largest,
    tail_index,
)
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined, coverage_factor
from benchtool.analysis.validity import clipping, require_signal, require_unbroken, standing
from benchtool.block import Block, as_samples

Floats = NDArray[np.float64]

_SMALLEST_MEAN = 0.02  # share of the peak-to-peak ripple below which "percent of mean" has no meaning
_SIGNIFICANT = 5.0  # standard uncertainties of the mean, from which a ratio to it is one
_DOF_OF_EXTREMES = 10.0  # of a tail from a few of the largest values
_FEWEST_PERIODS = 3  # fewest periods whose scatter is used
_CORRELATED = 2.0  # periods that count as one, from which a tail is made of stretches of them
_PARTS, _WHOLE_OVER_PARTS = 8, 1.5  # the whole reaches further into the tail than a part, and scatters more
_LOW, _HIGH = 0.5, 99.5  # per cent
_SAMPLES_OF_TAIL = 1 << 17
_NEAR = 0.25  # per cent to either side, for the density there


@dataclass(frozen=True)
class Ripple:
    """Mean and deviation of a signal, in the signal's `unit`."""

    mean: float
    peak_to_peak: float
    rms: float
    unit: str


@dataclass(frozen=True)
class _Scatter:
    """Uncertainties of mean, rms and percentile range, and the standard deviation of a peak-to-peak.

    `incomplete_mean` and `incomplete_rms` are what the part of a period at the record's end moves, `steps`
    the errors of a converter's steps that repeat.
    """

    periods: int
    repeated: str
    mean: MeanError
    rms: MeanError
    percentile_range: MeanError
    peak_to_peak: float
    mean_peak_to_peak: float
    incomplete_mean: float
    incomplete_rms: float
    steps: RepeatedSteps | None


def ripple(samples: NDArray[np.float64], unit: str, name: str = "signal") -> Ripple:
    """Return the ripple of uniformly sampled values, shape (n,).

    `peak_to_peak` is maximum minus minimum of all samples, `rms` the root mean square of the deviation from
    the mean (divided by n, not n - 1). Nothing is filtered. `name` stands in the messages.

    Raises:
        AnalysisError: too short, not finite, constant, or not of shape (n,).
    """
    samples = as_samples(samples, name)
    require_signal(samples, name)
    return Ripple(
        mean=float(np.mean(samples)),
        peak_to_peak=float(np.max(samples) - np.min(samples)),
        rms=float(np.std(samples)),
        unit=unit,
    )


def percentile_range(samples: NDArray[np.float64]) -> float:
    """Return 99.5th minus the 0.5th percentile of samples, shape (n,), which single spikes do not affect."""
    low, high = np.percentile(samples, (_LOW, _HIGH))
    return float(high - low)


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
    what: str = "",
) -> tuple[Measurement, ...]:
    """Return the mean of a channel, and its ripple peak to peak, rms and between percentiles, absolute and
    relative.

    Args:
        block: rows without gaps; of any uniform rate.
        channel: the channel to measure.
        name: what the names of the measurements begin with, such as torque.
        rated: the base of the numbers "of rated", in the channel's unit; None leaves them out.
        track: phase over the rows, for uncertainties from the scatter over whole electrical periods; without
            it, or with fewer than three periods, there are none but that of the peak-to-peak from a
            resolution.
        what: words for the channel in the definitions.

    Raises:
        AnalysisError: a gap, no such channel, or one that is too short, not finite or constant.
    """
    require_unbroken(block)
    samples, unit = np.ascontiguousarray(block.column(channel)), block.unit(channel)
    begins = None if track is None else track.period_rows()
    basis = record_basis(block)
    return ripple_of_rows(
        samples, unit, name, basis, rated=rated, begins=begins, what=what or channel, channel=channel
    )


def ripple_of_rows(
    samples: NDArray[np.float64],
    unit: str,
    name: str,
    basis: Basis,
    *,
    rated: float | None = None,
    begins: NDArray[np.int64] | None = None,
    repeated: str = "electrical periods",
    what: str = "signal",
    channel: str = "",
) -> tuple[Measurement, ...]:
    """`ripple_numbers` of samples, shape (n,), at any times, each counting the same.

    `begins`, shape (m + 1,), are the rows at which what repeats begins, the first 0, and the row after the
    last; `repeated` says what that is. Messages name `channel`, or `what` where it is not given.

    Raises:
        AnalysisError: too short, not finite, or constant.
    """
    whole = ripple(samples, unit, channel or what)
    step = counting_step(samples)
    scatter = None if begins is None else _scatter(samples, whole, begins, repeated, step)
    return tuple(_numbers(samples, whole, scatter, step, name, what, rated, basis))


def peak_to_peak_number(
    block: Block, channel: str, name: str, *, track: PhaseTrack | None = None, what: str = ""
) -> Measurement:
    """Return the peak-to-peak ripple alone of a channel, called `name`; arguments and errors of
    `ripple_numbers`."""
    require_unbroken(block)
    samples = np.ascontiguousarray(block.column(channel))
    whole = ripple(samples, block.unit(channel), channel)
    scatter = None if track is None else _scatter(samples, whole, track.period_rows(), percentiles=False)
    step = counting_step(samples)
    basis = record_basis(block)
    return _peak_to_peak(
        name, what or channel, whole, scatter, step, basis, clipping(samples) or standing(samples)
    )


def _numbers(
    samples: NDArray[np.float64],
    whole: Ripple,
    scatter: _Scatter | None,
    step: float,
    name: str,
    what: str,
    rated: float | None,
    basis: Basis,
) -> Iterator[Measurement]:
    unit = whole.unit
    clipped = clipping(samples) or standing(samples)

    def measured(
        suffix: str,
        text: str,
        value: float,
        error: MeanError | None,
        incomplete: float,
        floor: float,
        bound: float = 0.0,
        slow: float = 0.0,
    ) -> Measurement:
        full = f"{name}_{suffix}"
        if clipped:
            return Measurement.undefined(full, unit, text, clipped, basis)
        if scatter is None or error is None:
            return Measurement(full, value, unit, text, basis)
        budget = (
            Contribution(
                f"scatter over {scatter.periods} {scatter.repeated}", "A", error.standard, error.dof
            ),
            Contribution("share of the incomplete one at the end", "B", abs(incomplete)),
            Contribution(f"resolution {step:.3g} {unit}", "B", floor),
            Contribution("noise too slow for the record", "B", slow),
        )
        source = (
            f"scatter over {scatter.periods} {scatter.repeated}, the share of the incomplete one, resolution"
        )
        lines = tuple(each for each in budget if each.standard != 0.0)
        uncertain = combined(lines, source)
        return Measurement(full, value, unit, text, basis, _of_two_readings(uncertain, bound))

    # ripple that spans several steps turns quantization into noise, which the scatter holds already
    of_mean = step / math.sqrt(12.0) if whole.rms < step else 0.0
    of_rms = math.sqrt(2.0) * of_mean
    if scatter is not None and scatter.steps is not None:
        of_mean, of_rms = max(of_mean, scatter.steps.of_mean()), max(of_rms, scatter.steps.of_rms)
    # noise too slow for the record moves its mean in place of its rms
    taken = 0.0
    if scatter is not None and whole.rms > 0.0 and math.isfinite(scatter.mean.standard):
        taken = scatter.mean.standard**2 / (2.0 * whole.rms)
    # steps add a twelfth of their square to the mean square
    of_rms = math.hypot(of_rms, step**2 / (24.0 * whole.rms) if whole.rms > 0.0 else 0.0)
    mean = measured(
        "mean",
        f"mean of {what}",
        whole.mean,
        scatter.mean if scatter else None,
        scatter.incomplete_mean if scatter else 0.0,
        of_mean,
    )
    yield mean
    peak_to_peak = _peak_to_peak(f"{name}_ripple_pp", what, whole, scatter, step, basis, clipped)
    yield peak_to_peak
    rms = measured(
        "ripple_rms",
        f"rms of {what} about its mean",
        whole.rms,
        scatter.rms if scatter else None,
        scatter.incomplete_rms if scatter else 0.0,
        of_rms,
        slow=taken,
    )
    yield rms
    range_between = percentile_range(samples)
    yield measured(
        "ripple_percentile_range",
        f"{_HIGH:g}th minus {_LOW:g}th percentile of {what}",
        range_between,
        scatter.percentile_range if scatter else None,
        0.0,
        step / math.sqrt(6.0),
        step,
        slow=taken * range_between / whole.rms if whole.rms > 0.0 else 0.0,
    )
    reason = clipped or _no_base(mean, whole, name)
    for number in (peak_to_peak, rms):
        yield _percent(number, f"{name}_ripple", "of_mean", abs(whole.mean), f"|{name}_mean|", reason, mean)
    if rated is not None:
        reason = clipped or ("" if rated > 0.0 else f"it is {rated:g} {unit}")
        for number in (peak_to_peak, rms):
            base = f"rated {name} of {rated:g} {unit}"
            yield _percent(number, f"{name}_ripple", "of_rated", rated, base, reason)


def _repeated_steps(samples: Floats, begins: NDArray[np.int64], step: float) -> RepeatedSteps | None:
    """Return the errors of a converter's steps that are the same in every period; None where noise hides
    them."""
    periods = len(begins) - 1
    points = round((begins[-1] - begins[0]) / periods)
    at = begins[:-1, np.newaxis] + np.diff(begins)[:, np.newaxis] * (np.arange(points) / points)
    table = np.interp(at.ravel(), np.arange(len(samples)), samples).reshape(at.shape)
    phasors = fft.rfft(np.mean(table, axis=0))[1:] * (2.0 / points)
    if points % 2 == 0:
        phasors[-1] *= 0.5
    # periods begin within a sample: what the slope makes of that is no noise
    number = np.arange(periods + 1)
    within2 = float(np.var(begins - Polynomial.fit(number, begins, min(2, periods))(number)))
    slope = phasors * np.arange(1, len(phasors) + 1) * (2.0 * np.pi / points)
    left = float(np.mean(np.var(table, axis=0, ddof=1))) - within2 * float(np.sum(np.abs(slope) ** 2))
    # nor are periods that the track does not follow closely, which leave neighbouring samples alike
    noise2 = min(left, float(np.mean(np.diff(samples, 2) ** 2)) / 6.0)
    mean, covered = float(np.mean(table)), float(begins[-1] - begins[0])
    return repeated_steps(mean, phasors, step, noise_beside(noise2, step), covered, periods)


def _no_base(mean: Measurement, whole: Ripple, name: str) -> str:
    """Return why no percentage of the mean is given; empty if the mean is far enough from zero."""
    size = abs(whole.mean)
    if size <= _SMALLEST_MEAN * whole.peak_to_peak:
        return f"the mean {name} is zero, or less than {100 * _SMALLEST_MEAN:g} % of its ripple"
    if mean.uncertainty is not None and size < _SIGNIFICANT * mean.uncertainty.standard:
        return f"the mean {name} cannot be distinguished from zero"
    return ""


def _peak_to_peak(
    name: str,
    what: str,
    whole: Ripple,
    scatter: _Scatter | None,
    step: float,
    basis: Basis,
    clipped: str = "",
) -> Measurement:
    text = f"maximum minus minimum of {what}"
    if clipped:
        return Measurement.undefined(name, whole.unit, text, clipped, basis)
    # of a difference of two readings, each known to within a step (JCGM 100:2008, F.2.2.1)
    budget = [Contribution(f"resolution {step:.3g} {whole.unit}", "B", step / math.sqrt(6.0))] if step else []
    source = f"resolution {step:.3g} {whole.unit} / sqrt(6) alone"
    if scatter is not None and math.isfinite(scatter.peak_to_peak):
        budget.append(Contribution("scatter of the extremes", "A", scatter.peak_to_peak, _DOF_OF_EXTREMES))
        source = (
            f"scatter of maximum and minimum over records of this length, by those of the {scatter.periods} "
            f"single {scatter.repeated}, whose mean peak-to-peak is {scatter.mean_peak_to_peak:.4g} "
            f"{whole.unit}; a longer record reads more"
        )
    uncertain = _of_two_readings(combined(budget, source), step) if budget else None
    return Measurement(name, whole.peak_to_peak, whole.unit, text, basis, uncertain)


def _of_two_readings(uncertain: Uncertainty | None, step: float) -> Uncertainty | None:
    """Return the uncertainty of a difference of two readings, each on the nearest level of a converter.

    Where the steps are most of it the reading is one of two, by how far the difference is from a whole number
    of steps: for none of them does the error exceed a step, but for most of them it is near one at times.
    """
    if uncertain is None or not step > 0.0:
        return uncertain
    of_step = step / math.sqrt(6.0)
    rest = math.sqrt(max(0.0, uncertain.standard**2 - of_step**2))
    return replace(uncertain, half_width=math.hypot(step, coverage_factor(uncertain.dof) * rest))


def _percent(
    number: Measurement,
    prefix: str,
    suffix: str,
    base: float,
    base_text: str,
    reason: str,
    base_number: Measurement | None = None,
) -> Measurement:
    which = "_rms" if number.name.endswith("_rms") else ""
    name, text = f"{prefix}{which}_percent_{suffix}", f"100 x {number.name} / {base_text}"
    basis = Basis(**{**vars(number.basis), "reference": base_text})
    if reason:
        return Measurement.undefined(name, "%", text, reason, basis)
    scale, uncertain = 100.0 / base, None
    if number.uncertainty is not None:
        own = number.uncertainty
        budget = [Contribution(number.name, "A", scale * own.standard, own.dof)]
        width = None if own.half_width is None else scale * own.half_width
        if base_number is not None and base_number.uncertainty is not None:
            of_base = base_number.uncertainty
            share = scale * number.value / base
            budget.append(Contribution(base_number.name, "A", share * of_base.standard, of_base.dof))
            width = None if width is None else math.hypot(width, share * of_base.expanded)
        uncertain = combined(budget, " and ".join(each.name for each in budget), half_width=width)
    return Measurement(name, scale * number.value, "%", text, basis, uncertain)


def _scatter(
    samples: NDArray[np.float64],
    whole: Ripple,
    rows: NDArray[np.int64],
    repeated: str = "electrical periods",
    step: float = 0.0,
    *,
    percentiles: bool = True,
) -> _Scatter | None:
    """Return the scatter of the numbers of whole periods; None where there are too few."""
    periods = len(rows) - 1
    if periods < _FEWEST_PERIODS or np.min(np.diff(rows)) < 1:
        return None
    begin, within, counts = rows[:-1], samples[: rows[-1]], np.diff(rows)
    means = np.add.reduceat(within, begin) / counts
    square = np.square(within - whole.mean)
    squares = np.add.reduceat(square, begin) / counts
    largest, least = np.maximum.reduceat(within, begin), np.minimum.reduceat(within, begin)
    rms = math.sqrt(float(np.average(squares, weights=counts)))
    # edges that repeat leave no deviations, and a slope that falls beside its place no second differences
    tail = min(tail_index(_deviations(within, begin, counts)), tail_index(np.diff(within, 2)))
    return _Scatter(
        periods=periods,
        repeated=repeated,
        mean=at_lowest_frequencies(within, error_of_series(means), periods),
        rms=error_of_root(squares, rms, at_lowest_frequencies(square, error_of_series(squares), periods)),
        percentile_range=_percentile_scatter(within, begin, counts)
        if percentiles
        else MeanError(math.nan, math.nan),
        # what makes both extremes larger together scatters as their difference does
        peak_to_peak=max(
            math.hypot(scatter_of_largest(largest, tail), scatter_of_largest(-least, tail)),
            scatter_of_largest(largest - least, tail),
        ),
        mean_peak_to_peak=float(np.mean(largest - least)),
        # the record ends within a period: what that part moves is no scatter, but it is not known either
        incomplete_mean=float(np.average(means, weights=counts)) - whole.mean,
        incomplete_rms=rms - whole.rms,
        steps=_repeated_steps(within, rows, step) if percentiles and step > 0.0 else None,
    )


def _deviations(samples: NDArray[np.float64], begin: NDArray[np.int64], counts: NDArray[np.int64]) -> Floats:
    """Return deviations of samples from the mean of all periods at the same place in them; of a long record,
    those of its first periods."""
    taken = min(len(begin), max(_FEWEST_PERIODS, _SAMPLES_OF_TAIL // int(np.max(counts)) + 1))
    length = int(np.min(counts))
    rows = begin[:taken, np.newaxis] + np.arange(length)
    table = samples[np.minimum(rows, len(samples) - 1)]
    return np.asarray(table - np.mean(table, axis=0)).ravel()


def _percentile_scatter(
    samples: NDArray[np.float64], begin: NDArray[np.int64], counts: NDArray[np.int64]
) -> MeanError:
    """Return the standard uncertainty of the percentile range, by what each period contributes to it.

    A percentile moves by the share of samples beyond it, more than expected, over the density there (Bahadur,
    Ann. Math. Statist. 37 (1966)); the density is that between percentiles a little to either side. Where
    neighbouring periods are correlated, how the ranges of parts of the record scatter is added. What it moves
    by from sample to sample is a series as the samples are, with noise that is too slow for the record.
    """
    at = (_LOW - _NEAR, _LOW, _LOW + _NEAR, _HIGH - _NEAR, _HIGH, _HIGH + _NEAR)
    below, low, above_low, below_high, high, above = np.percentile(samples, at)
    per_share = 100.0 / (2.0 * _NEAR)
    is_low, is_high = samples < low, samples > high
    moved = per_share * ((above_low - below) * is_low + (above - below_high) * is_high)
    by_periods = error_of_series(np.add.reduceat(moved, begin) / counts)
    linear = at_lowest_frequencies(moved, by_periods, len(begin))
    of_few = max(_of_few(is_low, begin), _of_few(is_high, begin))
    linear = MeanError(of_few * linear.standard, linear.dof)
    if len(begin) < _CORRELATED * (linear.dof + 1.0) or len(begin) < 2 * _PARTS:
        return linear
    # few stretches make the tail, and with it the density there: those of parts say how much it varies
    parts = np.array([percentile_range(samples[rows]) for rows in _parts(begin, len(samples))])
    of_parts = _WHOLE_OVER_PARTS * float(np.std(parts, ddof=1)) / math.sqrt(_PARTS)
    return MeanError(math.hypot(linear.standard, of_parts), _PARTS - 1.0)


def _of_few(beyond: NDArray[np.bool_], begin: NDArray[np.int64]) -> float:
    """Return by how much more a percentile scatters where the samples beyond it are of few of the periods.

    Then the density there is that of these few. They count as the n = (sum s)^2 / sum s^2 that their shares s
    make; of periods alike it is about half of them.
    """
    shares = np.add.reduceat(beyond, begin, dtype=np.float64)
    squares = float(np.sum(shares**2))
    if not squares > 0.0:
        return 1.0
    concentrated = squares / float(np.sum(shares)) ** 2 - 2.0 / len(begin)
    return math.sqrt(1.0 + 2.0 * max(0.0, concentrated))


def _parts(begin: NDArray[np.int64], count: int) -> Iterator[slice]:
    """Return the rows of equally many whole periods each."""
    edges = [int(each[0]) for each in np.array_split(begin, _PARTS)]
    return (slice(first, last) for first, last in itertools.pairwise([*edges, count]))
