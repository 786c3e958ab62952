"""Whether a wobble of a measured angle about a smooth track is the rotor's or an error of the angle's sensor.

Along a phase that is off by x rad rms, order k of a signal reads low by exp(-k^2 x^2 / 2). So the angle
along which the orders of a signal are the larger, by as much as the other one is off, is the rotor's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.order_spectrum import OrderSpectrum
from benchtool.analysis.orders.wobble import Wobble
from benchtool.analysis.periods import PhaseTrack

_MOST_ORDERS = 8
_TOLD, _MOST = 0.5, 2.0  # of what a wobble takes off the orders


@dataclass(frozen=True)
class WobbleSource:
    """How much more of what a wobble takes off the orders they lose along the smooth track than along the
    angle, as a `share` of both together: 1 where it is the rotor's, -1 where it is the sensor's, 0 where
    nothing tells. The angle is off the track by `wobble_rad`, rms.
    """

    share: float = 0.0
    wobble_rad: float = 0.0

    @property
    def is_rotor(self) -> bool:
        return self.share > _TOLD

    @property
    def is_sensor(self) -> bool:
        return self.share < -_TOLD

    def with_what_is_told(self, spectrum: OrderSpectrum) -> OrderSpectrum:
        """Return orders along the angle that was chosen, without what the wobble does along the other one."""
        if not self.is_rotor and not self.is_sensor:
            return spectrum
        untold = 0.5 * abs(1.0 - abs(self.share))
        lost = Wobble(self.wobble_rad).lost(spectrum.amplitude)
        # of a part of the wobble only what is in phase with all of it is told: it is between that and all
        return spectrum.with_wobble(untold * lost, math.sqrt(untold) * spectrum.beside)


def source_of_wobble(
    samples: NDArray[np.float64], track: PhaseTrack, spectrum: OrderSpectrum
) -> WobbleSource:
    """Return where a wobble of the measured angle about a smooth mechanical track comes from, by the orders
    of samples, shape (n,), that may lose more to it than noise makes of them.

    `spectrum` has these along either angle.
    """
    if track.measured_rad is None:
        return WobbleSource()
    rows = np.arange(track.samples, dtype=np.float64)
    phase_rad = track.at(rows)
    may_lose = Wobble(float(np.std(track.measured_rad - phase_rad))).lost(spectrum.amplitude)
    strongest = np.argsort(-may_lose)[:_MOST_ORDERS]
    others2 = spectrum.standard**2 - spectrum.lost**2 - spectrum.beside**2
    orders = spectrum.order[strongest[may_lose[strongest] ** 2 > others2[strongest]]]
    if not len(orders):
        return WobbleSource()
    turns = (phase_rad - phase_rad[0]) / (2.0 * np.pi)
    whole = slice(0, int(np.searchsorted(turns, np.floor(turns[-1]))))
    weights = np.gradient(turns[whole]) / np.floor(turns[-1])
    weighted = 2.0 * weights * (samples[whole] - np.average(samples[whole], weights=weights))
    smooth, measured = (
        np.array([abs(np.exp(-1j * order * along[whole]) @ weighted) for order in orders])
        for along in (phase_rad, track.measured_rad)
    )
    deviation_rad = track.measured_rad[whole] - phase_rad[whole]
    off_rad = float(np.std(deviation_rad))
    # what is left of an order depends on the course of the wobble where that is no small part of a period
    left = np.array(
        [abs(np.average(np.exp(1j * order * deviation_rad), weights=weights)) for order in orders]
    )
    expected = np.maximum(smooth, measured) * (1.0 - left)
    more = measured - smooth
    own = np.abs(more) < _MOST * expected  # and not what the wobble makes of another order
    if not np.any(own):
        return WobbleSource()
    return WobbleSource(float(expected[own] @ more[own] / (expected[own] @ expected[own])), off_rad)
