"""Noise of orders of few revolutions: what the signal has halfway between whole orders."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.noise.noise_of_lines import PAIRS, experimental_noise_of_pairs

FEWEST_REVOLUTIONS = 1.9
"""From as many on, a fit of whole orders leaves most of the noise between them."""


def noise_between_orders(
    coefficient: NDArray[np.complex128], between: NDArray[np.complex128], share: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the experimental standard uncertainty of peak amplitudes by noise, and its degrees of freedom,
    both of shape (K,).

    Few revolutions have no scatter. Noise, coloured or not, is about as dense at an order as it is half an
    order beside it, where a machine has no line: as by time, pairs at equal distances around an order act on
    its amplitude as they add up when turned to its phase. Below order 0 they are those above it, conjugated.

    Args:
        coefficient: of orders 1 to K, shape (K,): half the peak amplitude.
        between: coefficients of the residual of the fit, at orders 1/2, 3/2 ... K + 1/2, shape (K + 1,).
        share: what the fit of whole orders has taken along of the power of white noise between them.
    """
    highest = len(coefficient)
    orders, steps = np.arange(1, highest + 1)[:, np.newaxis], np.arange(PAIRS)
    upper, lower = orders + steps, orders - steps - 1
    inside = upper <= highest
    mirrored = np.where(lower < 0, -1 - lower, lower)
    above = between[np.where(inside, upper, 0)]
    below = between[np.where(inside, mirrored, 0)]
    below = np.where(lower < 0, np.conj(below), below)
    towards = np.exp(-1j * np.angle(coefficient))[:, np.newaxis]
    together = above * towards + np.conj(below * towards)
    noise = 2.0 * experimental_noise_of_pairs(together, inside) / math.sqrt(1.0 - share)
    return noise, 2.0 * np.count_nonzero(inside, axis=1)


def fitted_share(revolutions: float) -> float:
    """Return the share of white noise, halfway between whole orders, that a fit of them all takes along: the
    sum of the responses sinc^2(R (l + 1/2)) of all orders l at that place, in R evenly covered
    revolutions."""
    whole = np.arange(1, math.floor(revolutions) + 1)
    alternating = np.where(whole % 2, -1.0, 1.0)
    return float(1.0 + 2.0 * np.sum((1.0 - whole / revolutions) * alternating)) / revolutions
