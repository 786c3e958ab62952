"""Orders of a speed by differences of counts are known to what the counts' rounding does to them."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.orders.orders import order_analysis
from benchtool.block import Block
from tests.unit.analysis.quantisation.counted_shaft import RATE_HZ, Shaft, difference

ORDERS = (1, 5, 24)
ROWS = 8


def record(shaft: Shaft, seed: int, digits: type = np.float64, has_gap: bool = False) -> Block:
    """Return angle and speed by its differences, computed in numbers of so many digits."""
    read_rad = shaft.read_rad(shaft.angle_rad(np.random.default_rng(seed)))
    angle: np.ndarray = np.mod(read_rad, 2.0 * np.pi).astype(digits)
    speed: np.ndarray = difference(np.unwrap(angle).astype(digits), ROWS).astype(digits)
    angle = angle[ROWS:]
    units = {"theta_m": "rad", "omega_m": "rad/s"}
    block = Block.from_arrays(RATE_HZ, units, theta_m=angle, omega_m=speed)
    lost = np.zeros(len(angle), dtype=np.bool_)
    lost[4000:5500] = has_gap
    return block.without(lost) if has_gap else block


def off_and_standard(shaft: Shaft, block: Block) -> np.ndarray:
    """Return errors of orders, and their standard uncertainties, rad/s, shape (orders, 2)."""
    of_means = shaft.speed_rad_s / (2.0 * np.pi * RATE_HZ) * ROWS
    truths = dict.fromkeys(ORDERS, 0.0) | {
        order: size * np.sinc(order * of_means) for order, size in shaft.ripple
    }
    found = order_analysis(block, "omega_m", "speed", orders=ORDERS).spectrum
    return np.array(
        [[found.amplitude[each - 1] - truths[each], found.uncertainty(each).standard] for each in ORDERS]
    )


@pytest.mark.parametrize(("counts", "has_gap"), [(16_384, False), (2_500, True)])
def test_the_uncertainty_is_that_of_rounding_by_time_and_by_angle(counts: int, has_gap: bool) -> None:
    shaft = Shaft(counts=counts)
    found = np.array([off_and_standard(shaft, record(shaft, seed, has_gap=has_gap)) for seed in range(8)])
    off, standard = (found[:, [0, 2], each] for each in (0, 1))  # order 5 is noise alone
    assert 0.6 < np.sqrt(np.mean((off / standard) ** 2)) < 1.4
    assert np.mean(np.abs(off) < 2.0 * standard) > 0.85


def test_the_digits_that_counts_are_written_in_are_not_their_steps() -> None:
    shaft = Shaft()
    of_64, of_32 = (off_and_standard(shaft, record(shaft, 3, digits)) for digits in (np.float64, np.float32))
    assert of_32[:, 1] == pytest.approx(of_64[:, 1], rel=0.3)


def test_a_shaft_that_turns_evenly_has_orders_beside_a_gap() -> None:
    shaft = Shaft(ripple=())
    found = off_and_standard(shaft, record(shaft, 2, has_gap=True))
    assert np.all(found[:, 0] < 2.5 * found[:, 1])
