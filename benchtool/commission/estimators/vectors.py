"""Amplitude-invariant space vectors of three phases as complex numbers; the real axis lies on phase a."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

PHASES: Final = np.exp(2j * math.pi / 3.0 * np.arange(3))
"""Directions of the phases a, b and c."""


def vector_of(phases: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the vectors of phase quantities of shape (n, 3): 2/3 (a + b e^(j 2 pi/3) + c e^(j 4 pi/3))."""
    vectors: NDArray[np.complex128] = phases @ PHASES * (2.0 / 3.0)
    return vectors


def drop_vector(phases: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the vector, for currents of shape (n, 3), of one volt in each phase against its current.

    Dead time and devices take their voltage so: V_drop sgn(i) of each phase, whatever the size of i.
    """
    return vector_of(np.sign(phases))


def phases_of(vectors: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the phase quantities, shape (n, 3), of vectors of shape (n,)."""
    phases: NDArray[np.float64] = (vectors[:, None] * PHASES.conj()).real
    return phases
