"""Space vectors of three phases as complex numbers, amplitude-invariant.

    x = 2/3 (x_a + x_b e^(j 2 pi/3) + x_c e^(j 4 pi/3)),     x_a = Re(x), x_b = Re(x e^(-j 2 pi/3)), ...

The real axis, alpha, lies along phase a. What the phases have in common, a third of their sum, is not in it.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]

AXES: Final[Complex] = np.exp(2j * math.pi / 3.0 * np.arange(3.0))
"""The directions of the phases a, b and c."""


def space_vector(phases: Floats) -> Complex:
    """Return the vector, shape (n,), of values of the phases, shape (3, n); what they have in common drops
    out."""
    a, b, c = phases
    return np.asarray((2.0 * a - b - c) / 3.0 + 1j * (b - c) / math.sqrt(3.0))


def phase_values(vector: Complex) -> Floats:
    """Return the values of the phases, shape (3, n), of a vector, shape (n,); they add up to zero."""
    return np.real(np.conj(AXES)[:, np.newaxis] * vector)
