"""Noise between harmonics by its place in the period: of few places it is the same from order to order."""

from __future__ import annotations

import numpy as np
from numpy import fft
from numpy.typing import NDArray

_FEWEST = 8  # orders, and bins of each


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
    places = np.square(np.abs(fft.fft(between, 2 * orders, axis=0)))
    alike = fft.ifft(np.sum(places, axis=1))[:orders]
    if not alike[0].real > 0.0:
        return 1.0
    share = 1.0 - np.arange(1, orders) / orders  # of the orders that have another at such a distance
    squares = np.square(np.abs(alike[1:]) / alike[0].real) / share
    return max(1.0, 1.0 + 2.0 * float(np.sum(squares - 1.0 / (orders * columns))))
