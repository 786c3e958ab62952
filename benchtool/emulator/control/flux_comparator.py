"""The comparator that decides whether TPC's next voltage vector raises the stator flux or lowers it.

Zhu, Xiao and Li (II-D) only state that it is a hysteresis controller. A vector moves the flux by up to u_s
T_k per period, several times what any band could usefully be, so that the band is taken as zero. What is
compared leaves two readings:

- plain: the flux at the moment the vector begins. The flux then alternates about its reference, but
  where it alternates drifts like a slow sawtooth by up to half a step either way, which the phase current
  shows as harmonics of low order.
- accumulated: that flux error plus half the sum of all errors so far, as in a sigma-delta modulator of
  second order. The mean flux is held, and its error is moved to frequencies that the machine's inductance
  does not let pass.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate
from benchtool.emulator.jit import njit

_ACCUMULATED = 1
_WEIGHT = 0.5  # of the sum; a loop of two accumulators is stable with one bit up to about 1
_LARGEST_SUM = 2.0  # steps of u_s T_k: a flux that cannot be reached winds up no further


@njit
def threshold(psi_s: float, at: StateEstimate, drive: Any, control: Any) -> float:
    """Return flux below which the vector raises the flux, in Wb; `flux_error_sum` grows with each call."""
    if drive.flux_comparator != _ACCUMULATED:
        return psi_s
    largest = _LARGEST_SUM * drive.u_s * drive.T_k_ratio * drive.control_period
    error = psi_s - math.sqrt(at.psi_d * at.psi_d + at.psi_q * at.psi_q)
    control.flux_error_sum = min(max(control.flux_error_sum + error, -largest), largest)
    shifted: float = psi_s + _WEIGHT * control.flux_error_sum
    return max(shifted, 0.0)
