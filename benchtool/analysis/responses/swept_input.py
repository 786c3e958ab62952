"""Noise of an input that sweeps, by what it holds at a frequency while the sweep is at others.

Noise of the input lowers H1 = S_xy / S_xx, and noise that a loop feeds back to it draws H1 towards -1 over
the controller. Of a sweep both show: it passes each frequency once, and what input and output have there
before and after is noise, with a response of its own. Stationary noise has no such times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

_MOST = 0.1  # share of noise in the input's power up to which a response is corrected for it
_ALIKE = 0.3  # of a response: what is quiet excites as the sweep does
_PARTS = 32  # half overlapping, of the record
_NEAR = 5  # bins of a part that are taken together
_SLOW = 8  # lowest bins of a part, into which what is left of its mean leaks: as the next above them
_FEWEST_ROWS = 64  # of a part
_QUIET = 4.0  # times the lower quartile of the power of the parts: up to there the sweep is elsewhere
_LEAKS = 1e-9  # share of its power that a sweep leaks to all frequencies
_STATIONARY = 0.5  # share that is quiet, of an input that does not sweep

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class InputNoise:
    """Share of noise in the power of the input, and the response of the output to it, both of shape (m,)."""

    share: Floats
    response: Complex

    @property
    def is_little(self) -> NDArray[np.bool_]:
        """Where a response can be corrected."""
        return np.asarray(self.share < _MOST)

    def excites(self, response: Complex) -> bool:
        """Return whether it has the response of the sweep, and so is no noise of the input but a part of what
        excites."""
        here = self.is_little & (self.share > 0.0)
        if not np.any(here):
            return False
        apart = np.abs(self.response[here] - response[here]) / np.abs(response[here])
        return bool(np.median(apart) < _ALIKE)

    def corrected(self, response: Complex) -> Complex:
        """Return a response, shape (m,), as it would be without the noise: (S_xy - N_xy) / (S_xx - N_xx)."""
        share = np.minimum(self.share, _MOST)
        return np.asarray(response + share / (1.0 - share) * (response - self.response))


def input_noise(x: Floats, y: Floats, at: Floats) -> InputNoise | None:
    """Return the noise in an input at frequencies `at`, in cycles per sample, shape (m,); None if the input
    does not sweep, is at each frequency not quiet most of the time, or is too short."""
    from scipy import ndimage

    size = 2 * (len(x) // (_PARTS + 1))
    if size < _FEWEST_ROWS:
        return None
    of_x, of_y = _parts(x, size), _parts(y, size)
    power = _smooth(np.abs(of_x) ** 2)
    quiet = power <= _QUIET * np.quantile(power, 0.25, axis=0)
    count = np.maximum(np.count_nonzero(quiet, axis=0), 1)
    noise = np.sum(power * quiet, axis=0) / count
    cross = np.sum(_smooth(np.conj(of_x) * of_y) * quiet, axis=0) / count
    mean = np.mean(power, axis=0)
    tiny = np.finfo(np.float64).tiny
    # at the edge of the sweep the neighbours hold less of it, or nothing
    share = ndimage.maximum_filter1d(noise / np.maximum(mean, tiny), _NEAR, mode="nearest")
    if not float(np.sum(mean * share)) < _STATIONARY * float(np.sum(mean)):
        return None
    response = cross / np.maximum(noise, tiny)
    places = np.arange(1.0, size // 2)[_SLOW:] / size
    real, imaginary, shares = (
        np.interp(at, places, each[_SLOW:]) for each in (response.real, response.imag, share)
    )
    return InputNoise(np.where(shares > _LEAKS, shares, 0.0), np.asarray(real + 1j * imaginary))


def _parts(samples: Floats, size: int) -> Complex:
    """Return the DFTs of half-overlapping parts under a Blackman-Harris window, less their means, dc and
    Nyquist left out: of a sweep at other frequencies next to nothing leaks in."""
    from scipy import signal

    parts = np.lib.stride_tricks.sliding_window_view(samples, size)[:: size // 2]
    window = signal.windows.blackmanharris(size, sym=False)
    return np.asarray(fft.rfft((parts - np.mean(parts, axis=1, keepdims=True)) * window, axis=1)[:, 1:-1])


def _smooth(bins: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Return means over neighbouring bins."""
    from scipy import ndimage

    return np.asarray(ndimage.uniform_filter1d(bins, _NEAR, axis=1, mode="nearest"))
