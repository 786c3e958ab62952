"""Mean frequency of a line by the course of its phase, from one end of the record to the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.polynomial import Polynomial

from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.lines.course import FEWEST, change_over_record
from benchtool.analysis.lines.line_models import Complexes, Floats, phasors_at
from benchtool.analysis.lines.steadiness import Line, are_sidebands

_PARTS, _FEWEST_CYCLES, _FEWEST_ROWS = 64, 1.0, 6  # of the record; in a part
_HIDDEN = 1e-5  # bins, by noise: with less, no swing hides
_SLOW_HALVES, _POWERS = 8, 3  # half cycles in the record that are taken for a drift; of a polynomial
_FITS, _COURSE = 3, 4  # degree of a polynomial
_LARGEST_RAD = 0.25  # noise of the phase in a part: with more, a turn may be lost between parts


def along_course(samples: Floats, bins: Complexes, line: Line, others: Sequence[Line]) -> Line:
    """Return a line of samples, shape (n,), at the mean of a frequency that may move slowly.

    A fit under a Hann window reads the middle of a record, while the mean frequency is how far the phase gets
    from its first to its last row. A slow swing hides in the main lobe, where noise covers it: between both
    it may be many times what noise causes. So the phase is fitted in up to 64 parts, and its course carried
    on to both ends (`change_over_record`), without the `others`. A line with sidebands that stand out is left
    at the frequency between them.
    """
    count = len(samples)
    parts = min(_PARTS, int(line.place / _FEWEST_CYCLES), count // _FEWEST_ROWS)
    if not line.is_one or line.of_mean or _has_sidebands(line, others) or not line.of_place > _HIDDEN:
        return line
    parts = min(parts, int((_LARGEST_RAD / line.of_place) ** 2))
    if parts < FEWEST:
        return line
    phase_rad = _phases_of_parts(samples - sum_of(others, bins, count), line.place, parts)
    if phase_rad is None:
        return line
    change = change_over_record(phase_rad)
    standard = students_deviation(change.dof) * change.standard
    return replace(
        line, place=line.place + change.size / (2.0 * math.pi), of_place=standard / (2.0 * math.pi)
    )


def _has_sidebands(line: Line, others: Sequence[Line]) -> bool:
    """Return whether two of the others are sidebands of a line."""
    return any(
        are_sidebands(line.place, (one.place, other.place), (one.amplitude, other.amplitude))
        for one, other in combinations(others, 2)
    )


def sum_of(lines: Sequence[Line], bins: Complexes, count: int) -> Floats:
    """Return the sinusoids of these lines, shape (count,)."""
    places = np.array([each.place for each in lines])
    number, total = np.arange(count), np.zeros(count)
    for place, phasor in zip(places, phasors_at(bins, places, count), strict=True):
        total += np.real(phasor * np.exp(2j * np.pi * place / count * (number - 0.5 * count)))
    return total


def _without_slow(samples: Floats, angle_rad: Floats) -> Floats:
    """Return samples, shape (n,), without what is slower than a line of this phase: in a part of few cycles
    of the line that is a slope, and turns it."""
    slow = _slow(len(samples))
    # together with the line, whose incomplete cycles are no slow course
    both = np.column_stack([slow, np.cos(angle_rad), np.sin(angle_rad)])
    found = np.linalg.lstsq(both, samples, rcond=None)[0]
    return np.asarray(samples - slow @ found[: slow.shape[1]])


@lru_cache(maxsize=1)
def _slow(count: int) -> Floats:
    """Return what a drift over so many samples is a sum of, shape (count, columns)."""
    at = np.arange(count) / count - 0.5
    halves = np.cos(np.pi * np.outer(at + 0.5, np.arange(1.0, _SLOW_HALVES + 1.0)))
    return np.concatenate([np.vander(at, _POWERS), halves], axis=1)


def _phases_of_parts(samples: Floats, place: float, parts: int) -> Floats | None:
    """Return the mean phases, beside that of a steady line at a place, of a sinusoid in equal parts of
    samples, shape (parts,); None where it is zero in one.

    In a part of few cycles a line that is faster or slower than the one that is fitted has an image at the
    negative frequency, which turns it: the second fit is along the course of the first.
    """
    count = len(samples)
    number, split = np.arange(count), np.array_split(np.arange(count), parts)
    middles = np.array([np.mean(rows) for rows in split])
    steady_rad = 2.0 * np.pi * place / count * number
    course_rad: Floats = np.zeros(count)
    left_rad: Floats = np.zeros(parts)
    for fit in range(_FITS):
        if fit:
            of_parts_rad = np.array([np.mean(course_rad[rows]) for rows in split])
            course_rad = np.asarray(Polynomial.fit(middles, left_rad + of_parts_rad, _COURSE)(number))
        angle_rad = steady_rad + course_rad
        phasors = _in_parts(_without_slow(samples, angle_rad), angle_rad, parts)
        if not float(np.min(np.abs(phasors))) > 0.0:
            return None
        steps_rad = np.angle(phasors[1:] * np.conj(phasors[:-1]))
        left_rad = np.concatenate(([0.0], np.cumsum(steps_rad)))
    # parts of whole rows are not of one length, over which the course is far from even
    edges = np.linspace(0.0, count, parts + 1)
    sums = np.interp(edges, np.arange(count + 1), np.concatenate([[0.0], np.cumsum(course_rad)]))
    return np.asarray(left_rad + np.diff(sums) / np.diff(edges))


def _in_parts(samples: Floats, angle_rad: Floats, parts: int) -> Complexes:
    """Return the phasors of a sinusoid of this phase in equal parts of samples by least squares, each with a
    mean of its own, shape (parts,)."""
    found = []
    for values, angle in zip(np.array_split(samples, parts), np.array_split(angle_rad, parts), strict=True):
        columns = np.stack([np.cos(angle), -np.sin(angle), np.ones(len(values))], axis=1)
        real, imaginary, _ = np.linalg.lstsq(columns, values, rcond=None)[0]
        found.append(complex(real, imaginary))
    return np.array(found)
