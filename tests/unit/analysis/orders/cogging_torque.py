"""A torque with cogging over the rotor's angle, and its orders, which tests of orders share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import TURN, angle_coverage
from benchtool.analysis.orders.order_spectrum import OrderSpectrum, fitted_orders
from benchtool.block import Block, Channel, Gap

Array = NDArray[np.float64]

COGGING = {72: (0.2, 0.3), 18: (0.04, -1.0), 12: (0.02, 2.0), 1: (0.01, 0.0)}
"""Amplitude in Nm and phase in rad of each order."""


def torque_at(angle: Array, mean: float = 0.65) -> Array:
    parts = (amplitude * np.cos(order * angle + phase) for order, (amplitude, phase) in COGGING.items())
    return np.asarray(mean + np.sum(list(parts), axis=0))


def steady(revolutions: float, samples: int = 20_000) -> Array:
    return 0.4 + TURN * revolutions * np.arange(samples) / samples


def block_of(theta_m: Array, torque: Array, rate_Hz: float = 10e3, gaps: tuple[Gap, ...] = ()) -> Block:
    channels = (Channel("theta_m", "rad"), Channel("torque", "Nm"))
    return Block(channels, 0, 1, 1 / rate_Hz, np.stack([theta_m, torque], axis=1), gaps)


def uneven_angle(revolutions: float, samples: int, seed: int = 0) -> Array:
    """A rotor that hurries and lingers, seen at uneven times."""
    steps = np.random.default_rng(seed).uniform(0.2, 1.8, samples)
    turned = np.cumsum(steps) / np.sum(steps) * TURN * revolutions
    return np.asarray(turned + 0.02 * np.sin(6 * turned))


def fitted(angle: Array, values: Array) -> OrderSpectrum:
    return fitted_orders(angle_coverage(angle), values, "torque", "Nm")
