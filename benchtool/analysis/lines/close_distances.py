"""How far apart lines are that are too close to be two maxima: all distances that explain the bins."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_PASSES, _LIKELY = 3, 12.0  # over ever fewer distances: by that much less likely in the logarithm is not


class FitsAtDistances(Protocol):
    """Fits at distances `apart`, in bins, and the logarithms of their likelihoods, both of shape
    (distances,)."""

    @property
    def apart(self) -> Floats: ...
    @property
    def likely(self) -> Floats: ...


Fits = TypeVar("Fits", bound=FitsAtDistances)


def likely_fits(fitted: Callable[[float, float], Fits], nearest: float, farthest: float) -> Fits:
    """Return the fits at distances that are likely, of `fitted` at distances from a first to a last one."""
    first, last = nearest, farthest
    fits = fitted(first, last)
    for _ in range(_PASSES - 1):
        apart, near = fits.apart, np.flatnonzero(fits.likely > np.max(fits.likely) - _LIKELY)
        step = float(apart[1] - apart[0])
        narrower = (
            max(nearest, float(apart[near[0]]) - step),
            min(farthest, float(apart[near[-1]]) + step),
        )
        if narrower == (first, last):
            break
        first, last = narrower
        fits = fitted(first, last)
    return fits
