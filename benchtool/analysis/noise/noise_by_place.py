"""Noise between harmonics by its place in the period: of few places it is the same from order to order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy import fft
from numpy.typing import NDArray

_FEWEST = 8  # orders, and bins of each
_TINY = 1e-12
_CLEARLY = 6.0  # standard deviations, of sums of few exponentials


def repetition_of_bins(phasor: NDArray[np.complex128], periods: int, bins: NDArray[np.int64]) -> float:
    """Return by how much more, in variance, the power of noise in these ascending `bins` of a spectrum over
    whole `periods` scatters than if each bin had noise of its own; 1 where too few tell it.

    What flickers at one place of the period, as a sample at the edge of a converter's step does, has a value
    in each period and so the spectrum of these few values, again between each pair of harmonics. The
    covariance of the powers of two bins is the square of that of their phasors, which depends on their
    distance in orders alone: it is the Fourier transform of the noise's power over the period.
    """
    # next to harmonics it may be these, which move
    beside = min(periods // 4, max(1, (periods - _FEWEST) // 2))
    inner = slice(beside, periods - beside)
    first, last = -(-int(bins[0]) // periods), int(bins[-1]) // periods
    orders, columns = last - first, inner.stop - inner.start
    if orders < _FEWEST or columns < _FEWEST:
        return 1.0
    between = phasor[first * periods : last * periods].reshape(orders, periods)[:, inner]
    power = np.mean(np.square(np.abs(between)), axis=1)
    together = np.sum(_correlation(between), axis=1)[1:orders]
    as_powers, as_amplitudes = (_correlation(each)[:orders].real for each in (power, np.sqrt(power)))
    if not as_powers[0] > 0.0:
        return 1.0
    alike, by_chance = np.square(np.abs(together) / columns), as_powers[1:] / columns
    weight = as_powers[1:] / np.maximum(np.square(as_amplitudes[1:]), _TINY * as_powers[0])
    more = float(weight @ (alike - by_chance))
    if more < _CLEARLY * float(np.linalg.norm(weight * by_chance)):  # in few orders by chance
        return 1.0
    return 1.0 + 2.0 * more / float(as_powers[0])


def _correlation(of_orders: NDArray[Any]) -> NDArray[np.complex128]:
    """Return the sums over orders of the products with what is so many orders on, shape (2 orders, ...)."""
    square = np.square(np.abs(fft.fft(of_orders, 2 * len(of_orders), axis=0)))
    return np.asarray(fft.ifft(square, axis=0))
