"""What a spectrum reads where nothing periodic is: the noise floor, and what it does to an amplitude."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.spectrum import CoherentSpectrum

_FEWEST_BINS = 8
_LOCAL_BINS = 20  # at least, around each harmonic

MEDIAN_OF_RMS = math.sqrt(math.log(2.0))
"""Median of Rayleigh-distributed amplitudes over their rms, 0.8326.

Their distribution is P(A < a) = 1 - exp(-a^2 / rms^2) (Papoulis, Probability, Random Variables, and
Stochastic Processes, 4th ed., 6.2), which is one half at a = rms sqrt(ln 2).
"""


@dataclass(frozen=True)
class NoiseFloor:
    """Noise between the harmonics of a spectrum, in the signal's unit.

    `amplitude` is the rms over `bins` bins of their peak amplitude, estimated from the median, so that lines
    in less than half of the bins do not count; `density` is rms per sqrt(Hz). A strong interharmonic leaks
    through the rectangular window into all bins around it, and with that counts as noise.
    """

    amplitude: float
    density: float
    bins: int

    @property
    def standard(self) -> float:
        """Standard uncertainty that the noise gives the amplitude of a line well above it.

        Of the two components of the noise, each of rms `amplitude` / sqrt(2), only the one in phase with the
        line changes its length.
        """
        return self.amplitude / math.sqrt(2.0)

    @property
    def relative_error(self) -> float:
        """Relative standard uncertainty of the floor itself: 1 / (2 ln 2 sqrt(bins)).

        The median of n values scatters by 1 / (2 f sqrt(n)), f the density at the median (Kendall and
        Stuart, The Advanced Theory of Statistics, vol. 1, 10.10), here ln 2 / median.
        """
        return 1.0 / (2.0 * math.log(2.0) * math.sqrt(self.bins))


def noise_floor(
    spectrum: CoherentSpectrum, first_order: float = 0.0, last_order: float = math.inf
) -> NoiseFloor | None:
    """Noise floor from the bins between two orders that are no harmonic; None if they are fewer than eight.

    Where there are four periods or more, the bins next to dc and to a harmonic are left out too: a harmonic
    that is not quite steady spreads there.
    """
    between = _between(spectrum, first_order, last_order)
    if len(between) < _FEWEST_BINS:
        return None
    amplitude = float(np.median(between)) / MEDIAN_OF_RMS
    bin_Hz = spectrum.fundamental_Hz / spectrum.periods
    return NoiseFloor(amplitude, amplitude / math.sqrt(2.0 * bin_Hz), len(between))


def harmonic_noise(spectrum: CoherentSpectrum, orders: int) -> NDArray[np.float64]:
    """Standard uncertainty of the amplitudes of harmonics 1 to `orders`, shape (orders,), nan if unknown.

    Each from the floor around it, because the noise of a drive is not white: from as many orders to either
    side as hold twenty bins.
    """
    per_order = max(1, spectrum.periods - 2 * _guard(spectrum) + 1)
    reach = math.ceil(_LOCAL_BINS / (2 * per_order))
    floors = (noise_floor(spectrum, order - reach, order + reach) for order in range(1, orders + 1))
    return np.array([math.nan if floor is None else floor.standard for floor in floors])


def _guard(spectrum: CoherentSpectrum) -> int:
    """Bins from a harmonic to the nearest that counts as being between harmonics."""
    return 2 if spectrum.periods >= 4 else 1


def _between(spectrum: CoherentSpectrum, first_order: float, last_order: float) -> NDArray[np.float64]:
    periods, count = spectrum.periods, len(spectrum.amplitude)
    first = max(0, math.floor(first_order))
    last = math.ceil(min(last_order, count / periods))
    guard = _guard(spectrum)
    whole = spectrum.amplitude[first * periods : min(count, last * periods)]
    orders = len(whole) // periods
    table = whole[: orders * periods].reshape(orders, periods)[:, guard : periods - guard + 1]
    rest = whole[orders * periods :][guard : periods - guard + 1]
    return np.concatenate([table.ravel(), rest])
