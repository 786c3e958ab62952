"""Space-vector modulation: duties whose mean is the voltage vector, the zero vectors sharing evenly."""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit

SQRT3 = math.sqrt(3.0)


class Modulated(NamedTuple):
    """Duties of the legs and the voltage that they make."""

    duty_a: float
    duty_b: float
    duty_c: float
    u_alpha: float
    u_beta: float
    limited: bool


@njit
def modulate(u_alpha: float, u_beta: float, u_dc: float) -> Modulated:
    """Return the duties of a mean voltage vector; beyond the hexagon it is shortened to its edge, keeping its
    angle.

    Adding half the sum of the largest and smallest phase voltage centres the active vectors in the period,
    which is SVPWM with equal shares of both zero vectors.
    """
    v_a = u_alpha
    v_b = -0.5 * u_alpha + 0.5 * SQRT3 * u_beta
    v_c = -0.5 * u_alpha - 0.5 * SQRT3 * u_beta
    highest, lowest = max(v_a, v_b, v_c), min(v_a, v_b, v_c)
    scale = 1.0
    beyond = highest - lowest > u_dc
    if beyond:
        scale = u_dc / (highest - lowest)
    centre = 0.5 * (highest + lowest)
    per_volt = scale / u_dc if u_dc > 0.0 else 0.0
    return Modulated(
        0.5 + (v_a - centre) * per_volt,
        0.5 + (v_b - centre) * per_volt,
        0.5 + (v_c - centre) * per_volt,
        scale * u_alpha,
        scale * u_beta,
        beyond,
    )


@njit
def compensated(duty: float, current: float, dead_share: float) -> float:
    """Return the duty that makes up for what the dead time takes at a positive current, or gives at a
    negative one."""
    if current > 0.0:
        duty += dead_share
    elif current < 0.0:
        duty -= dead_share
    return min(max(duty, 0.0), 1.0)
