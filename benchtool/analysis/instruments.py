"""The errors of sensors and clock in the uncertainty of measurements (JCGM 100:2008, 4.3).

They are added here only, after the analyses: as contributions of type B, each of which names the sensor and
its certificate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.quantisation import counting_step
from benchtool.analysis.sensitivity import Declared, Found, Sensitivity, declared
from benchtool.analysis.uncertainty import Contribution, InstrumentError
from benchtool.block import Block
from benchtool.profile import Bench, Instrument, Sensor

UNSTATED: Final = "the sensors' own uncertainty is not stated"
"""Text of `Basis.sensors` for a number whose sensors the bench does not state."""

_ROOT_3 = math.sqrt(3.0)
_BY_TIME: Final[Mapping[str, float]] = {"s": 1.0, "Hz": -1.0, "A/sqrt(Hz)": 0.5}
"""Degree in the length of a tick, by the unit of a measurement."""


@dataclass(frozen=True)
class Perturbed:
    """A channel with a perturbed sensor error: (1 + gain) x reading + offset."""

    channel: str
    gain: float = 0.0
    offset: float = 0.0

    def of(self, block: Block) -> Block:
        """Return the block with that channel, or as it is if it has none."""
        if self.channel not in block.names:
            return block
        data = np.array(block.data)
        data[:, block.names.index(self.channel)] = self.reading(block.column(self.channel))
        return replace(block, data=data)

    def reading(
        self, values: np.ndarray[tuple[int], np.dtype[np.float64]]
    ) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return np.asarray((1.0 + self.gain) * values + self.offset)


MeasureAgain = Callable[[Perturbed], Iterable[Measurement]]
"""Repeats, with a perturbed channel, the measurements whose sensitivity is not declared."""


@dataclass(frozen=True)
class Instruments:
    """The sensors of one recording.

    Args:
        bench: what is stated of them.
        blocks: what was recorded with them, for the resolution that the data show.
        entries: name of a channel in the bench by the name that `sensitivity` has for it, where they differ.
        rests_on: the channels of a measurement that is not declared, by its name.
        pole_pairs, slots: of the motor, if known.
        clock_of: whose clock times the samples.
    """

    bench: Bench
    blocks: Sequence[Block] = ()
    entries: Mapping[str, str] | None = None
    rests_on: Callable[[str], Sequence[str]] = lambda _: ()
    pole_pairs: int | None = None
    slots: int | None = None
    clock_of: str = "the drive"

    def applied(
        self, measurements: Sequence[Measurement], again: MeasureAgain | None = None
    ) -> tuple[Measurement, ...]:
        """Return the measurements with the errors of their sensors in uncertainty and basis.

        A measurement without an uncertainty stays without one, since the sensors are only part of it; the
        basis states that of the sensors alone.
        """
        values = {each.name: each.value for each in measurements}
        moved = {} if again is None else self._moved(measurements, again)
        return tuple(self._applied(each, values, moved.get(each.name, ())) for each in measurements)

    def _applied(
        self, each: Measurement, values: Mapping[str, float], moved: Sequence[Contribution]
    ) -> Measurement:
        if not math.isfinite(each.value):
            return each
        found = Found(each.name, each.value, values, self.pole_pairs, self.slots)
        stated = declared(each.name)
        lines = [*moved, *self._clock(each)]
        remarks = [self._unstated(each.name, stated)]
        if stated is not None:
            lines += [line for part in stated.sensitivities for line in self._lines(part, found)]
            for part in stated.sensitivities:
                line, remark = self._bandwidth(part.channel, stated, found, each)
                lines += line
                remarks.append(remark)
        lines = [line for line in lines if line.standard != 0.0]
        if each.uncertainty is None:
            remarks.append(_of_sensors_alone(lines, each.unit))
        basis = replace(each.basis, sensors="; ".join(filter(None, remarks)))
        if each.uncertainty is None:
            return replace(each, basis=basis)
        if not all(math.isfinite(line.standard) for line in lines):
            return replace(each, basis=basis, uncertainty=None)
        return replace(each, basis=basis, uncertainty=each.uncertainty.with_instruments(lines))

    def _sensor(self, channel: str) -> Sensor | None:
        return self.bench.channels.get(self._entry(channel))

    def _entry(self, channel: str) -> str:
        return channel if self.entries is None else self.entries.get(channel, channel)

    def _unstated(self, name: str, stated: Declared | None) -> str:
        """Return the remark on a number some of whose sensors are not stated."""
        channels = self.rests_on(name) if stated is None else [each.channel for each in stated.sensitivities]
        lacking = [self._entry(each) for each in channels if self._sensor(each) is None]
        if not lacking:
            return ""
        return (
            UNSTATED
            if len(lacking) == len(channels)
            else f"the uncertainty of {', '.join(lacking)} is not stated"
        )

    def _lines(self, part: Sensitivity, found: Found) -> Iterator[Contribution]:
        """Yield the gain, offset and resolution of one channel."""
        sensor = self._sensor(part.channel)
        if sensor is None:
            return
        channel = self._entry(part.channel)
        if sensor.gain_standard > 0.0:
            yield _gain(channel, sensor, part.gain(found) * sensor.gain_standard)
        if sensor.offset_standard > 0.0:
            yield _offset(channel, sensor, part.offset(found) * sensor.offset_standard)
        if sensor.resolution:
            seen = self._resolution(channel)
            if sensor.resolution > seen:  # what the data show is in the analyses' own budgets
                rest = math.sqrt(sensor.resolution**2 - seen**2)
                text = f"resolution of {sensor.resolution:g} {sensor.unit}"
                name = f"{text}{' beyond that in the data' if seen else ''} of {_of(channel, sensor)}"
                yield Contribution(name, "B", part.resolution(found) * rest)

    def _resolution(self, channel: str) -> float:
        """Return the step that the analyses found in a channel; 0 if none is coarse enough to be one."""
        for block in self.blocks:
            if channel in block.names:
                return counting_step(block.column(channel))
        return 0.0

    def _bandwidth(
        self, channel: str, stated: Declared, found: Found, each: Measurement
    ) -> tuple[list[Contribution], str]:
        """Return attenuation of a line by a first-order sensor, 1 - |H(f)|, as a contribution, and a remark.

        Nothing is corrected: u is the whole attenuation over sqrt(3). For a number that contains all
        components up to some frequency, their distribution is unknown: nothing is added, and a remark states
        where the bandwidth ends below that frequency.
        """
        sensor = self._sensor(channel)
        if sensor is None or sensor.bandwidth_Hz is None or stated.bandwidth == "level":
            return [], ""
        top_Hz = _top_Hz(stated, found, each)
        of = _of(self._entry(channel), sensor)
        if stated.bandwidth != "line":
            if top_Hz <= sensor.bandwidth_Hz or not math.isfinite(top_Hz):
                return [], ""
            return [], (
                f"components are counted up to {top_Hz:.4g} Hz and the bandwidth of {of} is "
                f"{sensor.bandwidth_Hz:g} Hz: what is above is attenuated"
            )
        if not math.isfinite(top_Hz):
            return [], f"how much the bandwidth of {of} takes off is not known, as the frequency is not"
        loss = math.hypot(1.0, top_Hz / sensor.bandwidth_Hz) - 1.0
        error = _error("bandwidth", self._entry(channel), sensor)
        name = f"bandwidth of {sensor.bandwidth_Hz:g} Hz of {of}, not corrected at {top_Hz:.4g} Hz"
        return [_signed(name, found.value * loss / _ROOT_3, error)], ""

    def _clock(self, each: Measurement) -> Iterator[Contribution]:
        clock = self.bench.clock
        if clock is not None and (degree := _BY_TIME.get(each.unit, 0.0)):
            name = f"tolerance of {clock.tolerance_ppm:g} ppm of {self.clock_of}'s clock, rectangular"
            label = f": {clock.label}" if clock.label else ""
            error = _error("period", f"{self.clock_of}'s clock", clock)
            yield _signed(f"{name}{label}", degree * each.value * clock.relative_standard, error)

    def _moved(
        self, measurements: Sequence[Measurement], again: MeasureAgain
    ) -> dict[str, list[Contribution]]:
        """Return the contributions to measurements without declared sensitivities: the change for one
        standard uncertainty of each error either way, the larger of the two (JCGM 100:2008, 5.1.3, note
        2)."""
        left = {
            each.name: each.value
            for each in measurements
            if declared(each.name) is None and math.isfinite(each.value)
        }
        channels = {self._entry(each) for name in left for each in self.rests_on(name)}
        found: dict[str, list[Contribution]] = {}
        for channel, sensor in self.bench.channels.items():
            if channel not in channels:
                continue
            for error, u, line in (
                ("gain", sensor.gain_standard, _gain),
                ("offset", sensor.offset_standard, _offset),
            ):
                if u <= 0.0:
                    continue
                up, down = (
                    {each.name: each.value for each in again(Perturbed(channel, **{error: step}))}
                    for step in (u, -u)
                )
                for name, value in left.items():
                    if channel in map(self._entry, self.rests_on(name)):
                        moved = _larger(up.get(name, math.nan) - value, value - down.get(name, math.nan))
                        found.setdefault(name, []).append(line(channel, sensor, moved))
        return found


def sensor_remarks(measurements: Iterable[Measurement]) -> tuple[str, ...]:
    """Return the remarks on sensors, each once, with the number of measurements that it applies to."""
    found: dict[str, list[str]] = {}
    for each in measurements:
        if each.basis.sensors:
            found.setdefault(each.basis.sensors, []).append(each.name)
    return tuple(
        f"{text} ({names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''})"
        for text, names in found.items()
    )


def _of_sensors_alone(lines: Sequence[Contribution], unit: str) -> str:
    """Return the remark on a number whose data give no uncertainty; empty where no sensor is stated."""
    standard = math.hypot(*(line.standard for line in lines))
    if not lines or not math.isfinite(standard):
        return ""
    return f"the data give no uncertainty, that of the sensors alone is u = {standard:.2g} {unit}".rstrip()


def _larger(up: float, down: float) -> float:
    """Return the change of greater magnitude; nan if neither is known."""
    known = [each for each in (up, down) if math.isfinite(each)]
    return max(known, key=abs, default=math.nan)


def _top_Hz(stated: Declared, found: Found, each: Measurement) -> float:
    """Return the highest frequency that contributes; nan if it is unknown."""
    if stated.line_Hz is not None:
        return abs(stated.line_Hz(found))
    if each.basis.harmonics is not None:
        return each.basis.harmonics * found.other("fundamental_frequency")
    return math.nan if each.basis.bandwidth_Hz is None else each.basis.bandwidth_Hz


def _gain(channel: str, sensor: Sensor, signed: float) -> Contribution:
    name = f"gain of {_of(channel, sensor)}; {sensor.gain_text}"
    return _signed(name, signed, _error("gain", channel, sensor))


def _offset(channel: str, sensor: Sensor, signed: float) -> Contribution:
    name = f"offset of {_of(channel, sensor)}; {sensor.offset_text}"
    return _signed(name, signed, _error("offset", channel, sensor))


def _signed(name: str, signed: float, error: InstrumentError) -> Contribution:
    return Contribution(name, "B", abs(signed), instrument=error, sign=-1 if signed < 0.0 else 1)


def _of(channel: str, instrument: Instrument) -> str:
    return f"{channel} ({instrument.label})" if instrument.label else channel


def _error(effect: str, channel: str, of: Instrument) -> InstrumentError:
    return InstrumentError(effect, channel, of.sensor, of.serial_number, of.certificate)
