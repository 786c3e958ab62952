"""What is known of the response of a sensor by its stated bandwidth, and the best estimate that follows.

A bandwidth alone is a guarantee. Nothing is lost to a sensor that is much faster than stated, or whose
response is flat almost up to there; most is lost to a first-order lag of just that bandwidth, and beyond it
to a Butterworth response of second order. The best estimate is the middle (JCGM 100:2008, F.2.4.5), its
standard uncertainty half of the interval: the largest that a distribution within limits can have, which is
that of sensors which are at one limit or the other.

Where the response was found to be that of a first-order lag, its effect is corrected, and the uncertainty is
that of the correction by the limits of the bandwidth (6.3.1, 4.3.7).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.profile import Sensor

_ROOT_3: Final = math.sqrt(3.0)


@dataclass(frozen=True)
class Response:
    """A first-order lag that has lost 3 dB at `bandwidth_Hz`; `at_most` is the greatest loss within a
    guarantee."""

    bandwidth_Hz: float
    at_most: bool = False

    def inverse(self, frequency_Hz: NDArray[np.float64] | float) -> NDArray[np.complex128]:
        """Return what makes a line that was read at a frequency what it was before the sensor."""
        x = np.abs(frequency_Hz) / self.bandwidth_Hz
        return np.asarray(1.0 + 1j * (np.maximum(x, x**2) if self.at_most else x))

    def enlarges(self, frequency_Hz: float) -> float:
        """Return the magnitude of the inverse."""
        return float(np.abs(self.inverse(frequency_Hz)))


@dataclass(frozen=True)
class Estimate:
    """A number as it was before a sensor, with the standard uncertainty that the sensor's response leaves."""

    value: float
    standard: float


@dataclass(frozen=True)
class Lag:
    """The bandwidth of a sensor, known within `tolerance`, relative; None where it is a guarantee."""

    bandwidth_Hz: float
    tolerance: float | None = None

    @classmethod
    def of(cls, sensor: Sensor | None) -> Lag | None:
        """Return that of a sensor; None where no bandwidth is stated."""
        if sensor is None or sensor.bandwidth_Hz is None:
            return None
        percent = sensor.bandwidth_tolerance_percent
        return cls(sensor.bandwidth_Hz, None if percent is None else 0.01 * percent)

    @property
    def text(self) -> str:
        """What was done about it."""
        if self.tolerance is None:
            return "a guarantee, half of what it may have taken off is corrected"
        return f"known within {100.0 * self.tolerance:g} %, corrected"

    def responses(self) -> tuple[Response, ...]:
        """Return the greatest loss of a guarantee, or the response that is known and both of its limits."""
        if self.tolerance is None:
            return (Response(self.bandwidth_Hz, at_most=True),)
        return tuple(
            Response(self.bandwidth_Hz * (1.0 + by)) for by in (0.0, -self.tolerance, self.tolerance)
        )

    def estimate(self, read: float, before: Callable[[Response], float]) -> Estimate:
        """Return the estimate of a number, of which `before` tells what it was before a response."""
        return best_estimate(read, [before(each) for each in self.responses()])

    def estimate_by_lags(self, read: float, once: float, twice: float) -> Estimate:
        """Return the estimate of a number that hangs on the waveform, of what it is with one and with two
        further lags; nan where it is not found with one.

        Where lags add up it is the parabola through the three: of a line at f within 0.2 % at half the
        bandwidth and 2.5 % low at the bandwidth. By how much that differs from the straight line through
        the first two enters besides. Of limits of the bandwidth a loss has at most the square.
        """
        straight = 2.0 * read - once
        whole = 3.0 * read - 3.0 * once + twice if math.isfinite(twice) else straight
        lost, bent = abs(whole - read), abs(whole - straight)
        if self.tolerance is None:
            return Estimate(0.5 * (read + whole), math.hypot(0.5 * lost, bent))
        return Estimate(whole, math.hypot(2.0 * self.tolerance * lost / _ROOT_3, bent))


def best_estimate(read: float, before: Sequence[float]) -> Estimate:
    """Return the estimate of a number by what it was before each of `Lag.responses`."""
    whole, *limits = before
    if not limits:
        return Estimate(0.5 * (read + whole), 0.5 * abs(whole - read))
    return Estimate(whole, 0.5 * abs(limits[1] - limits[0]) / _ROOT_3)
