"""Lines of an output, as of a ripple or hum, that by chance repeat with the stimulus.

Such a line is the same in all periods, and so in none of their scatter, but it is at one frequency: the
response there is far from what its neighbours on both sides tell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]

_BESIDE = 3  # neighbours on either side
_TERMS = 3  # of a parabola
_FAR = 4.0  # standard deviations of what the neighbours tell
_TINY = np.finfo(np.float64).tiny


def with_lone_lines(places: NDArray[np.int64], response: Complex, error: Floats) -> Floats:
    """Return relative standard uncertainties of a response, both of shape (n,), with what a line at a single
    frequency adds; `places` are those of the frequencies.

    Parabolas through the neighbours of a frequency, of the response and of its reciprocal, say what it is
    there: about a zero the one follows, about a pole the other. It is a line where both miss by far more
    than the errors and what they leave of the neighbours.
    """
    count, width = len(response), 2 * _BESIDE + 1
    if count < width:
        return error
    near = np.arange(count - width + 1)[:, np.newaxis] + np.delete(np.arange(width), _BESIDE)
    middle = np.arange(_BESIDE, count - _BESIDE)
    by_response = _missed(places, response, error, near, middle)
    reciprocal = np.asarray(1.0 / np.where(response == 0.0, _TINY, response), dtype=np.complex128)
    by_reciprocal = _missed(places, reciprocal, error, near, middle)
    found = error.copy()
    least = np.minimum(by_response, by_reciprocal)
    found[middle] = np.maximum(error[middle], least / math.sqrt(2.0))
    return found


def _missed(
    places: NDArray[np.int64],
    values: Complex,
    error: Floats,
    near: NDArray[np.int64],
    middle: NDArray[np.int64],
) -> Floats:
    """Return by how much parabolas through the values `near`, shape (m, 6), miss those in the `middle`, shape
    (m,), relative to these; 0 where errors and the neighbours explain that."""
    spread = math.sqrt(2.0) * np.maximum(error * np.abs(values), _TINY)  # of complex values
    along = places[near] - places[middle][:, np.newaxis]
    along = along / np.max(np.abs(along), axis=1, keepdims=True)
    weight = 1.0 / spread[near]
    columns = along[:, :, np.newaxis] ** np.arange(_TERMS) * weight[:, :, np.newaxis]
    normal = np.linalg.inv(np.swapaxes(columns, 1, 2) @ columns)
    terms = np.einsum("mij,mkj,mk->mi", normal, columns, values[near] * weight)
    left = values[near] * weight - np.einsum("mki,mi->mk", columns, terms)
    dof = near.shape[1] - _TERMS
    more = np.maximum(1.0, np.sum(np.abs(left) ** 2, axis=1) / dof)
    missed = np.abs(values[middle] - terms[:, 0])
    expected = np.sqrt(more * (normal[:, 0, 0] + spread[middle] ** 2))
    relative = missed / np.maximum(np.abs(values[middle]), _TINY)
    return np.where(missed > _FAR * expected, relative, 0.0)
