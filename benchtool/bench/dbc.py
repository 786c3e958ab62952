"""Instruments that speak CAN, described by a DBC file: torque transducer, power analyser, thermometer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from benchtool.bench.can_frames import MessageListener
from benchtool.bench.equipment import Temperatures
from benchtool.block import Block, Channel
from benchtool.errors import EnvironmentFailure, NoAnswer, ProfileError, ValueRefused
from benchtool.profile import CanSupply, CanTemperature, CanTransducer
from benchtool.protocol import DbcMessage, SignalRange
from benchtool.tables import unit_factor, units_of
from benchtool.telemetry import Alignment, ClockFit, Sampling, align, frame_numbers

_CHANNEL: Final = Channel("torque_transducer", "Nm")
_CELSIUS: Final = ("degC", "°C", "C", "deg C", "")
_PERIODS: Final = 2.0

Listen = Callable[[DbcMessage, float], MessageListener]
"""Subscribes to a message that comes at a rate in Hz."""


def factor_of(signal: SignalRange, unit: str) -> float:
    """Return how many of the SI unit `unit` one of a signal's own unit is; a signal without a unit is in
    `unit`.

    Raises:
        ProfileError: its unit is of another kind.
    """
    if not signal.unit:
        return 1.0
    factor = unit_factor(signal.unit, unit)
    if factor is None:
        raise ProfileError(
            f"signal '{signal.name}' is in '{signal.unit}' by its DBC file, {units_of(unit)} can be read: "
            f"choose the signal of that quantity, or correct its unit in the file"
        )
    return factor


class DbcTransducer:
    """A torque transducer whose frames are described by a DBC file; a `Transducer`.

    Samples that did not come, or that were damaged or out of range, are gaps of the block.

    Args:
        stated: as the profile has it.
        message: with the signals that are read.
        listen: begins to listen.

    Raises:
        ProfileError: its signals are not a torque.
    """

    def __init__(self, stated: CanTransducer, message: DbcMessage, listen: Listen) -> None:
        self._stated = stated
        self._ranges = [message.ranges[name] for name in stated.signals]
        self._factors = np.array([factor_of(each, "Nm") for each in self._ranges])
        counter = message.ranges[stated.counter] if stated.counter else None
        self._wrap = 0 if counter is None else _wrap_of(counter)
        self._listener = listen(message, stated.rate_Hz)
        self._alignment: Alignment | None = None
        self._repeated = 0

    @property
    def longest_s(self) -> float:
        """See `Transducer.longest_s`."""
        return self._listener.longest_s

    @property
    def late_s(self) -> float:
        """See `Transducer.late_s`: two frames, and the delay."""
        return _PERIODS / self._stated.rate_Hz + self._stated.delay_s + self._stated.delay_limit_s

    def require_alive(self) -> None:
        """See `Transducer.require_alive`."""
        self._listener.require_alive()

    def start(self, duration_s: float) -> None:
        """See `Transducer.start`; it goes on until `block`, and begins a tenth of a second before now."""
        self._alignment = None
        self._listener.start()

    def block(self, clock: ClockFit | None = None) -> Block:
        """See `Transducer.block`."""
        kept = self._listener.stop()
        self._listener.require_still_alive()
        if clock is None:
            raise EnvironmentFailure(
                f"'{self._stated.message}' cannot be aligned with the drive: three records at least with the "
                f"drive's tick are needed; use a drive that streams, or leave the transducer out"
            )
        if not kept:
            raise NoAnswer(
                f"no valid frame of '{self._stated.message}' came while it was recorded "
                f"({self._listener.counters.dropped} damaged or out of range so far): check the instrument"
            )
        arrivals_s = np.array([each.arrival_s for each in kept])
        values = np.array([[each.values[name] for name in self._stated.signals] for each in kept])
        counts = np.array([each.values[self._stated.counter] for each in kept]) if self._wrap else None
        numbers = frame_numbers(
            arrivals_s,
            self._stated.rate_Hz,
            None if counts is None else np.rint(counts).astype(np.int64),
            self._wrap,
        )
        first = np.concatenate(([True], np.diff(numbers) > 0))  # of frames that came twice
        self._repeated = int(len(first) - first.sum())
        arrivals_s, values, numbers = arrivals_s[first], values[first], numbers[first]
        sampling = Sampling(
            self._stated.rate_Hz, len(self._stated.signals), self._stated.delay_s, self._stated.delay_limit_s
        )
        block, self._alignment = align(_CHANNEL, arrivals_s, values * self._factors, numbers, sampling, clock)
        return block

    def facts(self) -> dict[str, Any]:
        """See `Transducer.facts`."""
        return {
            "message": self._stated.message,
            "dbc": self._stated.dbc,
            "bus": self._stated.bus,
            "sample_rate_Hz": self._stated.sample_rate_Hz,
            "resolution_Nm": max(
                float(factor * each.resolution)
                for factor, each in zip(self._factors, self._ranges, strict=True)
            ),
            "frames": {**asdict(self._listener.counters), "repeated": self._repeated},
            "alignment": None if self._alignment is None else asdict(self._alignment),
        }


def _wrap_of(counter: SignalRange) -> int:
    """Return how many values a counter has, by the range of its signal.

    Raises:
        ProfileError: the DBC file states no range.
    """
    if not (counter.minimum == 0.0 and 1.0 <= counter.maximum < 2.0**53 and counter.resolution == 1.0):
        raise ProfileError(
            f"counter '{counter.name}' counts from {counter.minimum:g} to {counter.maximum:g} in steps of "
            f"{counter.resolution:g} by its DBC file, from 0 in steps of 1 is expected: state its range "
            f"there, or leave 'counter' out"
        )
    return int(counter.maximum) + 1


class DbcSupply:
    """A power analyser that measures voltage and current of the dc link; a `Supply` that only measures."""

    def __init__(self, stated: CanSupply, message: DbcMessage, listen: Listen) -> None:
        self._stated = stated
        self._factor_V = factor_of(message.ranges[stated.u_dc], "V")
        self._factor_A = factor_of(message.ranges[stated.i_dc], "A") if stated.i_dc else 1.0
        self._listener = listen(message, stated.rate_Hz)

    @property
    def u_dc_V(self) -> float:
        """See `Supply.u_dc_V`."""
        return self._factor_V * self._listener.latest()[self._stated.u_dc]

    @property
    def i_dc_A(self) -> float | None:
        """See `Supply.i_dc_A`."""
        if not self._stated.i_dc:
            return None
        return self._factor_A * self._listener.latest()[self._stated.i_dc]

    def set_voltage(self, u_dc_V: float) -> None:
        """See `Supply.set_voltage`."""
        raise ValueRefused(
            f"{u_dc_V:g} V asked of the dc supply, which is only measured here: set it by hand; nothing was "
            f"sent"
        )


class DbcThermometer:
    """A thermometer whose frames are described by a DBC file; a `Thermometer`."""

    def __init__(self, stated: CanTemperature, message: DbcMessage, listen: Listen) -> None:
        self._stated = stated
        for each in message.ranges.values():
            if each.unit not in _CELSIUS:
                raise ProfileError(
                    f"signal '{each.name}' is in '{each.unit}' by its DBC file, degC is expected: choose "
                    f"another signal, or correct its unit in the file"
                )
        self._listener = listen(message, stated.rate_Hz)

    def temperatures(self) -> Temperatures:
        """See `Thermometer.temperatures`."""
        latest = self._listener.latest()
        return Temperatures(latest.get(self._stated.winding), latest.get(self._stated.ambient))
