"""Phase of a measured angle from the first to the last row of a window, with its budget."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import FIRST_ROW, rows_of
from benchtool.analysis.lines.course import FEWEST_TURNS, Repeated, change_over_record, repeated_in_turns
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.steady_departure import steady_departure
from benchtool.analysis.phase.turned_phase import Turned
from benchtool.analysis.phase.wander import Wander, beyond_noise
from benchtool.analysis.quantisation.counted_line import line_through_counts, of_slow_beats
from benchtool.analysis.quantisation.resolution import largest_even_step
from benchtool.analysis.statistics.scatter import error_of_series
from benchtool.analysis.uncertainty import Contribution

_LESS_THAN_A_COUNT = 1.0 - 1e-6
_COMPUTED_RAD = 1e-7  # noise of an angle that no sensor has
_BLOCKS, _FEWEST_IN_BLOCK = 128, 3
_SLOPE = 2.6  # most that two thirds of a turn of a sinusoid add over the record, over its rms: 1.8 sqrt(2)
_FEWEST_AT_END = 12  # samples of an angle for a cubic
_PASSES = 2
_BEYOND = 3.0  # standard uncertainties of the angle
_PLACES, _PLACES_SEEN = 64, 16  # in a period
_OF_REPEATED = "what is the same in every turn, by what differs from turn to turn"
_OF_SIGNAL = "departure of the signal"
_WITHIN = "what the angle does within periods"
_OF_EITHER = "what may be the rotor's or an error of its sensor"
_HALF = 0.5  # as likely the rotor's as an error of its sensor: a standard deviation away from both

Floats = NDArray[np.float64]


def turned_by_angle(track: PhaseTrack, seen: Wander, by_tone: Turned | None = None) -> Turned:
    """Return the phase of the measured angle of a track, of which the signal departs by what was `seen`.

    Counts tell a speed that is nearly a simple ratio of them to the rows less well than others: the same few
    places of a count pass all over the record. Where the signal's own phase, `by_tone`, agrees with an angle
    in counts, it counts by its variance.

    Raises:
        ValueError: the track has no measured angle.
    """
    if track.measured_rad is None:
        raise ValueError("a track without a measured angle: give the phase of the tone")
    smooth_rad = np.asarray(track.phase(np.arange(track.samples, dtype=np.float64)))
    if track.departure is None and (counted := _of_counts(track, track.measured_rad)) is not None:
        line_rad = np.linspace(0.0, counted.phase_rad, track.samples)
        departed = _with_departure(counted, track, seen, line_rad - smooth_rad)
        return _with_tone(counted, by_tone) if departed is counted else departed
    repeated = _repeated(track, smooth_rad, track.measured_rad)
    repeated_rad = repeated.values
    measured_rad = track.measured_rad - repeated_rad
    within_rad = _within_periods(track, smooth_rad, repeated_rad)
    may_be_rad = float(repeated_rad[-1] - repeated_rad[0]) - within_rad
    if track.departure is not None:
        found = _by_ends(track, measured_rad, seen)
    else:
        found = _by_course(track, smooth_rad, measured_rad)
        if not _shows_turns(track):  # nothing is seen to repeat: all of the course may be the sensor's
            may_be_rad += float(smooth_rad[-1] - smooth_rad[0]) - found.phase_rad
        elif not track.resolution_rad > 0.0:
            # slow noise is more than it seems in few rows: ends are better of a computed angle alone
            noise = _by_ends(track, measured_rad, seen).budget[0]
            if max(noise.standard, _between_rows_rad(track.measured_rad)) < _COMPUTED_RAD:
                found = Turned(float(measured_rad[-1] - measured_rad[0]), (noise,), noise.name)
    turned = _with_half(found, may_be_rad, may_be_rad)
    along_rad = smooth_rad
    if track.departure is not None:
        along_rad = track.at(np.arange(track.samples, dtype=np.float64))
    result = _with_departure(turned, track, seen, measured_rad - along_rad)
    if result is turned and track.resolution_rad > 0.0 and by_tone is not None:
        unseen = Contribution(_WITHIN, "B", math.sqrt(2.0) * _within_rad(track, measured_rad - smooth_rad))
        result = result.with_other(replace(by_tone, budget=(*by_tone.budget, unseen)))
    elif result is turned and by_tone is not None and track.departure is None and _shows_turns(track):
        beside = beyond_noise(_beside_angle(track, seen, measured_rad - smooth_rad), seen.amplitude)
        result = turned.with_either(by_tone, beside.excess_rad)
    result = _with_half(result, within_rad, may_be_rad)
    # as likely all of it is in the phase as none
    of_repeated = Contribution(_OF_REPEATED, "A", math.sqrt(0.5) * repeated.standard)
    return replace(result, budget=(*result.budget, of_repeated))


def _between_rows_rad(measured_rad: Floats) -> float:
    """Return the noise of an angle, rms, by how it is thrown back from row to row, all over the record.

    Neighbouring second differences have a covariance of -4 times the variance of white noise. A jump, as of
    an angle that is set again in each revolution, goes there and not on; that of a speed goes on.
    """
    bends = np.diff(measured_rad, 2)
    return 0.5 * math.sqrt(max(0.0, -float(np.mean(bends[1:] * bends[:-1]))))


def _with_half(turned: Turned, more_rad: float, may_be_rad: float) -> Turned:
    """Return it with half of what more may be the rotor's or an error of its sensor: all of it is, with
    `may_be_rad`, of which a half is in it, or nothing."""
    half_rad = _HALF * more_rad
    before_rad = sum(each.standard for each in turned.budget if each.name == _OF_EITHER)
    others = [each for each in turned.budget if each.name != _OF_EITHER]
    doubt = Contribution(_OF_EITHER, "B", abs(math.copysign(before_rad, may_be_rad) + half_rad))
    return Turned(turned.phase_rad + half_rad, (*others, doubt), turned.source)


def _within_periods(track: PhaseTrack, smooth_rad: Floats, repeated_rad: Floats) -> float:
    """Return how far what an angle repeats, shape (n,), gets over the record beside its own means over
    periods, which is all that the phases of periods of the signal show of it."""
    from scipy import ndimage

    turns = (smooth_rad - smooth_rad[0]) / (2.0 * math.pi)
    if turns[-1] < track.pole_pairs or not np.any(repeated_rad):
        return 0.0
    places = np.linspace(0.0, track.pole_pairs, track.pole_pairs * _PLACES, endpoint=False)
    of_revolution = np.interp(places, turns, repeated_rad)
    within_rad = of_revolution - ndimage.uniform_filter1d(of_revolution, _PLACES, mode="wrap")
    begin, end = np.interp(turns[[0, -1]] % track.pole_pairs, places, within_rad, period=track.pole_pairs)
    return float(end - begin)


def _within_rad(track: PhaseTrack, left_rad: Floats) -> float:
    """Return how far, rms, an angle departs within periods from its means over these, which are all that the
    phases of periods of a signal show, beyond its steps: `left_rad`, shape (n,), is the angle about a steady
    rise."""
    from scipy import ndimage

    per_period = track.samples / track.periods
    fine, means = (
        ndimage.uniform_filter1d(left_rad, max(1, round(size)))
        for size in (per_period / _PLACES_SEEN, per_period)
    )
    return math.sqrt(max(0.0, float(np.var(fine - means)) - track.resolution_rad**2 / 12.0))


def _with_tone(turned: Turned, by_tone: Turned | None) -> Turned:
    return turned if by_tone is None else turned.with_other(by_tone)


def _with_departure(turned: Turned, track: PhaseTrack, seen: Wander, angle_rad: Floats) -> Turned:
    """Return the phase halfway to that of the signal where this departs from the angle steadily, by more than
    noise and the angle's own error explain: an encoder that slips, or a current whose phase moves.

    `angle_rad` is what the angle departs from the track that the signal was seen along, shape (n,).
    """
    beside_rad = _beside_angle(track, seen, angle_rad)
    found = steady_departure(beside_rad, seen.amplitude)
    half_rad = _HALF * track.periods * found.rise_rad
    # what the signal departs in the mean is no reason to overlook that it does so steadily
    of_angle_rad = math.hypot(*(each.standard for each in turned.budget if each.name != _OF_SIGNAL))
    if not _HALF * _BEYOND * of_angle_rad < abs(half_rad):
        return turned
    line = Contribution("steady departure of the signal from the angle", "B", abs(half_rad))
    # the noise of the signal is in what is right if the angle slips
    noise = Contribution("noise of that departure", "A", track.periods * found.standard_rad, found.dof)
    budget = (*turned.budget, line, noise)
    return Turned(turned.phase_rad + half_rad, budget, f"{turned.source}, and {line.name}")


def _beside_angle(track: PhaseTrack, seen: Wander, angle_rad: Floats) -> Floats:
    """Return the phase of the signal in each period beside that of the angle, which is `angle_rad`, shape
    (n,), beside the track."""
    periods = len(seen.phase_rad)
    edges = FIRST_ROW + rows_of(track, periods) / periods * np.arange(periods + 1)
    first = np.round(edges).astype(np.int64)
    along_rad = np.add.reduceat(angle_rad[: first[-1]], first[:-1]) / np.diff(first)
    return np.asarray(seen.phase_rad - along_rad)


def tells_its_turn(track: PhaseTrack) -> bool:
    """Return whether a measured angle tells how far it turned: over a whole revolution, an error of its
    sensor is in its course.

    Of a part of one, most of such an error is a change of speed. Where a speed that swings is followed it is
    seen from two revolutions on, by what each of them does alike.
    """
    return track.periods >= track.pole_pairs and (track.departure is None or _shows_turns(track))


def _shows_turns(track: PhaseTrack) -> bool:
    """Return whether there are revolutions enough to see what the angle repeats in each."""
    return track.periods >= FEWEST_TURNS * track.pole_pairs


def _of_counts(track: PhaseTrack, measured_rad: Floats) -> Turned | None:
    """Return the phase of an angle in counts that a constant speed explains; None where it does not."""
    step_rad = track.resolution_rad or track.pole_pairs * largest_even_step(measured_rad / track.pole_pairs)
    if not step_rad > 0.0:
        return None
    rows = np.arange(track.samples, dtype=np.float64)
    counted = line_through_counts(measured_rad, rows, _LESS_THAN_A_COUNT * step_rad)
    if counted is None:
        return None
    source = "slopes that the counts of the angle allow"
    # a speed that is not quite constant shows nowhere but where counts pass
    of_beats = _of_beats(track) if track.resolution_rad > 0.0 else 0.0
    standard = max(counted.standard * (track.samples - 1), of_beats)
    return Turned(counted.slope * (track.samples - 1), (Contribution(source, "B", standard),), source)


def _of_beats(track: PhaseTrack) -> float:
    per_row = 2.0 * math.pi * track.periods / (track.samples - 1) / track.resolution_rad
    return of_slow_beats(track.resolution_rad, per_row, track.samples, track.residual_rad or 0.0)


def _repeated(track: PhaseTrack, smooth_rad: Floats, measured_rad: Floats) -> Repeated:
    """Return what the angle does about the smooth phase in every revolution or period alike.

    It is the rotor's or an error of its sensor, such as that of a resolver: each is as likely, and half of it
    a standard deviation away from both. It tilts the smooth phase, by which turns are told: without that they
    are told once more.
    """
    place = np.linspace(-1.0, 1.0, track.samples)
    repeated_rad, tilt_rad, standard_rad = np.zeros(track.samples), 0.0, 0.0
    for _ in range(_PASSES):
        steady_rad = smooth_rad + tilt_rad * place
        turns, left_rad = (steady_rad - steady_rad[0]) / (2.0 * math.pi), measured_rad - steady_rad
        of_revolution = repeated_in_turns(left_rad, turns / track.pole_pairs)
        of_period = repeated_in_turns(left_rad - of_revolution.values, turns)
        repeated_rad = of_revolution.values + of_period.values
        standard_rad = math.hypot(of_revolution.standard, of_period.standard)
        tilt_rad = 3.0 * float(np.mean(place * (measured_rad - repeated_rad - smooth_rad)))
    return Repeated(repeated_rad, standard_rad)


def _by_course(track: PhaseTrack, smooth_rad: Floats, measured_rad: Floats) -> Turned:
    """Return the phase by the course of the angle about the steady rise of the track, its smooth phase.

    Of fewer than two revolutions that course may be an error of the sensor: then the slope of the rise errs
    too, which is the sum of (t - mean t) times deviation over the sum of (t - mean t)^2.
    """
    left_rad = measured_rad - smooth_rad
    parts = min(_BLOCKS, track.samples // _FEWEST_IN_BLOCK)
    # equally long, from the first row to the last: a row more or less is where the course is another
    last = track.samples - 1
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (left_rad[1:] + left_rad[:-1]))])
    edges = np.linspace(0.0, last, parts + 1)
    means = np.diff(np.interp(edges, np.arange(track.samples), sums)) * (parts / last)
    course = change_over_record(means)
    source = "course of the angle about a steady rise"
    budget = [Contribution(source, "A", course.standard, course.dof)]
    if not _shows_turns(track):
        place = (np.arange(parts) + 0.5) / parts - 0.5
        scatter = error_of_series(place * means)
        standard = _SLOPE * float(np.std(means))
        if math.isfinite(scatter.standard):
            standard = min(standard, scatter.standard * parts / float(place @ place))
        dof = max(1.0, scatter.dof) if math.isfinite(scatter.dof) else 1.0
        budget.append(Contribution("its slope, if it is that of the sensor", "A", standard, dof))
    if track.resolution_rad > 0.0:
        budget.append(Contribution("steps of the angle that beat with the rows", "B", _of_beats(track)))
    return Turned(float(smooth_rad[-1] - smooth_rad[0]) + course.size, tuple(budget), source)


def _by_ends(track: PhaseTrack, measured_rad: Floats, seen: Wander) -> Turned:
    """Return the phase by the measured angle at both ends, of which the signal departs by what was `seen`.

    At either end the angle's deviation from the smooth track by a parabola through an eighth of a period; a
    cubic in its place estimates the error of the parabola. Steps of the angle that pass there scatter about
    it, and are in its noise; what does not, as of steps that beat with the samples, is not.
    """
    size = max(_FEWEST_AT_END, round(track.samples / (8.0 * track.periods)))
    values, random, left_out, steps2 = [], [], [], []
    for rows in (slice(size), slice(track.samples - size, track.samples)):
        numbers = np.arange(track.samples, dtype=np.float64)[rows]
        left = measured_rad[rows] - np.asarray(track.phase(numbers))
        edge = numbers[0] if rows.start is None else numbers[-1]
        parabola, cubic = (Polynomial.fit(numbers, left, degree) for degree in (2, 3))
        values.append(float(parabola(edge) + track.phase(edge)))
        freedom = max(1, len(numbers) - 4)
        noise = math.sqrt(float(np.sum((left - cubic(numbers)) ** 2)) / freedom)
        # of the end of a parabola: nine times the variance of a mean
        random.append(3.0 * noise / math.sqrt(len(numbers)))
        left_out.append(float(cubic(edge) - parabola(edge)))
        steps2.append(max(0.0, track.resolution_rad**2 / 12.0 - noise**2))
    budget = (
        Contribution("noise of the angle at both ends", "A", math.hypot(*random), 2.0 * size - 8.0),
        Contribution("bend of the angle at both ends", "B", math.hypot(*left_out)),
        Contribution("resolution of the angle", "B", math.sqrt(sum(steps2))),
        # what the signal does not do with the angle may be an error of the angle, at each end another
        Contribution(_OF_SIGNAL, "B", math.sqrt(2.0) * seen.excess_rad),
    )
    return Turned(values[1] - values[0], budget, "noise, bend and resolution of the angle at both ends")
