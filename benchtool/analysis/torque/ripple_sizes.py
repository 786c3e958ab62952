"""Whether the size of a ripple differs from period to period with a memory that so few do not tell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.scatter import is_memory_untold
from benchtool.analysis.torque.means_of_periods import Periods

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_MOST_HARMONICS, _FEWEST_ROWS = 64, 4  # in a period
_MOST_PERIODS = 31  # more tell how long a memory is
_FEWEST_REVOLUTIONS = 3


def is_size_untold(samples: Floats, repeats: Periods) -> bool:
    """Return whether the size of the ripple of samples, shape (n,), wanders for a while that its few periods
    do not tell, so that neither its scatter nor its neighbours tell the error of its mean.

    The size of a period is the part of it along the curve that all have in common. What noise, or a phase
    that is not followed, moves as much is the part along the same curve with each of its harmonics a quarter
    of its own period later. What comes back in each revolution is no wander.
    """
    fewest = int(np.min(np.diff(repeats.rows)))
    if len(repeats) > _MOST_PERIODS or fewest < _FEWEST_ROWS:
        return False
    within = samples[: repeats.rows[-1]] - np.mean(samples[: repeats.rows[-1]])
    if not np.any(within):
        return False
    curve = _common(within, np.exp(2j * np.pi * repeats.turns), min(_MOST_HARMONICS, (fewest - 1) // 2))
    begin, columns = repeats.rows[:-1], (np.ones(len(within)), curve.real, curve.imag)
    normal = np.array([[np.add.reduceat(one * other, begin) for other in columns] for one in columns])
    right = np.array([np.add.reduceat(each * within, begin) for each in columns])
    parts = np.linalg.pinv(normal.transpose(2, 0, 1), hermitian=True) @ right.T[:, :, np.newaxis]
    size = _without_revolutions(parts[:, 1, 0] + 1j * parts[:, 2, 0], repeats.per_revolution)
    return is_memory_untold(size.real, size.imag)


def _common(within: Floats, turned: Complexes, harmonics: int) -> Complexes:
    """Return the curve that all periods of samples, shape (n,), have in common, up to so many harmonics, and
    as its imaginary part the same a quarter later; `turned` is the phasor of their phase, shape (n,)."""
    curve, power = np.zeros(len(within), dtype=np.complex128), np.ones(len(within), dtype=np.complex128)
    for _ in range(harmonics):
        power *= turned
        curve += (2.0 * np.vdot(power, within) / len(within)) * power
    return curve


def _without_revolutions(values: Complexes, per_revolution: int) -> Complexes:
    """Return values, shape (periods,), without what they do in every revolution alike."""
    if per_revolution == 1 or len(values) < _FEWEST_REVOLUTIONS * per_revolution:
        return values
    place = np.arange(len(values)) % per_revolution
    repeated = np.array([np.mean(values[place == each]) for each in range(per_revolution)])
    return np.asarray(values - (repeated - np.mean(repeated))[place])
