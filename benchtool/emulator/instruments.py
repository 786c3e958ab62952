"""Instruments of the emulated bench that speak CAN: each a party of its own on a bus, in the bench's time.

They send the messages of a DBC file as a real instrument does; the host sees only their frames.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress

import can

from benchtool.emulator.core.core import Core
from benchtool.emulator.machine.transducer import MAX_TICKS
from benchtool.errors import ProfileError
from benchtool.profile import CanTransducer
from benchtool.protocol import DbcMessage

_ROUNDING = 1e-6


class CanInstrument(ABC):
    """An instrument on a bus.

    Args:
        bus: open bus whose frames bear the time that they are given, owned from now on.
        message: what it sends.
    """

    def __init__(self, bus: can.BusABC, message: DbcMessage) -> None:
        self._bus = bus
        self._message = message

    def prepare(self, now_s: float) -> None:  # noqa: B027 # most have nothing to prepare
        """Prepare for time to pass, up to `now_s`."""

    def send_until(self, now_s: float) -> None:
        """Send what was due until `now_s`."""
        for at_s, values in self._due(now_s):
            frame = can.Message(
                timestamp=at_s,
                arbitration_id=self._message.can_id,
                is_extended_id=self._message.extended,
                is_fd=self._message.is_fd,
                data=self._message.encode(values),
            )
            with suppress(can.CanError):
                self._bus.send(frame)
        while self._bus.recv(0.0) is not None:  # ignore what others send
            pass

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()

    @abstractmethod
    def _due(self, now_s: float) -> Iterator[tuple[float, Mapping[str, float]]]:
        """Return the moment and physical values of each frame that is due."""


class CanReadings(CanInstrument):
    """An instrument that sends some quantities `rate_Hz` times a second; `values` returns the present
    ones."""

    def __init__(
        self, bus: can.BusABC, message: DbcMessage, rate_Hz: float, values: Callable[[], Mapping[str, float]]
    ) -> None:
        super().__init__(bus, message)
        self._rate_Hz = rate_Hz
        self._values = values
        self._sent = 0

    def _due(self, now_s: float) -> Iterator[tuple[float, Mapping[str, float]]]:
        due = math.floor(now_s * self._rate_Hz + _ROUNDING)
        while self._sent < due:
            self._sent += 1
            yield self._sent / self._rate_Hz, self._values()


def samples_apart(core: Core, sample_rate_Hz: float) -> int:
    """Return every how many samples that the machine's torque is known at a transducer of this rate takes
    one.

    Raises:
        ProfileError: that is no whole number.
    """
    apart = 1.0 / (sample_rate_Hz * core.transducer.tick_s)
    if round(apart) < 1 or not math.isclose(apart, round(apart), rel_tol=1e-9):
        raise ProfileError(
            f"bench.transducer samples at {sample_rate_Hz:g} Hz, the emulated bench knows the torque at "
            f"{1.0 / core.transducer.tick_s:g} Hz and whole parts of it: choose such a rate_Hz"
        )
    return round(apart)


class CanTorque(CanInstrument):
    """A torque transducer: what that of the bench reads, a frame for every so many samples.

    A frame is sent `delay_s` after its last sample was taken, with the samples oldest first.

    Args:
        bus: as `CanInstrument`.
        message: what it sends.
        stated: which signals, how often and how late, as the profile states it.
        factor: Nm in a unit of the signals.
        core: the machine.

    Raises:
        ProfileError: as `samples_apart`.
    """

    def __init__(
        self, bus: can.BusABC, message: DbcMessage, stated: CanTransducer, factor: float, core: Core
    ) -> None:
        super().__init__(bus, message)
        self._stated = stated
        self._factor = factor
        self._count = 0
        self._waiting: deque[tuple[float, dict[str, float]]] = deque()
        self._samples: list[float] = []
        self._core = core
        self._every = samples_apart(core, stated.sample_rate_Hz)

    def prepare(self, now_s: float) -> None:
        """See `CanInstrument.prepare`."""
        ticks = self._core.first_tick + math.ceil(now_s / self._core.control_period_s) - self._core.tick
        self._core.transducer.start(min(max(1, ticks + 1), MAX_TICKS))

    def _due(self, now_s: float) -> Iterator[tuple[float, Mapping[str, float]]]:
        block = self._core.transducer.block()
        for row in range(-block.first_tick % self._every, len(block.data), self._every):
            self._take(block.first_tick + row, float(block.data[row, 0]))
        while self._waiting and self._waiting[0][0] <= now_s + _ROUNDING * self._core.control_period_s:
            yield self._waiting.popleft()

    def _take(self, sample: int, torque_Nm: float) -> None:
        """Take a sample, whose number counts from the drive's tick 0."""
        names = self._stated.signals
        if not self._samples and sample // self._every % len(names):
            return  # a frame begins with the first of its samples
        self._samples.append(torque_Nm / self._factor)
        if len(self._samples) < len(names):
            return
        values = dict(zip(names, self._samples, strict=True))
        if self._stated.counter:
            values[self._stated.counter] = self._count
            highest = self._message.ranges[self._stated.counter].maximum
            self._count = 0 if self._count >= highest else self._count + 1
        taken_s = (sample / self._core.transducer.samples_per_tick - self._core.first_tick) * (
            self._core.control_period_s
        )
        self._waiting.append((taken_s + self._stated.delay_s, values))
        self._samples = []
