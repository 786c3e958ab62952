"""What the steps of a converter do to lines of a spectrum under a Hann window.

The amplitude of a sinusoid of A that is read in steps of q is wrong by the sum over k of

    2 (-1)^k q / (pi k) J_1(2 pi k A / q) cos(2 pi k (mean - level) / q)

(Widrow and Kollár, Quantization Noise, 2008, of sinusoids): in records of any length alike, and bins around
the line show nothing of it. It is looked up along the record, in all that stands out of its spectrum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.lines.line_course import sum_of
from benchtool.analysis.lines.steadiness import Line
from benchtool.analysis.quantisation.repeated_steps import error_of_steps, noise_beside
from benchtool.analysis.quantisation.resolution import level_of
from benchtool.analysis.quantisation.steps_along import apart_from_noise, lines_of
from benchtool.analysis.spectral_window import line_at, spectral_window
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

HANN_POWER = 6.0
"""Mean square of white noise in a bin under a Hann window, times the samples over that of the noise."""

_LAST_DIGIT = 1e-6  # of the greatest bin: a smaller step is rounding
_LEAST_LINE = 0.25  # of a step: smaller ones may be made by steps
_DRAWS, _APART = 32, 0.2  # of a step, rms: by how much signals that may be read alike differ
_FEW, _APART_OF_FEW = 2.5, 0.5  # steps, from least to greatest; of a step: what was read tells them less
_MOST_ROWS = 1 << 15
_DRAWS_OF_NOISE = 8  # which eleven bins of each tell well enough
_AROUND = 5  # bins to either side, in which a line is fitted


@dataclass(frozen=True)
class StepsInLines:
    """Errors of a converter's steps at some `rows` of a record of `count`, shape (draws, rows), times the
    weights with which the sum of errors and a cosine is a peak amplitude under a Hann window; `square`, shape
    (bins,), is the mean square of what they make of each bin."""

    rows: NDArray[np.int64]
    errors: Floats
    count: int
    square: Floats

    def with_noise(self, line: Line) -> Line:
        """Return a line in whose bins errors count as noise."""
        place = round(line.place)
        around = self.square[max(0, place - _AROUND) : place + _AROUND + 1]
        return replace(line, far=math.hypot(line.far, math.sqrt(float(np.mean(around)))))

    def with_errors(self, line: Line, bins: Complexes) -> Line:
        """Return a line in `bins`, shape (n,), by how much it is read at another place and larger than it
        is."""
        place = round(line.place)
        read = bins[place - 1 : place + 2]
        before = [line_at(np.abs(read - each), 1) for each in self._beside(place)]
        of_place, of_amplitude = np.sqrt(np.mean((np.array(before) - line_at(np.abs(read), 1)) ** 2, axis=0))
        return replace(
            line,
            of_place=math.hypot(line.of_place, float(of_place)),
            of_amplitude=math.hypot(line.of_amplitude, float(of_amplitude)),
        )

    def _beside(self, place: int) -> Complexes:
        """Return what errors make of a bin and both beside it, shape (draws, 3)."""
        turned = (2.0 * np.pi / self.count) * (
            np.outer(self.rows, np.arange(place - 1, place + 2)) % self.count
        )
        return np.asarray(self.errors @ np.cos(turned) - 1j * (self.errors @ np.sin(turned)))


def steps_in_lines(
    samples: Floats, bins: Complexes, lines: Sequence[Line], step: float
) -> StepsInLines | None:
    """Return the errors of a converter's steps in samples, shape (n,), with these `lines` in their `bins`
    under a Hann window; None where there are no steps, or noise hides them.

    They are those of signals that differ from what was read by a part of a step in mean and size, in steps
    whose levels are known.
    """
    size, count = np.abs(bins), len(samples)
    white = float(np.median(size)) / MEDIAN_OF_RMS * math.sqrt(count / HANN_POWER)
    if not step > _LAST_DIGIT * float(np.max(size)) or _is_hidden(noise_beside(white**2, step), step):
        return None
    own = sum_of([each for each in lines if each.amplitude > _LEAST_LINE * step], bins, count)
    slow, noise = apart_from_noise(lines_of(samples - own), step, count)
    signal = own - np.mean(own) + slow
    rms = float(np.std(signal))
    if not rms > 0.0:
        return None
    random, rows = np.random.default_rng(0), np.arange(count)
    if count > _MOST_ROWS:  # any: what repeats does not repeat with them
        rows = np.sort(random.choice(count, _MOST_ROWS, replace=False))
    apart = _APART_OF_FEW if float(np.ptp(samples)) < _FEW * step else _APART
    higher, larger = apart * step * random.standard_normal((2, _DRAWS, 1))
    drawn = float(np.mean(samples)) + higher + (1.0 + larger / rms) * signal[rows]
    errors = error_of_steps(drawn, step, noise, level_of(samples, step))
    if errors is None:
        return None
    weights = spectral_window("hann", count)
    errors = errors * (weights[rows] * (2.0 / float(np.mean(weights)) / len(rows)))
    square = np.mean([_square_of_bins(rows, each, count) for each in errors[:_DRAWS_OF_NOISE]], axis=0)
    return StepsInLines(rows, errors, count, square)


def _square_of_bins(rows: NDArray[np.int64], errors: Floats, count: int) -> Floats:
    along = np.zeros(count)
    along[rows] = errors
    return np.asarray(np.abs(fft.rfft(along)) ** 2)


def _is_hidden(noise: float, step: float) -> bool:
    return error_of_steps(np.zeros(1), step, noise, 0.0) is None
