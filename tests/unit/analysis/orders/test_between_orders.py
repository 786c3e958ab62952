"""Noise halfway between orders, against sums over both sides written out one by one."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

from benchtool.analysis.noise.noise_of_lines import PAIRS, experimental_noise_of_pairs
from benchtool.analysis.orders.between_orders import fitted_share, noise_between_orders

HIGHEST = 12


@pytest.mark.parametrize("without", [None, 4])
def test_pairs_are_turned_to_the_order_and_mirrored_at_zero(without: int | None) -> None:
    random = np.random.default_rng(2)
    coefficient = random.standard_normal(HIGHEST) + 1j * random.standard_normal(HIGHEST)
    if without is not None:
        coefficient[without] = 0.0
    between = random.standard_normal(HIGHEST + 1) + 1j * random.standard_normal(HIGHEST + 1)
    at = {0.5 + number: complex(each) for number, each in enumerate(between)}
    at |= {-place: each.conjugate() for place, each in at.items()}

    noise, freedom = noise_between_orders(coefficient, between, 0.36)

    for order in range(1, HIGHEST + 1):
        towards = cmath.exp(-1j * cmath.phase(complex(coefficient[order - 1])))
        apart = [0.5 + number for number in range(PAIRS) if order + 0.5 + number in at]
        pairs = [at[order + each] * towards + (at[order - each] * towards).conjugate() for each in apart]
        sums, inside = np.array([pairs]), np.ones((1, len(pairs)), dtype=np.bool_)
        assert noise[order - 1] == pytest.approx(2.0 * experimental_noise_of_pairs(sums, inside)[0] / 0.8)
        assert freedom[order - 1] == 2 * len(apart)


@pytest.mark.parametrize("revolutions", [1.9, 2.0, 2.6, 3.0, 3.4, 7.3])
def test_whole_orders_take_along_what_they_respond_to_halfway_between(revolutions: float) -> None:
    apart = revolutions * (np.arange(-200_000, 200_000) + 0.5)
    assert fitted_share(revolutions) == pytest.approx(float(np.sum(np.sinc(apart) ** 2)), abs=1e-5)
