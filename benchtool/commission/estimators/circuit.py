"""What is known of a winding and the inverter at it, wherever an estimator rests on it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.legs import Legs
from benchtool.commission.estimators.vectors import vector_of


@dataclass(frozen=True)
class Circuit:
    """Resistance of a phase, voltage that dead time and devices take of it, and how currents are read.

    `T_s` is the control period, `double_update` whether it is half of a PWM period; `gains`, shape (3,), are
    the corrections of the current sensors, `noise_A` is the rms noise of one of them in a sample.
    """

    T_s: float
    R_s_ohm: float
    drop_V: float
    u_dc_V: float
    double_update: bool = False
    gains: NDArray[np.float64] = field(default_factory=lambda: np.ones(3))
    noise_A: float = 0.0

    def currents(self, readings_A: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return the vectors of readings of shape (n, 3)."""
        return vector_of(readings_A * self.gains)

    def legs(self, L_d_H: float, L_q_H: float) -> Legs:
        """Return the inverter at a winding with these inductances."""
        return Legs(self.T_s, self.u_dc_V, L_d_H, L_q_H, self.drop_V, self.double_update)
