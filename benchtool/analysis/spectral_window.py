"""Windows as sums of cosines, periodic, for spectra by the discrete Fourier transform.

scipy.signal has them too, and draws in scipy.stats and half a second of imports with them.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

WindowName = Literal["hann", "flattop"]

# a_k of sum a_k cos(k phi), phi from -pi to pi over the record: Harris, Proc. IEEE 66 (1978) no. 1,
# and, of the flat top, D'Antona and Ferrero, Digital Signal Processing for Measurement Systems (2006), p. 70.
_COEFFICIENTS: dict[WindowName, tuple[float, ...]] = {
    "hann": (0.5, 0.5),
    "flattop": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}

_ON_POLE = 1e-7  # bins


def spectral_window(name: WindowName, count: int) -> NDArray[np.float64]:
    """Return the weights of `count` samples, shape (count,)."""
    phi = np.linspace(-np.pi, np.pi, count + 1)
    weights = np.zeros(count + 1)
    for k, coefficient in enumerate(_COEFFICIENTS[name]):
        weights += coefficient * np.cos(k * phi)
    return weights[:-1] if count > 1 else np.ones(count)


def hann_response(apart: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return the response of a Hann window of many samples at distances in bins from a line, relative to its
    crest, with the phase as in the middle of the record: sinc(d) / (1 - d^2), which is 1/2 at d = 1 (Harris,
    section IV)."""
    pole = np.abs(np.abs(apart) - 1.0) < _ON_POLE
    away = np.where(pole, apart + 2.0 * _ON_POLE, apart)
    return np.asarray(np.sinc(away) / (1.0 - away**2))


def interpolated(size: NDArray[np.float64], place: int) -> tuple[float, float]:
    """Return how far a line is from its greatest bin, in bins, half of one at most, and the ratio of the
    second greatest to it."""
    side = 1 if size[place + 1] > size[place - 1] else -1
    ratio = float(size[place + side] / size[place]) if size[place] > 0.0 else 0.0
    return side * max(-0.5, (2.0 * ratio - 1.0) / (1.0 + ratio)), ratio


def line_at(size: NDArray[np.float64], place: int) -> tuple[float, float]:
    """Return how far a line is from its greatest bin, in bins, and its amplitude, by the response of a Hann
    window at that distance."""
    offset, _ = interpolated(size, place)
    return offset, float(size[place] / hann_response(offset))
