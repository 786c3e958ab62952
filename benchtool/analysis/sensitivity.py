"""Sensitivities of measurements to the errors of the sensors that they are computed from.

An analysis declares, with each number, the derivatives that follow from its definition: a peak-to-peak value
scales with the gain and is independent of the offset, a ratio of two amplitudes of one channel is independent
of both. Others depend on the waveform, and are found by measuring again
(`benchtool.analysis.sensors.instruments.MeasureAgain`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final, Literal

OF_MEAN_STEP: Final = 1.0 / math.sqrt(12.0)
"""Standard uncertainty of a reading in steps of one (JCGM 100:2008, F.2.2.1)."""

OF_EXTREMES_STEP: Final = 1.0 / math.sqrt(6.0)
"""That of the difference of two readings."""


@dataclass(frozen=True)
class Level:
    """A mean, a time or a frequency: a bandwidth does not touch it."""


@dataclass(frozen=True)
class Line:
    """One sinusoid, whose frequency the basis states."""


@dataclass(frozen=True)
class Largest:
    """The largest of many sinusoids; the basis states its frequency and the band."""

    fundamental_Hz: float


PhaseSequence = Literal["positive", "negative", "zero"]


@dataclass(frozen=True)
class Component:
    """A symmetrical component of three phases, or what it is in percent of the positive-sequence one.

    `positive` is the amplitude of that one; the basis states the frequency.
    """

    which: PhaseSequence
    positive: float
    in_percent: bool = False


@dataclass(frozen=True)
class Harmonics:
    """Harmonics up to some frequency, each by itself, of a fundamental; `as_ratio` to its amplitude."""

    fundamental_Hz: float
    as_ratio: bool = False


@dataclass(frozen=True)
class Noise:
    """The noise between the harmonics of a fundamental."""

    fundamental_Hz: float


@dataclass(frozen=True)
class Power:
    """The power of all components together."""


@dataclass(frozen=True)
class Extremes:
    """The extremes of all components together, or the percentiles with `beyond_percent` of the samples beyond
    each."""

    beyond_percent: float = 0.0


Content = Level | Line | Largest | Component | Harmonics | Noise | Power | Extremes
"""What a number holds, which tells what a bandwidth takes off.

Where a signal is sampled too slowly, what is faster folds into the band: power keeps its sum, components do
not keep their places, and extremes are missed.
"""


class Error(StrEnum):
    """Errors of a sensor."""

    GAIN = "gain"
    OFFSET = "offset"
    RESOLUTION = "resolution"
    BANDWIDTH = "bandwidth"


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of a number by the errors of one channel.

    `gain` is that by the relative error of the gain, in the number's unit, `offset` that by the offset in the
    channel's unit. `resolution` is the standard uncertainty for each unit of the smallest step that the
    sensor shows, where no waveform tells how far its errors average out. What the errors `again` do depends
    on the waveforms, and is found by measuring again.
    """

    channel: str
    gain: float = 0.0
    offset: float = 0.0
    resolution: float = 0.0
    again: frozenset[Error] = frozenset()

    @classmethod
    def of_factor(cls, channel: str, value: float, mean: float) -> Sensitivity:
        """Return those of a number that is proportional to a channel, by the mean of that."""
        by_mean = value / mean
        return cls(channel, value, by_mean, OF_MEAN_STEP * abs(by_mean))

    def scaled(self, factor: float) -> Sensitivity:
        """Return those of so many times the number."""
        return replace(
            self, gain=factor * self.gain, offset=factor * self.offset, resolution=factor * self.resolution
        )


@dataclass(frozen=True)
class Sensitivities:
    """What errors of sensors do to a number.

    `channels` are those that it is computed from; None if it has to be measured again with all errors of the
    channels that it `rests_on`. `of_spectra` says that it is of ratios of spectra, each frequency by itself:
    then the response of a sensor can be divided out of a channel with its noise. Both follow from the
    declaration of the analysis, which adds them. `of_largest` says that it is of the line that was chosen as
    the largest of the channel, which before a sensor may be another.

    Of a symmetrical component the derivatives are the largest changes that an error causes: a magnitude near
    zero grows with an error of either sign.
    """

    channels: tuple[Sensitivity, ...] | None = None
    content: Content = Level()
    rests_on: tuple[str, ...] = ()
    of_spectra: bool = False
    of_largest: bool = False

    @property
    def is_declared(self) -> bool:
        """Whether they follow from the definition, so that the number need not be measured again."""
        return self.channels is not None and not any(each.again for each in self.channels)

    def again(self, channel: str) -> frozenset[Error]:
        """Return the errors of a channel with which the number has to be measured again."""
        if self.channels is None:
            return frozenset(Error) if channel in self.rests_on else frozenset()
        return frozenset().union(*(each.again for each in self.channels if each.channel == channel))

    def is_moved_by_steps(self, part: Sensitivity) -> bool:
        """Return whether steps of a reading move it as declared: not a frequency, nor the number of an
        order."""
        return part.resolution != 0.0 or not isinstance(self.content, Level)

    @property
    def named(self) -> tuple[str, ...]:
        """The channels whose errors count."""
        return self.rests_on if self.channels is None else tuple(each.channel for each in self.channels)

    @property
    def chosen(self) -> Sensitivities:
        """Those of the line that was chosen as the largest."""
        return replace(self, of_largest=True)

    @classmethod
    def unmoved(cls, channel: str) -> Sensitivities:
        """Return those of a number that its channel's errors do not move: a frequency, which order it is."""
        return cls((Sensitivity(channel),))

    @classmethod
    def of_mean(cls, channel: str, value: float) -> Sensitivities:
        """Return those of a mean."""
        return cls((Sensitivity(channel, value, 1.0, OF_MEAN_STEP),))

    @classmethod
    def of_line(cls, channel: str, value: float) -> Sensitivities:
        """Return those of the amplitude of a sinusoid."""
        return cls((Sensitivity(channel, value),), Line())

    @classmethod
    def of_distortion(cls, channel: str, fundamental_Hz: float) -> Sensitivities:
        """Return those of a ratio of harmonics to one another, in which a gain cancels."""
        return cls((Sensitivity(channel),), Harmonics(fundamental_Hz, as_ratio=True))

    @classmethod
    def of_rms(cls, channel: str, value: float) -> Sensitivities:
        """Return those of an rms about a mean."""
        return cls((Sensitivity(channel, value, resolution=OF_MEAN_STEP),), Power())

    @classmethod
    def of_extremes(cls, channel: str, value: float, beyond_percent: float = 0.0) -> Sensitivities:
        """Return those of a difference of two readings, such as a peak-to-peak value, with `beyond_percent`
        of the samples beyond each."""
        content = Extremes(beyond_percent)
        return cls((Sensitivity(channel, value, resolution=OF_EXTREMES_STEP),), content)


MEASURED_AGAIN: Final = Sensitivities()
"""Of a number that hangs on the waveform: a time, an overshoot, a gain."""

NO_SENSORS: Final = Sensitivities(())
"""Of a number that no error of a sensor moves, whatever the channels."""
