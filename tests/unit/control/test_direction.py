"""The direction of a voltage of fixed length on either side of the pull-out angle."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from benchtool.emulator.control.estimation import state_estimate
from benchtool.emulator.control.fixed_voltage import direction, without_voltage


class Drive(NamedTuple):
    """What the functions read of the drive's memory."""

    L_d: float
    L_q: float
    psi_r: float = 0.1
    R_s: float = 0.0
    pole_pairs: int = 4
    control_period: float = 1e-4
    u_s: float = 80.0
    T_k_ratio: float = 0.7
    u_dc: float = 150.0


@pytest.mark.parametrize("psi_s", [0.05, 0.1, 0.2])
@pytest.mark.parametrize(("L_d", "L_q"), [(4e-3, 4e-3), (4e-3, 10e-3), (10e-3, 4e-3)])
def test_up_and_down_differ_where_the_torque_rises_with_the_angle_and_nowhere_else(
    L_d: float, L_q: float, psi_s: float
) -> None:
    """At standstill without resistance nothing drifts: both keep the torque, across its gradient. Up to the
    pull-out angle one raises the flux and the other lowers it; beyond it both lead back."""
    drive = Drive(L_d, L_q)

    def torque(delta: float) -> float:
        i_d, i_q = (psi_s * math.cos(delta) - drive.psi_r) / L_d, psi_s * math.sin(delta) / L_q
        return 1.5 * drive.pole_pairs * psi_s * (math.cos(delta) * i_q - math.sin(delta) * i_d)

    sides = set()
    for delta in np.linspace(-3.1, 3.1, 61):
        rises = torque(delta + 1e-6) > torque(delta - 1e-6)
        sides.add(rises)
        i_d, i_q = (psi_s * math.cos(delta) - drive.psi_r) / L_d, psi_s * math.sin(delta) / L_q
        now = state_estimate(i_d, i_q, 0.0, 1.0, 0.0, drive)
        drift = without_voltage(now, drive)
        up, down = (
            direction(now.torque, 0.0, drift.g_d, drift.g_q, now, drift, raise_below, drive)
            for raise_below in (1.0, 0.0)
        )
        assert math.hypot(up.cosine, up.sine) == pytest.approx(1.0)
        assert up.cosine * drift.g_d + up.sine * drift.g_q == pytest.approx(0.0, abs=1e-9)
        radial = up.cosine * now.psi_d + up.sine * now.psi_q
        if rises:
            assert (down.cosine, down.sine) == pytest.approx((-up.cosine, -up.sine))
            assert radial > 0.0
        else:
            assert (down.cosine, down.sine) == pytest.approx((up.cosine, up.sine))
            assert radial <= 0.0
    assert sides == {True, False}
