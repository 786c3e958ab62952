"""The least-squares line through samples that are evenly apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def places_about_middle(count: int) -> Floats:
    """Return the places of so many samples about the middle one, shape (count,), where the slope and the mean
    of a line are independent."""
    return np.arange(count, dtype=np.float64) - 0.5 * (count - 1)


def slope_weights(count: int) -> Floats:
    """Return weights, shape (count,), count > 1: the sum of samples so weighted is the slope of the line
    through them, per sample."""
    place = places_about_middle(count)
    return np.asarray(place / float(place @ place))


def slope_of(samples: Floats) -> float:
    """Return the slope of the line through samples, shape (n,), n > 1, per sample."""
    return float(slope_weights(len(samples)) @ samples)


def without_slope(samples: Floats) -> Floats:
    """Return samples, shape (n,), n > 1, less the line through them; their mean stays."""
    return np.asarray(samples - slope_of(samples) * places_about_middle(len(samples)))
