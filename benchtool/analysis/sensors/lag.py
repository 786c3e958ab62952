"""What is known of the response of a sensor by its stated bandwidth, and the best estimate that follows.

A bandwidth alone is a guarantee: nothing is lost to a sensor that is much faster than stated, and as much as
to a first-order lag or to a Butterworth response of second order to one that has lost 3 dB just there. The
best estimate is the middle of all three (JCGM 100:2008, F.2.4.5), its standard uncertainty half of the
interval: the largest that a distribution within limits can have, which is that of sensors that are at one
limit or the other.

Where the response was found to be that of a first-order lag, its effect is corrected, and the uncertainty is
that of the correction by the limits of the bandwidth (6.3.1, 4.3.7).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from benchtool.profile import Sensor

Floats = NDArray[np.float64]

_ROOT_3: Final = math.sqrt(3.0)


@dataclass(frozen=True)
class Response:
    """A response that has lost 3 dB at `bandwidth_Hz`: a first-order lag, or a Butterworth one of order 2."""

    bandwidth_Hz: float
    order: Literal[1, 2] = 1

    def inverse(self, frequency_Hz: Floats | float) -> NDArray[np.complex128]:
        """Return what makes a line that was read at a frequency what it was before the sensor."""
        s = 1j * np.asarray(frequency_Hz) / self.bandwidth_Hz
        return np.asarray(1.0 + s if self.order == 1 else 1.0 + math.sqrt(2.0) * s + s**2)

    def enlarges(self, frequency_Hz: float) -> float:
        """Return the magnitude of the inverse."""
        return float(np.abs(self.inverse(frequency_Hz)))


@dataclass(frozen=True)
class Estimate:
    """A number as it was before a sensor, with the standard uncertainty that the sensor's response leaves.

    `enlarges` is set of one to which sensors add, as those that differ do to an unbalance: by it scatter is
    larger before them. Of others they take off, and scatter is in proportion to the number.
    """

    value: float
    standard: float
    enlarges: float | None = None


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

    @property
    def responses(self) -> tuple[Response, ...]:
        """Both that a guarantee allows, or the one that is known and those at its limits."""
        if self.tolerance is None:
            return Response(self.bandwidth_Hz), Response(self.bandwidth_Hz, order=2)
        factors = 1.0, 1.0 - self.tolerance, 1.0 + self.tolerance
        return tuple(Response(self.bandwidth_Hz * by) for by in factors)

    def estimate(self, read: float, before: Sequence[float]) -> Estimate:
        """Return the estimate of a number by what it was before each of `responses`."""
        if self.tolerance is None:
            least, greatest = min(read, *before), max(read, *before)
            return Estimate(0.5 * (least + greatest), 0.5 * (greatest - least))
        whole, low, high = before
        return Estimate(whole, 0.5 * abs(high - low) / _ROOT_3)
