"""Lines whose phase swings, as that of a speed does: they have sidebands, and less amplitude without them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy import fft

from benchtool.analysis.lines.around_lines import MAIN_LOBE
from benchtool.analysis.lines.line_models import (
    Complexes,
    alternating,
    hann_kernel,
    middle_bins,
    phasors_at,
)
from benchtool.analysis.lines.steadiness import Line

_LOWEST, _REACH, _MARGIN = 4, 96, 12  # bins
_STANDS_OUT = 5.0  # of the noise
_PLACES, _INNER = 512, 0.3  # in the record; of it to either side of its middle, where the window is large
_OF_PHASE = 30.0  # power of what moves the phase over that of what moves the amplitude
_OF_NOISE, _SURELY = 2.0, 6.0  # of the power of noise
_TELLS = 0.5  # of a standard uncertainty
_OF_ONE_LINE = math.pi / math.sqrt(3.0)  # rad rms: of a phase anywhere in a turn


def with_swing(bins: Complexes, count: int, line: Line) -> Line:
    """Return a line in the bins of a record of `count` samples, with the reason why its amplitude has no
    uncertainty where its phase swings.

    What stands out of the noise to both sides, with the line itself, has a course of the logarithm of the
    amplitude and one of the phase. Sidebands of a phase that swings leave the first constant, those of an
    amplitude the second; other lines to both sides move both alike.
    """
    middle = round(line.place)
    reach = min(_REACH, middle - _LOWEST, len(bins) - 1 - middle)
    beside = np.arange(-reach, reach + 1)
    stands_out = (np.abs(bins[middle + beside]) > _STANDS_OUT * line.far) & (np.abs(beside) > 1)
    if reach <= MAIN_LOBE or not np.any(stands_out & stands_out[::-1]):
        return line
    number = np.arange(max(1, middle - reach - _MARGIN), min(len(bins), middle + reach + _MARGIN + 1))
    own = phasors_at(bins, np.array([line.place]), count)
    image = np.conj(own) * hann_kernel(number + np.float64(line.place), count)
    at = np.arange(_PLACES) / _PLACES - 0.5
    # at times about the middle every other bin has the other sign
    spread = np.zeros(_PLACES, dtype=np.complex128)
    spread[(number - middle) % _PLACES] = alternating(number - middle) * (middle_bins(bins, number) - image)
    carried = fft.ifft(spread) * np.exp(-2j * np.pi * (line.place - middle) * at)
    component = alternating(beside) * fft.fft(carried)[beside % _PLACES]
    stands_out = (np.abs(component) > _STANDS_OUT * line.far) & (np.abs(beside) > 1)
    stands_out &= stands_out[::-1]
    if not np.any(stands_out):
        return line
    kept = stands_out | (np.abs(beside) <= 1)
    at = at[np.abs(at) < _INNER]
    under_window = np.exp(2j * np.pi * np.outer(at, beside[kept])) @ component[kept]
    swung = np.log(under_window / (1.0 + np.cos(2.0 * np.pi * at)))
    of_phase2, of_amplitude2 = float(np.var(np.unwrap(swung.imag))), float(np.var(swung.real))
    of_noise2 = (line.far / line.amplitude) ** 2 * float(np.sum(kept)) / 3.0  # 1.5 bins' of one component
    swings = of_phase2 - of_noise2 > _OF_PHASE * (of_amplitude2 - _OF_NOISE * of_noise2)
    tells = 0.5 * of_phase2 * line.amplitude > _TELLS * line.of_amplitude
    if not (swings and tells and of_phase2 > _SURELY * of_noise2):
        return line
    return replace(line, unsure=_sidebands(math.sqrt(of_phase2)))


def _sidebands(swing_rad: float) -> str:
    """Return what sidebands are as of; a phase that goes further than a turn is not that of one line."""
    seen = (
        f"as of a line whose phase swings by {swing_rad:.2g} rad rms"
        if swing_rad < _OF_ONE_LINE
        else "as of a line whose phase turns round within the record, or of several lines"
    )
    return f"sidebands to both sides, {seen}: the amplitude is that of the line without them"


def is_sideband(line: Line, other: Line) -> bool:
    """Return whether a line is so near to another, whose phase swings, that it may be a sideband of that."""
    return bool(other.unsure) and abs(line.place - other.place) < _REACH
