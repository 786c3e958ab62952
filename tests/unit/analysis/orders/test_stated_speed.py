"""Orders where the rotor did not turn at quite the speed that was stated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import orders_at_speed
from benchtool.block import Block
from benchtool.errors import AnalysisError

RATE_HZ, COUNT = 5_000.0, 8_000
STATED_HZ = 20.0
TURNS = STATED_HZ * COUNT / RATE_HZ
ORDERS = {1: 0.05, 24: 0.1}


def torque(
    speed_Hz: float, *others: tuple[float, float], drift: float = 0.0, noise: float = 0.01, seed: int = 0
) -> Block:
    """Return torque of orders 1 and 24 at a speed, with sinusoids of frequencies and amplitudes, and noise.

    The speed rises by a share `drift` over the record.
    """
    random = np.random.default_rng(seed)
    time_s = np.arange(COUNT) / RATE_HZ
    turned = speed_Hz * time_s * (1.0 + drift * (0.5 * time_s * RATE_HZ / COUNT - 0.5))
    lines = [(order * turned, amplitude) for order, amplitude in ORDERS.items()]
    lines += [(frequency_Hz * time_s, amplitude) for frequency_Hz, amplitude in others]
    values = 1.5 + noise * random.standard_normal(COUNT)
    for cycles, amplitude in lines:
        values += amplitude * np.cos(2.0 * np.pi * cycles + random.uniform(0.0, 2.0 * np.pi))
    return Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values)


def found(block: Block) -> dict[int, tuple[float, float]]:
    """Return amplitude and standard uncertainty of the orders that are there, at the stated speed."""
    spectrum = orders_at_speed(block, "torque", 2.0 * math.pi * STATED_HZ)
    return {each: (spectrum.amplitude[each - 1], spectrum.standard[each - 1]) for each in ORDERS}


def test_a_speed_that_is_off_by_less_than_half_a_bin_is_told_by_the_lines() -> None:
    random = np.random.default_rng(3)
    errors: dict[int, list[float]] = {each: [] for each in ORDERS}
    for seed in range(40):
        bins = random.uniform(-0.45, 0.45)
        for order, (value, standard) in found(
            torque(STATED_HZ * (1.0 + bins / 24 / TURNS), seed=seed)
        ).items():
            errors[order].append((value - ORDERS[order]) / standard)
    for each in errors.values():
        assert 0.7 < np.sqrt(np.mean(np.square(each))) < 1.3
        assert abs(np.mean(each)) < 0.4


@pytest.mark.parametrize("slip", [-0.005, -0.001, 0.002, 0.009])
def test_another_speed_is_refused_and_named(slip: float) -> None:
    with pytest.raises(AnalysisError, match="would be order 24 of") as refused:
        found(torque(STATED_HZ * (1.0 + slip)))
    named = float(str(refused.value).partition(" of ")[2].rpartition(" rad/s:")[0].rpartition(" ")[2])
    assert named == pytest.approx(2.0 * math.pi * STATED_HZ * (1.0 + slip), rel=1e-5)


@pytest.mark.parametrize("drift", [1e-3, 5e-3, 0.02])
def test_a_speed_that_drifts_is_refused(drift: float) -> None:
    with pytest.raises(AnalysisError, match="is not steady"):
        found(torque(STATED_HZ, drift=drift))


@pytest.mark.parametrize("other_Hz", [50.0, 24.08 * STATED_HZ, 100.2 * STATED_HZ])
def test_a_line_of_something_else_moves_no_order(other_Hz: float) -> None:
    for order, (value, standard) in found(torque(STATED_HZ, (other_Hz, 0.08))).items():
        assert value == pytest.approx(ORDERS[order], abs=4.0 * standard)


def test_noise_alone_leaves_the_stated_speed() -> None:
    block = Block.from_arrays(
        RATE_HZ, {"torque": "Nm"}, torque=np.random.default_rng(5).standard_normal(COUNT)
    )
    spectrum = orders_at_speed(block, "torque", 2.0 * math.pi * STATED_HZ)
    assert "by the lines" not in spectrum.method
    assert np.all(np.isfinite(spectrum.standard))
