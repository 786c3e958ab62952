"""Corrections of numbers for the bandwidth of their sensors (JCGM 100:2008, 3.2.3, 3.2.4 and 6.3.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from benchtool.analysis.measurement import Correction, Measurement
from benchtool.analysis.sensors.lag import Estimate, Lag
from benchtool.analysis.uncertainty import Contribution, InstrumentError, Uncertainty, coverage_factor
from benchtool.profile import Sensor

BANDWIDTH: Final = "bandwidth"
"""`InstrumentError.effect` of what a sensor's lag takes off."""

_MOST_ENLARGED: Final = 2.0  # times the reading, by a response that is known


@dataclass(frozen=True)
class Effect:
    """What the bandwidth of a sensor, or of the three of the phases, has done to a number.

    `bandwidth` says whose it is, `of` also what is known of it, a guarantee or its response; `estimate` is
    the number as it was before, `scatter` the uncertainty by the data of one measured so.
    """

    bandwidth: str
    of: str
    estimate: Estimate
    error: InstrumentError
    is_guarantee: bool
    scatter: Uncertainty | None = None

    @classmethod
    def of_sensors(
        cls,
        sensors: Mapping[str, Sensor],
        lag: Lag,
        estimate: Estimate,
        scatter: Uncertainty | None = None,
    ) -> Effect:
        """By the sensors of channels; `lag` is what is known of their responses."""
        names = ", ".join(bandwidth_of(channel, sensor) for channel, sensor in sensors.items())
        identity = {
            key: ", ".join(filter(None, (getattr(sensor, key) for sensor in sensors.values())))
            for key in ("sensor", "serial_number", "certificate")
        }
        error = InstrumentError(BANDWIDTH, ", ".join(sensors), **identity)
        bandwidth = f"bandwidth of {names}"
        return cls(bandwidth, f"{bandwidth}; {lag.text}", estimate, error, lag.tolerance is None, scatter)


def corrected(
    read: Measurement, effects: Sequence[Effect], *, proportional: bool, falls: bool
) -> tuple[Measurement, tuple[Contribution, ...]]:
    """Return a number as it was before the sensors, and what is not known of that.

    What scatters in a `proportional` number, an amplitude or a ratio of some, is enlarged as the number is.
    Of one that a sensor may have taken almost whole the reading is left, without an uncertainty, and so of
    one that `falls` with what a sensor takes off where that is more than is left: so far beyond its bandwidth
    no sensor is known to follow a lag. One that sensors of known responses may have added, as an unbalance,
    is known to be no more than that.
    """
    added = sum(each.estimate.value - read.value for each in effects)
    lines = tuple(_contribution(each, read.value) for each in effects)
    if not effects:
        return read, ()
    value, by_sensors = read.value + added, math.hypot(*(each.standard for each in lines))
    names = ", ".join(each.of for each in effects)
    enlarges = next((each.estimate.enlarges for each in effects if each.estimate.enlarges), None)
    is_guarantee = any(each.is_guarantee for each in effects)
    may_be_all = is_guarantee or enlarges is None
    unknown = may_be_all and coverage_factor(math.inf) * by_sensors >= abs(value) > 0.0
    taken = falls and abs(value) > _MOST_ENLARGED * abs(read.value)
    if proportional and (unknown or taken):
        bandwidths = ", ".join(each.bandwidth for each in effects)
        why = f"the sensor may have changed it by as much as is left ({bandwidths})"
        if is_guarantee:
            why += ": state bandwidth_tolerance_percent, if its response is known"
        elif taken:
            why = (
                f"the sensor takes off more than it leaves, this is as read ({bandwidths}): use a faster one"
            )
        return _as_read(read, why), ()
    before = [each.scatter for each in effects if each.scatter is not None]
    uncertain = max(before, key=lambda each: each.standard, default=read.uncertainty)
    if uncertain is not None and proportional and read.value:
        uncertain = uncertain.scaled(value / read.value if enlarges is None else enlarges)
    correction = Correction(added, names) if added else None
    return replace(read, value=value, uncertainty=uncertain, correction=correction), lines


def _as_read(read: Measurement, why: str) -> Measurement:
    """Return a number that is not corrected, beside the reason for which it had no uncertainty before."""
    reason = "; ".join(filter(None, (read.uncertainty_reason, why)))
    return replace(read, uncertainty=None, uncertainty_reason=reason)


def bandwidth_of(channel: str, sensor: Sensor) -> str:
    """Return the bandwidth and whose it is, in words."""
    label = f" ({sensor.label})" if sensor.label else ""
    return f"{sensor.bandwidth_Hz:g} Hz of {channel}{label}"


def _contribution(effect: Effect, read: float) -> Contribution:
    rises = effect.estimate.value >= read
    return Contribution(
        effect.of, "B", effect.estimate.standard, instrument=effect.error, sign=1 if rises else -1
    )
