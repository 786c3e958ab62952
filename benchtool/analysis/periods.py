"""Where the electrical periods of a record are: from the rotor angle, or from the signal itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy import fft
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.quantisation.resolution import resolution, step_of_counts, step_of_even_counts
from benchtool.analysis.validity import require_signal, standing
from benchtool.errors import AnalysisError

_FEWEST_PERIODS = 2
_LARGEST_SPEED_CHANGE = 0.1
_LARGEST_CHANGE = 0.1  # of frequency and amplitude of a tone, between parts of the record
_MOST_PARTS, _PERIODS_PER_PART = 4, 2
_LEAST_SHARE = 0.1
_SEARCH = 0.3  # of the frequency, to either side, where a part of the record has its tone
_CLEARLY = 4.0  # standard uncertainties by the rest of the signal
_SINE_FIT_STEPS = 8  # one to find amplitude and phase, then quadratic convergence
_SINE_FIT_ENOUGH = 1e-9  # rad over half the record
_NEWTON_STEPS = 6  # quadratic convergence from within 10 %: 1e-1, 1e-2, 1e-4, 1e-8, 1e-16, one to spare
_NEWTON_ENOUGH = 1e-6  # of a sample: the next step is below rounding
_ON_A_ROW = 1e-6  # of a sample: a mark that is so little behind a row begins with it
_REPETITIONS, _MARGIN = 12, 2  # with a convergence of some hundredth each
_BACKWARDS = 0.02  # of the record: a rotor that runs back for that long has turned around
_PARTS_OF_THE_WAY = 50
_MOST_PLACES, _FEWEST_PLACES, _FEWEST_REPEATED = 64, 8, 8  # places in a period, and periods
_BY_CHANCE, _OF_QUADRATIC = 1e-6, 3
_OF_STEPS = 1.0  # rms of what repeats, over the steps of an encoder: they repeat with 0.29 of one
_REFITS = 2  # the first leaves a share of one over the periods
_DIGITS = 9  # of an angle, above its rounding
_MOST_LEVELS = 1 << 16  # samples whose levels are looked at
_CHUNK = 1 << 13  # samples at a time: in the cache, and too few for BLAS to start threads


@dataclass(frozen=True)
class PhaseTrack:
    """Electrical phase as a smooth function of the sample number.

    `phase` gives rad over sample numbers 0 to `samples` - 1, increasing; as a low-order polynomial it follows
    a drift of the speed and nothing faster, so that oscillations within a period stay in the signal, where a
    spectrum shows them. Where the speed swings, `departure`, rad at sample numbers, is added;
    `follows_signal` tells that this is the phase of the signal's own fundamental, which it tells up to the
    sample number `told_to`. `source` says what it was made from, `residual_rad` is the rms deviation of a
    measured angle from the polynomial, electrical, `measured_rad` that angle itself, shape (samples,),
    without jumps; None where the track was not made from an angle. `resolution_rad` is the electrical step in
    which it counts, 0 where it does not, and `pole_pairs` the electrical periods in a revolution of it.
    """

    phase: Polynomial
    samples: int
    source: str
    residual_rad: float | None = None
    measured_rad: NDArray[np.float64] | None = field(default=None, repr=False, compare=False)
    departure: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = field(
        default=None, repr=False, compare=False
    )
    resolution_rad: float = 0.0
    pole_pairs: int = 1
    follows_signal: bool = False
    told_to: float = math.inf

    def at(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the phase, rad, at fractional sample numbers, shape (m,); beyond the record the departure is
        that at its end, because a curve through it may go anywhere."""
        smooth = np.asarray(self.phase(numbers), dtype=np.float64)
        if self.departure is None:
            return smooth
        return smooth + self.departure(np.clip(numbers, 0.0, self.samples - 1.0))

    def turns_from(self, row: int) -> NDArray[np.float64]:
        """Return the electrical periods from a row to every sample, shape (samples,), negative before it."""
        phase = self.at(np.arange(self.samples, dtype=np.float64))
        return np.asarray((phase - self.at(np.array([float(row)]))) / (2.0 * np.pi))

    @property
    def periods(self) -> float:
        """Electrical periods between the first and the last sample."""
        begin, end = self.at(np.array([0.0, self.samples - 1.0]))
        return float(end - begin) / (2 * np.pi)

    def sample_numbers(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fractional sample numbers, shape (m,), at which the track has these phases (Newton's
        method).

        With a departure, between rows straight lines are near enough: it is slow beside the phase itself.
        """
        if self.departure is None:
            return self._of_polynomial(phase)
        rows = self._rows_around(float(np.min(phase)), float(np.max(phase)))
        # where rows are missing, or the angle is held, a curve through it may turn back for a moment
        risen = np.maximum.accumulate(self.at(rows))
        first = np.diff(risen, prepend=-np.inf) > 0.0
        return np.interp(phase, risen[first], rows[first])

    def _rows_around(self, least_rad: float, greatest_rad: float) -> NDArray[np.float64]:
        """Return the sample numbers between which the track has these phases, shape (m,).

        They begin where the polynomial has them, less what the track departs from it there, and reach out
        until they hold both.
        """
        ends = np.array([least_rad, greatest_rad])
        places = self._of_polynomial(ends)
        for _ in range(_REPETITIONS):
            places = self._of_polynomial(ends - (self.at(places) - self.phase(places)))
        first, last = math.floor(places[0]) - _MARGIN, math.ceil(places[1]) + _MARGIN
        reach = _MARGIN
        while self.at(np.array([first, last], dtype=np.float64))[0] > least_rad:
            first, reach = first - reach, 2 * reach
        while self.at(np.array([first, last], dtype=np.float64))[1] < greatest_rad:
            last, reach = last + reach, 2 * reach
        return np.arange(first, last + 1, dtype=np.float64)

    @cached_property
    def _slope(self) -> Polynomial:
        """The slope of the polynomial, rad per sample."""
        return self.phase.deriv()

    def _of_polynomial(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        begin, end = float(self.phase(0)), float(self.phase(self.samples - 1))
        numbers = (phase - begin) * ((self.samples - 1) / (end - begin))
        for start in range(0, len(phase), _CHUNK):
            chunk = slice(start, start + _CHUNK)
            for _ in range(_NEWTON_STEPS):
                step = (self.phase(numbers[chunk]) - phase[chunk]) / self._slope(numbers[chunk])
                numbers[chunk] -= step
                if np.max(np.abs(step)) < _NEWTON_ENOUGH:
                    break
        return numbers

    def period_marks(self) -> NDArray[np.float64]:
        """Return the sample numbers at which whole periods begin, the first at 0, and that at which the last
        ends whose phase is told, shape (n + 1,)."""
        begin = float(self.at(np.zeros(1))[0])
        marks = self.sample_numbers(begin + 2 * np.pi * np.arange(1.0, int(self.periods) + 1.0))
        # a phase that turns back for a moment may have that of the begin again later
        return np.append(0.0, marks[(marks > 0.0) & (marks <= self.told_to)])

    def rows_as_far(self, marks: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return in how many rows each period between marks, shape (n + 1,), turns as far as the record does
        behind the last mark, and at last the rows behind that, shape (n + 1,); None where the phase at the
        end of the record is not told, or nothing turns meanwhile. That is more than a period where one ends
        behind the last row, with the time that this stands for."""
        if self.told_to < self.samples - 1 or len(marks) < 2:
            return None
        begin, end = self.at(np.array([0.0, float(self.samples)]))
        unmarked = int((end - begin) / (2 * np.pi)) - int(self.periods)
        behind = math.fmod(float(end - begin), 2 * np.pi) + 2 * np.pi * unmarked
        turned = begin + 2 * np.pi * np.arange(len(marks) - 1.0) + behind
        reached = self.sample_numbers(np.append(turned, end - behind))
        rows = np.append(reached[:-1] - marks[:-1], self.samples - reached[-1])
        return rows if np.min(rows) > 0.0 else None

    def period_rows(self) -> NDArray[np.int64]:
        """Return the rows that begin whole periods, the first at row 0, and the row after the last, shape (n
        + 1,)."""
        return rows_of_marks(self.period_marks())


def rows_of_marks(marks: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the first rows at or behind sample numbers, shape (n,)."""
    return np.ceil(marks - _ON_A_ROW).astype(np.int64)


def track_angle(theta_m: NDArray[np.float64], pole_pairs: int, name: str = "theta_m") -> PhaseTrack:
    """Return the track of the measured rotor angle, rad mechanical, shape (n,), wrapped or not, of either
    direction; `name` stands in the messages.

    Quadratic least-squares fit to `pole_pairs * theta_m`: mean speed and mean acceleration, without what it
    does in every electrical period alike, which pulls at the fit where the periods are not whole.

    Raises:
        AnalysisError: fewer than two periods, not finite, standstill, or the speed changes by
            more than 10 % within the record, or its direction; of an angle that has one value for a while,
            that it does.
    """
    require_signal(theta_m, name, "rad")
    try:
        return _track_moving(theta_m, pole_pairs, name)
    except AnalysisError:
        if held := standing(theta_m, "rad"):
            raise AnalysisError(
                f"'{name}': {held}, or the rotor did: choose a window in which it turns"
            ) from None
        raise


def _track_moving(theta_m: NDArray[np.float64], pole_pairs: int, name: str) -> PhaseTrack:
    """Return the track of an angle that changes.

    Raises:
        AnalysisError: as `track_angle`.
    """
    theta_e = _unwrap(theta_m)
    theta_e *= pole_pairs if theta_e[-1] >= theta_e[0] else -pole_pairs
    _require_periods(float(np.ptp(theta_e)), name)
    _require_direction(theta_e, name)
    _require_periods(float(theta_e[-1] - theta_e[0]), name)
    step_rad = (
        step_of_counts(theta_e, pole_pairs * _resolution_rad(theta_m))
        or step_of_counts(theta_e, pole_pairs * _digit_rad(theta_m))
        or pole_pairs * step_of_even_counts(theta_e / pole_pairs)
    )
    phase, residual_rad = _fit_quadratic(theta_e)
    for _ in range(_REFITS):
        repeated_rad = repeated_in_periods(theta_e, phase, step_rad)
        if not np.any(repeated_rad):
            break
        phase, left_rad = _fit_quadratic(theta_e - repeated_rad)
        residual_rad = math.hypot(left_rad, float(np.std(repeated_rad)))
    speed = phase.deriv()
    mean_speed = float(theta_e[-1] - theta_e[0]) / (len(theta_e) - 1)
    change = abs(float(speed(len(theta_e) - 1) - speed(0))) / mean_speed
    if change > _LARGEST_SPEED_CHANGE:
        raise AnalysisError(
            f"the speed changes by {100 * change:.0f} % within the window, at most "
            f"{100 * _LARGEST_SPEED_CHANGE:.0f} % is allowed: choose a window in steady state"
        )
    source = f"quadratic fit to {pole_pairs} x {name}"
    return PhaseTrack(
        phase, len(theta_e), source, residual_rad, theta_e, resolution_rad=step_rad, pole_pairs=pole_pairs
    )


def _resolution_rad(theta_m: NDArray[np.float64]) -> float:
    """Return the resolution of an angle, rad, shape (n,), above the rounding by which it differs from turn to
    turn where it was wrapped by a computation."""
    few = np.sort(theta_m[:: max(1, len(theta_m) // _MOST_LEVELS)])
    return resolution(few[np.diff(few, prepend=-np.inf) > 10.0**-_DIGITS])


def _digit_rad(theta_m: NDArray[np.float64]) -> float:
    """Return the resolution of an angle, rad, shape (n,), that has so many digits within each turn: of these
    no whole number is a turn, and without its jumps the angle has other ones in each."""
    few = theta_m[:: max(1, len(theta_m) // _CHUNK)]
    return resolution(np.asarray(np.round(np.mod(few, 2 * np.pi), _DIGITS), dtype=np.float64))


def repeated_in_periods(
    theta_e: NDArray[np.float64], phase: Polynomial, resolution_rad: float
) -> NDArray[np.float64]:
    """Return what an electrical angle, rad, shape (n,), departs from a smooth phase in every period alike,
    shape (n,): means over the periods at up to 64 places in them; zero where the periods are few, or where
    the means differ by no more than noise does (analysis of variance) or than the steps in which it counts.
    """
    smooth = np.asarray(phase(np.arange(len(theta_e), dtype=np.float64)))
    periods = float(smooth[-1] - smooth[0]) / (2 * np.pi)
    places = min(_MOST_PLACES, int(len(theta_e) / max(periods, 1.0)))
    if periods < _FEWEST_REPEATED or places < _FEWEST_PLACES:
        return np.zeros(len(theta_e))
    place = np.floor(smooth * (places / (2 * np.pi))).astype(np.int64) % places
    count = np.maximum(1, np.bincount(place, minlength=places))
    departure = theta_e - smooth
    means = np.bincount(place, weights=departure, minlength=places) / count
    repeated = np.asarray((means - np.mean(means))[place])
    free = len(departure) - places - _OF_QUADRATIC
    among, left = float(repeated @ repeated), float(np.sum((departure - repeated) ** 2))
    ratio = among / (places - 1) / (left / free) if left > 0.0 else math.inf
    by_steps = among < (_OF_STEPS * resolution_rad) ** 2 * len(departure)
    if by_steps or not fisher_above(places - 1, free, ratio) < _BY_CHANCE:
        return np.zeros(len(theta_e))
    return repeated


def track_tone(samples: NDArray[np.float64], name: str = "signal") -> PhaseTrack:
    """Return track of the largest sinusoid in uniformly sampled values, shape (n,), at constant frequency.

    The largest bin under a Hann window begins a four-parameter sine fit (IEEE Std 1057-2017), weighted
    with the same window so that harmonics do not pull at it; for records without an angle channel. A drift
    of the speed is not followed and shows as sidebands.

    Raises:
        AnalysisError: too short, not finite, constant, fewer than two periods or samples for each, or
            frequency or amplitude differs by more than 10 % between quarters of the record (or fewer
            parts, of at least two periods).
    """
    require_signal(samples, name)
    count = len(samples)
    omega, in_phase, quadrature = _sine_fit(samples)
    _require_periods(omega * count, name)
    if omega > np.pi:
        raise AnalysisError(
            f"no sinusoid below half the sample rate fits '{name}': record a steady state, at a higher rate"
        )
    _require_steady(samples, omega, float(np.hypot(in_phase, quadrature)), name)
    # in_phase cos x + quadrature sin x = A cos(x - atan2(quadrature, in_phase))
    begin = -omega * count / 2 - float(np.arctan2(quadrature, in_phase))
    return PhaseTrack(
        Polynomial([begin, omega]), count, f"the largest sinusoid of {name}, constant frequency"
    )


def _sine_fit(samples: NDArray[np.float64], about: float = 0.0) -> tuple[float, float, float]:
    """Return the frequency, rad per sample, and amplitudes of cosine and sine of the largest sinusoid.

    Phase zero is in the middle of the record. Where a frequency `about` is given, it is sought near that.
    """
    count = len(samples)
    window = np.hanning(count + 1)[:count]
    bins = np.abs(fft.rfft((samples - np.mean(samples)) * window))
    first, last = 0, len(bins)
    if about > 0.0:
        centre = about * count / (2 * np.pi)
        reach = max(1.0, _SEARCH * centre)
        first, last = min(max(1, int(centre - reach)), len(bins) - 1), int(centre + reach) + 2
    omega = 2 * np.pi * (first + int(np.argmax(bins[first:last]))) / count
    in_phase, quadrature = 0.0, 0.0
    for attempt in range(_SINE_FIT_STEPS):
        in_phase, quadrature, step = _sine_fit_step(samples, window, omega, in_phase, quadrature)
        omega += step
        if attempt > 0 and abs(step) * count / 2 < _SINE_FIT_ENOUGH:
            break
    return omega, in_phase, quadrature


def _require_steady(samples: NDArray[np.float64], omega: float, whole: float, name: str) -> None:
    """Refuse a tone whose frequency or amplitude differs between parts of the record by more than 10 %.

    The rest of the signal, taken as noise, is allowed for. With less than a tenth of the power in the tone,
    of amplitude `whole`, parts are not compared.
    """
    if not 0.5 * whole**2 > _LEAST_SHARE * float(np.var(samples)):
        return
    parts = min(_MOST_PARTS, int(omega * len(samples) / (2 * np.pi)) // _PERIODS_PER_PART)
    if parts < 2:
        return
    found = []
    for part in np.array_split(samples, parts):
        of_part, in_phase, quadrature = _sine_fit(part, omega)
        found.append((of_part, float(np.hypot(in_phase, quadrature)), float(np.std(part))))
    frequency, amplitude, deviation = np.array(found).T
    count, middle = len(samples) / parts, max(float(np.mean(amplitude)), 1e-300)
    rest = math.sqrt(max(0.0, float(np.mean(deviation**2)) - 0.5 * float(np.mean(amplitude**2))))
    # of a fit with a Hann window squared, whose noise bandwidth is 35/18 of a bin; frequency: Cramér-Rao
    of_amplitude = rest * math.sqrt(2 * 35 / 18 / count)
    of_frequency = math.sqrt(24 * 35 / 18 / count) * rest / (middle * count)
    if not float(np.ptp(amplitude)) / middle <= _LARGEST_CHANGE + _CLEARLY * math.sqrt(2.0) * (
        of_amplitude / middle
    ):
        _require_steady_parts(deviation, name)
    # of a steady rise the parts' means span less than its ends do
    rise = parts / (parts - 1)
    for what, change, standard in (
        ("amplitude", float(np.ptp(amplitude)) / middle, of_amplitude / middle),
        ("frequency", rise * float(np.ptp(frequency)) / omega, rise * of_frequency / omega),
    ):
        if not change <= _LARGEST_CHANGE + _CLEARLY * math.sqrt(2.0) * standard:
            raise AnalysisError(
                f"the {what} of the largest sinusoid of '{name}' changes by {100 * change:.0f} % within the "
                f"window, at most {100 * _LARGEST_CHANGE:.0f} % is allowed: choose a window in steady state"
            )


def _require_steady_parts(deviation: NDArray[np.float64], name: str) -> None:
    """Refuse a tone of which a sinusoid has less in one part of the record than in others, where each part
    has the same rms `deviation`, shape (parts,): it turns slower or faster within that, as in a start."""
    change = float(np.ptp(deviation)) / float(np.mean(deviation))
    if change <= _LARGEST_CHANGE:
        raise AnalysisError(
            f"the frequency of the largest sinusoid of '{name}' changes within parts of the window, of which "
            f"each has the same rms within {100 * change:.2g} %: the machine starts, stops or changes its "
            f"speed; choose a window in steady state"
        )


def _sine_fit_step(
    samples: NDArray[np.float64],
    weights: NDArray[np.float64],
    omega: float,
    in_phase: float,
    quadrature: float,
) -> tuple[float, float, float]:
    """Return amplitudes of cosine and sine, and the step of `omega`, rad per sample, of one linearised fit.

    Samples are numbered from the middle of the record, where the phase depends least on the frequency; the
    slope is scaled to the record's length, so that the normal equations are well conditioned.
    """
    half = len(samples) / 2
    normal, right = np.zeros((4, 4)), np.zeros(4)
    for start in range(0, len(samples), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        number = np.arange(start, min(start + _CHUNK, len(samples))) - half
        cosine, sine = np.cos(omega * number), np.sin(omega * number)
        slope = number / half * (quadrature * cosine - in_phase * sine)
        columns = np.stack([cosine, sine, np.ones(len(number)), slope]) * weights[chunk]
        normal += columns @ columns.T
        right += columns @ (samples[chunk] * weights[chunk])
    # in the first step the slope is zero and with it the step: least squares of least norm
    solution = np.linalg.lstsq(normal, right, rcond=None)[0]
    return float(solution[0]), float(solution[1]), float(solution[3]) / half


def _unwrap(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle, rad, without its jumps of whole turns; a copy."""
    unwrapped = np.empty(len(angle))
    turns = 0.0
    for start in range(0, len(angle), _CHUNK):
        part = angle[start : start + _CHUNK]
        counted = np.diff(part, prepend=angle[max(0, start - 1)])
        counted /= 2 * np.pi
        np.cumsum(np.round(counted, out=counted), out=counted)
        counted += turns
        unwrapped[start : start + _CHUNK] = part - 2 * np.pi * counted
        turns = counted[-1]
    return unwrapped


def _fit_quadratic(values: NDArray[np.float64]) -> tuple[Polynomial, float]:
    """Return least-squares quadratic over sample numbers, shape (n,), n > 2, and the rms deviation from it.

    The columns 1, x and x^2 - mean(x^2), x from -1 to 1, are orthogonal: each coefficient is one sum.
    """
    count = len(values)
    mean_x2 = (count + 1) / (3 * (count - 1))
    sum_curve2 = count * (count + 1) * (3 * count**2 - 7) / (15 * (count - 1) ** 3) - count * mean_x2**2
    # less the chord, so that a long record does not drown the small coefficients in rounding
    offset, rise = 0.5 * (values[0] + values[-1]), 0.5 * (values[-1] - values[0])
    sums = np.zeros(3)
    for chunk, x in _abscissae(count):
        rest = values[chunk] - (offset + rise * x)
        sums += np.sum(rest), rest @ x, rest @ (x * x - mean_x2)
    mean, slope, bend = sums / (count, count * mean_x2, sum_curve2)
    coefficients = offset + mean - bend * mean_x2, rise + slope, bend
    squares = 0.0
    for chunk, x in _abscissae(count):
        rest = values[chunk] - (coefficients[0] + x * (coefficients[1] + x * bend))
        squares += rest @ rest
    return Polynomial(coefficients, domain=[0, count - 1], window=[-1, 1]), float(np.sqrt(squares / count))


def _abscissae(count: int) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    """Yield the pieces of -1 to 1 in `count` steps."""
    for start in range(0, count, _CHUNK):
        end = min(start + _CHUNK, count)
        yield slice(start, end), np.arange(start, end, dtype=np.float64) * (2.0 / (count - 1)) - 1.0


def _require_direction(angle: NDArray[np.float64], name: str) -> None:
    """Refuse an angle, rad, that between fiftieths of the record goes back by more than a fiftieth of a turn.

    Within them noise and the steps of an encoder may go back and forth.
    """
    marks = angle[np.linspace(0, len(angle) - 1, min(len(angle), _PARTS_OF_THE_WAY + 1)).astype(np.int64)]
    back = float(np.max(np.maximum.accumulate(marks) - marks))
    if back > max(_BACKWARDS * 2 * np.pi, _BACKWARDS * float(marks[-1] - marks[0])):
        raise AnalysisError(
            f"'{name}' turns back by {back / (2 * np.pi):.3g} electrical periods within the window, one "
            f"direction is needed: choose a window in steady state"
        )


def _require_periods(phase: float, name: str) -> None:
    if not phase >= 2 * np.pi * _FEWEST_PERIODS:
        raise AnalysisError(
            f"'{name}' covers {max(phase, 0.0) / (2 * np.pi):.2f} electrical periods, at least "
            f"{_FEWEST_PERIODS} are needed: record a longer window"
        )
