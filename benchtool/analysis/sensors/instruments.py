"""The errors of sensors and clock in the uncertainty of measurements (JCGM 100:2008, 4.3).

They are added here only, after the analyses: as contributions of type B, each of which names the sensor and
its certificate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from benchtool.analysis.measurement import Measurement, Table
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.sensitivity import Component, Error, Level, Noise, Sensitivity
from benchtool.analysis.sensors.corrections import Effect, bandwidth_of, corrected
from benchtool.analysis.sensors.effects import before_the_sensors, moved_by_steps
from benchtool.analysis.sensors.lag import Lag, Response
from benchtool.analysis.sensors.largest_line import may_be_another
from benchtool.analysis.sensors.tables import with_sensors
from benchtool.analysis.sensors.waveform import Undone, Waveform, before_sensor, in_steps
from benchtool.analysis.uncertainty import Contribution, InstrumentError
from benchtool.block import Block
from benchtool.profile import Bench, Instrument, Sensor

UNSTATED: Final = "the sensors' own uncertainty is not stated"
"""Text of `Basis.sensors` for a number whose sensors the bench does not state."""

_OF_READING = "noise is that of the reading: the sensor attenuates what comes before it"
_FEWEST = 16  # samples that are a waveform
_SAME_STEP = 1e-6  # relative: what rounding of the readings leaves of a stated step that the data show
_GRIDS = 0.125, 0.375, 0.625, 0.875  # where the steps of a reading may begin
_BY_TIME: Final[Mapping[str, float]] = {"s": 1.0, "Hz": -1.0, "A/sqrt(Hz)": 0.5}
"""Degree in the length of a tick, by the unit of a measurement."""
_OF_CLOCK: Final = frozenset({"s", "Hz"})  # measured by a clock alone


@dataclass(frozen=True)
class Perturbed:
    """A channel with a perturbed sensor error: (1 + gain) x reading + offset.

    Or as it was before a sensor of the response `by`, as far as that is `undone`, or in steps of `step` whose
    grid begins at `phase`.
    """

    channel: str
    gain: float = 0.0
    offset: float = 0.0
    by: Response | None = None
    undone: Undone = Undone.SIGNAL
    step: float = 0.0
    phase: float = 0.0

    def of(self, block: Block) -> Block:
        """Return the block with that channel, or as it is if it has none."""
        if self.channel not in block.names:
            return block
        data = np.array(block.data)
        values = self.reading(block.column(self.channel))
        if self.by is not None:
            values = before_sensor(values, block.sample_rate_Hz, self.by, self.undone)
        data[:, block.names.index(self.channel)] = values
        return replace(block, data=data)

    def reading(
        self, values: np.ndarray[tuple[int], np.dtype[np.float64]]
    ) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return single readings with the error; a lag leaves what stands still."""
        moved = np.asarray((1.0 + self.gain) * values + self.offset)
        return in_steps(moved, self.step, self.phase) if self.step > 0.0 else moved


MeasureAgain = Callable[[Perturbed], Iterable[Measurement]]
"""Repeats, with a perturbed channel, the measurements whose sensitivity is not declared."""


@dataclass(frozen=True)
class Moved:
    """What sensors do to a measurement that was measured again.

    Of a bandwidth it is the effect, or why that is not known; `remarks` are on what else is not known.
    """

    lines: list[Contribution] = field(default_factory=list)
    effects: list[Effect | str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Instruments:
    """The sensors of one recording.

    Args:
        bench: what is stated of them.
        blocks: what was recorded with them, for the resolution that the data show.
        clock_of: whose clock times the samples.
    """

    bench: Bench
    blocks: Sequence[Block] = ()
    clock_of: str = "the drive"
    _waveforms: dict[str, Waveform | None] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    _steps: dict[str, float] = field(default_factory=dict, init=False, repr=False, compare=False)

    def applied(
        self, measurements: Sequence[Measurement], again: MeasureAgain | None = None
    ) -> tuple[Measurement, ...]:
        """Return the measurements with the errors of their sensors in uncertainty and basis.

        A measurement without an uncertainty stays without one, since the sensors are only part of it; the
        basis states that of the sensors alone, and `of_sensors` has it for the mean of repetitions.
        """
        moved = {} if again is None else self._moved(measurements, again)
        return tuple(self._applied(each, moved.get(each.name, Moved())) for each in measurements)

    def applied_to(self, tables: Iterable[Table]) -> tuple[Table, ...]:
        """Return tables with the errors of their sensors."""
        return tuple(with_sensors(each, lambda row: self._applied(row, Moved())) for each in tables)

    def _applied(self, each: Measurement, moved: Moved) -> Measurement:
        if not math.isfinite(each.value):
            return each
        if other := self._of_another(each):
            return Measurement.undefined(each.name, each.unit, each.definition, other, each.basis)
        each, unresolved = self._resolved(each)
        channels = each.sensitivities.channels
        effects = [*moved.effects, *([] if channels is None else [self._by_bandwidth(channels, each)])]
        unknown = [effect for effect in effects if isinstance(effect, str) and effect]
        known = [effect for effect in effects if isinstance(effect, Effect)] if not unknown else []
        by_data = each.uncertainty
        falls = not isinstance(each.sensitivities.content, Component)
        each, by_lags = corrected(each, known, proportional=each.sensitivities.is_declared, falls=falls)
        if unknown:
            each = each.without_uncertainty("; ".join(unknown))
        untold = [] if by_lags else [effect.bandwidth for effect in known]
        lines = [*moved.lines, *by_lags, *self._clock(each)]
        remarks = [self._unstated(each), self._unstated_clock(each), *moved.remarks]
        if channels is not None:
            lines += [line for part in channels for line in self._lines(part, each)]
            remarks.append(self._of_noise(channels, each))
        lines = [line for line in lines if line.standard != 0.0]
        if each.uncertainty is None and not (unknown or untold):
            remarks.append(_of_sensors_alone(lines, each.unit))
        elif each.uncertainty is None:
            remarks += unknown or ([each.uncertainty_reason] if by_data is not None else [])
        basis = replace(each.basis, sensors=tuple(filter(None, remarks)))
        each = replace(each, basis=basis)
        if not all(math.isfinite(line.standard) for line in lines):
            each = each.without_uncertainty("it is not found again with another error of its sensors")
        if each.uncertainty is None:
            lines += [Contribution(effect, "B", math.nan) for effect in (*unknown, *untold, *unresolved)]
            return replace(each, of_sensors=tuple(lines))
        return replace(each, uncertainty=each.uncertainty.with_instruments(lines))

    def _resolved(self, each: Measurement) -> tuple[Measurement, list[str]]:
        """Return a number whose channels' resolutions are stated where their samples do not show them, and
        those which are not."""
        if each.unresolved is None:
            return each, []
        sensors = {channel.name: self._sensor(channel.name) for channel in each.unresolved.channels}
        lacking = [channel for channel, of in sensors.items() if of is None or not of.resolution]
        return each if lacking else each.with_stated_resolutions(), [f"resolution of {c}" for c in lacking]

    def _of_another(self, each: Measurement) -> str:
        """Return why it is not known which line is the largest; empty where it is, or none was chosen."""
        if not each.sensitivities.of_largest:
            return ""
        for channel in each.sensitivities.named:
            sensor, waveform = self._sensor(channel), self._waveform(channel)
            lag = Lag.of(sensor)
            if sensor is None or lag is None or waveform is None:
                continue
            if other := may_be_another(each, lag, waveform):
                return f"{other} (bandwidth of {bandwidth_of(channel, sensor)})"
        return ""

    def _of_noise(self, channels: Sequence[Sensitivity], each: Measurement) -> str:
        """Return the remark on noise that a sensor has attenuated; empty where it does not apply."""
        lags = [Lag.of(self._sensor(part.channel)) for part in channels]
        return _OF_READING if isinstance(each.sensitivities.content, Noise) and any(lags) else ""

    def _sensor(self, channel: str) -> Sensor | None:
        return self.bench.channels.get(channel)

    def _unstated(self, each: Measurement) -> str:
        """Return the remark on a number some of whose sensors are not stated."""
        channels = each.sensitivities.named
        lacking = [name for name in channels if self._sensor(name) is None]
        if not lacking:
            return ""
        return (
            UNSTATED
            if len(lacking) == len(channels)
            else f"the uncertainty of {', '.join(lacking)} is not stated"
        )

    def _unstated_clock(self, each: Measurement) -> str:
        """Return the remark on a time or a frequency whose clock is not stated."""
        if self.bench.clock is not None or each.unit not in _OF_CLOCK:
            return ""
        return f"the tolerance of {self.clock_of}'s clock is not stated"

    def _lines(self, part: Sensitivity, each: Measurement) -> Iterator[Contribution]:
        """Yield the gain, offset and resolution of one channel, of a number that is corrected already."""
        channel, sensor = part.channel, self._sensor(part.channel)
        if sensor is None:
            return
        part = part.scaled(_corrected_by(each))
        if sensor.gain_standard > 0.0:
            yield _gain(channel, sensor, part.gain * sensor.gain_standard)
        if sensor.offset_standard > 0.0:
            yield _offset(channel, sensor, part.offset * sensor.offset_standard)
        moves = each.sensitivities.is_moved_by_steps(part)
        if sensor.resolution and moves and (rest := self._rest(channel, sensor)) > 0.0:
            moved = moved_by_steps(part, each, sensor.resolution, self._waveform(channel))
            yield self._of_resolution(channel, sensor, moved * rest / sensor.resolution)

    def _rest(self, channel: str, sensor: Sensor) -> float:
        """Return the stated step less that which the data show, in squares: the analyses count those."""
        step, seen = sensor.resolution or 0.0, self._resolution(channel)
        return math.sqrt(step**2 - seen**2) if seen < (1.0 - _SAME_STEP) * step else 0.0

    def _of_resolution(self, channel: str, sensor: Sensor, standard: float) -> Contribution:
        text = f"resolution of {sensor.resolution:g} {sensor.unit}"
        seen = " beyond that in the data" if self._resolution(channel) else ""
        return Contribution(f"{text}{seen} of {_of(channel, sensor)}", "B", standard)

    def _resolution(self, channel: str) -> float:
        """Return the step that the analyses found in a channel; 0 if none is coarse enough to be one."""
        if channel not in self._steps:
            columns = (block.column(channel) for block in self.blocks if channel in block.names)
            self._steps[channel] = next(map(counting_step, columns), 0.0)
        return self._steps[channel]

    def _waveform(self, channel: str) -> Waveform | None:
        """Return the even samples of a channel; None where there are none."""
        if channel not in self._waveforms:
            block = next((each for each in self.blocks if channel in each.names), None)
            even = block is not None and not block.gaps and len(block.data) >= _FEWEST
            self._waveforms[channel] = (
                Waveform(block.column(channel), block.sample_rate_Hz) if block is not None and even else None
            )
        return self._waveforms[channel]

    def _by_bandwidth(self, channels: Sequence[Sensitivity], each: Measurement) -> Effect | str:
        """Return what the bandwidth of its sensors has done to a number, or why that is not known; empty if
        there is nothing."""
        sensors = [self._sensor(part.channel) for part in channels]
        lags = [Lag.of(sensor) for sensor in sensors]
        stating = {
            part.channel: sensor
            for part, sensor, lag in zip(channels, sensors, lags, strict=True)
            if sensor is not None and lag is not None
        }
        if not stating or isinstance(each.sensitivities.content, Level | Noise):
            return ""
        waveforms = [self._waveform(part.channel) for part in channels]
        estimate = before_the_sensors(each, lags, waveforms)
        if estimate is None:
            what = "the frequency" if waveforms[0] is not None else "a record of even samples without gaps"
            return _not_known(what, stating)
        return Effect.of_sensors(stating, next(filter(None, lags)), estimate)

    def _clock(self, each: Measurement) -> Iterator[Contribution]:
        clock = self.bench.clock
        if clock is not None and (degree := _BY_TIME.get(each.unit, 0.0)):
            name = f"tolerance of {clock.tolerance_ppm:g} ppm of {self.clock_of}'s clock, rectangular"
            label = f": {clock.label}" if clock.label else ""
            error = _error("period", f"{self.clock_of}'s clock", clock)
            yield _signed(f"{name}{label}", degree * each.value * clock.relative_standard, error)

    def _moved(self, measurements: Sequence[Measurement], again: MeasureAgain) -> dict[str, Moved]:
        """Return what the sensors do to measurements without declared sensitivities, by name.

        Of gain and offset it is the change for one standard uncertainty either way, the larger of the two
        (JCGM 100:2008, 5.1.3, note 2); of a bandwidth what was before the sensor; of a resolution the rms
        change over places of its grid.
        """
        left = {
            each.name: each
            for each in measurements
            if not each.sensitivities.is_declared and math.isfinite(each.value)
        }
        found = {name: Moved() for name in left}
        for channel, sensor in self.bench.channels.items():
            own = {name: each for name, each in left.items() if each.sensitivities.again(channel)}
            if own:
                self._of_channel(channel, sensor, own, again, found)
        return found

    def _of_channel(
        self,
        channel: str,
        sensor: Sensor,
        found: Mapping[str, Measurement],
        again: MeasureAgain,
        moved: Mapping[str, Moved],
    ) -> None:
        """Add what one sensor does to measurements, by name."""

        def moved_by(error: Error) -> dict[str, Measurement]:
            return {name: each for name, each in found.items() if error in each.sensitivities.again(channel)}

        def measured(**error: Any) -> dict[str, Measurement]:
            return {each.name: each for each in again(Perturbed(channel, **error))}

        def read(**error: Any) -> dict[str, float]:
            return {name: each.value for name, each in measured(**error).items()}

        for error, u, line in (
            (Error.GAIN, sensor.gain_standard, _gain),
            (Error.OFFSET, sensor.offset_standard, _offset),
        ):
            if u > 0.0 and (own := moved_by(error)):
                up, down = (read(**{error: step}) for step in (u, -u))
                for name, each in own.items():
                    by = _larger(up.get(name, math.nan) - each.value, each.value - down.get(name, math.nan))
                    moved[name].lines.append(line(channel, sensor, by))
        if (lag := Lag.of(sensor)) is not None and (own := moved_by(Error.BANDWIDTH)):
            for undone in {_undone(each) for each in own.values()}:
                before = [measured(by=by, undone=undone) for by in lag.responses]
                if undone is Undone.SIGNAL:
                    before.append(measured(by=lag.responses[0], undone=Undone.LOWER))
                for name, each in own.items():
                    if _undone(each) is undone:
                        numbers = [of.get(name) for of in before]
                        moved[name].effects.append(_by_lag(each, numbers, channel, sensor, lag))
        own = moved_by(Error.RESOLUTION)
        if sensor.resolution and own and (rest := self._rest(channel, sensor)) > 0.0:
            grids = [read(step=sensor.resolution, phase=phase) for phase in _GRIDS]
            for name, each in own.items():
                changes = [grid.get(name, math.nan) - each.value for grid in grids]
                by = math.sqrt(sum(change**2 for change in changes) / len(changes))
                if math.isfinite(by):
                    by *= rest / sensor.resolution
                    moved[name].lines.append(self._of_resolution(channel, sensor, by))
                else:
                    text = f"what steps of {sensor.resolution:g} {sensor.unit} of {channel} do is not known"
                    moved[name].remarks.append(text)


def _by_lag(
    each: Measurement, before: Sequence[Measurement | None], channel: str, sensor: Sensor, lag: Lag
) -> Effect | str:
    """Return what a bandwidth has done to a number, by what it was before each response, or why that is not
    known. One more of what was before the first, with less of it taken back, tells what is not."""
    whole = [of for of in before if of is not None and math.isfinite(of.value)]
    if len(whole) < len(before):
        return _not_known("that number before it", {channel: sensor})
    first, *lower = whole[0], *whole[len(lag.responses) :]
    estimate = lag.estimate(each.value, [of.value for of in whole[: len(lag.responses)]])
    lost = math.hypot(*(of.value - first.value for of in lower))
    estimate = replace(estimate, standard=math.hypot(estimate.standard, lost))
    return Effect.of_sensors({channel: sensor}, lag, estimate, first.uncertainty)


def _undone(each: Measurement) -> Undone:
    return Undone.ALL if each.sensitivities.of_spectra else Undone.SIGNAL


def sensor_remarks(measurements: Iterable[Measurement]) -> dict[str, str]:
    """Return the remarks on sensors, each with the first of the measurements that it applies to and how many
    more there are, by what they say."""
    found: dict[str, dict[str, None]] = {}
    for each in measurements:
        for text in each.basis.sensors:
            found.setdefault(text, {})[each.name] = None
    return {
        text: f"{text} ({next(iter(names))}{f' and {len(names) - 1} more' if len(names) > 1 else ''})"
        for text, names in found.items()
    }


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


def _gain(channel: str, sensor: Sensor, signed: float) -> Contribution:
    name = f"gain of {_of(channel, sensor)}; {sensor.gain_text}"
    return _signed(name, signed, _error("gain", channel, sensor))


def _offset(channel: str, sensor: Sensor, signed: float) -> Contribution:
    name = f"offset of {_of(channel, sensor)}; {sensor.offset_text}"
    return _signed(name, signed, _error("offset", channel, sensor))


def _signed(name: str, signed: float, error: InstrumentError) -> Contribution:
    return Contribution(name, "B", abs(signed), instrument=error, sign=-1 if signed < 0.0 else 1)


def _corrected_by(each: Measurement) -> float:
    """Return the factor by which a number was corrected, and its derivatives with it; a symmetrical
    component is not proportional to what the sensor takes off."""
    if each.correction is None or each.as_read == 0.0:
        return 1.0
    return 1.0 if isinstance(each.sensitivities.content, Component) else each.value / each.as_read


def _not_known(without: str, sensors: Mapping[str, Sensor]) -> str:
    """Return why a loss is not known, without what it could be computed from."""
    of = ", ".join(bandwidth_of(channel, sensor) for channel, sensor in sensors.items())
    return f"how much the sensor's bandwidth takes off is not known without {without} (bandwidth of {of})"


def _of(channel: str, instrument: Instrument) -> str:
    return f"{channel} ({instrument.label})" if instrument.label else channel


def _error(effect: str, channel: str, of: Instrument) -> InstrumentError:
    return InstrumentError(effect, channel, of.sensor, of.serial_number, of.certificate)
