"""Mean frequency of a line by the course of its phase, from one end of the record to the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.lines.course import FEWEST, change_over_record
from benchtool.analysis.lines.line_models import Complexes, Floats, phasors_at
from benchtool.analysis.lines.steadiness import Line, are_sidebands

_PARTS, _FEWEST_CYCLES, _FEWEST_ROWS = 64, 1.0, 6  # of the record; in a part
_HIDDEN = 1e-5  # bins, by noise: with less, no swing hides
_SLOW_HALVES, _POWERS = 8, 3  # half cycles in the record that are taken for a drift; of a polynomial
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
    alone = _without_slow(samples - sum_of(others, bins, count), line.place)
    phasors = _in_parts(alone, line.place, parts)
    if not float(np.min(np.abs(phasors))) > 0.0:
        return line
    steps_rad = np.angle(phasors[1:] * np.conj(phasors[:-1]))
    change = change_over_record(np.concatenate(([0.0], np.cumsum(steps_rad))))
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


def _without_slow(samples: Floats, place: float) -> Floats:
    """Return samples, shape (n,), without what is slower than a line at a place: in a part of few cycles of
    the line that is a slope, and turns it."""
    at = np.arange(len(samples)) / len(samples) - 0.5
    halves = np.cos(np.pi * np.outer(at + 0.5, np.arange(1.0, _SLOW_HALVES + 1.0)))
    slow, turned = np.concatenate([np.vander(at, _POWERS), halves], axis=1), 2.0 * np.pi * place * at
    # together with the line, whose incomplete cycles are no slow course
    both = np.column_stack([slow, np.cos(turned), np.sin(turned)])
    found = np.linalg.lstsq(both, samples, rcond=None)[0]
    return np.asarray(samples - slow @ found[: slow.shape[1]])


def _in_parts(samples: Floats, place: float, parts: int) -> Complexes:
    """Return the phasors of a sinusoid in equal parts of samples by least squares, each with a mean of its
    own, shape (parts,)."""
    count, found = len(samples), []
    for rows in np.array_split(np.arange(count), parts):
        angle = 2.0 * np.pi * place / count * rows
        columns = np.stack([np.cos(angle), -np.sin(angle), np.ones(len(rows))], axis=1)
        real, imaginary, _ = np.linalg.lstsq(columns, samples[rows], rcond=None)[0]
        found.append(complex(real, imaginary))
    return np.array(found)
