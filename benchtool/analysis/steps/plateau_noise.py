"""Noise on the plateau of an answer where that is not the noise at rest.

Without a current there is no ripple of one, and a sensor that is read against its range has noise in
proportion to what it reads. What a prediction leaves in windows of each piece (`bursts`) tells such noise
from the answer, which goes on smoothly.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.bursts import LOUD, unpredicted
from benchtool.analysis.steps.smoothing import Noise

Floats = NDArray[np.float64]

_SIZE = 16  # samples of a window
_FEWEST = 3 * _SIZE  # samples of a piece
_ROUNDING = 1e-6  # of the height of the step
_TURNS = 0.35  # of the errors, after which the next is on the other side: half of independent ones


def noise_of_plateau(
    plateau: Floats, at_rest: Iterable[Floats], height: float, converter_step: float
) -> Noise | None:
    """Return the noise of the late samples of a plateau, shape (n,); None where it is that of the pieces
    `at_rest`, or where any of these is too short to tell.

    Less noise than a step of a converter is read or not by where its levels are.
    """
    errors = [_errors(each) for each in (plateau, *at_rest)]
    if any(not len(each) for each in errors):
        return None
    there, *rest = (float(np.median(np.sqrt(np.mean(each**2, axis=1)))) for each in errors)
    loudest = max((there, *rest))
    is_louder, is_calmer = there > LOUD * max(rest), LOUD * there < max(rest)
    if not (is_louder or is_calmer) or loudest < max(_ROUNDING * height, converter_step):
        return None
    of_loudest = errors[int(np.argmax([there, *rest]))]
    turns = np.mean(np.diff(np.signbit(of_loudest), axis=1))
    return Noise.of(plateau) if turns > _TURNS else None


def _errors(piece: Floats) -> Floats:
    """Return what predictions leave in the windows of a piece, shape (windows, n); none of a short one."""
    if len(piece) < _FEWEST:
        return np.empty((0, 0))
    begin = np.arange(0, len(piece) - _SIZE + 1, _SIZE // 2)
    errors, _ = unpredicted(piece, begin, _SIZE)
    return errors
