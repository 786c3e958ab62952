"""Margins of a sampled loop that is known, from its open-loop response at z = exp(j omega T_s)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.errors import AnalysisError

Complex = NDArray[np.complex128]
_POINTS = 20_000
_LOWEST = 1e-4  # of half of the sampling rate


@dataclass(frozen=True)
class Margins:
    """Crossover in rad/s, phase margin in rad, gain margin as a factor, and the greatest sensitivity.

    The gain margin is infinite where the phase stays above -180 degrees.
    """

    crossover_rad_s: float
    phase_rad: float
    gain: float
    sensitivity: float


def margins(open_loop: Callable[[Complex], Complex], T_s: float) -> Margins:
    """Return the margins of a loop (Åström and Murray, Feedback Systems, 2nd ed., 10.3 and 12.1).

    Args:
        open_loop: its response, of z.
        T_s: sampling period in s.

    Raises:
        AnalysisError: the gain does not fall through 1.
    """
    omega = np.geomspace(_LOWEST * math.pi / T_s, math.pi / T_s, _POINTS)
    L = open_loop(np.exp(1j * omega * T_s))
    gain, phase = np.abs(L), np.unwrap(np.angle(L))
    phase -= 2.0 * math.pi * round(float(phase[0] + 0.5 * math.pi) / (2.0 * math.pi))
    crossover = _falls_through(np.log(gain), 0.0)
    if crossover is None:
        raise AnalysisError(
            f"the gain of the loop does not fall through 1 between {omega[0]:.3g} and {omega[-1]:.3g} rad/s: "
            f"check the parameters that it is designed with"
        )
    turned = _falls_through(phase, -math.pi)
    return Margins(
        _at(omega, crossover),
        math.pi + _at(phase, crossover),
        math.inf if turned is None else 1.0 / _at(gain, turned),
        float(np.max(1.0 / np.abs(1.0 + L))),
    )


def _falls_through(values: NDArray[np.float64], level: float) -> float | None:
    """Return the place, in samples, where values first fall through a level; None where they do not."""
    below = np.flatnonzero((values[:-1] >= level) & (values[1:] < level))
    if len(below) == 0:
        return None
    k = int(below[0])
    return k + float((values[k] - level) / (values[k] - values[k + 1]))


def _at(values: NDArray[np.float64], place: float) -> float:
    return float(np.interp(place, np.arange(len(values)), values))
