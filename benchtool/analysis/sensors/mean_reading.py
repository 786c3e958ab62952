"""The mean of a channel's readings, and what the steps of its converter leave in it.

Readings that are all the same are off by anything up to half a step, and do not show how large that is.
Others show the step; what moves within it, noise or a ripple, averages some of its error out (Widrow and
Kollár, Quantization Noise, 2008, ch. 4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.read_noise import error_of_mean
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.sensors.waveform import Waveform, by_steps
from benchtool.analysis.uncertainty import Contribution
from benchtool.block import Channel

_FEWEST: Final = 16  # readings that tell a waveform
_ROUNDING: Final = 1e-9  # of the largest: readings that differ by less are the same


@dataclass(frozen=True)
class MeanReading:
    """`mean` of readings of a channel; `of_steps` is the standard uncertainty that their steps leave in it,
    not a number where all are the same."""

    channel: str
    unit: str
    mean: float
    of_steps: float

    @classmethod
    def of(cls, channel: Channel, readings: NDArray[np.float64], rate_Hz: float) -> Self:
        """Return that of even samples, shape (n,)."""
        mean, of_steps = float(np.mean(readings)), _of_steps(readings, rate_Hz)
        return cls(channel.name, channel.unit, mean, of_steps)

    @property
    def is_resolved(self) -> bool:
        """Whether the readings show their resolution."""
        return math.isfinite(self.of_steps)

    @property
    def unresolved(self) -> tuple[Channel, ...]:
        """The channel, where its readings do not show their resolution."""
        return () if self.is_resolved else (Channel(self.channel, self.unit),)

    def line(self, factor: float = 1.0) -> tuple[Contribution, ...]:
        """Return the line of a budget in which the mean counts `factor` times; none where the readings show
        no steps."""
        if not self.of_steps > 0.0:
            return ()
        return (Contribution(f"resolution of {self.channel}", "B", abs(factor) * self.of_steps),)


def _of_steps(readings: NDArray[np.float64], rate_Hz: float) -> float:
    if float(np.ptp(readings)) <= _ROUNDING * float(np.max(np.abs(readings))):
        return math.nan
    step = counting_step(readings)
    if not step > 0.0:
        return 0.0
    at_rest = error_of_mean(readings, step)
    if len(readings) < _FEWEST:
        return at_rest
    # what oscillates averages less of it out than noise of the same power
    return max(at_rest, by_steps(Waveform(readings, rate_Hz), step, lambda of: of.mean))
