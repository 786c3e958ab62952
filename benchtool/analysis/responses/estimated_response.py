"""What an estimate of a frequency response consists of, and where it can be used.

Errors are absolute where they come from the noise, and relative to the gain where the response is read.
Relative to the gain found, an error is small where the noise happens to enlarge the gain: frequencies picked
or weighted by it have too large a gain on average. What picks and weights is relative to the geometric mean
of neighbouring gains, which hardly depends on the noise of one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.responses.local_polynomial import REACH
from benchtool.block import read_only

COHERENT = 0.8
"""Least coherence of a frequency that is used; higher where averages are few."""

EXCITED = 1e-5
"""Least input power of a frequency that is used, of the greatest there is: 50 dB below it."""

WELL_EXCITED = 1e-2
"""Least input power, of the greatest, of the frequency that gives the reference gain."""

NO_NOISE = 20.0
"""Power of a mean over what noise leaves in it: reached by chance once in e^20, and the bias of a ratio to
it."""

NEPER_DB = 20.0 / math.log(10.0)
"""dB of a small relative change of a gain, over that change."""

_BY_CHANCE = 0.05  # probability that noise alone passes for coherent at one of all frequencies
_LINE = 3.0  # times the noise of its neighbours: a disturbance at one frequency
_OF_GOING_ON = 0.5  # of the change of phase as far below: what is expected of the next
_ROUNDING = 1e-9  # of a distance of frequencies
_NOTHING_KNOWN = 1e9  # relative error
_EVEN = 0.05  # relative error of a mean of neighbouring gains that picks none by chance


@dataclass(frozen=True)
class FrequencyResponse:
    """Response at `frequency_Hz`, dc left out; every array has shape (bins,) and is read-only.

    `response` is output over input, complex; `error` the standard uncertainty of its gain relative to the
    gain, and of its phase in rad; `shared` is how many of these frequencies rest on the same bins and tell as
    much as one; `trusted` where the input has power and the coherence is high enough.
    `averages` is the number of independent spectra (of a fit, its degrees of freedom and one), `samples` how
    many samples they cover, and `method` says in words how they were made. `excited` are the frequencies
    where the input has power that is not noise, and `well_excited` those with more than a hundredth of its
    greatest. `at_rest` is an error of the gain, relative to it, that all low frequencies have in common.
    """

    frequency_Hz: NDArray[np.float64]
    response: NDArray[np.complex128]
    coherence: NDArray[np.float64]
    error: NDArray[np.float64]
    shared: NDArray[np.float64]
    excited: NDArray[np.bool_]
    well_excited: NDArray[np.bool_]
    averages: float
    samples: int
    method: str
    at_rest: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value))

    @property
    def least_coherence(self) -> float:
        """What is asked of a frequency: 0.8, or what noise reaches at one of them in a response of twenty.

        Of n averages, independent signals exceed a coherence c with probability (1 - c)^(n - 1) (Carter,
        Proc. IEEE 75 (1987) no. 2).
        """
        share = _BY_CHANCE / len(self.coherence)
        return max(COHERENT, 1.0 - math.pow(share, 1.0 / (self.averages - 1.0)))

    @cached_property
    def trusted(self) -> NDArray[np.bool_]:
        """Where the input has power, the output any, and the even error amounts to no less coherence than is
        asked."""
        coherence = coherence_of(self.even_error, self.averages)
        trusted: NDArray[np.bool_] = self.excited & (self.gain > 0.0) & (coherence >= self.least_coherence)
        trusted.setflags(write=False)
        return trusted

    @cached_property
    def even_error(self) -> NDArray[np.float64]:
        """Errors relative to the geometric mean of as many neighbouring gains as make that sure.

        Errors relative to the gains themselves would pick, and prefer, those that noise has made larger.
        """
        places = np.flatnonzero(self.excited)
        gain, error = np.abs(self.response[places]), self.error[places]
        spread = gain * error
        log_gain = np.log(np.maximum(gain, np.maximum(_EVEN * spread, np.finfo(np.float64).tiny)))
        total = np.concatenate([[0.0], np.cumsum(log_gain)])
        index = np.arange(len(places))
        even = np.exp(log_gain)
        for reach in range(1, REACH + 1):
            # no further than the neighbours in frequency, and as far on both sides
            room = np.minimum(np.minimum(index, len(places) - 1 - index), reach)
            near = places[index + room] - places[index - room] <= 2 * REACH
            mean = np.exp((total[index + room + 1] - total[index - room]) / (2.0 * room + 1.0))
            unsure = spread > _EVEN * np.sqrt(2.0 * reach - 1.0) * even
            even = np.where(near & unsure, mean, even)
        result = np.array(self.error)
        result[places] = spread / even
        return result

    @property
    def reference(self) -> int:
        """Index of the frequency whose gain the others are compared with.

        The lowest that is trusted and well excited, with an error of at most 1 % or three times the median of
        the trusted; the lowest trusted if there is none such.
        """
        trusted, error = self.trusted, self.even_error
        largest = max(0.01, 3.0 * float(np.median(error[trusted]))) if np.any(trusted) else 0.0
        known = trusted & self.well_excited & (error <= largest)
        return int(np.argmax(known if np.any(known) else trusted))

    @property
    def error_of_many(self) -> NDArray[np.float64]:
        """Errors to use where the frequencies are combined as if their errors were uncorrelated."""
        return np.asarray(self.even_error * np.sqrt(self.shared))

    @property
    def gain(self) -> NDArray[np.float64]:
        return np.abs(self.response)

    @property
    def gain_dB(self) -> NDArray[np.float64]:
        return decibels(self.response)

    @property
    def phase_rad(self) -> NDArray[np.float64]:
        """Phase without jumps between trusted frequencies, the first within +-pi; nan at the others."""
        phase = np.full(len(self.response), math.nan)
        phase[self.trusted] = without_jumps(self.frequency_Hz[self.trusted], self.response[self.trusted])
        return phase


def without_jumps(frequency_Hz: NDArray[np.float64], response: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the phase of a response, shape (n,), without jumps; the first is within +-pi.

    Between two frequencies it changes by what is nearest to half of how it went on over as far below them: of
    a delay between few frequencies it may change by more than half a turn, and at a pole it goes on no more.
    """
    phase = np.angle(response)
    # the next frequency is as far above each as that which its slope is taken from is below it
    apart = np.append(np.diff(frequency_Hz), 0.0)
    below = np.searchsorted(frequency_Hz, frequency_Hz - apart * (1.0 - _ROUNDING), side="right") - 1
    below = np.maximum(np.minimum(below, np.arange(len(phase)) - 1), 0)
    for at in range(len(phase) - 1):
        far, from_Hz = below[at], frequency_Hz[at] - frequency_Hz[below[at]]
        slope = (phase[at] - phase[far]) / from_Hz if from_Hz > 0.0 else 0.0
        expected = phase[at] + _OF_GOING_ON * slope * apart[at]
        phase[at + 1] -= 2.0 * math.pi * round((phase[at + 1] - expected) / (2.0 * math.pi))
    return phase


def decibels(ratio: NDArray[np.complex128] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the magnitude of ratios in dB; zero counts as the smallest positive number."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(ratio), np.finfo(np.float64).tiny)))


def coherence_of(error: NDArray[np.float64], averages: float) -> NDArray[np.float64]:
    """Return the coherence that relative errors amount to: c of sqrt((1 - c) / (2 (n - 1) c))."""
    known = np.minimum(error, _NOTHING_KNOWN)  # the square of more may be none
    return np.asarray(1.0 / (1.0 + 2.0 * (averages - 1.0) * known**2))


def noise_power(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power of the noise at every frequency, shape (bins,), estimated from few averages.

    At one frequency it scatters, and a fit that weights by it would follow where it is small by chance: the
    mean of a frequency and its neighbours, or its own where that stands out as a line does.
    """
    from scipy import ndimage

    mean = ndimage.uniform_filter1d(found, min(2 * REACH + 1, len(found)), mode="nearest")
    return np.asarray(np.where(found > _LINE * mean, found, mean))
