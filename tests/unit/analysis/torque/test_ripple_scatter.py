"""The size of a ripple, and by how much it differs from period to period."""

import math

import numpy as np
import pytest

from benchtool.analysis import torque_ripple, track_angle
from benchtool.block import Block

RATE_HZ, POLE_PAIRS, PER_REVOLUTION = 5_000.0, 2, 330


@pytest.mark.parametrize("begin_rad", [0.0, 1.0, 2.5])
def test_a_load_that_moves_the_speed_along_has_its_rms_over_time(begin_rad: float) -> None:
    """Once and three times in two periods is slower than one; the speed stays where the load is high."""
    turned = 2 * np.pi * np.arange(30.15 * PER_REVOLUTION) / PER_REVOLUTION + begin_rad
    theta_m = turned + 0.03 * np.sin(turned + 0.2) + 0.005 * np.sin(2 * turned + 1.0)
    torque = 3.0 + np.cos(theta_m) + 0.4 * np.cos(2 * theta_m + 0.4) + 0.2 * np.cos(3 * theta_m + 1.0)
    truth_Nm = float(np.std(torque[: 30 * PER_REVOLUTION]))
    torque += 1e-4 * np.random.default_rng(1).standard_normal(len(torque))
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    track = track_angle(theta_m - theta_m[0], POLE_PAIRS)
    found = {each.name: each for each in torque_ripple(block, track=track, pole_pairs=POLE_PAIRS)}
    rms = found["torque_ripple_rms"]
    assert rms.uncertainty is not None
    assert abs(rms.value - truth_Nm) < 3.0 * rms.uncertainty.standard
    assert math.isclose(rms.value, truth_Nm, rel_tol=4e-4)
