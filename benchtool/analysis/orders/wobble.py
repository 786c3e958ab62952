"""Wobble of a rotor's angle about a smooth track, and what it does to orders.

On an angle that errs by e sin(m theta), or in time along a smooth track about which the rotor moves by that,
an order k of amplitude A reads A (1 - (k e)^2 / 4), and k - m and k + m have sidebands of k A e / 2 (phase
modulation, Abramowitz and Stegun 9.1.42 for a small index).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_TURN = 2.0 * np.pi
_SECTORS = 72
_ROWS_PER_SECTOR = 4.0
_COUNTS_PER_SECTOR, _APART_RAD = 2.0, 1e-6  # of an angle; nearer ones are one, but for rounding
_HIGHEST = 3  # sectors in a period of the highest order told


@dataclass(frozen=True)
class Wobble:
    """`rms_rad` of an angle's deviation, and the peak `amplitude_rad` of the orders 1, 2, 3 ... of what of it
    repeats every revolution, shape (m,).

    Whether the angle errs or the rotor moves by that the angle does not tell. Where it acts on the orders,
    these show it: of one that has no sidebands nothing is lost.
    """

    rms_rad: float = 0.0
    amplitude_rad: Floats = field(default_factory=lambda: np.zeros(0))

    def lost(self, amplitude: Floats) -> Floats:
        """Return by how much it lowers the amplitudes of orders 1, 2, 3 ..., to second order: of what repeats
        no more than the power of both sidebands over twice the amplitude."""
        order = np.arange(1, len(amplitude) + 1)
        rest2 = max(0.0, self.rms_rad**2 - 0.5 * float(np.sum(self.amplitude_rad**2)))
        lost = 0.5 * amplitude * (order * order) * rest2
        below, above = self._beside(amplitude**2)
        shown = 0.5 * (below + above) / np.maximum(amplitude, np.finfo(float).tiny)
        for each_rad, sidebands in zip(self.amplitude_rad, shown, strict=True):
            lost += np.minimum(0.25 * amplitude * (order * each_rad) ** 2, sidebands)
        return np.asarray(np.minimum(amplitude, lost))

    def beside(self, amplitude: Floats) -> Floats:
        """Return the sidebands that all orders have at each of the orders 1, 2, 3 ..., no more than what is
        there: root of the sum of their squares, as their phases are not those of the orders."""
        below, above = self._beside((np.arange(1, len(amplitude) + 1) * amplitude) ** 2)
        sidebands2 = 0.25 * self.amplitude_rad**2 @ (below + above)
        return np.asarray(np.minimum(np.sqrt(sidebands2), amplitude))

    def _beside(self, power: Floats) -> tuple[Floats, Floats]:
        """Return a power, shape (orders,), at as many orders below and above each order as the deviation has,
        both of shape (m, orders); a negative order is the same as its positive one."""
        order = np.arange(1, len(power) + 1)
        apart = np.arange(1, len(self.amplitude_rad) + 1)[:, np.newaxis]
        padded = np.concatenate(([0.0], power, np.zeros(len(self.amplitude_rad))))
        return padded[np.abs(order - apart)], padded[order + apart]


def repeated_wobble_rad(angle_rad: Floats, deviation_rad: Floats) -> Floats:
    """Return the peak amplitudes of the orders of a deviation that are the same in every revolution.

    Both have shape (n,), the angle without wraps. What the scatter between revolutions explains, as of a
    speed that swings, is taken off; of fewer than two whole revolutions there are none. An angle in few
    counts is in no sector between them.
    """
    turn = np.floor((angle_rad - angle_rad.min()) / _TURN).astype(np.int64)
    within = np.mod(angle_rad, _TURN)
    counts = len(np.unique(np.round(within / _APART_RAD)))
    sectors = int(
        min(_SECTORS, len(angle_rad) / (turn.max() + 1) / _ROWS_PER_SECTOR, counts / _COUNTS_PER_SECTOR)
    )
    if sectors < _HIGHEST:
        return np.zeros(0)
    place = within * (sectors / _TURN)
    cell = turn * sectors + np.floor(place).astype(np.int64) % sectors
    length = int(turn.max() + 1) * sectors
    rows = np.bincount(cell, minlength=length)
    sums = np.bincount(cell, weights=deviation_rad, minlength=length)
    whole = np.all(rows.reshape(-1, sectors) > 0, axis=1)
    if np.count_nonzero(whole) < 2:
        return np.zeros(0)
    means = sums.reshape(-1, sectors)[whole] / rows.reshape(-1, sectors)[whole]
    order = np.arange(1, sectors // _HIGHEST + 1)
    lines = 2.0 / sectors * np.fft.rfft(means, axis=1)[:, order] / np.sinc(order / sectors)
    mean2 = np.abs(lines.mean(axis=0)) ** 2
    return np.asarray(np.sqrt(np.maximum(0.0, mean2 - np.var(lines, axis=0) / (len(lines) - 1))))
