"""Tones between the harmonics of a current whose frequency moves against these.

One of constant frequency beside a speed that swings or drifts, such as hum of the mains, or one that is
swept. In a spectrum along the phase of the fundamental it spreads over many bins, as noise does, but its
amplitude is constant, and its phase has a course of few constants: it is no noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_FEWEST_PERIODS = 8
_MOST, _ROUNDS = 8, 4
_ENDS, _STANDS_OUT = 0.01, 8.0  # of the power of its greatest bin; times the median of all bins
_GAP, _MARGIN = 8, 8  # bins
_PER_BIN, _FEWEST_POINTS = 4, 64  # of a course
_INNER = 0.1  # of the record at either end, where a filter of few bins rings
_EVEN = 0.1  # variance of the power over its mean squared, which is one for noise
_BEGINS_EVEN = 0.5  # likewise, with the harmonics cut out
_LEFT = 0.1  # of the power of its bins
_SAME = 1e-7  # of a column: what two courses differ less by is not told
_STEADY = 0.1  # periods of it
_BETTER = 2.0  # rms of what a steady one leaves of the phase, over that of one that moves


@dataclass(frozen=True)
class Course:
    """Where places in a record are, both of shape (n,) and relative to the record: in periods `turned`, and
    in time `passed`."""

    turned: Floats
    passed: Floats


@dataclass(frozen=True)
class MovingTone:
    """A tone with the peak `phasor` at the beginning, and cycles over the record: `by_turns` as the phase of
    the fundamental, `by_time` as the difference of time to it, and `swept` as the parabola t (t - 1) of
    time."""

    phasor: complex
    by_turns: float
    by_time: float
    swept: float

    def at(self, course: Course) -> Complexes:
        """Return it as an analytic signal, shape (n,)."""
        return np.asarray(self.phasor * np.exp(2j * np.pi * self._cycles(course)))

    def is_steady_in_time(self, course: Course) -> bool:
        """Return whether it has a constant frequency."""
        return float(np.std(self._cycles(course) - self.by_turns * course.passed)) < _STEADY

    def _cycles(self, course: Course) -> Floats:
        return np.asarray(_columns(course)[:, 1:] @ np.array([self.by_turns, self.by_time, self.swept]))


def course_of(turns: Floats, first_row: int, coherent: CoherentSamples) -> Course:
    """Return where the samples are; `turns`, shape (rows,), are periods from `first_row` on."""
    turned = np.arange(len(coherent.values)) / len(coherent.values)
    rows = np.interp(turned * coherent.periods, turns, np.arange(len(turns), dtype=np.float64))
    return Course(turned, (rows - first_row) / coherent.samples)


def moving_tones(coherent: CoherentSamples, course: Course) -> tuple[MovingTone, ...]:
    """Return up to eight of them in samples that are at `course`, the strongest first.

    Of the bins around the greatest one that is no harmonic an analytic signal is made. If its power is as
    even as that of four or more bins of noise is less than once in five hundred records, and a course of
    phase and time explains nine tenths of it, it is a tone; one that is steady against the harmonics is left
    out, and what else stands out is passed over.
    """
    if coherent.periods < _FEWEST_PERIODS:
        return ()
    found: list[MovingTone] = []
    values = coherent.values
    left = _bins(values, math.floor(coherent.usable_order * coherent.periods) + 1)
    passed_over = np.zeros(len(left), dtype=np.bool_)
    passed_over[:: coherent.periods] = True
    for _ in range(_MOST):
        around = _around_greatest(left, passed_over)
        if around is None:
            break
        fitted = _fitted(values, left, around, course, coherent.periods)
        if fitted is None:
            passed_over[around] = True
            continue
        tone, moves = fitted
        values = values - np.real(tone.at(course))
        left = _bins(values, len(left))
        if moves:
            found.append(tone)
    return tuple(found)


def _around_greatest(bins: Complexes, passed_over: NDArray[np.bool_]) -> slice | None:
    """Return the bins of what stands out most; None if nothing does."""
    power = np.where(passed_over, 0.0, bins.real**2 + bins.imag**2)
    greatest = int(np.argmax(power))
    usual = _STANDS_OUT**2 * float(np.median(power[~passed_over])) if not np.all(passed_over) else math.inf
    if not power[greatest] > usual:
        return None
    above = np.flatnonzero(power > max(_ENDS * power[greatest], usual))
    apart = np.flatnonzero(np.diff(above) > _GAP)
    part = np.split(above, apart + 1)[int(np.searchsorted(above[apart], greatest))]
    margin = _MARGIN + len(part) // 8
    return slice(max(1, int(part[0]) - margin), min(len(bins), int(part[-1]) + margin + 1))


def _fitted(
    values: Floats, bins: Complexes, around: slice, course: Course, periods: int
) -> tuple[MovingTone, bool] | None:
    """Return the tone in some bins of a spectrum, and whether it moves; None where they are none."""
    width = around.stop - around.start
    points = max(_FEWEST_POINTS, 1 << math.ceil(math.log2(_PER_BIN * width)))
    turned = np.arange(points) / points
    coarse = Course(turned, np.interp(turned, course.turned, course.passed))
    inner = np.abs(turned - 0.5) < 0.5 - _INNER
    columns = _columns(coarse)
    is_line = np.arange(around.start, around.stop) % periods == 0
    carrier = np.exp(2j * np.pi * around.start * turned)
    left = np.where(is_line, 0.0, bins[around])
    before = float(np.sum(np.abs(left) ** 2))
    tone, signal = None, np.zeros(points, dtype=np.complex128)
    for number in range(_ROUNDS):
        # at harmonics, which are not its own, stands what it makes of them
        signal = signal + carrier * fft.ifft(left, points) * points
        power = np.abs(signal[inner]) ** 2
        if not float(np.var(power)) < (_EVEN if number else _BEGINS_EVEN) * float(np.mean(power)) ** 2:
            return None
        cycles = np.unwrap(np.angle(signal / carrier)) / (2.0 * np.pi) + around.start * turned
        constants = _least_squares(columns[inner], cycles[inner])
        phasor = complex(np.mean((signal * np.exp(-2j * np.pi * (columns @ constants)))[inner]))
        tone = MovingTone(phasor * np.exp(2j * np.pi * constants[0]), *map(float, constants[1:]))
        signal = tone.at(coarse)
        left = np.where(is_line, 0.0, _bins(values - np.real(tone.at(course)), around.stop)[around])
    if tone is None or float(np.sum(np.abs(left) ** 2)) > _LEFT * before:
        return None
    steady = np.zeros(columns.shape[1])
    steady[:2] = _least_squares(columns[inner, :2], cycles[inner])
    rest, of_steady = (float(np.std((cycles - columns @ each)[inner])) for each in (constants, steady))
    return tone, of_steady > _BETTER * rest


def _columns(course: Course) -> Floats:
    """Return what the constants of a phase count by, shape (n, 4)."""
    turned, passed = course.turned, course.passed
    return np.stack([np.ones(len(turned)), turned, passed - turned, passed * (passed - 1.0)], axis=1)


def _least_squares(columns: Floats, cycles: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(columns, cycles, rcond=_SAME)[0], dtype=np.float64)


def _bins(values: Floats, count: int) -> Complexes:
    """Return the first bins of samples as peak phasors, from dc, which is twice itself."""
    return np.asarray(fft.rfft(values)[:count] * (2.0 / len(values)))
