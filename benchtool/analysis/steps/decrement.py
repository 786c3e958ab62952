"""Heights of the lobes of one mode that decays, by the logarithmic decrement of all of them.

The lobes of a mode are each by one factor less than the one before (den Hartog, Mechanical Vibrations,
4th ed. 1956): the height of the last ones, which noise makes the most of, follows from the first.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FEWEST = 3  # lobes: two are of any decrement
_DESCRIBED = 3.0  # standard deviations of a sum of squares beyond what noise leaves
_STEPS, _ENOUGH = 12, 1e-9  # of Gauss and Newton, and the change of a constant that ends them
_SINGULAR = 1e-10  # of the largest: an eigenvalue of a covariance that is rounding


def of_one_mode(heights: Floats, errors: Floats) -> Floats | None:
    """Return the heights of successive lobes, shape (draws, lobes), as those of one mode may be; None where
    they are of several, are not all above zero, or are too few to tell.

    `heights`, shape (lobes,), are those found one by one, with these `errors` in draws, shape (draws, lobes),
    by whose covariance they count (generalised least squares: Aitken, Proc. R. Soc. Edinburgh 55 (1936) 42).
    """
    count, draws = len(heights), len(errors)
    if count < _FEWEST or draws < 2 * count or not np.all(heights > 0.0):
        return None
    inverse = np.linalg.pinv(np.atleast_2d(np.cov(errors.T)), _SINGULAR, hermitian=True)
    # that of a covariance from few draws is too large (Hartlap, Simon and Schneider, A&A 464 (2007) 399)
    inverse *= (draws - count - 2.0) / (draws - 1.0)
    powers = np.stack([np.ones(count), np.arange(float(count))], axis=1)
    weights = heights**2 * np.diag(inverse)
    constants = np.linalg.lstsq(
        powers * np.sqrt(weights)[:, np.newaxis], np.log(heights) * np.sqrt(weights), rcond=None
    )[0]
    for _ in range(_STEPS):
        found = np.exp(powers @ constants)
        slopes = powers * found[:, np.newaxis]
        to_constants = np.linalg.pinv(slopes.T @ inverse @ slopes) @ slopes.T @ inverse
        change = to_constants @ (heights - found)
        constants = constants + change
        if not np.all(np.isfinite(constants)) or not constants[1] < 0.0:
            return None
        if float(np.max(np.abs(change))) < _ENOUGH:
            break
    found = np.exp(powers @ constants)
    left, dof = heights - found, count - 2
    if float(left @ inverse @ left) > dof + _DESCRIBED * math.sqrt(2.0 * dof):
        return None
    slopes = powers * found[:, np.newaxis]
    return np.asarray(found + errors @ to_constants.T @ slopes.T)
