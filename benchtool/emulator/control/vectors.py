"""The inverter's eight switch states, held for a whole control period.

Vector k = 1 ... 6 lies at (k - 1) 60 degrees: 100, 110, 010, 011, 001, 101; the zero vectors are 0 (000)
and 7 (111).
"""

from __future__ import annotations

from typing import Any

from benchtool.emulator.control.estimation import clarke
from benchtool.emulator.control.svpwm import Modulated
from benchtool.emulator.jit import njit

MODULATED = -1  # no vector: a mean voltage, made by SVPWM

# Bit k: the leg is high in vector k.
_HIGH_A, _HIGH_B, _HIGH_C = 0b11000110, 0b10011100, 0b11110000


@njit
def held(vector: int, u_dc: float) -> Modulated:
    """Return the duties of 0 and 1, and the voltage that they make."""
    a = float((_HIGH_A >> vector) & 1)
    b = float((_HIGH_B >> vector) & 1)
    c = float((_HIGH_C >> vector) & 1)
    u_alpha, u_beta = clarke(a, b, c)
    return Modulated(a, b, c, u_dc * u_alpha, u_dc * u_beta, False)


@njit
def nearest_zero(control: Any) -> int:
    """Return the zero vector that is fewer switchings away from the duties under way."""
    return 7 if control.duty_a + control.duty_b + control.duty_c > 1.5 else 0
