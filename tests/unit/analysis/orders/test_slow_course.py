"""Orders of a signal that moves from revolution to revolution, such as the speed of a run-up."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.orders.angle import angle_coverage
from benchtool.analysis.orders.angle_orders import AngleFit, fit_orders

RATE_HZ, SECONDS = 1000.0, 3.0
ORDER_1, ORDER_6 = 0.2, 0.1


def run_up(noise: float, seed: int, acceleration_rad_s2: float = 40.0) -> AngleFit:
    """Return the orders of a speed that is run up from 30 rad/s, with ripple of orders 1 and 6."""
    t = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    theta_m = 30.0 * t + 0.5 * acceleration_rad_s2 * t**2
    speed = 30.0 + acceleration_rad_s2 * t
    speed += ORDER_1 * np.cos(theta_m - 0.5) + ORDER_6 * np.cos(6 * theta_m)
    speed += np.random.default_rng(seed).normal(0.0, noise, len(t))
    return fit_orders(angle_coverage(theta_m % (2 * np.pi)), speed, 20)


def test_a_run_up_does_not_look_like_orders() -> None:
    fit = run_up(noise=0.0, seed=1)
    assert fit.on_a_course
    found = 2.0 * np.abs(fit.coefficient)
    truth = np.zeros(20)
    truth[0], truth[5] = ORDER_1, ORDER_6
    # the ramp alone, 90 rad/s high, would read 1 rad/s at order 1
    np.testing.assert_allclose(found, truth, atol=1.5e-3)


@pytest.mark.parametrize("acceleration_rad_s2", [2.0, 40.0])
def test_uncertainty_of_a_run_up_holds(acceleration_rad_s2: float) -> None:
    records = [run_up(0.1, seed, acceleration_rad_s2) for seed in range(30)]
    for order, truth in ((1, ORDER_1), (6, ORDER_6)):
        found = [2.0 * abs(fit.coefficient[order - 1]) for fit in records]
        standard = [float(fit.standard[order - 1]) for fit in records]
        errors = (np.array(found) - truth) / np.array(standard)
        assert 0.7 < np.sqrt(np.mean(errors**2)) < 1.4
        assert np.mean(standard) < 0.01  # noise alone: 0.1 sqrt(2 / 3000) = 2.6e-3


def test_noise_has_no_course() -> None:
    taken_off = [run_up(0.1, seed, acceleration_rad_s2=0.0).on_a_course for seed in range(60)]
    assert sum(taken_off) <= 1
