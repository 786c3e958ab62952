"""Whether a line of a spectrum is a steady sinusoid, and what else it is where it is none.

The bins of a steady sinusoid under a Hann window have a known shape. Where they depart from it by more than
the noise around explains, amplitude or frequency change within the record, or another line is too near: then
simple courses of both, and further lines, are tried, and what none of them explains is refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchtool.analysis.lines.around_lines import MAIN_LOBE
from benchtool.analysis.lines.line_models import (
    Complexes,
    Fit,
    Floats,
    Integers,
    changing,
    fitted,
    hann_kernel,
    middle_bins,
    phasors_at,
    places,
    steady,
)
from benchtool.analysis.lines.line_pairs import pair_of

_TOGETHER = 12.0  # bins: lines nearer than that are fitted together
_BESIDE = MAIN_LOBE + 1  # bins of the fit on either side of its lines
_BY_CHANCE, _DOUBTED = 1e-4, 0.05  # of a steady line
_EXPLAINED, _FILLED = 0.05, 0.2  # of another model; of a steady line in a band of noise
_STANDS_OUT, _WIDEST = 5.0, 24  # of the noise; bins on either side of a line that changes
_MIRRORED, _ALIKE = 0.7, 2.0  # bins; a ratio of amplitudes
_MOST_MORE, _APART, _TELLS = 2, 1.0, 0.5  # further lines that are no maxima; bins
_MOST_CHANGE = 2.0  # of an amplitude, of which the mean is stated

NOT_STEADY = (
    "the line is wider than that of a steady sinusoid: its amplitude or frequency changes within the record, "
    "or another line, or noise in a narrow band, is beside it"
)
DECAYS = "the amplitude of the line changes within the record, from {:.3g} to {:.3g}"


@dataclass(frozen=True)
class Line:
    """A sinusoid at a place, in bins, and its peak amplitude, with standard uncertainties, nan where unknown.

    `noise` is the rms amplitude of noise in a bin there, `far` that further away. `reason` tells why place
    and amplitude are unknown, `of_mean` why the amplitude alone is, `unsure` why its uncertainty is. `width`
    are the bins on either side that belong to a line that changes. `is_one` tells that one line explains its
    bins, and two that beat do not.
    """

    place: float
    amplitude: float
    of_place: float
    of_amplitude: float
    noise: float
    far: float
    reason: str = ""
    of_mean: str = ""
    unsure: str = ""
    width: float = 0.0
    is_one: bool = False


def examined(bins: Complexes, count: int, line: Line, lines: Sequence[Line]) -> Line:
    """Return a line, one of `lines`, as what it turns out to be, in the bins of a record of `count` samples.

    Steady lines nearby are fitted together, with those further away taken out.
    """
    near = [each for each in lines if abs(each.place - line.place) <= _TOGETHER]
    near.sort(key=lambda each: abs(each.place - line.place))
    at = np.array([each.place for each in near])
    number = _numbers(len(bins), float(at.min()) - _BESIDE, float(at.max()) + _BESIDE)
    clean = _without(bins, count, number, near, lines)
    start = _started(clean, number, at, count)
    together = fitted(steady(number, count), start, clean, number, line.far)
    if together is not None and together.by_chance > _BY_CHANCE:
        found = replace(line, is_one=True) if len(near) == 1 else _of_steady(line, together)
        return found if together.by_chance > _DOUBTED else _doubted(found, number, count, clean)
    changed = _changing(bins, count, line, lines, number, clean)
    if changed is not None:
        return changed
    more = _with_more(together, number, count, clean, line)
    if more is not None:
        return replace(more, is_one=more.is_one and len(near) == 1)
    if len(near) == 1:
        pair = pair_of(clean, number, count, line.place, line.far)
        if pair.by_chance > _EXPLAINED and pair.of_amplitude < _TELLS * pair.amplitude:
            return replace(
                line,
                place=pair.place,
                amplitude=pair.amplitude,
                of_place=pair.of_place,
                of_amplitude=pair.of_amplitude,
            )
    if line.noise > line.far:  # a band of noise beside it
        filled = fitted(steady(number, count), start, clean, number, line.noise)
        if filled is not None and filled.by_chance > _FILLED:
            return line
    return replace(line, of_place=math.nan, of_amplitude=math.nan, reason=NOT_STEADY)


def _numbers(count: int, first: float, last: float) -> Integers:
    return np.arange(max(1, math.floor(first)), min(count, math.ceil(last) + 1), dtype=np.int64)


def _without(
    bins: Complexes, count: int, number: Integers, near: Sequence[Line], lines: Sequence[Line]
) -> Complexes:
    """Return bins of these numbers without the lines that are not near, and without all at negative
    frequencies."""
    at, place = number[:, np.newaxis], np.array([each.place for each in lines])
    own = phasors_at(bins, place, count)
    is_far = np.array([each not in near for each in lines])
    far = hann_kernel(at - place[is_far], count) @ own[is_far]
    return np.asarray(middle_bins(bins, number) - far - hann_kernel(at + place, count) @ np.conj(own))


def _started(clean: Complexes, number: Integers, at: Floats, count: int) -> Floats:
    """Return the unknowns of steady lines at these places, by linear least squares."""
    phasors = np.linalg.lstsq(hann_kernel(number[:, np.newaxis] - at, count), clean, rcond=None)[0]
    return np.stack([phasors.real, phasors.imag, at], axis=1).ravel()


def _of_steady(line: Line, fit: Fit) -> Line:
    """Return the first of the steady lines of a fit."""
    real, imaginary, place = (float(each) for each in fit.unknowns[:3])
    amplitude, scale = math.hypot(real, imaginary), math.sqrt(max(1.0, fit.excess))
    toward = np.array([real, imaginary]) / amplitude
    of_amplitude = math.sqrt(float(toward @ fit.covariance[:2, :2] @ toward))
    of_place = math.sqrt(float(fit.covariance[2, 2]))
    return replace(
        line, place=place, amplitude=amplitude, of_place=scale * of_place, of_amplitude=scale * of_amplitude
    )


def _largest_of(line: Line, fit: Fit) -> Line | None:
    """Return the largest of the steady lines of a fit that are in the main lobe of this one; None where
    another is as large."""
    unknowns, size = fit.unknowns.reshape(-1, 3), len(fit.unknowns) // 3
    amplitudes = np.where(
        np.abs(unknowns[:, 2] - line.place) < MAIN_LOBE, np.hypot(unknowns[:, 0], unknowns[:, 1]), 0.0
    )
    order = np.argsort(-amplitudes)
    found = _of_steady(line, _in_order(fit, [int(each) for each in order]))
    if size > 1 and found.amplitude - amplitudes[order[1]] < 2.0 * math.sqrt(2.0) * found.of_amplitude:
        return None
    return found


def _doubted(line: Line, number: Integers, count: int, clean: Complexes) -> Line:
    """Return a line that may well change, though noise alone leaves as much once in twenty records: with
    what it would be if it did as part of its uncertainty, where a course of one line is possible."""
    at = places(count)
    shape = np.stack([at.astype(np.complex128), 1j * at**2, (at**2).astype(np.complex128)])
    fit = fitted(changing(number, count, shape), _begun(clean, number, shape, at), clean, number, line.far)
    line = _or_pair(line, clean, number, count)
    return line if fit is None or fit.by_chance < _BY_CHANCE else _or(line, _of_course(line, fit, shape))


def _or(line: Line, other: Line) -> Line:
    """Return a line that may as well be another, with the difference as part of its uncertainty."""
    return replace(
        line,
        of_place=math.hypot(line.of_place, other.place - line.place),
        of_amplitude=math.hypot(line.of_amplitude, other.amplitude - line.amplitude),
    )


def _in_order(fit: Fit, order: Sequence[int]) -> Fit:
    """Return a fit of steady lines with these in another order."""
    index = (3 * np.asarray(order)[:, np.newaxis] + np.arange(3)).ravel()
    return replace(fit, unknowns=fit.unknowns[index], covariance=fit.covariance[np.ix_(index, index)])


def _changing(
    bins: Complexes, count: int, line: Line, lines: Sequence[Line], number: Integers, clean: Complexes
) -> Line | None:
    """Return a line whose amplitude decays or grows exponentially, or whose frequency drifts evenly, or both
    with a quadratic; None where its bins are not explained so."""
    own = int(np.argmin(np.abs(number - line.place)))
    stands_out = np.abs(clean) > _STANDS_OUT * line.far
    first, last = own, own
    while first > 0 and np.any(stands_out[max(0, first - 2) : first]):
        first -= 1
    while last < len(number) - 1 and np.any(stands_out[last + 1 : last + 3]):
        last += 1
    middle = 0.5 * float(number[first] + number[last])
    width = 0.5 * float(number[last] - number[first]) + _BESIDE
    if width > _WIDEST:
        return None
    within = _numbers(len(bins), middle - width, middle + width)
    near = [each for each in lines if abs(each.place - middle) <= width]
    measured = _without(bins, count, within, near, lines)
    at = places(count)
    decay, drift, bent = at.astype(np.complex128), 1j * at**2, (at**2).astype(np.complex128)
    for parts in ((decay,), (drift,), (decay, drift, bent)):
        shape = np.stack(parts)
        start = _begun(measured, within, shape, at)
        fit = fitted(changing(within, count, shape), start, measured, within, line.far)
        if fit is None or fit.by_chance < _EXPLAINED or abs(fit.unknowns[2] - middle) > width:
            continue
        found = replace(_of_course(line, fit, shape), is_one=len(near) == 1)
        return replace(_or_pair(found, measured, within, count), width=width)
    return None


def _or_pair(line: Line, measured: Complexes, number: Integers, count: int) -> Line:
    """Return a line that may as well be two that beat slowly, with that as part of its uncertainty where they
    explain the bins."""
    pair = pair_of(measured, number, count, line.place, line.far)
    if not pair.by_chance > _EXPLAINED:
        return line
    return replace(
        line,
        of_place=math.hypot(line.of_place, pair.place - line.place, pair.of_place),
        of_amplitude=math.hypot(line.of_amplitude, pair.amplitude - line.amplitude, pair.of_amplitude),
        is_one=False,
    )


def _begun(measured: Complexes, number: Integers, parts: Complexes, at: Floats) -> Floats:
    """Return unknowns of a line that changes, by its course under the window."""
    middle = int(number[len(number) // 2])
    course = np.exp(2j * np.pi * np.outer(at, number - middle)) @ measured
    seen = np.abs(course) > 0.1 * float(np.max(np.abs(course)))
    weight, window = np.abs(course[seen]), np.maximum(1.0 + np.cos(2.0 * np.pi * at[seen]), 1e-9)
    phase, level, one = np.unwrap(np.angle(course[seen])), np.log(weight / window), np.ones(len(weight))
    turning, growing = np.stack([one, at[seen], *parts.imag[:, seen]]), np.stack([one, *parts.real[:, seen]])
    turned = np.linalg.lstsq((turning * weight).T, phase * weight, rcond=None)[0]
    grown = np.linalg.lstsq((growing * weight).T, level * weight, rcond=None)[0]
    phasor = np.exp(grown[0] + 1j * turned[0])
    begin = [phasor.real, phasor.imag, middle + turned[1] / (2.0 * math.pi)]
    return np.array([*begin, *(turned[2:] + grown[1:])])


def _of_course(line: Line, fit: Fit, parts: Complexes) -> Line:
    """Return the line of a fit of a course: its mean frequency and its mean amplitude over the record."""
    phasor, scale = complex(fit.unknowns[0], fit.unknowns[1]), math.sqrt(max(1.0, fit.excess))
    growth = np.exp(fit.unknowns[3:] @ parts.real)
    amplitude = abs(phasor) * float(np.mean(growth))
    of_phasor = np.array([phasor.real, phasor.imag, 0.0]) * (amplitude / abs(phasor) ** 2)
    slope = np.concatenate([of_phasor, abs(phasor) * np.mean(growth * parts.real, axis=1)])
    of_amplitude = scale * math.sqrt(float(slope @ fit.covariance @ slope))
    of_place = scale * math.sqrt(float(fit.covariance[2, 2]))
    least, most = abs(phasor) * float(np.min(growth)), abs(phasor) * float(np.max(growth))
    of_mean = DECAYS.format(*((least, most) if growth[0] < growth[-1] else (most, least)))
    return replace(
        line,
        place=float(fit.unknowns[2]),
        amplitude=amplitude,
        of_place=of_place,
        of_amplitude=of_amplitude,
        of_mean=of_mean if most > _MOST_CHANGE * least else "",
    )


def _with_more(
    together: Fit | None, number: Integers, count: int, clean: Complexes, line: Line
) -> Line | None:
    """Return the line with further ones beside it, that are no maxima; None where they do not explain the
    bins, or are too near to be told apart."""
    fit = together
    for _ in range(_MOST_MORE):
        if fit is None:
            return None
        largest = float(number[int(np.argmax(np.abs(fit.left)))])
        at = np.append(fit.unknowns[2::3], largest)
        fit = fitted(steady(number, count), _started(clean, number, at, count), clean, number, line.far)
        if fit is not None and fit.by_chance > _EXPLAINED:
            apart = np.diff(np.sort(fit.unknowns[2::3]))
            found = _largest_of(line, fit) if np.min(apart) > _APART else None
            return found and replace(found, is_one=_swings(found, fit))
    return None


def _swings(line: Line, fit: Fit) -> bool:
    """Return whether the largest two lines beside one are its sidebands, as where its phase swings."""
    real, imaginary, place = fit.unknowns.reshape(-1, 3).T
    size = np.hypot(real, imaginary)
    beside = np.argsort(-size)[1:3]
    return len(beside) == 2 and are_sidebands(line.place, place[beside].tolist(), size[beside].tolist())


def are_sidebands(of: float, places: Sequence[float], amplitudes: Sequence[float]) -> bool:
    """Return whether two lines are about as large, and as far from the place `of` another on either side."""
    is_mirrored = abs(sum(places) - 2.0 * of) < _MIRRORED
    return is_mirrored and max(amplitudes) < _ALIKE * min(amplitudes)
